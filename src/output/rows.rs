//! Files that grow by whole lines: whatever ends the process, and on a disk that fills up, what is
//! there ends with a line.

use crate::{Error, Result};
use mics_run::folder::old_name;
use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead as _, BufReader, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// Bytes of lines that wait before they are written.
const ROOM: usize = 1 << 16;

/// Places of the columns that the line `head` of names has under a new and an old name.
pub fn renamed(head: &str) -> Vec<usize> {
    let has = |old: String| head.split(',').any(|name| name == old);
    let places = head.split(',').enumerate();
    places.filter(|(_, name)| old_name(name).is_some_and(has)).map(|(place, _)| place).collect()
}

/// A line of names with the old names of renamed columns at its end.
pub fn with_old_names(head: &str) -> String {
    let old = head.split(',').filter_map(old_name);
    old.fold(head.to_owned(), |line, name| line + "," + &name)
}

/// Appends to the last line of a text its values in these columns.
pub fn repeat(text: &mut String, columns: &[usize]) {
    let start = text.rfind('\n').map_or(0, |end| end + 1);
    let end = text.len();
    for column in columns {
        let mut from = start;
        for _ in 0..*column {
            from += text[from..end].find(',').map_or(0, |comma| comma + 1);
        }
        let to = from + text[from..end].find(',').unwrap_or(end - from);
        text.push(',');
        text.extend_from_within(from..to);
    }
}

/// A file of lines.
pub struct LineFile {
    file: File,
    path: PathBuf,
    /// Whole lines that are not in the file yet.
    waiting: String,
    /// Bytes in the file.
    written: u64,
    /// Places of its columns that a row repeats at its end, under their old names.
    renamed: Vec<usize>,
}

impl LineFile {
    /// A new file, with the names of columns `head` in its first line unless that is empty; old
    /// names of renamed columns follow them.
    pub fn create(path: &Path, head: &str) -> Result<LineFile> {
        let file = File::create(path).map_err(Error::io(path))?;
        let mut rows = LineFile {
            file,
            path: path.to_owned(),
            waiting: String::with_capacity(2 * ROOM),
            written: 0,
            renamed: Vec::new(),
        };
        if !head.is_empty() {
            let head = with_old_names(head);
            rows.add(format_args!("{head}"))?;
            rows.renamed = renamed(&head);
        }
        Ok(rows)
    }

    /// A file that goes on after its first `length` bytes; what follows them is dropped.
    ///
    /// # Errors
    /// When it is shorter, or has no line that ends there: it is not the file that was left.
    pub fn go_on(path: &Path, length: u64) -> Result<LineFile> {
        let mut file = Self::fits(path, length)?;
        file.set_len(length).map_err(Error::io(path))?;
        file.rewind().map_err(Error::io(path))?;
        let mut head = String::new();
        BufReader::new(&file).read_line(&mut head).map_err(Error::io(path))?;
        let mut rows = LineFile {
            file,
            path: path.to_owned(),
            waiting: String::with_capacity(2 * ROOM),
            written: length,
            renamed: renamed(head.trim_end()),
        };
        rows.file.seek(SeekFrom::End(0)).map_err(Error::io(path))?;
        Ok(rows)
    }

    /// Opens a file that has a line's end after `length` bytes.
    pub fn fits(path: &Path, length: u64) -> Result<File> {
        let changed = |why: &str| {
            Error::Usage(format!(
                "{}: {why} than when the checkpoint was written; put the file back as it was, or \
                begin anew with --force",
                path.display()
            ))
        };
        let mut file =
            OpenOptions::new().read(true).write(true).open(path).map_err(|e| match e.kind() {
                io::ErrorKind::NotFound => changed("the file is not there, other"),
                _ => Error::io(path)(e),
            })?;
        let mut last = [b'\n'];
        if length > 0 {
            let read =
                file.seek(SeekFrom::Start(length - 1)).and_then(|_| file.read_exact(&mut last));
            read.map_err(|_| changed("the file is shorter"))?;
        }
        if last != [b'\n'] { Err(changed("the file has other lines")) } else { Ok(file) }
    }

    /// Adds a line.
    pub fn add(&mut self, line: fmt::Arguments) -> Result<()> {
        self.put(line);
        self.end_line()
    }

    /// Adds a part of a line.
    pub fn put(&mut self, part: fmt::Arguments) {
        // A String takes everything.
        let _ = fmt::Write::write_fmt(&mut self.waiting, part);
    }

    /// Ends a line.
    pub fn end_line(&mut self) -> Result<()> {
        repeat(&mut self.waiting, &self.renamed);
        self.waiting.push('\n');
        if self.waiting.len() < ROOM { Ok(()) } else { self.flush() }
    }

    /// Brings all lines to the file.
    ///
    /// # Errors
    /// When they do not fit: the file then ends as it did before.
    pub fn flush(&mut self) -> Result<()> {
        let lines = std::mem::take(&mut self.waiting);
        if let Err(e) = self.file.write_all(lines.as_bytes()) {
            self.waiting = lines;
            // Half a line is worse than none. If even that fails, there is nobody left to tell.
            let _ = self.file.set_len(self.written);
            let _ = self.file.seek(SeekFrom::Start(self.written));
            return Err(Error::io(&self.path)(e));
        }
        self.written += lines.len() as u64;
        self.waiting = lines;
        self.waiting.clear();
        Ok(())
    }

    /// Brings all lines to the disk; the bytes that the file then has.
    pub fn sync(&mut self) -> Result<u64> {
        self.flush()?;
        self.file.sync_data().map_err(Error::io(&self.path))?;
        Ok(self.written)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn renamed_columns_stand_under_old_names_at_the_end_before_and_after_a_resume() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.csv");
        let mut rows = LineFile::create(&path, "time,boundary_work,x,defect_fx").unwrap();
        rows.add(format_args!("0.5,1.0,2.0,3.0")).unwrap();
        let kept = rows.sync().unwrap();
        drop(rows);
        let mut rows = LineFile::go_on(&path, kept).unwrap();
        rows.add(format_args!("0.75,4.0,5.0,6.0")).unwrap();
        rows.flush().unwrap();
        assert_eq!(
            std::fs::read_to_string(&path).unwrap(),
            "time,boundary_work,x,defect_fx,border_work,convective_fx\n\
            0.5,1.0,2.0,3.0,1.0,3.0\n0.75,4.0,5.0,6.0,4.0,6.0\n"
        );
    }

    #[test]
    fn csv_is_truncated_on_resume_and_changed_file_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.csv");
        let mut rows = LineFile::create(&path, "head").unwrap();
        rows.add(format_args!("{},{}", 1, 2)).unwrap();
        let kept = rows.sync().unwrap();
        rows.add(format_args!("to be dropped")).unwrap();
        rows.flush().unwrap();
        drop(rows);
        let mut rows = LineFile::go_on(&path, kept).unwrap();
        rows.add(format_args!("3,4")).unwrap();
        rows.flush().unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "head\n1,2\n3,4\n");
        for (length, why) in [(kept - 1, "other lines"), (kept + 40, "shorter")] {
            let said = LineFile::go_on(&path, length).err().unwrap().to_string();
            assert!(said.contains(why) && said.contains("--force"), "{said}");
        }
        assert_eq!(
            std::fs::read_to_string(&path).unwrap(),
            "head\n1,2\n3,4\n",
            "a refusal changes nothing"
        );
    }
}
