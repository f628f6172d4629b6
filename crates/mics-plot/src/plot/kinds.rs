//! Bodies of one kind, by name, material, shape and size: which bodies stand for all in a figure,
//! and what is said of many.

use super::discs::{few, materials, near};
use super::series::Group;
use super::table::{Table, quantile};
use crate::figure::COLOURS;
use mics_run::config::{Case, Particle};
use std::collections::HashMap;
use std::iter;

/// Lines of bodies in a figure at most: as many as there are colours.
pub const LINES: usize = COLOURS.len();
/// Parts of the bodies of a kind that lie below the lower edge, the middle and the upper edge of
/// its spread.
const PARTS: [f64; 3] = [0.1, 0.5, 0.9];

/// Points of a spread over time at most.
const POINTS: usize = 500;

/// The meaning of the lines and bands of kinds, in words.
pub const SPREAD: &str =
    "lines are medians over the bodies of a kind, bands hold the middle 80 % of them";

/// Bodies of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Kind {
    /// Its name in a legend.
    pub label: String,
    /// The bodies.
    pub ids: Vec<usize>,
}

/// The kinds of some bodies: by name, material, shape and diameter, or by fewer of these where that
/// would be more than [`LINES`].
pub fn kinds(case: &Case, ids: &[usize]) -> Vec<Kind> {
    let materials = materials(case).len() > 1;
    let first = case.particle.first().map(|p| p.shape.name());
    let other = |p: &Particle| !p.shape.is_round() || Some(p.shape.name()) != first;
    let shapes = case.particle.iter().any(other);
    let sizes = few(case, |p| p.shape.diameter()).len() > 1;
    let named = |p: &Particle| p.name.clone();
    let made = |p: &Particle| materials.then(|| p.material().to_owned());
    let sized = |p: &Particle| sizes.then(|| format!("d = {} m", near(p.shape.diameter())));
    let shaped = |p: &Particle| shapes.then(|| p.shape.name().to_owned());
    type Words<'a> = &'a dyn Fn(&Particle) -> Vec<Option<String>>;
    let finest: [Words; 5] = [
        &|p| {
            let made = made(p).filter(|made| p.name.as_ref() != Some(made));
            vec![named(p), made, shaped(p), sized(p)]
        },
        &|p| vec![made(p), shaped(p), sized(p)],
        &|p| vec![made(p), shaped(p)],
        &|p| vec![made(p)],
        &|_| Vec::new(),
    ];
    // Obstacles have their names as long as there is room for these.
    let group = |(k, words): (usize, &Words)| {
        let mut all: Vec<Kind> = Vec::new();
        for id in ids {
            let words = |p| words(p).into_iter().flatten().collect::<Vec<_>>().join(", ");
            let named = case.obstacle.len() == 1 || k + 1 < finest.len();
            let obstacle = || if named { case.called(*id) } else { "obstacles".to_owned() };
            let label = case.particle.get(*id).map_or_else(obstacle, words);
            match all.iter().position(|kind| kind.label == label) {
                Some(at) => all[at].ids.push(*id),
                None if all.len() > LINES => break,
                None => all.push(Kind { label, ids: vec![*id] }),
            }
        }
        all
    };
    let mut kinds =
        finest.iter().enumerate().map(group).find(|kinds| kinds.len() <= LINES).unwrap_or_default();
    for kind in &mut kinds {
        let word = if kind.label.is_empty() { "particles" } else { &kind.label };
        // An obstacle is alone of its name.
        if kind.ids.iter().any(|id| *id < case.particle.len()) || kind.ids.len() > 1 {
            kind.label = format!("{word} ({})", kind.ids.len());
        }
    }
    kinds
}

/// At most [`LINES`] of some bodies that stand for all: every kind has its share, and the bodies of
/// a kind are evenly spread over their numbers.
pub fn representatives(case: &Case, ids: &[usize]) -> Vec<usize> {
    if ids.len() <= LINES {
        return ids.to_vec();
    }
    let kinds = kinds(case, ids);
    let mut shares = vec![0; kinds.len()];
    while shares.iter().sum::<usize>() < LINES {
        // The kind of which fewest are shown next; the first of equals.
        let free = (0..kinds.len()).filter(|k| shares[*k] < kinds[*k].ids.len());
        let Some(next) = free.min_by_key(|k| shares[*k]) else { break };
        shares[next] += 1;
    }
    let picked = |(kind, share): (&Kind, &usize)| {
        super::evenly(kind.ids.len(), *share).map(|k| kind.ids[k]).collect::<Vec<_>>()
    };
    kinds.iter().zip(&shares).flat_map(picked).collect()
}

/// Rows of many bodies over time: of each kind the edges and the middle of its spread.
pub struct Course {
    kinds: Vec<Kind>,
    /// The kind of a body.
    of: HashMap<usize, usize>,
    /// The time (s) of the rows that come now, and their values by kind and column.
    time: f64,
    now: Vec<Vec<Vec<f64>>>,
    /// Lower edge, middle and upper edge over time, of each kind.
    spreads: Vec<[Table; 3]>,
}

impl Course {
    /// The course of some bodies by kinds; the first of the columns is the time.
    pub fn new(case: &Case, ids: &[usize], columns: &[&str]) -> Course {
        let kinds = kinds(case, ids);
        let of = kinds
            .iter()
            .enumerate()
            .flat_map(|(k, kind)| kind.ids.iter().map(move |id| (*id, k)))
            .collect();
        let now = vec![vec![Vec::new(); columns.len() - 1]; kinds.len()];
        let empty = || std::array::from_fn(|_| Table::new(columns));
        let spreads = kinds.iter().map(|_| empty()).collect();
        Course { kinds, of, time: f64::NAN, now, spreads }
    }

