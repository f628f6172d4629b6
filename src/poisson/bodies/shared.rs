//! Bodies that lie on several ranks: their numbers go between these ranks only.
//!
//! ```text
//!   +-----+-----+-----+     each rank tells those around it, as far as a body reaches, which it
//!   |     |   o |     |     has; a sum over a body's ranks goes axis by axis: first along x
//!   |   o | here|     |     through the columns that have any of it, then along y, then along z,
//!   |     |   o | o   |     each in the order of the ranks: the same bits everywhere
//!   +-----+-----+-----+
//! ```
//! A rank that has nothing of a body passes sums on where the body lies on both sides of a corner.
//! Two messages an axis are enough where bodies are smaller than ranks' boxes.

use super::super::whole::Whole;
use crate::Result;
use crate::petsc::Session;

/// A rank that may have bodies of this one.
#[derive(Default)]
struct Peer {
    rank: usize,
    at: [usize; 3],
    /// The groups that it has, in their order.
    theirs: Vec<f64>,
}

/// A rank on the same line along an axis.
#[derive(Default)]
struct Partner {
    rank: usize,
    /// Its place along the axis.
    at: usize,
    /// The groups whose sums go through both.
    common: Vec<u32>,
    /// Its part of a sum.
    part: Vec<f64>,
}

/// To whom, by its number in a list, a message goes, and from whom one comes at the same time.
type Direction = [Option<usize>; 2];

/// A line of ranks along an axis.
#[derive(Default)]
struct Line {
    /// By their place.
    partners: Vec<Partner>,
    directions: Vec<Direction>,
    /// The groups of all of them.
    groups: Vec<u32>,
}

/// The groups that have faces on more than one rank: the others need nobody else's numbers.
pub(super) struct Shared {
    session: Session,
    /// Ranks and cells of the narrowest of their boxes along each axis, and this rank's place.
    ranks: [usize; 3],
    narrowest: [usize; 3],
    at: [usize; 3],
    periodic: [bool; 3],
    /// How many ranks away along each axis the same body may lie.
    reach: Option<[usize; 3]>,
    /// By rank, and how messages to all of them go.
    peers: Vec<Peer>,
    directions: Vec<Direction>,
    lines: [Line; 3],
    /// Scratch: groups and who has them, by its number among the peers; this rank's parts of a sum,
    /// and what is sent.
    owners: Vec<(u32, u32)>,
    own: Vec<f64>,
    send: Vec<f64>,
}

impl Shared {
    /// Nothing yet, on a grid that is divided so.
    pub fn new(session: &Session, whole: &Whole) -> Shared {
        let cells = |a: usize| whole.widths[a].iter().map(Vec::len).min().unwrap_or(1);
        Shared {
            session: session.clone(),
            ranks: std::array::from_fn(|a| whole.widths[a].len()),
            narrowest: std::array::from_fn(cells),
            at: whole.at,
            periodic: whole.periodic,
            reach: None,
            peers: Vec::new(),
            directions: Vec::new(),
            lines: Default::default(),
            owners: Vec::new(),
            own: Vec::new(),
            send: Vec::new(),
        }
    }

    /// Takes how many cells a body spans at most along each axis; the same on every rank.
    pub fn set_reach(&mut self, cells: [f64; 3]) {
        let reach = std::array::from_fn(|a| {
            let boxes = (cells[a] / self.narrowest[a] as f64).ceil();
            boxes.min(self.ranks[a] as f64 - 1.0).max(0.0) as usize
        });
        if self.reach == Some(reach) {
            return;
        }
        self.reach = Some(reach);
        let offsets = |a: usize| -> Vec<isize> {
            let (n, most) = (self.ranks[a] as isize, reach[a] as isize);
            match self.periodic[a] {
                true => (0..n).filter(|d| *d.min(&(n - d)) <= most).collect(),
                false => (-most..=most).collect(),
            }
        };
        let [x, y, z]: [Vec<isize>; 3] = std::array::from_fn(offsets);
        let all = z.iter().flat_map(|c| y.iter().flat_map(|b| x.iter().map(|a| [*a, *b, *c])));
        let away: Vec<_> = all.filter(|d| *d != [0; 3]).collect();
        let back = |d: &[isize; 3]| d.map(|d| -d);
        let pairs: Vec<_> = away.iter().map(|d| [self.place(*d), self.place(back(d))]).collect();
        let known = sorted(pairs.iter().flatten().flatten().map(|at| (self.rank_at(*at), *at)));
        let number = |at: Option<[usize; 3]>| {
            at.and_then(|at| known.binary_search_by_key(&self.rank_at(at), |peer| peer.0).ok())
        };
        self.directions = pairs.iter().map(|pair| pair.map(number)).collect();
        self.lines = std::array::from_fn(|a| {
            let along = |d: &&[isize; 3]| (0..3).all(|b| b == a || d[b] == 0);
            let pairs = away.iter().filter(along).map(|d| [self.place(*d), self.place(back(d))]);
            let pairs: Vec<_> = pairs.collect();
            let known =
                sorted(pairs.iter().flatten().flatten().map(|at| (at[a], self.rank_at(*at))));
            let number = |at: Option<[usize; 3]>| {
                at.and_then(|at| known.binary_search_by_key(&at[a], |partner| partner.0).ok())
            };
            let partner = |(at, rank): &(usize, usize)| Partner {
                rank: *rank,
                at: *at,
                ..Partner::default()
            };
            Line {
                directions: pairs.iter().map(|pair| pair.map(number)).collect(),
                partners: known.iter().map(partner).collect(),
                groups: Vec::new(),
            }
        });
        self.peers =
            known.into_iter().map(|(rank, at)| Peer { rank, at, theirs: Vec::new() }).collect();
    }

