//! The archive inside a checkpoint: what lasts from step to step, written and read by one list.
//!
//! A struct names what lasts of it once, in [`Checkpointed::serialize`]: an archive that writes
//! takes each number from its place, one that reads puts it there. All are eight bytes, little
//! endian:
//!
//! ```text
//!   number   a double, finite                 label
//!              count, text: what comes next, and has to be there when read
//!   count    an integer                       list    count, entries
//!   field    count of boxes, one a rank; of each its first cell and its extent along each axis,
//!            then the values, x fastest
//! ```
//! Structs are taken apart without `..`, so that a new field compiles only once somebody has said
//! whether it lasts.
//!
//! Boxes stand in the whole grid's count, so that any number of ranks finds its cells. The same
//! ranks find their own boxes again, bit for bit: two ranks share a face, and need not agree on its
//! last digit.
//!
//! What is read is checked as it comes: no list is longer than its file, no box larger than the
//! grid.

mod boxes;

use crate::petsc::Session;
use crate::{Error, Result};
use nalgebra::{Quaternion, SVector, UnitQuaternion};
use std::io::{self, Read};

/// State that lasts from step to step.
pub trait Checkpointed {
    /// Writes or reads all of it, in one order.
    ///
    /// # Errors
    /// When an archive that is read holds something else; what has been read by then is of no use.
    fn serialize(&mut self, archive: &mut Archive) -> Result<()>;
}

/// An archive that is written or read.
pub struct Archive<'a> {
    session: &'a Session,
    head: Head<'a>,
}

enum Head<'a> {
    /// A failure is kept for the end, since the others go on.
    Writes {
        to: &'a mut dyn Target,
        failed: Option<Error>,
    },
    Reads {
        from: &'a mut dyn Source,
        row: Vec<u8>,
    },
}

/// Where an archive is written.
pub trait Target {
    /// Writes what comes next, the same on every rank and wanted once.
    ///
    /// # Errors
    /// When that is not possible.
    fn put(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Writes what each rank has, one after the other in the order of the ranks. Collective.
    ///
    /// # Errors
    /// When that is not possible.
    fn put_parts(&mut self, session: &Session, mine: &[u8]) -> Result<()>;
}

/// What an archive is read from, on every rank for itself.
pub trait Source: Read {
    /// Passes over bytes.
    ///
    /// # Errors
    /// When there are fewer.
    fn skip(&mut self, bytes: u64) -> io::Result<()>;
}

/// Memory, for one rank.
impl Target for Vec<u8> {
    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.extend_from_slice(bytes);
        Ok(())
    }

    fn put_parts(&mut self, session: &Session, mine: &[u8]) -> Result<()> {
        if session.size() > 1 {
            return Err(Error::Run("an archive in memory is of one rank".into()));
        }
        self.put(mine).map_err(io_failure)
    }
}

impl Source for &[u8] {
    fn skip(&mut self, bytes: u64) -> io::Result<()> {
        let after = usize::try_from(bytes).ok().and_then(|bytes| self.get(bytes..));
        *self = after.ok_or(io::ErrorKind::UnexpectedEof)?;
        Ok(())
    }
}

impl<'a> Archive<'a> {
    /// One to write. All ranks write the same state, and then [`Archive::finish`].
    pub fn write(session: &'a Session, to: &'a mut dyn Target) -> Archive<'a> {
        Archive { session, head: Head::Writes { to, failed: None } }
    }

    /// One to read, on every rank for itself.
    pub fn read(session: &'a Session, from: &'a mut dyn Source) -> Archive<'a> {
        Archive { session, head: Head::Reads { from, row: Vec::new() } }
    }

    /// Writes or reads several, in their order.
    pub fn serialize<const N: usize>(&mut self, items: [&mut dyn Checkpointed; N]) -> Result<()> {
        items.into_iter().try_for_each(|item| item.serialize(self))
    }

    /// Writes or reads as many as the case has.
    pub fn each<T: Checkpointed>(&mut self, what: &str, items: &mut [T]) -> Result<()> {
        self.label(what)?;
        let mut count = items.len() as u64;
        count.serialize(self)?;
        if count != items.len() as u64 {
            return Err(refusal(format!(
                "it holds {count} of what the case has {}: {what}",
                items.len()
            )));
        }
        items.iter_mut().try_for_each(|item| item.serialize(self))
    }

    /// Says what comes next.
    pub fn label(&mut self, text: &str) -> Result<()> {
        let mut count = text.len() as u64;
        count.serialize(self)?;
        let mut bytes = text.as_bytes().to_vec();
        if count == bytes.len() as u64 {
            self.bytes(&mut bytes)?;
        }
        if count != text.len() as u64 || bytes != text.as_bytes() {
            return Err(refusal(format!("{text} should come next, and something else does")));
        }
        Ok(())
    }

    fn skip(&mut self, bytes: u64) -> Result<()> {
        let Head::Reads { from, .. } = &mut self.head else { return Ok(()) };
        from.skip(bytes).map_err(read_failure)
    }

    /// The next `count` numbers of an archive that is read, as they stand there.
    fn row(&mut self, count: usize) -> Result<&[u8]> {
        let Head::Reads { from, row } = &mut self.head else { return Ok(&[]) };
        row.resize(8 * count, 0);
        from.read_exact(row).map_err(read_failure)?;
        Ok(row)
    }

    fn bytes(&mut self, bytes: &mut [u8]) -> Result<()> {
        match &mut self.head {
            Head::Writes { to, failed } => {
                if failed.is_none() {
                    *failed = to.put(bytes).err().map(io_failure);
                }
                Ok(())
            }
            Head::Reads { from, .. } => from.read_exact(bytes).map_err(read_failure),
        }
    }

    /// Whether it is read.
    pub fn reads(&self) -> bool {
        matches!(self.head, Head::Reads { .. })
    }

    /// Ends the archive: what failed while it was written fails here, on all ranks; one that is
    /// read has to be at its end. Collective.
    pub fn finish(self) -> Result<()> {
        self.session.agree(match self.head {
            Head::Writes { failed: Some(error), .. } => Err(error),
            Head::Writes { failed: None, .. } => Ok(()),
            Head::Reads { from, .. } => match from.read(&mut [0]) {
                Ok(0) => Ok(()),
                Ok(_) => Err(refusal("more follows where it should end".into())),
                Err(e) => Err(read_failure(e)),
            },
        })
    }
}

