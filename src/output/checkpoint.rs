//! Checkpoints as files: `checkpoint/STEP.ckpt`, the newest two.
//!
//! ```text
//!   "mics" 0 "ckp"   format   archive ([`crate::archive`]): header, run, scene   CRC-32 of all before it
//!       8 bytes      4 bytes                                                   4 bytes
//! ```
//! A file is written under another name, brought to the disk, renamed, and the folder brought to the disk: whatever ends
//! the process, the newest whole checkpoint is there.

use super::snapshot::part;
use crate::archive::{Archive, Checkpointed};
use crate::{Error, Result};
use crc32fast::Hasher;
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Take, Write};
use std::path::{Path, PathBuf};

/// The folder of a run's folder.
pub const FOLDER: &str = "checkpoint";
/// The ending of a checkpoint's name.
pub const ENDING: &str = "ckpt";
/// How the file begins.
const MAGIC: [u8; 8] = *b"mics\0ckp";
/// The format that this program writes and reads; another one wherever the archive's order changes.
pub const FORMAT: u32 = 12;
/// Bytes before the archive, and after it.
const HEAD: u64 = 12;
const TAIL: u64 = 4;
/// Checkpoints that are kept.
const KEPT: usize = 2;

/// What a checkpoint begins with.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Header {
    /// The version of the program that wrote it.
    pub version: String,
    /// The case as run, in TOML: with it a change of the case can be named, which a hash could not.
    pub case: String,
    /// On how many ranks.
    pub ranks: u64,
}

impl Checkpointed for Header {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let Header { version, case, ranks } = self;
        archive.label("checkpoint")?;
        archive.serialize([version, case, ranks])
    }
}

/// The file of a step's checkpoint.
pub fn path(run: &Path, step: u64) -> PathBuf {
    run.join(FOLDER).join(format!("{step:08}.{ENDING}"))
}

/// A checkpoint that is being written; dropped before [`Writer::commit`], it leaves nothing.
pub struct Writer {
    file: BufWriter<File>,
    hasher: Hasher,
    path: PathBuf,
    done: bool,
}

impl Writer {
    /// Begins the checkpoint of a step in a run's folder.
    pub fn create(run: &Path, step: u64) -> Result<Writer> {
        let path = path(run, step);
        let folder = run.join(FOLDER);
        fs::create_dir_all(&folder).map_err(Error::io(&folder))?;
        let file = File::create(part(&path)).map_err(Error::io(&path))?;
        let file = BufWriter::with_capacity(1 << 18, file);
        let mut writer = Writer { file, hasher: Hasher::new(), path, done: false };
        let head = [&MAGIC[..], &FORMAT.to_le_bytes()].concat();
        writer.write_all(&head).map_err(Error::io(&writer.path))?;
        Ok(writer)
    }

    /// Brings it to the disk under its name, and deletes what is older than the one before it.
    pub fn commit(mut self) -> Result<()> {
        let sum = self.hasher.clone().finalize().to_le_bytes();
        let folder = self.path.parent().unwrap_or(Path::new("")).to_owned();
        let written = self.file.write_all(&sum).and_then(|()| self.file.flush());
        let written = written.and_then(|()| self.file.get_ref().sync_all());
        let written = written.and_then(|()| fs::rename(part(&self.path), &self.path));
        written.map_err(Error::io(&self.path))?;
        self.done = true;
        File::open(&folder).and_then(|f| f.sync_all()).map_err(Error::io(&folder))?;
        for (_, path) in files(&folder)?.into_iter().skip(KEPT) {
            fs::remove_file(&path).map_err(Error::io(&path))?;
        }
        Ok(())
    }
}

impl Write for Writer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.file.write(bytes)?;
        self.hasher.update(&bytes[..n]);
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        if !self.done {
            // Half a checkpoint is of no use, and keeps space that others need.
            let _ = fs::remove_file(part(&self.path));
        }
    }
}

/// The checkpoints in a folder with their steps, newest first.
fn files(folder: &Path) -> Result<Vec<(u64, PathBuf)>> {
    let entries = match fs::read_dir(folder) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(Error::io(folder))?,
    };
    let step = |path: PathBuf| {
        let named = path.extension().is_some_and(|e| e == ENDING);
        Some((path.file_stem()?.to_str()?.parse().ok().filter(|_| named)?, path))
    };
    let mut files: Vec<_> = entries.flatten().filter_map(|e| step(e.path())).collect();
    files.sort_unstable_by_key(|(step, _)| std::cmp::Reverse(*step));
    Ok(files)
}

/// The step of the newest checkpoint of a run that is whole, and why newer ones are not.
///
/// # Errors
/// When there is none.
pub fn newest(run: &Path) -> Result<(u64, Vec<String>)> {
    let mut refused = Vec::new();
    for (step, path) in files(&run.join(FOLDER))? {
        match verify(&path) {
            Ok(()) => return Ok((step, refused)),
            Err(why) => refused.push(format!("{}: {why}", path.display())),
        }
    }
    let why = if refused.is_empty() { String::new() } else { format!(" ({})", refused.join("; ")) };
    Err(Error::Usage(format!(
        "{}: there is no checkpoint to go on from{why}; without --resume the run begins anew (with --force, where the folder \
         holds one already)",
        run.display()
    )))
}

