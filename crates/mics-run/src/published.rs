//! Published values that figures and `mics validate` compare with.

/// Section 3's reference: drag and Strouhal number of a cylinder over its Reynolds number.
const CYLINDER: &str = include_str!("../../../cases/cylinder-wake/cylinder_s3.csv");

/// (Re, value) of a column of section 3's reference (`cylinder_s3.csv`), where it has one.
pub fn cylinder_reference(column: &str) -> Vec<(f64, f64)> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(CYLINDER.as_bytes());
    let at = reader.headers().ok().and_then(|h| h.iter().position(|n| n == column));
    let point = |r: csv::StringRecord| Some((r.get(0)?.parse().ok()?, r.get(at?)?.parse().ok()?));
    reader.records().flatten().filter_map(point).collect()
}
