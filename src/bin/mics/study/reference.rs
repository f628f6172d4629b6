//! References of measures: a value, a number in a CSV file, or what another run of the study gives.

use super::file::{Label, Place, Reference, Study, fault};
use super::planned::Planned;
use mics_run::Result;
use mics_run::config::{Fault, Text, suggest};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// References of a measure, run by run.
pub enum Compared {
    /// They are known before any run.
    Values(Vec<Option<f64>>),
    /// The number of the run that gives each.
    Runs(Vec<Option<usize>>),
}

/// The references of a study, read from their files or found among its runs.
///
/// # Errors
/// When a file has no such place, or no run of the study has the labels of a reference's.
pub fn references(
    study: &Study,
    text: &Text,
    folder: &Path,
    names: &[String],
    runs: &[Planned],
) -> Result<BTreeMap<String, Compared>> {
    let compared = |(measure, reference): (&String, &Reference)| {
        let compared = match reference {
            Reference::Value(value) => Ok(Compared::Values(vec![Some(*value); runs.len()])),
            Reference::Place(place) if place.run.is_empty() => {
                in_file(place, folder, names, runs).map(Compared::Values)
            }
            Reference::Place(Place { file: None, column: None, run, .. }) => {
                of_runs(run, names, runs).map(Compared::Runs)
            }
            Reference::Place(_) => Err(fault("run", "stands beside a place in a file; drop one")),
        };
        let refuse = |Fault { key, message }| {
            text.refuse(fault(format!("reference.{measure}.{key}"), message))
        };
        Ok((measure.clone(), compared.map_err(refuse)?))
    };
    study.reference.iter().map(compared).collect()
}

/// The runs that differ from each in the `wanted` labels and in nothing else.
fn of_runs(
    wanted: &BTreeMap<String, Label>,
    names: &[String],
    runs: &[Planned],
) -> Result<Vec<Option<usize>>, Fault> {
    let other = |run: &Planned| {
        let label = |(name, own): (&String, &String)| {
            wanted.get(name).map_or_else(|| own.clone(), |label| label.0.clone())
        };
        let labels: Vec<String> = names.iter().zip(&run.labels).map(label).collect();
        runs.iter().position(|other| other.labels == labels && other.id != run.id)
    };
    let found: Vec<_> = runs.iter().map(other).collect();
    if found.iter().any(Option::is_some) {
        return Ok(found);
    }
    let labels: Vec<String> =
        wanted.iter().map(|(name, label)| format!("{name}={}", label.0)).collect();
    let message = format!(
        "no run has the labels of another one but {}; a row's labels must be those of the runs \
        that are compared with it, and [quick] must keep it",
        labels.join(", ")
    );
    Err(fault("run", message))
}

/// The values in the rows of a file that are meant.
fn in_file(
    place: &Place,
    folder: &Path,
    names: &[String],
    runs: &[Planned],
) -> Result<Vec<Option<f64>>, Fault> {
    let (Some(file), Some(column)) = (&place.file, &place.column) else {
        let message = "wanted with `column` (and `row`, as in row = { re = 100 }), or `run` (as in \
            run = { solver = \"tight\" })";
        return Err(fault("file", message));
    };
    let sheet = Sheet::read(&folder.join(file))?;
    let at = sheet.position(column, "column")?;
    let mut cells = Vec::new();
    for (column, Label(wanted)) in &place.row {
        let at = sheet.position(column, &format!("row.{column}"))?;
        cells.push((at, names.iter().position(|name| name == wanted), wanted));
    }
    // A run whose label the file does not have is compared with nothing.
    let may_lack = cells.iter().any(|(_, of_run, _)| of_run.is_some());
    let value = |run: &Planned| {
        let wanted = cells.iter().map(|(at, of_run, fixed)| match of_run {
            Some(label) => (*at, run.labels[*label].as_str()),
            None => (*at, fixed.as_str()),
        });
        sheet.value(at, &wanted.collect::<Vec<_>>(), may_lack)
    };
    runs.iter().map(value).collect()
}

