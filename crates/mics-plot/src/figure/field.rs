//! Figures of a plane of the flow: the colour map of vorticity under streamlines, streamlines
//! coloured by speed, and the colours of a quantity alone.

use std::path::{Path, PathBuf};

use plotters::prelude::*;

use super::axis::Axis;
use super::canvas::{self, INK, LARGE, Pixel, SCALE, Sheet, THIN};
use super::frame::{BELOW, Frame};
use super::paint::{self, Palette};
use super::trace::speed;
use super::{Plane, Scale};
use mics_run::Result;

/// Largest width and height of a plot; the domain's aspect decides which one binds.
const MOST: [f64; 2] = [1000.0, 900.0];
/// Least width or height of a plot, for domains that are thinner than can be drawn to scale.
const LEAST: f64 = 60.0;
/// Distance between streamlines.
const SEPARATION: f64 = 22.0;
const BAR: i32 = 22 * SCALE;
const MARGIN: i32 = 20 * SCALE;
/// Height of an entry of a legend of particles.
const NAMED: i32 = 38 * SCALE;

/// Draws vorticity as a colour map with streamlines and discs over it. Writes `STEM.png` and
/// `STEM.svg`.
pub fn vorticity(plane: &Plane, stem: &Path) -> Result<[PathBuf; 2]> {
    let (sheet, size) = draw_vorticity(plane, stem)?;
    sheet.write(size, stem)
}

/// Draws the figure of [`vorticity`] as SVG text.
pub fn vorticity_svg(plane: &Plane) -> Result<String> {
    let (sheet, size) = draw_vorticity(plane, Path::new("vorticity"))?;
    sheet.svg(size)
}

fn draw_vorticity(plane: &Plane, stem: &Path) -> Result<(Sheet, Pixel)> {
    paint::check(plane, stem)?;
    let field = Field::new(plane, Palette::of(plane), plane.quantity.label(), &plane.title);
    let mut sheet = Sheet::default();
    paint::values(&mut sheet, &field.plot, plane, &field.palette);
    paint::streamlines(&mut sheet, &field.plot, plane, SEPARATION, |_| RGBColor(70, 70, 70));
    Ok(field.finish(sheet))
}

/// Draws streamlines coloured by speed, with discs, on white. Writes `STEM.png` and `STEM.svg`.
pub fn streamlines(plane: &Plane, stem: &Path) -> Result<[PathBuf; 2]> {
    let (sheet, size) = draw_streamlines(plane, stem)?;
    sheet.write(size, stem)
}

/// Draws the figure of [`streamlines`] as SVG text.
pub fn streamlines_svg(plane: &Plane) -> Result<String> {
    let (sheet, size) = draw_streamlines(plane, Path::new("streamlines"))?;
    sheet.svg(size)
}

fn draw_streamlines(plane: &Plane, stem: &Path) -> Result<(Sheet, Pixel)> {
    paint::check(plane, stem)?;
    let range =
        plane.style.range.unwrap_or_else(|| [0.0, paint::speed_limit(std::slice::from_ref(plane))]);
    let field = Field::new(plane, Palette::sequential(range), "speed (m/s)", &plane.title);
    let mut sheet = Sheet::default();
    paint::streamlines(&mut sheet, &field.plot, plane, SEPARATION, |at| {
        field.palette.colour(speed(plane, at))
    });
    Ok(field.finish(sheet))
}

/// Draws the colours of what a plane shows, with discs, and nothing else. Writes `STEM.png` and
/// `STEM.svg`.
///
/// # Errors
/// When the plane's values do not fill its cells, or a file cannot be written.
pub fn field(plane: &Plane, stem: &Path) -> Result<[PathBuf; 2]> {
    let (sheet, size) = draw_field(plane, &plane.title, stem)?;
    sheet.write(size, stem)
}

/// Draws the figure of [`field`] on its sheet, with room for a title wider than the plane's.
pub fn draw_field(plane: &Plane, widest: &str, stem: &Path) -> Result<(Sheet, Pixel)> {
    paint::check(plane, stem)?;
    let field = Field::new(plane, Palette::of(plane), plane.quantity.label(), widest);
    let mut sheet = Sheet::default();
    paint::values(&mut sheet, &field.plot, plane, &field.palette);
    Ok(field.finish(sheet))
}

/// A plane on its sheet with the colour bars beside it.
struct Field<'a> {
    plane: &'a Plane,
    plot: Frame,
    palette: Palette,
    /// Colour bars: of the flow, and of the particles where their colours say something.
    bars: Vec<Frame>,
    size: Pixel,
}

