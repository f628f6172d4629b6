//! The modes of free bodies in groups, three at most: the motion of each body along the axes, and
//! then, of the bodies that pressure turns, their turning.

use super::super::frame::Frame;
use super::ModeFace;
use std::f64::consts::PI;

/// The groups of all bodies, the same on every rank.
#[derive(Default)]
pub(super) struct Groups {
    pub axes: usize,
    /// Number of bodies: the groups from this number on are of bodies that turn.
    pub bodies: usize,
    /// Weights of the modes, by group.
    pub weights: Vec<[f64; 3]>,
    /// The body that each group is of.
    pub owner: Vec<u32>,
    /// The cells that each body fills, by axis, and nothing for its turning: three numbers a group,
    /// summed over the ranks that have it.
    pub volumes: Vec<f64>,
}

impl Groups {
    /// Takes the weights, times `scale`, of all bodies and of those that are `turning`.
    pub fn set(&mut self, weights: &[f64], turning: &[u32], scale: f64) {
        let Groups { axes, .. } = *self;
        self.bodies = (weights.len() / axes).saturating_sub(turning.len());
        self.weights.clear();
        self.weights.extend(
            weights
                .chunks(axes)
                .map(|w| std::array::from_fn(|a| w.get(a).map_or(0.0, |w| w * scale))),
        );
        self.owner.clear();
        self.owner.extend((0..self.bodies as u32).chain(turning.iter().copied()));
        self.volumes.clear();
        self.volumes.resize(3 * self.weights.len(), 0.0);
    }

    /// Whether these numbers are no modes of the groups.
    pub fn are_unsound(
        &self,
        frame: &Frame,
        weights: &[f64],
        covered: &[ModeFace],
        turning: &[u32],
    ) -> bool {
        let Groups { axes, bodies, .. } = *self;
        let stored = frame.stored.iter().product::<usize>();
        let mut unsound = !weights.len().is_multiple_of(axes)
            || weights.iter().any(|w| !w.is_finite() || *w < 0.0);
        unsound |=
            turning.len() > weights.len() / axes || turning.iter().any(|k| *k as usize >= bodies);
        unsound |= covered.iter().any(|e| {
            let mode = e.mode as usize;
            let axis = e.axis as usize;
            let moves = axis == mode % axes && e.part > 0.0;
            let known = mode < weights.len() && axis < axes && (e.face as usize) < stored;
            !(known && e.part.is_finite() && (moves || mode / axes >= bodies))
        });
        unsound
    }

    /// The largest over all bodies of a weight times the cells that they fill and those across
    /// them.
    pub fn lightest(&self) -> f64 {
        let of_body = |(v, w): (&f64, &f64)| v * w * self.cells_across(*v);
        self.volumes.iter().zip(self.weights.iter().flatten()).map(of_body).fold(0.0, f64::max)
    }

    /// The largest volume of all bodies here (cells).
    pub fn largest(&self) -> f64 {
        self.volumes.iter().copied().fold(0.0, f64::max)
    }

    /// Cells across the body of a group.
    pub fn across(&self, group: usize) -> f64 {
        let volumes = &self.volumes[3 * group..][..3];
        self.cells_across(volumes.iter().fold(0.0f64, |most, v| most.max(*v)))
    }

    /// Cells across a disc or sphere that fills `volume` cells.
    pub fn cells_across(&self, volume: f64) -> f64 {
        if self.axes == 2 { (volume * 4.0 / PI).sqrt() } else { (volume * 6.0 / PI).cbrt() }
    }
}
