//! Case -> scene: builds only what this scene needs, and says what it left out and why. The only reader of the case.

mod build;
mod cells;
mod words;

use crate::audit::Audit;
use crate::clock::Clock;
use crate::config::{self, Case};
use crate::coupling::Coupling;
use crate::coupling::mixing::{Choices, Driver, Mixing};
use crate::coupling::sharp::{self, Sharp};
use crate::error::NotFinite;
use crate::fluid::advection::Fluxes;
use crate::fluid::diffusion;
use crate::fluid::faces::{self, FaceCoefficient, Gravity};
use crate::fluid::pressure::{Projection, StoppingRule};
use crate::geometry::fraction;
use crate::grid::{Boundaries, Coefficient, GHOSTS, Grid, VectorField, largest, total, wide};
use crate::petsc::{Layout, Session};
use crate::scheme::{self, Limits, Scheme};
use crate::solids::Body;
use crate::{Error, Result};
use build::{axes, body, border, contacts, refuse_shapes, scatter, solver};
pub use cells::read_case;
use nalgebra::Vector3;

/// A scene that runs: the state, the terms that it needs and their scratch.
pub struct Scene<const D: usize> {
    /// The grid of this rank.
    pub grid: Grid<D>,
    /// Conditions at the borders.
    pub boundaries: Boundaries<D>,
    /// Velocity at cell centres (m/s), after mixing.
    pub u: VectorField<D>,
    /// Pressure without its hydrostatic part (Pa).
    pub p: Vec<f64>,
    /// Velocity through faces (m/s), divergence-free to D0.
    pub faces: VectorField<D>,
    /// Density of the mixture (kg/m3).
    pub density: Coefficient,
    /// Viscosity of the mixture (Pa s).
    pub viscosity: Coefficient,
    /// The particles; `None` in pure fluid.
    pub coupling: Option<Coupling<D>>,
    /// Time reached (s).
    pub time: f64,
    /// Steps done.
    pub steps: u64,
    /// Where the time goes.
    pub clock: Clock,
    /// The ranks.
    pub session: Session,
    /// `1/rho` on faces (m3/kg).
    pub beta: FaceCoefficient<D>,
    /// Reduced gravity, where something is free to fall in it.
    pub gravity: Option<Gravity<D>>,
    /// The pressure equation and its iteration.
    pub projection: Projection,
    /// Why it is solved as it is.
    pub(crate) solver_reason: &'static str,
    pub(crate) scheme: &'static Scheme,
    /// Courant number per second of what the borders prescribe (1/s): in a fluid at rest nothing else tells it.
    pub(crate) border_rate: f64,
    pub(crate) advection: Advection<D>,
    /// Pressure and gravity on faces (m/s2), of the pressure in `p`.
    pub(crate) acceleration: VectorField<D>,
    /// Face velocities of the step before, and those that carry in this one; `None` where `faces` themselves carry.
    pub(crate) faces_before: VectorField<D>,
    /// Weighted sum of the stages' rates (m/s2).
    pub(crate) total: VectorField<D>,
    /// Velocity that a stage starts from; between steps with sharp walls, that before the wall was imposed on it last (m/s).
    pub(crate) stage: VectorField<D>,
    pub(crate) fluxes: Fluxes,
    /// Scratch where the viscosity varies.
    pub(crate) scratch: Vec<f64>,
    pub(crate) dt_before: f64,
    /// The balance of momentum, where particles are free.
    pub audit: Option<Audit>,
    /// Whether the pressure is mixed too, (28, 29), and whether cells take (16) as printed.
    pub(crate) mix_pressure: bool,
    pub(crate) cell_gradient: bool,
    /// Substeps of the contacts in the last step.
    pub substeps: usize,
    pub(crate) properties_stale: bool,
    pub(crate) assembled: bool,
}

/// What a step starts from, to go back to.
#[derive(Clone, Debug)]
pub struct State<const D: usize> {
    /// Velocity (m/s).
    pub u: VectorField<D>,
    /// Pressure (Pa).
    pub p: Vec<f64>,
    /// The particles.
    pub bodies: Vec<Body>,
    /// Time (s).
    pub time: f64,
    /// Steps done.
    pub steps: u64,
}

