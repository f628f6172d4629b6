//! A case: what the user typed, checked. Pure data; [`crate::scene`] alone turns it into a running scene.
//!
//! SI units are named throughout; any consistent set works.

mod read;
mod validate;

pub use read::{Loaded, load, schema};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A whole case file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// The case's name; the run folder is `runs/NAME` unless `--out` names another.
    pub name: String,
    /// The box and its grid.
    pub domain: Domain,
    /// The carrier fluid.
    pub fluid: Fluid,
    /// One condition per face of the box.
    pub boundary: Boundary,
    /// Bodies, one by one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub particle: Vec<Particle>,
    /// The fluid at time 0.
    #[serde(default)]
    pub initial: Initial,
    /// How fluid and particles meet.
    #[serde(default)]
    pub coupling: Coupling,
    /// Time stepping.
    pub time: Time,
    /// The pressure equation and its stopping rule.
    #[serde(default)]
    pub pressure: Pressure,
    /// Raw PETSc options.
    #[serde(default)]
    pub petsc: Petsc,
    /// What `summary.json` reports.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measure: Vec<Measure>,
    /// What is written, and how often.
    #[serde(default)]
    pub output: Output,
}

/// The names of the faces of the box, in the order of [`Case::sides`]: face `f` closes axis `f / 2`, opposite `f ^ 1`.
pub const FACES: [&str; 6] = ["west", "east", "south", "north", "bottom", "top"];

impl Case {
    /// 2 or 3: how many numbers `domain.size` has.
    pub fn dimension(&self) -> usize {
        self.domain.size.len()
    }

    /// The conditions in the order of [`FACES`]; bottom and top are `None` in 2D.
    pub fn sides(&self) -> [Option<&Side>; 6] {
        let b = &self.boundary;
        [Some(&b.west), Some(&b.east), Some(&b.south), Some(&b.north), b.bottom.as_ref(), b.top.as_ref()]
    }

    /// The speed that coefficients refer to (m/s): the fastest inflow's; without one, the initial velocity's; without
    /// one, the fastest moving wall's. `None` where all of these rest.
    pub fn reference_speed(&self) -> Option<f64> {
        let speed = |v: &Vec<f64>| v.iter().map(|c| c * c).sum::<f64>().sqrt();
        let sides = || self.sides().into_iter().flatten();
        let inflows = sides().flat_map(Side::inflow).map(speed).fold(0.0, f64::max);
        let initial = self.initial.velocity.as_ref().map_or(0.0, speed);
        let walls = sides().map(|s| if let Side::MovingWall(v) = s { speed(v) } else { 0.0 }).fold(0.0, f64::max);
        [inflows, initial, walls].into_iter().find(|speed| *speed > 0.0)
    }

    /// The velocity of the fluid at time 0 (m/s): as given, else the first inflow's (at its middle), else rest.
    pub fn initial_velocity(&self) -> Vec<f64> {
        let middle = |(face, side): (usize, Option<&Side>)| match side? {
            Side::Inflow(v) | Side::InflowParabola(v) => Some(v.clone()),
            Side::InflowProfile(p) => Some(p.velocity_at(0.5 * self.domain.size[usize::from(face < 2)])),
            _ => None,
        };
        let given = self.initial.velocity.clone();
        given.or_else(|| self.sides().into_iter().enumerate().find_map(middle)).unwrap_or(vec![0.0; self.dimension()])
    }

    /// Writes out what a valid case leaves unsaid, so that `case.toml` in the run folder says it; the meaning stays.
    fn fill_defaults(&mut self) {
        let rest = vec![0.0; self.dimension()];
        self.initial.velocity = Some(self.initial_velocity());
        self.initial.perturbation.get_or_insert(0.0);
        self.fluid.gravity.get_or_insert(rest.clone());
        for particle in &mut self.particle {
            particle.density.get_or_insert(self.fluid.density);
            particle.viscosity.get_or_insert(self.fluid.viscosity);
            if let Motion::Prescribed(motion) = &mut particle.motion {
                motion.velocity.get_or_insert(rest.clone());
                motion.spin.get_or_insert(if rest.len() == 2 { Spin::Plane(0.0) } else { Spin::Space([0.0; 3]) });
            }
        }
        if self.time.step.is_none() {
            // Euler steps with upwind advection reach less far than all others.
            let short = self.time.scheme == Scheme::Euler && self.time.advection != Advection::Qsi;
            self.time.cfl.get_or_insert(if short { 0.2 } else { 0.4 });
        }
        let reference = self.reference_speed();
        for measure in self.measure.iter_mut().filter(|m| m.kind.needs_particle()) {
            measure.speed = measure.speed.or(reference);
            measure.force.get_or_insert(self.coupling.force);
        }
    }
}

