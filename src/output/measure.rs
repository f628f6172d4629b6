//! Measures: numbers that a run reports, each from a series of samples in time.

use super::fit::{self, Morison};
use super::midline;
use crate::Result;
use crate::archive::{Archive, Checkpointed};
use crate::config::{Case, ForceRule, Measure, MeasureKind, When};
use crate::particles::{Body, Motion};
use crate::scene::Scene;
use crate::state::Exchange;
use mics_run::compare::{Comparison, measured, percent, significant};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// A measure and its samples so far.
pub struct Series {
    measure: Measure,
    rule: ForceRule,
    /// Force (N) of a coefficient of 1.
    force_scale: f64,
    /// Reference speed over diameter (1/s).
    rate: f64,
    /// Against gravity, of length 1; zero without gravity.
    up: Vector3<f64>,
    /// Edges of the box (m).
    size: [f64; 3],
    samples: Vec<(f64, f64)>,
    morison: Morison,
    /// What the newest snapshot or the moment that was waited for gave.
    found: Option<f64>,
    /// Coordinate (m) and value at the step before, of a measure that waits for a moment.
    passing: Option<(f64, f64)>,
    /// Time of the step before (s), and that at which the first sample began.
    before: f64,
    began: f64,
}

/// The part by which a speed or a mean may change and still be called steady: as well as the best
/// values of this program are known.
const STEADY: f64 = 1e-2;

/// What is to be said of a value beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct Remark {
    /// Whether the value may not be what its name says.
    pub doubt: bool,
    /// In words that follow on the value.
    pub words: String,
}

/// What a step gives to the measures.
pub struct Sample<'a> {
    /// Time at its end (s).
    pub time: f64,
    /// What each particle exchanged with the fluid over it.
    pub exchange: &'a [Exchange],
    /// The particles at its end.
    pub bodies: &'a [Body],
    /// Largest speed of the fluid (m/s).
    pub max_speed: f64,
    /// Deepest overlap of contacts (m).
    pub deepest: f64,
    /// Per particle, whether it touched something; empty without contacts.
    pub touched: &'a [bool],
}

/// One series for each measure of the case.
pub fn series(case: &Case) -> Vec<Series> {
    let axis = |a: usize| case.fluid.gravity.get(a).copied().unwrap_or(0.0);
    let up = -Vector3::from_fn(|a, _| axis(a)).try_normalize(0.0).unwrap_or_default();
    let of = |m: &Measure| {
        // Of no use to what has none.
        let speed = m.speed.unwrap_or(f64::NAN);
        let diameter = case.particle.get(m.particle).map_or(1.0, |p| p.shape.diameter());
        let circle = 0.25 * PI * diameter * diameter;
        let (area, volume) = if case.dimension() == 2 {
            (diameter, circle)
        } else {
            (circle, 2.0 / 3.0 * diameter * circle)
        };
        let density = case.fluid.density;
        Series {
            morison: Morison::new(density, area, volume),
            before: 0.0,
            began: 0.0,
            found: None,
            passing: None,
            rule: m.force,
            force_scale: 0.5 * density * speed * speed * area,
            rate: speed / diameter,
            up,
            size: std::array::from_fn(|a| {
                case.domain.size.get(a).copied().unwrap_or(f64::INFINITY)
            }),
            samples: Vec::new(),
            measure: m.clone(),
        }
    };
    case.measure.iter().map(of).collect()
}

impl Series {
    /// What is measured.
    pub fn measure(&self) -> &Measure {
        &self.measure
    }

    /// The measure's name.
    pub fn name(&self) -> &str {
        &self.measure.name
    }

    /// Goes on with what the same measure has found.
    pub fn take_over(&mut self, old: Series) {
        let (measure, force_scale, rate) = (self.measure.clone(), self.force_scale, self.rate);
        *self = Series { measure, force_scale, rate, ..old };
    }

    /// Begins at a time (s) of a run that goes on.
    pub fn begin_at(&mut self, time: f64) {
        (self.before, self.began) = (time, time);
    }

    /// The value so far beside the measure's reference; `None` where the measure has none.
    pub fn comparison(&self) -> Option<Comparison> {
        Comparison::of(&self.measure, self.value())
    }

