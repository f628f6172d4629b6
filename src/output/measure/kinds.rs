//! Kinds of measures, a line each: the number that one takes of a step, and what samples become.

use super::Sample;
use crate::config::{self, ForceRule, MeasureKind};
use crate::output::fit::Morison;
use crate::particles::Body;
use crate::state::Exchange;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Value that samples become.
#[derive(Clone, Copy)]
pub(super) enum Becomes {
    /// Their mean over time.
    Mean,
    /// The largest.
    Largest,
    /// The least.
    Least,
    /// The last.
    Last,
    /// The time (s) of the first that is not zero.
    FirstTime,
    /// The largest rate at which they fall, or the time (s) of it.
    LargestFall,
    TimeOfLargestFall,
    /// Half of their range.
    HalfRange,
    /// The root mean square of the fluctuation about the mean.
    Rms,
    /// Oscillations over the reference speed and length.
    Frequency,
    /// Twice the time (s) in which they last changed by half a turn.
    HalfTurn,
    /// The speed over the steadiest quarter of the way.
    Steadiest,
    /// The noise from step to step, over the mean.
    Noise,
    /// A number of a fit to the force on a particle that swings.
    Fitted(fn(&Morison) -> Option<f64>),
    /// The value that the newest snapshot gives.
    Snapshot,
}

/// The number that a kind takes of a step, and the value that its samples become.
pub(super) fn kind(kind: MeasureKind) -> (fn(&View) -> f64, Becomes) {
    use Becomes::*;
    use MeasureKind::*;
    match kind {
        Angle => (|v| v.body(|b| b.angle), Last),
        BedHeight | BedShearStress | BedloadRate | Einstein | Shields => (|v| v.of_box, Mean),
        BodyEnergy => (|v| v.of_box, Mean),
        ContactStart => (|v| f64::from(v.touches()), FirstTime),
        Dissipation => (|v| v.of_box, LargestFall),
        DissipationTime => (|v| v.of_box, TimeOfLargestFall),
        DragCoefficient => (|v| v.coefficient(), Mean),
        DragCoefficientMax => (|v| v.coefficient(), Largest),
        DriveForce => (|v| v.of_box, Mean),
        FastestParticle => (|v| v.largest_of(|b| b.velocity.norm()), Last),
        FlowRate => (|v| v.of_box, Mean),
        FluidEnergy => (|v| v.of_box, Mean),
        Force => (|v| v.force_on_group(), Mean),
        ForceNoise => (|v| v.force(v.particle).dot(&v.direction()), Noise),
        HeightRank => (|v| v.height_rank(), Last),
        LargestOverlap => (|v| v.step.deepest, Largest),
        LargestSpin => (|v| v.body(|b| b.spin.z.abs()), Largest),
        LeastSpin => (|v| v.body(|b| b.spin.z.abs()), Least),
        LargestSpeed => (|v| v.body(|b| b.velocity.norm()), Largest),
        LiftAmplitude => (|v| v.coefficient(), HalfRange),
        LiftCoefficient => (|v| v.coefficient(), Mean),
        LiftCoefficientMax => (|v| v.coefficient(), Largest),
        LiftMagnitude => (|v| v.across(), Mean),
        LiftRms => (|v| v.coefficient(), Rms),
        MaxSpeed => (|v| v.step.max_speed, Largest),
        MeanHeight => (|v| v.mean_height(), Last),
        MeanSpeed => (|v| v.mean_of(|b| b.velocity.norm()), Mean),
        MidlineULeast | MidlineVLeast | MidlineVLargest | Reattachment => (|_| 0.0, Snapshot),
        MorisonDrag => (|_| 0.0, Fitted(|fit| fit.coefficients().map(|c| c.x))),
        MorisonInertia => (|_| 0.0, Fitted(|fit| fit.coefficients().map(|c| c.y))),
        MorisonResidual => (|_| 0.0, Fitted(Morison::residual)),
        PositionX => (|v| v.body(|b| b.centre.x), Last),
        PositionY => (|v| v.body(|b| b.centre.y), Last),
        PositionZ => (|v| v.body(|b| b.centre.z), Last),
        PressureDrop => (|v| v.of_box, Mean),
        RmsSpeed => (|v| v.mean_of(|b| b.velocity.norm_squared()).sqrt(), Mean),
        SolidFraction => (|v| v.of_box, Mean),
        Spin => (|v| v.body(|b| b.spin.z), Mean),
        Strouhal => (|v| v.coefficient(), Frequency),
        SuperficialVelocity => (|v| v.of_box, Mean),
        Torque => (|v| v.torque().dot(&v.direction()), Mean),
        TerminalSpeed => (|v| v.body(|b| b.velocity.norm()), Steadiest),
        TransportRate => (|v| v.of_box, Mean),
        TurnPeriod => (|v| v.body(|b| b.angle), HalfTurn),
        VelocityX => (|v| v.body(|b| b.velocity.x), Mean),
        VelocityY => (|v| v.body(|b| b.velocity.y), Mean),
        VelocityZ => (|v| v.body(|b| b.velocity.z), Mean),
    }
}

impl Becomes {
    /// Whether a new sample takes the place of the one that is kept; `None` where all are kept.
    pub fn replaces(self, kept: f64, new: f64) -> Option<bool> {
        match self {
            Becomes::Largest | Becomes::LargestFall | Becomes::TimeOfLargestFall => {
                Some(new > kept)
            }
            Becomes::Least => Some(new < kept),
            Becomes::Last => Some(true),
            Becomes::FirstTime => Some(kept <= 0.0),
            _ => None,
        }
    }
}

