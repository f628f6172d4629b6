//! Bodies and obstacles of a 3D scene as shaded surfaces, seen from a side in parallel light.
//!
//! Where the box cuts an obstacle, its section is drawn on the side of the box.
//!
//! ```text
//!      v  up     e  to the eye     a point x lies at (x.r, x.v) of the picture and hides what has
//!      |  /                         a smaller depth x.e; its colour is that of its body times
//!      | /                            0.45 + 0.55 max(0, n.l)
//!      o-----> r                    of the normal n and the light l, from over the left shoulder
//! ```

use super::canvas::{self, INK, LARGE, Pixel, SCALE, SMALL, Sheet};
use super::field::{draw_particle_bars, particle_bar, side_by_side};
use super::paint::Palette;
use super::{Scale, canvas::GAP};
use mics_run::Result;
use mics_run::words::rounded;
use nalgebra::Vector3;
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};
use std::path::{Path, PathBuf};

/// Largest width and height of the picture.
const MOST: [f64; 2] = [1000.0, 900.0];
const MARGIN: i32 = 20 * SCALE;
/// Part of its colour that a surface has without light.
const AMBIENT: f64 = 0.45;
/// Obstacles.
const WALL: RGBColor = RGBColor(0xc4, 0xb8, 0xa5);
/// Edges of the box, in parts of the picture's width.
const STEPS: usize = 4000;

/// A surface in the scene.
#[derive(Clone, Debug)]
pub enum Surface {
    /// A ball: its centre and radius (m).
    Ball(Vector3<f64>, f64),
    /// Triangles, corners counterclockwise seen from outside (m); of an obstacle a closed surface.
    Triangles(Vec<Triangle>),
}

/// The corners of a triangle (m).
pub type Triangle = [Vector3<f64>; 3];

/// A body or an obstacle with its surfaces.
#[derive(Clone, Debug)]
pub struct Solid {
    /// Its surfaces.
    pub surfaces: Vec<Surface>,
    /// Its grey or colour, from 0 (light) to 1 (dark); `None` of an obstacle.
    pub shade: Option<f64>,
}

/// A scene in a box from the origin.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Lengths of the box (m).
    pub size: [f64; 3],
    /// The axis that is upright.
    pub up: usize,
    /// The direction from the scene to the eye, of any length.
    pub eye: [f64; 3],
    /// Bodies and obstacles.
    pub solids: Vec<Solid>,
    /// Meaning of the bodies' colours.
    pub scale: Option<Scale>,
    /// Title above the figure.
    pub title: String,
}

/// The axes of a view: to the right, upwards and to the eye.
struct View {
    right: Vector3<f64>,
    up: Vector3<f64>,
    eye: Vector3<f64>,
}

impl View {
    fn of(scene: &Scene) -> View {
        let eye = Vector3::from(scene.eye).normalize();
        // Seen from straight above, the last axis in the plane points upwards.
        let upright = Vector3::ith(scene.up, 1.0);
        let aside = Vector3::ith(if scene.up == 1 { 2 } else { 1 }, 1.0);
        let upright = if eye.cross(&upright).norm() > 1e-6 { upright } else { aside };
        let right = upright.cross(&eye).normalize();
        View { right, up: eye.cross(&right), eye }
    }

    /// A point by the axes of the view.
    fn turned(&self, x: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(x.dot(&self.right), x.dot(&self.up), x.dot(&self.eye))
    }
}

/// The pixels of a picture: for each the number of what is seen there, its depth and colour.
struct Picture {
    size: [usize; 2],
    seen: Vec<u32>,
    depth: Vec<f64>,
    colours: Vec<RGBColor>,
    /// Pixels a metre, and the lower left corner by the axes of the view (m).
    scale: f64,
    corner: [f64; 2],
}

impl Picture {
    /// A place by the axes of the view (m) in pixels.
    fn pixel(&self, x: &Vector3<f64>) -> [f64; 2] {
        [0, 1].map(|a| (x[a] - self.corner[a]) * self.scale)
    }

    /// Takes what has this depth at a pixel, unless something hides it.
    fn put(&mut self, [i, j]: [usize; 2], depth: f64, number: u32, colour: RGBColor) {
        let at = j * self.size[0] + i;
        if depth > self.depth[at] {
            self.depth[at] = depth;
            self.seen[at] = number;
            self.colours[at] = colour;
        }
    }

