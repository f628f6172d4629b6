//! The force on a body, four ways: by pressure, by wall shear, by what both miss, and by what the
//! fluid loses (formulas in the parent).

use super::cut::CutBodies;
use super::cut_body::CutBody;
use super::stencil::Flow;
use super::sums::{CellMomentum, Sums, SurfaceForces};
use crate::Result;
use crate::domain::Domain;
use crate::grid::{Grid, VectorField};
use crate::method::vector;
use crate::particles::{Body, Impulse, Load, Velocities, velocities};
use crate::state::State;
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

/// Part of a cell that is open at most where bodies fill it wholly.
const FILLED: f64 = 1e-9;

/// Per body, pressure, wall shear and their torques over all ranks, with the cells' velocity and
/// pressure as they are, ghosts filled. Collective.
pub fn surface_forces<'a, const D: usize>(
    domain: &Domain<D>,
    cut: &CutBodies<D>,
    s: &State<D>,
    Sums { forces, messages, .. }: &'a mut Sums,
) -> Result<&'a [SurfaceForces]> {
    let own = |k: usize| {
        let force = pressure_force(cut, &domain.grid, k, &s.p);
        let torque = pressure_torque(cut, &domain.grid, &s.bodies[k], k, &s.p);
        let shear = shear_force(cut, domain, velocities(&s.bodies), k, &s.u);
        SurfaceForces { pressure: Load { force, torque }, shear }
    };
    Ok(forces.sum_for_all(&domain.session, &cut.reach, messages, own)?)
}

/// Per body, the momentum `exchanged` and what is inside, over all ranks. Collective.
pub fn cell_momenta<'a, const D: usize>(
    domain: &Domain<D>,
    cut: &CutBodies<D>,
    exchanged: &[Impulse],
    s: &State<D>,
    Sums { momenta, messages, .. }: &'a mut Sums,
) -> Result<&'a [CellMomentum]> {
    let own = |k: usize| {
        let (inside, swirl) = inside(cut, domain, &s.bodies[k], k, &s.u);
        CellMomentum { exchanged: exchanged[k], inside, swirl }
    };
    Ok(momenta.sum_for_all(&domain.session, &cut.reach, messages, own)?)
}

/// This rank's pressure force on the body `k` by a pressure (Pa) with its ghosts filled: every
/// face counts on the rank of the cell above it.
pub fn pressure_force<const D: usize>(
    cut: &CutBodies<D>,
    grid: &Grid<D>,
    k: usize,
    p: &[f64],
) -> Vector3<f64> {
    let mut force = Vector3::zeros();
    if !cut.joined[k].is_empty() {
        each_pressure_of_part(cut, grid, k, p, |_, own| force += own);
        return force;
    }
    for axis in 0..D {
        let s = grid.stride[axis];
        let area = grid.cell_volume() / grid.h[axis];
        // Sums that do not wait for each other.
        let mut sums = [0.0; 4];
        for cuts in cut.bodies[k].faces.cuts[axis].chunks(sums.len()) {
            for (sum, cut) in sums.iter_mut().zip(cuts).filter(|(_, cut)| cut.owned) {
                let face = cut.face as usize;
                *sum += cut.solid_fraction * (p[face - s] - p[face]);
            }
        }
        force[axis] = area * sums.iter().sum::<f64>();
    }
    force
}

/// This rank's part of the pressure load on the obstacle `k` that is not that of the fluid on its
/// walls, but of cells within the solid, whose pressure is nobody's: where faces between two cells
/// that bodies fill (`filled` is 1) are covered in part only, since apertures do not close, and
/// through the sides of the box that it covers,
///
/// ```text
///   sum over faces between filled cells of  A (m - 1) (p_b - p_a)      m: covered part, b and a:
///     + sum over sides of  A m p_a  at low, -A m p_b  at high ones     the cells below and above
/// ```
/// Ghosts of both fields filled.
pub fn load_of_filled<const D: usize>(
    cut: &CutBodies<D>,
    grid: &Grid<D>,
    k: usize,
    p: &[f64],
    filled: &[f64],
) -> Load {
    let is_filled = |cell: usize| filled[cell] > 1.0 - FILLED;
    let mut load = Load::default();
    let mut add = |axis: usize, pressure: f64, part: f64, lever: &Vector3<f64>| {
        let mut force = Vector3::zeros();
        force[axis] = grid.cell_volume() / grid.h[axis] * pressure;
        load.force += part * force;
        load.torque += part * lever.cross(&force);
    };
    let number = cut.joined[k].iter().position(|(j, _)| *j == k).map(|number| number as u32);
    let alone = [(k, Vector3::zeros())];
    let all = if number.is_some() { &cut.joined[k][..] } else { &alone };
    for (j, way) in all {
        let faces = &cut.bodies[*j].faces;
        for axis in 0..D {
            let s = grid.stride[axis];
            for (n, (cut, centroids)) in faces.cuts[axis].with_centroids().enumerate() {
                let face = cut.face as usize;
                if cut.owned && is_filled(face - s) && is_filled(face) {
                    let [below, above] = number.map_or([1.0; 2], |number| {
                        faces.owners[axis][n].map(|owner| f64::from(owner == number))
                    });
                    let pressure = below * p[face - s] - above * p[face];
                    let lever = centroids.lever() / cut.solid_fraction + way;
                    add(axis, pressure, cut.solid_fraction - 1.0, &lever);
                }
            }
        }
    }
    for (axis, cuts) in cut.bodies[k].faces.at_sides.iter().enumerate() {
        let s = grid.stride[axis];
        for (cut, centroids) in cuts.with_centroids() {
            let face = cut.face as usize;
            let is_low = grid.place_of(axis, face) == grid.ghosts;
            let pressure = if is_low { p[face] } else { -p[face - s] };
            let lever = centroids.lever() / cut.solid_fraction;
            add(axis, pressure, cut.solid_fraction, &lever);
        }
    }
    load
}

