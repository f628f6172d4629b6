//! Parts of a case in words, for `mics check` and reports.

use super::message::suggest;
use super::{
    Case, Contact, Damping, Drive, Loss, Motion, Obstacle, PairLaw, Particle, Side, Solid,
};
use crate::words::rounded;
use std::collections::BTreeSet;

impl Case {
    /// What a body is called: its name, with its number where others have the name too; without a
    /// name its number, from 0. Obstacles follow the particles.
    pub fn called(&self, id: usize) -> String {
        let name = |p: &Particle| p.name.clone();
        let wall =
            id.checked_sub(self.particle.len()).and_then(|k| Some((k, self.obstacle.get(k)?)));
        if let Some((k, obstacle)) = wall {
            return obstacle.name.clone().unwrap_or(format!("obstacle {k}"));
        }
        match self.particle.get(id).and_then(name) {
            None => format!("particle {id}"),
            Some(own)
                if self
                    .particle
                    .iter()
                    .filter(|p| p.name.as_ref() == Some(&own))
                    .nth(1)
                    .is_none() =>
            {
                own
            }
            Some(own) => format!("{own} {id}"),
        }
    }

    /// The particles of a number, from 0, or of a name.
    ///
    /// # Errors
    /// When there is none, in words.
    pub fn find(&self, wanted: &str) -> Result<Vec<usize>, String> {
        let count = self.particle.len();
        if let Ok(id) = wanted.parse::<usize>() {
            let unknown =
                || format!("there is no particle {id}: the case has {count}, counted from 0");
            return (id < count).then(|| vec![id]).ok_or_else(unknown);
        }
        let named = |id: &usize| self.particle[*id].name.as_deref() == Some(wanted);
        let ids: Vec<usize> = (0..count).filter(named).collect();
        let known = self.particle.iter().filter_map(|p| p.name.as_deref());
        if ids.is_empty() { Err(unnamed("particle", wanted, known)) } else { Ok(ids) }
    }

    /// What is said of the particles, each line with its label: of few one by one, of many their
    /// ranges.
    pub fn describe_particles(&self) -> Vec<(String, String)> {
        let widest = self.spacings().into_iter().fold(0.0, f64::max);
        let cells = |d: f64| d / widest;
        let ratio = |p: &Particle| p.density() / self.fluid.density;
        if self.particle.len() > 5 {
            let range = |f: &dyn Fn(&Particle) -> f64| {
                let values = self.particle.iter().map(f);
                values.fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)))
            };
            let (d, s) = (range(&|p| p.shape.diameter()), range(&ratio));
            let span = |(low, high): (f64, f64), say: &dyn Fn(f64) -> String| {
                let [low, high] = [low, high].map(say);
                if low == high { low } else { format!("{low} to {high}") }
            };
            let words = format!(
                "{}: d = {} m, d/h = {}, density ratio {}",
                self.particle.len(),
                span(d, &|d| rounded(d)),
                span((cells(d.0), cells(d.1)), &|n| format!("{n:.1}")),
                span(s, &|s| format!("{s:.4}"))
            );
            let shapes = self.describe_shapes().into_iter().map(|words| ("shapes".into(), words));
            let entering: Vec<_> = self.particle.iter().filter_map(|p| p.enter.as_ref()).collect();
            let first = entering.iter().map(|enter| enter.time).fold(f64::INFINITY, f64::min);
            let come = format!(
                "{} of them come in while the run goes on, the first at {first} s",
                entering.len()
            );
            let come = (!entering.is_empty()).then(|| ("enter".into(), come));
            return [("particles".into(), words)].into_iter().chain(shapes).chain(come).collect();
        }
        let line = |(id, p): (usize, &Particle)| {
            let motion = p.motion.describe();
            let d = p.shape.diameter();
            let enters = p
                .enter
                .as_ref()
                .map_or(String::new(), |enter| format!(", enters at {} s", enter.time));
            let words = format!(
                "{}d = {} m, d/h = {:.1}, density ratio {:.4}, {motion}{enters}",
                p.shape.solid().map_or(String::new(), |solid| self.describe_solid(solid) + ", "),
                rounded(d),
                cells(d),
                ratio(p)
            );
            (self.called(id), words)
        };
        self.particle.iter().enumerate().map(line).collect()
    }

    /// What is said of the obstacles, each line with its label.
    pub fn describe_obstacles(&self) -> Vec<(String, String)> {
        let widest = self.spacings().into_iter().fold(0.0, f64::max);
        let line = |(k, o): (usize, &Obstacle)| {
            let [low, high] = o.wall().bounds();
            let spans = ["x", "y", "z"].iter().enumerate().take(self.dimension());
            let spans = spans
                .map(|(a, x)| format!("{x} from {} to {} m", rounded(low[a]), rounded(high[a])));
            let thickness = o.wall().thickness();
            let thin = if thickness.is_finite() {
                format!("thinnest {} m = {:.1} cells, ", rounded(thickness), thickness / widest)
            } else {
                String::new()
            };
            let centre: Vec<String> = o.wall().centre().iter().map(|x| rounded(*x)).collect();
            let moves = match &o.motion {
                Motion::Prescribed(told) if told.turns() => {
                    format!("prescribed motion, turns about ({}) m", centre.join(", "))
                }
                Motion::Fixed => "fixed".to_owned(),
                _ => "prescribed motion".to_owned(),
            };
            let words = format!(
                "{}, walls within {}, {thin}{moves}, of {}",
                o.wall().detail(),
                spans.collect::<Vec<_>>().join(", "),
                o.material()
            );
            (self.called(self.particle.len() + k), words)
        };
        self.obstacle.iter().enumerate().map(line).collect()
    }

    /// A solid in words: what it is, how long and how thick.
    fn describe_solid(&self, solid: &Solid) -> String {
        let widest = self.spacings().into_iter().fold(0.0, f64::max);
        let name = solid.name();
        let detail = solid.detail();
        let geometry = solid.geometry();
        let length = 2.0 * geometry.radius();
        let thickness = geometry.thickness();
        format!(
            "{name}{detail}, up to {} m across, thinnest {} m = {:.1} cells",
            rounded(length),
            rounded(thickness),
            thickness / widest
        )
    }

    /// The shapes that are not round, a line each, with how many have them and how large they are.
    fn describe_shapes(&self) -> Vec<String> {
        let widest = self.spacings().into_iter().fold(0.0, f64::max);
        let mut kinds: Vec<(&Solid, usize, [f64; 2], f64)> = Vec::new();
        for solid in self.particle.iter().filter_map(|p| p.shape.solid()) {
            let d = solid.diameter();
            let thickness = solid.geometry().thickness();
            match kinds.iter_mut().find(|(other, ..)| other.is_like(solid)) {
                None => kinds.push((solid, 1, [d, d], thickness)),
                Some((_, count, [low, high], thinnest)) => {
                    (*count, *low, *high) = (*count + 1, low.min(d), high.max(d));
                    *thinnest = thinnest.min(thickness);
                }
            }
        }
        let line = |(solid, count, [low, high], thinnest): (&Solid, usize, [f64; 2], f64)| {
            let low = rounded(low);
            let high = rounded(high);
            let sizes = if low == high { low } else { format!("{low} to {high}") };
            let name = plural(solid.name(), count);
            format!(
                "{count} {name}{}, equal-volume diameter {sizes} m, thinnest {} m = {:.1} cells",
                solid.detail(),
                rounded(thinnest),
                thinnest / widest
            )
        };
        kinds.into_iter().map(line).collect()
    }
}