/// The box, from the origin to `size`, cut into equal cells.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// Edge lengths (m); two numbers make a 2D case, three a 3D one.
    pub size: Vec<f64>,
    /// Cells along each edge; at least 6.
    pub cells: Vec<usize>,
}

/// The carrier fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fluid {
    /// Density (kg/m3), positive.
    pub density: f64,
    /// Dynamic viscosity (Pa s), zero (inviscid) or positive.
    pub viscosity: f64,
    /// Gravity (m/s2), default none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Vec<f64>>,
}

/// One condition per face: west/east close x, south/north close y, bottom/top close z (3D only).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Boundary {
    /// Low x.
    pub west: Side,
    /// High x.
    pub east: Side,
    /// Low y.
    pub south: Side,
    /// High y.
    pub north: Side,
    /// Low z, 3D only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bottom: Option<Side>,
    /// High z, 3D only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub top: Option<Side>,
}

/// What happens at one face of the box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Side {
    /// Joined to the opposite face.
    Periodic,
    /// Zero-gradient velocity at zero pressure.
    Outflow,
    /// No slip, at rest.
    Wall,
    /// No flow through, no shear.
    Slip,
    /// No slip, moving in its own plane with this velocity (m/s).
    MovingWall(Vec<f64>),
    /// This velocity (m/s), uniform over the face.
    Inflow(Vec<f64>),
    /// A parabola that vanishes at the face's edges, with this velocity (m/s) at its middle.
    InflowParabola(Vec<f64>),
    /// Velocity along the face's first tangential axis, linear between the points given.
    InflowProfile(Profile),
}

impl Side {
    /// The velocities (m/s) that an inflow is given by: one, or one a point of its profile; none for other sides.
    pub fn inflow(&self) -> &[Vec<f64>] {
        match self {
            Side::Inflow(v) | Side::InflowParabola(v) => std::slice::from_ref(v),
            Side::InflowProfile(profile) => &profile.velocity,
            _ => &[],
        }
    }
}

/// A velocity profile: linear between points, constant beyond the first and last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Coordinates along the face's first tangential axis (m), increasing.
    pub at: Vec<f64>,
    /// One velocity (m/s) for each coordinate.
    pub velocity: Vec<Vec<f64>>,
}

impl Profile {
    /// The velocity (m/s) at coordinate `s` (m) along the face's first tangential axis.
    pub fn velocity_at(&self, s: f64) -> Vec<f64> {
        let next = self.at.partition_point(|at| *at <= s).clamp(1, self.at.len() - 1);
        let (s0, s1) = (self.at[next - 1], self.at[next]);
        let weight = ((s - s0) / (s1 - s0)).clamp(0.0, 1.0);
        let (low, high) = (&self.velocity[next - 1], &self.velocity[next]);
        low.iter().zip(high).map(|(a, b)| a + weight * (b - a)).collect()
    }
}

/// One body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Particle {
    /// Its shape.
    pub shape: Shape,
    /// Density (kg/m3), default the fluid's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Viscosity inside the particle (Pa s), default the fluid's; the paper has 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub viscosity: Option<f64>,
    /// Centre at time 0 (m).
    pub position: Vec<f64>,
    /// What moves it; default free.
    #[serde(default)]
    pub motion: Motion,
}

/// The shape of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// A disc (2D), of unit depth.
    Disc(Round),
    /// A sphere (3D).
    Sphere(Round),
}

impl Shape {
    /// The diameter (m) of a disc or sphere.
    pub fn diameter(&self) -> f64 {
        let (Shape::Disc(round) | Shape::Sphere(round)) = self;
        round.diameter
    }
}

/// The size of a disc or sphere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Round {
    /// Diameter (m).
    pub diameter: f64,
}

/// What moves a body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Motion {
    /// Forces and contacts move it (not in this version: refused).
    #[default]
    Free,
    /// It rests.
    Fixed,
    /// It moves as told, whatever the forces.
    Prescribed(Prescribed),
}

/// A prescribed motion: constant velocity and spin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Prescribed {
    /// Velocity of the centre (m/s), default zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<f64>>,
    /// Angular velocity (rad/s): one number in 2D (positive from x to y), three in 3D; default zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spin: Option<Spin>,
}

/// An angular velocity: one number in 2D, three in 3D (rad/s).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a spin is one number in 2D, three in 3D (rad/s)")]
pub enum Spin {
    /// About the axis that points at the viewer of a 2D scene.
    Plane(f64),
    /// About x, y, z.
    Space([f64; 3]),
}

/// The fluid at time 0.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Initial {
    /// Uniform velocity (m/s); default the inflow's (of its middle, where it has a profile), or rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<f64>>,
    /// Amplitude (m/s) of a reproducible pseudo-random disturbance of every cell, made divergence-free by the first
    /// step; it breaks the symmetry of a wake. Default none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub perturbation: Option<f64>,
}

