//! The particles of a picture as its plane cuts them: where, in which colour, and how they are
//! turned.
//!
//! ```text
//!   a body is marked in the half behind a plane through its centre, which turns with it:
//!     light |  n . r < 0
//!     dark  |  n . r > 0
//!   n = R n0, n0 down in the picture at the start; r from the centre of the body
//! ```
//! In 2D the two meet in a diameter. In 3D they meet where both planes do, so that a turn about any
//! axis but n is seen.

use super::section;
use super::slice::Section;
use crate::figure::{Disc, Scale};
use mics_run::bodies::Pose;
use mics_run::config::{Case, Motion, Particle};
use mics_run::words::rounded;
use nalgebra::Vector3;
use std::collections::{HashMap, HashSet};

/// Values that have a legend in place of a colour bar, and in figures of curves a line each, at
/// most.
const FEW: usize = 5;

/// Quantity that the colours of particles show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Bodies {
    /// Their diameter.
    #[default]
    Size,
    /// Speed of their centres.
    Speed,
    /// Their density, or the name of their material where that differs.
    Material,
}

/// Quantity that the colours of particles show, with the values of the lightest and the darkest.
#[derive(Clone, Copy, Debug)]
pub struct Colours {
    /// The quantity.
    pub by: Bodies,
    /// From and to: m, m/s or kg/m3, or numbers of materials.
    pub range: [f64; 2],
}

impl Colours {
    /// Colours of the particles of a case, which are at most so fast (m/s).
    pub fn of(by: Bodies, case: &Case, fastest: f64) -> Colours {
        let range = match by {
            Bodies::Speed => [0.0, if fastest > 0.0 { fastest } else { 1.0 }],
            Bodies::Size => range(case, |p| p.shape.diameter()),
            Bodies::Material if materials(case).len() > 1 => {
                [-0.5, materials(case).len() as f64 - 0.5]
            }
            Bodies::Material => range(case, |p| p.density()),
        };
        Colours { by, range: if case.particle.is_empty() { [0.0; 2] } else { range } }
    }

    /// Scale of their colour bar: its label, and names of values.
    pub fn scale(&self, case: &Case) -> Scale {
        let names = materials(case);
        let numbers = |values: Vec<f64>| {
            let words = told_apart(&values);
            values.into_iter().zip(words).collect()
        };
        let (label, names) = match self.by {
            Bodies::Size => ("diameter (m)", numbers(few(case, |p| p.shape.diameter()))),
            Bodies::Speed => ("speed of particles (m/s)", Vec::new()),
            Bodies::Material if names.len() > 1 => (
                "material",
                names.iter().enumerate().map(|(k, name)| (k as f64, (*name).to_owned())).collect(),
            ),
            Bodies::Material => ("density (kg/m\u{b3})", numbers(few(case, |p| p.density()))),
        };
        Scale { label: label.to_owned(), range: self.range, names, grey: false }
    }

    /// Greys: by size, or else by what they are made of.
    fn greys(case: &Case) -> Colours {
        let by = if differs(range(case, |p| p.shape.diameter())) {
            Bodies::Size
        } else {
            Bodies::Material
        };
        Colours::of(by, case, 0.0)
    }

    /// Where a particle is between the lightest and the darkest.
    pub fn shade(&self, materials: &[&str], particle: &Particle, pose: &Pose) -> f64 {
        let value = match self.by {
            Bodies::Size => particle.shape.diameter(),
            Bodies::Speed => pose.speed,
            Bodies::Material if materials.len() > 1 => {
                materials.iter().position(|name| *name == particle.material()).unwrap_or(0) as f64
            }
            Bodies::Material => particle.density(),
        };
        part(value, self.range)
    }
}

/// A number to three digits, as legends have room for.
pub fn near(value: f64) -> String {
    rounded(format!("{value:.2e}").parse().unwrap_or(value))
}

/// Numbers to three digits, or to six where these do not tell all apart.
pub fn told_apart(values: &[f64]) -> Vec<String> {
    let short: Vec<String> = values.iter().map(|value| near(*value)).collect();
    let once = short.iter().collect::<HashSet<_>>().len() == short.len();
    if once { short } else { values.iter().map(|value| rounded(*value)).collect() }
}

/// The names of the materials of a case, in the order in which they come.
pub fn materials(case: &Case) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for particle in &case.particle {
        if !names.contains(&particle.material()) {
            names.push(particle.material());
        }
    }
    names
}

/// The meaning of the greys of particles, where there are few.
pub fn grey_scale(case: &Case) -> Option<Scale> {
    let scale = Scale { grey: true, ..Colours::greys(case).scale(case) };
    (scale.names.len() > 1).then_some(scale)
}

/// The values of a case's particles in rising order, where these are few; else none.
pub fn few(case: &Case, value: fn(&Particle) -> f64) -> Vec<f64> {
    let mut values: Vec<f64> = Vec::new();
    for value in case.particle.iter().map(value) {
        if values.iter().all(|other| (value - other).abs() > 1e-9 * other.abs()) {
            values.push(value);
        }
        if values.len() > FEW {
            return Vec::new();
        }
    }
    values.sort_by(f64::total_cmp);
    values
}