/// The name of so many of a shape.
fn plural(name: &str, count: usize) -> String {
    match (name, count) {
        (_, 1) => name.to_owned(),
        ("polyhedron", _) => "polyhedra".to_owned(),
        _ => format!("{name}s"),
    }
}

/// The refusal of a name that no particle, or obstacle, has, where these are known.
pub(super) fn unnamed<'a>(
    kind: &str,
    wanted: &str,
    known: impl Iterator<Item = &'a str>,
) -> String {
    let known: Vec<&str> = known.collect::<BTreeSet<_>>().into_iter().collect();
    let cure = match &known[..] {
        [] => format!("give it one, as in name = \"pier\" in its [[{kind}]]"),
        known => suggest(wanted, known),
    };
    format!("no {kind} has the name \"{wanted}\"; {cure}")
}

impl Motion {
    /// What moves a body, in words.
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
    /// The laws of contact in words: that of all materials, then what is different between two.
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

impl Drive {
    /// What drives the fluid, in words.
    pub fn describe(&self) -> String {
        match self {
            Drive::Force(force) => format!("a force of {force:?} N/m3 on the fluid"),
            Drive::Gravity(_) => "gravity along the periodic axes, on the fluid as well".into(),
            Drive::MeanVelocity(held) => format!(
                "the gradient of the pressure that holds a mean velocity of {} m/s along {}",
                held.value,
                ["x", "y", "z"][held.axis.index()]
            ),
        }
    }
}

impl Case {
    /// The axis along which a periodic box of free bodies accelerates as a whole: gravity acts
    /// along it, and nothing holds it.
    pub fn falls_as_a_whole(&self) -> Option<usize> {
        let free = self.particle.iter().all(Particle::is_free);
        let heavy = self.particle.iter().any(|p| p.density() != self.fluid.density);
        let boxed = (0..self.dimension()).all(|axis| self.periodic(axis));
        let axis = (0..self.dimension()).find(|axis| self.fluid.gravity[*axis] != 0.0)?;
        (free && heavy && boxed && self.drive.is_none()).then_some(axis)
    }
}

impl Side {
    /// The condition in words.
    pub fn describe(&self) -> String {
        match self {
            Side::Periodic => "periodic".into(),
            Side::Outflow => "outflow".into(),
            Side::Wall => "wall".into(),
            Side::Slip => "slip".into(),
            Side::MovingWall(v) => format!("moving wall {v:?} m/s"),
            Side::Inflow(v) => format!("inflow {v:?} m/s"),
            Side::InflowParabola(v) => format!("parabolic inflow, {v:?} m/s in the middle"),
            Side::InflowProfile(p) => format!("inflow profile of {} points", p.at.len()),
        }
    }
}
