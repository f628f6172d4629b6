//! The runs of a study: the product of its axes and its listed rows, on each number of ranks, every
//! case read and checked.

use super::columns;
use super::file::{Study, fault, label};
use super::planned::{Planned, Refusal, reason};
use super::reference::{Compared, references};
use super::sheet::Sheet;
use mics::scene::read_case;
use mics_plot::study::Others;
use mics_run::Result;
use mics_run::config::{Text, suggest};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use toml::Table;

/// The runs of a study, and what they are compared with.
pub struct Plan {
    /// The names of the columns that tell runs apart.
    pub names: Vec<String>,
    /// The runs, in their order.
    pub runs: Vec<Planned>,
    /// References that measures are compared with.
    pub references: Vec<Compared>,
    /// Errors of other programs, and their costs.
    pub others: Vec<Others>,
}

/// Additions to a run by a choice of an axis, or by a listed row.
#[derive(Clone, Default)]
struct Draft {
    labels: BTreeMap<String, String>,
    case: Option<PathBuf>,
    set: Vec<String>,
    petsc: Vec<String>,
    sources: Vec<String>,
}

impl Draft {
    fn with(&self, other: &Draft) -> Draft {
        let mut both = self.clone();
        both.labels.extend(other.labels.clone());
        both.case = other.case.clone().or(both.case);
        both.set.extend(other.set.iter().cloned());
        both.petsc.extend(other.petsc.iter().cloned());
        both.sources.extend(other.sources.iter().cloned());
        both
    }
}

fn words(options: &str) -> Vec<String> {
    options.split_whitespace().map(str::to_owned).collect()
}

fn overrides(set: &Table) -> Vec<String> {
    set.iter().map(|(key, value)| format!("{key}={value}")).collect()
}

/// The product of the axes, then the listed rows.
fn drafts(study: &Study) -> Vec<Draft> {
    let mut product = vec![Draft::default()];
    for (index, axis) in study.axis.iter().enumerate() {
        let place = |list: &str, k: usize| vec![format!("axis.{index}.{list}.{k}")];
        let of_key = axis
            .key
            .iter()
            .flat_map(|key| axis.values.iter().enumerate().map(move |(k, v)| (k, key, v)));
        let values = of_key.map(|(k, key, value)| Draft {
            set: vec![format!("{key}={value}")],
            sources: place("values", k),
            ..Draft::default()
        });
        let choices = axis.choices.iter().enumerate().map(|(k, choice)| Draft {
            set: overrides(&choice.set),
            petsc: words(&choice.petsc),
            sources: place("choices", k),
            ..Draft::default()
        });
        let named: Vec<Draft> = values
            .chain(choices)
            .zip(axis.labels())
            .map(|(draft, label)| Draft { labels: [(axis.name.clone(), label)].into(), ..draft })
            .collect();
        product = product
            .iter()
            .flat_map(|draft| named.iter().map(|choice| draft.with(choice)))
            .collect();
    }
    // Without axes the product is the case itself, which rows stand in for.
    if study.axis.is_empty() && !study.row.is_empty() {
        product.clear();
    }
    let rows = study.row.iter().enumerate().map(|(index, row)| Draft {
        labels: row.labels.iter().map(|(name, value)| (name.clone(), label(value))).collect(),
        case: row.case.clone(),
        set: overrides(&row.set),
        petsc: words(&row.petsc),
        sources: vec![format!("row.{index}")],
    });
    product.into_iter().chain(rows).collect()
}

/// The folder's name of a run.
fn id(names: &[String], labels: &[String], ranks: Option<usize>) -> String {
    let named = names.iter().zip(labels).filter(|(_, label)| !label.is_empty());
    let parts = named.map(|(name, label)| format!("{name}={label}"));
    let id = parts.chain(ranks.map(|ranks| format!("ranks={ranks}"))).collect::<Vec<_>>().join(",");
    let plain = |c: char| if c.is_ascii_alphanumeric() || "=,.+-_".contains(c) { c } else { '_' };
    if id.is_empty() { "case".into() } else { id.chars().map(plain).collect() }
}