fn range(case: &Case, value: fn(&Particle) -> f64) -> [f64; 2] {
    let values = case.particle.iter().map(value);
    values.fold([f64::INFINITY, 0.0_f64], |[least, most], v| [least.min(v), most.max(v)])
}

fn differs([least, most]: [f64; 2]) -> bool {
    most > least * (1.0 + 1e-9)
}

/// Where a value is in a range; the middle of one that is none.
fn part(value: f64, [least, most]: [f64; 2]) -> f64 {
    if differs([least, most]) { (value - least) / (most - least) } else { 0.5 }
}

/// The sections of the particles in the plane across `axis` at `height` (m), with their images
/// across periodic sides that reach into it: in grey and with names or numbers, or in colours and
/// with the marks of their turning.
pub fn discs(
    case: &Case,
    axis: usize,
    height: f64,
    size: [f64; 2],
    place: &dyn Fn(usize) -> Option<Pose>,
    colours: Option<&Colours>,
) -> Vec<Disc> {
    let greys = Colours::greys(case);
    let axes = section::axes(axis);
    let materials = materials(case);
    let names = unique_names(case);
    let mut discs: Vec<Disc> = obstacles(case, axes, height, place).collect();
    for (id, p) in case.particle.iter().enumerate() {
        let Some(pose) = place(id).or_else(|| at_rest(p)) else { continue };
        let at = pose.centre;
        let off = off_plane(case, pose.centre, axis, height);
        let reach = 0.5 * p.shape.bounding_diameter();
        let square = reach * reach - off * off;
        if square <= 0.0 {
            continue;
        }
        let mut radius = square.sqrt();
        let mut outline = Vec::new();
        if let Some(solid) = p.shape.solid() {
            let section = Section { axes, height: -off, dimension: case.dimension() };
            outline = section.solid(solid, &pose.orientation.unwrap_or_else(|| p.turn()));
            let corners = outline.iter().flatten().map(|at| at[0].hypot(at[1]));
            radius = corners.fold(0.0, f64::max);
            if outline.is_empty() {
                continue;
            }
        }
        let shade = colours.unwrap_or(&greys).shade(&materials, p, &pose);
        let turned = pose.orientation.filter(|_| colours.is_some() && p.motion != Motion::Fixed);
        let mark = turned.map(|turned| {
            let n = turned * -Vector3::ith(axes[1], 1.0);
            [n[axes[0]], n[axes[1]], -off * n[axis]]
        });
        let label = if case.particle.len() > 1 && colours.is_none() {
            let name = names.get(&id).map(|name| (*name).to_owned());
            name.into_iter().chain([id.to_string()]).collect()
        } else {
            Vec::new()
        };
        let images = |axis: usize| if case.periodic(axis) { -1..=1 } else { 0..=0 };
        for (ka, kb) in images(axes[0]).flat_map(|ka| images(axes[1]).map(move |kb| (ka, kb))) {
            let centre =
                [at[axes[0]] + f64::from(ka) * size[0], at[axes[1]] + f64::from(kb) * size[1]];
            if (0..2).all(|a| centre[a] > -radius && centre[a] < size[a] + radius) {
                let outline = outline.clone();
                let label = label.clone();
                discs.push(Disc { centre, radius, outline, shade, mark, label, wall: false });
            }
        }
    }
    discs
}

/// The sections of the obstacles in the plane.
fn obstacles(
    case: &Case,
    axes: [usize; 2],
    height: f64,
    place: &dyn Fn(usize) -> Option<Pose>,
) -> impl Iterator<Item = Disc> {
    let section = Section { axes, height, dimension: case.dimension() };
    case.obstacle.iter().enumerate().map(move |(k, obstacle)| {
        let pose = place(case.particle.len() + k);
        let outline = section.obstacle(case, obstacle.wall(), pose);
        let radius = outline.iter().flatten().map(|at| at[0].hypot(at[1])).fold(0.0, f64::max);
        Disc { radius, outline, wall: true, ..Disc::default() }
    })
}

/// Distance (m) of a place from the plane across an axis at a height (m), by the shortest way
/// across a periodic axis; 0 in 2D.
fn off_plane(case: &Case, at: [f64; 3], axis: usize, height: f64) -> f64 {
    if case.dimension() == 2 {
        return 0.0;
    }
    let across = at[axis] - height;
    let length = case.domain.size[axis];
    if case.periodic(axis) { across - length * (across / length).round() } else { across }
}

/// The names that one particle has alone, by its number.
fn unique_names(case: &Case) -> HashMap<usize, &str> {
    let named =
        || case.particle.iter().enumerate().filter_map(|(id, p)| Some((id, p.name.as_deref()?)));
    let mut count: HashMap<&str, usize> = HashMap::new();
    named().for_each(|(_, name)| *count.entry(name).or_default() += 1);
    named().filter(|(_, name)| count.get(name) == Some(&1)).collect()
}

