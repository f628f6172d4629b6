//! Case -> scene: builds only what this scene needs, and says what it left out and why. The only
//! reader of the case.

mod begin;
mod build;
mod cells;
mod describe;
mod diagnostics;
mod dimensions;
mod division;
mod insertion;
mod sides;

use crate::clock::Stage;
use crate::config::{self, Axis, Case, OverTime, Side, WallRule};
use crate::contact::Impact;
use crate::domain::{Domain, Fluid};
use crate::drive::Drive;
use crate::error::NotFinite;
use crate::force::{Force, Forces};
use crate::grid::{Boundaries, Coefficient, GHOSTS, Grid};
use crate::kernels::{diffusion, faces};
use crate::method::{Method, MethodKind, energy, sharp};
use crate::particles::Body;
use crate::petsc::{Layout, Session};
use crate::poisson::pressure::{Projected, Projection, StoppingRule};
use crate::scheme::Limits;
use crate::state::{Readable, State};
use crate::varying::Varying;
use crate::{Error, Result};
pub use begin::{go_on_from, start_from};
pub(crate) use build::impact;
use build::{axes, body, method, refuse_shapes, scatter, solver};
pub use cells::read_case;
pub use describe::{needs, stages};
pub use diagnostics::gather;
pub(crate) use division::surface_work;
pub use insertion::{Passed, ids, keep_only, pass_boundaries};
use nalgebra::Vector3;
use sides::boundary;
use std::f64::consts::TAU;
use std::sync::Arc;

/// A scene that runs.
pub struct Scene<const D: usize> {
    /// The grid, the fluid, the pressure equation and the ranks.
    pub domain: Domain<D>,
    /// The state, which lasts from step to step.
    pub state: State<D>,
    /// The method of a step, and its scratch.
    pub method: Box<dyn Method<D>>,
    /// Reason for the choice of the pressure solver.
    pub(crate) solver_reason: &'static str,
    /// Courant number per second of the velocities that the boundaries prescribe, or a drive that
    /// varies holds, at their largest (1/s): in a fluid at rest nothing else tells it.
    boundary_rate: f64,
    /// Largest acceleration (m/s2) by which gravity may set off a body that has yet to come in.
    coming_fall: f64,
    /// The impacts that the case lets expect.
    impact: Impact,
    /// Scratch: motion of the bodies at the start of a step.
    motions: Vec<energy::BodyBefore>,
    /// Scratch: cells inside the bodies and their velocity (m/s).
    inside: Vec<(usize, [f64; D])>,
}

/// Outcome of a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Report {
    /// The pressure iteration.
    pub projected: Projected,
    /// Largest speed of the fluid, in a cell outside the bodies (m/s).
    pub largest_speed: f64,
}

impl std::ops::Deref for Report {
    type Target = Projected;

    fn deref(&self) -> &Projected {
        &self.projected
    }
}

impl<const D: usize> Scene<D> {
    /// Builds the scene that a case describes, at time 0: velocities set, bodies imposed, faces
    /// divergence-free. Collective.
    ///
    /// # Errors
    /// When PETSc refuses an option, there are too many ranks for the grid, or the first projection
    /// fails.
    pub fn new(session: &Session, case: &Case) -> Result<Scene<D>> {
        Scene::extended(session, case, None, Vec::new())
    }

    /// Builds the scene with these bodies, of any shape, in place of the particles; their numbers
    /// are their places among these. Collective.
    ///
    /// # Errors
    /// As [`Scene::extended`].
    pub fn with_bodies(session: &Session, case: &Case, bodies: Vec<Body>) -> Result<Scene<D>> {
        Scene::extended(session, case, Some(bodies), Vec::new())
    }

    /// Builds the scene with these bodies, or the case's particles where they are `None`, and with
    /// these forces per volume on the fluid. Collective.
    ///
    /// # Errors
    /// As [`Scene::new`]; and when the case asks for what a body's shape does not have, or its
    /// method has no such forces.
    pub fn extended(
        session: &Session,
        case: &Case,
        bodies: Option<Vec<Body>>,
        forces: Vec<Arc<dyn Force>>,
    ) -> Result<Scene<D>> {
        dimensions::build(session, case, bodies, forces)
    }