    /// Calls with the pixels of the picture between two places, in pixels.
    fn each(&self, low: [f64; 2], high: [f64; 2], mut take: impl FnMut([usize; 2], [f64; 2])) {
        let ends = |a: usize| {
            let end = |x: f64| x.clamp(0.0, self.size[a] as f64) as usize;
            end(low[a].floor())..end(high[a].ceil() + 1.0)
        };
        for j in ends(1) {
            for i in ends(0) {
                take([i, j], [i as f64 + 0.5, j as f64 + 0.5]);
            }
        }
    }

    fn ball(&mut self, centre: &Vector3<f64>, radius: f64, number: u32, paint: &Paint) {
        let [x, y] = self.pixel(centre);
        let r = radius * self.scale;
        let mut found = Vec::new();
        self.each([x - r, y - r], [x + r, y + r], |at, place| {
            let n = [(place[0] - x) / r, (place[1] - y) / r];
            let square = 1.0 - n[0] * n[0] - n[1] * n[1];
            if square > 0.0 {
                found.push((at, Vector3::new(n[0], n[1], square.sqrt())));
            }
        });
        for (at, n) in found {
            self.put(at, centre.z + radius * n.z, number, paint.colour(&n));
        }
    }

    /// Calls with the pixels of a triangle by the axes of the view, and its depth there.
    fn triangle(&self, corners: &Triangle, mut take: impl FnMut([usize; 2], f64)) {
        let [a, b, c] = corners.map(|x| self.pixel(&x));
        let cross = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
            (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        };
        let area = cross(a, b, c);
        if area == 0.0 {
            return;
        }
        let low = [0, 1].map(|k| a[k].min(b[k]).min(c[k]));
        let high = [0, 1].map(|k| a[k].max(b[k]).max(c[k]));
        self.each(low, high, |at, place| {
            let parts = [cross(b, c, place), cross(c, a, place), cross(a, b, place)];
            let parts = parts.map(|part| part / area);
            if parts.iter().all(|part| *part >= 0.0) {
                take(at, (0..3).map(|k| parts[k] * corners[k].z).sum());
            }
        });
    }

    /// Triangles of a body, which are drawn whole.
    fn surface(&mut self, triangles: &[Triangle], number: u32, paint: &Paint) {
        let mut found = Vec::new();
        for corners in triangles {
            let Some(n) = normal(corners) else { continue };
            let colour = paint.colour(&n);
            self.triangle(corners, |at, depth| found.push((at, depth)));
            found.drain(..).for_each(|(at, depth)| self.put(at, depth, number, colour));
        }
    }

    /// The closed surface of an obstacle, of which what lies in the box is drawn, and its section
    /// where the line of sight enters the box within it.
    fn obstacle(&mut self, triangles: &[Triangle], number: u32, paint: &Paint, room: &Room) {
        // The depth of the last crossing before the box, and whether it leads into the obstacle.
        let mut before = vec![(f64::INFINITY, false); self.seen.len()];
        let mut found = Vec::new();
        for corners in triangles {
            let Some(n) = normal(corners) else { continue };
            let colour = paint.colour(&n);
            self.triangle(corners, |at, depth| found.push((at, depth)));
            for (at, depth) in found.drain(..) {
                let Some(sight) = room.sight(self, at) else { continue };
                let last = &mut before[at[1] * self.size[0] + at[0]];
                if depth > sight.enters && depth < last.0 {
                    *last = (depth, n.z > 0.0);
                } else if (sight.leaves..=sight.enters).contains(&depth) && n.z > 0.0 {
                    self.put(at, depth, number, colour);
                }
            }
        }
        let columns = self.size[0];
        for (k, _) in before.iter().enumerate().filter(|(_, last)| last.1) {
            let at = [k % columns, k / columns];
            if let Some(sight) = room.sight(self, at) {
                self.put(at, sight.enters, number, paint.colour(&sight.side));
            }
        }
    }

    /// Edges of what is seen, where another thing is seen beside it.
    fn outlines(&mut self) {
        let [columns, rows] = self.size;
        let differs = |at: usize, other: usize| self.seen[at] != self.seen[other];
        let edge: Vec<usize> = (0..columns * rows)
            .filter(|at| {
                let i = at % columns;
                i + 2 < columns && differs(*at, at + 2)
                    || at / columns + 2 < rows && differs(*at, at + 2 * columns)
            })
            .collect();
        edge.into_iter().for_each(|at| self.colours[at] = INK);
    }
}