    /// The place of the rank so many places away, if there is one.
    fn place(&self, offset: [isize; 3]) -> Option<[usize; 3]> {
        let mut place = [0; 3];
        for a in 0..3 {
            let (n, to) = (self.ranks[a] as isize, self.at[a] as isize + offset[a]);
            let to = if self.periodic[a] { to.rem_euclid(n) } else { to };
            place[a] = (0..n).contains(&to).then_some(to as usize)?;
        }
        Some(place)
    }

    /// The rank of a place.
    fn rank_at(&self, at: [usize; 3]) -> usize {
        at[0] + self.ranks[0] * (at[1] + self.ranks[1] * at[2])
    }

    /// Finds which of the groups `here`, in their order, lie on other ranks too, and through whom
    /// their sums go. Collective.
    pub fn find(&mut self, here: &[u32]) -> Result<()> {
        if self.reach.is_none() {
            self.set_reach([f64::INFINITY; 3]);
        }
        if self.peers.is_empty() {
            return Ok(());
        }
        let Shared { session, peers, directions, send, .. } = self;
        send.clear();
        send.extend(here.iter().map(|group| f64::from(*group)));
        for [to, from] in directions.iter() {
            let rank = |peer: &Option<usize>| peer.map(|peer| peers[peer].rank);
            let (to, from_rank, mut count) = (rank(to), rank(from), [0.0]);
            session.swap(&[send.len() as f64], to, &mut count, from_rank)?;
            let mut nothing = Vec::new();
            let theirs = from.map_or(&mut nothing, |from| &mut peers[from].theirs);
            theirs.resize(count[0] as usize, 0.0);
            let to = to.filter(|_| !send.is_empty());
            session.swap(send, to, theirs, from_rank.filter(|_| count[0] > 0.0))?;
        }
        self.find_partners(here);
        Ok(())
    }

    /// Who takes part in the sum of each group, from what all peers have told.
    fn find_partners(&mut self, here: &[u32]) {
        let Shared { at: place, peers, lines, owners, .. } = self;
        let me = peers.len() as u32;
        owners.clear();
        owners.extend(here.iter().map(|group| (*group, me)));
        for (peer, number) in peers.iter().zip(0..) {
            owners.extend(peer.theirs.iter().map(|group| (*group as u32, number)));
        }
        owners.sort_unstable();
        for line in lines.iter_mut() {
            line.groups.clear();
            line.partners.iter_mut().for_each(|partner| partner.common.clear());
        }
        for sharing in owners.chunk_by(|a, b| a.0 == b.0).filter(|sharing| sharing.len() > 1) {
            let along = |owner: u32, a: usize| {
                if owner == me { place[a] } else { peers[owner as usize].at[a] }
            };
            let has = |a: usize, at: usize| sharing.iter().any(|(_, owner)| along(*owner, a) == at);
            // Those whose place along every axis is one of some rank that has it.
            if !(0..3).all(|a| has(a, place[a])) {
                continue;
            }
            for (a, line) in lines.iter_mut().enumerate() {
                let mut any = false;
                for partner in line.partners.iter_mut().filter(|partner| has(a, partner.at)) {
                    partner.common.push(sharing[0].0);
                    any = true;
                }
                line.groups.extend(any.then_some(sharing[0].0));
            }
        }
    }

    /// Sums the `width` numbers of each such group over its ranks, zero where a rank has nothing of
    /// it. Collective.
    pub fn sum(&mut self, width: usize, numbers: &mut [f64]) -> Result<()> {
        let Shared { session, at, lines, own, send, .. } = self;
        for (a, line) in lines.iter_mut().enumerate() {
            line.sum(session, (width, at[a]), numbers, (own, send))?;
        }
        Ok(())
    }
}

impl Line {
    /// Sums along the line, on which this rank has the place `at`. Collective.
    fn sum(
        &mut self,
        session: &Session,
        (width, at): (usize, usize),
        numbers: &mut [f64],
        (own, send): (&mut Vec<f64>, &mut Vec<f64>),
    ) -> Result<()> {
        let Line { partners, directions, groups } = self;
        let of = |group: &u32| width * *group as usize..width * (*group as usize + 1);
        for [to, from] in directions.iter() {
            send.clear();
            if let Some(to) = to {
                partners[*to].common.iter().for_each(|g| send.extend_from_slice(&numbers[of(g)]));
            }
            let to = to.map(|to| partners[to].rank).filter(|_| !send.is_empty());
            let Some(partner) = from.map(|from| &mut partners[from]) else {
                session.swap(send, to, &mut [], None)?;
                continue;
            };
            partner.part.resize(width * partner.common.len(), 0.0);
            let from = (!partner.part.is_empty()).then_some(partner.rank);
            session.swap(send, to, &mut partner.part, from)?;
        }
        own.clear();
        for group in groups.iter() {
            own.extend_from_slice(&numbers[of(group)]);
            numbers[of(group)].fill(0.0);
        }
        let mut add = |groups: &[u32], parts: &[f64]| {
            for (group, part) in groups.iter().zip(parts.chunks_exact(width)) {
                numbers[of(group)].iter_mut().zip(part).for_each(|(n, p)| *n += p);
            }
        };
        let before = partners.partition_point(|partner| partner.at < at);
        partners[..before].iter().for_each(|partner| add(&partner.common, &partner.part));
        add(groups, own);
        partners[before..].iter().for_each(|partner| add(&partner.common, &partner.part));
        Ok(())
    }
}

/// Each pair once, by its first number.
fn sorted<T: Copy + Ord>(pairs: impl Iterator<Item = (usize, T)>) -> Vec<(usize, T)> {
    let mut pairs: Vec<_> = pairs.collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}