    /// Takes what the fields give of a kind that is of them. Collective.
    ///
    /// # Errors
    /// When ranks cannot add up what they have.
    pub fn take_fields<const D: usize>(&mut self, scene: &Scene<D>) -> Result<()> {
        if self.measure.kind.is_of_midline() {
            self.found = midline::extremum(self.measure.kind, scene)?;
        }
        Ok(())
    }

    /// Takes the state after a step, and what [`survey`](super::survey::survey) gives of it, of a
    /// kind that is of the whole box.
    pub fn sample(
        &mut self,
        &Sample { time, exchange, bodies, max_speed, deepest, touched }: &Sample,
        of_box: f64,
    ) {
        let before = std::mem::replace(&mut self.before, time);
        let dt = time - before;
        if time < self.measure.from {
            return;
        }
        let at = |id: usize| place(bodies, id);
        let particle = at(self.measure.particle).unwrap_or(usize::MAX);
        let kind = self.measure.kind;
        // What has left has no more samples.
        if (kind.needs_particle() && particle == usize::MAX)
            || (kind.is_of_group() && self.group(bodies).next().is_none())
        {
            return;
        }
        let force_on = |id: usize| {
            exchange.get(id).map_or_else(Vector3::zeros, |e| match self.rule {
                ForceRule::Momentum => e.momentum,
                ForceRule::Literal => e.literal(),
            })
        };
        let (force, direction) = (force_on(particle), self.measure.direction.unwrap_or_default());
        let coefficient = || force.dot(&direction) / self.force_scale;
        if let (true, Some(Motion::Prescribed(Some(path)))) =
            (self.measure.kind.fits_morison(), bodies.get(particle).map(|b| b.motion))
        {
            self.morison.add(&path, &force, dt);
        }
        let body = |of: &dyn Fn(&Body) -> f64| bodies.get(particle).map_or(0.0, of);
        let value = match self.measure.kind {
            MeasureKind::MaxSpeed => max_speed,
            MeasureKind::DragCoefficient
            | MeasureKind::DragCoefficientMax
            | MeasureKind::LiftCoefficient
            | MeasureKind::LiftCoefficientMax
            | MeasureKind::LiftRms
            | MeasureKind::LiftAmplitude
            | MeasureKind::Strouhal => coefficient(),
            MeasureKind::LiftMagnitude => {
                (force - force.dot(&direction) * direction).norm() / self.force_scale
            }
            MeasureKind::Force => self.group(bodies).map(|k| force_on(k).dot(&direction)).sum(),
            MeasureKind::LargestSpeed | MeasureKind::TerminalSpeed => body(&|b| b.velocity.norm()),
            MeasureKind::PositionX => body(&|b| b.centre.x),
            MeasureKind::PositionY => body(&|b| b.centre.y),
            MeasureKind::PositionZ => body(&|b| b.centre.z),
            MeasureKind::VelocityX => body(&|b| b.velocity.x),
            MeasureKind::VelocityY => body(&|b| b.velocity.y),
            MeasureKind::VelocityZ => body(&|b| b.velocity.z),
            MeasureKind::Spin => body(&|b| b.spin.z),
            MeasureKind::MorisonDrag
            | MeasureKind::MorisonInertia
            | MeasureKind::MorisonResidual => 0.0,
            MeasureKind::ForceNoise => force.dot(&direction),
            MeasureKind::MidlineULeast
            | MeasureKind::MidlineVLeast
            | MeasureKind::MidlineVLargest => return,
            MeasureKind::MeanHeight => self.mean_height(bodies),
            MeasureKind::HeightRank => self.height_rank(bodies),
            MeasureKind::FastestParticle => {
                self.group(bodies).map(|id| bodies[id].velocity.norm()).fold(0.0, f64::max)
            }
            MeasureKind::LargestOverlap => deepest,
            MeasureKind::MeanSpeed => self.mean_of(bodies, |b| b.velocity.norm()),
            MeasureKind::RmsSpeed => self.mean_of(bodies, |b| b.velocity.norm_squared()).sqrt(),
            MeasureKind::ContactStart => f64::from(touched.get(particle).copied().unwrap_or(false)),
            MeasureKind::TransportRate
            | MeasureKind::SuperficialVelocity
            | MeasureKind::FlowRate
            | MeasureKind::PressureDrop
            | MeasureKind::DriveForce
            | MeasureKind::SolidFraction
            | MeasureKind::BedHeight
            | MeasureKind::FluidEnergy
            | MeasureKind::BodyEnergy => of_box,
            MeasureKind::Dissipation | MeasureKind::DissipationTime => {
                let Some((was, _)) = self.passing.replace((of_box, 0.0)) else { return };
                return self.keep(before, (time - 0.5 * dt, (was - of_box) / dt));
            }
        };
        match self.measure.when {
            None => self.keep(before, (time, value)),
            Some(When::Contact) => {
                let touches = touched.get(particle).copied().unwrap_or(false);
                self.found = self.found.or(touches.then_some(value));
            }
            Some(When::X(at)) => self.wait(at, body(&|b| b.centre.x), value, self.size[0]),
            Some(When::Y(at)) => self.wait(at, body(&|b| b.centre.y), value, self.size[1]),
            Some(When::Z(at)) => self.wait(at, body(&|b| b.centre.z), value, self.size[2]),
            Some(When::Time(at)) => self.wait(at, time, value, f64::INFINITY),
        }
    }

