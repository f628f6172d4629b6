//! Strips: one scene at several times side by side, vorticity with contour lines, streamlines or
//! the colours of a quantity alone, in the same colours.

use std::io;
use std::path::{Path, PathBuf};

use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

use super::axis::Axis;
use super::canvas::{self, INK, LARGE, MEDIUM, Pixel, SCALE, Sheet};
use super::contour::{contours, outside};
use super::field::{bars, draw_bars, side_by_side};
use super::frame::{BELOW, Frame};
use super::paint::{self, Palette};
use super::trace::{Point, speed};
use super::{Plane, Quantity, Scale, Style, shared_range};
use mics_run::{Error, Result};

/// Largest width and height of all panels together.
const MOST: [f64; 2] = [1200.0, 900.0];
/// Least width or height of a panel.
const LEAST: f64 = 60.0;
/// Distance between streamlines.
const SEPARATION: f64 = 12.0;
/// Room between panels; above each stands its time.
const BESIDE: i32 = 34 * SCALE;
const ABOVE: i32 = 38 * SCALE;
const MARGIN: i32 = 20 * SCALE;
/// Width of a contour line, length of its dashes and of the gaps between them.
const LINE: u32 = 2;
const DASH: Pixel = (4 * SCALE, 3 * SCALE);
/// Number of cells of which one has a vorticity beyond all contour lines.
const LINED: usize = 1000;
/// Contour lines of either sign at most: more would be one black patch.
const LEVELS: f64 = 60.0;

/// Draws the vorticity of some planes of one size, their titles above them, with contour lines
/// every `interval` (1/s, by default a round part of what there is): solid where positive, dashed
/// where negative, none at 0, none within a disc, and none in the thin layers that one cell in a
/// thousand is of. Writes `STEM.png` and `STEM.svg`.
///
/// # Errors
/// When the interval is not positive, or too small for the values that there are.
pub fn vorticity_strip(
    panels: &[Plane],
    title: &str,
    interval: Option<f64>,
    stem: &Path,
) -> Result<[PathBuf; 2]> {
    let strip = Strip::new(panels, stem)?;
    let [low, high] = strip.range();
    let limit = high.max(-low);
    let interval = interval.unwrap_or_else(|| round_down(limit / 4.0));
    let coloured = (limit / interval).ceil();
    let lined = paint::limit(&strip.planes(), LINED);
    if !(interval > 0.0 && coloured <= LEVELS) {
        let why = format!(
            "contour lines every {interval} 1/s are too many where {limit:.3} 1/s is common"
        );
        return Err(Error::Usage(format!(
            "{why}; give --interval {}, say",
            round_down(limit / 4.0)
        )));
    }
    let palette = Palette::diverging(
        strip.style().range.unwrap_or([-coloured * interval, coloured * interval]),
    );
    let title =
        format!("{title}: vorticity, contour lines every {interval} 1/s, dashed where negative");
    let mut sheet = Sheet::default();
    let (size, bars) =
        strip.draw(&mut sheet, &title, &palette, "vorticity (1/s)", |sheet, plot, plane| {
            paint::values(sheet, plot, plane, &palette);
            for (level, line) in isolines(plane, interval, lined) {
                isoline(sheet, line.iter().map(|at| plot.pixel(at[0], at[1])).collect(), level);
            }
        });
    let levels = (1..coloured as i32).flat_map(|k| [-k, k]).map(|k| f64::from(k) * interval);
    for (level, bar) in
        levels.filter(|level| palette.range.contains(level)).zip(bars.first().into_iter().cycle())
    {
        let (left, y) = bar.pixel(0.0, level);
        isoline(&mut sheet, vec![(left, y), (left + bar.extent.0, y)], level);
    }
    sheet.write(size, stem)
}

/// The contour lines of a plane's vorticity outside its discs, with their levels, which go up to
/// `limit`.
fn isolines(plane: &Plane, interval: f64, limit: f64) -> Vec<(f64, Vec<Point>)> {
    let levels = (1..=(limit / interval).min(LEVELS) as i32)
        .flat_map(|k| [-k, k])
        .map(|k| f64::from(k) * interval);
    let lines = levels.flat_map(|level| {
        contours(plane, &plane.values, level).into_iter().map(move |line| (level, line))
    });
    lines
        .flat_map(|(level, line)| {
            outside(line, &plane.discs).into_iter().map(move |part| (level, part))
        })
        .collect()
}