/// A CSV file of reference data.
struct Sheet {
    path: PathBuf,
    heads: Vec<String>,
    rows: Vec<csv::StringRecord>,
}

impl Sheet {
    fn read(path: &Path) -> Result<Sheet, Fault> {
        let file = path.display();
        let bad = |e: csv::Error| fault("file", format!("{file}: {e}"));
        let content = fs::read_to_string(path).map_err(|e| {
            fault("file", format!("{file}: {e}; its path is from this file's folder"))
        })?;
        let mut reader =
            csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(content.as_bytes());
        let heads = reader.headers().map_err(bad)?.iter().map(str::to_owned).collect();
        let rows = reader.records().collect::<Result<_, _>>().map_err(bad)?;
        Ok(Sheet { path: path.to_owned(), heads, rows })
    }

    /// The number of a column that a key of the reference names.
    fn position(&self, name: &str, key: &str) -> Result<usize, Fault> {
        let known: Vec<&str> = self.heads.iter().map(String::as_str).collect();
        self.heads.iter().position(|head| head == name).ok_or_else(|| {
            let file = self.path.display();
            fault(key, format!("{file} has no column `{name}`; {}", suggest(name, &known)))
        })
    }

    /// The number in column `at` of the one row that has what is `wanted` in other columns; where
    /// it `may_lack`, `None` of no such row or an empty cell.
    fn value(
        &self,
        at: usize,
        wanted: &[(usize, &str)],
        may_lack: bool,
    ) -> Result<Option<f64>, Fault> {
        let is = |cell: &str, wanted: &str| {
            let number: Option<f64> = wanted.parse().ok();
            cell == wanted || (number.is_some() && cell.parse().ok() == number)
        };
        let has = |row: &&csv::StringRecord| {
            wanted.iter().all(|(k, w)| row.get(*k).is_some_and(|cell| is(cell, w)))
        };
        let rows: Vec<_> = self.rows.iter().filter(has).collect();
        let file = self.path.display();
        let cell = match &rows[..] {
            [] if may_lack => return Ok(None),
            [row] => row.get(at).unwrap_or_default(),
            rows => {
                let count = rows.len();
                let first = self.heads.first().map_or("", String::as_str);
                let message = format!(
                    "{count} rows of {file} are meant, not one; say which, as in \
                    row = {{ {first} = ... }}"
                );
                return Err(fault("row", message));
            }
        };
        match cell.parse() {
            Ok(number) => Ok(Some(number)),
            Err(_) if cell.is_empty() && may_lack => Ok(None),
            Err(_) => Err(fault("column", format!("{file}: {cell:?} is not a number"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn study_reference_row_matched_by_value() {
        let file = tempfile::NamedTempFile::new().unwrap();
        fs::write(file.path(), "# Cd\nre,place,cd\n10.0,west,3.5\n1e2,east,1.5\n1e2,west,\n")
            .unwrap();
        let sheet = Sheet::read(file.path()).unwrap();
        let cd = sheet.position("cd", "column").unwrap();
        let value = |wanted: &[(usize, &str)], may_lack| {
            sheet.value(cd, wanted, may_lack).map_err(|fault| fault.key)
        };
        assert_eq!(value(&[(0, "10")], false), Ok(Some(3.5)));
        assert_eq!(value(&[(0, "100"), (1, "east")], true), Ok(Some(1.5)));
        // A row that is not there, and a cell that is empty, are no reference of one run among
        // several.
        assert_eq!(value(&[(0, "70")], true), Ok(None));
        assert_eq!(value(&[(0, "100"), (1, "west")], true), Ok(None));
        assert_eq!(value(&[(0, "70")], false), Err("row".into()));
        assert_eq!(value(&[(0, "100"), (1, "west")], false), Err("column".into()));
        assert_eq!(value(&[(0, "100")], true), Err("row".into()), "which one is not said");
        assert_eq!(sheet.position("rey", "row.rey").unwrap_err().key, "row.rey");
    }
}