    /// The particles that the measure is of.
    fn group<'a>(&'a self, bodies: &'a [Body]) -> impl Iterator<Item = usize> + 'a {
        self.measure.particles.iter().filter_map(|id| place(bodies, *id))
    }

    fn mean_of(&self, bodies: &[Body], value: impl Fn(&Body) -> f64) -> f64 {
        self.group(bodies).map(|id| value(&bodies[id])).sum::<f64>()
            / self.group(bodies).count() as f64
    }

    fn mean_height(&self, bodies: &[Body]) -> f64 {
        let height = |id: usize| bodies[id].centre.dot(&self.up);
        let lowest = (0..bodies.len()).map(height).fold(f64::INFINITY, f64::min);
        self.group(bodies).map(|id| height(id) - lowest).sum::<f64>()
            / self.group(bodies).count() as f64
    }

    fn height_rank(&self, bodies: &[Body]) -> f64 {
        let height = |id: usize| bodies[id].centre.dot(&self.up);
        let rank =
            |id: usize| 1 + (0..bodies.len()).filter(|other| height(*other) < height(id)).count();
        self.group(bodies).map(rank).sum::<usize>() as f64 / self.group(bodies).count() as f64
    }

    /// Takes the value as what it is waited for passes `at`, on the straight line between two
    /// steps; a way of more than half of the `length` is no way, but one across a period or back to
    /// an entrance.
    fn wait(&mut self, at: f64, now: f64, value: f64, length: f64) {
        let (Some((before, value_before)), None) = (self.passing.replace((now, value)), self.found)
        else {
            return;
        };
        if (now - before).abs() > 0.5 * length {
            return;
        }
        let share = (at - before) / (now - before);
        self.found =
            (0.0..=1.0).contains(&share).then_some(value_before + share * (value - value_before));
    }

    /// Keeps a sample: the one that counts where one does, so that a long run takes no more memory
    /// than a short one.
    fn keep(&mut self, before: f64, new: (f64, f64)) {
        if self.samples.is_empty() {
            self.began = before.max(self.measure.from);
        }
        let counts = |kept: (f64, f64)| match self.measure.kind {
            MeasureKind::MaxSpeed
            | MeasureKind::LargestSpeed
            | MeasureKind::LargestOverlap
            | MeasureKind::Dissipation
            | MeasureKind::DissipationTime
            | MeasureKind::DragCoefficientMax
            | MeasureKind::LiftCoefficientMax => Some(new.1 > kept.1),
            MeasureKind::PositionX
            | MeasureKind::PositionY
            | MeasureKind::PositionZ
            | MeasureKind::MeanHeight
            | MeasureKind::HeightRank
            | MeasureKind::FastestParticle => Some(true),
            MeasureKind::ContactStart => Some(kept.1 <= 0.0),
            _ => None,
        };
        match self.samples.last_mut().map(|kept| (counts(*kept), kept)) {
            None | Some((None, _)) => self.samples.push(new),
            Some((Some(better), kept)) if better => *kept = new,
            Some(_) => {}
        }
    }

