//! Ghost layers: from neighbours across ranks and periods, and from the condition at the borders of the box.
//!
//! ```text
//!   ghosts 2 1 0 | cells 0 1 2 ...        velocity u_b given:  ghost k = 2 u_b - cell k
//!                ^ border                 no gradient:         ghost k = cell 0
//!                                         mirror:              ghost k = cell k
//! ```

use super::{GHOSTS, Grid, VectorField};
use crate::Result;
use crate::petsc::{Halo, Layout, Session};

/// The condition at one face of the box.
#[derive(Clone, Debug)]
pub enum Border<const D: usize> {
    /// A given velocity (m/s): walls, moving walls, inflows. One value for each stored position of the face, the first
    /// axis of the face fastest.
    Velocity(VectorField<D>),
    /// No flow through, no shear.
    Slip,
    /// No velocity gradient, zero pressure.
    Outflow,
}

/// The conditions at all faces, and the halo exchange.
pub struct Boundaries<const D: usize> {
    /// By axis and side (low, high); `None` where the axis is periodic.
    pub borders: [[Option<Border<D>>; 2]; D],
    halo: Halo,
    /// The faces of the box that this rank's own box reaches.
    here: [[bool; 2]; D],
    planes: [Planes; D],
    /// Layers of ghosts that velocities are given.
    layers: usize,
}

/// How the layers across one axis lie in a field.
#[derive(Clone, Copy, Debug)]
struct Planes {
    outer: usize,
    stored: usize,
    inner: usize,
    local: usize,
    ghosts: usize,
}

impl Planes {
    /// Sets the first `layers` of ghosts of a field to `value(position on the face, nearest cell's, mirrored cell's)`.
    fn set_ghosts(&self, side: usize, layers: usize, field: &mut [f64], value: impl Fn(usize, f64, f64) -> f64) {
        let (low, high) = (self.ghosts, self.ghosts + self.local);
        let place =
            |depth: usize| if side == 0 { (low - 1 - depth, low + depth) } else { (high + depth, high - 1 - depth) };
        let (stored, inner) = (self.stored, self.inner);
        for (block, field) in field.chunks_exact_mut(stored * inner).enumerate().take(self.outer) {
            if inner == 1 {
                let near = field[place(0).1];
                for depth in 0..layers {
                    let (ghost, mirror) = place(depth);
                    field[ghost] = value(block, near, field[mirror]);
                }
                continue;
            }
            let (below, above) = field.split_at_mut(if side == 0 { low * inner } else { high * inner });
            let (ghosts, cells) = if side == 0 { (below, above) } else { (above, below) };
            let layer = |number: usize| if side == 0 { number - low } else { number } * inner;
            let near = &cells[layer(place(0).1)..][..inner];
            for depth in 0..layers {
                let (ghost, mirror) = place(depth);
                let ghost = if side == 0 { ghost } else { ghost - high } * inner;
                let ghosts = ghosts[ghost..][..inner].iter_mut();
                let cells = near.iter().zip(&cells[layer(mirror)..][..inner]);
                for (at, (ghost, (near, mirror))) in ghosts.zip(cells).enumerate() {
                    *ghost = value(block * inner + at, *near, *mirror);
                }
            }
        }
    }