impl<const D: usize> Default for State<D> {
    fn default() -> Self {
        State { u: std::array::from_fn(|_| Vec::new()), p: Vec::new(), bodies: Vec::new(), time: 0.0, steps: 0 }
    }
}

/// The advection scheme with its scratch.
pub(crate) enum Advection<const D: usize> {
    Upwind5,
    Upwind5Advective,
    Qsi { from: VectorField<D>, to: VectorField<D> },
}

impl<const D: usize> Scene<D> {
    /// Builds the scene that a case describes, at time 0: velocities set, bodies imposed, faces
    /// divergence-free. Collective.
    ///
    /// # Errors
    /// When PETSc refuses an option, there are too many ranks for the grid, or the first projection fails.
    pub fn new(session: &Session, case: &Case) -> Result<Scene<D>> {
        let bodies = case.particle.iter().map(body).collect();
        Scene::with_bodies(session, case, bodies)
    }

    /// The same with these bodies in place of the case's particles: of any shape, wherever a library's user has it from.
    /// Collective.
    ///
    /// # Errors
    /// As [`Scene::new`]; and when the case asks for what a body's shape does not have.
    pub fn with_bodies(session: &Session, case: &Case, bodies: Vec<Body>) -> Result<Scene<D>> {
        refuse_shapes::<D>(case, &bodies)?;
        let cells = axes(&case.domain.cells);
        let periodic = std::array::from_fn(|a| case.periodic(a));
        let walls_are_sharp = case.coupling.wall == config::WallRule::Sharp && !bodies.is_empty();
        let ghosts = if walls_are_sharp { sharp::reach(&case.spacings()).1 } else { GHOSTS };
        let layout = Layout::new(session, &cells, &periodic, ghosts)?;
        let grid = Grid::new(cells, axes(&case.domain.size), periodic, &layout);
        let borders = std::array::from_fn(|a| [0, 1].map(|s| border(&grid, a, &case.boundary[a][s])));
        let boundaries = Boundaries::new(session, &layout, &grid, borders);
        let stopping = StoppingRule {
            limit: case.pressure.divergence_limit,
            tightening: case.pressure.tightening,
            max_iterations: case.pressure.max_iterations,
        };
        let border_rate = boundaries.courant_rate(&grid);

        let property = |of_fluid: f64, of_body: fn(&Body) -> f64| {
            if walls_are_sharp || bodies.iter().all(|b| of_body(b) == of_fluid) {
                Coefficient::Uniform(of_fluid)
            } else {
                Coefficient::Field(vec![of_fluid; grid.field().len()])
            }
        };
        let density = property(case.fluid.density, |b| b.density);
        let viscosity = property(case.fluid.viscosity, |b| b.viscosity);
        let uniform = !walls_are_sharp && matches!(density, Coefficient::Uniform(_));
        let (choice, solver_reason) = solver(case.pressure.solver, uniform, session.size());
        let projection = Projection::new(session, &layout, &grid, &boundaries, stopping, choice)?;
        let rule = match case.coupling.fraction {
            config::FractionRule::Exact => fraction::Rule::Exact,
            config::FractionRule::Polygon => fraction::Rule::Polygon,
        };
        let flies = bodies.iter().any(|b| b.freedom().is_some());
        if walls_are_sharp && flies {
            projection.solver().refuse_preconditioner_alone()?;
        }
        let g = Vector3::from(axes::<f64, 3>(&case.fluid.gravity));
        let choices = Choices {
            fraction: rule,
            driver: if case.coupling.force == config::ForceRule::Literal { Driver::Literal } else { Driver::Momentum },
            rotation_at_boundary: case.coupling.rotation == config::RotationRule::Boundary,
            field_gravity: if case.coupling.buoyancy == config::Buoyancy::Faces { g } else { Vector3::zeros() },
            own_gravity: if case.coupling.buoyancy == config::Buoyancy::Particle { g } else { Vector3::zeros() },
        };
        let falls = |b: &Body| b.freedom().is_some() && b.density != case.fluid.density;
        let reduced = !walls_are_sharp && choices.field_gravity != Vector3::zeros() && bodies.iter().any(falls);
        let gravity = reduced.then(|| Gravity {
            g: std::array::from_fn(|a| g[a]),
            excess: std::array::from_fn(|a| if g[a] == 0.0 { Vec::new() } else { grid.field() }),
        });
        let law = case.contact.as_ref().filter(|_| flies).map(|law| contacts(case, law, &bodies));
        let (rho, mu) = (case.fluid.density, case.fluid.viscosity);
        let coupling = (!bodies.is_empty()).then(|| {
            if walls_are_sharp {
                Coupling::Sharp(Sharp::new(session, &grid, bodies, law, g, rho, mu))
            } else {
                Coupling::Mixing(Mixing::new(session, &grid, bodies, law, choices, rho, mu))
            }
        });
        let scheme = match (case.time.scheme, case.time.advection) {
            (_, config::Advection::Qsi) => &scheme::QSI,
            (config::Scheme::Euler, _) => &scheme::EULER,
            (config::Scheme::Rk2, _) => &scheme::RK2,
            (config::Scheme::Rk3, _) => &scheme::RK3,
        };
        let stages = scheme.weights.len() > 1 || walls_are_sharp;
        let nothing = || std::array::from_fn(|_| Vec::new());
        let conservative = case.time.advection == config::Advection::Upwind5;
        let extrapolates = scheme.centred && conservative;
        let mut scene = Scene {
            u: grid.vector_field(),
            p: grid.field(),
            faces: grid.vector_field(),
            beta: if walls_are_sharp {
                FaceCoefficient::Field(std::array::from_fn(|_| vec![1.0 / rho; grid.field().len()]))
            } else {
                FaceCoefficient::new(&grid, &density)
            },
            gravity,
            advection: match case.time.advection {
                config::Advection::Upwind5 => Advection::Upwind5,
                config::Advection::Upwind5Advective => Advection::Upwind5Advective,
                config::Advection::Qsi => Advection::Qsi { from: grid.vector_field(), to: grid.vector_field() },
            },
            acceleration: grid.vector_field(),
            faces_before: if extrapolates { grid.vector_field() } else { nothing() },
            total: grid.vector_field(),
            stage: if stages { grid.vector_field() } else { nothing() },
            fluxes: Fluxes::new(&grid),
            scratch: if matches!(viscosity, Coefficient::Field(_)) { grid.field() } else { Vec::new() },
            time: 0.0,
            steps: 0,
            clock: Clock::default(),
            session: session.clone(),
            dt_before: 0.0,
            audit: flies.then(Audit::default),
            mix_pressure: case.coupling.mix_pressure,
            cell_gradient: case.coupling.gradient == config::GradientRule::Cells,
            substeps: 0,
            properties_stale: true,
            assembled: false,
            grid,
            boundaries,
            density,
            viscosity,
            coupling,
            projection,
            solver_reason,
            scheme,
            border_rate,
        };
        scene.set_initial_velocity(&axes(&case.initial.velocity), case.initial.perturbation);
        scene.start()?;
        Ok(scene)
    }

