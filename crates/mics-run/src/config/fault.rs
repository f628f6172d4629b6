//! Refusals, and the checks of numbers that all rules share.

use std::fmt::Display;

/// A refusal: the dotted path of the key, and what would be right.
#[derive(Debug)]
pub struct Fault {
    /// Its dotted path.
    pub key: String,
    /// The fault, and what would be right.
    pub message: String,
}

/// The outcome of a check.
pub type Check = Result<(), Fault>;

/// Refusals whose keys are of one table, and get the path of that table ahead; the key "" is the
/// table itself.
pub(super) trait Within {
    /// The refusal, its key within this table.
    fn within(self, table: impl Display) -> Self;
}

impl<T> Within for Result<T, Fault> {
    fn within(self, table: impl Display) -> Self {
        self.map_err(|Fault { key, message }| {
            let key = if key.is_empty() { table.to_string() } else { format!("{table}.{key}") };
            Fault { key, message }
        })
    }
}

/// The names of the axes.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// Returns the refusal of a key with a formatted message unless the condition holds.
macro_rules! ensure {
    ($holds:expr, $key:expr, $($message:tt)+) => {
        let holds: bool = $holds;
        if !holds {
            let key = $key.into();
            let message = format!($($message)+);
            return Err($crate::config::fault::Fault { key, message });
        }
    };
}

/// Largest quantity of a case, in any consistent units: its square and cube are far from the
/// largest double.
const LARGEST: f64 = 1e30;

/// Checks that a quantity is at most [`LARGEST`]: more is a slip of the exponent.
fn sensible(key: &str, value: f64, unit: &str) -> Check {
    ensure!(
        value.abs() <= LARGEST,
        key,
        "{value:e} ({unit}) is beyond {LARGEST:e}, the largest that is computed with: look at its \
        exponent"
    );
    Ok(())
}

/// A positive number, if it is given.
pub(super) fn positive(key: &str, value: impl Into<Option<f64>>, unit: &str) -> Check {
    let Some(value) = value.into() else { return Ok(()) };
    ensure!(
        value > 0.0 && value.is_finite(),
        key,
        "must be positive and finite ({unit}), not {value:?}"
    );
    sensible(key, value, unit)
}

/// Zero or a positive number, if it is given.
pub(super) fn not_negative(key: &str, value: impl Into<Option<f64>>, unit: &str) -> Check {
    let Some(value) = value.into() else { return Ok(()) };
    let holds = value >= 0.0 && value.is_finite();
    ensure!(holds, key, "must be zero or positive, and finite ({unit}), not {value:?}");
    sensible(key, value, unit)
}

/// Finite numbers.
pub(super) fn finite(key: &str, values: &[f64], unit: &str) -> Check {
    for (i, value) in values.iter().enumerate() {
        let key = format!("{key}.{i}");
        ensure!(value.is_finite(), key, "must be a finite number ({unit}), not {value:?}");
        sensible(&key, *value, unit)?;
    }
    Ok(())
}

/// Two finite numbers or more, which increase; `what` names them.
pub(super) fn increasing(key: &str, values: &[f64], what: &str, unit: &str) -> Check {
    finite(key, values, unit)?;
    let count = values.len();
    ensure!(count >= 2, key, "needs at least 2 {what} ({unit}), not {count}");
    let holds = values.is_sorted_by(|a, b| a < b);
    ensure!(holds, key, "the {what} ({unit}) must increase from each to the next");
    Ok(())
}

/// One finite number for each axis.
pub(super) fn vector(key: &str, value: &[f64], dimension: usize, unit: &str) -> Check {
    let count = value.len();
    ensure!(
        count == dimension,
        key,
        "a {dimension}D case needs {dimension} numbers here ({unit}), not {count}"
    );
    finite(key, value, unit)
}

/// Two numbers that differ, with as many digits as show that, and five at least.
pub(super) fn unlike(a: f64, b: f64) -> [String; 2] {
    let digits =
        (4..16).find(|digits| format!("{a:.digits$e}") != format!("{b:.digits$e}")).unwrap_or(16);
    [a, b].map(|value| format!("{:?}", format!("{value:.digits$e}").parse().unwrap_or(value)))
}

/// A computed number to five digits, without the noise of its rounding.
pub(super) fn short(value: f64) -> String {
    format!("{:?}", format!("{value:.4e}").parse().unwrap_or(value))
}
