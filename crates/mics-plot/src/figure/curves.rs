//! Figures of series over axes: lines, dashed lines and markers, with the legend where it covers
//! least.

use std::ops::Range;
use std::path::{Path, PathBuf};

use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

use super::axis::Axis;
use super::canvas::{self, LARGE, Pixel, SCALE, SMALL, Sheet, THIN};
use super::frame::{BELOW, Frame};
use super::{Axes, Chart, Series, SeriesStyle};
use mics_run::Result;

const PLOT: Pixel = (820 * SCALE, 520 * SCALE);
const MARGIN: i32 = 20 * SCALE;
const PAD: i32 = 10 * SCALE;
/// Room between plots beside each other.
const GUTTER: i32 = 2 * MARGIN;
/// Height of a line of small print.
const LINE: i32 = SMALL + 4 * SCALE;
const SAMPLE: i32 = 44 * SCALE;
const ROW: i32 = 28 * SCALE;
/// Rows of a legend that stands inside the plot, at most.
const MOST_INSIDE: usize = 6;
/// Places of a legend along an edge of the plot, less one.
const PLACES: i32 = 8;
/// Points of curves, PAD apart, that a legend in the plot may hide or come near.
const FEW: usize = 4;
/// Okabe and Ito's colours, which stay apart for every kind of colour vision, the readable ones
/// first.
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
/// Dashes of a line that lies on another one, in whose gaps that shows.
const LONG_DASH: Pixel = (24 * SCALE, 24 * SCALE);
/// The colour of bands and obstacles, which are no series of their own.
const BAND: RGBColor = RGBColor(110, 110, 110);
/// Markers as regular polygons: corners, radius in pixels of the figure, direction of the first
/// corner in degrees.
const MARKERS: [(u32, f64, f64); 5] =
    [(16, 5.5, 0.0), (4, 7.0, 45.0), (3, 7.0, -90.0), (4, 7.0, 0.0), (3, 7.0, 90.0)];

/// Draws series over axes. Writes `STEM.png` and `STEM.svg`.
pub fn curves(axes: &Axes, series: &[Series], stem: &Path) -> Result<[PathBuf; 2]> {
    let (sheet, size) = draw(&[(axes, series)], false);
    sheet.write(size, stem)
}

/// Draws the figure of [`curves`] as SVG text.
pub fn curves_svg(axes: &Axes, series: &[Series]) -> Result<String> {
    let (sheet, size) = draw(&[(axes, series)], false);
    sheet.svg(size)
}

/// Draws the plots of a chart. Writes `STEM.png` and `STEM.svg`.
pub fn chart(chart: &Chart, stem: &Path) -> Result<[PathBuf; 2]> {
    let (sheet, size) = draw_chart(chart);
    sheet.write(size, stem)
}

/// Draws the figure of [`chart`] as SVG text.
pub fn chart_svg(chart: &Chart) -> Result<String> {
    let (sheet, size) = draw_chart(chart);
    sheet.svg(size)
}

fn draw_chart(chart: &Chart) -> (Sheet, Pixel) {
    let panels: Vec<Panel> =
        chart.panels.iter().map(|(axes, series)| (axes, &series[..])).collect();
    draw(&panels, chart.beside)
}

/// A plot of a figure.
type Panel<'a> = (&'a Axes, &'a [Series]);

/// Where a point is on axes: its logarithm where they are logarithmic.
fn place(axes: &Axes, point: &(f64, f64)) -> (f64, f64) {
    let place = |value: f64, log: bool| if log { value.log10() } else { value };
    (place(point.0, axes.log_x), place(point.1, axes.log_y))
}

fn good(point: &(f64, f64)) -> bool {
    point.0.is_finite() && point.1.is_finite()
}

/// All points of a plot that can be placed.
fn placed(panel: Panel) -> Vec<(f64, f64)> {
    let (axes, series) = panel;
    series
        .iter()
        .flat_map(|series| &series.points)
        .map(|point| place(axes, point))
        .filter(good)
        .collect()
}

/// Width and height of one of `count` plots.
fn extent(axes: &Axes, count: usize, beside: bool) -> Pixel {
    match (axes.frame, count) {
        (Some([width, height]), _) => {
            let scale = (f64::from(PLOT.0) / width).min(1.6 * f64::from(PLOT.1) / height);
            ((scale * width) as i32, (scale * height) as i32)
        }
        (None, 0 | 1) => PLOT,
        (None, _) if beside => (PLOT.0 / 2, PLOT.1),
        (None, count) => (PLOT.0, PLOT.1 * 6 / (6 + 2 * count as i32)),
    }
}