    fn build(
        session: &Session,
        case: &Case,
        bodies: Option<Vec<Body>>,
        forces: Vec<Arc<dyn Force>>,
    ) -> Result<Scene<D>> {
        let own = || case.particle.iter().map(body).collect();
        let mut bodies: Vec<Body> = bodies.unwrap_or_else(own);
        let given = bodies.len();
        bodies.extend((0..case.obstacle.len()).map(|number| build::obstacle(case, number)));
        bodies.iter_mut().enumerate().for_each(|(id, body)| body.id = id);
        build::sort_from_middle(&mut bodies[..given], &case.domain.size);
        refuse_shapes::<D>(case, &bodies)?;
        let domain = build_domain(session, case, &bodies, forces)?;
        let enters = |body: &Body| case.particle.get(body.id).is_some_and(|p| p.enter.is_some());
        let mut waiting: Vec<u64> =
            bodies.iter().filter(|body| enters(body)).map(|body| body.id as u64).collect();
        waiting.sort_unstable();
        let fluid = domain.fluid;
        let coming_fall = bodies
            .iter()
            .filter(|body| enters(body))
            .filter_map(|body| fall(body, &fluid))
            .fold(0.0, f64::max);
        // The impacts are those of all bodies as they start, so that a stiffness that nobody gave
        // is the same whoever comes and goes.
        let impact = build::impact(case, &bodies);
        bodies.retain(|body| !enters(body));
        let method = method(&domain, case, &bodies, impact);
        if method.kind() == MethodKind::Sharp
            && (!waiting.is_empty() || bodies.iter().any(|b| b.freedom().is_some()))
        {
            domain.projection.solver().refuse_without_low_rank()?;
        }
        if method.kind() == MethodKind::Mixture && domain.forces.is_some() {
            let why = "forces that vary act on fluid beside sharp surfaces: set coupling.wall = \
                       \"sharp\"";
            return Err(Error::Usage(why.into()));
        }
        let mut boundary_rate = domain.boundaries.courant_rate(&domain.grid);
        if let Some(Drive::Held { axis, velocity }) = domain.varying.largest_drive() {
            boundary_rate = boundary_rate.max(velocity.abs() / domain.grid.h[axis]);
        }
        let motions = Vec::with_capacity(bodies.len());
        let mut state = State::new(&domain.grid, bodies, build::extrapolates(case));
        state.waiting = waiting;
        let mut scene = Scene {
            domain,
            state,
            method,
            solver_reason: if case.pressure.solver == crate::config::Solver::Auto {
                "auto"
            } else {
                "as the case says"
            },
            boundary_rate,
            coming_fall,
            impact,
            motions,
            inside: Vec::new(),
        };
        scene.set_initial_flow(case);
        scene.start()?;
        Ok(scene)
    }

    /// Sets the velocity of the cells that a case begins with.
    fn set_initial_flow(&mut self, case: &Case) {
        self.set_initial_velocity(&axes(&case.initial.velocity), case.initial.perturbation);
        if let Some(speed) = case.initial.taylor_green {
            self.add_vortex(speed);
        }
        if let Some(axis) = case.initial.couette.map(Axis::index) {
            let velocity =
                |end| case.boundary.side(2 * axis + end).map_or(&[][..], Side::wall_velocity);
            self.add_couette(axis, [0, 1].map(velocity));
        }
    }

    /// Sets a uniform velocity (m/s) with a reproducible disturbance that does not depend on the
    /// ranks.
    fn set_initial_velocity(&mut self, velocity: &[f64; D], perturbation: f64) {
        let grid = &self.domain.grid;
        for axis in 0..D {
            for c in grid.rows().flatten() {
                let cell = grid.global_cell(c);
                let number = (0..D).rev().fold(axis, |n, a| n * grid.cells[a] + cell[a]);
                self.state.u[axis][c] = velocity[axis] + perturbation * scatter(number as u64);
            }
        }
    }

