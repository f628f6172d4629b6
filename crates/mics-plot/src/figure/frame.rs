//! The rectangle of a plot on the sheet, with its axes.

use super::axis::Axis;
use super::canvas::{GAP, INK, MEDIUM, Pixel, SMALL, Sheet, THIN, TICK, ring};
use plotters::prelude::*;
use plotters::style::FontTransform;
use plotters::style::text_anchor::{HPos, VPos};

/// Room that a horizontal axis needs below the plot.
pub const BELOW: i32 = TICK + GAP + SMALL + GAP + MEDIUM;

/// A plot's rectangle on the sheet with its two axes.
pub struct Frame {
    /// Upper left corner.
    pub corner: Pixel,
    /// Width and height.
    pub extent: Pixel,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
}

impl Frame {
    /// Where a point of the plot is on the sheet.
    pub fn pixel(&self, x: f64, y: f64) -> Pixel {
        let place = |corner: i32, extent: i32, fraction: f64| {
            corner + (fraction.clamp(-1.0, 2.0) * f64::from(extent)).round() as i32
        };
        (
            place(self.corner.0, self.extent.0, self.x.fraction(x)),
            place(self.corner.1, self.extent.1, 1.0 - self.y.fraction(y)),
        )
    }

    /// Draws grid lines across the plot.
    pub fn grid(&self, sheet: &mut Sheet) {
        let (left, top) = self.corner;
        let (width, height) = self.extent;
        let vertical = self.x.named().map(|tick| self.pixel(tick.0, 0.0).0);
        let vertical = vertical.map(|x| vec![(x, top), (x, top + height)]);
        let level = self.y.named().map(|tick| self.pixel(0.0, tick.0).1);
        let level = level.map(|y| vec![(left, y), (left + width, y)]);
        vertical.chain(level).for_each(|line| sheet.line(line, RGBColor(225, 225, 225), THIN));
    }

    /// Draws the frame, ticks and labels; `right` puts the vertical axis on the right.
    pub fn axes(&self, sheet: &mut Sheet, right: bool) {
        let (left, top) = self.corner;
        let (width, height) = self.extent;
        let below = top + height + TICK + GAP;
        let centred = (HPos::Center, VPos::Top);
        let long = |label: &str| if label.is_empty() { TICK / 2 } else { TICK };
        for (value, label) in &self.x.ticks {
            let x = self.pixel(*value, 0.0).0;
            sheet.line(vec![(x, top + height), (x, top + height + long(label))], INK, THIN);
            sheet.text(label, SMALL, (x, below), centred, FontTransform::None);
        }
        let at = (left + width / 2, below + SMALL + GAP);
        sheet.text(&self.x.label, MEDIUM, at, centred, FontTransform::None);

        let (side, out, anchor) =
            if right { (left + width, 1, HPos::Left) } else { (left, -1, HPos::Right) };
        for (value, label) in &self.y.ticks {
            let y = self.pixel(0.0, *value).1;
            if !self.y.names {
                sheet.line(vec![(side, y), (side + out * long(label), y)], INK, THIN);
            }
            let at = (side + out * (TICK + GAP), y);
            sheet.text(label, SMALL, at, (anchor, VPos::Center), FontTransform::None);
        }
        if self.y.names {
            let at = (left, top - GAP);
            return sheet.text(
                &self.y.label,
                SMALL,
                at,
                (HPos::Left, VPos::Bottom),
                FontTransform::None,
            );
        }
        let edge = side + out * self.y.room() - if right { MEDIUM } else { 0 };
        let at = (edge, top + height / 2);
        sheet.text(&self.y.label, MEDIUM, at, centred, FontTransform::Rotate270);
        sheet.line(ring(self.corner, self.extent), INK, THIN);
    }
}
