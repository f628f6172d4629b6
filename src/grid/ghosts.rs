//! Ghosts across one axis, set from the cells beside a boundary: the rules of
//! [`boundary`](super::boundary), applied to the rows of a field.

use super::{BoundaryKind, GHOSTS, Grid};

/// Layout in a field of the layers across one axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Planes {
    outer: usize,
    pub stored: usize,
    pub inner: usize,
    local: usize,
    pub ghosts: usize,
    /// Numbers of the first row of cells and of the row after the last along each axis after this
    /// one, and of the rows stored.
    after: [(usize, usize, usize); 2],
}

/// Factors of the three nearest cells in the first ghost of a velocity along a boundary where it is
/// given.
const PARABOLA: [f64; 3] = [-1.4, -0.2, 0.2];

/// The first ghost of a velocity that is `given` at the boundary, from the three nearest cells: the
/// share `bend` of the parabola through all, and the rest of the straight line.
#[inline(always)]
fn bent(given: f64, bend: f64, [near, next, third]: [f64; 3]) -> f64 {
    let [a, b, c] = PARABOLA;
    let parabola = (1.0 - a - b - c) * given + (a * near + b * next + c * third);
    let straight = 2.0 * given - near;
    straight + bend * (parabola - straight)
}

/// Rule of a ghost: the sum of a given value, if there is one, and a multiple of a cell's.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rule<'a> {
    /// The value at the boundary, for each position on the face, which counts twice.
    given: Option<&'a [f64]>,
    factor: f64,
    /// Whether the cell is always the nearest one, and not the mirrored one.
    nearest: bool,
    /// Share of a parabola that the first ghost continues, for each position on the face.
    bend: Option<&'a [f64]>,
    /// Most layers that anything reads: the stencils of the flow alone where the velocity is given,
    /// since no image point lies beyond the surface nearest to a body along its normal. A plane of
    /// symmetry may pass through a body.
    most: usize,
}

impl<'a> Rule<'a> {
    /// Rule of a field that is mirrored, times a factor.
    pub fn mirrored(factor: f64) -> Rule<'a> {
        Rule { given: None, factor, nearest: false, bend: None, most: usize::MAX }
    }

    /// Rule of a field that has these values at the boundary.
    pub fn of_values(values: &'a [f64]) -> Rule<'a> {
        Rule { given: Some(values), ..Rule::mirrored(-1.0) }
    }

    /// Rule of a component of the velocity on a boundary normal to an axis, with the share `bend`
    /// of the parabola along it.
    pub fn of_velocity<const D: usize>(
        boundary: &'a BoundaryKind<D>,
        bend: &'a [f64],
        component: usize,
        axis: usize,
    ) -> Rule<'a> {
        match boundary {
            BoundaryKind::Velocity(value) => {
                let bend = (component != axis && !bend.is_empty()).then_some(bend);
                Rule { given: Some(&value[component]), bend, most: GHOSTS, ..Rule::mirrored(-1.0) }
            }
            BoundaryKind::Slip => Rule::mirrored(if component == axis { -1.0 } else { 1.0 }),
            BoundaryKind::Outflow => Rule { nearest: true, ..Rule::mirrored(1.0) },
        }
    }
}

impl Planes {
    /// The layers across an axis of a grid.
    pub fn new<const D: usize>(grid: &Grid<D>, axis: usize) -> Planes {
        let inner = grid.stride[axis];
        let total: usize = grid.stored.iter().product();
        let after = [axis + 1, axis + 2].map(|b| {
            if b < D {
                (grid.ghosts, grid.ghosts + grid.local[b], grid.stored[b])
            } else {
                (0, 1, 1)
            }
        });
        Planes {
            after,
            outer: total / (inner * grid.stored[axis]),
            stored: grid.stored[axis],
            inner,
            local: grid.local[axis],
            ghosts: grid.ghosts,
        }
    }

    /// The blocks whose ghosts count: those of other axes' ghosts are set with these axes, which
    /// come later.
    fn blocks(&self) -> impl Iterator<Item = usize> + use<> {
        let [(first, last, stored), (low, high, _)] = self.after;
        (low..high).flat_map(move |outer| (first..last).map(move |block| outer * stored + block))
    }

    /// Sets the first `layers` of ghosts of a field on the sides that have a rule.
    pub fn set_ghosts(&self, layers: usize, rules: [Option<Rule>; 2], field: &mut [f64]) {
        let length = self.stored * self.inner;
        for block in self.blocks() {
            let field = &mut field[block * length..][..length];
            if self.inner > 1 {
                self.set_slabs(layers, &rules, block, field);
                continue;
            }
            // Both ends of a row while it is at hand.
            if let Some(rule) = &rules[0] {
                self.set_end::<0>(layers, rule, block, field);
            }
            if let Some(rule) = &rules[1] {
                self.set_end::<1>(layers, rule, block, field);
            }
        }
    }