    /// Mean over time of samples, of which the first began at `began` (s): of forces, which are
    /// means over their steps, from the start of the first one on; of what is known at the ends of
    /// steps, by trapezia between them.
    fn mean(&self, samples: &[(f64, f64)], began: f64) -> Option<f64> {
        let (first, last) = (samples.first()?, samples.last()?);
        let begin = if self.measure.kind.is_mean_of_step() { began } else { first.0 };
        if last.0 <= begin {
            return Some(first.1);
        }
        let pairs = samples.windows(2).map(|pair| (pair[0], pair[1]));
        let area: f64 = if self.measure.kind.is_mean_of_step() {
            first.1 * (first.0 - begin) + pairs.map(|(a, b)| b.1 * (b.0 - a.0)).sum::<f64>()
        } else {
            pairs.map(|(a, b)| 0.5 * (a.1 + b.1) * (b.0 - a.0)).sum()
        };
        Some(area / (last.0 - begin))
    }

    /// The measure's value; `None` where the samples do not give one (no steps in its window, no
    /// oscillation, no contact).
    pub fn value(&self) -> Option<f64> {
        if self.found.is_some() || self.measure.when.is_some() {
            return self.found;
        }
        self.value_of(&self.samples, self.began)
    }

    /// The value that samples give, of which the first began at `began` (s).
    fn value_of(&self, samples: &[(f64, f64)], began: f64) -> Option<f64> {
        let values = || samples.iter().map(|s| s.1);
        let (low, high) =
            values().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let mean = self.mean(samples, began)?;
        match self.measure.kind {
            MeasureKind::DragCoefficient
            | MeasureKind::LiftCoefficient
            | MeasureKind::LiftMagnitude
            | MeasureKind::Force
            | MeasureKind::VelocityX
            | MeasureKind::VelocityY
            | MeasureKind::VelocityZ
            | MeasureKind::MeanSpeed
            | MeasureKind::RmsSpeed
            | MeasureKind::TransportRate
            | MeasureKind::SuperficialVelocity
            | MeasureKind::FlowRate
            | MeasureKind::PressureDrop
            | MeasureKind::DriveForce
            | MeasureKind::SolidFraction
            | MeasureKind::BedHeight
            | MeasureKind::FluidEnergy
            | MeasureKind::BodyEnergy
            | MeasureKind::Spin => Some(mean),
            MeasureKind::MaxSpeed
            | MeasureKind::LargestSpeed
            | MeasureKind::LargestOverlap
            | MeasureKind::Dissipation
            | MeasureKind::DragCoefficientMax
            | MeasureKind::LiftCoefficientMax => Some(high),
            MeasureKind::TerminalSpeed => fit::steadiest_quarter(samples).map(|part| part.speed),
            MeasureKind::DissipationTime => samples.last().map(|s| s.0),
            MeasureKind::MorisonDrag => self.morison.coefficients().map(|c| c.x),
            MeasureKind::MorisonInertia => self.morison.coefficients().map(|c| c.y),
            MeasureKind::MorisonResidual => self.morison.residual(),
            MeasureKind::ForceNoise => fit::noise(samples),
            MeasureKind::PositionX
            | MeasureKind::PositionY
            | MeasureKind::PositionZ
            | MeasureKind::MeanHeight
            | MeasureKind::HeightRank
            | MeasureKind::FastestParticle => samples.last().map(|s| s.1),
            MeasureKind::ContactStart => samples.iter().find(|s| s.1 > 0.0).map(|s| s.0),
            MeasureKind::LiftAmplitude => Some(0.5 * (high - low)),
            MeasureKind::LiftRms => {
                let squares: Vec<_> =
                    samples.iter().map(|&(t, v)| (t, (v - mean) * (v - mean))).collect();
                self.mean(&squares, began).map(f64::sqrt)
            }
            // A lift coefficient that moves by less is a steady wake, whatever its last digits do.
            MeasureKind::Strouhal if high - low < 2e-3 => None,
            MeasureKind::Strouhal => frequency(samples, mean).map(|f| f / self.rate),
            MeasureKind::MidlineULeast
            | MeasureKind::MidlineVLeast
            | MeasureKind::MidlineVLargest => None,
        }
    }

