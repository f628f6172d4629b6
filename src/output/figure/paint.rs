//! What figures of the flow are painted with: colours of values, streamlines, particles, the colour bar.

use std::f64::consts::{SQRT_2, TAU};
use std::io;
use std::ops::Range;
use std::path::Path;

use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{self, Axis, Frame, INK, Pixel, SCALE, SMALL, Sheet, THIN};
use super::trace::{self, HOPS, Point, sample};
use super::{Disc, Plane};
use crate::{Error, Result};

/// Distance between arrow heads along a streamline.
const ARROWS: i32 = 220 * SCALE;
/// Blue, white, red (ColorBrewer's RdBu without its darkest ends), for values with a sign.
const DIVERGING: [u32; 9] = [0x2166ac, 0x4393c3, 0x92c5de, 0xd1e5f0, 0xffffff, 0xfddbc7, 0xf4a582, 0xd6604d, 0xb2182b];
/// Blue to orange (plasma without its palest end), for lines on white.
const SEQUENTIAL: [u32; 6] = [0x0d0887, 0x5402a3, 0x8b0aa5, 0xb93289, 0xdb5c68, 0xf48849];

/// Colours of a range of values.
pub struct Palette {
    colours: Vec<RGBColor>,
    /// The values of the first and the last colour; beyond them colours saturate.
    pub range: Range<f64>,
}

impl Palette {
    /// Of values with a sign, white at 0.
    pub fn diverging(limit: f64) -> Palette {
        Palette { colours: ramp(&DIVERGING), range: -limit..limit }
    }

    /// Of values from 0 on.
    pub fn sequential(top: f64) -> Palette {
        Palette { colours: ramp(&SEQUENTIAL), range: 0.0..top }
    }

    /// The colour of a value; grey where it is not a number.
    pub fn colour(&self, value: f64) -> RGBColor {
        let part = ((value - self.range.start) / (self.range.end - self.range.start)).clamp(0.0, 1.0);
        let colour = || self.colours[(part * (self.colours.len() - 1) as f64).round() as usize];
        if part.is_nan() { RGBColor(200, 200, 200) } else { colour() }
    }

    /// Draws the colours into the frame of a colour bar, whose vertical axis has this range.
    pub fn bar(&self, sheet: &mut Sheet, bar: &Frame) {
        let value = |part: f64| self.range.start + part * (self.range.end - self.range.start);
        sheet.bitmap(bar, |_, up| self.colour(value(up)));
    }
}

/// One of a plane's axes with about `count` ticks.
pub fn axis(plane: &Plane, axis: usize, count: i32) -> Axis {
    let corner = plane.corner[axis];
    Axis::linear(corner..corner + plane.size[axis], &plane.labels[axis], count.max(2)).from(corner)
}

/// Refuses a plane whose values do not fill its cells; the message names the figure.
pub fn check(plane: &Plane, stem: &Path) -> Result<()> {
    let count = plane.cells[0] * plane.cells[1];
    let filled = [&plane.u, &plane.v, &plane.vorticity].iter().all(|values| values.len() == count);
    let sized = plane.size.iter().all(|size| *size > 0.0 && size.is_finite());
    if count > 0 && filled && sized {
        return Ok(());
    }
    let message = format!("a plane of {:?} cells and size {:?} cannot be drawn", plane.cells, plane.size);
    Err(Error::io(stem)(io::Error::new(io::ErrorKind::InvalidInput, message)))
}

/// The vorticity that one cell in `in_one` of all planes exceeds: where colours or lines end, so that thin layers at discs
/// do not wash out or blacken the rest. 1 where there is nothing but the rounding errors of a flow without vorticity.
pub fn vorticity_limit(planes: &[Plane], in_one: usize) -> f64 {
    let all = planes.iter().flat_map(|plane| &plane.vorticity);
    let mut values: Vec<f64> = all.map(|value| value.abs()).filter(|value| value.is_finite()).collect();
    values.sort_unstable_by(f64::total_cmp);
    let noise = planes.iter().map(|plane| 1e-9 * trace::fastest(plane) / plane.size[0].max(plane.size[1]));
    let noise = noise.fold(1e-300, f64::max);
    let limits = [values.get(values.len() - values.len().div_ceil(in_one)), values.last()].into_iter().flatten();
    limits.copied().find(|limit| *limit > noise).unwrap_or(1.0)
}

/// The greatest speed of some planes outside their discs, 1 where nothing moves.
pub fn speed_limit(planes: &[Plane]) -> f64 {
    Some(planes.iter().map(trace::fastest).fold(0.0, f64::max)).filter(|speed| *speed > 1e-300).unwrap_or(1.0)
}

/// Fills a plot with the colours of the vorticity.
pub fn vorticity(sheet: &mut Sheet, plot: &Frame, plane: &Plane, palette: &Palette) {
    sheet.bitmap(plot, |x, y| palette.colour(sample(plane, &plane.vorticity, [x * plane.size[0], y * plane.size[1]])));
}

