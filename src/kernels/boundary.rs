//! Forces of the sides of the box on the fluid: the momentum that goes through them, from the
//! fields beside them alone.
//!
//! ```text
//!      ghost 0 | cell 0   cell 1         viscous   mu (u_ghost - u_0)/h
//!         o    |    o        o           carried   rho U u_face       the fifth-order upwind value
//!              ^ side                    pressure  (3 p_0 - p_1)/2
//!              (p_ghost + p_0)/2 at an outflow
//! ```
//! At walls nothing is carried, and the viscous part is the shear on them. Where the viscosity is a
//! field, its force is that of the full stress ([`crate::kernels::diffusion::stress`]). These are
//! the values that the terms of the step have there, each on its face, so that summed over the
//! sides they are what all cells together gain.

use super::advection::{Carrier, upwind_flux};
use crate::grid::{Boundaries, Coefficient, Grid, VectorField};
use nalgebra::{Matrix3x2, Vector3};

/// Forces of the sides on the fluid (N; per metre of depth in 2D): by what flows through them, and
/// by viscosity.
pub type Sides = Matrix3x2<f64>;

/// This rank's part of the forces by what flows through the sides, of this density (kg/m3), and by
/// viscosity (Pa s), at the velocities `u`, ghosts filled, carried by `carrier`.
pub fn stress<const D: usize>(
    grid: &Grid<D>,
    carrier: &Carrier<D>,
    u: &VectorField<D>,
    density: f64,
    viscosity: &Coefficient,
) -> Sides {
    let mut force = Sides::zeros();
    for (axis, side) in (0..D).flat_map(|axis| [(axis, 0), (axis, 1)]) {
        let s = grid.stride[axis];
        let area = grid.cell_volume() / grid.h[axis];
        let inwards = 1.0 - 2.0 * side as f64;
        for cell in grid.boundary_cells(axis, side) {
            let (face, ghost) = if side == 0 { (cell, cell - s) } else { (cell + s, cell + s) };
            let carried = carrier.at(axis, face);
            for (i, q) in u.iter().enumerate() {
                let flux = upwind_flux(carried, std::array::from_fn(|k| q[face + k * s - 3 * s]));
                let normal = (q[ghost] - q[cell]) / grid.h[axis];
                let shear = match viscosity {
                    Coefficient::Uniform(viscosity) => viscosity * normal,
                    Coefficient::Field(mu) => {
                        let along = grid.stride[i];
                        let v = &u[axis];
                        let across = |c: usize| (v[c + along] - v[c - along]) / (4.0 * grid.h[i]);
                        let transposed = if i == axis {
                            normal
                        } else {
                            -inwards * (across(cell) + across(ghost))
                        };
                        0.5 * (mu[cell] + mu[ghost]) * (normal + transposed)
                    }
                };
                force[(i, 0)] += area * inwards * density * flux;
                force[(i, 1)] += area * shear;
            }
        }
    }
    force
}

/// This rank's part of the force (N; per metre of depth in 2D) by the pressure `p` (Pa) on the
/// sides.
pub fn pressure<const D: usize>(
    grid: &Grid<D>,
    boundaries: &Boundaries<D>,
    p: &[f64],
) -> Vector3<f64> {
    let mut force = Vector3::zeros();
    for (axis, side) in (0..D).flat_map(|axis| [(axis, 0), (axis, 1)]) {
        let s = grid.stride[axis];
        let area = grid.cell_volume() / grid.h[axis];
        for cell in grid.boundary_cells(axis, side) {
            let (next, ghost, inwards) =
                if side == 0 { (cell + s, cell - s, 1.0) } else { (cell - s, cell + s, -1.0) };
            force[axis] +=
                inwards * area * boundaries.pressure_at(axis, side, p, [ghost, cell, next]);
        }
    }
    force
}

/// This rank's part of the work per time (W; per metre of depth in 2D) of the sides on the fluid:
/// by the pressure `p` (Pa) and the kinetic energy that flows through them, and apart, by viscosity
/// (Pa s) where they move; ghosts of `u` filled.
pub fn power<const D: usize>(
    grid: &Grid<D>,
    boundaries: &Boundaries<D>,
    density: f64,
    viscosity: f64,
    u: &VectorField<D>,
    faces: &VectorField<D>,
    p: &[f64],
) -> [f64; 2] {
    let mut power = [0.0; 2];
    for (axis, side) in (0..D).flat_map(|axis| [(axis, 0), (axis, 1)]) {
        if boundaries.kinds[axis][side].is_none() {
            continue;
        }
        let s = grid.stride[axis];
        let area = grid.cell_volume() / grid.h[axis];
        for cell in grid.boundary_cells(axis, side) {
            let (face, ghost, next) =
                if side == 0 { (cell, cell - s, cell + s) } else { (cell + s, cell + s, cell - s) };
            let inwards = if side == 0 { faces[axis][face] } else { -faces[axis][face] };
            let pressure = boundaries.pressure_at(axis, side, p, [ghost, cell, next]);
            let at_side = |i: usize| boundaries.velocity_at(axis, side, i, &u[i], ghost, cell);
            let kinetic = 0.5 * density * (0..D).map(|i| at_side(i).powi(2)).sum::<f64>();
            let shear =
                u.iter().enumerate().map(|(i, q)| at_side(i) * (q[ghost] - q[cell])).sum::<f64>()
                    * viscosity
                    / grid.h[axis];
            power[0] += area * (pressure + kinetic) * inwards;
            power[1] += area * shear;
        }
    }
    power
}
