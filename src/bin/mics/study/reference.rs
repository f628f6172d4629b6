//! References of measures: a value, a number in a CSV file, or what another run of the study gives.

use super::file::{Reference, Study, fault, label};
use super::planned::Planned;
use super::sheet::{Refuse, Sheet};
use mics_plot::study::Target;
use mics_run::Result;
use mics_run::config::Text;
use std::path::{Path, PathBuf};
use toml::Table;

/// A measure and its reference, run by run.
pub struct Compared {
    /// The measure's name.
    pub measure: String,
    places: Places,
}

/// Where its values come from.
enum Places {
    /// They are known before any run.
    Values(Vec<Option<f64>>),
    /// The number of the run that gives each.
    Runs(Vec<Option<usize>>),
}

impl Compared {
    /// The values, where the run of a number gives `measured`.
    pub fn target(&self, measured: impl Fn(usize) -> Option<f64>) -> Target {
        let (values, of_runs) = match &self.places {
            Places::Values(values) => (values.clone(), false),
            Places::Runs(runs) => (runs.iter().map(|run| measured((*run)?)).collect(), true),
        };
        Target { measure: self.measure.clone(), values, of_runs }
    }
}

/// The references of a study, read from their files or found among its runs.
///
/// # Errors
/// When a file has no such place, or no run of the study has the labels of a reference's.
pub fn references(
    study: &Study,
    text: &Text,
    beside: &dyn Fn(&Path) -> PathBuf,
    names: &[String],
    runs: &[Planned],
) -> Result<Vec<Compared>> {
    let mut found = Vec::new();
    for (index, reference) in study.reference.iter().enumerate() {
        let refuse = |key: &str, message: String| {
            text.refuse(fault(format!("reference.{index}{key}"), message))
        };
        let places = match (&reference.file, &reference.column) {
            (Some(file), Some(column)) => {
                let sheet = Sheet::read(&beside(file), &refuse)?;
                Places::Values(in_file(reference, &sheet, column, names, runs, &refuse)?)
            }
            _ if !reference.run.is_empty() => {
                let all: Vec<_> =
                    runs.iter().map(|run| other_run(&reference.run, names, run, runs)).collect();
                if all.iter().all(Option::is_none) {
                    let wanted: Vec<String> = (reference.run.iter())
                        .map(|(name, value)| format!("{name}={}", label(value)))
                        .collect();
                    let message = format!(
                        "no run has the labels of another one but {}; a row's labels must be those \
                        of the runs that are compared with it, and [quick] must keep it",
                        wanted.join(", ")
                    );
                    return Err(refuse(".run", message));
                }
                Places::Runs(all)
            }
            _ => Places::Values(vec![reference.value; runs.len()]),
        };
        found.push(Compared { measure: reference.measure.clone(), places });
    }
    Ok(found)
}

/// The values in the rows of a file that are meant.
fn in_file(
    reference: &Reference,
    sheet: &Sheet,
    column: &str,
    names: &[String],
    runs: &[Planned],
    refuse: Refuse,
) -> Result<Vec<Option<f64>>> {
    let at = sheet.position(column, ".column", refuse)?;
    let fixed: Vec<(usize, String)> = reference
        .row
        .iter()
        .map(|(name, wanted)| {
            Ok((sheet.position(name, &format!(".row.{name}"), refuse)?, label(wanted)))
        })
        .collect::<Result<_>>()?;
    let of_label = |(name, axis): (&String, &String)| {
        let of = names.iter().position(|other| other == axis).unwrap_or_default();
        Ok((sheet.position(name, &format!(".row_of.{name}"), refuse)?, of))
    };
    let varied: Vec<(usize, usize)> =
        reference.row_of.iter().map(of_label).collect::<Result<_>>()?;
    let value = |run: &Planned| {
        let varied = varied.iter().map(|(column, of)| (*column, run.labels[*of].clone()));
        sheet.value(
            at,
            &fixed.iter().cloned().chain(varied).collect::<Vec<_>>(),
            !reference.row_of.is_empty(),
            refuse,
        )
    };
    runs.iter().map(value).collect()
}

/// The number of the run that differs from `run` in the labels `wanted` and in nothing else.
fn other_run(wanted: &Table, names: &[String], run: &Planned, runs: &[Planned]) -> Option<usize> {
    let of = |name: &String, own: String| wanted.get(name).map_or(own, label);
    let labels: Vec<String> =
        names.iter().zip(&run.labels).map(|(name, own)| of(name, own.clone())).collect();
    let ranks = of(&"ranks".to_owned(), run.ranks.to_string());
    let is = |other: &Planned| other.labels == labels && other.ranks.to_string() == ranks;
    runs.iter().position(|other| is(other) && other.id != run.id)
}
