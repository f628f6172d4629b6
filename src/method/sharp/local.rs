//! The cut bodies that reach this rank; of the others it has nothing.

use super::cut_body::CutBody;
use crate::grid::Grid;
use std::ops::Index;

/// The place of a body that is not here.
const NOWHERE: u32 = u32::MAX;

/// The cut bodies of a rank, by the numbers of the bodies, ascending.
#[derive(Clone, Debug)]
pub struct LocalBodies<const D: usize> {
    bodies: Vec<CutBody<D>>,
    /// Their numbers.
    numbers: Vec<u32>,
    /// Per body of all ranks, its place among these.
    places: Vec<u32>,
    /// The empty cut body of the bodies that are not here.
    nothing: CutBody<D>,
}

impl<const D: usize> LocalBodies<D> {
    /// No cut bodies yet, of `count` bodies on all ranks.
    pub fn none(grid: &Grid<D>, count: usize) -> LocalBodies<D> {
        LocalBodies {
            bodies: Vec::new(),
            numbers: Vec::new(),
            places: vec![NOWHERE; count],
            nothing: CutBody::elsewhere(grid),
        }
    }

    /// Keeps those of the given numbers, which ascend, and makes those that come: only where some
    /// come or go does this allocate.
    pub fn keep(
        &mut self,
        grid: &Grid<D>,
        here: impl ExactSizeIterator<Item = usize> + Clone,
        mut make: impl FnMut(usize) -> CutBody<D>,
    ) {
        if here.clone().eq(self.numbers.iter().map(|k| *k as usize)) {
            return;
        }
        let mut old = std::mem::take(&mut self.bodies);
        self.bodies.reserve(here.len());
        for k in here.clone() {
            let kept = old.get_mut(self.places[k] as usize);
            self.bodies.push(
                kept.map_or_else(
                    || make(k),
                    |kept| std::mem::replace(kept, CutBody::elsewhere(grid)),
                ),
            );
        }
        self.numbers.iter().for_each(|k| self.places[*k as usize] = NOWHERE);
        self.numbers.clear();
        self.numbers.extend(here.map(|k| k as u32));
        (0..).zip(&self.numbers).for_each(|(place, k)| self.places[*k as usize] = place);
    }

    /// Takes cut bodies over from other ones, where there are none yet; by the number of a body
    /// there, its number here, if it is taken.
    pub fn take_over(&mut self, others: LocalBodies<D>, numbers: &[Option<usize>]) {
        for (k, cut) in others.numbers.iter().zip(others.bodies) {
            let Some(k) = numbers[*k as usize] else { continue };
            self.places[k] = self.bodies.len() as u32;
            self.numbers.push(k as u32);
            self.bodies.push(cut);
        }
    }

    /// Number of bodies on all ranks.
    pub fn count(&self) -> usize {
        self.places.len()
    }

    /// The cut bodies of this rank.
    pub fn iter(&self) -> std::slice::Iter<'_, CutBody<D>> {
        self.bodies.iter()
    }

    /// The cut bodies of this rank, to be changed.
    pub fn iter_mut(&mut self) -> std::slice::IterMut<'_, CutBody<D>> {
        self.bodies.iter_mut()
    }

    /// The cut bodies of this rank, one after the other.
    pub fn as_mut_slice(&mut self) -> &mut [CutBody<D>] {
        &mut self.bodies
    }

    /// The cut bodies of this rank, with their numbers.
    pub fn each(&self) -> impl Iterator<Item = (usize, &CutBody<D>)> + Clone {
        self.numbers.iter().map(|k| *k as usize).zip(&self.bodies)
    }

    /// The cut bodies of this rank, with their numbers, to be changed.
    pub fn each_mut(&mut self) -> impl Iterator<Item = (usize, &mut CutBody<D>)> {
        self.numbers.iter().map(|k| *k as usize).zip(&mut self.bodies)
    }
}

/// A body by its number: of one that is not here, nothing.
impl<const D: usize> Index<usize> for LocalBodies<D> {
    type Output = CutBody<D>;

    fn index(&self, k: usize) -> &CutBody<D> {
        self.bodies.get(self.places[k] as usize).unwrap_or(&self.nothing)
    }
}