/// Calls `take` with the lever from the centre of the obstacle `k` (m), which is one solid with
/// others, to each covered face beside cells that belong to it, and the force of the pressure
/// in these cells on the face (N). A cell within the solid has the same on both sides.
fn each_pressure_of_part<const D: usize>(
    cut: &CutBodies<D>,
    grid: &Grid<D>,
    k: usize,
    p: &[f64],
    mut take: impl FnMut(&Vector3<f64>, &Vector3<f64>),
) {
    let number = cut.joined[k].iter().position(|(j, _)| *j == k).unwrap_or(0) as u32;
    for (j, way) in &cut.joined[k] {
        let cut_body = &cut.bodies[*j];
        for axis in 0..D {
            let s = grid.stride[axis];
            let area = grid.cell_volume() / grid.h[axis];
            let faces = cut_body.covered(axis).zip(&cut_body.faces.owners[axis]);
            for ((cut, centroids), owners) in faces.filter(|((cut, _), _)| cut.owned) {
                let face = cut.face as usize;
                let [below, above] = owners.map(|owner| f64::from(owner == number));
                let mut force = Vector3::zeros();
                force[axis] = area * (below * p[face - s] - above * p[face]);
                take(
                    &(centroids.lever() / cut.solid_fraction + way),
                    &(cut.solid_fraction * force),
                );
            }
        }
    }
}

/// Its torque about the centre, of a body that is not round.
pub fn pressure_torque<const D: usize>(
    cut: &CutBodies<D>,
    grid: &Grid<D>,
    body: &Body,
    k: usize,
    p: &[f64],
) -> Vector3<f64> {
    let mut torque = Vector3::zeros();
    if body.shape().is_round() {
        return torque;
    }
    if !cut.joined[k].is_empty() {
        each_pressure_of_part(cut, grid, k, p, |lever, own| torque += lever.cross(own));
        return torque;
    }
    for axis in 0..D {
        let s = grid.stride[axis];
        let area = grid.cell_volume() / grid.h[axis];
        for (cut, centroids) in cut.bodies[k].covered(axis).filter(|(cut, _)| cut.owned) {
            let face = cut.face as usize;
            let mut force = Vector3::zeros();
            force[axis] = area * (p[face - s] - p[face]);
            torque += centroids.lever().cross(&force);
        }
    }
    torque
}

/// This rank's force and torque by wall shear; ghosts of `u` filled.
pub fn shear_force<const D: usize>(
    cut: &CutBodies<D>,
    domain: &Domain<D>,
    velocities: impl Velocities,
    k: usize,
    u: &VectorField<D>,
) -> Load {
    let cut = &cut.bodies[k];
    Arch::new().dispatch(WallShear { cut, velocities, k, domain, u })
}

/// This rank's part of the momentum (kg m/s) and angular momentum (kg m2/s) inside the body
/// `k`, relative to its own motion.
fn inside<const D: usize>(
    cut: &CutBodies<D>,
    domain: &Domain<D>,
    body: &Body,
    k: usize,
    u: &VectorField<D>,
) -> (Vector3<f64>, Vector3<f64>) {
    let mass = domain.fluid.density * domain.grid.cell_volume();
    let mut momentum = Vector3::zeros();
    let mut swirl = Vector3::zeros();
    for o in &cut.bodies[k].solid {
        let own = (mass * o.fraction) * (vector(u, o.cell) - body.velocity_at(&o.arm));
        momentum += own;
        swirl += o.arm.cross(&own);
    }
    (momentum, swirl)
}

/// Force and torque on a body by the shear of a velocity, ghosts filled.
struct WallShear<'a, V: Velocities, const D: usize> {
    cut: &'a CutBody<D>,
    velocities: V,
    k: usize,
    domain: &'a Domain<D>,
    u: &'a VectorField<D>,
}

impl<V: Velocities, const D: usize> WithSimd for WallShear<'_, V, D> {
    type Output = Load;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let WallShear { cut, velocities, k, domain, u } = self;
        let Domain { grid, boundaries, .. } = domain;
        let viscosity = domain.fluid.viscosity;
        let mut load = Load::default();
        let flow = Flow { grid, u, boundaries, velocities, k };
        cut.stencils.values(
            simd,
            &cut.surface.points,
            &flow,
            None,
            #[inline(always)]
            |point, slope| {
                let df = (viscosity * point.share) * slope;
                load.force += df;
                load.torque += point.arm.cross(&df);
            },
        );
        load
    }
}
