//! Files that a case names: refusals at the key that names them, with file and line; and the keys
//! beside it.

use crate::config::fault::{Check, Fault, positive};
use std::path::Path;

/// A file, and the key that names it.
pub(super) struct Source<'a> {
    pub path: &'a Path,
    pub key: &'a str,
}

impl Source<'_> {
    fn refuse_at(&self, place: &str, what: &str) -> Fault {
        Fault { key: self.key.to_owned(), message: format!("{place}: {what}") }
    }

    /// The refusal of the file.
    pub fn refuse(&self, what: &str) -> Fault {
        self.refuse_at(&self.path.display().to_string(), what)
    }

    /// The refusal of a line.
    pub fn refuse_line(&self, line: u64, what: &str) -> Fault {
        self.refuse_at(&format!("{}:{line}", self.path.display()), what)
    }

    /// The refusal of a file that is no table.
    pub fn malformed(&self, e: &csv::Error) -> Fault {
        let line = e.position().map_or(1, |position| position.line());
        let what = match e.kind() {
            csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                format!("has {len} columns, and the header {expected_len}")
            }
            _ => e.to_string(),
        };
        self.refuse_line(line, &what)
    }

    /// Refuses a file that is not there, and a directory.
    pub fn exists(&self) -> Check {
        match self.path {
            path if path.is_dir() => Err(self.refuse("is a directory: name a file in it")),
            path if path.exists() => Ok(()),
            _ => {
                let why = "there is no such file; its path goes from the case file's folder";
                Err(self.refuse(why))
            }
        }
    }

    /// The text of the file.
    pub fn text(&self) -> Result<String, Fault> {
        self.exists()?;
        let text = std::fs::read_to_string(self.path)
            .map_err(|e| self.refuse(&format!("cannot be read: {e}")))?;
        // Where a line ends with two characters, the second would count as another line's.
        Ok(text.replace("\r\n", "\n"))
    }

    /// The names of the columns of a table.
    pub fn header(&self) -> Result<csv::StringRecord, Fault> {
        let text = self.text()?;
        reader(&text).headers().cloned().map_err(|e| self.malformed(&e))
    }

    /// The rows of numbers below a header that names exactly these columns, in their order, each
    /// with its line; `what` names them in a refusal.
    pub fn rows(&self, columns: &[&str], what: &str) -> Result<Vec<(u64, Vec<f64>)>, Fault> {
        let text = self.text()?;
        let mut reader = reader(&text);
        let header = reader.headers().map_err(|e| self.malformed(&e))?.clone();
        let header_line = header.position().map_or(1, |position| position.line());
        let known = || columns.join(", ");
        let place = |name: &&str| header.iter().position(|column| column == *name);
        let places: Option<Vec<usize>> = columns.iter().map(place).collect();
        let places = places.filter(|_| header.len() == columns.len()).ok_or_else(|| {
            let found = header.iter().collect::<Vec<_>>().join(",");
            let needs = format!("the header must be {}", columns.join(","));
            self.refuse_line(header_line, &format!("{needs}, not \"{found}\""))
        })?;
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|e| self.malformed(&e))?;
            let line = record.position().map_or(0, |position| position.line());
            let number = |(place, name): (&usize, &&str)| {
                let text = record.get(*place).unwrap_or_default();
                let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
                let what = || format!("column `{name}` must be a finite number, not \"{text}\"");
                number.ok_or_else(|| self.refuse_line(line, &what()))
            };
            rows.push((line, places.iter().zip(columns).map(number).collect::<Result<_, _>>()?));
        }
        if rows.is_empty() {
            return Err(
                self.refuse(&format!("lists no {what}: one a line, below the header {}", known()))
            );
        }
        Ok(rows)
    }
}

/// A reader of a table with comments.
pub(super) fn reader(text: &str) -> csv::Reader<&[u8]> {
    csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes())
}

/// The name of a file, which is not empty.
pub(super) fn named<'a>(file: &'a str, key: &str) -> Result<&'a str, Fault> {
    ensure!(!file.is_empty(), format!("{key}.file"), "is empty: name a file beside the case file");
    Ok(file)
}

/// Checks that exactly one of these keys is given.
pub(super) fn one_of(key: &str, keys: &[(&str, bool)]) -> Check {
    let given = keys.iter().filter(|(_, given)| *given).count();
    let names: Vec<&str> = keys.iter().map(|(name, _)| *name).collect();
    let names = names.join(" and ");
    ensure!(given != 0, key, "needs exactly one of {names}");
    ensure!(given == 1, key, "{names} exclude each other: remove one of them");
    Ok(())
}

/// Factor on the lengths of a file.
pub(super) fn factor(key: &str, scale: Option<f64>, of_file: bool) -> Result<f64, Fault> {
    let key = format!("{key}.scale");
    positive(&key, scale, "a factor, such as 0.001 for mm")?;
    ensure!(of_file || scale.is_none(), key, "is for a file: give the lengths in m");
    Ok(scale.unwrap_or(1.0))
}
