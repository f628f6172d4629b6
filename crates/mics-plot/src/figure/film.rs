//! Films: planes of one scene one after the other as an animated PNG, which browsers and most
//! viewers play, others show its first frame; or as a GIF, which slides and chats play as well.
//!
//! A film has at most 256 colours, which are chosen before it begins: those of its colour bars,
//! each of the particles' marked and not, and greys. That is a third of the bytes of all colours,
//! and no difference to the eye. Each frame keeps only the rectangle in which it differs from the
//! one before.

use std::error::Error as StdError;
use std::io::{self, Write};
use std::path::Path;

use png::{ColorType, DisposeOp};

use super::Plane;
use super::canvas::encoder;
use super::field::draw_field;
use super::paint;
use mics_run::{Error, Result};

/// Frames a second are kept as a fraction with this numerator.
const TICKS: u16 = 100;
/// Bits of each of red, green and blue by which a colour is looked up.
const BITS: u32 = 6;

/// Files that a film can be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Animated PNG.
    Png,
    /// GIF, whose frames last whole hundredths of a second, two or more.
    Gif,
}

/// Draws `count` planes of one size and style, each as it comes, and writes them as an animated
/// picture that repeats for ever: `rate` frames a second (0.01 to 100), with room for a title of
/// the width of `widest`. Errors name `path`, which is not touched.
///
/// # Errors
/// When there are more or fewer planes, one is an error or cannot be drawn, or `to` cannot be
/// written to.
pub fn film(
    to: &mut dyn Write,
    format: Format,
    path: &Path,
    mut planes: impl Iterator<Item = Result<Plane>>,
    count: usize,
    widest: &str,
    rate: f64,
) -> Result<()> {
    let failed = |error: Failure| Error::io(path)(io::Error::other(error));
    let none =
        || Error::io(path)(io::Error::new(io::ErrorKind::InvalidInput, "a film of no frames"));
    let frame = |plane: &Plane, inks: &Inks| -> Result<Frame> {
        let (sheet, size) = draw_field(plane, widest, path)?;
        let (pixels, size) = sheet.pixels(size)?;
        Ok(Frame {
            pixels: pixels.chunks_exact(3).map(|colour| inks.nearest(colour)).collect(),
            size,
        })
    };
    let first = planes.next().ok_or_else(none)??;
    let inks = Inks::new(&first);
    let mut last = frame(&first, &inks)?;
    let mut writer = Writer::start(to, format, &inks, last.size, count, rate).map_err(failed)?;
    writer.add(&last, (0, 0), last.size).map_err(failed)?;
    for plane in planes {
        let next = frame(&plane?, &inks)?;
        let (corner, extent) = last.differs(&next);
        writer.add(&next, corner, extent).map_err(failed)?;
        last = next;
    }
    writer.finish().map_err(failed)
}

/// The error of an encoder.
type Failure = Box<dyn StdError + Send + Sync>;

