//! Description of a case in words: the lines of `mics check`, and the list of a report.

use super::fault::AXES;
use super::{
    Advection, Cadence, Case, Checkpoints, Contact, Damping, Drive, Loss, Motion, OverTime,
    PairLaw, Scheme, Side, Solid, Step,
};
use crate::words::{number, rounded};
use std::fmt;

/// A line of the description of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// The thing described: `fluid`, say, or the name of a body.
    pub label: String,
    /// Its description.
    pub words: String,
}

impl fmt::Display for Line {
    fn fmt(&self, to: &mut fmt::Formatter) -> fmt::Result {
        write!(to, "{:<13}{}", self.label, self.words)
    }
}

fn line(label: impl Into<String>, words: impl Into<String>) -> Line {
    Line { label: label.into(), words: words.into() }
}

/// The values of all as "LOW to HIGH", or as one where both read the same.
fn span(values: impl Iterator<Item = f64>, say: impl Fn(f64) -> String) -> String {
    let ends = values.fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], value| {
        [low.min(value), high.max(value)]
    });
    let [low, high] = ends.map(say);
    if low == high { low } else { format!("{low} to {high}") }
}

/// Words one after the other.
fn join(words: impl Iterator<Item = String>, between: &str) -> String {
    words.collect::<Vec<_>>().join(between)
}

impl Case {
    /// The box, its fluid, what is given at its sides and what drives it.
    pub fn describe_box(&self) -> Vec<Line> {
        let size = join(self.domain.size.iter().map(|x| number(*x)), " x ");
        let cells = join(self.domain.cells.iter().map(usize::to_string), " x ");
        let h = join(self.spacings().iter().map(|h| format!("{h:.4e}")), " x ");
        let gravity = match self.fluid.gravity.iter().all(|g| *g == 0.0) {
            true => "no gravity".to_owned(),
            false => format!("gravity {:?} m/s2", self.fluid.gravity),
        };
        let density = number(self.fluid.density);
        let viscosity = number(self.fluid.viscosity);
        let fluid = format!("density {density} kg/m3, viscosity {viscosity} Pa s, {gravity}");
        let sides = self.sides().map(|(name, side)| format!("{name} {}", side.describe()));
        let drive = self.drive.as_ref().map(|drive| line("drive", drive.describe()));
        let begins = self.initial.from.as_ref();
        let begins = begins.map(|run| line("begins", format!("where {run} has come to")));
        let all = [
            line("case", format!("{} ({}D)", self.name, self.dimension())),
            line("domain", format!("{size} m, {cells} cells, h = {h} m")),
            line("fluid", fluid),
            line("boundary", join(sides, ", ")),
        ];
        all.into_iter().chain(drive).chain(begins).collect()
    }

    /// The particles (up to five one by one, more by their ranges), obstacles and materials.
    pub fn describe_bodies(&self) -> Vec<Line> {
        let particles: Vec<Line> = match self.particle.len() {
            0..=5 => (0..self.particle.len()).map(|id| self.describe_particle(id)).collect(),
            _ => self.describe_many(),
        };
        let obstacles = (0..self.obstacle.len()).map(|k| self.describe_obstacle(k));
        let materials = self.contact.iter().flat_map(Contact::describe);
        let materials = materials.map(|words| line("materials", words));
        particles.into_iter().chain(obstacles).chain(materials).collect()
    }

    /// End time, time steps, time scheme and advection scheme.
    pub fn describe_time(&self) -> Line {
        let steps = match self.time.length() {
            Step::Fixed(step) => format!("steps of {step} s"),
            Step::Courant(number) => format!("steps by a Courant number of {number}"),
        };
        let scheme = match self.time.scheme() {
            Scheme::Euler => "Euler",
            Scheme::Rk2 => "two-stage Runge-Kutta",
            Scheme::Rk3 => "three-stage Runge-Kutta",
            Scheme::Rkl2 => "Runge-Kutta of two stages, Legendre's of more where viscosity asks",
            Scheme::Rkl3 => "Runge-Kutta of three stages, Legendre's of more where viscosity asks",
        };
        let advection = match self.time.advection {
            Advection::Upwind5 => "fifth-order upwind, conservative",
            Advection::Qsi => "QSI, semi-Lagrangian",
        };
        let end = self.time.end;
        line("time", format!("to t = {end} s, {steps}, {scheme}; advection: {advection}"))
    }

    /// The solver of the pressure equation, and its limit of the divergence (1/s).
    pub fn describe_pressure(&self, solver: &str) -> Line {
        let limit = self.pressure.divergence_limit;
        line("pressure", format!("{solver}, until |D| < {limit:e} 1/s"))
    }