/// Colour of a surface in the light.
struct Paint {
    base: RGBColor,
    light: Vector3<f64>,
}

impl Paint {
    fn colour(&self, n: &Vector3<f64>) -> RGBColor {
        let part = AMBIENT + (1.0 - AMBIENT) * n.dot(&self.light).max(0.0);
        let RGBColor(red, green, blue) = self.base;
        let [red, green, blue] =
            [red, green, blue].map(|channel| (part * f64::from(channel)).round() as u8);
        RGBColor(red, green, blue)
    }
}

/// The normal of a triangle, of length 1; none of one without area.
fn normal(corners: &Triangle) -> Option<Vector3<f64>> {
    (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).try_normalize(0.0)
}

/// The box, as lines of sight pass it.
struct Room<'a> {
    view: &'a View,
    size: [f64; 3],
}

/// Part of a line of sight in the box: its depths, and the normal of the side where it enters.
struct Sight {
    enters: f64,
    leaves: f64,
    side: Vector3<f64>,
}

impl Room<'_> {
    /// The line of sight through a pixel; none where it misses the box.
    fn sight(&self, picture: &Picture, at: [usize; 2]) -> Option<Sight> {
        let View { right, up, eye } = self.view;
        let place = |a: usize| (at[a] as f64 + 0.5) / picture.scale + picture.corner[a];
        let from = place(0) * right + place(1) * up;
        let mut sight =
            Sight { enters: f64::INFINITY, leaves: f64::NEG_INFINITY, side: Vector3::zeros() };
        // Rounding may take nothing of what lies on a side of the box.
        let room = 1e-9 * self.size.iter().sum::<f64>();
        for a in 0..3 {
            if eye[a].abs() < 1e-12 {
                if !(-room..=self.size[a] + room).contains(&from[a]) {
                    return None;
                }
                continue;
            }
            let ends = [-room, self.size[a] + room].map(|end| (end - from[a]) / eye[a]);
            let high = ends[0].max(ends[1]);
            if high < sight.enters {
                sight.enters = high;
                sight.side = self.view.turned(&(Vector3::ith(a, 1.0) * eye[a].signum()));
            }
            sight.leaves = sight.leaves.max(ends[0].min(ends[1]));
        }
        (sight.leaves < sight.enters).then_some(sight)
    }
}

/// The corners of the box from the origin.
fn corners(size: [f64; 3]) -> [Vector3<f64>; 8] {
    [0, 1, 2, 3, 4, 5, 6, 7]
        .map(|k| Vector3::from_fn(|a, _| if k >> a & 1 == 1 { size[a] } else { 0.0 }))
}

/// The picture of a scene, as large as there is room for.
fn render(scene: &Scene, view: &View) -> Picture {
    let ends = corners(scene.size).map(|x| view.turned(&x));
    let low = ends.iter().fold(Vector3::repeat(f64::INFINITY), |low, x| low.inf(x));
    let high = ends.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |high, x| high.sup(x));
    let fits = |a: usize| MOST[a] * f64::from(SCALE) / (high[a] - low[a]);
    // Room for outlines and for bodies that reach beyond a side.
    let scale = 0.98 * fits(0).min(fits(1));
    let size = [0, 1].map(|a| ((high[a] - low[a]) * scale / 0.98).ceil() as usize + 1);
    let corner = [0, 1].map(|a| low[a] - 0.01 * (high[a] - low[a]));
    let count = size[0] * size[1];
    let mut picture = Picture {
        size,
        seen: vec![0; count],
        depth: vec![f64::NEG_INFINITY; count],
        colours: vec![WHITE; count],
        scale,
        corner,
    };
    let light = Vector3::new(-0.5, 0.6, 1.0).normalize();
    let room = Room { view, size: scene.size };
    let palette = Palette::particles(scene.scale.as_ref());
    for (number, solid) in (1..).zip(&scene.solids) {
        let paint = Paint { base: solid.shade.map_or(WALL, |shade| palette.at(shade)), light };
        for surface in &solid.surfaces {
            match surface {
                Surface::Ball(centre, radius) => {
                    picture.ball(&view.turned(centre), *radius, number, &paint);
                }
                Surface::Triangles(all) => {
                    let turned = |corners: &Triangle| corners.map(|x| view.turned(&x));
                    let all: Vec<Triangle> = all.iter().map(turned).collect();
                    match solid.shade {
                        Some(_) => picture.surface(&all, number, &paint),
                        None => picture.obstacle(&all, number, &paint, &room),
                    }
                }
            }
        }
    }
    picture.outlines();
    picture
}

