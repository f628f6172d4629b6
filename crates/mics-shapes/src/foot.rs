//! The points of corners, edges and faces that stand fixed which are nearest to a part of a body.

use crate::beside::Beside;
use crate::near::{Foot, around, foot_of_ball};
use crate::part::{Core, Part};
use crate::placed::{Placed, Pose};
use crate::polytope;
use nalgebra::Vector3;

/// That of the simplex with these corners (m) of a face with this normal, where the gap is less
/// than `most` (m).
pub(crate) fn foot(
    part: &Part,
    pose: &Pose,
    simplex: &[Vector3<f64>],
    normal: &Vector3<f64>,
    most: f64,
) -> Option<Foot> {
    let placed = Placed::new(part, pose);
    let found = match &part.core {
        Core::Polytope(polytope) => {
            return polytope::foot(polytope, &placed, part.rounding, (simplex, normal), most);
        }
        _ => match Beside::new(placed) {
            Some(beside) => beside.foot(simplex, normal),
            None => foot_of_ball(&placed.place, part.rounding, simplex, normal),
        },
    };
    (found.gap < most).then_some(found)
}

/// The least that the gap of a part to a face of these corners can be (m).
pub(crate) fn least_gap(part: &Part, placed: &Placed<'_>, corners: &[Vector3<f64>]) -> f64 {
    let (middle, reach) = around(corners);
    let gap = match &part.core {
        Core::Polytope(polytope) => {
            let back = placed.orientation.inverse_transform_vector(&(middle - placed.place));
            polytope.height(&back) - part.rounding
        }
        _ => match Beside::new(*placed) {
            Some(beside) => beside.foot(&[middle], &Vector3::zeros()).gap,
            None => (middle - placed.place).norm() - part.rounding,
        },
    };
    gap - reach
}