/// Draws streamlines of some planes of one size, coloured by speed, their titles above them. Writes
/// `STEM.png` and `STEM.svg`.
pub fn streamlines_strip(panels: &[Plane], title: &str, stem: &Path) -> Result<[PathBuf; 2]> {
    let strip = Strip::new(panels, stem)?;
    let palette = Palette::sequential(
        strip.style().range.unwrap_or_else(|| [0.0, paint::speed_limit(panels)]),
    );
    let mut sheet = Sheet::default();
    let title = format!("{title}: streamlines");
    let (size, _) =
        strip.draw(&mut sheet, &title, &palette, "speed (m/s)", |sheet, plot, plane| {
            paint::streamlines(sheet, plot, plane, SEPARATION, |at| {
                palette.colour(speed(plane, at))
            });
        });
    sheet.write(size, stem)
}

/// Draws the colours of what some planes of one size show, with their discs, their titles above
/// them. Writes `STEM.png` and `STEM.svg`.
///
/// # Errors
/// When there is no plane, one's values do not fill its cells, or a file cannot be written.
pub fn field_strip(panels: &[Plane], title: &str, stem: &Path) -> Result<[PathBuf; 2]> {
    let strip = Strip::new(panels, stem)?;
    let quantity = strip.quantity();
    let palette = Palette::showing(strip.quantity(), strip.range());
    let mut sheet = Sheet::default();
    let title = format!("{title}: {}", quantity.name());
    let (size, _) =
        strip.draw(&mut sheet, &title, &palette, quantity.label(), |sheet, plot, plane| {
            paint::values(sheet, plot, plane, &palette);
        });
    sheet.write(size, stem)
}

fn isoline(sheet: &mut Sheet, places: Vec<Pixel>, level: f64) {
    match level {
        0.0.. => sheet.line(places, INK, LINE),
        _ => sheet.dashed(places, INK, LINE, DASH),
    }
}

/// The largest of 1, 2 and 5 times a power of ten that is not above a value.
fn round_down(value: f64) -> f64 {
    let power = 10f64.powf((value * (1.0 + 1e-9)).log10().floor());
    [5.0, 2.0]
        .map(|part| part * power)
        .into_iter()
        .find(|round| *round <= value * (1.0 + 1e-9))
        .unwrap_or(power)
}

/// Panels in rows and columns, as large as the sheet allows.
struct Strip<'a> {
    panels: &'a [Plane],
    columns: usize,
    /// Width and height of a panel.
    extent: Pixel,
    /// Upper left corner of the first.
    corner: Pixel,
}

