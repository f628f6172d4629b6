//! The acceleration by the pressure, on faces, and what covered faces change of it in the cells
//! beside them:
//!
//! ```text
//!   a = (-grad p + G)/rho                                        G: the drive's force
//!   cell:  b + (H_w (a_w - b) + H_e (a_e - b))/(1 + (H_w + H_e)/2)
//! ```
//! with b = G/rho beside free bodies, which the drive accelerates as well, and 0 beside others.
//! Where both faces are open this is the mean of theirs. A drive accelerates the fluid and free
//! bodies of its density alike, so that they stay at rest relative to each other.

use super::cut::CutBodies;
use crate::domain::Domain;
use crate::grid::{Grid, VectorField};
use crate::kernels::faces::{self, FaceCoefficient};
use crate::particles::{Body, Impulse};
use nalgebra::Vector3;

/// Acceleration by one pressure.
pub struct PressureAcceleration<const D: usize> {
    /// On every face, open or not (m/s2).
    pub faces: VectorField<D>,
    /// The drive's part of it, the same everywhere (m/s2).
    driven: Vector3<f64>,
}

impl<const D: usize> PressureAcceleration<D> {
    /// No acceleration yet.
    pub fn new(grid: &Grid<D>) -> PressureAcceleration<D> {
        PressureAcceleration { faces: grid.vector_field(), driven: Vector3::zeros() }
    }

    /// Sets it to zero.
    pub fn clear(&mut self) {
        self.faces.iter_mut().for_each(|f| f.fill(0.0));
        self.driven = Vector3::zeros();
    }

    /// Finds it by a pressure `p` (Pa), ghosts filled, and by the drive, where there is one (N/m3).
    pub fn of_pressure(
        &mut self,
        domain: &Domain<D>,
        cut: &mut CutBodies<D>,
        bodies: &[Body],
        p: &[f64],
        drive: Option<Vector3<f64>>,
    ) {
        let whole = FaceCoefficient::Uniform(1.0 / domain.fluid.density);
        faces::acceleration(&domain.grid, &whole, p, &mut self.faces);
        domain.boundaries.extrapolate_to_closed_faces(&mut self.faces);
        self.driven = drive.map_or_else(Vector3::zeros, |force| force / domain.fluid.density);
        for (driven, faces) in
            self.driven.iter().zip(&mut self.faces).filter(|(driven, _)| **driven != 0.0)
        {
            faces.iter_mut().for_each(|a| *a += driven);
        }
        self.find_cut_changes(domain, cut, bodies);
    }

    /// The part of it that the drive gives a body as well as the fluid (m/s2).
    pub fn driven(&self, body: &Body) -> Vector3<f64> {
        felt(&self.driven, body)
    }

    /// Finds what covered faces change of it in the bodies' own cells, once bodies have moved.
    pub fn find_cut_changes(&self, domain: &Domain<D>, cut: &mut CutBodies<D>, bodies: &[Body]) {
        let grid = &domain.grid;
        let density = domain.fluid.density;
        let CutBodies { bodies: cut_bodies, beta, .. } = cut;
        let beta = &*beta.field(grid);
        for (k, cut) in cut_bodies.each_mut() {
            let driven = felt(&self.driven, &bodies[k]);
            for own in &mut cut.own.cells {
                for (axis, (beta, a)) in beta.iter().zip(&self.faces).enumerate() {
                    let low = own.cell as usize;
                    let high = own.cell as usize + grid.stride[axis];
                    let [open_low, open_high] = [low, high].map(|f| beta[f] * density);
                    let [a_low, a_high] = [low, high].map(|f| a[f] - driven[axis]);
                    let open = (open_low * a_low + open_high * a_high)
                        / (1.0 + 0.5 * (open_low + open_high));
                    own.cut_change[axis] = own.ownership * (open - 0.5 * (a_low + a_high));
                }
            }
        }
    }

    /// Adds `dt` (s) of it to the cells.
    pub fn add_to(&self, domain: &Domain<D>, cut: &CutBodies<D>, dt: f64, u: &mut VectorField<D>) {
        faces::add_to_cells(&domain.grid, dt, &self.faces, u);
        add_cut_cells(cut, domain, dt, None, u);
    }
}

/// Adds `dt` (s) of what covered faces change of the acceleration; the momentum of that goes to
/// the `exchanged` of each body.
pub fn add_cut_cells<const D: usize>(
    cut: &CutBodies<D>,
    domain: &Domain<D>,
    dt: f64,
    mut exchanged: Option<&mut Vec<Impulse>>,
    u: &mut VectorField<D>,
) {
    let mass = domain.fluid.density * domain.grid.cell_volume();
    for (k, body) in cut.bodies.each() {
        for own in &body.own.cells {
            let mut given = Vector3::zeros();
            for (axis, field) in u.iter_mut().enumerate() {
                let change = dt * own.cut_change[axis];
                field[own.cell as usize] += change;
                given[axis] = mass * change;
            }
            if let Some(exchanged) = &mut exchanged {
                exchanged[k].add(&own.arm, &given);
            }
        }
    }
}

/// The drive's acceleration of a body (m/s2): nothing along directions in which it is
/// held.
fn felt(driven: &Vector3<f64>, body: &Body) -> Vector3<f64> {
    body.freedom().map_or_else(Vector3::zeros, |freedom| freedom.along(driven))
}
