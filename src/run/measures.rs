//! Measurements of a run: the series of the case's measures, its statistics, its probes.

use crate::Result;
use crate::config::Case;
use crate::output::measure::{self, Series};
use crate::output::probe::Probes;
use crate::output::statistics::Statistics;
use crate::scene::Scene;
use mics_run::compare::measured;
use serde_json::{Map, Value, json};
use std::fmt::Arguments;
use std::path::Path;

/// The measures, the statistics and the probes of a case.
pub(super) struct Measures<const D: usize> {
    /// One series a measure.
    pub series: Vec<Series>,
    /// Sums over time, where the case asks for them.
    pub statistics: Option<Statistics<D>>,
    probes: Probes,
}

impl<const D: usize> Measures<D> {
    /// The measures of a case, which have taken nothing yet.
    pub fn new(case: &Case, scene: &Scene<D>) -> Measures<D> {
        Measures {
            series: measure::series(case),
            statistics: Statistics::of_case(scene, case),
            probes: Probes::new(&case.probe),
        }
    }

    /// Goes on, at `time` (s), with the series of a run before: `wanted` take over what the same
    /// measure has found there, and begin now where there was none.
    pub fn go_on_with(&mut self, mut wanted: Vec<Series>, time: f64) {
        for new in &mut wanted {
            match self.series.iter().position(|old| old.measure().is_of(new.measure())) {
                Some(at) => new.take_over(self.series.swap_remove(at)),
                None => new.begin_at(time),
            }
        }
        self.series = wanted;
    }

    /// Gives every series the state after a step, in which the fluid's largest speed is `speed`
    /// (m/s).
    pub fn sample(&mut self, scene: &Scene<D>, speed: f64) -> Result<()> {
        self.series.iter_mut().try_for_each(|series| series.take(scene, speed))
    }

    /// Gives every series the fields of a snapshot. Collective.
    pub fn take_fields(&mut self, scene: &Scene<D>) -> Result<()> {
        self.series.iter_mut().try_for_each(|series| series.take_fields(scene))
    }

    /// Gives statistics and probes the state; `put` takes the lines of the probes. Collective.
    pub fn record(
        &mut self,
        scene: &mut Scene<D>,
        put: impl FnMut(Arguments) -> Result<()>,
    ) -> Result<()> {
        if let Some(statistics) = &mut self.statistics {
            statistics.take(scene);
        }
        self.probes.record(scene, put)
    }

    /// Writes the statistics into the run's folder. Collective.
    pub fn write_statistics(&self, scene: &Scene<D>, out: &Path) -> Result<()> {
        self.statistics.as_ref().map_or(Ok(()), |statistics| statistics.write(scene, out))
    }

    /// The measures that have a value so far, by name.
    pub fn values(&self) -> Map<String, Value> {
        self.table(|series| Some(json!(series.value()?)))
    }

    /// Table, by name, of a value `of` each measure; measures without one are left out.
    pub fn table(&self, of: impl Fn(&Series) -> Option<Value>) -> Map<String, Value> {
        let row = |series: &Series| Some((series.name().to_owned(), of(series)?));
        self.series.iter().filter_map(row).collect()
    }

    /// Doubts about measures of a run that is done.
    pub fn doubts(&self) -> Vec<String> {
        let remarks = self.series.iter().filter_map(|s| Some((s.name(), s.remark()?)));
        let doubts = remarks.filter(|(_, remark)| remark.doubt);
        doubts.map(|(name, remark)| format!("{name} {}", remark.words)).collect()
    }

    /// A line for each measure: what it gives, beside its reference.
    pub fn lines(&self) -> impl Iterator<Item = String> {
        self.series.iter().map(|series| {
            let name = series.name();
            let Some(value) = series.value() else {
                return format!(
                    "{name}: the run gives no value (no oscillation, no contact, a particle that \
                    was not there, or no steps after `from`)"
                );
            };
            let value = format!("{name} = {} {}", measured(value), series.unit(D));
            let beside = series.comparison().map(|comparison| format!(", {comparison}"));
            let remark = series.remark().map(|remark| format!("; {}", remark.words));
            let beside = beside.unwrap_or_default();
            let remark = remark.unwrap_or_default();
            format!("{}{beside}{remark}", value.trim_end())
        })
    }
}