/// How fluid and particles meet.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// How the volume fractions are found.
    #[serde(default)]
    pub fraction: FractionRule,
    /// Which force `fluid_f*` in `particles.csv`, and the measures, report.
    #[serde(default)]
    pub force: ForceRule,
}

/// How the volume fraction of a particle in a cell is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FractionRule {
    /// The exact overlap of disc (sphere) and cell.
    #[default]
    Exact,
    /// The paper's polygon through the crossings of circle and grid, its missing area spread over the cut cells; 2D.
    Polygon,
}

/// Which force a particle is said to feel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ForceRule {
    /// The momentum that the mixing (27) takes from the fluid.
    #[default]
    Momentum,
    /// Eq. (19) as printed: convective + pressure + viscous parts, weighted by the fraction.
    Literal,
}

/// Time stepping: exactly one of `step` and `cfl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Time {
    /// When the run ends (s).
    pub end: f64,
    /// A fixed step (s), refused where it breaks a stability limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<f64>,
    /// Steps from this Courant number, sum over axes of |u| dt/h, and from the other limits; default 0.4 (0.2 for
    /// Euler steps with upwind advection).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cfl: Option<f64>,
    /// The time scheme.
    #[serde(default)]
    pub scheme: Scheme,
    /// The advection scheme.
    #[serde(default)]
    pub advection: Advection,
}

/// The time scheme of the prediction (7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// First order, the paper's.
    Euler,
    /// Second order: strong-stability-preserving Runge-Kutta, two stages.
    #[default]
    Rk2,
    /// Three stages, stable at larger steps; second order with the projection.
    Rk3,
}

/// The advection scheme.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Advection {
    /// Conservative: fifth-order upwind values carried by the divergence-free face velocities.
    #[default]
    Upwind5,
    /// `-u.grad u` as printed in (7), fifth-order upwind differences.
    Upwind5Advective,
    /// The paper's QSI: semi-Lagrangian local quintic, axis by axis; `scheme = "euler"` only.
    Qsi,
}

/// The pressure equation and its stopping rule.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Pressure {
    /// D0 (1/s): C-HSMAC iterates until every cell's |D| is below it.
    pub divergence_limit: f64,
    /// How much tighter the linear solve is asked to be at each further iteration (a in eps_k = a^k eps).
    pub tightening: f64,
    /// C-HSMAC iterations a step may take before the run fails.
    pub max_iterations: usize,
    /// The linear solver.
    pub solver: Solver,
}

impl Default for Pressure {
    fn default() -> Self {
        Pressure { divergence_limit: 1e-6, tightening: 0.1, max_iterations: 20, solver: Solver::default() }
    }
}

/// The linear solver of the pressure equation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Solver {
    /// BiCGStab with hypre's BoomerAMG.
    #[default]
    BcgsBoomeramg,
}

/// Raw PETSc options.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Petsc {
    /// As on a PETSc command line: `"-ksp_type cg -pc_type gamg"`.
    pub options: String,
}

/// One number that `summary.json` reports.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Its name in `summary.json`.
    pub name: String,
    /// What is measured.
    pub kind: MeasureKind,
    /// Of which particle (its index in the case).
    #[serde(default)]
    pub particle: usize,
    /// From this time on (s).
    #[serde(default)]
    pub from: f64,
    /// Reference speed (m/s), default the inflow's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// Which force, default the coupling's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<ForceRule>,
}

/// What a measure is. Coefficients are forces over `0.5 rho_f speed^2 d` (2D, per unit depth) or
/// `0.5 rho_f speed^2 pi d^2/4` (3D); means are over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MeasureKind {
    /// Mean of the force along x, as a coefficient.
    DragCoefficient,
    /// Mean of the force along y, as a coefficient.
    LiftCoefficient,
    /// Root mean square of the lift coefficient about its mean.
    LiftRms,
    /// Half the span of the lift coefficient.
    LiftAmplitude,
    /// `f d/speed` of the lift, from its upward crossings of the mean.
    Strouhal,
    /// Largest speed of the fluid over the domain and over time (m/s).
    MaxSpeed,
}

impl MeasureKind {
    /// Whether it is of one particle: a coefficient or frequency, made dimensionless with a reference speed.
    pub fn needs_particle(self) -> bool {
        self != MeasureKind::MaxSpeed
    }
}

/// What is written, and how often.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Rows of `particles.csv`; default every step.
    pub particles: Cadence,
    /// Snapshots under `fields/`; default only the first and the last state.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fields: Option<Cadence>,
    /// Figures of the last state as PNG and SVG; default yes.
    pub figures: bool,
}

impl Default for Output {
    fn default() -> Self {
        Output { particles: Cadence { every: Some(1), every_time: None }, fields: None, figures: true }
    }
}

/// How often: exactly one of the two.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cadence {
    /// Every so many steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every: Option<u64>,
    /// Every so much time (s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every_time: Option<f64>,
}
