//! Files that all ranks write together.

use crate::petsc::Session;
use crate::{Error, Result};
use mics_run::file::{PartFile, part};
use std::fs::{File, OpenOptions};
use std::path::Path;

/// Begins the file that will be at `path` for all ranks: rank 0 makes the file and will give it its
/// name, the others open it. Collective.
///
/// # Errors
/// When it cannot be made, or a rank does not see it.
pub fn create_together(session: &Session, path: &Path) -> Result<(Option<PartFile>, File)> {
    let made = if session.rank() == 0 { PartFile::create(path).map(Some) } else { Ok(None) };
    let (lead, opened) = match session.agree(made)? {
        Some((lead, file)) => (Some(lead), Ok(file)),
        None => {
            let name = part(path);
            let unseen = "not seen by this rank: all ranks need one and the same folder";
            let file = OpenOptions::new().write(true).open(&name);
            (None, file.map_err(|e| Error::Run(format!("{}: {e}; {unseen}", name.display()))))
        }
    };
    Ok((lead, session.agree(opened)?))
}
