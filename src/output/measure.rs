//! Measures: numbers that a run reports, each from a series of samples in time.

use crate::case::{Case, ForceRule, Measure, MeasureKind};
use crate::coupling::Exchange;
use crate::solids::Body;
use std::f64::consts::PI;

/// A measure and its samples so far.
pub struct Series {
    measure: Measure,
    rule: ForceRule,
    /// Force (N) of a coefficient of 1.
    force_scale: f64,
    /// Reference speed over diameter (1/s).
    rate: f64,
    samples: Vec<(f64, f64)>,
}

/// One series for each measure of the case.
pub fn series(case: &Case) -> Vec<Series> {
    let of = |m: &Measure| {
        let speed = m.speed.or(case.reference_speed()).unwrap_or(1.0);
        let diameter = case.particle.get(m.particle).map_or(1.0, |p| p.shape.diameter());
        let area = if case.dimension() == 2 { diameter } else { 0.25 * PI * diameter * diameter };
        Series {
            rule: m.force.unwrap_or(case.coupling.force),
            force_scale: 0.5 * case.fluid.density * speed * speed * area,
            rate: speed / diameter,
            samples: Vec::new(),
            measure: m.clone(),
        }
    };
    case.measure.iter().map(of).collect()
}

impl Series {
    /// The measure's name.
    pub fn name(&self) -> &str {
        &self.measure.name
    }

    /// Takes the state after a step: the time (s), what each particle exchanged, the particles, the largest speed of the
    /// fluid (m/s).
    pub fn sample(&mut self, time: f64, exchange: &[Exchange], bodies: &[Body], max_speed: f64) {
        if time < self.measure.from {
            return;
        }
        let particle = self.measure.particle;
        let coefficient = |axis: usize| {
            let Some(e) = exchange.get(particle) else { return 0.0 };
            let force = if self.rule == ForceRule::Momentum { e.momentum } else { e.literal() };
            force[axis] / self.force_scale
        };
        let body = |of: &dyn Fn(&Body) -> f64| bodies.get(particle).map_or(0.0, of);
        let value = match self.measure.kind {
            MeasureKind::MaxSpeed => max_speed,
            MeasureKind::DragCoefficient => coefficient(0),
            MeasureKind::LiftCoefficient
            | MeasureKind::LiftRms
            | MeasureKind::LiftAmplitude
            | MeasureKind::Strouhal => coefficient(1),
            MeasureKind::TerminalVelocity => body(&|b| b.velocity.norm()),
            MeasureKind::PositionX => body(&|b| b.centre.x),
            MeasureKind::PositionY => body(&|b| b.centre.y),
            MeasureKind::PositionZ => body(&|b| b.centre.z),
            MeasureKind::VelocityX => body(&|b| b.velocity.x),
            MeasureKind::VelocityY => body(&|b| b.velocity.y),
            MeasureKind::VelocityZ => body(&|b| b.velocity.z),
            MeasureKind::Spin => body(&|b| b.spin.z),
            MeasureKind::ContactStart => exchange.get(particle).map_or(0.0, |e| e.contact.norm()),
        };
        self.samples.push((time, value));
    }

    /// The measure's value; `None` where the samples do not give one (no steps in its window, no oscillation, no
    /// contact).
    pub fn value(&self) -> Option<f64> {
        let values = || self.samples.iter().map(|s| s.1);
        let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let mean = mean(&self.samples)?;
        match self.measure.kind {
            MeasureKind::DragCoefficient
            | MeasureKind::LiftCoefficient
            | MeasureKind::VelocityX
            | MeasureKind::VelocityY
            | MeasureKind::VelocityZ
            | MeasureKind::Spin => Some(mean),
            MeasureKind::MaxSpeed | MeasureKind::TerminalVelocity => Some(high),
            MeasureKind::PositionX | MeasureKind::PositionY | MeasureKind::PositionZ => {
                self.samples.last().map(|s| s.1)
            }
            MeasureKind::ContactStart => self.samples.iter().find(|s| s.1 > 0.0).map(|s| s.0),
            MeasureKind::LiftAmplitude => Some(0.5 * (high - low)),
            MeasureKind::LiftRms => {
                let squares: Vec<_> = self.samples.iter().map(|&(t, v)| (t, (v - mean) * (v - mean))).collect();
                self::mean(&squares).map(f64::sqrt)
            }
            // A lift coefficient that moves by less is a steady wake, whatever its last digits do.
            MeasureKind::Strouhal if high - low < 2e-3 => None,
            MeasureKind::Strouhal => frequency(&self.samples, mean).map(|f| f / self.rate),
        }
    }
}

