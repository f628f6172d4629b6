//! Orientation of a body, as it is typed.

use crate::config::fault::{Check, finite};
use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Rotation of a body's own axes from those of the box: degrees in 2D, counterclockwise; about an
/// axis, or by a quaternion, in 3D.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "an orientation is degrees in 2D, and { axis = [0, 0, 1], degrees = 30 } or { \
                 quaternion = [w, x, y, z] } in 3D"
)]
pub enum Orientation {
    /// Counterclockwise (degrees), 2D.
    Plane(f64),
    /// About an axis, 3D.
    About(About),
    /// By a quaternion, 3D.
    By(By),
}

/// A turn about an axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct About {
    /// The axis, of any length.
    pub axis: [f64; 3],
    /// The angle (degrees), right-handed.
    pub degrees: f64,
}

/// A turn by a quaternion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct By {
    /// w, x, y, z, as `particles.csv` has them; of length 1, but for rounding.
    pub quaternion: [f64; 4],
}

/// Largest deviation of a quaternion's length from 1.
const WORN: f64 = 1e-3;

impl Orientation {
    /// A turn by a quaternion.
    pub fn by(turn: &UnitQuaternion<f64>) -> Orientation {
        Orientation::By(By { quaternion: [turn.w, turn.i, turn.j, turn.k] })
    }

    /// Rotation from the body's own axes to those of the box.
    pub fn quaternion(&self) -> UnitQuaternion<f64> {
        match self {
            Orientation::Plane(degrees) => {
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), degrees.to_radians())
            }
            Orientation::About(About { axis, degrees }) => UnitQuaternion::from_axis_angle(
                &Unit::new_normalize(Vector3::from(*axis)),
                degrees.to_radians(),
            ),
            Orientation::By(By { quaternion: [w, x, y, z] }) => {
                UnitQuaternion::new_normalize(Quaternion::new(*w, *x, *y, *z))
            }
        }
    }

    /// The angle (rad) about z by which it is turned in 2D.
    pub fn angle(&self) -> f64 {
        if let Orientation::Plane(degrees) = self { degrees.to_radians() } else { 0.0 }
    }

    /// Checks it under `key`.
    pub(super) fn check(&self, key: &str, dimension: usize) -> Check {
        let (numbers, fits): (&[f64], bool) = match self {
            Orientation::Plane(degrees) => (std::slice::from_ref(degrees), dimension == 2),
            Orientation::About(about) => (&about.axis, dimension == 3),
            Orientation::By(by) => (&by.quaternion, dimension == 3),
        };
        ensure!(
            fits,
            key,
            "is one number in 2D (degrees), and {{ axis = [0, 0, 1], degrees = 30 }} or {{ \
            quaternion = [w, x, y, z] }} in 3D; this case is {dimension}D"
        );
        finite(key, numbers, "an orientation")?;
        let length = numbers.iter().map(|x| x * x).sum::<f64>().sqrt();
        match self {
            Orientation::Plane(_) => Ok(()),
            Orientation::About(About { degrees, .. }) => {
                finite(&format!("{key}.degrees"), &[*degrees], "degrees")?;
                ensure!(
                    length > 1e-12,
                    format!("{key}.axis"),
                    "has no length: name a direction, as in [0, 0, 1]"
                );
                Ok(())
            }
            Orientation::By(_) => {
                ensure!(
                    (length - 1.0).abs() < WORN,
                    format!("{key}.quaternion"),
                    "must have the length 1, not {length:.4}: divide its numbers by that"
                );
                Ok(())
            }
        }
    }
}