    /// A length (m), and how many cells that is.
    fn thinnest(&self, thickness: f64) -> String {
        let cells = thickness / self.widest_spacing();
        format!("thinnest {} m = {cells:.1} cells", rounded(thickness))
    }

    fn describe_particle(&self, id: usize) -> Line {
        let p = &self.particle[id];
        let d = p.shape.diameter();
        let solid = |solid: &Solid| {
            let length = rounded(2.0 * solid.geometry().radius());
            let thinnest = self.thinnest(solid.geometry().thickness());
            format!("{}{}, up to {length} m across, {thinnest}, ", solid.name(), solid.detail())
        };
        let words = format!(
            "{}d = {} m, d/h = {:.1}, density ratio {:.4}, {}{}",
            p.shape.solid().map(solid).unwrap_or_default(),
            rounded(d),
            d / self.widest_spacing(),
            p.density() / self.fluid.density,
            p.motion.describe(),
            p.enter.as_ref().map(|e| format!(", enters at {} s", e.time)).unwrap_or_default()
        );
        line(self.called(id), words)
    }

    /// Many particles: their ranges, their shapes, and the time (s) at which the first one enters.
    fn describe_many(&self) -> Vec<Line> {
        let count = self.particle.len();
        let h = self.widest_spacing();
        let diameters = || self.particle.iter().map(|p| p.shape.diameter());
        let d = span(diameters(), rounded);
        let cells = span(diameters().map(|d| d / h), |n| format!("{n:.1}"));
        let ratios = self.particle.iter().map(|p| p.density() / self.fluid.density);
        let ratio = span(ratios, |s| format!("{s:.4}"));
        let words = format!("{count}: d = {d} m, d/h = {cells}, density ratio {ratio}");
        let mut lines = vec![line("particles", words)];
        lines.extend(self.describe_shapes());
        let times = || self.particle.iter().filter_map(|p| Some(p.enter.as_ref()?.time));
        if let Some(first) = times().min_by(f64::total_cmp) {
            let count = times().count();
            let words =
                format!("{count} of them come in while the run goes on, the first at {first} s");
            lines.push(line("enter", words));
        }
        lines
    }

    /// The shapes that are not round, a line each, with how many have them and how large they are.
    fn describe_shapes(&self) -> Vec<Line> {
        let mut kinds: Vec<Vec<&Solid>> = Vec::new();
        for solid in self.particle.iter().filter_map(|p| p.shape.solid()) {
            match kinds.iter_mut().find(|kind| kind[0].is_like(solid)) {
                None => kinds.push(vec![solid]),
                Some(kind) => kind.push(solid),
            }
        }
        let words = |kind: Vec<&Solid>| {
            let count = kind.len();
            let name = plural(kind[0].name(), count);
            let detail = kind[0].detail();
            let sizes = span(kind.iter().map(|solid| solid.diameter()), rounded);
            let thickness = kind.iter().map(|solid| solid.geometry().thickness());
            let thinnest = self.thinnest(thickness.fold(f64::INFINITY, f64::min));
            format!("{count} {name}{detail}, equal-volume diameter {sizes} m, {thinnest}")
        };
        kinds.into_iter().map(|kind| line("shapes", words(kind))).collect()
    }

    fn describe_obstacle(&self, k: usize) -> Line {
        let obstacle = &self.obstacle[k];
        let wall = obstacle.wall();
        let [low, high] = wall.bounds().map(|end| end.map(rounded));
        let spans = (0..self.dimension())
            .map(|axis| format!("{} from {} to {} m", AXES[axis], low[axis], high[axis]));
        let thickness = Some(wall.thickness()).filter(|thickness| thickness.is_finite());
        let thin = thickness.map(|thickness| self.thinnest(thickness) + ", ").unwrap_or_default();
        let moves = match &obstacle.motion {
            Motion::Prescribed(told) if told.turns() => {
                let centre = join(wall.centre().iter().map(|x| rounded(*x)), ", ");
                format!("prescribed motion, turns about ({centre}) m")
            }
            Motion::Fixed => "fixed".to_owned(),
            _ => "prescribed motion".to_owned(),
        };
        let words = format!(
            "{}, walls within {}, {thin}{moves}, of {}",
            wall.detail(),
            join(spans, ", "),
            obstacle.material()
        );
        line(self.called(self.particle.len() + k), words)
    }
}

