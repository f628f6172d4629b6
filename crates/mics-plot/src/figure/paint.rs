//! Parts of figures of the flow: colours of values, streamlines, particles, the colour bar.

use std::f64::consts::SQRT_2;
use std::io;
use std::ops::Range;
use std::path::Path;

use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

use super::axis::Axis;
use super::canvas::{self, INK, Pixel, SCALE, SMALL, Sheet, THIN};
use super::cut::{self, clipped, in_plane};
use super::frame::Frame;
use super::trace::{self, HOPS, Point, sample};
use super::{Disc, Plane, Quantity, Scale};
use mics_run::{Error, Result};

/// Distance between arrow heads along a streamline.
const ARROWS: i32 = 220 * SCALE;
/// Blue, white, red (ColorBrewer's RdBu without its darkest ends), for values with a sign.
const DIVERGING: [u32; 9] =
    [0x2166ac, 0x4393c3, 0x92c5de, 0xd1e5f0, 0xffffff, 0xfddbc7, 0xf4a582, 0xd6604d, 0xb2182b];
/// Blue to orange (plasma without its palest end), for lines on white.
const SEQUENTIAL: [u32; 6] = [0x0d0887, 0x5402a3, 0x8b0aa5, 0xb93289, 0xdb5c68, 0xf48849];
/// Light to dark, for particles.
const GREYS: [u32; 2] = [0xd7d7d7, 0x7d7d7d];
/// Obstacles: darker than any particle.
const WALL: RGBColor = RGBColor(0x63, 0x63, 0x63);
/// Light yellow to dark green (ColorBrewer's YlGn without its palest end), for particles that say
/// something beside the two above.
const GREENS: [u32; 5] = [0xf7fcb9, 0xaddd8e, 0x78c679, 0x31a354, 0x006837];
/// Brightness of the marked part of a particle, relative to the rest of it.
const MARKED: f64 = 0.62;
/// Number of cells of which one has a vorticity or a pressure beyond the colours.
const SATURATED: usize = 100;
/// Number of cells of which one has a speed beyond the colours: more, so that jets show.
const FASTEST: usize = 1000;

/// Colours of a range of values.
pub struct Palette {
    colours: Vec<RGBColor>,
    /// The values of the first and the last colour; beyond them colours saturate.
    pub range: Range<f64>,
}

impl Palette {
    /// Colours of values with a sign, white in the middle.
    pub fn diverging([low, high]: [f64; 2]) -> Palette {
        Palette { colours: ramp(&DIVERGING), range: low..high }
    }

    /// Colours of values without a sign.
    pub fn sequential([low, high]: [f64; 2]) -> Palette {
        Palette { colours: ramp(&SEQUENTIAL), range: low..high }
    }

    /// Colours of a plane's quantity, over its style's range or else over that of its values.
    pub fn of(plane: &Plane) -> Palette {
        Palette::showing(
            plane.quantity,
            plane.style.range.unwrap_or_else(|| shared_range(plane.quantity, &[plane])),
        )
    }

    /// Colours of a quantity over a range.
    pub fn showing(quantity: Quantity, range: [f64; 2]) -> Palette {
        match quantity {
            Quantity::Vorticity => Palette::diverging(range),
            Quantity::Speed | Quantity::Pressure => Palette::sequential(range),
        }
    }

    /// Colours of particles: those of a scale, or greys.
    pub fn particles(scale: Option<&Scale>) -> Palette {
        let [low, high] = scale.map_or([0.0, 1.0], |scale| scale.range);
        Palette {
            colours: ramp(if scale.is_some_and(|scale| !scale.grey) { &GREENS } else { &GREYS }),
            range: low..high,
        }
    }

    /// The colour at a part of the range.
    pub fn at(&self, part: f64) -> RGBColor {
        self.colours[(part.clamp(0.0, 1.0) * (self.colours.len() - 1) as f64).round() as usize]
    }

    /// The colour of a value; grey where it is not a number.
    pub fn colour(&self, value: f64) -> RGBColor {
        let part = (value - self.range.start) / (self.range.end - self.range.start);
        if part.is_nan() { RGBColor(200, 200, 200) } else { self.at(part) }
    }

