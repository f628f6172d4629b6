//! The force on a body, four ways: by pressure, by wall shear, by what both miss, and by what the
//! fluid loses (formulas in the parent).

use super::cut::CutBodies;
use super::cut_body::CutBody;
use super::exchanged::ExchangedMomentum;
use super::gap::Shares;
use super::sums::{CellMomentum, Sums, SurfaceForces};
use super::values::Flow;
use super::{Sharp, StepNumbers, history};
use crate::Result;
use crate::clock::Stage;
use crate::domain::Domain;
use crate::grid::{BoundaryKind, Grid, VectorField};
use crate::method::vector;
use crate::numerics::{DEFECT_DECAY, DEFECT_TIME};
use crate::particles::{Body, Load, gap, nearest_image};
use crate::petsc::LogStage;
use crate::state::{BodyHistory, Exchange, State};
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

/// Per body, pressure, wall shear and their torques over all ranks, with the cells' velocity and
/// pressure as they are, ghosts filled. Collective.
pub fn surface_forces<'a, const D: usize>(
    domain: &Domain<D>,
    cut: &CutBodies<D>,
    s: &State<D>,
    Sums { forces, messages, .. }: &'a mut Sums,
) -> Result<&'a [SurfaceForces]> {
    let own = |k: usize| {
        let force = cut.pressure_force(&domain.grid, k, &s.p);
        let torque = cut.pressure_torque(&domain.grid, &s.bodies[k], k, &s.p);
        let shear = cut.shear_force(domain, &s.bodies, k, &s.u);
        SurfaceForces { pressure: Load { force, torque }, shear }
    };
    Ok(forces.sum_for_all(&domain.session, &cut.reach, messages, own)?)
}

/// Per body, the momentum `exchanged` and what is inside, over all ranks. Collective.
pub fn cell_momenta<'a, const D: usize>(
    domain: &Domain<D>,
    cut: &CutBodies<D>,
    exchanged: &[ExchangedMomentum],
    s: &State<D>,
    Sums { momenta, messages, .. }: &'a mut Sums,
) -> Result<&'a [CellMomentum]> {
    let own = |k: usize| {
        let (inside, swirl) = cut.inside(domain, &s.bodies[k], k, &s.u);
        CellMomentum { exchanged: exchanged[k], inside, swirl }
    };
    Ok(momenta.sum_for_all(&domain.session, &cut.reach, messages, own)?)
}

impl<const D: usize> CutBodies<D> {
    /// This rank's pressure force on the body `k` by a pressure (Pa) with its ghosts filled: every
    /// face counts on the rank of the cell above it.
    pub fn pressure_force(&self, grid: &Grid<D>, k: usize, p: &[f64]) -> Vector3<f64> {
        let mut force = Vector3::zeros();
        if !self.joined[k].is_empty() {
            self.each_pressure_of_part(grid, k, p, |_, own| force += own);
            return force;
        }
        for axis in 0..D {
            let s = grid.stride[axis];
            let area = grid.cell_volume() / grid.h[axis];
            // Sums that do not wait for each other.
            let mut sums = [0.0; 4];
            for cuts in self.bodies[k].faces.cuts[axis].chunks(sums.len()) {
                for (sum, cut) in sums.iter_mut().zip(cuts).filter(|(_, cut)| cut.owned) {
                    let face = cut.face as usize;
                    *sum += cut.solid_fraction * (p[face - s] - p[face]);
                }
            }
            force[axis] = area * sums.iter().sum::<f64>();
        }
        force
    }

