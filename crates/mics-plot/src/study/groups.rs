//! Which runs of a study are a curve of its figures, and which a point of it.

use super::{Row, Study};
use crate::figure::{Series, SeriesStyle};

/// Curves in a figure at most, where they can be divided among several.
const CURVES: usize = 16;

/// Place of the runs of a point in a figure, if they have one.
pub type Place<'a> = &'a dyn Fn(&[&Row]) -> Option<(f64, f64)>;

/// Rows of each point of each curve, in one figure.
#[derive(Debug)]
pub struct Group {
    /// Labels that all of its rows have, of a study whose curves are more than a figure can show.
    pub title: Vec<String>,
    /// The column along which the points of a curve follow each other.
    pub along: Option<usize>,
    /// The curves: their names, and the numbers of the rows of each of their points.
    curves: Vec<(String, Vec<Vec<usize>>)>,
}

/// The different labels of some rows in a column.
fn labels<'a>(study: &'a Study, rows: &[usize], column: usize) -> Vec<&'a str> {
    let mut labels: Vec<&str> =
        rows.iter().map(|row| study.rows[*row].labels[column].as_str()).collect();
    labels.sort_unstable();
    labels.dedup();
    labels
}

impl Group {
    /// The figures of a study. Along a curve the numeric column with most labels changes, not the
    /// one across if there is another, or else the first; all other columns that change tell one
    /// curve from another, but for those that are summed up. Where that makes too many curves, each
    /// label of the first has figures of its own.
    pub fn all(study: &Study) -> Vec<Group> {
        let rows: Vec<usize> = (0..study.rows.len()).collect();
        let count = |column: &usize| labels(study, &rows, *column).len();
        let varied = (0..study.names.len()).filter(|column| count(column) > 1);
        let varied = varied.filter(|column| !study.over.contains(&study.names[*column]));
        let mut varied: Vec<usize> = varied.collect();
        let rank = |column: &usize| {
            let tells_apart = Some(&study.names[*column]) == study.across.as_ref();
            (!tells_apart, count(column))
        };
        let along = varied.iter().copied().filter(|column| study.is_numeric(*column));
        // Of several with as many labels the first, which `max_by_key` meets last.
        let along = along.rev().max_by_key(rank).or(varied.first().copied());
        varied.retain(|column| Some(*column) != along);
        divided(study, rows, &varied, along, &[])
    }

    /// Whether the column along its curves has numbers.
    pub fn is_over_numbers(&self, study: &Study) -> bool {
        self.along.is_some_and(|column| study.is_numeric(column))
    }

    /// The curves, without those that have no point.
    pub fn series(&self, study: &Study, place: Place) -> Vec<Series> {
        let point = |rows: &Vec<usize>| {
            let rows: Vec<&Row> = rows.iter().map(|row| &study.rows[*row]).collect();
            place(&rows)
        };
        let curves = self.curves.iter().map(|(label, points)| Series {
            label: label.clone(),
            points: points.iter().filter_map(point).collect(),
            style: SeriesStyle::Joined,
        });
        curves.filter(|series| !series.points.is_empty()).collect()
    }

    /// The numbers of its rows.
    pub fn rows(&self) -> impl Iterator<Item = usize> {
        self.curves.iter().flat_map(|(_, points)| points).flatten().copied()
    }
}

/// The figures of some rows whose curves are told apart by the columns `names`.
fn divided(
    study: &Study,
    rows: Vec<usize>,
    names: &[usize],
    along: Option<usize>,
    title: &[String],
) -> Vec<Group> {
    let mut curves: Vec<(String, Vec<Vec<usize>>)> = Vec::new();
    for index in rows.iter().copied() {
        let row = &study.rows[index];
        let part = |column: &usize| {
            let label = &row.labels[*column];
            let name = &study.names[*column];
            if label.parse::<f64>().is_ok() { format!("{name} {label}") } else { label.clone() }
        };
        let parts: Vec<String> = names.iter().map(part).filter(|part| !part.is_empty()).collect();
        let name = parts.join(", ");
        let at = curves.iter().position(|(other, _)| *other == name).unwrap_or(curves.len());
        if at == curves.len() {
            curves.push((name, Vec::new()));
        }
        let label = |index: usize| along.map(|column| &study.rows[index].labels[column]);
        match curves[at].1.iter_mut().find(|point| label(point[0]) == label(index)) {
            Some(point) => point.push(index),
            None => curves[at].1.push(vec![index]),
        }
    }
    let [first, rest @ ..] = names else {
        return vec![Group { title: title.to_vec(), along, curves }];
    };
    if curves.len() <= CURVES || rest.is_empty() {
        return vec![Group { title: title.to_vec(), along, curves }];
    }
    let of_label = |label: &&str| {
        let own = rows.iter().copied().filter(|row| study.rows[*row].labels[*first] == **label);
        let title = [title, &[label.to_string()]].concat();
        divided(study, own.collect(), rest, along, &title)
    };
    labels(study, &rows, *first).iter().flat_map(of_label).collect()
}