/// Mean over time by trapezia.
fn mean(samples: &[(f64, f64)]) -> Option<f64> {
    let (first, last) = (samples.first()?, samples.last()?);
    if samples.len() == 1 {
        return Some(first.1);
    }
    let area: f64 = samples.windows(2).map(|w| 0.5 * (w[0].1 + w[1].1) * (w[1].0 - w[0].0)).sum();
    Some(area / (last.0 - first.0))
}

/// Oscillations per unit time from the first to the last upward crossing of `level`. A crossing counts after the signal
/// has been below the level by a tenth of its depth, so that noise makes none.
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
    use nalgebra::Vector3;

    #[test]
    fn a_noisy_sine_has_its_frequency() {
        let signal = |t: f64| 0.3 + (2.0 * PI * 1.7 * t).sin() + 0.03 * (2.0 * PI * 61.0 * t).sin();
        let samples: Vec<_> = (0..5000).map(|k| k as f64 * 2e-3).map(|t| (t, signal(t))).collect();
        assert!((frequency(&samples, 0.3).unwrap() - 1.7).abs() < 0.01);
        assert_eq!(frequency(&samples[..100], 0.3), None);
    }

    #[test]
    fn a_falling_body_that_lands_gives_its_speed_place_spin_and_landing() {
        let kinds = ["terminal_velocity", "position_y", "velocity_y", "spin", "contact_start"];
        let measure = |kind: &&str| format!("[[measure]]\nname = \"{kind}\"\nkind = \"{kind}\"\nfrom = 1.0\n");
        let text = format!(
            "name = \"fall\"\ntime.end = 9.0\ndomain = {{ size = [1.0, 9.0], cells = [8, 72] }}\n\
             fluid = {{ density = 1.0, viscosity = 0.1 }}\n\
             boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" }}\n\
             particle = [{{ shape = {{ disc = {{ diameter = 0.2 }} }}, position = [0.5, 8.0] }}]\n{}",
            kinds.iter().map(measure).collect::<String>()
        );
        let mut series = series(&toml::from_str(&text).unwrap());
        assert!(series.iter().all(|s| s.value().is_none()));
        let mut body = Body {
            shape: crate::solids::Shape::Disc,
            radius: 0.1,
            density: 2.0,
            viscosity: 0.1,
            centre: Vector3::new(0.5, 8.0, 0.0),
            velocity: Vector3::zeros(),
            angle: 0.0,
            orientation: nalgebra::UnitQuaternion::identity(),
            spin: Vector3::new(0.0, 0.0, 0.5),
            motion: crate::solids::Motion::Fixed,
        };
        // Before the window, in it, at the bottom, and at rest without a force.
        for (time, speed, force) in
            [(0.5, -9.0, 9.0), (1.0, -2.0, 0.0), (2.0, -3.0, 0.0), (3.0, 0.0, 7.0), (4.0, 0.0, 0.0)]
        {
            body.velocity.y = speed;
            body.centre.y += speed / 10.0;
            let mut exchange = Exchange::default();
            exchange.contact.y = force;
            series.iter_mut().for_each(|s| s.sample(time, &[exchange], std::slice::from_ref(&body), 0.0));
        }
        let values: Vec<f64> = series.iter().map(|s| s.value().unwrap()).collect();
        let expected = [3.0, 8.0 - 1.4, -(2.5 + 1.5) / 3.0, 0.5, 3.0];
        assert!(values.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{values:?}");
    }
}