/// The pose of a fixed body of which no file says it; none of one that moves, which has left the
/// box or has not come in.
pub fn at_rest(particle: &Particle) -> Option<Pose> {
    let rests = particle.motion == Motion::Fixed && particle.enter.is_none();
    rests.then(|| Pose::at(start(particle)))
}

/// Where a particle is at the start (m).
pub fn start(particle: &Particle) -> [f64; 3] {
    std::array::from_fn(|a| particle.position.get(a).copied().unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;
    use std::f64::consts::FRAC_PI_2;

    fn case(more: &str) -> Case {
        mics_run::config::written(&format!(
            "name = \"t\"\ntime.end = 9.0\ndomain = {{ size = [1.0, 1.0, 1.0], cells = [8, 8, 8] \
            }}\n\
            fluid = {{ density = 2.0, viscosity = 0.1 }}\n\
            boundary = {{ west = \"slip\", east = \"slip\", south = \"slip\", north = \"slip\", \
            bottom = \"slip\", top = \"slip\" }}\n\
            {more}\n"
        ))
        .unwrap()
    }

    fn sphere(diameter: f64, more: &str) -> String {
        format!(
            "[[particle]]\nshape = {{ sphere = {{ diameter = {diameter} }} }}\n\
            position = [0.5, 0.5, 0.5]\ndensity = 3.0\n{more}\n"
        )
    }

    #[test]
    fn rotation_mark_turns_with_body_and_is_cut_by_plane() {
        let case = case(&sphere(0.2, ""));
        let colours = Colours::of(Bodies::Size, &case, 0.0);
        let mark = |across: usize, height: f64, axis: Vector3<f64>, angle: f64| {
            let orientation = Some(UnitQuaternion::from_scaled_axis(axis * angle));
            let place = |_| Some(Pose { orientation, ..Pose::at([0.5; 3]) });
            discs(&case, across, height, [1.0; 2], &place, Some(&colours))[0].mark.unwrap()
        };
        let near = |a: [f64; 3], b: [f64; 3]| {
            assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-12), "{a:?} {b:?}")
        };
        near(mark(2, 0.5, Vector3::z(), 0.0), [0.0, -1.0, 0.0]);
        near(mark(2, 0.5, Vector3::z(), FRAC_PI_2), [1.0, 0.0, 0.0]);
        // Across y, where z is up; and in front of the middle, once the dark half faces away from
        // there.
        near(mark(1, 0.5, Vector3::y(), 0.0), [0.0, -1.0, 0.0]);
        near(mark(2, 0.55, Vector3::x(), FRAC_PI_2), [0.0, 0.0, -0.05]);
        let unknown = discs(&case, 2, 0.5, [1.0; 2], &|_| Some(Pose::at([0.5; 3])), Some(&colours));
        assert!(unknown[0].mark.is_none());
    }

    #[test]
    fn moving_body_drawn_at_recorded_position_only() {
        let late = sphere(0.2, "enter = { time = 1.0 }");
        let case =
            case(&[late, sphere(0.1, "motion = \"fixed\"").replace("[0.5", "[0.1")].concat());
        let drawn =
            |place: &dyn Fn(usize) -> Option<Pose>| discs(&case, 2, 0.5, [1.0; 2], place, None);
        let before = drawn(&|_| None);
        assert_eq!(before.iter().map(|disc| disc.centre).collect::<Vec<_>>(), [[0.1, 0.5]]);
        assert_eq!(drawn(&|id| (id == 0).then(|| Pose::at([0.7, 0.5, 0.5]))).len(), 2);
    }

    #[test]
    fn body_colours_span_their_range() {
        let apart = |text: String| text.replace("position = [0.5", "position = [0.2");
        let case = case(
            &[
                apart(sphere(0.1, "name = \"left\"\nmaterial = \"steel\"")),
                sphere(0.2, "velocity = [1.0, 0.0, 0.0]\nmaterial = \"glass\""),
            ]
            .concat(),
        );
        let place = |id: usize| Some(Pose { speed: id as f64, ..Pose::at([0.5; 3]) });
        let shades = |by: Bodies| {
            let colours = Colours::of(by, &case, 2.0);
            discs(&case, 2, 0.5, [1.0; 2], &place, Some(&colours))
                .iter()
                .map(|disc| disc.shade)
                .collect::<Vec<_>>()
        };
        assert_eq!([shades(Bodies::Size), shades(Bodies::Speed)], [[0.0, 1.0], [0.0, 0.5]]);
        assert_eq!(shades(Bodies::Material), [0.25, 0.75]);
        let scale = Colours::of(Bodies::Material, &case, 0.0).scale(&case);
        assert_eq!(scale.names, [(0.0, "steel".to_owned()), (1.0, "glass".to_owned())]);
        let labels =
            discs(&case, 2, 0.5, [1.0; 2], &place, None).into_iter().map(|disc| disc.label);
        assert_eq!(labels.collect::<Vec<_>>(), [vec!["left", "0"], vec!["1"]]);
        let alike = super::tests::case(&sphere(0.1, ""));
        assert_eq!(Colours::of(Bodies::Material, &alike, 0.0).scale(&alike).range, [3.0, 3.0]);
    }
}