    /// Sets a uniform velocity (m/s) with a reproducible disturbance that does not depend on the ranks.
    fn set_initial_velocity(&mut self, velocity: &[f64; D], perturbation: f64) {
        for axis in 0..D {
            for c in self.grid.rows().flatten() {
                let cell = self.grid.global_cell(c);
                let number = (0..D).rev().fold(axis, |n, a| n * self.grid.cells[a] + cell[a]);
                self.u[axis][c] = velocity[axis] + perturbation * scatter(number as u64);
            }
        }
    }

    /// Makes a consistent start from the cell velocities: bodies imposed, faces divergence-free to D0, pressure zero.
    /// Also for callers that set `u` themselves. Collective.
    pub fn start(&mut self) -> Result<()> {
        if matches!(self.coupling, Some(Coupling::Sharp(_))) {
            return self.start_sharp();
        }
        self.mix_properties()?;
        if let Some(coupling) = self.coupling.as_mut().and_then(Coupling::mixing) {
            coupling.start_tally();
            coupling.impose(&self.grid, &self.density, 1.0, &mut self.u);
            coupling.start_tally();
        }
        self.p.fill(0.0);
        self.boundaries.fill_velocity(&mut self.u)?;
        self.acceleration.iter_mut().for_each(|f| f.fill(0.0));
        faces::predict(&self.grid, &self.u, 0.0, &self.acceleration, &mut self.faces);
        self.boundaries.set_faces(&mut self.faces);
        // With dt = 1 the potential is the pressure's impulse; it corrects the cells and is forgotten.
        self.projection.project(
            &self.grid,
            &mut self.boundaries,
            &self.beta,
            1.0,
            &mut self.p,
            &mut self.faces,
            None,
        )?;
        faces::acceleration(&self.grid, &self.beta, None, &self.p, &mut self.acceleration);
        self.boundaries.extrapolate_to_closed_faces(&mut self.acceleration);
        faces::add_to_cells(&self.grid, 1.0, &self.acceleration, &mut self.u);
        if let Some(coupling) = self.coupling.as_mut().and_then(Coupling::mixing) {
            coupling.impose(&self.grid, &self.density, 1.0, &mut self.u);
            coupling.start_tally();
        }
        self.p.fill(0.0);
        faces::acceleration(&self.grid, &self.beta, self.gravity.as_ref(), &self.p, &mut self.acceleration);
        self.boundaries.extrapolate_to_closed_faces(&mut self.acceleration);
        self.boundaries.fill_velocity(&mut self.u)?;
        self.clock = Clock::default();
        Ok(())
    }

