//! Checkpoints as files: `checkpoint/STEP.ckpt`, the newest two.
//!
//! ```text
//!   "mics" 0 "ckp"   format   archive ([`crate::archive`]): header, run, scene
//!              CRC-32 of all before it
//!       8 bytes      4 bytes                                                   4 bytes
//! ```
//! A file is written under another name, brought to the disk, renamed, and the folder brought to
//! the disk: whatever ends the process, the newest whole checkpoint is there.

use super::file::create_together;
use crate::archive::{Archive, Checkpointed, Source, Target};
use crate::petsc::Session;
use crate::{Error, Result};
use crc32fast::Hasher;
use mics_run::file::PartFile;
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};

/// The folder of a run's folder.
pub const FOLDER: &str = "checkpoint";
/// The ending of a checkpoint's name.
pub const ENDING: &str = "ckpt";
/// First bytes of the file.
const MAGIC: [u8; 8] = *b"mics\0ckp";
/// The format that this program writes and reads; another one wherever the archive's order changes.
pub const FORMAT: u32 = 21;
/// Bytes before the archive, and after it.
const HEAD: u64 = 12;
const TAIL: u64 = 4;
/// Checkpoints that are kept.
const KEPT: usize = 2;

/// Header at the start of a checkpoint's archive.
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

/// A checkpoint that all ranks write; dropped before [`Writer::commit`], it leaves nothing.
pub struct Writer {
    file: BufWriter<File>,
    path: PathBuf,
    /// On rank 0, which writes what all ranks share.
    lead: Option<Lead>,
}

/// Rank 0's part of a writer: the file to be renamed, the checksum and the place.
struct Lead {
    part: PartFile,
    hasher: Hasher,
    /// Where it writes next.
    at: u64,
}

impl Writer {
    /// Begins the checkpoint of a step in a run's folder. Collective.
    ///
    /// # Errors
    /// When it cannot be made, or a rank does not see it.
    pub fn begin(session: &Session, run: &Path, step: u64) -> Result<Writer> {
        let path = path(run, step);
        let folder = run.join(FOLDER);
        session.agree(if session.rank() == 0 {
            fs::create_dir_all(&folder).map_err(Error::io(&folder))
        } else {
            Ok(())
        })?;
        let (part, file) = create_together(session, &path)?;
        session.agree(Writer::of(path, part, file))
    }

    fn of(path: PathBuf, part: Option<PartFile>, file: File) -> Result<Writer> {
        let lead = part.map(|part| Lead { part, hasher: Hasher::new(), at: 0 });
        let mut writer = Writer { file: BufWriter::with_capacity(1 << 18, file), path, lead };
        let head = [&MAGIC[..], &FORMAT.to_le_bytes()].concat();
        writer.put(&head).map_err(Error::io(&writer.path))?;
        Ok(writer)
    }

    /// Brings it to the disk under its name, and deletes what is older than the one before it.
    /// Collective.
    ///
    /// # Errors
    /// When a rank cannot.
    pub fn commit(mut self, session: &Session) -> Result<()> {
        let synced = self.file.flush().and_then(|()| self.file.get_ref().sync_all());
        session.agree(synced.map_err(Error::io(&self.path)))?;
        session.agree(self.close())
    }

    /// Completes the file on rank 0, once all have written.
    fn close(mut self) -> Result<()> {
        let Some(lead) = self.lead.take() else { return Ok(()) };
        let folder = self.path.parent().unwrap_or(Path::new("")).to_owned();
        let written = self
            .file
            .write_all(&lead.hasher.finalize().to_le_bytes())
            .and_then(|()| self.file.flush());
        written.and_then(|()| self.file.get_ref().sync_all()).map_err(Error::io(&self.path))?;
        lead.part.commit()?;
        File::open(&folder).and_then(|f| f.sync_all()).map_err(Error::io(&folder))?;
        for (_, path) in files(&folder)?.into_iter().skip(KEPT) {
            fs::remove_file(&path).map_err(Error::io(&path))?;
        }
        Ok(())
    }

    /// Writes this rank's part at its place; rank 0 goes on after the last one.
    fn place(&mut self, at: u64, mine: &[u8], after: u64) -> io::Result<()> {
        self.file.flush()?;
        self.file.get_ref().write_all_at(mine, at)?;
        self.file.seek(SeekFrom::Start(after)).map(drop)
    }
}

