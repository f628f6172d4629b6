//! A CSV file beside a study: values that its runs are compared with, points of others in its
//! figures.

use mics_run::config::suggest;
use mics_run::{Error, Result};
use std::fs;
use std::path::{Path, PathBuf};

/// A CSV file of reference data.
pub struct Sheet {
    path: PathBuf,
    heads: Vec<String>,
    rows: Vec<csv::StringRecord>,
}

/// Makes the refusal of a key of a reference, with a message.
pub type Refuse<'a> = &'a dyn Fn(&str, String) -> Error;

impl Sheet {
    /// Reads it; `refuse` says what is wrong with the file.
    pub fn read(path: &Path, refuse: Refuse) -> Result<Sheet> {
        let content = fs::read_to_string(path).map_err(|e| {
            refuse(".file", format!("{}: {e}; its path is from this file's folder", path.display()))
        })?;
        let mut reader =
            csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(content.as_bytes());
        let bad = |e: csv::Error| refuse(".file", format!("{}: {e}", path.display()));
        let heads = reader.headers().map_err(bad)?.iter().map(str::to_owned).collect();
        let rows = reader.records().collect::<Result<Vec<_>, _>>().map_err(bad)?;
        Ok(Sheet { path: path.to_owned(), heads, rows })
    }

    /// The number of a column.
    pub fn position(&self, name: &str, key: &str, refuse: Refuse) -> Result<usize> {
        let known: Vec<&str> = self.heads.iter().map(String::as_str).collect();
        let message =
            || format!("{} has no column `{name}`; {}", self.path.display(), suggest(name, &known));
        self.heads.iter().position(|head| head == name).ok_or_else(|| refuse(key, message()))
    }

    /// The number in column `at` of the one row that has what is `wanted` in other columns; where
    /// it `may_lack`, `None` of no such row or an empty cell.
    pub fn value(
        &self,
        at: usize,
        wanted: &[(usize, String)],
        may_lack: bool,
        refuse: Refuse,
    ) -> Result<Option<f64>> {
        let is = |cell: &str, wanted: &str| {
            let number: Option<f64> = wanted.parse().ok();
            cell == wanted || (number.is_some() && cell.parse().ok() == number)
        };
        let has = |row: &&csv::StringRecord| {
            wanted.iter().all(|(k, w)| row.get(*k).is_some_and(|cell| is(cell, w)))
        };
        let rows: Vec<_> = self.rows.iter().filter(has).collect();
        let cell = match &rows[..] {
            [] if may_lack => return Ok(None),
            [row] => row.get(at).unwrap_or_default(),
            rows => {
                let message = format!(
                    "{} rows of {} are meant, not one; say which, as in row = {{ {} = ... }}",
                    rows.len(),
                    self.path.display(),
                    self.heads.first().map_or("", String::as_str)
                );
                return Err(refuse(".row", message));
            }
        };
        if cell.is_empty() && may_lack {
            return Ok(None);
        }
        let number = cell.parse().map(Some);
        number.map_err(|_| {
            refuse(".column", format!("{}: {cell:?} is not a number", self.path.display()))
        })
    }

    /// The cells of two columns as numbers, in the rows whose column `label` is not empty, with
    /// that label.
    pub fn points(&self, label: usize, [x, y]: [usize; 2]) -> Vec<(String, (f64, f64))> {
        let point = |row: &csv::StringRecord| {
            let number = |at: usize| row.get(at)?.parse::<f64>().ok();
            Some((
                row.get(label).filter(|text| !text.is_empty())?.to_owned(),
                (number(x)?, number(y)?),
            ))
        };
        self.rows.iter().filter_map(point).collect()
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
        let refuse = |key: &str, message: String| Error::Usage(format!("{key}: {message}"));
        let sheet = Sheet::read(file.path(), &refuse).unwrap();
        let cd = sheet.position("cd", ".column", &refuse).unwrap();
        let value = |wanted: &[(usize, &str)], may_lack| {
            let wanted: Vec<_> = wanted.iter().map(|(k, text)| (*k, text.to_string())).collect();
            sheet.value(cd, &wanted, may_lack, &refuse).map_err(|e| e.to_string())
        };
        assert_eq!(value(&[(0, "10")], false), Ok(Some(3.5)));
        assert_eq!(value(&[(0, "100"), (1, "east")], true), Ok(Some(1.5)));
        // A row that is not there, and a cell that is empty, are no reference of one run among
        // several.
        assert_eq!(
            (value(&[(0, "70")], true), value(&[(0, "100"), (1, "west")], true)),
            (Ok(None), Ok(None))
        );
        assert!(value(&[(0, "70")], false).unwrap_err().starts_with(".row: 0 rows"));
        assert!(value(&[(0, "100"), (1, "west")], false).unwrap_err().starts_with(".column"));
        assert!(
            value(&[(0, "100")], true).unwrap_err().starts_with(".row: 2 rows"),
            "which one is not said"
        );
        let unknown = sheet.position("rey", ".row_of.rey", &refuse).unwrap_err().to_string();
        assert!(
            unknown.starts_with(".row_of.rey: ") && unknown.contains("no column `rey`"),
            "{unknown}"
        );
    }
}
