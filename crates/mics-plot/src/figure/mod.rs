//! Figures: data in, `STEM.png` and `STEM.svg` out. Owns what a figure looks like; knows nothing of
//! runs or cases.
//!
//! [`vorticity`], [`streamlines`] and [`field()`] draw a plane of the flow, [`vorticity_strip`],
//! [`streamlines_strip`] and [`field_strip`] several of one scene side by side, [`film()`] one
//! after the other, [`curves()`] draws series over axes and [`chart()`] several such plots in one
//! figure. `canvas` turns one description into both files, or into a frame; `field`, `strip`,
//! `film` and `curves` describe, in `frame`s with `axis`es, with what `paint` knows of flows;
//! `trace` finds evenly spaced streamlines, `contour` contour lines.

mod axis;
mod canvas;
mod contour;
mod curves;
mod cut;
mod field;
mod film;
mod frame;
mod paint;
mod strip;
mod trace;

pub use curves::{COLOURS, chart, chart_svg, curves, curves_svg};
#[cfg(test)]
pub(crate) use cut::area;
pub use cut::{Disc, in_plane};
pub use field::{field, streamlines, streamlines_svg, vorticity, vorticity_svg};
pub use film::{Format, film};
pub use paint::shared_range;
pub use strip::{field_strip, streamlines_strip, vorticity_strip};

/// A plane cut of the flow for drawing: cell values, x fastest.
#[derive(Debug, Clone, Default)]
pub struct Plane {
    /// Cells along the two axes of the plane.
    pub cells: [usize; 2],
    /// Extent along the two axes; places are from the lower left corner.
    pub size: [f64; 2],
    /// Coordinates that the axes show at the lower left corner.
    pub corner: [f64; 2],
    /// Velocity along the two axes at cell centres.
    pub velocity: [Vec<f64>; 2],
    /// Values at cell centres that colours show; not a number where there is none.
    pub values: Vec<f64>,
    /// Quantity of the values.
    pub quantity: Quantity,
    /// Particles as the plane cuts them.
    pub discs: Vec<Disc>,
    /// Meaning of the particles' colours; where it is absent they are grey and say nothing.
    pub scale: Option<Scale>,
    /// Range of the colours and size of the figure.
    pub style: Style,
    /// Axis labels, such as `x (m)`.
    pub labels: [String; 2],
    /// Title above the figure; may be empty.
    pub title: String,
    /// Where the plane cuts a 3D flow, such as `, z = 0.02 m`; empty in 2D.
    pub place: String,
}

/// Quantity that a plane shows in colours.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Quantity {
    /// Vorticity (1/s), in 3D its part across the plane, positive counterclockwise.
    #[default]
    Vorticity,
    /// Speed (m/s), of all components of the velocity.
    Speed,
    /// Pressure (Pa), without the weight of the fluid.
    Pressure,
}

impl Quantity {
    /// Its name on the command line and of files.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Vorticity => "vorticity",
            Quantity::Speed => "speed",
            Quantity::Pressure => "pressure",
        }
    }

    /// Label of its colour bar, with the unit.
    fn label(self) -> &'static str {
        match self {
            Quantity::Vorticity => "vorticity (1/s)",
            Quantity::Speed => "speed (m/s)",
            Quantity::Pressure => "pressure (Pa)",
        }
    }
}

impl Plane {
    /// The plane with fewer cells, about so many along each axis at most, each with the values of
    /// one of its own.
    pub fn sampled(&self, most: usize) -> Plane {
        let [columns, rows] =
            self.cells.map(|count| (0..count).step_by(count.div_ceil(most).max(1)));
        let of = |values: &[f64]| {
            let row = |j: usize| {
                columns.clone().filter_map(move |i| values.get(j * self.cells[0] + i).copied())
            };
            rows.clone().flat_map(row).collect()
        };
        let cells = [columns.len(), rows.len()];
        let velocity = self.velocity.each_ref().map(|part| of(part));
        Plane { cells, velocity, values: of(&self.values), ..self.clone() }
    }
}

/// Range of the colours and size of a plane's figure.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Style {
    /// The values of the first and the last colour; by default what there is, without its outermost
    /// hundredth.
    pub range: Option<[f64; 2]>,
    /// Pixels of the longer side of the flow, of all panels together in a strip; by default what
    /// suits a page.
    pub size: Option<u32>,
}

/// Meaning of the particles' colours.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scale {
    /// Label of the colour bar.
    pub label: String,
    /// The values of the lightest and the darkest colour; there is no bar or legend where they are
    /// the same.
    pub range: [f64; 2],
    /// Names of values, where these are few: then there is a legend in place of a colour bar.
    pub names: Vec<(f64, String)>,
    /// Whether the colours are greys.
    pub grey: bool,
}

/// One series of a line or point figure.
#[derive(Debug, Clone)]
pub struct Series {
    /// Its entry in the legend; empty for none.
    pub label: String,
    /// Points in drawing order. One that cannot be placed (NaN, or not positive on a log axis) is a
    /// gap.
    pub points: Vec<(f64, f64)>,
    /// Style in which the points are drawn.
    pub style: SeriesStyle,
}

/// Style of a series. Colours and marker shapes follow from the order of the series.
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
    /// A grey rectangle between the first and the last point, for a range that something is
    /// expected in.
    Band,
    /// A pale area with the points as its outline, in the colour of the series before it, whose
    /// spread it shows. It has no entry in the legend.
    Spread,
    /// A grey line, for the outline of an obstacle. It has no entry in the legend.
    Wall,
}

impl SeriesStyle {
    /// Whether it is drawn under all lines, with no colour of its own and no entry in the legend.
    fn is_under(self) -> bool {
        matches!(self, SeriesStyle::Spread | SeriesStyle::Wall)
    }
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
    /// Whether the horizontal axis counts: its ticks are whole numbers.
    pub whole_x: bool,
    /// Whether the horizontal axis runs from its high end to its low end.
    pub falling_x: bool,
    /// Title above the figure; may be empty.
    pub title: String,
    /// Small print under the title; may be empty.
    pub note: String,
    /// The ends of the vertical axis, where they are not those of the points; what lies beyond is
    /// cut off there.
    pub range_y: Option<[f64; 2]>,
    /// A box from the origin to these edges, drawn to scale, that the axes show whatever the
    /// points.
    pub frame: Option<[f64; 2]>,
}

/// Plots in one figure: below each other over one horizontal axis, or beside each other.
#[derive(Debug, Clone, Default)]
pub struct Chart {
    /// The plots; title and note of the figure are the first one's.
    pub panels: Vec<(Axes, Vec<Series>)>,
    /// Whether the plots stand beside each other.
    pub beside: bool,
}

impl From<(Axes, Vec<Series>)> for Chart {
    fn from(panel: (Axes, Vec<Series>)) -> Chart {
        Chart { panels: vec![panel], beside: false }
    }
}

impl Chart {
    /// Whether some line of it has two points.
    pub fn shows(&self) -> bool {
        self.panels.iter().flat_map(|(_, series)| series).any(|one| one.points.len() > 1)
    }
}

#[cfg(test)]
mod tests;