/// Draws the edges of the box where nothing hides them.
fn draw_box(picture: &mut Picture, scene: &Scene, view: &View) {
    let all = corners(scene.size);
    let grey = RGBColor(120, 120, 120);
    let edges = (0..8).flat_map(|k| (0..3).map(move |a| (k, a))).filter(|(k, a)| k >> a & 1 == 0);
    for (k, a) in edges {
        let from = all[k];
        let to = all[k | 1 << a];
        for step in 0..=STEPS {
            let x = view.turned(&(from + (step as f64 / STEPS as f64) * (to - from)));
            let [i, j] = picture.pixel(&x).map(|x| x.max(0.0) as usize);
            for near in [[i, j], [i + 1, j], [i, j + 1]] {
                if near[0] < picture.size[0] && near[1] < picture.size[1] {
                    picture.put(near, x.z, u32::MAX, grey);
                }
            }
        }
    }
}

/// Draws a scene. Writes `STEM.png` and `STEM.svg`.
///
/// # Errors
/// When a file cannot be written.
pub fn shaded(scene: &Scene, stem: &Path) -> Result<[PathBuf; 2]> {
    let (sheet, size) = draw(scene);
    sheet.write(size, stem)
}

fn draw(scene: &Scene) -> (Sheet, Pixel) {
    let view = View::of(scene);
    let mut picture = render(scene, &view);
    draw_box(&mut picture, scene, &view);
    let [columns, rows] = picture.size;
    let extent = (columns as i32, rows as i32);
    let top = MARGIN + LARGE + MARGIN / 2;
    let corner = (MARGIN + canvas::width(&length(scene, scene.up), SMALL) + GAP, top);
    let mut sheet = Sheet::default();
    sheet.bitmap(corner, extent, |x, y| {
        let i = (x * columns as f64) as usize;
        let j = (y * rows as f64) as usize;
        picture.colours[j.min(rows - 1) * columns + i.min(columns - 1)]
    });
    label_axes(&mut sheet, &picture, scene, &view, corner);
    let tall = extent.1.min(400 * SCALE);
    let values: Vec<_> = particle_bar(scene.scale.as_ref(), tall).into_iter().collect();
    let wide = values.iter().map(|axis| 2 * MARGIN + axis.room()).sum::<i32>();
    let begin = (corner.0 + extent.0 + MARGIN, top);
    let bars = side_by_side(values, begin, tall);
    draw_particle_bars(&mut sheet, &bars, scene.scale.as_ref());
    sheet.title(&scene.title, corner.0 + extent.0 / 2, top);
    let right = (begin.0 + wide).max(canvas::width(&scene.title, LARGE)) + 2 * MARGIN;
    (sheet, (right, top + extent.1 + SMALL + 2 * MARGIN))
}

/// Name and length of an edge of the box.
fn length(scene: &Scene, axis: usize) -> String {
    format!("{}, {} m", ["x", "y", "z"][axis], rounded(scene.size[axis]))
}