impl<'a> Strip<'a> {
    fn new(panels: &'a [Plane], stem: &Path) -> Result<Strip<'a>> {
        let none =
            || Error::io(stem)(io::Error::new(io::ErrorKind::InvalidInput, "a strip of no panels"));
        let first = panels.first().ok_or_else(none)?;
        panels.iter().try_for_each(|plane| paint::check(plane, stem))?;
        let most = first.style.size.map_or(MOST, |size| [f64::from(size); 2]);
        let (columns, scale) = arrangement(panels.len(), first.size, most);
        let [width, height] =
            first.size.map(|size| (size * scale).max(LEAST).round() as i32 * SCALE);
        let y = axis(first, 1, height, true);
        Ok(Strip {
            panels,
            columns,
            extent: (width, height),
            corner: (MARGIN + y.room(), MARGIN + LARGE + MARGIN / 2 + ABOVE),
        })
    }

    fn planes(&self) -> Vec<&Plane> {
        self.panels.iter().collect()
    }

    /// Style of all panels: that of the first.
    fn style(&self) -> Style {
        self.panels.first().map_or_else(Style::default, |plane| plane.style)
    }

    /// Quantity that all panels show: that of the first.
    fn quantity(&self) -> Quantity {
        self.panels.first().map_or_else(Quantity::default, |plane| plane.quantity)
    }

    /// The values of the first and the last colour.
    fn range(&self) -> [f64; 2] {
        self.style().range.unwrap_or_else(|| shared_range(self.quantity(), &self.planes()))
    }

    /// Width and height of all panels together.
    fn all(&self) -> Pixel {
        let rows = self.panels.len().div_ceil(self.columns) as i32;
        let columns = self.columns as i32;
        (columns * (self.extent.0 + BESIDE) - BESIDE, rows * (self.extent.1 + ABOVE) - ABOVE)
    }

    /// A panel with its axes: numbers and labels only on the left and below.
    fn plot(&self, index: usize) -> Frame {
        let column = (index % self.columns) as i32;
        let row = (index / self.columns) as i32;
        let plane = &self.panels[index];
        let (width, height) = self.extent;
        Frame {
            corner: (
                self.corner.0 + column * (width + BESIDE),
                self.corner.1 + row * (height + ABOVE),
            ),
            extent: self.extent,
            x: axis(plane, 0, width, index + self.columns >= self.panels.len()),
            y: axis(plane, 1, height, column == 0),
        }
    }

    /// The colour bars, beside all panels.
    fn bars(&self, palette: &Palette, label: &str) -> Vec<Frame> {
        let (width, height) = self.all();
        let tall = height.clamp(160 * SCALE, 600 * SCALE);
        let corner = (self.corner.0 + width + MARGIN, self.corner.1 + (height - tall) / 2);
        side_by_side(bars(palette, label, self.scale(), tall), corner, tall)
    }

    fn scale(&self) -> Option<&Scale> {
        self.panels.first().and_then(|plane| plane.scale.as_ref())
    }

    /// Draws all panels as `paint` fills them, and the bar; returns the size of the sheet and the
    /// bars' frames.
    fn draw(
        &self,
        sheet: &mut Sheet,
        title: &str,
        palette: &Palette,
        label: &str,
        paint: impl Fn(&mut Sheet, &Frame, &Plane),
    ) -> (Pixel, Vec<Frame>) {
        for (index, plane) in self.panels.iter().enumerate() {
            let plot = self.plot(index);
            paint(sheet, &plot, plane);
            paint::discs(sheet, &plot, plane);
            plot.axes(sheet, false);
            let letter = char::from(b'a' + (index % 26) as u8);
            let at = (plot.corner.0 + plot.extent.0 / 2, plot.corner.1 - 6 * SCALE);
            let anchor = (HPos::Center, VPos::Bottom);
            sheet.text(
                &format!("({letter}) {}", plane.title),
                MEDIUM,
                at,
                anchor,
                FontTransform::None,
            );
        }
        let bars = self.bars(palette, label);
        draw_bars(sheet, &bars, palette, self.scale());
        let (width, height) = self.all();
        sheet.title(title, self.corner.0 + width / 2, self.corner.1 - ABOVE);
        let beside = bars
            .iter()
            .map(|bar| bar.corner.0 + bar.extent.0 + bar.y.room() + MARGIN)
            .max()
            .unwrap_or(0);
        let titled = self.corner.0 + width / 2 + canvas::width(title, LARGE) / 2 + MARGIN;
        let low = bars.iter().map(|bar| bar.corner.1 + bar.extent.1).max().unwrap_or(0);
        let below = (self.corner.1 + height + BELOW).max(low) + MARGIN;
        ((beside.max(titled), below), bars)
    }
}

fn axis(plane: &Plane, axis: usize, extent: i32, named: bool) -> Axis {
    let axis = paint::axis(plane, axis, extent / (60 * SCALE));
    if named { axis } else { axis.unnamed() }
}

/// The number of columns that gives the largest panels with few empty places, and the pixels of a
/// unit of length.
fn arrangement(count: usize, size: [f64; 2], most: [f64; 2]) -> (usize, f64) {
    let of = |columns: usize| {
        let rows = count.div_ceil(columns);
        let scale = (most[0] / (columns as f64 * size[0])).min(most[1] / (rows as f64 * size[1]));
        (columns, scale, scale * (count as f64 / (columns * rows) as f64).sqrt())
    };
    let best = (1..=count).map(of).max_by(|a, b| a.2.total_cmp(&b.2));
    best.map_or((1, 1.0), |(columns, scale, _)| (columns, scale))
}