impl<'a> Field<'a> {
    fn new(plane: &'a Plane, palette: Palette, label: &str, widest: &str) -> Self {
        let most = plane.style.size.map_or(MOST, |size| [f64::from(size); 2]);
        let scale = (most[0] / plane.size[0]).min(most[1] / plane.size[1]);
        let plot = plane.size.map(|size| (size * scale).max(LEAST));
        let [width, height] = plot.map(|size| size.round() as i32 * SCALE);
        let tall = height.max(160 * SCALE);

        let x = paint::axis(plane, 0, width / (100 * SCALE));
        let y = paint::axis(plane, 1, height / (100 * SCALE));
        let values = bars(&palette, label, plane.scale.as_ref(), tall);
        let needed =
            y.room() + width + values.iter().map(|axis| MARGIN + BAR + axis.room()).sum::<i32>();
        let all = needed.max(canvas::width(widest, LARGE)) + 2 * MARGIN;
        let left = (all - needed) / 2 + y.room();
        let top = MARGIN + if plane.title.is_empty() { 0 } else { LARGE + MARGIN / 2 };
        let free = (300 * SCALE - top - BELOW - MARGIN).max(tall);
        let at = |x: i32, height: i32| (x, top + (free - height) / 2);
        Field {
            plane,
            plot: Frame { corner: at(left, height), extent: (width, height), x, y },
            palette,
            bars: side_by_side(values, at(left + width + MARGIN, tall), tall),
            size: (all, top + free + BELOW + MARGIN),
        }
    }

    /// Draws all that lies over the flow and beside it; returns the sheet and its size.
    fn finish(&self, mut sheet: Sheet) -> (Sheet, Pixel) {
        paint::discs(&mut sheet, &self.plot, self.plane);
        draw_bars(&mut sheet, &self.bars, &self.palette, self.plane.scale.as_ref());
        self.plot.axes(&mut sheet, false);
        let top = self.bars.iter().map(|bar| bar.corner.1).fold(self.plot.corner.1, i32::min);
        sheet.title(&self.plane.title, self.plot.corner.0 + self.plot.extent.0 / 2, top);
        (sheet, self.size)
    }
}

/// The axes of colour bars of a height: of a palette of what is shown of the flow, and of what the
/// colours of particles say.
pub fn bars(palette: &Palette, label: &str, scale: Option<&Scale>, tall: i32) -> Vec<Axis> {
    let flow = Axis::linear(palette.range.clone(), label, ticks(tall));
    [flow].into_iter().chain(particle_bar(scale, tall)).collect()
}

/// The axis of the colour bar of particles, where their colours say something.
pub fn particle_bar(scale: Option<&Scale>, tall: i32) -> Option<Axis> {
    scale.filter(|scale| scale.range[0] < scale.range[1]).map(|scale| {
        let [low, high] = scale.range;
        match scale.names.len() {
            0 => Axis::linear(low..high, &scale.label, ticks(tall)),
            _ => Axis::of_names(&scale.label, scale.names.iter().map(|(_, name)| name.clone())),
        }
    })
}

fn ticks(tall: i32) -> i32 {
    (tall / (70 * SCALE)).max(4)
}

/// Colour bars beside each other, from the upper left corner of the first; one of names is as tall
/// as these need.
pub fn side_by_side(axes: Vec<Axis>, corner: Pixel, tall: i32) -> Vec<Frame> {
    let mut left = corner.0;
    let place = |y: Axis| {
        let at = left;
        left += BAR + y.room() + MARGIN;
        let (top, tall) = match y.is_of_names() {
            true => (corner.1 + NAMED, (y.range.end * f64::from(NAMED)) as i32),
            false => (corner.1, tall),
        };
        Frame { corner: (at, top), extent: (BAR, tall), x: Axis::blank(), y }
    };
    axes.into_iter().map(place).collect()
}

/// Draws the colour bars of a palette and of what the colours of particles say: of few values a
/// field of its colour for each.
pub fn draw_bars(sheet: &mut Sheet, bars: &[Frame], palette: &Palette, scale: Option<&Scale>) {
    let mut bars = bars.iter();
    if let Some(bar) = bars.next() {
        palette.bar(sheet, bar);
    }
    draw_particle_bars(sheet, bars.as_slice(), scale);
}

/// Draws the colour bar of particles, where there is one.
pub fn draw_particle_bars(sheet: &mut Sheet, bars: &[Frame], scale: Option<&Scale>) {
    let particles = Palette::particles(scale);
    for (bar, scale) in bars.iter().zip(scale) {
        if scale.names.is_empty() {
            particles.bar(sheet, bar);
        } else {
            let colours: Vec<_> =
                scale.names.iter().map(|(value, _)| particles.colour(*value)).collect();
            legend(sheet, bar, &colours);
        }
    }
}

/// Draws a field of each colour, the first one lowest, with the names of the vertical axis beside
/// them.
fn legend(sheet: &mut Sheet, bar: &Frame, colours: &[RGBColor]) {
    let (left, top) = bar.corner;
    let tall = bar.extent.1 / colours.len().max(1) as i32;
    for (k, colour) in colours.iter().rev().enumerate() {
        let side = BAR.min(tall * 3 / 4);
        let corner = (left, top + k as i32 * tall + (tall - side) / 2);
        let ring = canvas::ring(corner, (BAR, side));
        sheet.area(ring.clone(), *colour);
        sheet.line(ring, INK, THIN);
    }
    bar.axes(sheet, true);
}
