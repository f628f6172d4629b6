//! The page `docs/accuracy.md`: written by `mics validate --markdown`, read by `--compare`.

use super::{Found, Request};
use crate::study::markdown;
use mics_run::compare::{Comparison, percent, significant};
use mics_run::config::Reference;
use mics_run::summary::Summary;
use mics_run::{Error, Result};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Largest change of a value from the page, as a part of the room that its tolerance leaves.
const PART: f64 = 0.1;

/// Relative change of a value from which on it counts: the page has five digits.
const ROUNDING: f64 = 1e-4;

/// The columns of the table.
pub(super) const COLUMNS: [&str; 9] =
    ["case", "measure", "value", "reference", "difference", "tolerance", "", "steps", "s"];

/// The page of a table of values.
pub(super) fn page(request: &Request, table: &str, found: &Found) -> String {
    let mut command = "mics validate".to_owned();
    request.names.iter().for_each(|name| command += &format!(" \"{name}\""));
    command += if request.full { " --full --markdown" } else { " --markdown" };
    let version = env!("CARGO_PKG_VERSION");
    let commit = crate::COMMIT;
    let pass = found.pass;
    let all = pass + found.short;
    let sources = sources(found);
    format!(
        "# Accuracy\n\n\
        This page is what `{command}` printed, by mics {version} of commit {commit}.\n\
        Nothing in it is typed. Each row is a measure of a shipped case beside its reference. The \
        difference is a part of the\n\
        reference, or the place in a band, from 0 at its lower to 100 % at its upper end. The \
        tolerance is what was asked for before the run was made, not what was\n\
        reached: a value passes within it, and otherwise *falls short*. Seconds are those of the \
        whole run on the machine that\n\
        made the page. `mics validate --full --compare docs/accuracy.md` says what has moved \
        since.\n\n\
        {table}\n{pass} of {all} values pass.\n\n## Where the references are from\n\n{sources}"
    )
}

/// The table of where the references are from.
fn sources(found: &Found) -> String {
    let row = |of_one: &[(String, String, String)]| {
        let measures: Vec<&str> = of_one.iter().map(|(_, measure, _)| measure.as_str()).collect();
        vec![of_one[0].0.clone(), measures.join(", "), of_one[0].2.clone()]
    };
    let rows = found.sources.chunk_by(|a, b| (&a.0, &a.2) == (&b.0, &b.2)).map(row);
    markdown(&["case", "measures", "source"], rows.collect()).trim_end().to_owned()
}

/// A row of the table.
pub(super) fn row(case: &str, measure: &str, c: &Comparison, run: &Summary) -> Vec<String> {
    let verdict = c.verdict();
    vec![
        case.to_owned(),
        measure.to_owned(),
        c.value.map_or("none".into(), significant),
        c.reference.to_string(),
        c.difference().unwrap_or_default(),
        percent(c.tolerance),
        if c.pass { verdict.to_owned() } else { format!("**{verdict}**") },
        run.steps.to_string(),
        format!("{:.1}", run.cost.wall_seconds),
    ]
}

/// Value of a page, where it has one, and whether it passed.
type Before = (Option<f64>, bool);

/// A page that was written before.
#[derive(Debug)]
pub(super) struct Page {
    /// The file.
    pub file: PathBuf,
    /// Values by case and measure.
    rows: BTreeMap<(String, String), Before>,
}

impl Page {
    /// Reads a page.
    ///
    /// # Errors
    /// When the file cannot be read or has no table of values.
    pub fn read(file: &Path) -> Result<Page> {
        let text = fs::read_to_string(file).map_err(|e| {
            Error::Usage(format!(
                "{}: cannot be read ({e}); give a page to --compare",
                file.display()
            ))
        })?;
        let rows: BTreeMap<_, _> = text.lines().filter_map(parse).collect();
        if rows.is_empty() {
            let cure = "no row of values in it; give a page that `mics validate --markdown` wrote";
            return Err(Error::Usage(format!("{}: {cure}", file.display())));
        }
        Ok(Page { file: file.to_owned(), rows })
    }