    /// Adds a vortex of Taylor and Green of a period in the box, of this largest speed (m/s).
    fn add_vortex(&mut self, speed: f64) {
        let grid = &self.domain.grid;
        for c in grid.rows().flatten() {
            let at = grid.centre(c);
            let phase: [f64; D] = std::array::from_fn(|a| TAU * at[a] / grid.size[a]);
            let rest: f64 = phase[2..].iter().map(|z| z.cos()).product();
            self.state.u[0][c] += speed * phase[0].sin() * phase[1].cos() * rest;
            self.state.u[1][c] -=
                speed * grid.size[1] / grid.size[0] * phase[0].cos() * phase[1].sin() * rest;
        }
    }

    /// Adds the Couette flow along an axis between walls of these velocities (m/s).
    fn add_couette(&mut self, axis: usize, walls: [&[f64]; 2]) {
        let [low, high] = walls.map(axes::<f64, D>);
        let grid = &self.domain.grid;
        for c in grid.rows().flatten() {
            let part = grid.centre(c)[axis] / grid.size[axis];
            for a in 0..D {
                self.state.u[a][c] += low[a] + part * (high[a] - low[a]);
            }
        }
    }

    /// Makes a consistent start from the cell velocities: bodies imposed, faces divergence-free to
    /// D0, pressure zero. Also for callers that set `state.u` themselves. Collective.
    ///
    /// # Errors
    /// When the first projection fails.
    pub fn start(&mut self) -> Result<()> {
        self.state.faces.iter_mut().for_each(|f| f.fill(0.0));
        self.domain.set_time(self.state.time);
        self.set_backflow_pressure();
        self.domain.take_forces(&self.state.u, self.state.time);
        self.method.start(&mut self.domain, &mut self.state)?;
        self.set_backflow_pressure();
        energy::start(&mut self.domain, &mut self.state, &mut *self.method)?;
        self.domain.clock = Default::default();
        Ok(())
    }

    /// Sets the pressure at outflows so that fluid comes in from rest in the next step.
    fn set_backflow_pressure(&mut self) {
        let Scene { domain, state, method, .. } = self;
        if domain.boundaries.set_backflow_pressure(domain.fluid.density, &state.faces, &mut state.p)
        {
            method.find_acceleration(domain, state);
        }
    }

    /// Takes the force of a drive that varies at a time (s). Collective.
    fn set_driving_force(&mut self, time: f64) -> Result<()> {
        let Scene { domain, state, method, .. } = self;
        let force = domain.varying.force_at(time);
        if force.is_some() && force != state.drive {
            state.drive = force;
            method.find_acceleration(domain, state);
            state.energy.powers.drive = domain.driving_power(state)?;
        }
        Ok(())
    }

    /// Advances the scene by `dt` (s). Collective.
    ///
    /// # Errors
    /// When the divergence cannot be brought below D0, or a value is no longer finite: names the
    /// cell or the particle.
    pub fn step(&mut self, dt: f64) -> Result<Report> {
        dimensions::step(self, dt)
    }

    fn advance(&mut self, dt: f64) -> Result<Report> {
        self.motions.clear();
        self.motions.extend(self.state.bodies.iter().map(energy::BodyBefore::of));
        let start = self.state.time;
        self.set_driving_force(start + 0.5 * dt)?;
        self.domain.take_forces(&self.state.u, start + 0.5 * dt);
        let power = energy::power_of_forces(&self.domain, &self.state.u, &*self.method)?;
        match self.method.step(&mut self.domain, &mut self.state, dt) {
            Err(Error::NotFinite(NotFinite::Velocity)) => {
                Err(diagnostics::name_what_is_lost(self)?)
            }
            Err(failed) => Err(failed),
            Ok(projected) => {
                let diagnostics::Energies { all_cells, inside, largest_speed } =
                    diagnostics::energies(self)?;
                self.state.energy.work.drive += 0.5
                    * dt
                    * (power
                        + energy::power_of_forces(&self.domain, &self.state.u, &*self.method)?);
                energy::close(
                    &mut self.domain,
                    &mut self.state,
                    &self.motions,
                    &*self.method,
                    [all_cells, inside],
                )?;
                self.set_backflow_pressure();
                self.domain.take_forces(&self.state.u, self.state.time);
                self.domain.clock.lap(Stage::Logs);
                self.domain.clock.count();
                Ok(Report { projected, largest_speed })
            }
        }
    }