    /// Calls `take` with the lever from the centre of the obstacle `k` (m), which is one solid with
    /// others, to each covered face beside cells that belong to it, and the force of the pressure
    /// in these cells on the face (N). A cell within the solid has the same on both sides.
    fn each_pressure_of_part(
        &self,
        grid: &Grid<D>,
        k: usize,
        p: &[f64],
        mut take: impl FnMut(&Vector3<f64>, &Vector3<f64>),
    ) {
        let number = self.joined[k].iter().position(|(j, _)| *j == k).unwrap_or(0) as u32;
        for (j, way) in &self.joined[k] {
            let cut_body = &self.bodies[*j];
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
    pub fn pressure_torque(
        &self,
        grid: &Grid<D>,
        body: &Body,
        k: usize,
        p: &[f64],
    ) -> Vector3<f64> {
        let mut torque = Vector3::zeros();
        if body.shape().is_round() {
            return torque;
        }
        if !self.joined[k].is_empty() {
            self.each_pressure_of_part(grid, k, p, |lever, own| torque += lever.cross(own));
            return torque;
        }
        for axis in 0..D {
            let s = grid.stride[axis];
            let area = grid.cell_volume() / grid.h[axis];
            for (cut, centroids) in self.bodies[k].covered(axis).filter(|(cut, _)| cut.owned) {
                let face = cut.face as usize;
                let mut force = Vector3::zeros();
                force[axis] = area * (p[face - s] - p[face]);
                torque += centroids.lever().cross(&force);
            }
        }
        torque
    }

    /// This rank's force and torque by wall shear; ghosts of `u` filled.
    pub fn shear_force(
        &self,
        domain: &Domain<D>,
        bodies: &[Body],
        k: usize,
        u: &VectorField<D>,
    ) -> Load {
        let cut = &self.bodies[k];
        let grid = &domain.grid;
        let viscosity = domain.fluid.viscosity;
        Arch::new().dispatch(WallShear { cut, bodies, k, grid, u, viscosity })
    }

    /// This rank's part of the momentum (kg m/s) and angular momentum (kg m2/s) inside the body
    /// `k`, relative to its own motion.
    fn inside(
        &self,
        domain: &Domain<D>,
        body: &Body,
        k: usize,
        u: &VectorField<D>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let mass = domain.fluid.density * domain.grid.cell_volume();
        let mut momentum = Vector3::zeros();
        let mut swirl = Vector3::zeros();
        for o in &self.bodies[k].solid {
            let own = (mass * o.fraction) * (vector(u, o.cell) - body.velocity_at(&o.arm));
            momentum += own;
            swirl += o.arm.cross(&own);
        }
        (momentum, swirl)
    }
}

/// Force and torque on a body by the shear of a velocity, ghosts filled.
struct WallShear<'a, const D: usize> {
    cut: &'a CutBody<D>,
    bodies: &'a [Body],
    k: usize,
    grid: &'a Grid<D>,
    u: &'a VectorField<D>,
    viscosity: f64,
}

impl<const D: usize> WithSimd for WallShear<'_, D> {
    type Output = Load;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let WallShear { cut, bodies, k, grid, u, viscosity } = self;
        let mut load = Load::default();
        let flow = Flow { grid, u, bodies, k };
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

impl CellMomentum {
    /// Momentum and angular momentum inside a body in all.
    pub fn whole(&self, fluid_density: f64, body: &Body) -> (Vector3<f64>, Vector3<f64>) {
        (
            self.inside + fluid_density * body.volume() * body.velocity,
            self.swirl + body.inertia().times(fluid_density / body.density).of(&body.spin),
        )
    }
}

impl<const D: usize> Sharp<D> {
    /// Takes the momentum inside the bodies of these numbers as what was there before. Collective.
    pub(super) fn take_inside(
        &mut self,
        domain: &Domain<D>,
        s: &mut State<D>,
        of: impl Fn(usize) -> bool,
    ) -> Result<()> {
        self.work.exchanged.fill(ExchangedMomentum::default());
        let momenta =
            cell_momenta(domain, &self.cut, &self.work.exchanged, s, &mut self.work.sums)?;
        let all = history(&mut s.surfaces)?.bodies.iter_mut().zip(&s.bodies).zip(momenta);
        for ((history, body), momentum) in all.filter(|((_, body), _)| of(body.id)) {
            history.inside = momentum.whole(domain.fluid.density, body);
        }
        Ok(())
    }