    /// Takes a row of a body, its time (s) first; all bodies come before the next time.
    pub fn take(&mut self, id: usize, row: &[f64]) {
        let finite = row.iter().all(|value| value.is_finite());
        let Some(kind) = self.of.get(&id).copied().filter(|_| finite) else { return };
        if row[0] != self.time {
            self.close();
            self.time = row[0];
        }
        self.now[kind].iter_mut().zip(&row[1..]).for_each(|(values, value)| values.push(*value));
    }

    /// Sums up the rows of a time.
    fn close(&mut self) {
        for (now, tables) in self.now.iter_mut().zip(&mut self.spreads) {
            if now.first().is_none_or(Vec::is_empty) {
                continue;
            }
            now.iter_mut().for_each(|values| values.sort_by(f64::total_cmp));
            for (table, part) in tables.iter_mut().zip(PARTS) {
                let parts = now.iter().map(|values| quantile(values, part));
                table.push(&iter::once(self.time).chain(parts).collect::<Vec<_>>());
            }
            now.iter_mut().for_each(Vec::clear);
        }
    }

    /// A group a kind, of so many rows as a figure shows.
    pub fn groups(mut self) -> Vec<Group> {
        self.close();
        let group = |(kind, spread): (Kind, [Table; 3])| {
            let [low, middle, high] = spread.map(|table| table.map(thinned));
            Group { label: kind.label, table: middle, edges: Some([low, high]) }
        };
        self.kinds.into_iter().zip(self.spreads).map(group).collect()
    }
}

/// At most [`POINTS`] values, each the mean of some that follow each other.
fn thinned(values: &[f64]) -> Vec<f64> {
    let mean = |some: &[f64]| some.iter().sum::<f64>() / some.len() as f64;
    values.chunks(values.len().div_ceil(POINTS).max(1)).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::super::discs::told_apart;
    use super::*;

    /// 16 discs of stone and 8 larger ones of steel, in this order.
    fn two_kinds() -> Case {
        let disc = |k: usize, d: f64, name: &str, material: &str| {
            format!(
                "[[particle]]\nname = \"{name}\"\nmaterial = \"{material}\"\n\
                shape = {{ disc = {{ diameter = {d} }} }}\n\
                density = 3.0\nposition = [{}, {}]\n",
                0.5 + (k % 6) as f64,
                0.5 + (k / 6) as f64
            )
        };
        let bodies = (0..24).map(|k| {
            if k < 16 { disc(k, 0.2, "gravel", "stone") } else { disc(k, 0.3, "steel", "steel") }
        });
        mics_run::config::written(&format!(
            "name = \"t\"\ntime.end = 9.0\ndomain = {{ size = [8.0, 8.0], cells = [8, 8] }}\n\
            fluid = {{ density = 2.0, viscosity = 0.1 }}\n\
            boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" \
            }}\n{}",
            bodies.collect::<String>()
        ))
        .unwrap()
    }

    #[test]
    fn representatives_per_material_and_size() {
        let case = two_kinds();
        let all: Vec<usize> = (0..24).collect();
        let labels: Vec<_> = kinds(&case, &all).into_iter().map(|kind| kind.label).collect();
        assert_eq!(labels, ["gravel, stone, d = 0.2 m (16)", "steel, d = 0.3 m (8)"]);
        let shown = representatives(&case, &all);
        assert_eq!((shown.len(), shown.iter().filter(|id| **id >= 16).count()), (LINES, 3));
        assert!(shown.contains(&0) && shown.contains(&15) && shown.contains(&23), "{shown:?}");
        assert_eq!(representatives(&case, &[3, 17]), [3, 17]);
    }

    /// Legends say what a body is, and no more digits than they have room for.
    #[test]
    fn kind_of_bodies_has_shape_and_three_digits() {
        let ellipse = |x: f64, d: f64| {
            format!(
                "[[particle]]\nshape = {{ ellipse = {{ axes = [2.0, 1.0], diameter = {d} }} }}\n\
                density = 3.0\nposition = [{x}, 4.0]\n"
            )
        };
        let case = mics_run::config::written(&format!(
            "name = \"t\"\ntime.end = 9.0\ndomain = {{ size = [8.0, 8.0], cells = [160, 160] }}\n\
            fluid = {{ density = 2.0, viscosity = 0.1 }}\n\
            boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" \
            }}\n{}{}",
            ellipse(2.0, 0.158_114),
            ellipse(6.0, 0.387_298)
        ))
        .unwrap();
        let labels: Vec<_> = kinds(&case, &[0, 1]).into_iter().map(|kind| kind.label).collect();
        assert_eq!(labels, ["ellipse, d = 0.158 m (1)", "ellipse, d = 0.387 m (1)"]);
        assert_eq!(told_apart(&[0.158_114, 0.25]), ["0.158", "0.25"]);
        assert_eq!(told_apart(&[0.158_114, 0.158_211]), ["0.158114", "0.158211"]);
    }

    #[test]
    fn spread_of_kind_is_10_to_90_percent() {
        let case = two_kinds();
        let mut course = Course::new(&case, &(0..24).collect::<Vec<_>>(), &["time", "vx"]);
        for time in [0.0, 1.0] {
            (0..24).for_each(|id| course.take(id, &[time, id as f64 * time]));
        }
        let groups = course.groups();
        let [low, high] = groups[0].edges.as_ref().unwrap();
        assert_eq!(groups[0].table.column("time"), [0.0, 1.0]);
        for (table, last) in [low, &groups[0].table, high].into_iter().zip([1.5, 7.5, 13.5]) {
            let v = table.column("vx");
            assert!(v[0] == 0.0 && (v[1] - last).abs() < 1e-12, "{v:?}");
        }
    }
}