    /// Goes on from the state as it is, which may have just been read: ghosts, what the bodies
    /// touch, the operator, the acceleration by the pressure. Collective.
    ///
    /// # Errors
    /// When a body is outside the box, or the state is another case's.
    pub fn resume(&mut self) -> Result<()> {
        self.resume_after(None)
    }

    /// As [`Scene::resume`]; the method takes over what it can use of the one `before`, which went
    /// on with some of these bodies. Collective.
    fn resume_after(&mut self, before: Option<Box<dyn Method<D>>>) -> Result<()> {
        let Scene { domain, state, method, .. } = self;
        let size: [f64; 3] =
            std::array::from_fn(|a| domain.grid.size.get(a).copied().unwrap_or(f64::INFINITY));
        let inside = |body: &Body| (0..D).all(|a| (0.0..=size[a]).contains(&body.centre[a]));
        if let Some(body) = state.bodies.iter().find(|body| !inside(body)) {
            return Err(Error::Usage(format!("it has {} outside the box", body.called())));
        }
        if state.time < 0.0 || state.dt < 0.0 {
            return Err(Error::Usage("its time runs backwards".into()));
        }
        domain.set_time(state.time);
        domain.boundaries.fill_velocity(&mut state.u)?;
        domain.boundaries.set_backflow_pressure(domain.fluid.density, &state.faces, &mut state.p);
        domain.boundaries.fill_pressure(&mut state.p)?;
        domain.take_forces(&state.u, state.time);
        method.resume(domain, state, before)?;
        domain.clock = Default::default();
        Ok(())
    }

    /// Drops all scratch and makes it anew from the `case`: the next steps are the same, bit for
    /// bit. Collective.
    ///
    /// # Errors
    /// As [`Scene::resume`].
    pub fn renew(&mut self, case: &Case) -> Result<()> {
        let clock = self.domain.clock.clone();
        let forces = self.domain.forces.take().map_or(Vec::new(), Forces::into_all);
        self.domain = build_domain(&self.domain.session, case, &self.state.bodies, forces)?;
        self.method = method(&self.domain, case, &self.state.bodies, self.impact);
        self.resume()?;
        self.domain.clock = clock;
        Ok(())
    }

    /// Brings back what [`State::keep`] copied, for readers; the next step would need more.
    pub fn restore(&mut self, kept: &Readable<D>) {
        self.state.restore(kept);
        self.method.place(&self.domain, &self.state);
    }

    /// The limits of the time step at the present velocities. Collective.
    pub fn limits(&self) -> Result<Limits> {
        let grid = &self.domain.grid;
        let scheme = self.method.scheme();
        let forces = self.domain.forces.as_ref().map_or(0.0, Forces::largest);
        let courant = faces::courant_rate(grid, &self.state.faces, scheme.by_axis);
        let mut rate = [courant.max(self.boundary_rate), forces];
        let smallest = grid.h.iter().fold(f64::INFINITY, |m, h| m.min(*h));
        rate[0] = self.state.bodies.iter().fold(rate[0], |m, b| m.max(b.top_speed() / smallest));
        self.domain.session.max(&mut rate)?;
        let (diffusion_rate, damping_rate) = self.diffusion_rates();
        let largest = self.domain.varying.largest_drive().map(|drive| drive.at_start());
        let varies = largest.filter(|force| *force != Vector3::zeros());
        let driven = varies.or(self.state.drive).map_or(0.0, |force| force.norm()) + rate[1];
        let driven = driven / self.domain.fluid.density;
        let courant_growth = (self.largest_fall() + driven) / smallest;
        Ok(Limits { courant_rate: rate[0], diffusion_rate, damping_rate, courant_growth, scheme })
    }

    /// The rate that limits the step (1/s), and the fluid's along the axis of the largest spacing.
    fn diffusion_rates(&self) -> (f64, f64) {
        let grid = &self.domain.grid;
        let Fluid { density, viscosity, .. } = self.domain.fluid;
        let mixed = self.method.kind() == MethodKind::Mixture;
        let bodies = || self.state.bodies.iter().filter(|_| mixed);
        let nu = bodies().map(|b| b.viscosity).fold(viscosity, f64::max)
            / bodies().map(|b| b.density).fold(density, f64::min);
        let widest = grid.h.iter().copied().fold(0.0, f64::max);
        let varies = matches!(self.method.mixture().viscosity, Coefficient::Field(_));
        let limit = diffusion::limit_rate(&grid.h, nu, varies);
        (limit, diffusion::limit_rate(&[widest], viscosity / density, false))
    }

