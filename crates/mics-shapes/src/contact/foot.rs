//! The points of corners, edges and faces that stand fixed which are nearest to a part of a body.

use crate::contact::beside::Beside;
use crate::contact::near::{Foot, around, foot_of_ball};
use crate::contact::part::{Core, Part};
use crate::contact::polytope;
use crate::contact::pose::{Placed, Pose};
use nalgebra::Vector3;

/// The foot on the simplex with these corners (m) of a face with this normal, where the gap is less
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
            return polytope::foot(polytope, &placed, part.rounding, simplex, normal, most);
        }
        _ => match Beside::new(placed) {
            Some(beside) => beside.foot(simplex, normal),
            None => foot_of_ball(&placed.place, part.rounding, simplex, normal),
        },
    };
    (found.gap < most).then_some(found)
}

/// The foot at the middle of a face of these corners (m), and by how much others are nearer at most
/// (m).
pub(crate) fn at_middle(part: &Part, placed: &Placed<'_>, corners: &[Vector3<f64>]) -> (Foot, f64) {
    let (middle, reach) = around(corners);
    let found = match &part.core {
        Core::Polytope(polytope) => {
            let back = placed.orientation.inverse_transform_vector(&(middle - placed.place));
            let (distance, away) = polytope.beside(&back);
            let up = -(placed.orientation * away);
            Foot { gap: distance - part.rounding, up, place: middle }
        }
        _ => match Beside::new(*placed) {
            Some(beside) => beside.foot(&[middle], &Vector3::zeros()),
            None => foot_of_ball(&placed.place, part.rounding, &[middle], &Vector3::zeros()),
        },
    };
    (found, reach)
}
