//! Options of pictures of the flow that `mics plot` and `mics film` share: what is shown, and how.

use super::discs::Bodies;
use super::{Run, fields};
use crate::figure::{Plane, Quantity, Style};
use mics_run::config::Section;
use mics_run::{Error, Result};
use std::ops::RangeInclusive;

/// Pixels of the longer side of the flow that can be asked for.
const PIXELS: RangeInclusive<u32> = 60..=4000;

/// Options of pictures of the flow: what they show, and how.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct View {
    /// Quantity that the colours of the flow show [default: vorticity].
    #[arg(long, value_name = "FIELD")]
    pub field: Option<Quantity>,
    /// Quantity that the colours of the bodies show [default: size].
    #[arg(long, value_name = "WHAT")]
    pub bodies: Option<Bodies>,
    /// Show this part of the flow only: from and to along the axis to the right, then along the one
    /// up (m).
    #[arg(long, value_name = "X0,X1,Y0,Y1", value_delimiter = ',', allow_hyphen_values = true)]
    pub window: Vec<f64>,
    /// Cut a 3D flow here, e.g. z=0.02 (m), in the layer of cells that holds it [default: the
    /// case's output.planes, or along gravity or the stream through the bodies].
    #[arg(long, value_name = "AXIS=PLACE")]
    pub plane: Option<Section>,
    /// The values of the first and the last colour [default: those of the flow without its
    /// outermost hundredth, of a speed thousandth].
    #[arg(long, value_name = "LOW,HIGH", value_delimiter = ',', allow_hyphen_values = true)]
    pub range: Vec<f64>,
    /// Pixels of the longer side of the flow, of all panels together in a strip [default: 1000, of
    /// a film 600].
    #[arg(long, value_name = "PIXELS")]
    pub size: Option<u32>,
}

impl View {
    /// Refuses what no run can be shown by.
    pub(crate) fn check(&self) -> Result<()> {
        let refuse = |why: String| Err(Error::Usage(why));
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        if !self.window.is_empty() && (self.window.len() != 4 || !finite(&self.window)) {
            return refuse(format!(
                "--window {:?}: give X0,X1,Y0,Y1 in m, as in --window 0.4,2.4,0.4,1.2",
                self.window
            ));
        }
        let rises = |range: &[f64]| matches!(range, [low, high] if low < high) && finite(range);
        if !self.range.is_empty() && !rises(&self.range) {
            return refuse(format!(
                "--range {:?}: give the values of the first and the last colour, the lower one \
                first, as in --range=-20,20",
                self.range
            ));
        }
        match self.size.filter(|size| !PIXELS.contains(size)) {
            Some(size) => {
                refuse(format!("--size {size}: give {} to {} pixels", PIXELS.start(), PIXELS.end()))
            }
            None => Ok(()),
        }
    }

    /// Refuses a plane that a run does not have.
    pub(super) fn fits(&self, run: &Run) -> Result<()> {
        let Some(plane) = self.plane else { return Ok(()) };
        let folder = run.folder.display();
        let (axis, at) = plane.place();
        let why = match run.case.domain.size.get(axis).filter(|_| run.case.dimension() == 3) {
            None => format!("{folder} is in 2D, and figures show all of it"),
            Some(size) if !(0.0..=*size).contains(&at) => {
                format!("the box of {folder} goes from 0 to {size} m")
            }
            Some(_) => return Ok(()),
        };
        Err(Error::Usage(format!("--plane {plane}: {why}")))
    }

    /// Style in which a plane is drawn.
    pub(super) fn style(&self) -> Style {
        let range = if let [low, high] = self.range[..] { Some([low, high]) } else { None };
        Style { range, size: self.size }
    }

    /// The part of a plane that is asked for.
    pub(super) fn part(&self, plane: Plane) -> Result<Plane> {
        if let [a, b, c, d] = self.window[..] {
            fields::cut(plane, [a, b, c, d])
        } else {
            Ok(plane)
        }
    }
}