    /// Message about a value that has moved from the page; `None` where it has not.
    pub fn moved(&self, case: &str, measure: &str, now: &Comparison) -> Option<String> {
        let value = now.value.map_or("none".into(), significant);
        let of = (case.to_owned(), measure.to_owned());
        let Some((before, passed)) = self.rows.get(&of) else {
            return Some(format!("{case}, {measure}: {value}, which the page does not have"));
        };
        let was = before.map_or("none".into(), significant);
        let distance = match (now.value, before) {
            (Some(now), Some(before)) => (now - before).abs(),
            (None, None) => 0.0,
            _ => f64::INFINITY,
        };
        let half = match now.reference {
            Reference::Value(_) => 0.0,
            Reference::Band([low, high]) => 0.5 * (high - low),
        };
        let room = now.tolerance * now.reference.middle().abs() + half;
        let rounding = ROUNDING * before.map_or(0.0, f64::abs);
        if distance > (PART * room).max(rounding) {
            let part = if room > 0.0 {
                format!(" ({} of its tolerance)", percent(distance / room))
            } else {
                String::new()
            };
            return Some(format!("{case}, {measure}: {value}, was {was}{part}"));
        }
        (*passed && !now.pass)
            .then(|| format!("{case}, {measure}: {value} falls short, {was} passed"))
    }
}

/// A row of the table, from its line.
fn parse(line: &str) -> Option<((String, String), Before)> {
    let cells: Vec<&str> =
        line.strip_prefix('|')?.strip_suffix('|')?.split('|').map(str::trim).collect();
    let [case, measure, value, _, _, _, verdict, steps, _] = cells.as_slice() else { return None };
    steps.parse::<u64>().ok()?;
    let value = if *value == "none" { None } else { Some(value.parse().ok()?) };
    Some((((*case).to_owned(), (*measure).to_owned()), (value, *verdict == "pass")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn comparison(value: Option<f64>, reference: Reference, tolerance: f64) -> Comparison {
        let error = value.map(|v| v / reference.middle() - 1.0);
        let pass = value.is_some_and(|v| reference.holds(v, tolerance));
        Comparison { value, reference, tolerance, error, pass, source: None }
    }

    /// The page of some values, each a (measure, comparison) of one case.
    fn page(folder: &Path, values: &[(&str, Comparison)]) -> Page {
        let run: Summary =
            serde_json::from_str("{\"steps\": 420, \"wall_seconds\": 1.25}").unwrap();
        let rows = values.iter().map(|(measure, c)| row("disc N 8", measure, c, &run));
        let table = markdown(&COLUMNS, rows.collect());
        let text = super::page(&Request::default(), &table, &Found::default());
        let file = folder.join("accuracy.md");
        fs::write(&file, text).unwrap();
        Page::read(&file).unwrap()
    }

    #[test]
    fn accuracy_page_names_value_moved_by_tenth_of_tolerance() {
        let folder = tempfile::tempdir().unwrap();
        let two = Reference::Value(2.0);
        let band = Reference::Band([0.0, 2.0]);
        let none = comparison(None, two, 0.1);
        let of = |value: f64| comparison(Some(value), two, 0.1);
        let values = [
            ("drag", of(2.1)),
            ("lift", comparison(Some(1.5), band, 0.0)),
            ("kiss", none.clone()),
            ("edge", of(2.199)),
        ];
        let page = page(folder.path(), &values);
        let same = values.iter().all(|(measure, c)| page.moved("disc N 8", measure, c).is_none());
        assert!(same, "a page is like itself: {page:?}");
        assert_eq!(page.moved("disc N 8", "drag", &of(2.119)), None);
        let said = page.moved("disc N 8", "drag", &of(2.05)).unwrap();
        assert_eq!(said, "disc N 8, drag: 2.0500, was 2.1000 (25 % of its tolerance)");
        assert!(page.moved("disc N 8", "lift", &comparison(Some(1.61), band, 0.0)).is_some());
        assert!(
            page.moved("disc N 8", "kiss", &of(2.0)).is_some()
                && page.moved("disc N 8", "drag", &none).is_some()
        );
        assert!(page.moved("disc N 8", "edge", &of(2.201)).unwrap().contains("falls short"));
        assert!(page.moved("disc N 16", "drag", &of(2.1)).unwrap().contains("does not have"));
    }

    #[test]
    fn accuracy_page_digits_and_refused_files() {
        let written = [1.5576, -0.00871234, 75.123456, 0.0, 1.25e-7, 123456.7].map(significant);
        assert_eq!(written, ["1.5576", "-0.0087123", "75.123", "0.0000", "1.2500e-7", "1.2346e5"]);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("page.md");
        for text in [None, Some("# A page\n\n| a | b |\n|---|---|\n| 1 | 2 |\n")] {
            text.iter().for_each(|text| fs::write(&file, text).unwrap());
            assert!(matches!(Page::read(&file), Err(Error::Usage(m)) if m.contains("page.md")));
        }
    }
}