/// A logarithmic or a linear axis over a range.
fn axis(log: bool, range: Range<f64>, label: &str, ticks: i32) -> Axis {
    (if log { Axis::logarithmic } else { Axis::linear })(range, label, ticks)
}

/// The vertical axis of a plot of such points and that height.
fn vertical(axes: &Axes, points: &[(f64, f64)], height: i32) -> Axis {
    let range = match (axes.frame, axes.range_y) {
        (Some([_, height]), _) => 0.0..height,
        (None, Some([low, high])) => low..high,
        (None, None) => padded(points.iter().map(|point| point.1), 0.07),
    };
    axis(axes.log_y, range, &axes.y_label, (8 * height / PLOT.1).max(4))
}

/// Draws plots beside or below each other; returns the sheet and its size.
fn draw(panels: &[Panel], beside: bool) -> (Sheet, Pixel) {
    let mut sheet = Sheet::default();
    let Some((first, _)) = panels.first() else { return (sheet, PLOT) };
    let count = panels.len();
    let everything: Vec<Vec<(f64, f64)>> = panels.iter().map(|panel| placed(*panel)).collect();
    // Plots below each other share their horizontal axis.
    let shared = padded(everything.iter().flatten().map(|point| point.0), 0.03);
    let extents: Vec<Pixel> = panels.iter().map(|(axes, _)| extent(axes, count, beside)).collect();
    let ys: Vec<Axis> =
        (0..count).map(|k| vertical(panels[k].0, &everything[k], extents[k].1)).collect();
    let room = ys.iter().map(Axis::room).max().unwrap_or(0);
    let whole = match beside {
        true => {
            extents.iter().map(|extent| extent.0).sum::<i32>()
                + ys.iter().skip(1).map(|y| y.room() + GUTTER).sum::<i32>()
        }
        false => extents.iter().map(|extent| extent.0).max().unwrap_or(0),
    };
    let notes = wrapped(&first.note, whole);
    let small = notes.len() as i32 * LINE;
    let top = MARGIN + if first.title.is_empty() { 0 } else { LARGE + MARGIN / 2 } + small;
    let middle = MARGIN + if beside { ys[0].room() } else { room } + whole / 2;

    let mut at = (MARGIN, top);
    let mut right = 0;
    let mut bottom = top;
    for (k, (panel, y)) in panels.iter().zip(ys).enumerate() {
        let axes = panel.0;
        let extent = extents[k];
        let in_x = match axes.frame {
            Some([width, _]) => 0.0..width,
            None if beside => padded(everything[k].iter().map(|point| point.0), 0.03),
            None => shared.clone(),
        };
        let ticks = (8 * extent.0 / PLOT.0).max(4);
        // A step of 1 where there is room.
        let whole = ((in_x.end - in_x.start) as i32 + 1).min(ticks);
        let x = axis(axes.log_x, in_x, &axes.x_label, if axes.whole_x { whole } else { ticks });
        let x = if axes.falling_x { x.reversed() } else { x };
        let last = beside || k + 1 == count;
        let x = if last { x } else { x.hushed() };
        let corner = (at.0 + if beside { y.room() } else { room }, at.1);
        let frame = Frame { corner, extent, x, y };
        let reached = plot(&mut sheet, *panel, &frame);
        right = right.max(reached);
        bottom = bottom.max(corner.1 + extent.1 + BELOW + MARGIN);
        at = if beside {
            (corner.0 + extent.0 + GUTTER, top)
        } else {
            (MARGIN, corner.1 + extent.1 + MARGIN)
        };
    }
    sheet.title(&first.title, middle, top - small);
    for (k, note) in notes.iter().enumerate() {
        let at = (middle, top - small - LINE / 4 + k as i32 * LINE);
        sheet.text(note, SMALL, at, (HPos::Center, VPos::Top), FontTransform::None);
    }
    (sheet, (right.max(canvas::width(&first.title, LARGE)) + MARGIN, bottom))
}

