//! Measures beside their references: what `summary.json`, `mics report` and `mics validate` say of
//! them.

use crate::config::{Measure, Reference};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A measured value beside its reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Measured value; none where the run gave no value.
    pub value: Option<f64>,
    /// Expected value or band.
    pub reference: Reference,
    /// Largest difference that passes, as a part of the reference (of a band: beyond its ends, as a
    /// part of its middle).
    pub tolerance: f64,
    /// The error, as a part of the reference (of a band: against its middle).
    pub error: Option<f64>,
    /// Whether the value is within the tolerance.
    pub pass: bool,
    /// Where the reference is from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
}

/// A number with five digits.
pub fn significant(value: f64) -> String {
    let size = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    match size {
        -4..5 => format!("{value:.*}", usize::try_from(4 - size).unwrap_or(0)),
        _ => format!("{value:.4e}"),
    }
}

/// A measured value with five decimals, or where these would show less with five digits.
pub fn measured(value: f64) -> String {
    if value == 0.0 || (0.1..1e5).contains(&value.abs()) {
        format!("{value:.5}")
    } else {
        significant(value)
    }
}

impl Comparison {
    /// Compares a value with the reference of its measure; `None` where it has none.
    pub fn of(measure: &Measure, value: Option<f64>) -> Option<Comparison> {
        let reference = measure.reference?;
        let tolerance = measure.tolerance.unwrap_or(0.0);
        let middle = reference.middle();
        Some(Comparison {
            value,
            reference,
            tolerance,
            error: value.map(|v| (v - middle) / middle.abs()).filter(|error| error.is_finite()),
            pass: value.is_some_and(|v| reference.holds(v, tolerance)),
            source: measure.source.clone(),
        })
    }

    /// Difference of the value from the reference in words: a part of the reference, or the place
    /// in a band, from 0 at its lower to 100 % at its upper end; nothing where there is no value.
    pub fn difference(&self) -> Option<String> {
        match self.reference {
            Reference::Value(_) => self.error.map(signed_percent),
            Reference::Band([low, high]) => self.value.map(|value| {
                format!("at {:.0} % of the band", 100.0 * (value - low) / (high - low))
            }),
        }
    }

    /// `pass` or `falls short`.
    pub fn verdict(&self) -> &'static str {
        if self.pass { "pass" } else { "falls short" }
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "reference {}", self.reference)?;
        if self.tolerance > 0.0 {
            write!(f, " within {}", percent(self.tolerance))?;
        }
        match (self.difference(), self.reference) {
            (Some(difference), Reference::Value(_)) => write!(f, ", error {difference}")?,
            (Some(difference), Reference::Band(_)) => write!(f, ", {difference}")?,
            (None, _) => {}
        }
        write!(f, ": {}", self.verdict())
    }
}

/// A part in percent, with the digits that it needs: `2 %`, `0.5 %`.
pub fn percent(part: f64) -> String {
    let text = format!("{:.2}", 100.0 * part);
    format!("{} %", text.trim_end_matches('0').trim_end_matches('.'))
}

/// A signed part in percent: `+1.74 %`.
pub fn signed_percent(part: f64) -> String {
    format!("{:+.2} %", 100.0 * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measure(target: Option<(Reference, f64)>) -> Measure {
        let text = "name = \"m\"\nkind = \"max_speed\"";
        let mut measure: Measure = toml::from_str(text).unwrap();
        measure.reference = target.map(|(reference, _)| reference);
        measure.tolerance = target.map(|(_, tolerance)| tolerance);
        measure
    }

    #[test]
    fn reference_tolerance_pass_and_fail() {
        let number = measure(Some((Reference::Value(-2.0), 0.05)));
        let of = |value| Comparison::of(&number, Some(value)).unwrap();
        assert!(
            of(-1.91).pass
                && of(-2.09).pass
                && !of(-1.89).pass
                && !of(2.0).pass
                && !of(f64::NAN).pass
        );
        assert!((of(-2.1).error.unwrap() + 0.05).abs() < 1e-12, "below is negative");
        assert_eq!(of(-2.1).to_string(), "reference -2 within 5 %, error -5.00 %: pass");
        let band = measure(Some((Reference::Band([1.0, 3.0]), 0.1)));
        let of = |value| Comparison::of(&band, value).unwrap();
        assert!(of(Some(0.85)).pass && of(Some(3.15)).pass && !of(Some(3.25)).pass);
        assert_eq!(
            of(Some(1.5)).to_string(),
            "reference 1 to 3 within 10 %, at 25 % of the band: pass"
        );
        let none = of(None);
        assert!(!none.pass && none.error.is_none());
        assert_eq!(none.to_string(), "reference 1 to 3 within 10 %: falls short");
        assert_eq!(Comparison::of(&measure(None), Some(1.0)), None);
    }
}
