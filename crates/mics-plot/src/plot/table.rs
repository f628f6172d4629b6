//! Tables of a run (CSV files), row by row or as columns of numbers: they may be far larger than
//! memory, and may still be growing.
//!
//! ```text
//!   time,id,x,...,fluid_fx,...        wanted: id, time, fluid_fx
//!   0.1,0,0.5,...,3.0,...        ->   [0.0, 0.1, 3.0]
//!   0.1,1,0.                          a line that is not whole yet is left out
//! ```

use mics_run::folder::old_name;
use mics_run::{Error, Result, not_a_run};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Take};
use std::path::{Path, PathBuf};

/// The whole lines of a file, which may still be growing.
fn whole_lines(mut file: File) -> io::Result<Take<File>> {
    let mut whole = file.metadata()?.len();
    let mut block = [0u8; 4096];
    // Backwards to the end of the last whole line.
    while whole > 0 {
        let from = whole.saturating_sub(block.len() as u64);
        let part = &mut block[..(whole - from) as usize];
        file.seek(SeekFrom::Start(from))?;
        file.read_exact(part)?;
        match part.iter().rposition(|byte| *byte == b'\n') {
            Some(at) => {
                whole = from + at as u64 + 1;
                break;
            }
            None => whole = from,
        }
    }
    file.rewind()?;
    Ok(file.take(whole))
}

/// The rows of a table of a run, of which some columns are wanted.
pub struct Rows {
    reader: csv::Reader<Take<File>>,
    head: csv::StringRecord,
    record: csv::StringRecord,
    /// The places of the wanted columns.
    wanted: Vec<usize>,
    /// Their values in the row.
    values: Vec<f64>,
    /// The run's folder and the file in it, for messages.
    run: PathBuf,
    file: String,
}

impl Rows {
    /// Opens a file of a run; none where there is no such file.
    ///
    /// # Errors
    /// When it lacks a column that is wanted, or cannot be read.
    pub fn open(run: &Path, file: &str, wanted: &[&str]) -> Result<Option<Rows>> {
        let path = run.join(file);
        let Ok(open) = File::open(&path) else { return Ok(None) };
        let lines = whole_lines(open).map_err(Error::io(&path))?;
        let mut reader = csv::Reader::from_reader(lines);
        let strange = |e: csv::Error| not_a_run(run, &format!("{file}: {e}"));
        let head = reader.headers().map_err(strange)?.clone();
        let place = |name: &&str| {
            let at = |name: &str| head.iter().position(|other| other == name);
            let lacks = || not_a_run(run, &format!("{file} lacks {name}"));
            at(name).or_else(|| at(&old_name(name)?)).ok_or_else(lacks)
        };
        let wanted = wanted.iter().map(place).collect::<Result<Vec<_>>>()?;
        let values = vec![f64::NAN; wanted.len()];
        let record = csv::StringRecord::new();
        let run = run.to_owned();
        Ok(Some(Rows { reader, head, record, wanted, values, run, file: file.to_owned() }))
    }

    /// The names of all columns.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.head.iter()
    }

    /// The wanted values of the next row, not a number where there is none; none at the end.
    ///
    /// # Errors
    /// When the row cannot be read.
    pub fn advance(&mut self) -> Result<Option<&[f64]>> {
        let more = self.reader.read_record(&mut self.record);
        if !more.map_err(|e| not_a_run(&self.run, &format!("{}: {e}", self.file)))? {
            return Ok(None);
        }
        for (value, at) in self.values.iter_mut().zip(&self.wanted) {
            *value = self.record.get(*at).and_then(|text| text.parse().ok()).unwrap_or(f64::NAN);
        }
        Ok(Some(&self.values))
    }

    /// The text of the row in a wanted column.
    pub fn text(&self, wanted: usize) -> &str {
        self.wanted.get(wanted).and_then(|at| self.record.get(*at)).unwrap_or_default()
    }
}

/// Columns of numbers by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

impl Table {
    /// A table of these columns without rows.
    pub fn new(names: &[&str]) -> Table {
        let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
        Table { columns: vec![Vec::new(); names.len()], names }
    }

    /// Reads columns of a file of a run; none where there is no such file.
    ///
    /// # Errors
    /// As [`Rows::open`] and [`Rows::advance`].
    pub fn read(run: &Path, file: &str, wanted: &[&str]) -> Result<Option<Table>> {
        let Some(mut rows) = Rows::open(run, file, wanted)? else { return Ok(None) };
        let mut table = Table::new(wanted);
        while let Some(row) = rows.advance()? {
            table.push(row);
        }
        Ok(Some(table))
    }

    /// Appends a row.
    pub fn push(&mut self, row: &[f64]) {
        self.columns.iter_mut().zip(row).for_each(|(column, value)| column.push(*value));
    }

    /// The table with one more column, of a length of its own.
    pub fn with(mut self, name: &str, column: Vec<f64>) -> Table {
        self.names.push(name.to_owned());
        self.columns.push(column);
        self
    }

    /// A column; empty where there is none of that name.
    pub fn column(&self, name: &str) -> &[f64] {
        let at = self.names.iter().position(|other| other == name);
        at.map_or(&[], |at| &self.columns[at])
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.columns.first().is_none_or(Vec::is_empty)
    }

    /// The names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Keeps the rows that a function of their first value says.
    pub fn retain(&mut self, keep: impl Fn(f64) -> bool) {
        let Some(first) = self.columns.first().cloned() else { return };
        for column in &mut self.columns {
            let mut row = first.iter();
            column.retain(|_| row.next().is_some_and(|first| keep(*first)));
        }
    }

    /// A table whose columns are those of this one through a function.
    pub fn map(&self, of: impl Fn(&[f64]) -> Vec<f64>) -> Table {
        let columns = self.columns.iter().map(|column| of(column)).collect();
        Table { names: self.names.clone(), columns }
    }
}

/// The value that a part of some sorted values lies below, linear between two of them.
pub fn quantile(sorted: &[f64], part: f64) -> f64 {
    let place = part * sorted.len().saturating_sub(1) as f64;
    let low = place.floor() as usize;
    let rest = place.fract();
    match (sorted.get(low), sorted.get(low + 1)) {
        (Some(a), Some(b)) => a + rest * (b - a),
        (Some(a), None) => *a,
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_end_with_the_last_whole_line() {
        let folder = tempfile::tempdir().unwrap();
        // The last line is not whole yet, and may lack digits.
        let text = "time,id,border_x,what\n0.0,0,0.5,left\n1.0,0,,right\n2.0,0,0.1,no";
        std::fs::write(folder.path().join("t.csv"), text).unwrap();
        let table = |wanted: &[&str]| Table::read(folder.path(), "t.csv", wanted);
        // Under its old name.
        let read = table(&["time", "boundary_x"]).unwrap().unwrap();
        assert_eq!(read.column("time"), [0.0, 1.0]);
        let x = read.column("boundary_x");
        assert!(x[0] == 0.5 && x[1].is_nan() && x.len() == 2, "{x:?}");
        let lacks = table(&["spin"]).unwrap_err().to_string();
        assert!(lacks.contains("t.csv lacks spin"), "{lacks}");
        assert!(Table::read(folder.path(), "none.csv", &["time"]).unwrap().is_none());
        let mut rows = Rows::open(folder.path(), "t.csv", &["id", "what"]).unwrap().unwrap();
        rows.advance().unwrap();
        assert_eq!(rows.text(1), "left");
    }
}