/// Draws a plot with its legend into its frame; returns how far to the right it reaches.
fn plot(sheet: &mut Sheet, panel: Panel, frame: &Frame) -> i32 {
    let (axes, series) = panel;
    frame.grid(sheet);
    let top = frame.corner.1;
    let bottom = frame.corner.1 + frame.extent.1;
    let cut = |pixel: Pixel| {
        if axes.range_y.is_some() { (pixel.0, pixel.1.clamp(top, bottom)) } else { pixel }
    };
    let runs = |series: &Series| -> Vec<Vec<Pixel>> {
        let places: Vec<(f64, f64)> =
            series.points.iter().map(|point| place(axes, point)).collect();
        let runs = places.split(|point| !good(point)).filter(|run| !run.is_empty());
        let runs =
            runs.map(|run| run.iter().map(|point| cut(frame.pixel(point.0, point.1))).collect());
        let lines = matches!(series.style, SeriesStyle::Line | SeriesStyle::Dashed);
        runs.map(|run: Vec<Pixel>| if lines { thinned(&run) } else { run }).collect()
    };
    let all: Vec<Vec<Vec<Pixel>>> = series.iter().map(runs).collect();
    // A line on top of another one would hide it.
    let is_line = |k: &usize| series[*k].style == SeriesStyle::Line;
    let hides = |k: usize| {
        is_line(&k) && (0..k).filter(is_line).any(|other| coincide(&all[other], &all[k]))
    };
    let ranks: Vec<usize> = ranks(series);
    let mut drawn = Vec::new();
    let under = |k: &usize| series[*k].style.is_under();
    let order = (0..series.len()).filter(under).chain((0..series.len()).filter(|k| !under(k)));
    for k in order {
        for pixels in &all[k] {
            drawn.extend(match series[k].style {
                SeriesStyle::Markers => pixels.clone(),
                SeriesStyle::Spread => Vec::new(),
                _ => dotted(pixels),
            });
            if hides(k) {
                sheet.dashed(pixels.clone(), colour(ranks[k]), 2 * THIN, LONG_DASH);
            } else {
                stroke(sheet, series[k].style, ranks[k], pixels.clone());
            }
        }
    }
    frame.axes(sheet, false);
    let entries: Vec<Entry> = (0..series.len())
        .filter(|k| !series[*k].label.is_empty() && !under(k))
        .map(|k| (series[k].label.as_str(), series[k].style, ranks[k]))
        .collect();
    legend(sheet, &entries, frame.corner, frame.extent, &drawn)
}

/// The number of each series among those that have a colour of their own; a spread has that of the
/// series before it.
fn ranks(series: &[Series]) -> Vec<usize> {
    let mut next = 0;
    let rank = |series: &Series| {
        next += usize::from(!series.style.is_under());
        next.saturating_sub(1)
    };
    series.iter().map(rank).collect()
}

/// Whether two lines are one on paper.
fn coincide(a: &[Vec<Pixel>], b: &[Vec<Pixel>]) -> bool {
    let near = |(p, q): (&Pixel, &Pixel)| p.0 == q.0 && (p.1 - q.1).abs() <= SCALE;
    let mut a = a.iter().flatten();
    let mut b = b.iter().flatten();
    let mut any = false;
    loop {
        match (a.next(), b.next()) {
            (Some(p), Some(q)) if near((p, q)) => any = true,
            (None, None) => return any,
            _ => return false,
        }
    }
}

/// The colour of the series of a number: those of one round over [`COLOURS`] are darker or paler
/// than those of another.
fn colour(rank: usize) -> RGBColor {
    let RGBColor(red, green, blue) = COLOURS[rank % COLOURS.len()];
    let mixed = |target: u8| {
        let mix = |channel: u8| ((u16::from(channel) + u16::from(target)) / 2) as u8;
        RGBColor(mix(red), mix(green), mix(blue))
    };
    match (rank / COLOURS.len()) % 3 {
        0 => RGBColor(red, green, blue),
        1 => mixed(0),
        _ => mixed(255),
    }
}