/// The runs of a draft, one for each number of ranks; none where `--quick` keeps none.
fn planned(
    study: &Study,
    names: &[String],
    draft: &Draft,
    case: &Path,
    set: &[String],
) -> Vec<Planned> {
    let kept = |name: &str, of_run: &str| {
        let kept = study.quick.keep.get(name);
        kept.is_none_or(|kept| kept.iter().any(|value| label(value) == of_run))
    };
    if !draft.labels.iter().all(|(name, label)| kept(name, label)) {
        return Vec::new();
    }
    let loaded = read_case(case, set).map(|loaded| loaded.case).map_err(|e| Refusal::of(&e));
    let labels: Vec<String> =
        names.iter().map(|name| draft.labels.get(name).cloned().unwrap_or_default()).collect();
    let run = |ranks: &usize| Planned {
        id: id(names, &labels, (study.ranks.len() > 1).then_some(*ranks)),
        labels: labels.clone(),
        ranks: *ranks,
        case: case.to_owned(),
        set: set.to_vec(),
        petsc: [words(&study.petsc), draft.petsc.clone()].concat(),
        loaded: loaded.clone(),
        sources: draft.sources.clone(),
    };
    study.ranks.iter().filter(|ranks| kept("ranks", &ranks.to_string())).map(run).collect()
}

impl Plan {
    /// Plans the runs of a study.
    ///
    /// # Errors
    /// When the case, a reference or the name in an override is wrong, or no run is left. A choice
    /// with a value that is refused is no error: its runs are refused.
    pub fn new(study: &Study, text: &Text) -> Result<Plan> {
        let beside = |path: &Path| text.file.parent().unwrap_or(Path::new("")).join(path);
        // A study has no use for figures of its runs unless it asks for them.
        let common: Vec<String> =
            ["output.figures=false".to_owned()].into_iter().chain(overrides(&study.set)).collect();
        let last = overrides(&study.quick.set);
        let case = beside(&study.case);
        read_case(&case, &[])?;
        for (key, set) in [("set", &common), ("quick.set", &[&common[..], &last[..]].concat())] {
            read_case(&case, set).map_err(|e| text.refuse(fault(key, reason(&e))))?;
        }

        let names = study.names();
        let drafts = drafts(study);
        let case_of = |draft: &Draft| draft.case.as_deref().map_or_else(|| case.clone(), beside);
        let mut runs: Vec<Planned> = Vec::new();
        for draft in &drafts {
            let set = [&common[..], &draft.set[..], &last[..]].concat();
            for run in planned(study, &names, draft, &case_of(draft), &set) {
                if runs.iter().any(|other| other.id == run.id) {
                    let source = draft.sources.first().cloned().unwrap_or_default();
                    let message =
                        format!("another run has the labels `{}` too; give it others", run.id);
                    return Err(text.refuse(fault(source, message)));
                }
                runs.push(run);
            }
        }
        let references = references(study, text, &beside, &names, &runs)?;
        let others = others(study, text, &beside)?;
        let plan = Plan { names, runs, references, others };
        plan.refuse_faults(text, &common, &case)?;
        // A measure may be one of runs that --quick leaves out.
        let all = drafts.iter().filter_map(|draft| {
            let loaded =
                read_case(&case_of(draft), &[&common[..], &draft.set[..]].concat()).ok()?;
            Some(loaded.case.measure.into_iter().map(|measure| measure.name))
        });
        plan.refuse_unknown_measures(study, text, all.flatten())?;
        Ok(plan)
    }

