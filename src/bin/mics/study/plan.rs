//! The runs of a study: the product of its axes and its listed rows, every case read and checked.

use super::columns::number_columns;
use super::file::{Axis, Choice, Listed, Study, fault};
use super::planned::{Planned, Refusal};
use super::reference::{Compared, references};
use mics::scene::read_case;
use mics_run::Result;
use mics_run::config::{Text, suggest};
use std::collections::BTreeMap;
use std::path::Path;
use toml::Value;

/// The runs of a study, and what they are compared with.
pub struct Plan {
    /// The names of the columns that tell runs apart.
    pub names: Vec<String>,
    /// The runs, in their order.
    pub runs: Vec<Planned>,
    /// References of measures, by the measure.
    pub references: BTreeMap<String, Compared>,
}

/// Labels and overrides of a run, by choices of axes or by a listed row.
#[derive(Clone, Default)]
struct Draft {
    labels: BTreeMap<String, String>,
    set: Vec<(String, Value)>,
    sources: Vec<String>,
}

impl Draft {
    fn with(&self, other: &Draft) -> Draft {
        let mut both = self.clone();
        both.labels.extend(other.labels.clone());
        both.set.extend(other.set.iter().cloned());
        both.sources.extend(other.sources.iter().cloned());
        both
    }
}

/// The choices of each axis, as drafts.
fn choices(study: &Study) -> Vec<Vec<Draft>> {
    let of = |(index, axis): (usize, &Axis)| {
        let draft = |(k, Choice { label, set }): (usize, Choice)| Draft {
            labels: [(axis.name.clone(), label.0)].into(),
            set: set.into_iter().collect(),
            sources: vec![format!("axis.{index}.{}.{k}", axis.list())],
        };
        axis.all().into_iter().enumerate().map(draft).collect()
    };
    study.axis.iter().enumerate().map(of).collect()
}

/// Each of some drafts with each of others.
fn product(drafts: Vec<Draft>, others: &[Draft]) -> Vec<Draft> {
    drafts.iter().flat_map(|draft| others.iter().map(|other| draft.with(other))).collect()
}

/// The product of the axes, then each listed row with the axes that it does not label. Rows that
/// label no axis stand in for the case itself.
fn drafts(study: &Study) -> Vec<Draft> {
    let axes = choices(study);
    let all = || study.axis.iter().zip(&axes);
    let rows = study.row.iter().enumerate().flat_map(|(index, row)| {
        let own = Draft {
            labels: row.labels.iter().map(|(name, l)| (name.clone(), l.0.clone())).collect(),
            set: row.set.clone().into_iter().collect(),
            sources: vec![format!("row.{index}")],
        };
        let others = all().filter(|(axis, _)| !row.labels.contains_key(&axis.name));
        others.fold(vec![own], |drafts, (_, choices)| product(drafts, choices))
    });
    let labelled = |row: &Listed| study.axis.iter().any(|axis| row.labels.contains_key(&axis.name));
    let mut drafts = Vec::new();
    if study.row.is_empty() || study.row.iter().any(labelled) {
        drafts =
            all().fold(vec![Draft::default()], |drafts, (_, choices)| product(drafts, choices));
    }
    drafts.extend(rows);
    drafts
}

/// The folder's name of a run.
fn id(names: &[String], labels: &[String]) -> String {
    let named = names.iter().zip(labels).filter(|(_, label)| !label.is_empty());
    let id = named.map(|(name, label)| format!("{name}={label}")).collect::<Vec<_>>().join(",");
    let plain = |c: char| if c.is_ascii_alphanumeric() || "=,.+-_".contains(c) { c } else { '_' };
    if id.is_empty() { "case".into() } else { id.chars().map(plain).collect() }
}

/// The run of a draft.
fn planned(study: &Study, names: &[String], draft: Draft, folder: &Path) -> Planned {
    let mut case = folder.join(&study.case);
    let mut ranks = 1;
    // A study has no use for figures of its runs unless it asks for them.
    let mut set = vec!["output.figures=false".to_owned()];
    let common = study.set.clone().into_iter();
    for (key, value) in common.chain(draft.set).chain(study.quick.set.clone()) {
        match (key.as_str(), &value) {
            ("case", Value::String(file)) => case = folder.join(file),
            ("ranks", Value::Integer(count)) => ranks = usize::try_from(*count).unwrap_or(1),
            _ => set.push(format!("{key}={value}")),
        }
    }
    let label = |name: &String| draft.labels.get(name).cloned().unwrap_or_default();
    let labels: Vec<String> = names.iter().map(label).collect();
    let loaded = read_case(&case, &set).map(|loaded| loaded.case).map_err(|e| Refusal::of(&e));
    Planned { id: id(names, &labels), labels, ranks, case, set, loaded, sources: draft.sources }
}