/// A step as a measure sees it.
pub(super) struct View<'a> {
    pub measure: &'a config::Measure,
    pub step: &'a Sample<'a>,
    /// Places of the bodies in the list, by their numbers.
    pub places: Vec<usize>,
    /// Where the measure's particle is in the list; beyond it where there is none.
    pub particle: usize,
    /// Force (N) of a coefficient of 1.
    pub force_scale: f64,
    /// Against gravity, of length 1; zero without gravity.
    pub up: Vector3<f64>,
    /// Value by [`survey`](crate::output::survey::survey), of a kind that is of the whole box.
    pub of_box: f64,
}

impl View<'_> {
    fn direction(&self) -> Vector3<f64> {
        self.measure.direction().unwrap_or_default()
    }

    /// The force on a particle (N), by the measure's rule.
    pub fn force(&self, particle: usize) -> Vector3<f64> {
        self.step.exchange.get(particle).map_or_else(Vector3::zeros, |e| {
            match self.measure.force() {
                ForceRule::Momentum => e.momentum,
                ForceRule::Literal => e.literal(),
            }
        })
    }

    /// The torque on its particle about the measure's point, or else the centre (N m), by the
    /// measure's rule.
    fn torque(&self) -> Vector3<f64> {
        let at_centre = |e: &Exchange| match self.measure.force() {
            ForceRule::Momentum => e.momentum_torque,
            ForceRule::Literal => e.literal_torque,
        };
        let torque = self.step.exchange.get(self.particle).map_or_else(Vector3::zeros, at_centre);
        let body = self.step.bodies.get(self.particle);
        let moved = self
            .measure
            .about()
            .zip(body)
            .map(|(about, body)| (body.centre - about).cross(&self.force(self.particle)));
        torque + moved.unwrap_or_default()
    }

    fn coefficient(&self) -> f64 {
        self.force(self.particle).dot(&self.direction()) / self.force_scale
    }

    fn across(&self) -> f64 {
        let force = self.force(self.particle);
        let direction = self.direction();
        (force - force.dot(&direction) * direction).norm() / self.force_scale
    }

    /// A number of the measure's particle.
    pub fn body(&self, of: impl Fn(&Body) -> f64) -> f64 {
        self.step.bodies.get(self.particle).map_or(0.0, of)
    }

    /// Whether it touches something.
    pub fn touches(&self) -> bool {
        self.step.contacts.get(self.particle).is_some_and(|contacts| contacts.touched)
    }

    /// The particles that the measure is of.
    pub fn group(&self) -> impl Iterator<Item = usize> + '_ {
        self.measure.group().filter_map(|id| place(&self.places, self.step.bodies, id))
    }

    fn force_on_group(&self) -> f64 {
        self.group().map(|k| self.force(k).dot(&self.direction())).sum()
    }

    fn largest_of(&self, value: impl Fn(&Body) -> f64) -> f64 {
        self.group().map(|k| value(&self.step.bodies[k])).fold(0.0, f64::max)
    }

    fn mean_of(&self, value: impl Fn(&Body) -> f64) -> f64 {
        self.group().map(|k| value(&self.step.bodies[k])).sum::<f64>() / self.group().count() as f64
    }

    fn height(&self, k: usize) -> f64 {
        self.step.bodies[k].centre.dot(&self.up)
    }

    fn mean_height(&self) -> f64 {
        let all = 0..self.step.bodies.len();
        let lowest = all.map(|k| self.height(k)).fold(f64::INFINITY, f64::min);
        self.group().map(|k| self.height(k) - lowest).sum::<f64>() / self.group().count() as f64
    }

    fn height_rank(&self) -> f64 {
        let lower = |than: f64| {
            (0..self.step.bodies.len()).filter(|other| self.height(*other) < than).count()
        };
        let ranks: usize = self.group().map(|k| 1 + lower(self.height(k))).sum();
        ranks as f64 / self.group().count() as f64
    }
}

/// Oscillations per unit time from the first to the last upward crossing of `level`. A crossing
/// counts after the signal has been below the level by a tenth of its depth, so that noise makes
/// none.
pub(super) fn frequency(samples: &[(f64, f64)], level: f64) -> Option<f64> {
    let depth = samples.iter().map(|s| level - s.1).fold(0.0, f64::max);
    let mut armed = false;
    let mut crossings = Vec::new();
    for w in samples.windows(2) {
        armed |= level - w[0].1 > 0.1 * depth;
        if armed && w[0].1 < level && w[1].1 >= level {
            crossings.push(w[0].0 + (level - w[0].1) / (w[1].1 - w[0].1) * (w[1].0 - w[0].0));
            armed = false;
        }
    }
    let first = crossings.first()?;
    let last = crossings.last()?;
    (crossings.len() > 1).then(|| (crossings.len() - 1) as f64 / (last - first))
}

/// Twice the time (s) that the last half turn took, of samples of an angle (rad).
pub(super) fn period(samples: &[(f64, f64)]) -> Option<f64> {
    let &(end, angle) = samples.last()?;
    let left = |sample: &(f64, f64)| PI - (angle - sample.1).abs();
    let before = samples.iter().rposition(|sample| left(sample) <= 0.0)?;
    let a = &samples[before];
    let b = &samples[before + 1];
    let began = a.0 + left(a) / (left(a) - left(b)) * (b.0 - a.0);
    Some(2.0 * (end - began))
}

/// Place of the body of a number in a list of bodies, whose `places` by number are these; `None`
/// once it has left.
pub(super) fn place(places: &[usize], bodies: &[Body], id: usize) -> Option<usize> {
    places.binary_search_by_key(&id, |k| bodies[*k].id).ok().map(|at| places[at])
}