    /// Copies what a reader of the fields needs into `state`.
    pub fn save(&self, state: &mut State<D>) {
        for (to, from) in state.u.iter_mut().zip(&self.u).chain([(&mut state.p, &self.p)]) {
            to.clone_from(from);
        }
        if let Some(coupling) = &self.coupling {
            state.bodies.clear();
            state.bodies.extend_from_slice(coupling.bodies());
        }
        (state.time, state.steps) = (self.time, self.steps);
    }

    /// Brings back what [`Scene::save`] kept, for readers; the next step would need more.
    pub fn load(&mut self, state: &State<D>) {
        for (to, from) in self.u.iter_mut().zip(&state.u).chain([(&mut self.p, &state.p)]) {
            to.clone_from(from);
        }
        match &mut self.coupling {
            None => {}
            Some(Coupling::Mixing(c)) => c.place(&self.grid, &state.bodies),
            Some(Coupling::Sharp(c)) => c.place(&self.grid, &self.boundaries, &mut self.beta, &state.bodies),
        }
        (self.time, self.steps) = (state.time, state.steps);
    }

    /// The limits of the time step at the present velocities. Collective.
    pub fn limits(&self) -> Result<Limits> {
        let mut rate = [faces::courant_rate(&self.grid, &self.faces, self.scheme.by_axis).max(self.border_rate)];
        let smallest = self.grid.h.iter().fold(f64::INFINITY, |m, h| m.min(*h));
        if let Some(coupling) = &self.coupling {
            rate[0] = coupling.bodies().iter().fold(rate[0], |m, b| m.max(b.top_speed() / smallest));
        }
        self.session.max(&mut rate)?;
        let (diffusion_rate, damping_rate) = self.diffusion_rates();
        let courant_growth = self.coupling.as_ref().map_or(0.0, |c| c.largest_fall()) / smallest;
        Ok(Limits { courant_rate: rate[0], diffusion_rate, damping_rate, courant_growth, scheme: self.scheme })
    }

    /// The rate that limits the step (1/s), and the fluid's along the axis of the largest spacing.
    fn diffusion_rates(&self) -> (f64, f64) {
        let bodies = || self.coupling.iter().filter(|c| matches!(c, Coupling::Mixing(_))).flat_map(|c| c.bodies());
        let (viscosity, density) = match &self.coupling {
            Some(Coupling::Mixing(c)) => (c.fluid_viscosity(), c.fluid_density()),
            Some(Coupling::Sharp(_)) | None => (self.viscosity.at(0), self.density.at(0)),
        };
        let nu = bodies().map(|b| b.viscosity).fold(viscosity, f64::max)
            / bodies().map(|b| b.density).fold(density, f64::min);
        let widest = self.grid.h.iter().copied().fold(0.0, f64::max);
        let limit = diffusion::limit_rate(&self.grid.h, nu, matches!(self.viscosity, Coefficient::Field(_)));
        (limit, diffusion::limit_rate(&[widest], viscosity / density, false))
    }

