//! Figures of a plane of the flow: the colour map of vorticity under streamlines, and streamlines coloured by speed.

use std::path::{Path, PathBuf};

use plotters::prelude::*;

use super::Plane;
use super::canvas::{self, Axis, BELOW, Frame, LARGE, Pixel, SCALE, Sheet};
use super::paint::{self, Palette};
use super::trace::{Point, sample};
use crate::Result;

/// Largest width and height of a plot; the domain's aspect decides which one binds.
const MOST: [f64; 2] = [1000.0, 900.0];
/// Least width or height of a plot, for domains that are thinner than can be drawn to scale.
const LEAST: f64 = 60.0;
/// Distance between streamlines.
const SEPARATION: f64 = 22.0;
/// Of so many cells, one has a vorticity beyond the colours.
pub const SATURATED: usize = 100;
const BAR: i32 = 22 * SCALE;
const MARGIN: i32 = 20 * SCALE;

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
    paint::check(plane, stem)?;
    let limit = paint::vorticity_limit(std::slice::from_ref(plane), SATURATED);
    let field = Field::new(plane, Palette::diverging(limit), "vorticity (1/s)");
    let mut sheet = Sheet::default();
    paint::vorticity(&mut sheet, &field.plot, plane, &field.palette);
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
    paint::check(plane, stem)?;
    let fastest = paint::speed_limit(std::slice::from_ref(plane));
    let field = Field::new(plane, Palette::sequential(fastest), "speed (m/s)");
    let speed = |at: Point| sample(plane, &plane.u, at).hypot(sample(plane, &plane.v, at));
    Ok(field.finish(Sheet::default(), |at| field.palette.colour(speed(at))))
}

/// A plane on its sheet with the colour bar beside it.
struct Field<'a> {
    plane: &'a Plane,
    plot: Frame,
    bar: Frame,
    palette: Palette,
    size: Pixel,
}

impl<'a> Field<'a> {
    fn new(plane: &'a Plane, palette: Palette, label: &str) -> Self {
        let scale = (MOST[0] / plane.size[0]).min(MOST[1] / plane.size[1]);
        let plot = plane.size.map(|size| (size * scale).max(LEAST));
        let [width, height] = plot.map(|size| size.round() as i32 * SCALE);
        let tall = height.max(160 * SCALE);

        let x = paint::axis(plane, 0, width / (100 * SCALE));
        let y = paint::axis(plane, 1, height / (100 * SCALE));
        let values = Axis::linear(palette.range.clone(), label, (tall / (70 * SCALE)).max(4));
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
            palette,
            size: (all, top + free + BELOW + MARGIN),
        }
    }

    /// Draws streamlines in the colours of a point, then all that lies over them; returns the sheet and its size.
    fn finish(&self, mut sheet: Sheet, colour: impl Fn(Point) -> RGBColor) -> (Sheet, Pixel) {
        paint::streamlines(&mut sheet, &self.plot, self.plane, SEPARATION, colour);
        paint::discs(&mut sheet, &self.plot, self.plane);
        self.palette.bar(&mut sheet, &self.bar);
        self.plot.axes(&mut sheet, false);
        self.bar.axes(&mut sheet, true);
        sheet.title(&self.plane.title, self.plot.corner.0 + self.plot.extent.0 / 2, self.bar.corner.1);
        (sheet, self.size)
    }
}
