//! Bodies that lie on several ranks: their numbers go between these ranks only.
//!
//! ```text
//!   +-----+-----+-----+    each rank tells those around it, as far as a body reaches, which bodies
//!   |     |   o |     |     it has; of what both have it sends its part of a sum and gets theirs,
//!   |   o | here|     |     which are added in the order of the ranks: the same bits everywhere
//!   |     |   o | o   |
//!   +-----+-----+-----+
//! ```

use super::super::whole::Whole;
use crate::Result;
use crate::petsc::Session;

/// A rank with which this one may share bodies.
#[derive(Default)]
struct Peer {
    rank: usize,
    /// The groups that it has, and those of them that are here too, in their order.
    theirs: Vec<f64>,
    common: Vec<u32>,
    /// Its part of a sum.
    part: Vec<f64>,
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
    /// By rank.
    peers: Vec<Peer>,
    /// To which peer a message goes and from which one comes at the same time.
    directions: Vec<[Option<usize>; 2]>,
    /// All of them, and scratch: this rank's parts, and what is sent.
    groups: Vec<u32>,
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
            groups: Vec::new(),
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
        let [x, y, z] = std::array::from_fn(offsets);
        let all = z.iter().flat_map(|c| y.iter().flat_map(|b| x.iter().map(|a| [*a, *b, *c])));
        let pairs: Vec<_> = all
            .filter(|d| *d != [0; 3])
            .map(|d| [self.rank_at(d), self.rank_at(d.map(|d| -d))])
            .collect();
        let mut known: Vec<usize> = pairs.iter().flatten().copied().flatten().collect();
        known.sort_unstable();
        known.dedup();
        let index = |rank: Option<usize>| rank.and_then(|rank| known.binary_search(&rank).ok());
        self.directions = pairs.iter().map(|pair| pair.map(index)).collect();
        self.peers = known.into_iter().map(|rank| Peer { rank, ..Peer::default() }).collect();
    }

    /// The rank so many places away.
    fn rank_at(&self, offset: [isize; 3]) -> Option<usize> {
        let mut rank = 0;
        for a in (0..3).rev() {
            let (n, to) = (self.ranks[a] as isize, self.at[a] as isize + offset[a]);
            let to = if self.periodic[a] { to.rem_euclid(n) } else { to };
            rank = rank * self.ranks[a] + (0..n).contains(&to).then_some(to as usize)?;
        }
        Some(rank)
    }

    /// Finds which of the groups `here`, in their order, lie on other ranks too. Collective.
    pub fn find(&mut self, here: &[u32]) -> Result<()> {
        if self.reach.is_none() {
            self.set_reach([f64::INFINITY; 3]);
        }
        let Shared { session, peers, directions, groups, send, .. } = self;
        send.clear();
        send.extend(here.iter().map(|group| f64::from(*group)));
        for [to, from] in directions.iter() {
            let rank = |peer: &Option<usize>| peer.map(|peer| peers[peer].rank);
            let (to, from_rank, mut count) = (rank(to), rank(from), [0.0]);
            session.swap(&[send.len() as f64], to, &mut count, from_rank)?;
            let mut nothing = Vec::new();
            let theirs = from.map_or(&mut nothing, |from| &mut peers[from].theirs);
            theirs.resize(count[0] as usize, 0.0);
            let (to, from) =
                (to.filter(|_| !send.is_empty()), from_rank.filter(|_| !theirs.is_empty()));
            session.swap(send, to, theirs, from)?;
        }
        groups.clear();
        for peer in peers {
            let Peer { theirs, common, .. } = peer;
            common.clear();
            let both = |group: &&u32| {
                theirs.binary_search_by(|other| other.total_cmp(&f64::from(**group))).is_ok()
            };
            common.extend(here.iter().filter(both));
            groups.extend_from_slice(common);
        }
        groups.sort_unstable();
        groups.dedup();
        Ok(())
    }

    /// Sums the `width` numbers of each such group over its ranks. Collective.
    pub fn sum(&mut self, width: usize, numbers: &mut [f64]) -> Result<()> {
        let Shared { session, peers, directions, groups, own, send, .. } = self;
        let of = |group: &u32| width * *group as usize..width * (*group as usize + 1);
        for [to, from] in directions.iter() {
            send.clear();
            if let Some(to) = to {
                peers[*to].common.iter().for_each(|g| send.extend_from_slice(&numbers[of(g)]));
            }
            let to = to.map(|to| peers[to].rank).filter(|_| !send.is_empty());
            let Some(peer) = from.map(|from| &mut peers[from]) else {
                session.swap(send, to, &mut [], None)?;
                continue;
            };
            peer.part.resize(width * peer.common.len(), 0.0);
            let from = (!peer.part.is_empty()).then_some(peer.rank);
            session.swap(send, to, &mut peer.part, from)?;
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
        let before = peers.partition_point(|peer| peer.rank < session.rank());
        peers[..before].iter().for_each(|peer| add(&peer.common, &peer.part));
        add(groups, own);
        peers[before..].iter().for_each(|peer| add(&peer.common, &peer.part));
        Ok(())
    }
}
