//! The sheet under every figure: one drawing to PNG and SVG, and text.
//!
//! Lengths are in pixels of the sheet, [`SCALE`] of them to a pixel of the figure: plotters rounds
//! every coordinate to whole pixels and smooths almost nothing, so the PNG is drawn larger and
//! averaged down, and the SVG is scaled.

use std::error::Error as StdError;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Once;

use plotters::element::{BitMapElement, DashedPathElement};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, FontTransform, register_font};

use mics_run::{Error, Result};

type Drawn = std::result::Result<(), Box<dyn StdError + Send + Sync>>;

/// Sheet pixels per pixel of the figure.
pub const SCALE: i32 = 3;
/// Height of tick labels and legend text.
pub const SMALL: i32 = 20 * SCALE;
/// Height of axis labels.
pub const MEDIUM: i32 = 22 * SCALE;
/// Height of titles.
pub const LARGE: i32 = 25 * SCALE;
/// The colour of text, frames and ticks.
pub const INK: RGBColor = RGBColor(38, 38, 38);
/// Width of thin lines.
pub const THIN: u32 = SCALE as u32;
/// Length of a tick.
pub const TICK: i32 = 6 * SCALE;
/// Room between a tick and its text.
pub const GAP: i32 = 6 * SCALE;

/// A place on the sheet: from the left, from the top.
pub type Pixel = (i32, i32);

enum Shape {
    Line(Vec<Pixel>, ShapeStyle),
    /// With the length of its dashes and of the gaps between them.
    Dashes(Vec<Pixel>, ShapeStyle, Pixel),
    Area(Vec<Pixel>, ShapeStyle),
    Bitmap(Pixel, Pixel, Vec<u8>),
    Text(String, Pixel, Box<TextStyle<'static>>),
}

/// Shapes that have been drawn so far, for any backend.
#[derive(Default)]
pub struct Sheet(Vec<Shape>);

impl Sheet {
    /// A line through some places.
    pub fn line(&mut self, mut places: Vec<Pixel>, colour: RGBColor, width: u32) {
        places.dedup();
        self.0.push(Shape::Line(places, colour.stroke_width(width)));
    }

    /// A line through some places in dashes of a length with gaps of a length.
    pub fn dashed(&mut self, places: Vec<Pixel>, colour: RGBColor, width: u32, lengths: Pixel) {
        self.0.push(Shape::Dashes(places, colour.stroke_width(width), lengths));
    }

    /// A filled polygon.
    pub fn area(&mut self, places: Vec<Pixel>, colour: impl Color) {
        self.0.push(Shape::Area(places, colour.filled()));
    }

    /// A bitmap over a rectangle (its upper left corner, its width and height), its colours given
    /// by the part of its width and height from the lower left corner.
    pub fn bitmap(&mut self, corner: Pixel, extent: Pixel, colour: impl Fn(f64, f64) -> RGBColor) {
        let (width, height) = extent;
        let part = |k: i32, extent: i32| (f64::from(k) + 0.5) / f64::from(extent);
        let places = (0..height).rev().flat_map(|j| (0..width).map(move |i| (i, j)));
        let colours = places.map(|(i, j)| colour(part(i, width), part(j, height)));
        let bytes = colours.flat_map(|RGBColor(red, green, blue)| [red, green, blue]).collect();
        self.0.push(Shape::Bitmap(corner, extent, bytes));
    }

    /// A text anchored at a place.
    pub fn text(
        &mut self,
        text: &str,
        size: i32,
        at: Pixel,
        anchor: (HPos, VPos),
        turn: FontTransform,
    ) {
        register_fonts();
        let font = ("sans-serif", size).into_font().transform(turn);
        let style = font.color(&INK).pos(Pos::new(anchor.0, anchor.1));
        // Neither backend centres on the digits: both leave them too high.
        let down = if matches!(anchor.1, VPos::Center) { size * 3 / 20 } else { 0 };
        if !text.is_empty() {
            self.0.push(Shape::Text(text.to_owned(), (at.0, at.1 + down), Box::new(style)));
        }
    }

    /// A title centred at `x`, above a height.
    pub fn title(&mut self, text: &str, x: i32, above: i32) {
        let anchor = (HPos::Center, VPos::Bottom);
        self.text(text, LARGE, (x, above - 2 * GAP), anchor, FontTransform::None);
    }

    /// Writes a sheet of that width and height as `STEM.png` and `STEM.svg`, returns their paths.
    pub fn write(&self, size: Pixel, stem: &Path) -> Result<[PathBuf; 2]> {
        let size = ((size.0 / SCALE) as u32, (size.1 / SCALE) as u32);
        let paths = ["png", "svg"].map(|extension| {
            let mut name = stem.as_os_str().to_owned();
            name.push(format!(".{extension}"));
            PathBuf::from(name)
        });
        let wrap =
            |path, done: Drawn| done.map_err(|error| Error::io(path)(io::Error::other(error)));
        wrap(&paths[0], self.write_png(size, &paths[0]))?;
        wrap(&paths[1], self.write_svg(size, &paths[1]))?;
        Ok(paths)
    }