    /// Kinetic energy of the mixture (J; per metre of depth in 2D) and the largest speed in a cell (m/s). Collective.
    ///
    /// # Errors
    /// When a velocity is not finite: names the cell or the particle.
    pub fn energy_and_speed(&self) -> Result<(f64, f64)> {
        let (sum, most) = self.squares();
        let (mut energy, mut fastest) = ([sum], [most]);
        energy[0] *= 0.5 * self.grid.cell_volume();
        self.session.sum(&mut energy)?;
        self.session.max(&mut fastest)?;
        if !energy[0].is_finite() {
            return Err(self.name_what_is_lost()?);
        }
        Ok((energy[0], fastest[0].sqrt()))
    }

    /// Over this rank's cells, the sum of density times squared velocity and the largest squared velocity.
    fn squares(&self) -> (f64, f64) {
        let (grid, u) = (&self.grid, &self.u);
        wide(
            #[inline(always)]
            || {
                let (mut sum, mut most) = (0.0, 0.0f64);
                for row in grid.rows() {
                    let u: [&[f64]; D] = std::array::from_fn(|a| &u[a][row.clone()]);
                    let square = |i: usize| u.iter().map(|u| u[i] * u[i]).sum::<f64>();
                    sum += match &self.density {
                        Coefficient::Uniform(rho) => rho * total(row.len(), square),
                        Coefficient::Field(rho) => {
                            let rho = &rho[row.clone()];
                            total(
                                row.len(),
                                #[inline(always)]
                                |i| rho[i] * square(i),
                            )
                        }
                    };
                    most = most.max(largest(row.len(), square));
                }
                (sum, most)
            },
        )
    }

    /// The error for a value that is not finite, with the first cell that holds one; without one, the first particle. Collective.
    pub fn name_what_is_lost(&self) -> Result<Error> {
        let fields: Vec<&[f64]> = self.u.iter().chain([&self.p]).map(Vec::as_slice).collect();
        let found = (0..fields.len())
            .find_map(|k| self.grid.rows().flatten().find(|&c| !fields[k][c].is_finite()).map(|c| (k, c)));
        // The highest rank that found one speaks for all.
        let rank = self.session.rank() as f64;
        let mut speaker = [if found.is_some() { rank } else { -1.0 }];
        self.session.max(&mut speaker)?;
        let mut place = [0.0; 7];
        if let Some((field, c)) = found.filter(|_| speaker[0] == rank) {
            place[0] = field as f64;
            for a in 0..D {
                place[1 + a] = self.grid.global_cell(c)[a] as f64;
                place[4 + a] = self.grid.centre(c)[a];
            }
        }
        self.session.sum(&mut place)?;
        if speaker[0] < 0.0 {
            let bodies = self.coupling.as_ref().map_or(&[][..], Coupling::bodies);
            let lost = bodies.iter().position(|body| !body.is_finite());
            return Ok(Error::NotFinite(lost.map_or(NotFinite::Energy, NotFinite::Particle)));
        }
        let names = ["the velocity along x", "the velocity along y", "the velocity along z", "the pressure"];
        Ok(Error::NotFinite(NotFinite::Cell {
            field: if place[0] as usize == D { names[3] } else { names[place[0] as usize] },
            cell: place[1..1 + D].iter().map(|i| *i as usize).collect(),
            at: place[4..4 + D].to_vec(),
        }))
    }

    /// The owned cells of all ranks, x fastest, on rank 0 (empty elsewhere). Collective.
    pub fn gather(&self, field: &[f64]) -> Result<Vec<f64>> {
        let grid = &self.grid;
        let mut bytes: Vec<f64> = (0..D).flat_map(|a| [grid.start[a] as f64, grid.local[a] as f64]).collect();
        grid.rows().for_each(|row| bytes.extend_from_slice(&field[row]));
        let mut whole = if self.session.rank() == 0 { vec![0.0; grid.total_cells()] } else { Vec::new() };
        self.session.gather(&bytes, |_, part| {
            let (head, values) = part.split_at(2 * D);
            let (start, local): ([usize; D], [usize; D]) =
                (std::array::from_fn(|a| head[2 * a] as usize), std::array::from_fn(|a| head[2 * a + 1] as usize));
            for (k, row) in values.chunks_exact(local[0]).enumerate() {
                let (mut rest, mut at, mut stride) = (k, start[0], grid.cells[0]);
                for a in 1..D {
                    at += (start[a] + rest % local[a]) * stride;
                    rest /= local[a];
                    stride *= grid.cells[a];
                }
                whole[at..at + local[0]].copy_from_slice(row);
            }
        })?;
        Ok(whole)
    }
}