impl Target for Writer {
    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        let Some(lead) = &mut self.lead else { return Ok(()) };
        lead.hasher.update(bytes);
        lead.at += bytes.len() as u64;
        self.file.write_all(bytes)
    }

    fn put_parts(&mut self, session: &Session, mine: &[u8]) -> Result<()> {
        let rank = session.rank();
        let ranks = session.size();
        // Where the parts begin, and length and checksum of each: whole numbers that a double
        // holds, each told by one rank.
        let mut told = vec![0.0; 1 + 2 * ranks];
        told[0] = self.lead.as_ref().map_or(0.0, |lead| lead.at as f64);
        told[1 + 2 * rank] = mine.len() as f64;
        told[2 + 2 * rank] = f64::from(crc32fast::hash(mine));
        session.sum(&mut told)?;
        let begin = told[0] as u64;
        let parts = told[1..].chunks_exact(2).map(|part| (part[0] as u64, part[1] as u32));
        let at = begin + parts.clone().take(rank).map(|(length, _)| length).sum::<u64>();
        let after = begin + parts.clone().map(|(length, _)| length).sum::<u64>();
        if let Some(lead) = &mut self.lead {
            parts.for_each(|(length, sum)| {
                lead.hasher.combine(&Hasher::new_with_initial_len(sum, length))
            });
            lead.at = after;
        }
        self.place(at, mine, after).map_err(Error::io(&self.path))
    }
}

/// The archive of a checkpoint that is read, between its head and its checksum.
pub struct Reader {
    file: BufReader<File>,
    left: u64,
}

impl Read for Reader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = (&mut self.file).take(self.left).read(buffer)?;
        self.left -= n as u64;
        Ok(n)
    }
}

impl Source for Reader {
    fn skip(&mut self, bytes: u64) -> io::Result<()> {
        self.left = self.left.checked_sub(bytes).ok_or(io::ErrorKind::UnexpectedEof)?;
        self.file.seek_relative(bytes as i64)
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

/// Whether a run has checkpoints.
pub fn any(run: &Path) -> Result<bool> {
    Ok(!files(&run.join(FOLDER))?.is_empty())
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
        "{}: there is no checkpoint to go on from{why}; without --resume the run begins anew (with \
        --force, where the folder \
         holds one already)",
        run.display()
    )))
}

/// Deletes the checkpoints of a run after `step`, which are damaged (by their steps they would pass
/// for the newest), and what was not finished.
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
        let mut hasher = Hasher::new();
        let mut buffer = vec![0; 1 << 18];
        let mut left = length - TAIL;
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
pub fn open(run: &Path, step: u64) -> Result<Reader> {
    let path = path(run, step);
    let opened = sized(&path).and_then(|(mut file, length)| {
        file.seek(SeekFrom::Start(HEAD))?;
        Ok(Reader {
            file: BufReader::with_capacity(1 << 18, file),
            left: length.saturating_sub(HEAD + TAIL),
        })
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
    use mics_run::file::part;

    /// Begins a checkpoint as one rank does.
    fn begin(run: &Path, step: u64) -> Writer {
        let path = path(run, step);
        fs::create_dir_all(run.join(FOLDER)).unwrap();
        let (part, file) = PartFile::create(&path).unwrap();
        Writer::of(path, Some(part), file).unwrap()
    }

    fn write(run: &Path, step: u64, bytes: &[u8]) {
        let mut writer = begin(run, step);
        writer.put(bytes).unwrap();
        writer.close().unwrap();
    }

    fn names(run: &Path) -> Vec<String> {
        let entries = fs::read_dir(run.join(FOLDER)).unwrap();
        let mut names: Vec<_> =
            entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn newest_two_checkpoints_kept_and_newest_valid_found() {
        let run = tempfile::tempdir().unwrap();
        assert!(
            newest(run.path()).unwrap_err().to_string().contains("no checkpoint to go on from")
        );
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
    fn damaged_checkpoint_detected_and_older_used() {
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
            assert!(
                step == 1 && refused.len() == 1 && refused[0].contains("00000002.ckpt"),
                "{refused:?}"
            );
        }
        fs::write(part(&path(run.path(), 3)), "half").unwrap();
        delete_after(run.path(), 1).unwrap();
        assert_eq!(names(run.path()), ["00000001.ckpt"]);
    }

    #[test]
    fn unfinished_and_foreign_format_checkpoints() {
        let run = tempfile::tempdir().unwrap();
        write(run.path(), 1, b"whole");
        let mut writer = begin(run.path(), 2);
        writer.put(b"half").unwrap();
        drop(writer);
        assert_eq!(names(run.path()), ["00000001.ckpt"]);
        let mut bytes = [&MAGIC[..], &(FORMAT + 1).to_le_bytes(), b"archive"].concat();
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        fs::write(path(run.path(), 3), bytes).unwrap();
        fs::create_dir(path(run.path(), 4)).unwrap();
        let (step, refused) = newest(run.path()).unwrap();
        assert!(
            step == 1
                && refused[0].contains("no file")
                && refused[1].contains(&format!("format {}", FORMAT + 1)),
            "{refused:?}"
        );
    }
}
