//! Figures of series over axes: lines, dashed lines and markers, with the legend where it covers least.

use std::ops::Range;
use std::path::{Path, PathBuf};

use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{self, Axis, BELOW, Frame, LARGE, Pixel, SCALE, SMALL, Sheet, THIN};
use super::{Axes, Series, SeriesStyle};
use crate::Result;

const PLOT: Pixel = (820 * SCALE, 520 * SCALE);
const MARGIN: i32 = 20 * SCALE;
const PAD: i32 = 10 * SCALE;
const SAMPLE: i32 = 44 * SCALE;
const ROW: i32 = 28 * SCALE;
/// Rows of a legend that stands inside the plot, at most.
const MOST_INSIDE: usize = 6;
/// Places of a legend along an edge of the plot, less one.
const PLACES: i32 = 8;
/// Points of curves, PAD apart, that a legend in the plot may hide or come near.
const FEW: usize = 4;
/// Okabe and Ito's colours, which stay apart for every kind of colour vision, the readable ones first.
pub const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(60, 60, 60),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];
const DASH: Pixel = (9 * SCALE, 6 * SCALE);
/// The colour of bands, which are no series of their own.
const BAND: RGBColor = RGBColor(110, 110, 110);
/// Markers as regular polygons: corners, radius in pixels of the figure, direction of the first corner in degrees.
const MARKERS: [(u32, f64, f64); 5] = [(16, 5.5, 0.0), (4, 7.0, 45.0), (3, 7.0, -90.0), (4, 7.0, 0.0), (3, 7.0, 90.0)];

/// Draws series over axes. Writes `STEM.png` and `STEM.svg`.
pub fn curves(axes: &Axes, series: &[Series], stem: &Path) -> Result<[PathBuf; 2]> {
    let (sheet, size) = draw(axes, series);
    sheet.write(size, stem)
}

/// The same figure as SVG text.
pub fn curves_svg(axes: &Axes, series: &[Series]) -> Result<String> {
    let (sheet, size) = draw(axes, series);
    sheet.svg(size)
}

fn draw(axes: &Axes, series: &[Series]) -> (Sheet, Pixel) {
    let place = |value: f64, log: bool| if log { value.log10() } else { value };
    let place = |point: &(f64, f64)| (place(point.0, axes.log_x), place(point.1, axes.log_y));
    let good = |point: &(f64, f64)| point.0.is_finite() && point.1.is_finite();
    let all = || series.iter().flat_map(|series| &series.points).map(place).filter(good);
    let axis = |log: bool, range: Range<f64>, label: &str| {
        (if log { Axis::logarithmic } else { Axis::linear })(range, label, 8)
    };
    let (in_x, in_y) = match axes.frame {
        Some([width, height]) => (0.0..width, 0.0..height),
        None => (padded(all().map(|point| point.0), 0.03), padded(all().map(|point| point.1), 0.07)),
    };
    let extent = match axes.frame {
        Some([width, height]) => {
            let scale = (f64::from(PLOT.0) / width).min(1.6 * f64::from(PLOT.1) / height);
            ((scale * width) as i32, (scale * height) as i32)
        }
        None => PLOT,
    };
    let x = axis(axes.log_x, in_x, &axes.x_label);
    let x = if axes.falling_x { x.reversed() } else { x };
    let y = axis(axes.log_y, in_y, &axes.y_label);
    let top = MARGIN + if axes.title.is_empty() { 0 } else { LARGE + MARGIN / 2 };
    let frame = Frame { corner: (MARGIN + y.room(), top), extent, x, y };

    let mut sheet = Sheet::default();
    frame.grid(&mut sheet);
    let mut drawn = Vec::new();
    for (index, series) in series.iter().enumerate() {
        let placed: Vec<(f64, f64)> = series.points.iter().map(place).collect();
        for run in placed.split(|point| !good(point)).filter(|run| !run.is_empty()) {
            let pixels: Vec<Pixel> = run.iter().map(|point| frame.pixel(point.0, point.1)).collect();
            let lines = matches!(series.style, SeriesStyle::Line | SeriesStyle::Dashed);
            let pixels = if lines { thinned(&pixels) } else { pixels };
            let covers = series.style != SeriesStyle::Markers;
            drawn.extend(if covers { dotted(&pixels) } else { pixels.clone() });
            stroke(&mut sheet, series.style, index, pixels);
        }
    }
    frame.axes(&mut sheet, false);
    let right = legend(&mut sheet, series, frame.corner, extent, &drawn);
    sheet.title(&axes.title, frame.corner.0 + extent.0 / 2, top);
    let width = right.max(canvas::width(&axes.title, LARGE)) + MARGIN;
    (sheet, (width, top + extent.1 + BELOW + MARGIN))
}

/// Draws places in a style, in the colour and with the marker of the series of that index.
fn stroke(sheet: &mut Sheet, style: SeriesStyle, index: usize, places: Vec<Pixel>) {
    let colour = COLOURS[index % COLOURS.len()];
    match style {
        SeriesStyle::Line => sheet.line(places, colour, 2 * THIN),
        SeriesStyle::Dashed => sheet.dashed(places, colour, 2 * THIN, DASH),
        SeriesStyle::Band => {
            if let (Some((left, top)), Some((right, bottom))) = (places.first(), places.last()) {
                sheet.area(canvas::ring((*left, *top), (right - left, bottom - top)), BAND.mix(0.55));
            }
        }
        SeriesStyle::Joined => {
            sheet.line(places.clone(), colour, THIN);
            stroke(sheet, SeriesStyle::Markers, index, places);
        }
        SeriesStyle::Markers => {
            let (corners, radius, first) = MARKERS[index % MARKERS.len()];
            let corner = |(x, y): Pixel, k: u32| {
                let angle = (first + 360.0 * f64::from(k) / f64::from(corners)).to_radians();
                let offset = |part: f64| (radius * f64::from(SCALE) * part).round() as i32;
                (x + offset(angle.cos()), y + offset(angle.sin()))
            };
            for place in places {
                sheet.area((0..corners).map(|k| corner(place, k)).collect(), colour);
            }
        }
    }
}

