//! A level of the multigrid on fewer ranks: where ranks have few cells left, some beside each other
//! give theirs to one of them, which goes on.
//!
//! ```text
//!   +----+----+----+----+        +---------+---------+        +-------------------+
//!   | 0  | 1  | 2  | 3  |        |         |         |        |                   |
//!   +----+----+----+----+  --->  |    0    |    2    |  --->  |         0         |
//!   | 4  | 5  | 6  | 7  |        |         |         |        |                   |
//!   +----+----+----+----+        +---------+---------+        +-------------------+
//! ```
//! A cycle is two messages of each other rank: b to the one, x back. The rest wait meanwhile.

use super::lattice::Lattice;
use super::level::{Level, Single};
use super::whole::Whole;
use crate::petsc::Session;
use crate::{Error, Result};

/// Cells per rank below which a level, from the third on, is merged: a sweep over so many takes as
/// long as a message.
const FEW: usize = 2048;

/// A rank that gives its cells to another, or that other one itself: its first cell and its cells
/// along each axis within the merged box.
struct Member {
    rank: usize,
    first: [usize; 3],
    n: [usize; 3],
}

/// The ranks whose cells are merged with this one's.
pub(super) struct Merge {
    session: Session,
    /// The rank that goes on.
    root: usize,
    /// All ranks of the merge on `root`; elsewhere this one alone.
    members: Vec<Member>,
    buffer: Vec<Single>,
}

/// Whether a level on this grid had better be merged.
pub(super) fn is_due(whole: &Whole) -> bool {
    whole.cells() < FEW * whole.parts().iter().product::<usize>()
}

impl Merge {
    /// The ranks that merge the level `whole`, and the merged grid on the rank that goes on.
    pub fn new(session: &Session, whole: &Whole) -> (Merge, Option<Whole>) {
        // The narrowest boxes are merged first, until there are enough cells for each rank.
        let mut by = [1; 3];
        let parts = whole.parts();
        let left =
            |by: &[usize; 3]| -> [usize; 3] { std::array::from_fn(|a| parts[a].div_ceil(by[a])) };
        while by == [1; 3] || whole.cells() < FEW * left(&by).iter().product::<usize>() {
            let wide = |a: &usize| whole.cells_along(*a) / left(&by)[*a];
            let Some(axis) = (0..3).filter(|a| left(&by)[*a] > 1).min_by_key(wide) else { break };
            by[axis] *= 2;
        }
        let merged = whole.merged(by);
        let first: [usize; 3] = std::array::from_fn(|a| whole.at[a] / by[a] * by[a]);
        let root = whole.rank_of(first);
        let last: [usize; 3] = std::array::from_fn(|a| (first[a] + by[a]).min(parts[a]));
        let mut members = Vec::new();
        for z in first[2]..last[2] {
            for (y, x) in (first[1]..last[1]).flat_map(|y| (first[0]..last[0]).map(move |x| (y, x)))
            {
                let at = [x, y, z];
                let cells = |a: usize, from, to: usize| -> usize {
                    whole.widths[a][from..to].iter().map(Vec::len).sum()
                };
                members.push(Member {
                    rank: whole.rank_of(at),
                    first: std::array::from_fn(|a| cells(a, first[a], at[a])),
                    n: std::array::from_fn(|a| cells(a, at[a], at[a] + 1)),
                });
            }
        }
        let here = session.rank() == root;
        members.retain(|member| here || member.rank == session.rank());
        let faces = |member: &Member| -> usize {
            whole.axes * member.n.map(|n| n + 1).iter().product::<usize>()
        };
        let merge = Merge {
            buffer: vec![0.0; members.iter().map(faces).max().unwrap_or(0)],
            session: session.clone(),
            root,
            members,
        };
        (merge, here.then_some(merged))
    }

    /// Brings the faces of all members' `level` to the one `whole`, on the rank that has it.
    /// Collective among the members.
    pub fn bring_faces(&mut self, level: &Level, whole: Option<&mut Level>) -> Result<()> {
        let Merge { session, root, members, buffer } = self;
        let axes = level.lattice.axes;
        let wide = |member: &Member, axis: usize| -> [usize; 3] {
            std::array::from_fn(|a| member.n[a] + usize::from(a == axis))
        };
        let Some(whole) = whole else {
            let mut at = 0;
            for axis in 0..axes {
                let n = wide(&members[0], axis);
                take(&level.g[axis], &level.lattice, [0; 3], n, &mut buffer[at..]);
                at += n.iter().product::<usize>();
            }
            return session.swap(&buffer[..at], Some(*root), &mut [], None);
        };
        for member in members.iter() {
            if member.rank == *root {
                for axis in 0..axes {
                    let from = &level.g[axis];
                    let to = &mut whole.g[axis];
                    let n = wide(member, axis);
                    copy(from, &level.lattice, to, &whole.lattice, member.first, n);
                }
                continue;
            }
            let count = (0..axes).map(|axis| wide(member, axis).iter().product::<usize>()).sum();
            session.swap(&[], None, &mut buffer[..count], Some(member.rank))?;
            let mut at = 0;
            for axis in 0..axes {
                let n = wide(member, axis);
                put(&buffer[at..], &mut whole.g[axis], &whole.lattice, member.first, n);
                at += n.iter().product::<usize>();
            }
        }
        Ok(())
    }