/// A film that is being written.
enum Writer<'a> {
    Png(png::Writer<&'a mut dyn Write>),
    /// With the time that a frame lasts (1/100 s).
    Gif(gif::Encoder<&'a mut dyn Write>, u16),
}

impl<'a> Writer<'a> {
    /// Begins a film of `count` frames, `rate` of them a second.
    fn start(
        to: &'a mut dyn Write,
        format: Format,
        inks: &Inks,
        size: (u32, u32),
        count: usize,
        rate: f64,
    ) -> std::result::Result<Writer<'a>, Failure> {
        let palette = inks.colours.concat();
        if format == Format::Gif {
            let mut encoder =
                gif::Encoder::new(to, u16::try_from(size.0)?, u16::try_from(size.1)?, &palette)?;
            encoder.set_repeat(gif::Repeat::Infinite)?;
            return Ok(Writer::Gif(encoder, (f64::from(TICKS) / rate).round().max(2.0) as u16));
        }
        let mut encoder = encoder(to, size);
        encoder.set_color(ColorType::Indexed);
        encoder.set_palette(palette);
        encoder.set_animated(u32::try_from(count).unwrap_or(u32::MAX), 0)?;
        encoder.set_frame_delay(TICKS, (rate * f64::from(TICKS)).round().max(1.0) as u16)?;
        encoder.set_dispose_op(DisposeOp::None)?;
        Ok(Writer::Png(encoder.write_header()?))
    }

    /// Adds a rectangle of a frame.
    fn add(
        &mut self,
        frame: &Frame,
        corner: (u32, u32),
        extent: (u32, u32),
    ) -> std::result::Result<(), Failure> {
        let width = frame.size.0 as usize;
        let rows = (corner.1..corner.1 + extent.1).map(|y| y as usize * width + corner.0 as usize);
        let part: Vec<u8> =
            rows.flat_map(|from| &frame.pixels[from..from + extent.0 as usize]).copied().collect();
        match self {
            Writer::Png(writer) => {
                // A rectangle that fits at every moment: the corner first to the origin.
                writer.set_frame_position(0, 0)?;
                writer.set_frame_dimension(extent.0, extent.1)?;
                writer.set_frame_position(corner.0, corner.1)?;
                writer.write_image_data(&part)?;
            }
            Writer::Gif(encoder, delay) => {
                let frame = gif::Frame {
                    delay: *delay,
                    dispose: gif::DisposalMethod::Keep,
                    left: u16::try_from(corner.0)?,
                    top: u16::try_from(corner.1)?,
                    width: u16::try_from(extent.0)?,
                    height: u16::try_from(extent.1)?,
                    buffer: part.into(),
                    ..gif::Frame::default()
                };
                encoder.write_frame(&frame)?;
            }
        }
        Ok(())
    }

    /// Ends the film.
    fn finish(self) -> std::result::Result<(), Failure> {
        match self {
            Writer::Png(writer) => writer.finish()?,
            Writer::Gif(encoder, _) => encoder.into_inner()?.flush()?,
        }
        Ok(())
    }
}

/// The colours of a film.
struct Inks {
    colours: Vec<[u8; 3]>,
    /// The number of the nearest one, by the first bits of red, green and blue.
    nearest: Vec<u8>,
}

impl Inks {
    /// The colours that frames like a plane are drawn in.
    fn new(plane: &Plane) -> Inks {
        let colours: Vec<[u8; 3]> =
            paint::inks(plane).iter().map(|ink| [ink.0, ink.1, ink.2]).collect();
        let nearest = |place: u32| {
            // The middle of all that are looked up here.
            let channel = |k: u32| {
                (((place >> (BITS * k)) % (1 << BITS)) << (8 - BITS)) as i32 + (1 << (7 - BITS))
            };
            let wanted = [channel(2), channel(1), channel(0)];
            let off =
                |ink: &[u8; 3]| (0..3).map(|k| (i32::from(ink[k]) - wanted[k]).pow(2)).sum::<i32>();
            let best = colours.iter().enumerate().min_by_key(|(_, ink)| off(ink));
            best.map_or(0, |(number, _)| number as u8)
        };
        Inks { nearest: (0..1 << (3 * BITS)).map(nearest).collect(), colours }
    }

    /// The number of the colour that is nearest to one in red, green and blue.
    fn nearest(&self, colour: &[u8]) -> u8 {
        let place = colour
            .iter()
            .fold(0, |place, channel| place << BITS | usize::from(channel >> (8 - BITS)));
        self.nearest[place]
    }
}

/// The pixels of a frame, as numbers of colours, and how many there are in width and height.
struct Frame {
    pixels: Vec<u8>,
    size: (u32, u32),
}

impl Frame {
    /// The corner and the extent of the rectangle in which another frame of the same size differs,
    /// a pixel where none does.
    fn differs(&self, other: &Frame) -> ((u32, u32), (u32, u32)) {
        let width = self.size.0 as usize;
        let rows = || self.pixels.chunks_exact(width).zip(other.pixels.chunks_exact(width));
        let mut left = width;
        let mut right = 0;
        let mut top = usize::MAX;
        let mut bottom = 0;
        for (y, (a, b)) in rows().enumerate().filter(|(_, (a, b))| a != b) {
            let apart = |k: &usize| a[*k] != b[*k];
            left = (0..left).find(apart).unwrap_or(left);
            right = (right..width).rfind(apart).unwrap_or(right);
            top = top.min(y);
            bottom = y;
        }
        if top > bottom {
            return ((0, 0), (1, 1));
        }
        ((left as u32, top as u32), ((right - left + 1) as u32, (bottom - top + 1) as u32))
    }
}
