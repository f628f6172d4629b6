//! Ghost layers: from neighbours across ranks and periods, and from the condition at the boundaries
//! of the box.
//!
//! ```text
//!   ghosts 2 1 0 | cells 0 1 2 ...        velocity u_b given:  ghost k = 2 u_b - cell k
//!                ^ boundary                   along the boundary:
//!              ghost 0 = 2.4 u_b - 1.4 cell 0 - 0.2 cell 1 + 0.2 cell 2
//!                                         no gradient:         ghost k = cell 0
//!                                         mirror:              ghost k = cell k
//! ```
//! The rule along the boundary is exact for a parabola of which every cell has the mean, and so is
//! the flow between two walls. Two cells, or other factors of three, would do; with these diffusion
//! is stable for the steps that it has far from walls. Across the boundary the rule would feed the
//! correction of the face velocities: the flow around a sphere that creeps through a closed box
//! grew. Ghost 0 is as the others where a body is so near that it has one of the cells, with the
//! mixture method, and where bodies move, since that correction then decays slowly: a flow grew in
//! the corners of the box. Where an obstacle covers the boundary there is no shear on it: by the
//! part that is covered, ghost 0 is cell 0.

use super::ghosts::{Planes, Rule};
use super::{GHOSTS, Grid, VectorField};
use crate::Result;
use crate::petsc::{Halo, Layout, Session};
use nalgebra::Vector3;

/// The condition at one side of the box.
#[derive(Clone, Debug)]
pub enum BoundaryKind<const D: usize> {
    /// A given velocity (m/s): walls, moving walls, inflows. One value for each stored position of
    /// the face, the first axis of the face fastest.
    Velocity(VectorField<D>),
    /// No flow through, no shear.
    Slip,
    /// No velocity gradient. The pressure is zero where fluid leaves; where it comes in, as from a
    /// reservoir at rest, `-rho U^2/2` (Bernoulli): at zero pressure what comes in would bring
    /// spurious energy, a jet that feeds itself.
    Outflow,
}

impl<const D: usize> BoundaryKind<D> {
    /// The side `side` (0 low, 1 high) across an axis that gives a velocity (m/s) by place (m); in
    /// 2D what that has along the third axis does not count.
    pub fn given(
        grid: &Grid<D>,
        [axis, side]: [usize; 2],
        velocity: impl Fn(&Vector3<f64>) -> Vector3<f64>,
    ) -> BoundaryKind<D> {
        let places = || places(grid, axis, side);
        let values = |c: usize| places().map(|place| velocity(&place)[c]).collect();
        BoundaryKind::Velocity(std::array::from_fn(values))
    }
}

/// The stored positions (m) of a side, the first axis along it fastest; ghosts beyond it repeat its
/// edge.
fn places<const D: usize>(
    grid: &Grid<D>,
    axis: usize,
    side: usize,
) -> impl Iterator<Item = Vector3<f64>> {
    let positions = grid.stored.iter().product::<usize>() / grid.stored[axis];
    (0..positions).map(move |mut k| {
        let mut place = Vector3::zeros();
        place[axis] = if side == 0 { 0.0 } else { grid.size[axis] };
        for a in (0..D).filter(|a| *a != axis) {
            let i = (k % grid.stored[a] + grid.start[a]) as f64 - grid.ghosts as f64 + 0.5;
            place[a] = (i * grid.h[a]).clamp(0.0, grid.size[a]);
            k /= grid.stored[a];
        }
        place
    })
}

/// A cell at a boundary with its first ghost, and the part of the face between them that an
/// obstacle covers.
struct CoveredSide {
    ghost: usize,
    cell: usize,
    part: f64,
}

/// The conditions at all sides of the box, and the halo exchange.
pub struct Boundaries<const D: usize> {
    /// By axis and side (low, high); `None` where the axis is periodic.
    pub kinds: [[Option<BoundaryKind<D>>; 2]; D],
    /// Pressure at outflows (Pa), by axis and side, one value for each stored position of the face;
    /// empty elsewhere.
    entry: [[Vec<f64>; 2]; D],
    /// Share of the parabola along it that the first ghosts have, by axis and side, one value for
    /// each stored position of the face; empty for none.
    bend: [[Vec<f64>; 2]; D],
    /// The cells whose face on the boundary obstacles cover, by axis.
    covered: [Vec<CoveredSide>; D],
    halo: Halo,
    /// The sides of the box that this rank's own box reaches.
    here: [[bool; 2]; D],
    planes: [Planes; D],
    /// Layers of ghosts that velocities are given.
    layers: usize,
}

