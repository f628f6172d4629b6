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
//! last digit. A rank that finds its own box takes that, and else its part of each.
//!
//! All that is read is checked as it comes: no list is longer than its file, no box larger than the
//! grid.

use crate::grid::{Grid, Rows};
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

/// Target of an archive that is written.
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

/// Source of an archive, which every rank reads for itself.
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

/// A box of cells, or of faces, in the whole grid's count.
#[derive(Clone, Copy, PartialEq)]
struct Cells<const D: usize> {
    start: [usize; D],
    extent: [usize; D],
}

impl<const D: usize> Cells<D> {
    fn end(&self, axis: usize) -> usize {
        self.start[axis] + self.extent[axis]
    }

    fn count(&self) -> usize {
        self.extent.iter().product()
    }

    fn meets(&self, other: &Cells<D>) -> bool {
        (0..D).all(|a| self.end(a) > other.start[a] && other.end(a) > self.start[a])
    }
}

impl<'a> Archive<'a> {
    /// An archive to write. All ranks write the same state, and then [`Archive::finish`].
    pub fn write(session: &'a Session, to: &'a mut dyn Target) -> Archive<'a> {
        Archive { session, head: Head::Writes { to, failed: None } }
    }

    /// An archive to read, on every rank for itself.
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

    /// Writes a text that says what comes next, or checks that it is there.
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

    /// Writes or reads the cells of fields.
    pub fn cells<const D: usize>(&mut self, grid: &Grid<D>, fields: &mut [Vec<f64>]) -> Result<()> {
        fields.iter_mut().try_for_each(|field| self.boxes(grid, grid.local, || grid.rows(), field))
    }

    /// Writes or reads a velocity through faces.
    pub fn faces<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        field: &mut [Vec<f64>; D],
    ) -> Result<()> {
        for (axis, field) in field.iter_mut().enumerate() {
            let mut extent = grid.local;
            extent[axis] += 1;
            self.boxes(grid, extent, || grid.face_rows(axis), field)?;
        }
        Ok(())
    }

    fn boxes<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        extent: [usize; D],
        rows: impl Fn() -> Rows<D>,
        field: &mut [f64],
    ) -> Result<()> {
        let mut count = self.session.size() as u64;
        count.serialize(self)?;
        let Head::Writes { to, failed } = &mut self.head else {
            return self.read_boxes(grid, extent, rows, field, count);
        };
        let head = (0..D).flat_map(|a| [grid.start[a] as f64, extent[a] as f64]);
        let mut bytes: Vec<u8> = head.flat_map(f64::to_le_bytes).collect();
        bytes.reserve_exact(8 * extent.iter().product::<usize>());
        let mut finite = true;
        for x in rows().flat_map(|row| &field[row]) {
            finite &= x.is_finite();
            bytes.extend_from_slice(&x.to_le_bytes());
        }
        let written = to.put_parts(self.session, &bytes);
        if failed.is_none() {
            *failed = written.err();
        }
        if failed.is_none() && !finite {
            *failed = Some(Error::Run(
                "a field is not finite everywhere: there is nothing to go on from".into(),
            ));
        }
        Ok(())
    }

    /// Takes this rank's part of `count` boxes: its own where it is among them, else what the boxes
    /// have of it.
    fn read_boxes<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        extent: [usize; D],
        rows: impl Fn() -> Rows<D>,
        field: &mut [f64],
        count: u64,
    ) -> Result<()> {
        if !(1..=grid.total_cells() as u64).contains(&count) {
            return Err(refusal(format!("a field in {count} boxes is not of this grid")));
        }
        let mine = Cells { start: grid.start, extent };
        let mut taken = 0;
        let mut own = false;
        for _ in 0..count {
            let there = self.read_box(grid, extent)?;
            if there == mine {
                for row in rows() {
                    taken += put(self.row(row.len())?, &mut field[row])?;
                }
                own = true;
            } else if own || !there.meets(&mine) {
                self.skip(8 * there.count() as u64)?;
            } else {
                taken += self.read_common(grid, &mine, &there, field)?;
            }
        }
        if taken < mine.count() {
            return Err(refusal("a field does not fill the grid".into()));
        }
        Ok(())
    }

    /// The next box, which has to lie in the grid; `extent` is that of this rank's.
    fn read_box<const D: usize>(&mut self, grid: &Grid<D>, extent: [usize; D]) -> Result<Cells<D>> {
        let mut found = Cells { start: [0; D], extent: [0; D] };
        for a in 0..D {
            let inside = (grid.cells[a] + extent[a] - grid.local[a]) as f64;
            let mut s = 0.0;
            let mut n = 0.0;
            self.serialize([&mut s, &mut n])?;
            let whole = |x: f64| x >= 0.0 && x.fract() == 0.0 && x <= inside;
            if !(whole(s) && whole(n) && n >= 1.0 && s + n <= inside) {
                return Err(refusal(format!(
                    "a box of {n} cells from cell {s} on is not of this grid"
                )));
            }
            found.start[a] = s as usize;
            found.extent[a] = n as usize;
        }
        Ok(found)
    }

    /// Takes the cells that another box shares with this rank's, and returns their number.
    fn read_common<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        mine: &Cells<D>,
        there: &Cells<D>,
        field: &mut [f64],
    ) -> Result<usize> {
        let mut taken = 0;
        let from = there.start[0].max(mine.start[0]);
        let to = there.end(0).min(mine.end(0));
        for k in 0..there.extent[1..].iter().product() {
            let values = self.row(there.extent[0])?;
            // Where the row lies in this rank's box, if it does.
            let mut rest = k;
            let mut at = Some(from + grid.ghosts - mine.start[0]);
            for a in 1..D {
                let cell = there.start[a] + rest % there.extent[a];
                rest /= there.extent[a];
                let within = (mine.start[a]..mine.end(a)).contains(&cell);
                at = at
                    .filter(|_| within)
                    .map(|at| at + (cell + grid.ghosts - mine.start[a]) * grid.stride[a]);
            }
            if let Some(at) = at {
                let common = &values[8 * (from - there.start[0])..8 * (to - there.start[0])];
                taken += put(common, &mut field[at..])?;
            }
        }
        Ok(taken)
    }
}

/// Puts numbers in their places, and returns how many.
fn put(bytes: &[u8], field: &mut [f64]) -> Result<usize> {
    for (x, bytes) in field.iter_mut().zip(bytes.chunks_exact(8)) {
        *x = double(bytes)?;
    }
    Ok(bytes.len() / 8)
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
