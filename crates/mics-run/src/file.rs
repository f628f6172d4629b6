//! Files that are there whole or not at all.

use crate::{Error, Result};
use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

/// A file under the name that it has until it is whole; dropped before [`PartFile::commit`], it
/// leaves nothing.
pub struct PartFile {
    path: PathBuf,
    done: bool,
}

impl PartFile {
    /// Begins the file that will be at `path`, in a folder that is made where there is none.
    ///
    /// # Errors
    /// When it cannot be made.
    pub fn create(path: &Path) -> Result<(PartFile, File)> {
        let name = part(path);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(Error::io(folder))?;
        }
        let file = File::create(&name).map_err(Error::io(&name))?;
        Ok((PartFile { path: path.to_owned(), done: false }, file))
    }

    /// Gives it its name.
    ///
    /// # Errors
    /// When that is not possible.
    pub fn commit(mut self) -> Result<()> {
        fs::rename(part(&self.path), &self.path).map_err(Error::io(&self.path))?;
        self.done = true;
        Ok(())
    }
}

impl Drop for PartFile {
    fn drop(&mut self) {
        if !self.done {
            // Half a file (a full disk) is of no use, and would keep space that the next one needs.
            let _ = fs::remove_file(part(&self.path));
        }
    }
}

/// The name of a file while it is being written.
pub fn part(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    path.with_file_name(name)
}

/// Writes a whole file or none.
///
/// # Errors
/// When it cannot be written.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<()> {
    replace_by(path, |file| file.write_all(bytes).map_err(Error::io(part(path))))
}

/// Writes a whole file or none, piece by piece.
///
/// # Errors
/// When the file cannot be written, or `write` says so.
pub fn replace_by(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<()>,
) -> Result<()> {
    let (whole, file) = PartFile::create(path)?;
    let mut file = BufWriter::new(file);
    write(&mut file)?;
    file.flush().map_err(Error::io(part(path)))?;
    whole.commit()
}
