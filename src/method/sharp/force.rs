//! The force on a body, four ways: by pressure, by wall shear, by what both miss, and by what the fluid loses (formulas in
//! the parent).

use super::gap::Shares;
use super::{NUMBERS, Ride, Sharp, TAKE_IN};
use crate::Result;
use crate::coupling::{Exchange, vector};
use crate::grid::{Border, Boundaries, Grid, VectorField, wide};
use crate::solids::nearest_image;
use nalgebra::Vector3;

impl Ride {
    /// Torque on it by the fluid over the step (N m).
    fn torque(&self) -> Vector3<f64> {
        self.shear.1 + self.pressure_torque
    }
}

impl<const D: usize> Sharp<D> {
    /// This rank's pressure force on the body `k` by a pressure (Pa) with its ghosts filled: every face counts on the rank
    /// of the cell above it.
    pub(super) fn pressure_force(&self, grid: &Grid<D>, k: usize, p: &[f64]) -> Vector3<f64> {
        let mut force = Vector3::zeros();
        for axis in 0..D {
            let (s, area) = (grid.stride[axis], grid.cell_volume() / grid.h[axis]);
            for cut in self.skins[k].cuts[axis].iter().filter(|cut| cut.owned) {
                let face = cut.face as usize;
                force[axis] += area * cut.covered * (p[face - s] - p[face]);
            }
        }
        force
    }

    /// Its torque about the centre, of a body that is not round.
    pub(super) fn pressure_torque(&self, grid: &Grid<D>, k: usize, p: &[f64]) -> Vector3<f64> {
        let mut torque = Vector3::zeros();
        if self.bodies[k].shape().is_round() {
            return torque;
        }
        for axis in 0..D {
            let (s, area) = (grid.stride[axis], grid.cell_volume() / grid.h[axis]);
            for (cut, opening) in self.skins[k].faces(axis).filter(|(cut, _)| cut.owned) {
                let face = cut.face as usize;
                let mut force = Vector3::zeros();
                force[axis] = area * (p[face - s] - p[face]);
                torque += opening.lever.cross(&force);
            }
        }
        torque
    }

    /// This rank's force and torque by wall shear; ghosts of `u` filled.
    pub(super) fn shear_force(&self, grid: &Grid<D>, k: usize, u: &VectorField<D>) -> (Vector3<f64>, Vector3<f64>) {
        let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
        let skin = &self.skins[k];
        wide(
            #[inline(always)]
            || {
                for point in &skin.points {
                    let slope = skin.value(&point.slope, &point.arm, grid, u, &self.bodies, k, None);
                    let df = (self.fluid_viscosity * point.area) * slope;
                    force += df;
                    torque += point.arm.cross(&df);
                }
            },
        );
        (force, torque)
    }

    /// This rank's part of the momentum (kg m/s) and angular momentum (kg m2/s) inside the body `k`, relative to its own
    /// motion.
    fn inside(&self, grid: &Grid<D>, k: usize, u: &VectorField<D>) -> (Vector3<f64>, Vector3<f64>) {
        let mass = self.fluid_density * grid.cell_volume();
        let (mut momentum, mut swirl) = (Vector3::zeros(), Vector3::zeros());
        for o in &self.skins[k].solid {
            let own = (mass * o.fraction) * (vector(u, o.cell) - self.bodies[k].velocity_at(&o.arm));
            momentum += own;
            swirl += o.arm.cross(&own);
        }
        (momentum, swirl)
    }

    /// Forgets all that forces remember, and takes the momentum inside the bodies. Collective.
    pub fn start_forces(&mut self, grid: &Grid<D>, boundaries: &Boundaries<D>, u: &VectorField<D>) -> Result<()> {
        for ride in &mut self.rides {
            (ride.rest, ride.owed, ride.shear_before) = (Vector3::zeros(), Vector3::zeros(), None);
        }
        self.start_books();
        self.close_books(grid, boundaries, u, 1.0)?;
        for ride in &mut self.rides {
            (ride.rest, ride.owed) = (Vector3::zeros(), Vector3::zeros());
        }
        self.exchange.fill(Exchange::default());
        Ok(())
    }

    /// Momentum that belongs to the balance beside that of all cells (kg m/s): less what lies inside the bodies, with the
    /// free bodies' own and what they are owed.
    pub fn momentum_beside_cells(&self) -> Vector3<f64> {
        let terms = self.bodies.iter().zip(&self.rides).map(|(body, ride)| {
            let own = if body.freedom().is_some() { body.mass() * body.velocity } else { Vector3::zeros() };
            own + ride.owed - ride.inside
        });
        terms.sum()
    }

    /// Impulse over the step `dt` (s) of gravity and contacts on the free bodies, less that of the fluid on held ones, and
    /// on free ones along the directions in which they are held (N s).
    pub fn impulse(&self, dt: f64) -> Vector3<f64> {
        let terms = self.bodies.iter().zip(&self.exchange).map(|(body, exchange)| {
            let Some(freedom) = body.freedom() else { return -dt * exchange.momentum };
            let weight = (body.mass() - self.fluid_density * body.volume()) * self.gravity;
            let free = freedom.along(&(dt * (weight + exchange.contact)));
            free - dt * (exchange.momentum - freedom.along(&exchange.momentum))
        });
        terms.sum::<Vector3<f64>>() - dt * self.passed_on
    }

