//! Measures: numbers that a run reports, each from a series of samples in time.

use crate::case::{Case, ForceRule, Measure, MeasureKind};
use crate::coupling::Exchange;
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

    /// Takes the state after a step: the time (s), what each particle exchanged, the largest speed (m/s).
    pub fn sample(&mut self, time: f64, exchange: &[Exchange], max_speed: f64) {
        if time < self.measure.from {
            return;
        }
        let coefficient = |axis: usize| {
            let Some(e) = exchange.get(self.measure.particle) else { return 0.0 };
            let force = if self.rule == ForceRule::Momentum { e.momentum } else { e.literal() };
            force[axis] / self.force_scale
        };
        let value = match self.measure.kind {
            MeasureKind::MaxSpeed => max_speed,
            MeasureKind::DragCoefficient => coefficient(0),
            _ => coefficient(1),
        };
        self.samples.push((time, value));
    }

    /// The measure's value; `None` where the samples do not give one (no steps in its window, no oscillation).
    pub fn value(&self) -> Option<f64> {
        let values = || self.samples.iter().map(|s| s.1);
        let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let mean = mean(&self.samples)?;
        match self.measure.kind {
            MeasureKind::DragCoefficient | MeasureKind::LiftCoefficient => Some(mean),
            MeasureKind::MaxSpeed => Some(high),
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

    #[test]
    fn a_noisy_sine_has_its_frequency() {
        let signal = |t: f64| 0.3 + (2.0 * PI * 1.7 * t).sin() + 0.03 * (2.0 * PI * 61.0 * t).sin();
        let samples: Vec<_> = (0..5000).map(|k| k as f64 * 2e-3).map(|t| (t, signal(t))).collect();
        assert!((frequency(&samples, 0.3).unwrap() - 1.7).abs() < 0.01);
        assert_eq!(frequency(&samples[..100], 0.3), None);
    }
}
