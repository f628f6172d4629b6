//! Figures: data in, `STEM.png` and `STEM.svg` out. Owns what a figure looks like; knows nothing of runs or cases.
//!
//! [`vorticity`] and [`streamlines`] draw a plane of the flow, [`vorticity_strip`] and [`streamlines_strip`] several of one
//! scene side by side, [`curves()`] draws series over axes. `canvas` turns one description into both files; `field`, `strip`
//! and `curves` describe, with what `paint` knows of flows; `trace` finds evenly spaced streamlines, `contour` contour lines.

mod canvas;
mod contour;
mod curves;
mod field;
mod paint;
mod strip;
mod trace;

pub use curves::{curves, curves_svg};
pub use field::{streamlines, streamlines_svg, vorticity, vorticity_svg};
pub use strip::{streamlines_strip, vorticity_strip};

/// A plane cut of the flow for drawing: cell values, x fastest.
#[derive(Debug, Clone, Default)]
pub struct Plane {
    /// Cells along the two axes of the plane.
    pub cells: [usize; 2],
    /// Extent along the two axes; places are from the lower left corner.
    pub size: [f64; 2],
    /// What the axes say at the lower left corner.
    pub corner: [f64; 2],
    /// Velocity along the first axis at cell centres.
    pub u: Vec<f64>,
    /// Velocity along the second axis at cell centres.
    pub v: Vec<f64>,
    /// Vorticity at cell centres; not a number where there is none.
    pub vorticity: Vec<f64>,
    /// Particles as the plane cuts them.
    pub discs: Vec<Disc>,
    /// Axis labels, such as `x (m)`.
    pub labels: [String; 2],
    /// Title above the figure; may be empty.
    pub title: String,
    /// Where the plane cuts a 3D flow, such as `, z = 0.02 m`; empty in 2D.
    pub place: String,
}

/// A particle as a plane cuts it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Disc {
    /// Centre in the plane's own coordinates.
    pub centre: [f64; 2],
    /// Radius of the cut.
    pub radius: f64,
    /// Its grey, from 0 (light) to 1 (dark).
    pub shade: f64,
    /// The number that is written on it where there is room; `None` of one that is alone.
    pub number: Option<usize>,
}

/// One series of a line or point figure.
#[derive(Debug, Clone)]
pub struct Series {
    /// Its entry in the legend; empty for none.
    pub label: String,
    /// Points in drawing order. One that cannot be placed (NaN, or not positive on a log axis) is a gap.
    pub points: Vec<(f64, f64)>,
    /// How the points are drawn.
    pub style: SeriesStyle,
}

/// How a series is drawn. Colours and marker shapes follow from the order of the series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeriesStyle {
    /// A solid line through the points.
    Line,
    /// A dashed line through the points, for formulas and references.
    Dashed,
    /// A marker at each point.
    Markers,
    /// A marker at each point, and a thin line from one to the next.
    Joined,
    /// A grey rectangle between the first and the last point, for a range that something is expected in.
    Band,
}

/// The axes of a line or point figure.
#[derive(Debug, Clone, Default)]
pub struct Axes {
    /// Label of the horizontal axis.
    pub x_label: String,
    /// Label of the vertical axis.
    pub y_label: String,
    /// Whether the horizontal axis is logarithmic.
    pub log_x: bool,
    /// Whether the vertical axis is logarithmic.
    pub log_y: bool,
    /// Whether the horizontal axis runs from its high end to its low end.
    pub falling_x: bool,
    /// Title above the figure; may be empty.
    pub title: String,
    /// A box from the origin to these edges, drawn to scale, that the axes show whatever the points.
    pub frame: Option<[f64; 2]>,
}

#[cfg(test)]
mod tests;