/// Draws streamlines about `apart` pixels of the figure from each other, in the colours of their points.
pub fn streamlines(sheet: &mut Sheet, plot: &Frame, plane: &Plane, apart: f64, colour: impl Fn(Point) -> RGBColor) {
    let extent = [plot.extent.0, plot.extent.1].map(|extent| f64::from(extent / SCALE));
    let apart = apart.min(extent[0] / 4.0).min(extent[1] / 4.0);
    let apart = [0, 1].map(|k| apart / extent[k] * plane.size[k]);
    let least = plane.size[0].max(plane.size[1]) / 4000.0;
    let separation = apart[0].min(apart[1]).max(least);
    let hop = separation / HOPS as f64 / plane.size[0] * f64::from(plot.extent.0);
    for line in trace::streamlines(plane, separation) {
        streamline(sheet, plot, &line, hop, &colour);
    }
}

/// Draws a streamline whose points are a `hop` on the sheet from each other.
fn streamline(sheet: &mut Sheet, plot: &Frame, line: &[Point], hop: f64, colour: impl Fn(Point) -> RGBColor) {
    let place = |point: &Point| plot.pixel(point[0], point[1]);
    let mut start = 0;
    for run in line[1..].chunk_by(|a, b| colour(*a) == colour(*b)) {
        let end = start + run.len();
        sheet.line(line[start..=end].iter().map(place).collect(), colour(run[0]), THIN);
        start = end;
    }
    let every = (f64::from(ARROWS) / hop).ceil() as usize;
    let first = (every / 2).min(line.len() / 2);
    for pair in line.windows(3).skip(first - 1).step_by(every) {
        let (x, y) = place(&pair[1]);
        let [ahead, behind] = [place(&pair[2]), place(&pair[0])];
        let along = [ahead.0 - behind.0, ahead.1 - behind.1].map(f64::from);
        let unit = f64::from(SCALE) / along[0].hypot(along[1]).max(1.0);
        let [dx, dy] = along.map(|step| step * unit);
        let corner = |ahead: f64, aside: f64| {
            let step = [ahead * dx - aside * dy, ahead * dy + aside * dx];
            (x + step[0].round() as i32, y + step[1].round() as i32)
        };
        let head = vec![corner(5.0, 0.0), corner(-4.0, 3.5), corner(-4.0, -3.5)];
        sheet.area(head, colour(pair[1]));
    }
}

/// Draws the particles of a plane.
pub fn discs(sheet: &mut Sheet, plot: &Frame, plane: &Plane) {
    let scale = f64::from(plot.extent.0) / plane.size[0];
    for disc in &plane.discs {
        let rim = outline(disc, plane.size, (disc.radius * scale).clamp(12.0, 128.0) as usize);
        let mut rim: Vec<Pixel> = rim.iter().map(|at| plot.pixel(at[0], at[1])).collect();
        if rim.len() > 2 {
            let grey = (215.0 - 90.0 * disc.shade.clamp(0.0, 1.0)).round() as u8;
            sheet.area(rim.clone(), RGBColor(grey, grey, grey));
            rim.push(rim[0]);
            sheet.line(rim, INK, 3 * THIN / 2);
            let label = disc.number.map(|number| number.to_string()).unwrap_or_default();
            let inside = (0..2).all(|a| (0.0..=plane.size[a]).contains(&disc.centre[a]));
            // A square in the circle holds it.
            let room = (disc.radius * scale * SQRT_2) as i32;
            if inside && canvas::width(&label, SMALL) < room && SMALL < room {
                let anchor = (HPos::Center, VPos::Center);
                sheet.text(&label, SMALL, plot.pixel(disc.centre[0], disc.centre[1]), anchor, FontTransform::None);
            }
        }
    }
}

/// 255 colours, so that there is a middle one, evenly along the given ones.
fn ramp(anchors: &[u32]) -> Vec<RGBColor> {
    let colour = |k: usize| {
        let place = k as f64 / 254.0 * (anchors.len() - 1) as f64;
        let low = (place as usize).min(anchors.len() - 2);
        let channel = |shift: u32| {
            let [a, b] = [anchors[low], anchors[low + 1]].map(|hex| f64::from(hex >> shift & 255));
            (a + (b - a) * (place - low as f64)).round() as u8
        };
        RGBColor(channel(16), channel(8), channel(0))
    };
    (0..255).map(colour).collect()
}

/// The part of a disc's rim and of the plane's edges that bounds what of the disc is in the plane.
fn outline(disc: &Disc, size: [f64; 2], corners: usize) -> Vec<Point> {
    let angle = |k: usize| k as f64 / corners as f64 * TAU;
    let rim = |[x, y]: Point, (sin, cos): (f64, f64)| [x + disc.radius * cos, y + disc.radius * sin];
    let circle = (0..corners).map(|k| rim(disc.centre, angle(k).sin_cos())).collect();
    let edges = [(0, 0.0, 1.0), (0, size[0], -1.0), (1, 0.0, 1.0), (1, size[1], -1.0)];
    edges.iter().fold(circle, |ring: Vec<Point>, &(axis, edge, inward)| {
        let depth = |point: Point| (point[axis] - edge) * inward;
        let sides = ring.iter().zip(ring.iter().cycle().skip(1)).flat_map(|(&a, &b)| {
            let (inside, crosses) = (depth(a) > 0.0, (depth(a) > 0.0) != (depth(b) > 0.0));
            let part = depth(a) / (depth(a) - depth(b));
            let crossing = [0, 1].map(|k| a[k] + part * (b[k] - a[k]));
            [inside.then_some(a), crosses.then_some(crossing)]
        });
        sides.flatten().collect()
    })
}
