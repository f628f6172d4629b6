//! A measure that a case asks for: samples in time, of which one number becomes.

use super::kinds::{Becomes, View, frequency, kind, period, place};
use super::{Remark, Sample};
use crate::Result;
use crate::archive::{Archive, Checkpointed};
use crate::config::{self, Case, MeasureKind, When};
use crate::contact::Contacts;
use crate::output::fit::{self, Morison};
use crate::output::midline;
use crate::output::survey::survey;
use crate::particles::{Motion, by_number};
use crate::scene::Scene;
use mics_run::compare::{Comparison, measured, percent, significant};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// A measure and its samples so far.
pub struct Series {
    pub(super) measure: config::Measure,
    /// Force (N) of a coefficient of 1.
    force_scale: f64,
    /// Reference speed over length (1/s).
    rate: f64,
    /// Against gravity, of length 1; zero without gravity.
    pub(super) up: Vector3<f64>,
    /// Edges of the box (m).
    size: [f64; 3],
    pub(super) samples: Vec<(f64, f64)>,
    morison: Morison,
    /// Value that the newest snapshot gave, or the moment that was waited for.
    found: Option<f64>,
    /// Coordinate (m) and value at the step before, of a measure that waits for a moment.
    passing: Option<(f64, f64)>,
    /// Scratch of measures that count by layers of cells.
    layers: Vec<f64>,
    /// Time of the step before (s), and that at which the first sample began.
    before: f64,
    began: f64,
}

/// The part by which a speed or a mean may change and still be called steady: as well as the best
/// values of this program are known.
const STEADY: f64 = 1e-2;