    /// Lets the members know whether the rank that goes on has failed. Collective among them.
    ///
    /// # Errors
    /// On all of them, when it has.
    pub fn agree(&self, built: Result<()>) -> Result<()> {
        let mut failed = [Single::from(u8::from(built.is_err()))];
        if self.session.rank() != self.root {
            self.session.swap(&[], None, &mut failed, Some(self.root))?;
            let alike = "the coarsest level of the multigrid is singular: see rank 0";
            return if failed[0] == 0.0 { Ok(()) } else { Err(Error::Run(alike.into())) };
        }
        for member in self.members.iter().filter(|member| member.rank != self.root) {
            self.session.swap(&failed, Some(member.rank), &mut [], None)?;
        }
        built
    }

    /// Brings b of all members' `level` to the one `whole`. Collective among them.
    pub fn bring_b(&mut self, level: &Level, whole: Option<&mut Level>) -> Result<()> {
        let Merge { session, root, members, buffer } = self;
        let Some(whole) = whole else {
            let n = members[0].n;
            let buffer = &mut buffer[..n.iter().product()];
            take(&level.b, &level.lattice, [0; 3], n, buffer);
            return session.swap(buffer, Some(*root), &mut [], None);
        };
        for member in members.iter() {
            if member.rank == *root {
                let to = &mut whole.b;
                copy(&level.b, &level.lattice, to, &whole.lattice, member.first, member.n);
                continue;
            }
            let buffer = &mut buffer[..member.n.iter().product()];
            session.swap(&[], None, buffer, Some(member.rank))?;
            put(buffer, &mut whole.b, &whole.lattice, member.first, member.n);
        }
        Ok(())
    }

    /// Brings x of the one `whole` back to all members' `level`. Collective among them.
    pub fn take_x(&mut self, level: &mut Level, whole: Option<&Level>) -> Result<()> {
        let Merge { session, root, members, buffer } = self;
        for member in members.iter() {
            let own = member.rank == session.rank();
            let buffer = &mut buffer[..member.n.iter().product()];
            match whole {
                Some(whole) => take(&whole.x, &whole.lattice, member.first, member.n, buffer),
                None => session.swap(&[], None, buffer, Some(*root))?,
            }
            match own {
                true => put(buffer, &mut level.x, &level.lattice, [0; 3], member.n),
                false => session.swap(buffer, Some(member.rank), &mut [], None)?,
            }
        }
        Ok(())
    }
}

/// The first places of the rows of a box of `n` from `first` on.
fn rows(lattice: &Lattice, first: [usize; 3], n: [usize; 3]) -> impl Iterator<Item = usize> {
    let lattice = *lattice;
    (0..n[2]).flat_map(move |k| {
        (0..n[1]).map(move |j| lattice.row(first[1] + j, first[2] + k) + first[0])
    })
}

/// Takes a box out of a field.
fn take(field: &[Single], lattice: &Lattice, first: [usize; 3], n: [usize; 3], out: &mut [Single]) {
    for (s, out) in rows(lattice, first, n).zip(out.chunks_exact_mut(n[0])) {
        out.copy_from_slice(&field[s..][..n[0]]);
    }
}

/// Puts a box into a field.
fn put(from: &[Single], field: &mut [Single], lattice: &Lattice, first: [usize; 3], n: [usize; 3]) {
    for (s, from) in rows(lattice, first, n).zip(from.chunks_exact(n[0])) {
        field[s..][..n[0]].copy_from_slice(from);
    }
}

/// Copies a box of `n` from the beginning of a field to `first` in another.
fn copy(
    from: &[Single],
    of: &Lattice,
    to: &mut [Single],
    lattice: &Lattice,
    first: [usize; 3],
    n: [usize; 3],
) {
    for (s, t) in rows(of, [0; 3], n).zip(rows(lattice, first, n)) {
        to[t..][..n[0]].copy_from_slice(&from[s..][..n[0]]);
    }
}