/// Draws the legend in that corner or place at an edge of the plot where it covers least of what is drawn, or beside the plot
/// where it is long or would hide a curve; returns how far to the right all reaches.
fn legend(sheet: &mut Sheet, series: &[Series], (left, top): Pixel, extent: Pixel, drawn: &[Pixel]) -> i32 {
    let right = left + extent.0 + MARGIN;
    let named = || series.iter().enumerate().filter(|(_, series)| !series.label.is_empty());
    let widths = named().map(|(_, series)| canvas::width(&series.label, SMALL));
    let Some(widest) = widths.max() else { return right };
    // The font of a viewer of the SVG may be wider.
    let (width, height) = (widest * 11 / 10 + SAMPLE + 3 * PAD, ROW * named().count() as i32 + PAD);
    let free = (extent.0 - width - 2 * PAD, extent.1 - height - 2 * PAD);
    let corner = |(i, j): (i32, i32)| (left + PAD + i * free.0 / PLACES, top + PAD + j * free.1 / PLACES);
    let covered = |place: &(i32, i32)| {
        let (x, y) = corner(*place);
        let (columns, rows) = (x - PAD..x + width + PAD, y - PAD..y + height + PAD);
        drawn.iter().filter(|at| columns.contains(&at.0) && rows.contains(&at.1)).count()
    };
    let edges = (0..=PLACES).flat_map(|k| [(k, 0), (k, PLACES), (0, k), (PLACES, k)]);
    let places = [(PLACES, 0), (0, 0), (PLACES, PLACES), (0, PLACES)].into_iter().chain(edges);
    let best = places.min_by_key(covered).filter(|place| covered(place) <= FEW && free.0 >= 0 && free.1 >= 0);
    let inside = best.filter(|_| named().count() <= MOST_INSIDE);
    let (beside, (x, y)) = inside.map_or((true, (right, top)), |place| (false, corner(place)));
    let outline = canvas::ring((x, y), (width, height));
    sheet.area(outline.clone(), WHITE.mix(0.85));
    sheet.line(outline, RGBColor(190, 190, 190), THIN);
    for (row, (index, series)) in named().enumerate() {
        let middle = y + PAD / 2 + ROW * row as i32 + ROW / 2;
        let ends = [0, 1, 2].map(|k| (x + PAD + k * SAMPLE / 2, middle));
        match series.style {
            SeriesStyle::Line | SeriesStyle::Dashed => stroke(sheet, series.style, index, ends.to_vec()),
            SeriesStyle::Band => {
                let swatch = [(ends[0].0, middle - PAD / 2), (ends[2].0, middle + PAD / 2)];
                stroke(sheet, series.style, index, swatch.to_vec());
            }
            SeriesStyle::Markers | SeriesStyle::Joined => stroke(sheet, SeriesStyle::Markers, index, vec![ends[1]]),
        }
        let (at, anchor) = ((x + 2 * PAD + SAMPLE, middle), (HPos::Left, VPos::Center));
        sheet.text(&series.label, SMALL, at, anchor, FontTransform::None);
    }
    if beside { x + width } else { right }
}

/// The range of some values, widened so that nothing lies on its ends.
fn padded(values: impl Iterator<Item = f64>, part: f64) -> Range<f64> {
    let around = |(low, high): (f64, f64), value: f64| (low.min(value), high.max(value));
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), around);
    if low > high {
        return 0.0..1.0;
    }
    let size = low.abs().max(high.abs());
    let flat = if size > 0.0 { 0.1 * size } else { 1.0 };
    let pad = if high - low > 1e-12 * size { part * (high - low) } else { flat };
    low - pad..high + pad
}

/// At most four points of a line in each column of pixels: the first, the lowest, the highest and the last.
fn thinned(run: &[Pixel]) -> Vec<Pixel> {
    let columns = run.chunk_by(|a, b| a.0 == b.0);
    let mut points: Vec<Pixel> = columns
        .flat_map(|column| {
            let ys = || column.iter().map(|point| point.1);
            let (x, last) = (column[0].0, column[column.len() - 1].1);
            [Some(column[0].1), ys().min(), ys().max(), Some(last)].map(|y| (x, y.unwrap_or(last)))
        })
        .collect();
    points.dedup();
    points
}

/// Points along a run close enough to tell what a legend covers.
fn dotted(run: &[Pixel]) -> Vec<Pixel> {
    let pairs = run.windows(2).flat_map(|pair| {
        let [(x0, y0), (x1, y1)] = [pair[0], pair[1]];
        let count = ((x1 - x0).abs().max((y1 - y0).abs()) / PAD).max(1);
        (0..count).map(move |k| (x0 + (x1 - x0) * k / count, y0 + (y1 - y0) * k / count))
    });
    pairs.chain(run.last().copied()).collect()
}