/// One series for each measure of the case.
pub fn series(case: &Case) -> Vec<Series> {
    let axis = |a: usize| case.fluid.gravity.get(a).copied().unwrap_or(0.0);
    let up = -Vector3::from_fn(|a, _| axis(a)).try_normalize(0.0).unwrap_or_default();
    let of = |m: &config::Measure| {
        // Measures without a reference speed have no use for it.
        let speed = m.speed.unwrap_or(f64::NAN);
        let diameter = case.particle.get(m.particle.id()).map_or(1.0, |p| p.shape.diameter());
        let flat = case.dimension() == 2;
        let circle = 0.25 * PI * diameter * diameter;
        let volume = if flat { circle } else { 2.0 / 3.0 * diameter * circle };
        let frontal = |length: f64| if flat { length } else { 0.25 * PI * length * length };
        let length = m.length.unwrap_or(diameter);
        let density = case.fluid.density;
        Series {
            morison: Morison::new(density, frontal(diameter), volume),
            before: 0.0,
            began: 0.0,
            found: None,
            passing: None,
            layers: Vec::new(),
            force_scale: 0.5 * density * speed * speed * frontal(length),
            rate: speed / length,
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
    /// The measure as the case has it.
    pub fn measure(&self) -> &config::Measure {
        &self.measure
    }

    /// Goes on with what the same measure has found.
    pub fn take_over(&mut self, old: Series) {
        let measure = self.measure.clone();
        let force_scale = self.force_scale;
        let rate = self.rate;
        *self = Series { measure, force_scale, rate, ..old };
    }

    /// Begins at a time (s) of a run that goes on.
    pub fn begin_at(&mut self, time: f64) {
        self.before = time;
        self.began = time;
    }

    /// Takes what the fields give of a kind that is of them. Collective.
    ///
    /// # Errors
    /// When ranks cannot add up what they have.
    pub fn take_fields<const D: usize>(&mut self, scene: &Scene<D>) -> Result<()> {
        if self.measure.kind.is_of_line() {
            self.found = midline::value(self.measure.kind, scene)?;
        }
        Ok(())
    }

    /// Takes the state after a step, and what [`survey`] gives of it, of a kind that is of the
    /// whole box.
    pub fn sample(&mut self, step: &Sample, of_box: f64) {
        let &Sample { time, bodies, .. } = step;
        let before = std::mem::replace(&mut self.before, time);
        let dt = time - before;
        if time < self.measure.from {
            return;
        }
        let measure = &self.measure;
        let places = by_number(bodies);
        let view = View {
            measure,
            step,
            particle: place(&places, bodies, measure.particle.id()).unwrap_or(usize::MAX),
            places,
            force_scale: self.force_scale,
            up: self.up,
            of_box,
        };
        let asked = measure.kind;
        // Bodies that have left give no more samples.
        if (asked.needs_particle() && view.particle == usize::MAX)
            || (asked.is_of_group() && view.group().next().is_none())
        {
            return;
        }
        if let (true, Some(Motion::Prescribed(Some(path)))) =
            (asked.fits_morison(), bodies.get(view.particle).map(|b| b.motion))
        {
            self.morison.add(&path, &view.force(view.particle), dt);
        }
        let (of, becomes) = kind(asked);
        let value = of(&view);
        let at = [0, 1, 2].map(|a| view.body(|b| b.centre[a]));
        let touches = view.touches();
        match becomes {
            Becomes::Snapshot => return,
            Becomes::LargestFall | Becomes::TimeOfLargestFall => {
                let Some((was, _)) = self.passing.replace((value, 0.0)) else { return };
                return self.keep(before, (time - 0.5 * dt, (was - value) / dt));
            }
            _ => {}
        }
        match self.measure.when {
            None => self.keep(before, (time, value)),
            Some(When::Contact) => self.found = self.found.or(touches.then_some(value)),
            Some(When::X(place)) => self.wait(place, at[0], value, self.size[0]),
            Some(When::Y(place)) => self.wait(place, at[1], value, self.size[1]),
            Some(When::Z(place)) => self.wait(place, at[2], value, self.size[2]),
            Some(When::Time(moment)) => self.wait(moment, time, value, f64::INFINITY),
        }
    }

    /// Takes the value at the moment at which `now`, a coordinate or the time, passes `at`, on the
    /// straight line between two steps; a change of more than half of the `length` is a jump across
    /// a period or back to an entrance, and does not count.
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
        let becomes = kind(self.measure.kind).1;
        match self.samples.last_mut().map(|kept| (becomes.replaces(kept.1, new.1), kept)) {
            None | Some((None, _)) => self.samples.push(new),
            Some((Some(better), kept)) if better => *kept = new,
            Some(_) => {}
        }
    }

    /// Mean over time of samples, of which the first began at `began` (s): of forces, which are
    /// means over their steps, from the start of the first one on; of what is known at the ends of
    /// steps, by trapezia between them.
    fn mean(&self, samples: &[(f64, f64)], began: f64) -> Option<f64> {
        let first = samples.first()?;
        let last = samples.last()?;
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
        match kind(self.measure.kind).1 {
            Becomes::Mean => Some(mean),
            Becomes::Largest | Becomes::LargestFall => Some(high),
            Becomes::Least => Some(low),
            Becomes::Last => samples.last().map(|s| s.1),
            Becomes::FirstTime => samples.iter().find(|s| s.1 > 0.0).map(|s| s.0),
            Becomes::TimeOfLargestFall => samples.last().map(|s| s.0),
            Becomes::HalfRange => Some(0.5 * (high - low)),
            Becomes::Rms => {
                let squares: Vec<_> =
                    samples.iter().map(|&(t, v)| (t, (v - mean) * (v - mean))).collect();
                self.mean(&squares, began).map(f64::sqrt)
            }
            // A lift coefficient that moves by less is a steady wake, whatever its last digits do.
            Becomes::Frequency if high - low < 2e-3 => None,
            Becomes::Frequency => frequency(samples, mean).map(|f| f / self.rate),
            Becomes::HalfTurn => period(samples),
            Becomes::Steadiest => fit::steadiest_quarter(samples).map(|part| part.speed),
            Becomes::Noise => fit::noise(samples),
            Becomes::Fitted(number) => number(&self.morison),
            Becomes::Snapshot => None,
        }
    }
}

impl Series {
    /// Its name in `summary.json`.
    pub fn name(&self) -> &str {
        &self.measure.name
    }

    /// Its unit; empty where it has none.
    pub fn unit(&self, dimension: usize) -> &'static str {
        self.measure.kind.unit(dimension)
    }

    /// Takes the state after a step, in which the fluid's largest speed was this (m/s). Collective.
    ///
    /// # Errors
    /// When ranks cannot sum.
    pub fn take<const D: usize>(&mut self, scene: &Scene<D>, largest_speed: f64) -> Result<()> {
        let state = &scene.state;
        let outcome = scene.method.contacts().map(Contacts::outcome);
        let step = Sample {
            time: state.time,
            exchange: &state.exchange,
            bodies: &state.bodies,
            max_speed: largest_speed,
            deepest: outcome.map_or(0.0, |outcome| outcome.deepest),
            contacts: outcome.map_or(&[], |outcome| &outcome.bodies),
        };
        let measure = &self.measure;
        let of_box = if measure.kind.is_of_box() && step.time >= measure.from {
            survey(scene, measure, &mut self.layers)?
        } else {
            0.0
        };
        self.sample(&step, of_box);
        Ok(())
    }

    /// The value beside a reference, where there is one.
    pub fn comparison(&self) -> Option<Comparison> {
        Comparison::of(&self.measure, self.value())
    }

    /// Remark on how far the value is to be trusted, or on its time; `None` without one.
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
        // A bed goes on settling long after its start.
        let kind = self.measure.kind;
        let begins_late = self.measure.from > 0.0 || self.began > 0.0;
        if !(kind.is_of_bed() || kind.counts_the_start() && !begins_late) {
            return None;
        }
        let first = self.samples.first()?;
        let last = self.samples.last()?;
        let middle = 0.5 * (first.0 + last.0);
        let at = self.samples.partition_point(|sample| sample.0 <= middle);
        let value = self.value()?;
        let began = self.samples.get(at.checked_sub(1)?)?.0;
        let later = self.value_of(&self.samples[at..], began)?;
        let differs = (value - later).abs() > STEADY * value.abs().max(later.abs());
        // A lift is small beside the drag that scales it. Coefficients have no unit in 3D either.
        let small = (value - later).abs() <= STEADY && self.measure.kind.unit(2).is_empty();
        (differs && !small).then(|| Remark {
            doubt: true,
            words: format!(
                "not steady: from t = {} s on it is {}; `from` leaves out a start",
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
            layers: _,
            force_scale: _,
            rate: _,
            up: _,
            size: _,
        } = self;
        archive.serialize([samples, before, began, found, passing, morison])
    }
}