    /// (19): what each body exchanged with the fluid over the step `dt` (s), what it takes in of
    /// what it missed, and its acceleration without contacts for the next step. Collective.
    pub(super) fn find_loads(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        numbers: StepNumbers,
        dt: f64,
    ) -> Result<()> {
        let _logged = domain.session.log(LogStage::Bodies)?;
        let momenta =
            cell_momenta(domain, &self.cut, &self.work.exchanged, s, &mut self.work.sums)?;
        let histories = &mut history(&mut s.surfaces)?.bodies;
        for (k, momentum) in momenta.iter().enumerate() {
            let ExchangedMomentum { linear: given, angular: spun } = momentum.exchanged;
            let body = &s.bodies[k];
            let motion = &mut self.motions[k];
            let (inside, swirl) = momentum.whole(domain.fluid.density, body);
            let before = std::mem::replace(&mut histories[k].inside, (inside, swirl));
            // Momentum that advection loses by itself is nobody's force.
            let lost = if self.prediction.keeps_momentum() {
                (inside - before.0 - given) / dt - domain.unfelt(&s.drive, body.volume())
            } else {
                motion.pressure.force + motion.shear.force
            };
            motion.spin_lost = swirl - before.1 - spun;
            let struck = self.contacts.as_ref().map(|c| c.outcome().impulse(k)).unwrap_or_default();
            let felt = motion.pressure.force + motion.shear.force + histories[k].filtered_defect;
            // What moved a free body, the resistance to changes within the step included.
            let moved = body.freedom().map(|freedom| {
                let weight =
                    (body.mass() - domain.fluid.density * body.volume()) * domain.fluid.gravity;
                let force = (body.mass() * (body.velocity - motion.start.velocity) - struck.linear)
                    / dt
                    - weight;
                freedom.along(&(force - felt))
            });
            let used = felt + moved.unwrap_or_default();
            (motion.force_defect, motion.used) =
                (lost - motion.pressure.force - motion.shear.force, used);
            s.exchange[k] = Exchange { contact: struck.linear / dt, ..motion.exchange() };
        }
        self.share_defect_of_joined();
        self.share_force_defect(domain, &s.bodies);
        let take_in = (numbers.courant / DEFECT_TIME + DEFECT_DECAY * numbers.diffusion).min(1.0);
        for (motion, BodyHistory { filtered_defect, undelivered, .. }) in
            self.motions.iter().zip(histories.iter_mut())
        {
            *undelivered += dt
                * (motion.force_defect + motion.pressure.force + motion.shear.force - motion.used);
            *filtered_defect += take_in * (motion.force_defect - *filtered_defect);
        }
        self.take_accelerations(domain, &s.bodies, histories, dt);
        self.take_displacements(s)?;
        domain.clock.lap(Stage::Force);
        Ok(())
    }

    /// Shares what pressure and wall shear miss of obstacles that are one solid among them by the
    /// areas of their walls: where one ends within the solid, the cells cannot tell.
    fn share_defect_of_joined(&mut self) {
        for (k, joined) in self.cut.joined.iter().enumerate() {
            // Once for all of them, by the first.
            if joined.first().is_none_or(|(first, _)| *first != k) {
                continue;
            }
            let mut area = 0.0;
            let mut whole = Vector3::zeros();
            for motion in joined.iter().map(|(j, _)| &self.motions[*j]) {
                area += motion.surface_moments.0;
                whole += motion.force_defect;
            }
            for (j, _) in joined {
                let motion = &mut self.motions[*j];
                motion.force_defect = motion.surface_moments.0 / area * whole;
            }
        }
    }

    /// Takes from what pressure and wall shear miss the part that two bodies with a gap between
    /// them that the grid does not resolve would do to each other along the line between their
    /// nearest points, or a wall to a body: whose it is of what the fluid lost there the cells
    /// cannot tell, and taken in with a delay it would be spurious work. The sum of a pair's stays.
    fn share_force_defect(&mut self, domain: &Domain<D>, bodies: &[Body]) {
        let cut = &self.cut;
        let motions = &mut self.motions;
        let periods = domain.periods();
        self.passed_on = Vector3::zeros();
        for i in 0..bodies.len() {
            for &j in cut.near.near[i].iter().filter(|j| **j > i) {
                let apart = nearest_image(&bodies[i].centre, &bodies[j].centre, &periods);
                let (n, gap) = gap(&bodies[i], &bodies[j], &apart);
                let share = Shares::of(gap / cut.h).across;
                let free = [i, j].map(|k| bodies[k].freedom().is_some());
                let along = share * (motions[i].force_defect - motions[j].force_defect).dot(&n);
                let (of_i, of_j) = match free {
                    [true, true] => (0.5 * along, -0.5 * along),
                    _ => (
                        share * motions[i].force_defect.dot(&n),
                        share * motions[j].force_defect.dot(&n),
                    ),
                };
                motions[i].force_defect -= of_i * n;
                motions[j].force_defect -= of_j * n;
                // Nothing of a free pair; else it is left to what holds the other.
                self.passed_on += (of_i + of_j) * n;
            }
            let reach = bodies[i].reach();
            for (a, side) in (0..D).flat_map(|a| [(a, 0), (a, 1)]) {
                let spans = match domain.boundaries.kinds[a][side] {
                    Some(BoundaryKind::Velocity(_)) => 1.0,
                    // To the body's own image.
                    Some(BoundaryKind::Slip) => 2.0,
                    _ => continue,
                };
                let centre = bodies[i].centre[a];
                let distance = if side == 0 { centre } else { domain.grid.size[a] - centre };
                let share = Shares::of(spans * (distance - reach[a]) / cut.h).across
                    * motions[i].force_defect[a];
                motions[i].force_defect[a] -= share;
                self.passed_on[a] += share;
            }
        }
    }
}