fn refusal(why: String) -> Error {
    Error::Usage(why)
}

fn io_failure(e: io::Error) -> Error {
    Error::io("checkpoint")(e)
}

fn read_failure(e: io::Error) -> Error {
    if e.kind() == io::ErrorKind::UnexpectedEof {
        refusal("it ends too early".into())
    } else {
        io_failure(e)
    }
}

fn double(bytes: &[u8]) -> Result<f64> {
    let x = f64::from_le_bytes(bytes.try_into().unwrap_or([0xff; 8]));
    if x.is_finite() {
        Ok(x)
    } else {
        Err(refusal(format!("it holds {x} where a finite number should be")))
    }
}

impl Checkpointed for f64 {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let mut bytes = self.to_le_bytes();
        archive.bytes(&mut bytes)?;
        match &mut archive.head {
            Head::Writes { failed, .. } => {
                if failed.is_none() && !self.is_finite() {
                    *failed = Some(Error::Run(format!(
                        "{self} cannot be kept: it is not a finite number"
                    )));
                }
            }
            Head::Reads { .. } => *self = double(&bytes)?,
        }
        Ok(())
    }
}

impl Checkpointed for u64 {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let mut bytes = self.to_le_bytes();
        archive.bytes(&mut bytes)?;
        *self = u64::from_le_bytes(bytes);
        Ok(())
    }
}

impl Checkpointed for usize {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let mut count = *self as u64;
        count.serialize(archive)?;
        *self = count as usize;
        Ok(())
    }
}

impl Checkpointed for String {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let mut count = self.len() as u64;
        count.serialize(archive)?;
        let Head::Reads { from, .. } = &mut archive.head else {
            let mut bytes = self.as_bytes().to_vec();
            return archive.bytes(&mut bytes);
        };
        // Grows with what is there, whatever the count says.
        let mut bytes = Vec::new();
        from.take(count).read_to_end(&mut bytes).map_err(read_failure)?;
        if bytes.len() as u64 != count {
            return Err(refusal("it ends within a text".into()));
        }
        *self =
            String::from_utf8(bytes).map_err(|_| refusal("it holds a text that is none".into()))?;
        Ok(())
    }
}

impl<const N: usize> Checkpointed for SVector<f64, N> {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        self.iter_mut().try_for_each(|x| x.serialize(archive))
    }
}

impl Checkpointed for UnitQuaternion<f64> {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let mut numbers = self.coords;
        numbers.serialize(archive)?;
        // Normalising again would change its last digits.
        *self = UnitQuaternion::new_unchecked(Quaternion::from(numbers));
        Ok(())
    }
}

impl<A: Checkpointed, B: Checkpointed> Checkpointed for (A, B) {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        archive.serialize([&mut self.0, &mut self.1])
    }
}

impl<A: Checkpointed, B: Checkpointed, C: Checkpointed> Checkpointed for (A, B, C) {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        archive.serialize([&mut self.0, &mut self.1, &mut self.2])
    }
}

impl<T: Checkpointed + Default> Checkpointed for Option<T> {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let mut there = u64::from(self.is_some());
        there.serialize(archive)?;
        match there {
            0 => *self = None,
            1 => self.get_or_insert_default().serialize(archive)?,
            other => return Err(refusal(format!("it holds {other} where 0 or 1 should be"))),
        }
        Ok(())
    }
}

impl<T: Checkpointed + Default> Checkpointed for Vec<T> {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let mut count = self.len() as u64;
        count.serialize(archive)?;
        if !archive.reads() {
            return self.iter_mut().try_for_each(|item| item.serialize(archive));
        }
        self.clear();
        // No room ahead: every entry is read before the next one is made.
        for _ in 0..count {
            let mut item = T::default();
            item.serialize(archive)?;
            self.push(item);
        }
        Ok(())
    }
}