    /// Sets the ghosts at the low (`SIDE` 0) or high (1) end of a row of cells.
    #[inline(always)]
    fn set_end<const SIDE: usize>(
        &self,
        layers: usize,
        rule: &Rule,
        block: usize,
        row: &mut [f64],
    ) {
        let Rule { given, factor, nearest, bend, most } = *rule;
        let layers = layers.min(most);
        let twice = given.map(|given| 2.0 * given[block]);
        let (below, above) = row.split_at_mut(self.ghosts + if SIDE == 0 { 0 } else { self.local });
        let (ghosts, cells) = if SIDE == 0 { (below, &*above) } else { (above, &*below) };
        let count = ghosts.len();
        let last = cells.len() - 1;
        let cell = |depth: usize| cells[if SIDE == 0 { depth } else { last - depth }];
        let ghost = |depth: usize| if SIDE == 0 { count - 1 - depth } else { depth };
        for depth in 0..layers {
            let own = factor * cell(if nearest { 0 } else { depth });
            ghosts[ghost(depth)] = twice.map_or(own, |twice| twice + own);
        }
        if let (Some(bend), Some(given)) = (bend, given) {
            ghosts[ghost(0)] = bent(given[block], bend[block], [cell(0), cell(1), cell(2)]);
        }
    }

    /// Sets the ghosts of a block whose layers are slabs of cells.
    fn set_slabs(&self, layers: usize, rules: &[Option<Rule>; 2], block: usize, field: &mut [f64]) {
        let low = self.ghosts;
        let high = self.ghosts + self.local;
        let inner = self.inner;
        for (side, rule) in rules.iter().enumerate() {
            let Some(Rule { given, factor, nearest, bend, most }) = *rule else { continue };
            let given = given.map(|given| &given[block * inner..][..inner]);
            if let (Some(bend), Some(given)) = (bend, given) {
                self.continue_parabola(side, given, &bend[block * inner..][..inner], field);
            }
            for depth in usize::from(bend.is_some())..layers.min(most) {
                let (ghost, mirror) = if side == 0 {
                    (low - 1 - depth, low + depth)
                } else {
                    (high + depth, high - 1 - depth)
                };
                let cell = if nearest { [low, high - 1][side] } else { mirror };
                let (below, above) = field.split_at_mut(ghost.max(cell) * inner);
                let (ghosts, cells) = if side == 0 {
                    (&mut below[ghost * inner..][..inner], &above[..inner])
                } else {
                    (&mut above[..inner], &below[cell * inner..][..inner])
                };
                let pairs = ghosts.iter_mut().zip(cells);
                match given {
                    Some(given) => {
                        pairs.zip(given).for_each(|((g, c), given)| *g = 2.0 * given + factor * c)
                    }
                    None => pairs.for_each(|(g, c)| *g = factor * c),
                }
            }
        }
    }

    /// Sets the first ghosts of a block from the velocity given at the boundary and the three
    /// nearest cells.
    fn continue_parabola(&self, side: usize, given: &[f64], bend: &[f64], field: &mut [f64]) {
        let inner = self.inner;
        let boundary = (self.ghosts + if side == 0 { 0 } else { self.local }) * inner;
        let (below, above) = field.split_at_mut(boundary);
        let row = |cells: &'_ [f64], n: usize| -> std::ops::Range<usize> {
            let from = if side == 0 { n * inner } else { cells.len() - (n + 1) * inner };
            from..from + inner
        };
        let (ghosts, cells): (&mut [f64], &[f64]) =
            if side == 0 { (below, above) } else { (above, below) };
        let ghosts = if side == 0 {
            let from = ghosts.len() - inner;
            &mut ghosts[from..]
        } else {
            &mut ghosts[..inner]
        };
        let [near, next, third] = [0, 1, 2].map(|n| &cells[row(cells, n)]);
        for (i, ((ghost, given), bend)) in ghosts.iter_mut().zip(given).zip(bend).enumerate() {
            *ghost = bent(*given, *bend, [near[i], next[i], third[i]]);
        }
    }

    /// Calls `set(position on the face, boundary face, next face inside)` with a field's indices.
    pub fn for_faces(&self, side: usize, mut set: impl FnMut(usize, usize, usize)) {
        let (face, inside) = if side == 0 {
            (self.ghosts, self.ghosts + 1)
        } else {
            (self.ghosts + self.local, self.ghosts + self.local - 1)
        };
        for block in 0..self.outer {
            for i in 0..self.inner {
                let at = |layer: usize| (block * self.stored + layer) * self.inner + i;
                set(block * self.inner + i, at(face), at(inside));
            }
        }
    }
}
