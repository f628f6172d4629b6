//! Figures of a plane of the flow: the colour map of vorticity under streamlines, and streamlines coloured by speed.

use std::f64::consts::TAU;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use plotters::prelude::*;

use super::canvas::{self, Axis, BELOW, Frame, INK, LARGE, Pixel, SCALE, Sheet, THIN};
use super::trace::{self, HOPS, Point, sample};
use super::{Disc, Plane};
use crate::{Error, Result};

/// Largest width and height of a plot; the domain's aspect decides which one binds.
const MOST: [f64; 2] = [1000.0, 900.0];
/// Least width or height of a plot, for domains that are thinner than can be drawn to scale.
const LEAST: f64 = 60.0;
/// Distance between streamlines.
const SEPARATION: f64 = 22.0;
/// Distance between arrow heads along a streamline.
const ARROWS: i32 = 220 * SCALE;
const BAR: i32 = 22 * SCALE;
const MARGIN: i32 = 20 * SCALE;
/// Blue, white, red (ColorBrewer's RdBu without its darkest ends), for values with a sign.
const DIVERGING: [u32; 9] = [0x2166ac, 0x4393c3, 0x92c5de, 0xd1e5f0, 0xffffff, 0xfddbc7, 0xf4a582, 0xd6604d, 0xb2182b];
/// Blue to orange (plasma without its palest end), for lines on white.
const SEQUENTIAL: [u32; 6] = [0x0d0887, 0x5402a3, 0x8b0aa5, 0xb93289, 0xdb5c68, 0xf48849];

/// Draws vorticity as a colour map with streamlines and discs over it. Writes `STEM.png` and `STEM.svg`.
pub fn vorticity(plane: &Plane, stem: &Path) -> Result<[PathBuf; 2]> {
    let (sheet, size) = draw_vorticity(plane, stem)?;
    sheet.write(size, stem)
}

/// The same figure as SVG text.
pub fn vorticity_svg(plane: &Plane) -> Result<String> {
    let (sheet, size) = draw_vorticity(plane, Path::new("vorticity"))?;
    sheet.svg(size)
}

fn draw_vorticity(plane: &Plane, stem: &Path) -> Result<(Sheet, Pixel)> {
    check(plane, stem)?;
    let limit = vorticity_limit(plane);
    let field = Field::new(plane, &DIVERGING, -limit..limit, "vorticity (1/s)");
    let mut sheet = Sheet::default();
    sheet.bitmap(&field.plot, |x, y| {
        let at = [x * plane.size[0], y * plane.size[1]];
        field.colour(sample(plane, &plane.vorticity, at))
    });
    Ok(field.finish(sheet, |_| RGBColor(70, 70, 70)))
}

/// Draws streamlines coloured by speed, with discs, on white. Writes `STEM.png` and `STEM.svg`.
pub fn streamlines(plane: &Plane, stem: &Path) -> Result<[PathBuf; 2]> {
    let (sheet, size) = draw_streamlines(plane, stem)?;
    sheet.write(size, stem)
}

/// The same figure as SVG text.
pub fn streamlines_svg(plane: &Plane) -> Result<String> {
    let (sheet, size) = draw_streamlines(plane, Path::new("streamlines"))?;
    sheet.svg(size)
}

fn draw_streamlines(plane: &Plane, stem: &Path) -> Result<(Sheet, Pixel)> {
    check(plane, stem)?;
    let fastest = Some(trace::fastest(plane)).filter(|speed| *speed > 1e-300);
    let field = Field::new(plane, &SEQUENTIAL, 0.0..fastest.unwrap_or(1.0), "speed (m/s)");
    let speed = |at: Point| sample(plane, &plane.u, at).hypot(sample(plane, &plane.v, at));
    Ok(field.finish(Sheet::default(), |at| field.colour(speed(at))))
}

fn check(plane: &Plane, stem: &Path) -> Result<()> {
    let count = plane.cells[0] * plane.cells[1];
    let filled = [&plane.u, &plane.v, &plane.vorticity].iter().all(|values| values.len() == count);
    let sized = plane.size.iter().all(|size| *size > 0.0 && size.is_finite());
    if count > 0 && filled && sized {
        return Ok(());
    }
    let message = format!("a plane of {:?} cells and size {:?} cannot be drawn", plane.cells, plane.size);
    Err(Error::io(stem)(io::Error::new(io::ErrorKind::InvalidInput, message)))
}

/// The vorticity where colours saturate: what one cell in a hundred exceeds, so that thin layers at discs do not wash
/// out the rest. Rounding errors of a flow without vorticity stay white.
fn vorticity_limit(plane: &Plane) -> f64 {
    let finite = plane.vorticity.iter().map(|value| value.abs()).filter(|value| value.is_finite());
    let mut values: Vec<f64> = finite.collect();
    values.sort_unstable_by(f64::total_cmp);
    let noise = 1e-9 * trace::fastest(plane) / plane.size[0].max(plane.size[1]);
    let limits = [values.get(values.len() * 99 / 100), values.last()].into_iter().flatten();
    limits.copied().find(|limit| *limit > noise.max(1e-300)).unwrap_or(1.0)
}