    /// Largest acceleration (m/s2) by which gravity may set a free particle off that is there or
    /// comes in.
    pub fn largest_fall(&self) -> f64 {
        let coming = if self.state.waiting.is_empty() { 0.0 } else { self.coming_fall };
        self.state
            .bodies
            .iter()
            .filter_map(|body| fall(body, &self.domain.fluid))
            .fold(coming, f64::max)
    }

    /// The solver of the pressure equation and why it is taken, as `cg + boxmg (auto: ...)`.
    pub fn solver(&self) -> Result<String> {
        let solver = self.domain.projection.solver();
        let reason =
            if solver.chosen_by_options()? { "PETSc's options" } else { self.solver_reason };
        Ok(format!("{} ({reason})", solver.describe()?))
    }

    /// Kinetic energy of all cells, those inside bodies included (J; per metre of depth in 2D), and
    /// the largest speed of the fluid in cells outside the bodies (m/s). Collective.
    ///
    /// # Errors
    /// When a velocity is not finite: names the cell or the particle.
    pub fn energy_and_speed(&mut self) -> Result<(f64, f64)> {
        let diagnostics::Energies { all_cells, largest_speed, .. } = diagnostics::energies(self)?;
        Ok((all_cells, largest_speed))
    }
}

/// The acceleration (m/s2) by which gravity sets off a free body in a fluid, its added mass half
/// its volume's.
fn fall(body: &Body, fluid: &Fluid) -> Option<f64> {
    let Fluid { density, gravity, .. } = fluid;
    Some(
        body.freedom()?.along(gravity).norm() * (body.density - density).abs()
            / (body.density + 0.5 * density),
    )
}

/// The domain of a case with these bodies; what varies over time at its largest. Collective.
fn build_domain<const D: usize>(
    session: &Session,
    case: &Case,
    bodies: &[Body],
    forces: Vec<Arc<dyn Force>>,
) -> Result<Domain<D>> {
    let cells = axes(&case.domain.cells);
    let periodic = std::array::from_fn(|a| case.periodic(a));
    let sharp = build::walls_are_sharp(case, bodies);
    let ghosts = if sharp { sharp::ghost_width(&case.spacings()).1 } else { GHOSTS };
    let imbalance = |ranks: [usize; 3]| division::imbalance::<D>(case, axes(&ranks));
    let layout = Layout::balanced(session, &cells, &periodic, ghosts, &imbalance)?;
    let grid = Grid::new(cells, axes(&case.domain.size), periodic, &layout);
    let kinds = std::array::from_fn(|a| [0, 1].map(|s| boundary(&grid, [a, s], case, bodies)));
    let parabola = case.coupling.wall == WallRule::Sharp;
    let mut boundaries = Boundaries::new(session, &layout, &grid, kinds, parabola);
    let sides_work = session.anywhere(boundaries.do_work())?;
    let stopping = StoppingRule {
        limit: case.pressure.divergence_limit,
        tightening: case.pressure.tightening,
        max_iterations: case.pressure.max_iterations,
    };
    let choice = solver(case.pressure.solver);
    let projection = Projection::new(session, &layout, &grid, &boundaries, stopping, choice)?;
    let fluid = Fluid {
        density: case.fluid.density,
        viscosity: case.fluid.viscosity,
        gravity: Vector3::from(axes::<f64, 3>(&case.fluid.gravity)),
    };
    let session = session.clone();
    let mut drive = case.drive.as_ref().map(|drive| build::drive(case, drive));
    let factor = |a: usize, s: usize| case.boundary.side(2 * a + s).and_then(Side::over_time);
    let table = case.drive.as_ref().and_then(config::Drive::over_time);
    let varying = Varying::new(&boundaries, factor, drive.zip(table.cloned()));
    varying.set(OverTime::largest, &mut boundaries, &mut drive);
    Ok(Domain {
        session,
        forces: Forces::new(&grid, forces),
        grid,
        boundaries,
        sides_work,
        fluid,
        drive,
        varying,
        projection,
        clock: Default::default(),
    })
}