impl<const D: usize> Boundaries<D> {
    /// The conditions `kinds` on `grid`, velocities along them by a parabola or as straight
    /// lines.
    pub fn new(
        session: &Session,
        layout: &Layout,
        grid: &Grid<D>,
        kinds: [[Option<BoundaryKind<D>>; 2]; D],
        parabola: bool,
    ) -> Self {
        let planes = std::array::from_fn(|a| Planes::new(grid, a));
        let here = std::array::from_fn(|a| [0, 1].map(|s| grid.at_boundary(a, s)));
        let positions = |axis: usize| grid.stored.iter().product::<usize>() / grid.stored[axis];
        let open =
            |axis: usize, side: usize| matches!(kinds[axis][side], Some(BoundaryKind::Outflow));
        let entry =
            |axis, side| if open(axis, side) { vec![0.0; positions(axis)] } else { Vec::new() };
        let entry = std::array::from_fn(|axis| [0, 1].map(|side| entry(axis, side)));
        let given = |axis: usize, side: usize| {
            parabola && matches!(kinds[axis][side], Some(BoundaryKind::Velocity(_)))
        };
        let bend =
            |axis, side| if given(axis, side) { vec![1.0; positions(axis)] } else { Vec::new() };
        let bend = std::array::from_fn(|axis| [0, 1].map(|side| bend(axis, side)));
        Boundaries {
            kinds,
            entry,
            bend,
            covered: std::array::from_fn(|_| Vec::new()),
            halo: Halo::new(session, layout),
            here,
            planes,
            layers: grid.ghosts,
        }
    }

    /// Whether some boundary fixes the pressure; where none does, the pressure equation is
    /// singular.
    pub fn fixes_pressure(&self) -> bool {
        self.kinds.iter().flatten().any(|b| matches!(b, Some(BoundaryKind::Outflow)))
    }

    /// The largest Courant number for `dt = 1` of the velocities that boundaries prescribe here
    /// (1/s).
    pub fn courant_rate(&self, grid: &Grid<D>) -> f64 {
        let here = (0..2 * D).filter_map(|f| self.boundary(f / 2, f % 2));
        let rates = here.flat_map(|boundary| {
            let velocity = if let BoundaryKind::Velocity(v) = boundary { Some(v) } else { None };
            velocity.into_iter().flat_map(|v| {
                (0..v[0].len()).map(|k| (0..D).map(|a| v[a][k].abs() / grid.h[a]).sum())
            })
        });
        rates.fold(0.0, f64::max)
    }

    /// Whether a side of the box that this rank reaches can do work on the fluid: something flows
    /// through it, or it moves.
    pub fn do_work(&self) -> bool {
        let mut here = (0..2 * D).filter_map(|f| self.boundary(f / 2, f % 2));
        here.any(|boundary| match boundary {
            BoundaryKind::Velocity(v) => v.iter().flatten().any(|v| *v != 0.0),
            BoundaryKind::Slip => false,
            BoundaryKind::Outflow => true,
        })
    }

    fn boundary(&self, axis: usize, side: usize) -> Option<&BoundaryKind<D>> {
        self.kinds[axis][side].as_ref().filter(|_| self.here[axis][side])
    }

    /// Fills the ghosts of a velocity. Collective.
    pub fn fill_velocity(&mut self, u: &mut VectorField<D>) -> Result<()> {
        self.fill_layers(self.layers, u)
    }

    /// Fills the ghosts of a velocity that the stencils of the flow read, without those for bodies'
    /// image points. Collective.
    pub fn fill_stencils(&mut self, u: &mut VectorField<D>) -> Result<()> {
        self.fill_layers(GHOSTS, u)
    }