    /// Refuses what is a fault of the study file and not of a run: a choice with a misspelt name,
    /// and a study of which no run is left. Any other choice that is refused is a row with its
    /// reason.
    fn refuse_faults(&self, text: &Text, common: &[String], base: &Path) -> Result<()> {
        let sources: BTreeSet<&String> = self.runs.iter().flat_map(|run| &run.sources).collect();
        let of = |source: &String| {
            self.runs.iter().filter(|run| run.sources.contains(source)).collect::<Vec<_>>()
        };
        let none_left = self.runs.iter().all(|run| run.loaded.is_err());
        let misspelt = |run: &Planned| run.loaded.as_ref().is_err_and(|refusal| refusal.misspelt);
        let faulty = |source: &&&String| {
            let runs = of(source);
            runs.iter().all(|run| run.loaded.is_err())
                && (none_left || runs.iter().any(|run| misspelt(run)))
        };
        let never = || sources.iter().filter(faulty);
        // Where several are never accepted, one that is refused by itself is to blame, not those
        // that only met it.
        let by_itself = |source: &&&String| {
            let runs = of(source);
            let shared = |given: &&String| runs.iter().all(|run| run.set.contains(given));
            let set =
                runs.first().map(|run| run.set.iter().filter(shared).cloned().collect::<Vec<_>>());
            read_case(runs.first().map_or(base, |run| &run.case), set.as_deref().unwrap_or(common))
                .is_err()
        };
        let Some(source) = never().find(by_itself).or_else(|| never().next()) else {
            return Ok(());
        };
        let refusal = of(source).iter().find_map(|run| run.loaded.as_ref().err().cloned());
        let key =
            if source.starts_with("row.") { format!("{source}.set") } else { source.to_string() };
        Err(text.refuse(fault(key, refusal.map(|refusal| refusal.why).unwrap_or_default())))
    }

    /// Refuses references of measures, and columns to be laid out, that do not exist; `all` are the
    /// names of the measures of all the file's runs, looked up where the runs of this plan do not
    /// have one.
    fn refuse_unknown_measures(
        &self,
        study: &Study,
        text: &Text,
        all: impl Iterator<Item = String>,
    ) -> Result<()> {
        let references = study.reference.iter().enumerate();
        let references = references.map(|(k, r)| (format!("reference.{k}.measure"), &r.measure));
        let crossed = study.cross.iter().enumerate();
        let crossed = crossed.map(|(k, cross)| (format!("cross.{k}.column"), &cross.column));
        let of_error = |name: &str| name.strip_suffix("_error").is_some_and(|m| self.compares(m));
        let numbers = columns::numbers();
        let crossed = crossed.filter(|(_, n)| !numbers.contains(&n.as_str()) && !of_error(n));
        let wanted: Vec<(String, &String)> = references.chain(crossed).collect();
        let mut known = self.measures();
        let unknown =
            |known: &[String]| wanted.iter().find(|(_, name)| !known.contains(name)).cloned();
        if unknown(&known).is_none() {
            return Ok(());
        }
        known.extend(all);
        known.sort();
        known.dedup();
        let Some((key, name)) = unknown(&known) else { return Ok(()) };
        let mut known: Vec<&str> = known.iter().map(String::as_str).collect();
        let what = if key.starts_with("cross") {
            known.extend(numbers);
            "study.csv has no number"
        } else {
            "the case has no measure"
        };
        Err(text.refuse(fault(key, format!("{what} `{name}`; {}", suggest(name, &known)))))
    }

    /// Whether a measure is compared with something.
    pub fn compares(&self, measure: &str) -> bool {
        self.references.iter().any(|compared| compared.measure == measure)
    }

    /// The names of all measures of the cases.
    pub fn measures(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for case in self.runs.iter().filter_map(|run| run.loaded.as_ref().ok()) {
            for measure in &case.measure {
                if !names.contains(&measure.name) {
                    names.push(measure.name.clone());
                }
            }
        }
        names
    }
}

/// The points of others, read from their files.
fn others(study: &Study, text: &Text, beside: &dyn Fn(&Path) -> PathBuf) -> Result<Vec<Others>> {
    let read = |(index, others): (usize, &super::file::Others)| {
        let refuse = |key: &str, message: String| {
            text.refuse(fault(format!("plot.others.{index}{key}"), message))
        };
        if !study.reference.iter().any(|reference| reference.measure == others.measure) {
            let message =
                format!("`{}` has no reference, and so no figure of its error", others.measure);
            return Err(refuse(".measure", message));
        }
        let sheet = Sheet::read(&beside(&others.file), &refuse)?;
        let column = |name: &str, key: &str| sheet.position(name, key, &refuse);
        let numbers = [column(&others.cpu, ".cpu")?, column(&others.error, ".error")?];
        let points = sheet.points(column(&others.label, ".label")?, numbers);
        Ok(Others { measure: others.measure.clone(), points })
    };
    study.plot.others.iter().enumerate().map(read).collect()
}