    /// What the torque misses of the angular momentum that the fluid lost about the free bodies' centres over
    /// the step `dt` (s), summed over them (kg m2/s).
    pub fn angular_error(&self, dt: f64) -> f64 {
        let terms = self
            .bodies
            .iter()
            .zip(&self.rides)
            .map(|(body, ride)| body.freedom().map_or(0.0, |f| f.about(&(ride.spun - dt * ride.torque())).norm()));
        terms.sum()
    }

    /// Starts the step's sums.
    pub fn start_books(&mut self) {
        for ride in &mut self.rides {
            (ride.given, ride.spun) = (Vector3::zeros(), Vector3::zeros());
        }
    }

    /// Closes the step `dt` (s): what each body exchanged with the fluid, and what it takes in of what it missed. Collective.
    pub fn close_books(
        &mut self,
        grid: &Grid<D>,
        boundaries: &Boundaries<D>,
        u: &VectorField<D>,
        dt: f64,
    ) -> Result<()> {
        let mut buffer = std::mem::take(&mut self.buffer);
        for (k, row) in buffer.chunks_exact_mut(NUMBERS).enumerate() {
            let (ride, (inside, swirl)) = (&self.rides[k], self.inside(grid, k, u));
            for (slot, v) in row.chunks_exact_mut(3).zip([ride.given, ride.spun, inside, swirl]) {
                slot.copy_from_slice(v.as_slice());
            }
        }
        self.session.sum(&mut buffer)?;
        let take_in = (self.courant / TAKE_IN).min(1.0);
        for (k, row) in buffer.chunks_exact(NUMBERS).enumerate() {
            let [given, spun, inside, swirl] = [0, 3, 6, 9].map(|n| Vector3::from_column_slice(&row[n..n + 3]));
            let (body, ride, exchange) = (&self.bodies[k], &mut self.rides[k], &mut self.exchange[k]);
            let inside = inside + self.fluid_density * body.volume() * body.velocity;
            let swirl = swirl + body.inertia().times(self.fluid_density / body.density).of(&body.spin);
            let lost = (inside - ride.inside - given) / dt;
            ride.spun = swirl - ride.swirl - spun;
            (ride.inside, ride.swirl) = (inside, swirl);
            let struck = self.contacts.as_ref().map(|c| c.impulses()[k]).unwrap_or_default();
            let felt = ride.pressure + ride.shear.0 + ride.rest;
            // What moved a free body, the resistance to changes within the step included.
            let moved = body.freedom().map(|freedom| {
                let weight = (body.mass() - self.fluid_density * body.volume()) * self.gravity;
                let force = (body.mass() * (body.velocity - ride.start.0) - struck.linear) / dt - weight;
                freedom.along(&(force - felt))
            });
            let used = felt + moved.unwrap_or_default();
            (ride.missed, ride.used) = (lost - ride.pressure - ride.shear.0, used);
            *exchange = Exchange {
                momentum: used,
                momentum_torque: ride.torque(),
                convective: used - ride.pressure - ride.shear.0,
                pressure: ride.pressure,
                viscous: ride.shear.0,
                literal_torque: ride.torque(),
                contact: struck.linear / dt,
                ..Exchange::default()
            };
        }
        self.buffer = buffer;
        self.share_missed(grid, boundaries);
        for ride in &mut self.rides {
            ride.owed += dt * (ride.missed + ride.pressure + ride.shear.0 - ride.used);
            ride.rest += take_in * (ride.missed - ride.rest);
        }
        Ok(())
    }

    /// Takes from what pressure and wall shear miss the part that two bodies with a gap between them that the grid does not
    /// resolve would do to each other along the line of their centres, or a wall to a body: whose it is of what the fluid
    /// lost there the cells cannot tell, and taken in with a delay it would be work from nothing. The sum of a pair's stays.
    fn share_missed(&mut self, grid: &Grid<D>, boundaries: &Boundaries<D>) {
        self.passed_on = Vector3::zeros();
        for i in 0..self.bodies.len() {
            for &j in self.near[i].iter().filter(|j| **j > i) {
                let apart = nearest_image(&self.bodies[i].centre, &self.bodies[j].centre, &self.periods);
                let distance = apart.norm();
                let (n, gap) = (apart / distance, distance - self.bodies[i].radius() - self.bodies[j].radius());
                let share = Shares::of(gap / self.h).across;
                let free = [i, j].map(|k| self.bodies[k].freedom().is_some());
                let along = share * (self.rides[i].missed - self.rides[j].missed).dot(&n);
                let (of_i, of_j) = match free {
                    [true, true] => (0.5 * along, -0.5 * along),
                    _ => (share * self.rides[i].missed.dot(&n), share * self.rides[j].missed.dot(&n)),
                };
                self.rides[i].missed -= of_i * n;
                self.rides[j].missed -= of_j * n;
                // Nothing of a free pair; else it is left to what holds the other.
                self.passed_on += (of_i + of_j) * n;
            }
            for (a, side) in (0..D).flat_map(|a| [(a, 0), (a, 1)]) {
                if !matches!(boundaries.borders[a][side], Some(Border::Velocity(_) | Border::Slip)) {
                    continue;
                }
                let centre = self.bodies[i].centre[a];
                let distance = if side == 0 { centre } else { grid.size[a] - centre };
                let share = Shares::of((distance - self.bodies[i].radius()) / self.h).across * self.rides[i].missed[a];
                self.rides[i].missed[a] -= share;
                self.passed_on[a] += share;
            }
        }
    }
}