    /// What a reader has to know of the value: whether a fall is steady, or that a mean counts the
    /// start of the flow.
    pub fn remark(&self) -> Option<Remark> {
        if self.measure.kind == MeasureKind::TerminalSpeed {
            let part = fit::steadiest_quarter(&self.samples)?;
            let varies = percent(part.variation);
            return Some(if part.variation <= STEADY {
                Remark { doubt: false, words: format!("steady within {varies}") }
            } else {
                let words = format!(
                    "not steady: over that quarter of the way the speed changes by {varies}; a \
                    longer fall comes nearer to its end"
                );
                Remark { doubt: true, words }
            });
        }
        if matches!(
            self.measure.kind,
            MeasureKind::DragCoefficientMax | MeasureKind::LiftCoefficientMax
        ) {
            let at = significant(self.samples.last()?.0);
            return Some(Remark { doubt: false, words: format!("at t = {at} s") });
        }
        if !self.measure.kind.counts_the_start() || self.measure.from > 0.0 || self.began > 0.0 {
            return None;
        }
        let (first, last) = (self.samples.first()?, self.samples.last()?);
        let middle = 0.5 * (first.0 + last.0);
        let at = self.samples.partition_point(|sample| sample.0 <= middle);
        let (value, began) = (self.value()?, self.samples.get(at.checked_sub(1)?)?.0);
        let later = self.value_of(&self.samples[at..], began)?;
        let differs = (value - later).abs() > STEADY * value.abs().max(later.abs());
        // A lift is small beside the drag that scales it.
        let counts = self.measure.kind == MeasureKind::Force || (value - later).abs() > STEADY;
        (differs && counts).then(|| Remark {
            doubt: true,
            words: format!(
                "counts the start of the flow; from t = {} s on it is {}: set `from`",
                significant(began),
                measured(later)
            ),
        })
    }
}

impl Checkpointed for Series {
    fn serialize(&mut self, archive: &mut Archive) -> Result<()> {
        let Series {
            samples,
            morison,
            before,
            began,
            found,
            passing,
            measure: _,
            rule: _,
            force_scale: _,
            rate: _,
            up: _,
            size: _,
        } = self;
        archive.serialize([samples, before, began, found, passing, morison])
    }
}

/// Where in a list of bodies, in the order of their numbers, that of a number is; `None` once it
/// has left.
fn place(bodies: &[Body], id: usize) -> Option<usize> {
    match bodies.get(id) {
        Some(body) if body.id == id => Some(id),
        _ => bodies.binary_search_by_key(&id, |body| body.id).ok(),
    }
}