/// Deletes the checkpoints of a run after `step`, which are damaged (by their steps they would pass for the newest), and
/// what was not finished.
pub fn delete_after(run: &Path, step: u64) -> Result<()> {
    let folder = run.join(FOLDER);
    let later = files(&folder)?.into_iter().filter(|(s, _)| *s > step).map(|(_, path)| path);
    let entries = fs::read_dir(&folder).into_iter().flatten().flatten().map(|e| e.path());
    let halves = entries.filter(|path| path.extension().is_some_and(|e| e == "part"));
    later.chain(halves).try_for_each(|path| fs::remove_file(&path).map_err(Error::io(&path)))
}

/// Why a file is no whole checkpoint, if it is not. Reads it once, whatever it holds.
fn verify(path: &Path) -> Result<(), String> {
    let read = |path: &Path| -> io::Result<Result<(), String>> {
        let (mut file, length) = sized(path)?;
        if length < HEAD + TAIL {
            return Ok(Err("it is too short".into()));
        }
        let (mut hasher, mut buffer, mut left) = (Hasher::new(), vec![0; 1 << 18], length - TAIL);
        let mut head = [0; HEAD as usize];
        file.read_exact(&mut head)?;
        hasher.update(&head);
        left -= HEAD;
        let format = u32::from_le_bytes([head[8], head[9], head[10], head[11]]);
        if head[..8] != MAGIC {
            return Ok(Err("it is no checkpoint".into()));
        }
        while left > 0 {
            let some = buffer.len().min(usize::try_from(left).unwrap_or(usize::MAX));
            file.read_exact(&mut buffer[..some])?;
            hasher.update(&buffer[..some]);
            left -= some as u64;
        }
        let mut sum = [0; TAIL as usize];
        file.read_exact(&mut sum)?;
        Ok(if u32::from_le_bytes(sum) != hasher.finalize() {
            Err("it is damaged, its checksum does not hold".into())
        } else if format != FORMAT {
            Err(format!("it has format {format}, and this mics goes on from format {FORMAT}"))
        } else {
            Ok(())
        })
    };
    read(path).unwrap_or_else(|e| Err(e.to_string()))
}

/// The archive of a run's checkpoint, for [`Archive::read`].
pub fn open(run: &Path, step: u64) -> Result<Take<BufReader<File>>> {
    let path = path(run, step);
    let opened = sized(&path).and_then(|(mut file, length)| {
        file.seek(SeekFrom::Start(HEAD))?;
        Ok(BufReader::with_capacity(1 << 18, file).take(length.saturating_sub(HEAD + TAIL)))
    });
    opened.map_err(Error::io(&path))
}

/// A plain file (a pipe would never end) with its length.
fn sized(path: &Path) -> io::Result<(File, u64)> {
    let about = fs::metadata(path)?;
    if !about.is_file() {
        return Err(io::Error::other("it is no file"));
    }
    Ok((File::open(path)?, about.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(run: &Path, step: u64, bytes: &[u8]) {
        let mut writer = Writer::create(run, step).unwrap();
        writer.write_all(bytes).unwrap();
        writer.commit().unwrap();
    }

    fn names(run: &Path) -> Vec<String> {
        let entries = fs::read_dir(run.join(FOLDER)).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn the_newest_two_are_kept_and_the_newest_whole_one_is_found() {
        let run = tempfile::tempdir().unwrap();
        assert!(newest(run.path()).unwrap_err().to_string().contains("no checkpoint to go on from"));
        for step in [5, 70, 300_000_000] {
            write(run.path(), step, b"state");
        }
        assert_eq!(names(run.path()), ["00000070.ckpt", "300000000.ckpt"]);
        assert_eq!(newest(run.path()).unwrap(), (300_000_000, vec![]));
        let mut text = String::new();
        open(run.path(), 70).unwrap().read_to_string(&mut text).unwrap();
        assert_eq!(text, "state");
    }

    #[test]
    fn every_damage_is_found_and_the_older_one_used() {
        let run = tempfile::tempdir().unwrap();
        write(run.path(), 1, b"older");
        write(run.path(), 2, b"newer");
        let file = path(run.path(), 2);
        let whole = fs::read(&file).unwrap();
        let flips = (0..whole.len()).map(|at| {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x10;
            bytes
        });
        let cuts = (0..whole.len()).map(|length| whole[..length].to_vec());
        for bytes in flips.chain(cuts).chain([[&whole[..], b"x"].concat()]) {
            fs::write(&file, &bytes).unwrap();
            let (step, refused) = newest(run.path()).unwrap();
            assert!(step == 1 && refused.len() == 1 && refused[0].contains("00000002.ckpt"), "{refused:?}");
        }
        fs::write(part(&path(run.path(), 3)), "half").unwrap();
        delete_after(run.path(), 1).unwrap();
        assert_eq!(names(run.path()), ["00000001.ckpt"]);
    }

    #[test]
    fn one_that_was_not_finished_leaves_nothing_and_one_of_another_format_is_named() {
        let run = tempfile::tempdir().unwrap();
        write(run.path(), 1, b"whole");
        let mut writer = Writer::create(run.path(), 2).unwrap();
        writer.write_all(b"half").unwrap();
        drop(writer);
        assert_eq!(names(run.path()), ["00000001.ckpt"]);
        let mut bytes = [&MAGIC[..], &(FORMAT + 1).to_le_bytes(), b"archive"].concat();
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        fs::write(path(run.path(), 3), bytes).unwrap();
        fs::create_dir(path(run.path(), 4)).unwrap();
        let (step, refused) = newest(run.path()).unwrap();
        assert!(
            step == 1 && refused[0].contains("no file") && refused[1].contains(&format!("format {}", FORMAT + 1)),
            "{refused:?}"
        );
    }
}