impl Plan {
    /// Plans the runs of a study.
    ///
    /// # Errors
    /// When the case, a reference or the name in an override is wrong, or no run is left. A choice
    /// with a value that is refused is no error: its runs are refused.
    pub fn new(study: &Study, text: &Text) -> Result<Plan> {
        let folder = text.file.parent().unwrap_or(Path::new(""));
        read_case(&folder.join(&study.case), &[])?;
        for (key, set) in [("set", &study.set), ("quick.set", &study.quick.set)] {
            let draft = Draft { set: set.clone().into_iter().collect(), ..Draft::default() };
            if let Err(refusal) = planned(study, &[], draft, folder).loaded {
                return Err(text.refuse(fault(key, refusal.why)));
            }
        }
        let names = study.names();
        let drafts = drafts(study).into_iter();
        let mut runs: Vec<Planned> =
            drafts.map(|draft| planned(study, &names, draft, folder)).collect();
        refuse_faults(&runs, text)?;
        refuse_unknown(study, &runs, text)?;
        let kept = |(name, label): (&String, &String)| {
            let kept = study.quick.keep.get(name);
            kept.is_none_or(|kept| label.is_empty() || kept.iter().any(|k| k.0 == *label))
        };
        runs.retain(|run| names.iter().zip(&run.labels).all(kept));
        let references = references(study, text, folder, &names, &runs)?;
        Ok(Plan { names, runs, references })
    }

    /// The names of all measures of the cases.
    pub fn measures(&self) -> Vec<String> {
        measures(&self.runs)
    }
}

/// The names of the measures of some runs, each once.
fn measures(runs: &[Planned]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for measure in runs.iter().flat_map(|run| &run.loaded).flat_map(|case| &case.measure) {
        if !names.contains(&measure.name) {
            names.push(measure.name.clone());
        }
    }
    names
}

/// Refuses what is a fault of the study file and not of a run: labels that two runs have, a choice
/// with a misspelt name, and a study of which no run is left. Any other choice that is refused is a
/// row with its reason.
fn refuse_faults(runs: &[Planned], text: &Text) -> Result<()> {
    let refuse = |source: &str, why: &str| {
        let key = if source.starts_with("row.") { format!("{source}.set") } else { source.into() };
        Err(text.refuse(fault(key, why)))
    };
    for (index, run) in runs.iter().enumerate() {
        if runs[..index].iter().any(|other| other.id == run.id) {
            let message = format!("another run has the labels `{}` too; give it others", run.id);
            let source = run.sources.first().cloned().unwrap_or_default();
            return Err(text.refuse(fault(source, message)));
        }
    }
    for (run, source) in runs.iter().flat_map(|run| run.sources.iter().map(move |s| (run, s))) {
        let mut of_source = runs.iter().filter(|other| other.sources.contains(source));
        let misspelt = |run: &Planned| run.loaded.as_ref().is_err_and(|refusal| refusal.misspelt);
        if let (true, Err(refusal)) = (of_source.all(misspelt), &run.loaded) {
            return refuse(source, &refusal.why);
        }
    }
    match runs.first().map(|run| (run.sources.last(), &run.loaded)) {
        Some((source, Err(refusal))) if runs.iter().all(|run| run.loaded.is_err()) => {
            refuse(source.map_or("case", String::as_str), &refusal.why)
        }
        _ => Ok(()),
    }
}

/// Refuses references of measures, and columns to be shown, that do not exist.
fn refuse_unknown(study: &Study, runs: &[Planned], text: &Text) -> Result<()> {
    let measures = measures(runs);
    let measures: Vec<&str> = measures.iter().map(String::as_str).collect();
    for name in study.reference.keys() {
        if !measures.contains(&name.as_str()) {
            let message = format!("the case has no measure `{name}`; {}", suggest(name, &measures));
            return Err(text.refuse(fault(format!("reference.{name}"), message)));
        }
    }
    let columns = [&measures[..], &number_columns()].concat();
    for (index, name) in study.columns.iter().flatten().enumerate() {
        if !columns.contains(&name.as_str()) {
            let message = format!("study.csv has no number `{name}`; {}", suggest(name, &columns));
            return Err(text.refuse(fault(format!("columns.{index}"), message)));
        }
    }
    Ok(())
}