/// A text in lines of a width at most.
fn wrapped(text: &str, most: i32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if canvas::width(&format!("{line} {word}"), SMALL) <= most => {
                *line += &format!(" {word}")
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Draws places in a style, in the colour and with the marker of the series of that number.
fn stroke(sheet: &mut Sheet, style: SeriesStyle, index: usize, places: Vec<Pixel>) {
    let colour = colour(index);
    match style {
        SeriesStyle::Spread => {
            if places.len() > 2 {
                sheet.area(places, colour.mix(0.22));
            }
        }
        SeriesStyle::Line => sheet.line(places, colour, 2 * THIN),
        SeriesStyle::Wall => sheet.line(places, BAND, 2 * THIN),
        SeriesStyle::Dashed => sheet.dashed(places, colour, 2 * THIN, DASH),
        SeriesStyle::Band => {
            if let (Some((left, top)), Some((right, bottom))) = (places.first(), places.last()) {
                sheet.area(
                    canvas::ring((*left, *top), (right - left, bottom - top)),
                    BAND.mix(0.55),
                );
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

/// An entry of a legend: its text, the style and the number of its series.
type Entry<'a> = (&'a str, SeriesStyle, usize);

/// Draws the legend in that corner or place at an edge of the plot where it covers least of what is
/// drawn, or beside the plot where it is long or would hide a curve; returns how far to the right
/// all reaches.
fn legend(
    sheet: &mut Sheet,
    entries: &[Entry],
    corner: Pixel,
    extent: Pixel,
    drawn: &[Pixel],
) -> i32 {
    let (left, top) = corner;
    let right = left + extent.0 + MARGIN;
    let widths = entries.iter().map(|(label, ..)| canvas::width(label, SMALL));
    let Some(widest) = widths.max() else { return right };
    // The font of a viewer of the SVG may be wider.
    let width = widest * 11 / 10 + SAMPLE + 3 * PAD;
    let height = ROW * entries.len() as i32 + PAD;
    let free = (extent.0 - width - 2 * PAD, extent.1 - height - 2 * PAD);
    let corner =
        |(i, j): (i32, i32)| (left + PAD + i * free.0 / PLACES, top + PAD + j * free.1 / PLACES);
    let covered = |place: &(i32, i32)| {
        let (x, y) = corner(*place);
        let columns = x - PAD..x + width + PAD;
        let rows = y - PAD..y + height + PAD;
        drawn.iter().filter(|at| columns.contains(&at.0) && rows.contains(&at.1)).count()
    };
    let edges = (0..=PLACES).flat_map(|k| [(k, 0), (k, PLACES), (0, k), (PLACES, k)]);
    let places = [(PLACES, 0), (0, 0), (PLACES, PLACES), (0, PLACES)].into_iter().chain(edges);
    let best = places
        .min_by_key(covered)
        .filter(|place| covered(place) <= FEW && free.0 >= 0 && free.1 >= 0);
    let inside = best.filter(|_| entries.len() <= MOST_INSIDE);
    let (beside, (x, y)) = inside.map_or((true, (right, top)), |place| (false, corner(place)));
    let outline = canvas::ring((x, y), (width, height));
    sheet.area(outline.clone(), WHITE.mix(0.85));
    sheet.line(outline, RGBColor(190, 190, 190), THIN);
    for (row, (label, style, index)) in entries.iter().enumerate() {
        let middle = y + PAD / 2 + ROW * row as i32 + ROW / 2;
        let ends = [0, 1, 2].map(|k| (x + PAD + k * SAMPLE / 2, middle));
        match style {
            SeriesStyle::Line | SeriesStyle::Dashed => stroke(sheet, *style, *index, ends.to_vec()),
            SeriesStyle::Band => {
                let swatch = [(ends[0].0, middle - PAD / 2), (ends[2].0, middle + PAD / 2)];
                stroke(sheet, *style, *index, swatch.to_vec());
            }
            SeriesStyle::Markers | SeriesStyle::Joined => {
                stroke(sheet, SeriesStyle::Markers, *index, vec![ends[1]])
            }
            SeriesStyle::Spread | SeriesStyle::Wall => {}
        }
        let at = (x + 2 * PAD + SAMPLE, middle);
        let anchor = (HPos::Left, VPos::Center);
        sheet.text(label, SMALL, at, anchor, FontTransform::None);
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

/// At most four points of a line in each column of pixels: the first, the lowest, the highest and
/// the last.
fn thinned(run: &[Pixel]) -> Vec<Pixel> {
    let columns = run.chunk_by(|a, b| a.0 == b.0);
    let mut points: Vec<Pixel> = columns
        .flat_map(|column| {
            let ys = || column.iter().map(|point| point.1);
            let x = column[0].0;
            let last = column[column.len() - 1].1;
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