    fn draw<DB: DrawingBackend<ErrorType: 'static>>(&self, backend: DB, joins: bool) -> Drawn {
        let area = backend.into_drawing_area();
        area.fill(&WHITE)?;
        for shape in &self.0 {
            match shape {
                Shape::Line(places, style) => {
                    // Bitmaps join lines in a point, however long: a line that turns back is two.
                    let mut start = 0;
                    for middle in 1..places.len().saturating_sub(1) {
                        if !joins && turns_back(&places[middle - 1..=middle + 1]) {
                            area.draw(&PathElement::new(&places[start..=middle], *style))?;
                            start = middle;
                        }
                    }
                    area.draw(&PathElement::new(&places[start..], *style))?;
                }
                Shape::Dashes(places, style, (dash, gap)) => {
                    area.draw(&DashedPathElement::new(
                        places.iter().copied(),
                        *dash,
                        *gap,
                        *style,
                    ))?;
                }
                Shape::Area(places, style) => area.draw(&Polygon::new(&places[..], *style))?,
                Shape::Bitmap(corner, (width, height), bytes) => {
                    let size = (*width as u32, *height as u32);
                    let bitmap = BitMapElement::with_ref(*corner, size, bytes);
                    area.draw(&bitmap.ok_or("a bitmap smaller than its rectangle")?)?;
                }
                Shape::Text(text, at, style) => area.draw_text(text, style, *at)?,
            }
        }
        Ok(area.present()?)
    }

    fn write_png(&self, size: (u32, u32), path: &Path) -> Drawn {
        let pixels = self.pixels_of(size)?;
        let mut writer = encoder(BufWriter::new(File::create(path)?), size).write_header()?;
        writer.write_image_data(&pixels)?;
        Ok(writer.finish()?)
    }

    /// The pixels of a sheet of that width and height, three bytes each, and how many there are in
    /// width and height.
    pub fn pixels(&self, size: Pixel) -> Result<(Vec<u8>, (u32, u32))> {
        let size = ((size.0 / SCALE) as u32, (size.1 / SCALE) as u32);
        let drawn =
            self.pixels_of(size).map_err(|error| Error::io("a frame")(io::Error::other(error)));
        drawn.map(|pixels| (pixels, size))
    }

    fn pixels_of(
        &self,
        size: (u32, u32),
    ) -> std::result::Result<Vec<u8>, Box<dyn StdError + Send + Sync>> {
        let (width, height) = size;
        let scale = SCALE as usize;
        let row = width as usize * scale;
        let mut large = vec![0; row * height as usize * scale * 3];
        let size = (width * scale as u32, height * scale as u32);
        self.draw(BitMapBackend::with_buffer(&mut large, size), false)?;
        let mean = |k: usize| {
            let x = k / 3 % width as usize * scale;
            let y = k / 3 / width as usize * scale;
            let block = (0..scale * scale).map(|b| (y + b / scale) * row + x + b % scale);
            (block.map(|at| usize::from(large[3 * at + k % 3])).sum::<usize>() / (scale * scale))
                as u8
        };
        Ok((0..3 * (width * height) as usize).map(mean).collect())
    }

    fn write_svg(&self, size: (u32, u32), path: &Path) -> Drawn {
        Ok(std::fs::write(path, self.svg_text(size)?)?)
    }

    /// A sheet of that width and height as SVG text.
    pub fn svg(&self, size: Pixel) -> Result<String> {
        let size = ((size.0 / SCALE) as u32, (size.1 / SCALE) as u32);
        self.svg_text(size).map_err(|error| Error::io("a figure")(io::Error::other(error)))
    }

    fn svg_text(
        &self,
        size: (u32, u32),
    ) -> std::result::Result<String, Box<dyn StdError + Send + Sync>> {
        let (width, height) = size;
        let mut text = String::new();
        let scale = SCALE as u32;
        self.draw(SVGBackend::with_string(&mut text, (width * scale, height * scale)), true)?;
        let sized =
            |scale| format!(r#"<svg width="{}" height="{}""#, width * scale, height * scale);
        let rounded = format!(r#"{} stroke-linejoin="round""#, sized(1));
        let text = text.replacen(&sized(scale), &rounded, 1);
        // Plotters writes a media type that only some viewers forgive.
        Ok(text.replace("data:png;", "data:image/png;"))
    }
}

/// An encoder of pictures of that width and height.
pub fn encoder<W: Write>(to: W, size: (u32, u32)) -> png::Encoder<'static, W> {
    let mut encoder = png::Encoder::new(to, size.0, size.1);
    encoder.set_color(png::ColorType::Rgb);
    // Flat areas and lines are smaller by a third without the filters that photographs want.
    encoder.set_compression(png::Compression::Default);
    encoder.set_filter(png::FilterType::NoFilter);
    encoder.set_adaptive_filter(png::AdaptiveFilterType::NonAdaptive);
    encoder
}

fn turns_back(corner: &[Pixel]) -> bool {
    let step = |k: usize| (corner[k + 1].0 - corner[k].0, corner[k + 1].1 - corner[k].1);
    step(0).0 * step(1).0 + step(0).1 * step(1).1 < 0
}

fn register_fonts() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        for style in [FontStyle::Normal, FontStyle::Bold] {
            // A font that cannot be read shows as an error of the first text drawn.
            let _ = register_font("sans-serif", style, epaint_default_fonts::UBUNTU_LIGHT);
        }
    });
}

/// Width of a text on the sheet.
pub fn width(text: &str, size: i32) -> i32 {
    register_fonts();
    ("sans-serif", size).into_font().box_size(text).map_or(0, |(width, _)| width as i32)
}

/// The outline of a rectangle, closed.
pub fn ring(corner: Pixel, extent: Pixel) -> Vec<Pixel> {
    let (x, y) = corner;
    let (width, height) = extent;
    vec![(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)]
}