/// Oscillations per unit time from the first to the last upward crossing of `level`. A crossing
/// counts after the signal has been below the level by a tenth of its depth, so that noise makes
/// none.
fn frequency(samples: &[(f64, f64)], level: f64) -> Option<f64> {
    let depth = samples.iter().map(|s| level - s.1).fold(0.0, f64::max);
    let (mut armed, mut crossings) = (false, Vec::new());
    for w in samples.windows(2) {
        armed |= level - w[0].1 > 0.1 * depth;
        if armed && w[0].1 < level && w[1].1 >= level {
            crossings.push(w[0].0 + (level - w[0].1) / (w[1].1 - w[0].1) * (w[1].0 - w[0].0));
            armed = false;
        }
    }
    let (first, last) = (crossings.first()?, crossings.last()?);
    (crossings.len() > 1).then(|| (crossings.len() - 1) as f64 / (last - first))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::written;
    use crate::particles::Oscillation;

    #[test]
    fn a_noisy_sine_has_its_frequency() {
        let signal = |t: f64| 0.3 + (2.0 * PI * 1.7 * t).sin() + 0.03 * (2.0 * PI * 61.0 * t).sin();
        let samples: Vec<_> = (0..5000).map(|k| k as f64 * 2e-3).map(|t| (t, signal(t))).collect();
        assert!((frequency(&samples, 0.3).unwrap() - 1.7).abs() < 0.01);
        assert_eq!(frequency(&samples[..100], 0.3), None);
    }

    fn disc() -> Body {
        let shape = std::sync::Arc::new(crate::geometry::Disc { radius: 0.1 });
        let mut body = Body::new(shape, 2.0, 0.1, Vector3::new(0.5, 8.0, 0.0));
        body.spin.z = 0.5;
        body
    }

    fn at<'a>(time: f64, exchange: &'a [Exchange], bodies: &'a [Body]) -> Sample<'a> {
        let touches = exchange.first().is_some_and(|e| e.contact != Vector3::zeros());
        let touched = if touches { &[true] } else { &[false] };
        Sample { time, exchange, bodies, max_speed: 0.0, deepest: 1e-3 * time, touched }
    }

    fn pushed(momentum: Vector3<f64>) -> Exchange {
        Exchange { momentum, ..Exchange::default() }
    }

    /// The measures of these kinds, from 1 s on, of a disc of 0.2 m in a fluid of 2 kg/m3.
    fn of_kinds(kinds: &[&str]) -> Vec<Series> {
        let measure = |kind: &&str| {
            format!("[[measure]]\nname = \"{kind}\"\nkind = \"{kind}\"\nfrom = 1.0\nspeed = 3.0\n")
        };
        let text = format!(
            "name = \"t\"\ntime.end = 9.0\ndomain = {{ size = [1.0, 9.0], cells = [8, 72] }}\n\
             fluid = {{ density = 2.0, viscosity = 0.1, gravity = [0.0, -9.81] }}\n\
             boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" \
                 }}\n\
             coupling.wall = \"mixing\"\n\
             particle = [{{ shape = {{ disc = {{ diameter = 0.2 }} }}, position = [0.5, 8.0], \
             motion = {{ prescribed = {{\
             oscillation = {{ amplitude = [0.1, 0.0], frequency = 0.5 }} }} }} }}]\n{}",
            kinds.iter().map(measure).collect::<String>()
        );
        series(&written(&text).unwrap())
    }

    #[test]
    fn the_force_on_a_swinging_disc_gives_back_the_coefficients_that_it_was_made_with() {
        let mut series = of_kinds(&["morison_drag", "morison_inertia"]);
        let (origin, drift, amplitude) =
            (Vector3::zeros(), Vector3::zeros(), Vector3::new(-0.3, 0.4, 0.0));
        let path = |time| Oscillation { origin, drift, amplitude, frequency: 0.5, time };
        let (along, mut time) = (amplitude.normalize(), 0.0);
        for k in 0..400 {
            let dt = 0.01 * (1.0 + 0.3 * f64::from(k).sin());
            time += dt;
            let middle = path(time - 0.5 * dt);
            let (u, a) = (middle.velocity().dot(&along), middle.acceleration().dot(&along));
            // Across the motion, and before the window, anything goes.
            let across = Vector3::new(0.8, 0.6, 0.0) * f64::from(k).cos();
            let force = -2.1 * 0.5 * 2.0 * 0.2 * u.abs() * u - 1.4 * 2.0 * 0.01 * PI * a;
            let momentum = if time < 1.0 { Vector3::repeat(9.0) } else { force * along + across };
            let mut body = disc();
            body.motion = Motion::Prescribed(Some(path(time)));
            let exchange = pushed(momentum);
            series
                .iter_mut()
                .for_each(|s| s.sample(&at(time, &[exchange], std::slice::from_ref(&body)), 0.0));
        }
        let values: Vec<f64> = series.iter().map(|s| s.value().unwrap()).collect();
        assert!((values[0] - 2.1).abs() < 1e-12 && (values[1] - 1.4).abs() < 1e-12, "{values:?}");
    }

    /// A force of 4 N over 0.9 to 1.2 s and of 1 N over the next 0.5 s, of which the first 0.1 s
    /// are before the window; a velocity by what it is at the ends.
    #[test]
    fn the_mean_of_a_force_is_what_it_gave_over_its_time() {
        let mut series = of_kinds(&["force", "velocity_x"]);
        let mut bodies = [disc()];
        for (time, force, speed) in [(0.9, 9.0, 7.0), (1.2, 4.0, 1.0), (1.7, 1.0, 3.0)] {
            bodies[0].velocity.x = speed;
            series.iter_mut().for_each(|s| {
                s.sample(&at(time, &[pushed(Vector3::new(force, 0.0, 0.0))], &bodies), 0.0)
            });
        }
        let [force, speed] = [0, 1].map(|n: usize| series[n].value().unwrap());
        assert!(
            (force - (4.0 * 0.2 + 0.5) / 0.7).abs() < 1e-14 && (speed - 2.0).abs() < 1e-14,
            "{force} {speed}"
        );
    }

    #[test]
    fn the_largest_coefficients_are_those_of_the_window() {
        let mut series =
            of_kinds(&["drag_coefficient_max", "lift_coefficient_max", "drag_coefficient"]);
        for (time, x, y) in [(0.5, 9.0, 9.0), (1.0, 1.8, -0.9), (2.0, 3.6, 0.18), (3.0, 1.8, -2.0)]
        {
            let exchange = pushed(Vector3::new(x, y, 0.0));
            series.iter_mut().for_each(|s| s.sample(&at(time, &[exchange], &[disc()]), 0.0));
        }
        // In units of 0.5 rho U^2 d = 1.8 N.
        let values: Vec<f64> = series.iter().map(|s| s.value().unwrap()).collect();
        assert!(
            values.iter().zip([2.0, 0.1, 1.5]).all(|(a, b)| (a - b).abs() < 1e-12),
            "{values:?}"
        );
        let kept: Vec<usize> = series.iter().map(|s| s.samples.len()).collect();
        assert_eq!(kept, [1, 1, 3], "a mean needs all samples, the largest itself");
    }

    #[test]
    fn a_place_can_be_asked_for_at_a_passing_and_at_the_first_contact() {
        let when = |series: &mut Series, when| series.measure.when = Some(when);
        let mut series = of_kinds(&["position_x", "velocity_x", "position_y"]);
        when(&mut series[0], When::Y(7.5));
        when(&mut series[1], When::Y(2.0));
        when(&mut series[2], When::Contact);
        let mut body = disc();
        for k in 0..9 {
            // A straight way down from (0, 8), which turns back at the fifth step.
            body.centre =
                Vector3::new(0.2 * f64::from(k), 8.0 - 0.4 * f64::from(k.min(8 - k)), 0.0);
            let mut exchange = Exchange::default();
            exchange.contact.y = if k == 5 { 1.0 } else { 0.0 };
            let time = 1.0 + f64::from(k);
            series
                .iter_mut()
                .for_each(|s| s.sample(&at(time, &[exchange], std::slice::from_ref(&body)), 0.0));
        }
        let values: Vec<_> = series.iter().map(Series::value).collect();
        assert!(
            (values[0].unwrap() - 0.25).abs() < 1e-12,
            "on the way down, between two steps: {values:?}"
        );
        assert_eq!(values[1], None, "never so low");
        assert!((values[2].unwrap() - 6.8).abs() < 1e-12, "{values:?}");
        assert!(series.iter().all(|s| s.samples.is_empty()), "a moment needs no history");
    }

    #[test]
    fn a_heap_is_told_by_the_heights_of_its_parts_its_fastest_and_its_deepest_overlap() {
        let mut series =
            of_kinds(&["mean_height", "height_rank", "fastest_particle", "largest_overlap"]);
        let up = Vector3::new(0.6, 0.8, 0.0);
        for s in &mut series {
            (s.up, s.measure.particles) = (up, vec![0, 2]);
        }
        // Heights 5, 1, 3 along `up`, whatever lies across.
        let body = |height: f64, across: f64, speed: f64| {
            let mut body = disc();
            body.centre = height * up + across * Vector3::new(-0.8, 0.6, 0.0);
            body.velocity = Vector3::new(0.0, speed, 0.0);
            body
        };
        let mut bodies = [body(5.0, 9.0, 0.1), body(1.0, -3.0, 7.0), body(3.0, 20.0, -0.2)];
        bodies.iter_mut().enumerate().for_each(|(id, body)| body.id = id);
        series.iter_mut().for_each(|s| s.sample(&at(2.0, &[], &bodies), 0.0));
        let values: Vec<f64> = series.iter().map(|s| s.value().unwrap()).collect();
        let expected = [3.0, 2.5, 0.2, 2e-3];
        assert!(values.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{values:?}");
    }

    #[test]
    fn a_falling_body_that_lands_gives_its_speed_place_spin_and_landing() {
        let mut series =
            of_kinds(&["largest_speed", "position_y", "velocity_y", "spin", "contact_start"]);
        assert!(series.iter().all(|s| s.value().is_none()));
        let mut body = disc();
        // Before the window, in it, at the bottom, and at rest without a force.
        for (time, speed, force) in
            [(0.5, -9.0, 9.0), (1.0, -2.0, 0.0), (2.0, -3.0, 0.0), (3.0, 0.0, 7.0), (4.0, 0.0, 0.0)]
        {
            body.velocity.y = speed;
            body.centre.y += speed / 10.0;
            let mut exchange = Exchange::default();
            exchange.contact.y = force;
            series
                .iter_mut()
                .for_each(|s| s.sample(&at(time, &[exchange], std::slice::from_ref(&body)), 0.0));
        }
        let values: Vec<f64> = series.iter().map(|s| s.value().unwrap()).collect();
        let expected = [3.0, 8.0 - 1.4, -(2.5 + 1.5) / 3.0, 0.5, 3.0];
        assert!(values.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{values:?}");
    }
}