    /// Fills the ghosts of a velocity again after ghost cells in bodies were set: none changes
    /// where every body is far from the ends of the box. Collective.
    pub fn fill_imposed(&mut self, u: &mut VectorField<D>) -> Result<()> {
        if self.layers > GHOSTS { self.fill_velocity(u) } else { Ok(()) }
    }

    fn fill_layers(&mut self, layers: usize, u: &mut VectorField<D>) -> Result<()> {
        for axis in 0..D {
            for (component, field) in u.iter_mut().enumerate() {
                self.halo.exchange(axis, layers, field)?;
                let rule = |side: usize| {
                    let bend = &self.bend[axis][side];
                    self.boundary(axis, side)
                        .map(|boundary| Rule::of_velocity(boundary, bend, component, axis))
                };
                self.planes[axis].set_ghosts(layers, [rule(0), rule(1)], field);
                for CoveredSide { ghost, cell, part } in &self.covered[axis] {
                    field[*ghost] += part * (field[*cell] - field[*ghost]);
                }
            }
        }
        Ok(())
    }

    /// Forgets what obstacles cover of the boundaries.
    pub fn uncover(&mut self) {
        self.covered.iter_mut().for_each(Vec::clear);
    }

    /// Has an obstacle cover this part of a face along an axis, if that is at a boundary with a
    /// given velocity: its shear is on the open part alone.
    pub fn cover(&mut self, grid: &Grid<D>, axis: usize, face: usize, part: f64) {
        let s = grid.stride[axis];
        let place = grid.place_of(axis, face);
        for side in [0, 1] {
            let [ghost, cell] = if side == 0 { [face - s, face] } else { [face, face - s] };
            let is_there = place == grid.ghosts + side * grid.local[axis];
            if is_there && matches!(self.boundary(axis, side), Some(BoundaryKind::Velocity(_))) {
                self.covered[axis].push(CoveredSide { ghost, cell, part });
            }
        }
    }

    /// Sets whether anything reads a velocity's ghosts beyond those of the fifth-order stencils:
    /// the same on all ranks. Returns whether the layers filled before are too few.
    pub fn set_velocity_layers(&mut self, deep: bool) -> bool {
        let layers = if deep { self.planes[0].ghosts } else { GHOSTS };
        std::mem::replace(&mut self.layers, layers) < layers
    }

    /// Fills ghosts of a field in so many layers, from neighbours across ranks and periods alone.
    /// Collective.
    pub fn exchange(&mut self, layers: usize, field: &mut [f64]) -> Result<()> {
        (0..D).try_for_each(|axis| self.halo.exchange(axis, layers, field))
    }

    /// Fills the ghosts of a pressure, next to its cells: no gradient at boundaries with a given
    /// velocity, and what [`Boundaries::set_backflow_pressure`] found at outflows. Collective.
    pub fn fill_pressure(&mut self, p: &mut [f64]) -> Result<()> {
        self.fill_increment(p)?;
        self.fill_outflows(p);
        Ok(())
    }

    /// Fills the ghosts of a change of the pressure, which is zero at outflows. Collective.
    pub fn fill_increment(&mut self, phi: &mut [f64]) -> Result<()> {
        self.fill_even(phi, -1.0)
    }

    /// Fills the ghosts of a pressure at outflows.
    fn fill_outflows(&self, p: &mut [f64]) {
        for axis in 0..D {
            let rule = |side: usize| {
                let given = self.boundary(axis, side).map(|_| &self.entry[axis][side][..])?;
                (!given.is_empty()).then(|| Rule::of_values(given))
            };
            self.planes[axis].set_ghosts(1, [rule(0), rule(1)], p);
        }
    }

