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

use super::bodies::Bodies;
use super::lattice::Lattice;
use super::level::{Level, Single};
use super::multigrid::{Multigrid, Tuning};
use super::whole::Whole;
use crate::petsc::Session;
use crate::{Error, Result};

/// The cells of a level from the third on below which ranks merge theirs: a sweep over so many
/// takes as long as a message.
const FEW: usize = 2048;

/// A rank that gives its cells to another, or that other one itself: its first cell and its cells
/// along each axis in what both make.
struct Member {
    rank: usize,
    first: [usize; 3],
    n: [usize; 3],
}

/// The ranks whose cells are merged with this one's, and what follows.
pub(super) struct Merged {
    session: Session,
    /// The rank that goes on.
    root: usize,
    /// On it, all of them; else only this one.
    members: Vec<Member>,
    /// On it, the levels from here on.
    inner: Option<Multigrid>,
    /// There are none on coarse levels.
    bodies: Bodies,
    buffer: Vec<Single>,
}

/// Whether a level on this grid had better be merged.
pub(super) fn is_due(whole: &Whole) -> bool {
    whole.cells() < FEW * whole.parts().iter().product::<usize>()
}

impl Merged {
    /// Merges the level `whole`; `tuning` is that of the levels from here on.
    pub fn new(session: &Session, whole: &Whole, singular: bool, tuning: Tuning) -> Merged {
        // The narrowest boxes are merged first, until there are enough cells for each rank.
        let (mut by, parts) = ([1; 3], whole.parts());
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
        Merged {
            buffer: vec![0.0; members.iter().map(faces).max().unwrap_or(0)],
            inner: here.then(|| Multigrid::new_from(session, merged, singular, tuning, 0)),
            bodies: Bodies::new(session, whole, [0.0; 3]),
            session: session.clone(),
            root,
            members,
        }
    }

    /// Everything that follows from the faces of the `level`. Collective among its ranks.
    ///
    /// # Errors
    /// On all of them, when the coarsest level is singular.
    pub fn rebuild(&mut self, level: &Level) -> Result<()> {
        let Merged { session, root, members, inner, bodies, buffer } = self;
        let axes = level.lattice.axes;
        let wide = |member: &Member, axis: usize| -> [usize; 3] {
            std::array::from_fn(|a| member.n[a] + usize::from(a == axis))
        };
        let mut failed = [0.0 as Single];
        let Some(inner) = inner else {
            let (member, mut at) = (&members[0], 0);
            for axis in 0..axes {
                let n = wide(member, axis);
                take(&level.g[axis], &level.lattice, [0; 3], n, &mut buffer[at..]);
                at += n.iter().product::<usize>();
            }
            session.swap(&buffer[..at], Some(*root), &mut [], None)?;
            session.swap(&[], None, &mut failed, Some(*root))?;
            return match failed[0] == 0.0 {
                true => Ok(()),
                false => Err(Error::Run("the coarsest level of the multigrid is singular".into())),
            };
        };
        let whole = &mut inner.levels[0];
        for member in members.iter() {
            if member.rank == *root {
                for axis in 0..axes {
                    let n = wide(member, axis);
                    let (from, to) = (&level.g[axis], &mut whole.g[axis]);
                    copy((from, &level.lattice), (to, &whole.lattice), member.first, n);
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
        let built = inner.rebuild(bodies, [0.0; 3], 0.0);
        failed[0] = f32::from(u8::from(built.is_err()));
        for member in members.iter().filter(|member| member.rank != *root) {
            session.swap(&failed, Some(member.rank), &mut [], None)?;
        }
        built
    }

    /// So many cycles for the b of the `level`, from x = 0. Collective among its ranks.
    pub fn cycle(&mut self, level: &mut Level, times: usize) -> Result<()> {
        let Merged { session, root, members, inner, bodies, buffer } = self;
        let Some(inner) = inner else {
            let n = members[0].n;
            let buffer = &mut buffer[..n.iter().product()];
            take(&level.b, &level.lattice, [0; 3], n, buffer);
            session.swap(buffer, Some(*root), &mut [], None)?;
            session.swap(&[], None, buffer, Some(*root))?;
            put(buffer, &mut level.x, &level.lattice, [0; 3], n);
            return Ok(());
        };
        let whole = &mut inner.levels[0];
        let others = |member: &&Member| member.rank != *root;
        let size = |member: &Member| member.n.iter().product::<usize>();
        for member in members.iter() {
            if !others(&member) {
                let to = (&mut whole.b[..], &whole.lattice);
                copy((&level.b, &level.lattice), to, member.first, member.n);
                continue;
            }
            let buffer = &mut buffer[..size(member)];
            session.swap(&[], None, buffer, Some(member.rank))?;
            put(buffer, &mut whole.b, &whole.lattice, member.first, member.n);
        }
        for time in 0..times {
            inner.cycle(bodies, time == 0)?;
        }
        let whole = &inner.levels[0];
        for member in members.iter() {
            let count = size(member);
            take(&whole.x, &whole.lattice, member.first, member.n, &mut buffer[..count]);
            match others(&member) {
                true => session.swap(&buffer[..count], Some(member.rank), &mut [], None)?,
                false => put(&buffer[..count], &mut level.x, &level.lattice, [0; 3], member.n),
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
    (from, of): (&[Single], &Lattice),
    (to, lattice): (&mut [Single], &Lattice),
    first: [usize; 3],
    n: [usize; 3],
) {
    for (s, t) in rows(of, [0; 3], n).zip(rows(lattice, first, n)) {
        to[t..][..n[0]].copy_from_slice(&from[s..][..n[0]]);
    }
}
