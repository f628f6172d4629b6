//! The traction at the quadrature points of the surfaces: the shear that is in the force, and the
//! pressure of a linear fit to that of the four cells about the point along each axis,
//!
//! ```text
//!   min over p, g of   sum_c w_c (p + g.(x_c - x) - p_c)^2
//!              w_c = (1 - alpha_c) product over axes of (1 - |x_c - x|/(2 h))
//! ```
//! alpha: what bodies fill of a cell. A linear pressure is found exactly.

use super::cut::CutBodies;
use super::stencil::Flow;
use crate::Result;
use crate::domain::Domain;
use crate::geometry::images;
use crate::grid::Grid;
use crate::method::Traction;
use crate::particles::velocities;
use crate::state::State;
use nalgebra::{Matrix4, Vector3, Vector4};

/// Layers of ghosts that the fit reads.
const LAYERS: usize = 2;

/// Part of the weight that resists a gradient along axes on which all cells of the fit are one.
const RIDGE: f64 = 1e-9;

/// Tractions at the quadrature points of this rank. Collective.
pub fn find<const D: usize>(
    cut: &CutBodies<D>,
    domain: &mut Domain<D>,
    s: &mut State<D>,
) -> Result<Vec<Traction>> {
    domain.boundaries.fill_velocity(&mut s.u)?;
    let mut p = s.p.clone();
    // Nothing beyond the sides of the box.
    let mut open = domain.grid.field();
    domain.grid.rows().for_each(|row| open[row].fill(1.0));
    let filled = cut.bodies.iter().flat_map(|body| &body.solid);
    filled.for_each(|solid| open[solid.cell] -= solid.fraction);
    domain.boundaries.exchange(LAYERS, &mut p)?;
    domain.boundaries.exchange(LAYERS, &mut open)?;
    let grid = &domain.grid;
    let mut all = Vec::new();
    for (k, body) in cut.bodies.each() {
        let flow = Flow {
            grid,
            boundaries: &domain.boundaries,
            u: &s.u,
            velocities: velocities(&s.bodies),
            k,
        };
        let points = &body.surface.points;
        body.stencils.values(pulp::Scalar::new(), points, &flow, None, |point, slope| {
            let at = images(grid, s.bodies[k].shape(), &s.bodies[k].centre)
                .map(|centre| centre + point.arm)
                .find(|at| grid.owns(at));
            all.extend(at.map(|at| Traction {
                body: k,
                arm: point.arm,
                area: point.share,
                pressure: pressure(grid, &p, &open, &at),
                shear: domain.fluid.viscosity * slope,
            }));
        });
    }
    Ok(all)
}

/// The pressure (Pa) at a point (m) of this rank, by the cells as far as they are `open`.
fn pressure<const D: usize>(grid: &Grid<D>, p: &[f64], open: &[f64], point: &Vector3<f64>) -> f64 {
    // Among the middles of the stored cells (spacings); points beyond the box count at its side.
    let place: [f64; D] = std::array::from_fn(|a| {
        let first = grid.ghosts as f64 - 0.5;
        (point[a] / grid.h[a] - grid.start[a] as f64 + first)
            .clamp(first, first + grid.local[a] as f64)
    });
    let mut sums = Matrix4::zeros();
    let mut values = Vector4::zeros();
    for n in 0..1 << (2 * D) {
        let mut index = 0;
        let mut weight = 1.0;
        let mut row = Vector4::new(1.0, 0.0, 0.0, 0.0);
        for a in 0..D {
            let cell = place[a].floor() as usize + (n >> (2 * a) & 3) - 1;
            index += cell * grid.stride[a];
            row[a + 1] = cell as f64 - place[a];
            weight *= 1.0 - 0.5 * row[a + 1].abs();
        }
        weight *= open[index].max(0.0);
        sums += weight * row * row.transpose();
        values += weight * p[index] * row;
    }
    let ridge = RIDGE * sums[(0, 0)];
    (1..4).for_each(|a| sums[(a, a)] += ridge);
    // Deep in other bodies there is no pressure.
    sums.cholesky().map_or(0.0, |factors| factors.solve(&values)[0])
}