/// Name of a shape, plural for `count` of them.
fn plural(name: &str, count: usize) -> String {
    match (name, count) {
        (_, 1) => name.to_owned(),
        ("polyhedron", _) => "polyhedra".to_owned(),
        _ => format!("{name}s"),
    }
}

impl Motion {
    /// Motion of a body in words.
    fn describe(&self) -> String {
        let Motion::Prescribed(told) = self else { return self.name().to_owned() };
        let swing = told.oscillation.as_ref().map_or(String::new(), |o| {
            let speed = o.speed();
            format!(", to and fro by {:?} m at {} 1/s ({speed:.4} m/s)", o.amplitude, o.frequency)
        });
        format!("prescribed motion{swing}")
    }
}

impl Contact {
    /// The laws of contact in words: those of pairs, then that of all other materials.
    pub fn describe(&self) -> Vec<String> {
        let words = |law: PairLaw| {
            let loss = match law.loss {
                Loss::Restitution(e) => format!("restitution {}", rounded(e)),
                Loss::Damping(Damping { normal, tangential }) => {
                    let [normal, tangential] = [normal, tangential].map(rounded);
                    format!("damping {normal} and {tangential} N s/m, normal and tangential")
                }
            };
            let stiffness = match law.normal_stiffness.given() {
                Some(k) if law.exponent == 1.0 => format!("normal stiffness {} N/m", rounded(k)),
                Some(k) => format!("normal stiffness {} N/m^{}", rounded(k), rounded(law.exponent)),
                None => "normal stiffness \"auto\"".into(),
            };
            let rolling = match law.rolling_friction {
                0.0 => String::new(),
                lever => format!(", rolling friction {}", rounded(lever)),
            };
            format!("friction {}{rolling}, {loss}, {stiffness}", rounded(law.friction))
        };
        let all = if self.pair.is_empty() { "all contacts" } else { "all other contacts" };
        let pairs = self.pair.iter().map(|pair| {
            format!("{}: {}", pair.between.join(" with "), words(pair.law(self.law())))
        });
        pairs.chain([format!("{all}: {}", words(self.law()))]).collect()
    }
}

/// The factor of an inflow or a drive in words, ahead of which its value stands; empty for none.
fn over_time(table: Option<&OverTime>) -> String {
    table.map_or(String::new(), |table| {
        let least = table.factor.iter().copied().fold(f64::INFINITY, f64::min);
        let most = table.factor.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        format!(", times {} to {} over time", number(least), number(most))
    })
}

impl Drive {
    /// Drive of the fluid in words.
    pub fn describe(&self) -> String {
        let words = match self {
            Drive::Force(force) => format!("a force of {:?} N/m3 on the fluid", force.vector()),
            Drive::Gravity(_) => "gravity along the periodic axes, on the fluid as well".into(),
            Drive::MeanVelocity(held) => format!(
                "the gradient of the pressure that holds a mean velocity of {} m/s along {}",
                held.value,
                AXES[held.axis.index()]
            ),
        };
        words + &over_time(self.over_time())
    }
}

impl Side {
    /// The condition in words.
    pub fn describe(&self) -> String {
        let words = match self {
            Side::Periodic => "periodic".into(),
            Side::Outflow => "outflow".into(),
            Side::Wall => "wall".into(),
            Side::Slip => "slip".into(),
            Side::MovingWall(v) => format!("moving wall {v:?} m/s"),
            Side::Inflow(v) => format!("inflow {:?} m/s", v.velocity()),
            Side::InflowParabola(v) => {
                format!("parabolic inflow, {:?} m/s in the middle", v.velocity())
            }
            Side::InflowHalfParabola(v) => {
                format!("half-parabolic inflow, {:?} m/s at the top", v.velocity())
            }
            Side::InflowLog(p) => format!(
                "logarithmic inflow, {:?} m/s in the mean over a bed of roughness {:?} m",
                p.velocity, p.roughness
            ),
            Side::InflowProfile(p) => format!("inflow profile of {} points", p.at.len()),
        };
        words + &over_time(self.over_time())
    }
}

impl Cadence {
    /// Interval in words.
    pub fn describe(&self) -> String {
        match self {
            Cadence::Steps(1) => "every step".to_owned(),
            Cadence::Steps(n) => format!("every {n} steps"),
            Cadence::Time(time) => format!("every {} s", number(*time)),
        }
    }
}

impl Checkpoints {
    /// Interval in words.
    pub fn describe(&self) -> String {
        match self {
            Checkpoints::Steps(n) => format!("every {n} steps"),
            Checkpoints::WallMinutes(minutes) => format!("every {} minutes", number(*minutes)),
        }
    }
}