    /// Draws the colours into the frame of a colour bar, whose vertical axis has this range, with
    /// the axis on its right.
    pub fn bar(&self, sheet: &mut Sheet, bar: &Frame) {
        sheet.bitmap(bar.corner, bar.extent, |_, up| self.at(up));
        bar.axes(sheet, true);
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
    let filled = plane.velocity.iter().chain([&plane.values]).all(|values| values.len() == count);
    let sized = plane.size.iter().all(|size| *size > 0.0 && size.is_finite());
    if count > 0 && filled && sized {
        return Ok(());
    }
    let message =
        format!("a plane of {:?} cells and size {:?} cannot be drawn", plane.cells, plane.size);
    Err(Error::io(stem)(io::Error::new(io::ErrorKind::InvalidInput, message)))
}

/// The values of the first and the last colour that suit some planes of a quantity: its outermost
/// hundredth is beyond them, of a speed the fastest thousandth.
pub fn shared_range(quantity: Quantity, planes: &[&Plane]) -> [f64; 2] {
    match quantity {
        Quantity::Vorticity => Some(limit(planes, SATURATED)).map(|limit| [-limit, limit]),
        Quantity::Speed => Some([0.0, limit(planes, FASTEST)]),
        Quantity::Pressure => {
            let values = sorted(planes, |value| value);
            let beyond = values.len() / (2 * SATURATED);
            let ends = values
                .get(beyond)
                .zip(values.iter().rev().nth(beyond))
                .map(|(low, high)| [*low, *high]);
            ends.filter(|[low, high]| high - low > 1e-9 * low.abs().max(high.abs()).max(1e-290))
        }
    }
    .unwrap_or([-1.0, 1.0])
}

fn sorted(planes: &[&Plane], of: fn(f64) -> f64) -> Vec<f64> {
    let all = planes.iter().flat_map(|plane| &plane.values);
    let mut values: Vec<f64> =
        all.map(|value| of(*value)).filter(|value| value.is_finite()).collect();
    values.sort_unstable_by(f64::total_cmp);
    values
}

/// The size of a value that one cell in `in_one` of all planes exceeds: where colours or lines end,
/// so that thin layers at discs do not wash out or blacken the rest. 1 where there is nothing but
/// the rounding errors of a flow without vorticity.
pub fn limit(planes: &[&Plane], in_one: usize) -> f64 {
    let values = sorted(planes, f64::abs);
    let noise =
        planes.iter().map(|plane| 1e-9 * trace::fastest(plane) / plane.size[0].max(plane.size[1]));
    let noise = noise.fold(1e-300, f64::max);
    let limits = [values.get(values.len() - values.len().div_ceil(in_one)), values.last()]
        .into_iter()
        .flatten();
    limits.copied().find(|limit| *limit > noise).unwrap_or(1.0)
}

/// The greatest speed of some planes outside their discs, 1 where nothing moves.
pub fn speed_limit(planes: &[Plane]) -> f64 {
    Some(planes.iter().map(trace::fastest).fold(0.0, f64::max))
        .filter(|speed| *speed > 1e-300)
        .unwrap_or(1.0)
}

/// Fills a plot with the colours of a plane's values.
pub fn values(sheet: &mut Sheet, plot: &Frame, plane: &Plane, palette: &Palette) {
    sheet.bitmap(plot.corner, plot.extent, |x, y| {
        palette.colour(sample(plane, &plane.values, [x * plane.size[0], y * plane.size[1]]))
    });
}

/// Draws streamlines about `apart` pixels of the figure from each other, in the colours of their
/// points.
pub fn streamlines(
    sheet: &mut Sheet,
    plot: &Frame,
    plane: &Plane,
    apart: f64,
    colour: impl Fn(Point) -> RGBColor,
) {
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
fn streamline(
    sheet: &mut Sheet,
    plot: &Frame,
    line: &[Point],
    hop: f64,
    colour: impl Fn(Point) -> RGBColor,
) {
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
    let colours = Palette::particles(plane.scale.as_ref());
    for disc in &plane.discs {
        if disc.wall {
            draw_wall(sheet, plot, disc, plane.size);
            continue;
        }
        let corners = (disc.radius * scale).clamp(12.0, 128.0) as usize;
        draw_body(sheet, plot, disc, corners, plane.size, colours.at(disc.shade));
        write_label(sheet, plot, disc, plane.size, scale);
    }
}

/// Draws an obstacle: what is within its outer rings, which run counterclockwise, each as one area
/// with its holes, by way of its first corner.
fn draw_wall(sheet: &mut Sheet, plot: &Frame, wall: &Disc, size: [f64; 2]) {
    let rings: Vec<_> = wall.rings(0).into_iter().map(|ring| in_plane(ring, size)).collect();
    let (outer, holes): (Vec<_>, Vec<_>) =
        rings.into_iter().filter(|ring| ring.len() > 2).partition(|ring| cut::area(ring) > 0.0);
    let pixels = |ring: &[Point]| -> Vec<Pixel> {
        ring.iter().chain(ring.first()).map(|at| plot.pixel(at[0], at[1])).collect()
    };
    for ring in &outer {
        let mut area = pixels(ring);
        let within = |hole: &&Vec<Point>| cut::within(std::slice::from_ref(ring), hole[0]);
        for hole in holes.iter().filter(within) {
            area.extend(pixels(hole));
            area.extend(area.first().copied());
        }
        sheet.area(area, WALL);
    }
    for ring in outer.iter().chain(&holes) {
        sheet.line(pixels(ring), INK, 3 * THIN / 2);
    }
}

/// Draws a body with the part that is marked: all edges first, so that none shows where its rings
/// overlap.
fn draw_body(
    sheet: &mut Sheet,
    plot: &Frame,
    disc: &Disc,
    corners: usize,
    size: [f64; 2],
    colour: RGBColor,
) {
    let pixels =
        |places: &[Point]| places.iter().map(|at| plot.pixel(at[0], at[1])).collect::<Vec<Pixel>>();
    let rings: Vec<_> = disc.rings(corners).into_iter().map(|ring| in_plane(ring, size)).collect();
    let rings: Vec<_> = rings.into_iter().filter(|ring| ring.len() > 2).collect();
    for ring in &rings {
        let mut edge = pixels(ring);
        edge.push(edge[0]);
        sheet.line(edge, INK, 3 * THIN);
    }
    for ring in &rings {
        sheet.area(pixels(ring), colour);
    }
    let Some([x, y, off]) = disc.mark else { return };
    let off = off - x * disc.centre[0] - y * disc.centre[1];
    for ring in rings {
        let marked = pixels(&clipped(ring, [x, y, off]));
        if marked.len() > 2 {
            sheet.area(marked, dark(colour));
        }
    }
}

/// Writes on a particle what there is room for.
fn write_label(sheet: &mut Sheet, plot: &Frame, disc: &Disc, size: [f64; 2], scale: f64) {
    let inside = (0..2).all(|a| (0.0..=size[a]).contains(&disc.centre[a]));
    // A square in the circle holds it.
    let room = (disc.room() * scale * SQRT_2) as i32;
    let label = disc.label.iter().find(|label| canvas::width(label, SMALL) < room && SMALL < room);
    if let Some(label) = label.filter(|_| inside) {
        let anchor = (HPos::Center, VPos::Center);
        let at = plot.pixel(disc.centre[0], disc.centre[1]);
        sheet.text(label, SMALL, at, anchor, FontTransform::None);
    }
}

/// At most 256 colours that a plane of values with its particles, bars and text can be drawn in.
pub fn inks(plane: &Plane) -> Vec<RGBColor> {
    // The first and the last of them as well: paper has to stay white.
    let few = |palette: &Palette, count: usize| -> Vec<RGBColor> {
        (0..count).map(|k| palette.at(k as f64 / (count - 1) as f64)).collect()
    };
    let particles = few(&Palette::particles(plane.scale.as_ref()), 32);
    let marked = particles.iter().copied().map(dark).collect();
    let greys = Palette { colours: ramp(&[0x262626, 0xffffff]), range: 0.0..1.0 };
    // An odd number, so that the middle is among them.
    [few(&Palette::of(plane), 127), particles, marked, few(&greys, 32)].concat()
}

/// The colour of the marked part of a particle.
fn dark(RGBColor(red, green, blue): RGBColor) -> RGBColor {
    let [red, green, blue] =
        [red, green, blue].map(|channel| (MARKED * f64::from(channel)).round() as u8);
    RGBColor(red, green, blue)
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
