//! Sums over the ranks of the numbers of each group of modes that lies on several.

use crate::Result;
use crate::petsc::Session;
use crate::sharing::{Messages, Sharing};

/// The groups that may have faces on more than one rank: the others need nobody else's numbers.
pub(super) struct Shared {
    session: Session,
    groups: Sharing,
    messages: Messages,
}

impl Shared {
    /// Shares nothing yet.
    pub fn new(session: &Session) -> Shared {
        let groups = Sharing::new(session.rank());
        Shared { session: session.clone(), groups, messages: Messages::default() }
    }

    /// Takes the bodies that ranks share, which the groups from 0 are of; those after the first
    /// `bodies` are of the bodies that are `turning`, ascending.
    pub fn set(&mut self, shared: &Sharing, bodies: usize, turning: &[u32]) {
        self.groups.set(shared.pairs().iter().flat_map(|(rank, body)| {
            let turn = turning.binary_search(body).ok().map(|place| (bodies + place) as u32);
            std::iter::once(*body).chain(turn).map(|group| (*rank, group))
        }));
    }

    /// Sums the `width` numbers of each such group over its ranks, zero where a rank has nothing of
    /// it. Collective.
    pub fn sum(&mut self, width: usize, numbers: &mut [f64]) -> Result<()> {
        let Shared { session, groups, messages } = self;
        groups.sum(session, messages, width, |group, take| {
            take(&mut numbers[width * group..][..width]);
        })
    }
}
