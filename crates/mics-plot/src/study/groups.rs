//! Which runs of a study are a curve of its figures, and which a point of it.

use super::{Layout, Plan, Row};
use crate::figure::{Series, SeriesStyle};

/// Curves in a figure at most, where the study file does not say which.
const CURVES: usize = 12;

/// Where runs that belong together lie in a figure, if they do.
pub type Point<'a> = &'a dyn Fn(&[&Row]) -> Option<(f64, f64)>;

/// Which rows are a curve, and what it is called.
pub struct Groups {
    /// Rows of each point of each curve, under its label.
    pub curves: Vec<(String, Vec<Vec<usize>>)>,
    /// Names of the columns that change from point to point of a curve.
    pub along: Vec<String>,
}

impl Groups {
    /// The curves of some rows.
    pub fn new(plan: &Plan, rows: &[Row], layout: &Layout) -> Groups {
        let Layout { series: wanted, over, .. } = *layout;
        let column = |name: &str, row: &Row| plan.label(name, row);
        let count = |names: &[String]| {
            let mut keys: Vec<Vec<String>> = rows
                .iter()
                .map(|row| names.iter().map(|name| column(name, row)).collect())
                .collect();
            keys.sort();
            keys.dedup();
            keys.len()
        };
        let mut all: Vec<String> = plan.names.iter().cloned().chain(["ranks".to_owned()]).collect();
        all.retain(|name| count(std::slice::from_ref(name)) > 1 && !over.contains(name));
        let names: Vec<String> = match wanted {
            Some(wanted) => wanted.to_vec(),
            None => {
                let mut rest = all.get(1..).unwrap_or_default();
                while count(rest) > CURVES {
                    rest = &rest[1..];
                }
                rest.to_vec()
            }
        };
        let mut curves: Vec<(String, Vec<Vec<usize>>)> = Vec::new();
        let along: Vec<String> = all.iter().filter(|name| !names.contains(name)).cloned().collect();
        let same = |a: usize, b: usize| {
            along.iter().all(|name| column(name, &rows[a]) == column(name, &rows[b]))
        };
        for (index, row) in rows.iter().enumerate() {
            let part = |name: &String| {
                let label = column(name, row);
                if label.parse::<f64>().is_ok() { format!("{name} {label}") } else { label }
            };
            let parts: Vec<String> =
                names.iter().map(part).filter(|part| !part.is_empty()).collect();
            let label = parts.join(", ");
            match curves.iter_mut().find(|(other, _)| *other == label) {
                Some((_, points)) => {
                    match points.iter_mut().find(|point| !over.is_empty() && same(point[0], index))
                    {
                        Some(point) => point.push(index),
                        None => points.push(vec![index]),
                    }
                }
                None => curves.push((label, vec![vec![index]])),
            }
        }
        Groups { curves, along }
    }

    /// The first thing that changes along a curve and is a number in every row that says it.
    pub fn numeric(&self, plan: &Plan, rows: &[Row]) -> Option<&str> {
        let varies = |name: &&String| {
            let mut values: Vec<f64> =
                rows.iter().filter_map(|row| self.number(plan, row, name)).collect();
            let text = |row: &Row| {
                plan.names
                    .iter()
                    .position(|other| other == *name)
                    .is_some_and(|at| row.labels[at].is_empty())
            };
            let all = values.len() + rows.iter().filter(|row| text(row)).count() == rows.len();
            values.sort_by(f64::total_cmp);
            values.dedup();
            all && values.len() > 1
        };
        self.along.iter().find(varies).map(String::as_str)
    }

    /// The number in a column of a row, where its label is one.
    pub fn number(&self, plan: &Plan, row: &Row, name: &str) -> Option<f64> {
        let at = plan.names.iter().position(|other| other == name)?;
        row.labels[at].parse().ok()
    }

    /// The curves, without those that have no point.
    pub fn series(&self, rows: &[Row], point: Point) -> Vec<Series> {
        let of = |(label, points): &(String, Vec<Vec<usize>>)| Series {
            label: label.clone(),
            points: points
                .iter()
                .filter_map(|same| {
                    point(&same.iter().map(|index| &rows[*index]).collect::<Vec<_>>())
                })
                .collect(),
            // Points of a curve follow each other where only one thing changes along it.
            style: if self.along.len() == 1 { SeriesStyle::Joined } else { SeriesStyle::Markers },
        };
        self.curves.iter().map(of).filter(|series| !series.points.is_empty()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::mean;

    #[test]
    fn runs_differing_in_position_share_a_curve_point() {
        let names = ["N", "scheme", "place"].map(str::to_owned).to_vec();
        let plan = Plan { names: &names, measures: &[], references: &[], others: &[], costs: &[] };
        let row = |n: f64, scheme: &str, place: &str, cpu: f64| Row {
            labels: vec![n.to_string(), scheme.to_owned(), place.to_owned()],
            ranks: 1,
            measured: Vec::new(),
            cpu: Some(cpu),
            cells: Some(n),
            per_cell_step: None,
            costs: Vec::new(),
        };
        let mut rows = Vec::new();
        for (k, scheme) in ["rk2", "rk3"].into_iter().enumerate() {
            for n in [8.0, 16.0] {
                let cpu = n * (1.0 + k as f64);
                rows.extend([row(n, scheme, "a", cpu), row(n, scheme, "b", 3.0 * cpu)]);
            }
        }
        let point = |same: &[&Row]| {
            Some((mean(&same.iter().filter_map(|r| r.cpu).collect::<Vec<_>>()), same.len() as f64))
        };
        let series = |over: &[String]| {
            let layout = Layout { series: Some(&["scheme".to_owned()]), each: &[], over };
            let groups = Groups::new(&plan, &rows, &layout);
            let points = groups.series(&rows, &point);
            (
                points.into_iter().map(|s| (s.label, s.points, s.style)).collect::<Vec<_>>(),
                groups.along,
            )
        };
        let joined = |label: &str, points: [(f64, f64); 2]| {
            (label.to_owned(), points.to_vec(), SeriesStyle::Joined)
        };
        let (found, along) = series(&["place".to_owned()]);
        assert_eq!(
            found,
            [joined("rk2", [(16.0, 2.0), (32.0, 2.0)]), joined("rk3", [(32.0, 2.0), (64.0, 2.0)])]
        );
        assert_eq!(along, ["N"]);
        // Where nobody says that they belong together, each is a point.
        let (found, along) = series(&[]);
        assert_eq!((found[0].1.len(), found[0].2, along.len()), (4, SeriesStyle::Markers, 2));
    }
}