    /// Finds the pressure at outflows, of a fluid of this density (kg/m3), and fills the ghosts of
    /// `p` there. Returns whether any changed on this rank.
    pub fn set_backflow_pressure(
        &mut self,
        density: f64,
        faces: &VectorField<D>,
        p: &mut [f64],
    ) -> bool {
        let mut changed = false;
        for (axis, side) in (0..D).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let mut entry = std::mem::take(&mut self.entry[axis][side]);
            if !entry.is_empty() && self.here[axis][side] {
                self.planes[axis].for_faces(side, |at, face, _| {
                    let inwards = if side == 0 { faces[axis][face] } else { -faces[axis][face] };
                    let pressure = -0.5 * density * inwards.max(0.0).powi(2);
                    changed |= std::mem::replace(&mut entry[at], pressure) != pressure;
                });
            }
            self.entry[axis][side] = entry;
        }
        if changed {
            self.fill_outflows(p);
        }
        changed
    }

    /// The pressure (Pa) at a boundary's side of the box, by the indices of the cell and of the
    /// next one inside.
    pub fn pressure_at(
        &self,
        axis: usize,
        side: usize,
        p: &[f64],
        [ghost, cell, next]: [usize; 3],
    ) -> f64 {
        match self.kinds[axis][side] {
            Some(BoundaryKind::Outflow) => 0.5 * (p[ghost] + p[cell]),
            _ => 0.5 * (3.0 * p[cell] - p[next]),
        }
    }

    /// Sets the share of the parabola along all boundaries.
    pub fn bend(&mut self, share: f64) {
        self.bend.iter_mut().flatten().for_each(|bend| bend.fill(share));
    }

    /// Leaves at most this share of the parabola along a boundary at a position on it, where a body
    /// is near.
    pub fn straighten(&mut self, axis: usize, side: usize, position: usize, share: f64) {
        if let Some(bend) = self.bend[axis][side].get_mut(position) {
            *bend = bend.min(share);
        }
    }

    /// A component of the velocity (m/s) at a boundary's side of the box, by the indices of the
    /// ghost and of the cell; ghosts of `q` filled.
    pub fn velocity_at(
        &self,
        axis: usize,
        side: usize,
        component: usize,
        q: &[f64],
        ghost: usize,
        cell: usize,
    ) -> f64 {
        match &self.kinds[axis][side] {
            Some(BoundaryKind::Velocity(velocity)) => {
                let Planes { inner, stored, .. } = self.planes[axis];
                velocity[component][ghost / (stored * inner) * inner + ghost % inner]
            }
            _ => 0.5 * (q[ghost] + q[cell]),
        }
    }

    /// Fills the ghosts of a property of the mixture (density, viscosity), next to its cells:
    /// mirrored at every boundary. Collective.
    pub fn fill_property(&mut self, field: &mut [f64]) -> Result<()> {
        self.fill_even(field, 1.0)
    }

    fn fill_even(&mut self, field: &mut [f64], at_outflow: f64) -> Result<()> {
        for axis in 0..D {
            self.halo.exchange(axis, 1, field)?;
            let factor = |boundary: &BoundaryKind<D>| {
                if let BoundaryKind::Outflow = boundary { at_outflow } else { 1.0 }
            };
            let rule =
                |side| self.boundary(axis, side).map(|boundary| Rule::mirrored(factor(boundary)));
            self.planes[axis].set_ghosts(1, [rule(0), rule(1)], field);
        }
        Ok(())
    }

    /// Sets the normal velocity of the boundary's faces where it is given.
    pub fn set_faces(&self, faces: &mut VectorField<D>) {
        for (axis, face) in faces.iter_mut().enumerate() {
            for side in [0, 1] {
                match self.boundary(axis, side) {
                    Some(BoundaryKind::Velocity(v)) => {
                        self.planes[axis].for_faces(side, |at, f, _| face[f] = v[axis][at])
                    }
                    Some(BoundaryKind::Slip) => {
                        self.planes[axis].for_faces(side, |_, f, _| face[f] = 0.0)
                    }
                    Some(BoundaryKind::Outflow) | None => {}
                }
            }
        }
    }

    /// Gives closed faces the value of the next face inside, for averages to cells beside them: the
    /// pressure's own condition there (no gradient) would halve the acceleration of the cell.
    pub fn extrapolate_to_closed_faces(&self, faces: &mut VectorField<D>) {
        for (axis, face) in faces.iter_mut().enumerate() {
            for side in [0, 1] {
                if let Some(BoundaryKind::Velocity(_) | BoundaryKind::Slip) =
                    self.boundary(axis, side)
                {
                    self.planes[axis].for_faces(side, |_, f, inside| face[f] = face[inside]);
                }
            }
        }
    }
}