    /// Calls `set(position on the face, border face, next face inside)` with a field's indices.
    fn for_faces(&self, side: usize, mut set: impl FnMut(usize, usize, usize)) {
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

impl<const D: usize> Boundaries<D> {
    /// The conditions `borders` on `grid`.
    pub fn new(session: &Session, layout: &Layout, grid: &Grid<D>, borders: [[Option<Border<D>>; 2]; D]) -> Self {
        let planes = std::array::from_fn(|a| {
            let inner = grid.stride[a];
            let total: usize = grid.stored.iter().product();
            Planes {
                outer: total / (inner * grid.stored[a]),
                stored: grid.stored[a],
                inner,
                local: grid.local[a],
                ghosts: grid.ghosts,
            }
        });
        let here = std::array::from_fn(|a| [0, 1].map(|s| grid.at_border(a, s)));
        Boundaries { borders, halo: Halo::new(session, layout), here, planes, layers: grid.ghosts }
    }

    /// Whether some border fixes the pressure; where none does, the pressure equation is singular.
    pub fn fixes_pressure(&self) -> bool {
        self.borders.iter().flatten().any(|b| matches!(b, Some(Border::Outflow)))
    }

    /// The largest Courant number for `dt = 1` of the velocities that borders prescribe here (1/s).
    pub fn courant_rate(&self, grid: &Grid<D>) -> f64 {
        let here = (0..2 * D).filter_map(|f| self.border(f / 2, f % 2));
        let rates = here.flat_map(|border| {
            let velocity = if let Border::Velocity(v) = border { Some(v) } else { None };
            velocity.into_iter().flat_map(|v| (0..v[0].len()).map(|k| (0..D).map(|a| v[a][k].abs() / grid.h[a]).sum()))
        });
        rates.fold(0.0, f64::max)
    }

    fn border(&self, axis: usize, side: usize) -> Option<&Border<D>> {
        self.borders[axis][side].as_ref().filter(|_| self.here[axis][side])
    }

    /// Fills the ghosts of a velocity. Collective.
    pub fn fill_velocity(&mut self, u: &mut VectorField<D>) -> Result<()> {
        let layers = self.layers;
        for axis in 0..D {
            for (component, field) in u.iter_mut().enumerate() {
                self.halo.exchange(axis, layers, field)?;
                for side in [0, 1] {
                    let planes = self.planes[axis];
                    match self.border(axis, side) {
                        None => {}
                        Some(Border::Velocity(value)) => {
                            let value = &value[component];
                            planes.set_ghosts(side, layers, field, |at, _, mirror| 2.0 * value[at] - mirror);
                        }
                        Some(Border::Slip) => {
                            let sign = if component == axis { -1.0 } else { 1.0 };
                            planes.set_ghosts(side, layers, field, |_, _, mirror| sign * mirror);
                        }
                        Some(Border::Outflow) => planes.set_ghosts(side, layers, field, |_, near, _| near),
                    }
                }
            }
        }
        Ok(())
    }

    /// Says whether anything reads a velocity's ghosts beyond those of the fifth-order stencils. To be the same on all ranks.
    pub fn set_velocity_layers(&mut self, deep: bool) {
        self.layers = if deep { self.planes[0].ghosts } else { GHOSTS };
    }

    /// Fills the ghosts of a pressure, next to its cells: no gradient at borders with a given velocity, zero at outflows.
    /// Collective.
    pub fn fill_pressure(&mut self, p: &mut [f64]) -> Result<()> {
        self.fill_even(p, -1.0)
    }

    /// Fills the ghosts of a property of the mixture (density, viscosity), next to its cells: mirrored at every border.
    /// Collective.
    pub fn fill_property(&mut self, field: &mut [f64]) -> Result<()> {
        self.fill_even(field, 1.0)
    }

    fn fill_even(&mut self, field: &mut [f64], at_outflow: f64) -> Result<()> {
        for axis in 0..D {
            self.halo.exchange(axis, 1, field)?;
            for side in [0, 1] {
                let sign = match self.border(axis, side) {
                    None => continue,
                    Some(Border::Outflow) => at_outflow,
                    Some(_) => 1.0,
                };
                self.planes[axis].set_ghosts(side, 1, field, |_, _, mirror| sign * mirror);
            }
        }
        Ok(())
    }

    /// Sets the normal velocity of the border's faces where it is given.
    pub fn set_faces(&self, faces: &mut VectorField<D>) {
        for (axis, face) in faces.iter_mut().enumerate() {
            for side in [0, 1] {
                match self.border(axis, side) {
                    Some(Border::Velocity(v)) => self.planes[axis].for_faces(side, |at, f, _| face[f] = v[axis][at]),
                    Some(Border::Slip) => self.planes[axis].for_faces(side, |_, f, _| face[f] = 0.0),
                    Some(Border::Outflow) | None => {}
                }
            }
        }
    }

    /// Gives closed faces the value of the next face inside, for averages to cells beside them: the pressure's own
    /// condition there (no gradient) would halve the acceleration of the cell.
    pub fn extrapolate_to_closed_faces(&self, faces: &mut VectorField<D>) {
        for (axis, face) in faces.iter_mut().enumerate() {
            for side in [0, 1] {
                if let Some(Border::Velocity(_) | Border::Slip) = self.border(axis, side) {
                    self.planes[axis].for_faces(side, |_, f, inside| face[f] = face[inside]);
                }
            }
        }
    }
}