/// A plane on its sheet with the colour bar beside it.
struct Field<'a> {
    plane: &'a Plane,
    plot: Frame,
    bar: Frame,
    colours: Vec<RGBColor>,
    /// Distance between streamlines in the plane.
    separation: f64,
    size: Pixel,
}

impl<'a> Field<'a> {
    fn new(plane: &'a Plane, colours: &[u32], range: Range<f64>, label: &str) -> Self {
        let scale = (MOST[0] / plane.size[0]).min(MOST[1] / plane.size[1]);
        let plot = plane.size.map(|size| (size * scale).max(LEAST));
        let apart = SEPARATION.min(plot[0] / 4.0).min(plot[1] / 4.0);
        let apart = [0, 1].map(|k| apart / plot[k] * plane.size[k]);
        let least = plane.size[0].max(plane.size[1]) / 4000.0;
        let [width, height] = plot.map(|size| size.round() as i32 * SCALE);
        let tall = height.max(160 * SCALE);

        let axis = |k: usize, count: i32| Axis::linear(0.0..plane.size[k], &plane.labels[k], count.max(2));
        let x = axis(0, width / (100 * SCALE));
        let y = axis(1, height / (100 * SCALE));
        let values = Axis::linear(range, label, (tall / (70 * SCALE)).max(4));
        let needed = y.room() + width + MARGIN + BAR + values.room();
        let all = needed.max(canvas::width(&plane.title, LARGE)) + 2 * MARGIN;
        let left = (all - needed) / 2 + y.room();
        let top = MARGIN + if plane.title.is_empty() { 0 } else { LARGE + MARGIN / 2 };
        let free = (300 * SCALE - top - BELOW - MARGIN).max(tall);
        let at = |x: i32, height: i32| (x, top + (free - height) / 2);
        let bar = at(left + width + MARGIN, tall);
        Field {
            plane,
            plot: Frame { corner: at(left, height), extent: (width, height), x, y },
            bar: Frame { corner: bar, extent: (BAR, tall), x: Axis::blank(), y: values },
            colours: ramp(colours),
            separation: apart[0].min(apart[1]).max(least),
            size: (all, top + free + BELOW + MARGIN),
        }
    }

    /// Draws streamlines in the colours of a point, then all that lies over them; returns the sheet and its size.
    fn finish(&self, mut sheet: Sheet, colour: impl Fn(Point) -> RGBColor) -> (Sheet, Pixel) {
        for line in trace::streamlines(self.plane, self.separation) {
            self.streamline(&mut sheet, &line, &colour);
        }
        for disc in &self.plane.discs {
            self.disc(&mut sheet, disc);
        }
        let range = &self.bar.y.range;
        let value = |part: f64| range.start + part * (range.end - range.start);
        sheet.bitmap(&self.bar, |_, up| self.colour(value(up)));
        self.plot.axes(&mut sheet, false);
        self.bar.axes(&mut sheet, true);
        sheet.title(&self.plane.title, self.plot.corner.0 + self.plot.extent.0 / 2, self.bar.corner.1);
        (sheet, self.size)
    }

    fn colour(&self, value: f64) -> RGBColor {
        let range = &self.bar.y.range;
        let part = ((value - range.start) / (range.end - range.start)).clamp(0.0, 1.0);
        let colour = || self.colours[(part * (self.colours.len() - 1) as f64).round() as usize];
        if part.is_nan() { RGBColor(200, 200, 200) } else { colour() }
    }

    fn streamline(&self, sheet: &mut Sheet, line: &[Point], colour: impl Fn(Point) -> RGBColor) {
        let place = |point: &Point| self.plot.pixel(point[0], point[1]);
        let mut start = 0;
        for run in line[1..].chunk_by(|a, b| colour(*a) == colour(*b)) {
            let end = start + run.len();
            sheet.line(line[start..=end].iter().map(place).collect(), colour(run[0]), THIN);
            start = end;
        }
        let hop = self.separation / HOPS as f64 / self.plane.size[0] * f64::from(self.plot.extent.0);
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

    fn disc(&self, sheet: &mut Sheet, disc: &Disc) {
        let scale = f64::from(self.plot.extent.0) / self.plane.size[0];
        let rim = outline(disc, self.plane.size, (disc.radius * scale).clamp(12.0, 128.0) as usize);
        let mut rim: Vec<Pixel> = rim.iter().map(|at| self.plot.pixel(at[0], at[1])).collect();
        if rim.len() > 2 {
            sheet.area(rim.clone(), RGBColor(170, 170, 170));
            rim.push(rim[0]);
            sheet.line(rim, INK, 3 * THIN / 2);
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