/// Writes names and lengths of the three edges of the box that are lowest in the picture.
fn label_axes(sheet: &mut Sheet, picture: &Picture, scene: &Scene, view: &View, corner: Pixel) {
    let all = corners(scene.size);
    let height = |x: &Vector3<f64>| view.turned(x).y;
    for axis in 0..3 {
        let edges = (0..8).filter(|k| k >> axis & 1 == 0).map(|k| (all[k], all[k | 1 << axis]));
        // An upright edge to the left, any other one at the bottom of the picture.
        let place = |(from, to): &(Vector3<f64>, Vector3<f64>)| {
            let middle = 0.5 * (from + to);
            if axis == scene.up { view.turned(&middle).x } else { height(&middle) }
        };
        let Some((from, to)) = edges.min_by(|a, b| place(a).total_cmp(&place(b))) else { continue };
        let [x, y] = picture.pixel(&view.turned(&(0.5 * (from + to))));
        let [x0, _] = picture.pixel(&view.turned(&from));
        let [x1, _] = picture.pixel(&view.turned(&to));
        // Seen end on, it has no length to write at.
        let seen = view.turned(&(to - from)).xy().norm() > 0.05 * scene.size[axis];
        let at = (corner.0 + x as i32, corner.1 + picture.size[1] as i32 - y as i32);
        let text = length(scene, axis);
        let (anchor, at) = if axis == scene.up {
            ((HPos::Right, VPos::Center), (at.0 - GAP, at.1))
        } else if (x1 - x0).abs() < 1.0 || (x < 0.5 * picture.size[0] as f64) {
            ((HPos::Right, VPos::Top), (at.0 - GAP, at.1 + GAP))
        } else {
            ((HPos::Left, VPos::Top), (at.0 + GAP, at.1 + GAP))
        };
        if seen {
            sheet.text(&text, SMALL, at, anchor, FontTransform::None);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(solids: Vec<Solid>) -> Scene {
        Scene { size: [1.0; 3], up: 2, eye: [0.0, -1.0, 0.0], solids, ..Scene::default() }
    }

    fn ball(place: [f64; 3], radius: f64) -> Solid {
        Solid { surfaces: vec![Surface::Ball(place.into(), radius)], shade: Some(0.5) }
    }

    /// Number of what is seen in the middle of the picture, and the part of it that has any.
    fn seen(scene: &Scene) -> (u32, f64) {
        let picture = render(scene, &View::of(scene));
        let [columns, rows] = picture.size;
        let some = picture.seen.iter().filter(|number| **number > 0).count();
        let part = some as f64 / (columns * rows) as f64;
        (picture.seen[rows / 2 * columns + columns / 2], part)
    }

    #[test]
    fn nearer_body_hides_the_one_behind() {
        let near = ball([0.5, 0.2, 0.5], 0.1);
        let far = ball([0.5, 0.8, 0.5], 0.3);
        let both = scene(vec![far, near]);
        let (number, part) = seen(&both);
        // The disc of the larger one, in a picture 2 % wider than the box.
        let exact = std::f64::consts::PI * 0.09 * 0.98 * 0.98;
        assert!(number == 2 && (part / exact - 1.0).abs() < 5e-3, "{number} {part} {exact}");
        let from_behind = Scene { eye: [0.0, 1.0, 0.0], ..both };
        assert_eq!(seen(&from_behind).0, 1);
    }

    /// A closed box from one corner to the other one (m).
    fn block(low: [f64; 3], high: [f64; 3]) -> Vec<Triangle> {
        let corner =
            |k: usize| Vector3::from_fn(|a, _| if k >> a & 1 == 1 { high[a] } else { low[a] });
        let faces =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let two = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]].map(|t| t.map(corner));
        faces.into_iter().flat_map(two).collect()
    }

    #[test]
    fn obstacle_is_drawn_within_the_box_with_its_section_on_the_sides() {
        // A bed that goes on beyond the box to all sides but above: seen from above its top, from
        // the side its section, and nothing over it.
        let bed = block([-1.0, -1.0, -1.0], [2.0, 2.0, 0.25]);
        let bed = || Solid { surfaces: vec![Surface::Triangles(bed.clone())], shade: None };
        for (eye, exact) in [([0.0, 0.0, 1.0], 1.0), ([0.0, -1.0, 0.0], 0.25)] {
            let (_, part) = seen(&Scene { eye, ..scene(vec![bed()]) });
            assert!((part / (0.98 * 0.98) - exact).abs() < 5e-3, "{part} {exact}");
        }
        // It hides what lies in it, also behind its section.
        let both = scene(vec![ball([0.5, 0.5, 0.1], 0.05), bed()]);
        let picture = render(&both, &View::of(&both));
        assert!(picture.seen.iter().all(|number| *number != 1));
    }

    #[test]
    fn view_has_up_upwards_from_every_side() {
        for eye in [[1.0, 0.0, 0.0], [-1.0, -2.0, 1.0], [0.0, 0.0, -1.0], [0.3, 5.0, -0.2]] {
            let view = View::of(&Scene { eye, up: 2, ..Scene::default() });
            let turned = [view.right, view.up, view.eye];
            for (k, axis) in turned.iter().enumerate() {
                assert!((axis.norm() - 1.0).abs() < 1e-12);
                assert!(axis.dot(&turned[(k + 1) % 3]).abs() < 1e-12);
            }
            assert!((view.right.cross(&view.up) - view.eye).norm() < 1e-12);
            assert!(view.up.z >= 0.0);
        }
    }
}
