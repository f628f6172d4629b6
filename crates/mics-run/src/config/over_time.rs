//! Factors over time, by which inflows and drives vary: a hydrograph.

use super::source::{Source, named, one_of};
use super::{Case, Drive, SIDES, Side};
use crate::config::fault::{Check, finite, increasing};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A factor over time: linear between the points, constant before the first and after the last.
/// Either `time` and `factor` or `file`.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OverTime {
    /// Times (s), increasing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub time: Vec<f64>,
    /// One factor for each time; a negative one turns the flow round.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub factor: Vec<f64>,
    /// A CSV file of them: columns time, factor. Its path goes from the case file's folder.
    pub file: Option<String>,
}

impl OverTime {
    /// The factor at a time (s).
    pub fn at(&self, time: f64) -> f64 {
        let (next, weight) = between(&self.time, time);
        let low = self.factor[next - 1];
        low + weight * (self.factor[next] - low)
    }

    /// The largest size of the factor, whenever it is reached.
    pub fn largest(&self) -> f64 {
        self.factor.iter().fold(0.0, |largest, factor| largest.max(factor.abs()))
    }

    /// Takes the points of the file, if one is named, and checks all; refusals are within `key`.
    fn build(&mut self, key: &str, folder: &Path) -> Check {
        let listed = !self.time.is_empty() || !self.factor.is_empty();
        one_of(key, &[("`time` with `factor`", listed), ("`file`", self.file.is_some())])?;
        if let Some(file) = self.file.take() {
            let path = folder.join(named(&file, key)?);
            let source = Source { path: &path, key: &format!("{key}.file") };
            for (line, row) in source.rows(&["time", "factor"], "points")? {
                if let Some(before) = self.time.last().filter(|before| **before >= row[0]) {
                    let time = row[0];
                    let why = format!(
                        "column `time` must increase from line to line, and {time:?} follows \
                        {before:?}"
                    );
                    return Err(source.refuse_line(line, &why));
                }
                self.time.push(row[0]);
                self.factor.push(row[1]);
            }
        }
        increasing(&format!("{key}.time"), &self.time, "times", "s")?;
        let times = self.time.len();
        let factors = self.factor.len();
        let key = format!("{key}.factor");
        ensure!(
            factors == times,
            key,
            "needs {times} factors, one for each in `time`, not {factors}"
        );
        finite(&key, &self.factor, "a factor")
    }
}

/// Number of the first of increasing coordinates beyond a place, the second or the last at least
/// and at most, and the weight of its value in a line from the one before: 0 to 1.
pub(super) fn between(at: &[f64], place: f64) -> (usize, f64) {
    let next = at.partition_point(|at| *at <= place).clamp(1, at.len() - 1);
    let low = at[next - 1];
    (next, ((place - low) / (at[next] - low)).clamp(0.0, 1.0))
}

/// Reads the tables over time of a case's inflows and drive, and checks them; files are looked for
/// from `folder` on.
pub(super) fn build(case: &mut Case, folder: &Path) -> Check {
    for (number, name) in SIDES.into_iter().enumerate() {
        let side = case.boundary.side_mut(number).and_then(Side::over_time_mut);
        if let Some((kind, table)) = side {
            table.build(&format!("boundary.{name}.{kind}.over_time"), folder)?;
        }
    }
    match case.drive.as_mut().and_then(Drive::over_time_mut) {
        Some((kind, table)) => table.build(&format!("drive.{kind}.over_time"), folder),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::OverTime;

    #[test]
    fn factor_over_time_is_linear_between_points_and_constant_outside() {
        let factor = vec![0.5, -2.0, 1.0];
        let table = OverTime { time: vec![1.0, 2.0, 4.0], factor, file: None };
        for (time, factor) in [
            (-9.0, 0.5),
            (1.0, 0.5),
            (1.5, -0.75),
            (2.0, -2.0),
            (3.0, -0.5),
            (4.0, 1.0),
            (9.0, 1.0),
        ] {
            assert_eq!(table.at(time), factor, "at {time} s");
        }
        assert_eq!(table.largest(), 2.0);
    }
}
