//! Two that could meet within a step, and what they have given each other in it.

use super::lubrication::Lubrication;
use crate::particles::Body;
use nalgebra::Vector3;

/// Two that could meet within the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub(super) first: usize,
    /// A body, or the number of bodies plus that of a wall.
    pub(super) second: usize,
    /// Which image of the second body it is: whole periods from its path to that of the image,
    /// along each axis.
    pub(super) image: Vector3<f64>,
    /// Which parts of both; 0 of round bodies and of walls, of an obstacle the face that holds the
    /// contact, or did so last.
    pub(super) parts: [usize; 2],
    /// Which of the regions of obstacles it is, where the second is one.
    pub(super) region: usize,
    /// Tangential spring (m), while they touch, and that of their rolling (rad).
    pub(super) spring: Option<Vector3<f64>>,
    pub(super) rolled: Vector3<f64>,
    /// Impulse on the first and angular impulses on both over the step, by touch and lubrication (N
    /// s, N m s).
    pub(super) impulse: Vector3<f64>,
    pub(super) turns: [Vector3<f64>; 2],
    /// Normal impulse over the step, by touch and lubrication, positive where it parts the two (N
    /// s).
    pub(super) normal: f64,
    /// Of touch alone: tangential impulse on the first, normal impulse, in all and while the two
    /// stick (N s), and its time (s).
    pub(super) tangential: Vector3<f64>,
    pub(super) normal_impulse: f64,
    pub(super) stuck: f64,
    pub(super) touched: f64,
    /// Energy in the springs at the start of the step (J).
    pub(super) stored: f64,
    /// What the fluid between them resists, after how many substeps each, and for how long (s) it
    /// has not yet.
    pub(super) lubrication: Lubrication,
    pub(super) stride: usize,
    pub(super) due: f64,
    /// The normal that it met with last in the step, zero before it did: where the search for the
    /// next one starts.
    pub(super) seen: Vector3<f64>,
    /// They cannot touch before the two have gone so far since the search, together (m).
    pub(super) clear: f64,
}

impl Pair {
    /// The region of a pair of which none was searched for yet.
    pub(super) const NO_REGION: usize = usize::MAX;

    pub(super) fn new(first: usize, second: usize, image: Vector3<f64>) -> Pair {
        Pair {
            first,
            second,
            image,
            parts: [0; 2],
            region: Pair::NO_REGION,
            spring: None,
            rolled: Vector3::zeros(),
            impulse: Vector3::zeros(),
            turns: [Vector3::zeros(); 2],
            normal: 0.0,
            tangential: Vector3::zeros(),
            normal_impulse: 0.0,
            stuck: 0.0,
            touched: 0.0,
            stored: 0.0,
            lubrication: Lubrication::UNKNOWN,
            stride: 1,
            due: 0.0,
            seen: Vector3::zeros(),
            clear: 0.0,
        }
    }

    /// Counts an impulse on the first (N s), and angular impulses on both (N m s).
    pub(super) fn add(&mut self, impulse: Vector3<f64>, turns: [Vector3<f64>; 2]) {
        self.impulse += impulse;
        self.turns.iter_mut().zip(turns).for_each(|(sum, turn)| *sum += turn);
    }

    /// Whether the second is an image of the first itself.
    pub(super) fn is_own_image(&self) -> bool {
        self.first == self.second
    }

    /// From the centre of the first body to that of the image of the second (m).
    pub(super) fn apart(&self, bodies: &[Body], periods: &[Option<f64>; 3]) -> Vector3<f64> {
        let way = bodies[self.second].centre - bodies[self.first].centre;
        let image = self.image + crossed(bodies, self.first, self.second, periods);
        Vector3::from_fn(|a, _| way[a] + periods[a].map_or(0.0, |length| length * image[a]))
    }
}

/// Whole periods, along each axis, by which the second of two bodies has crossed more periodic
/// boundaries; none of a wall.
pub(super) fn crossed(
    bodies: &[Body],
    first: usize,
    second: usize,
    periods: &[Option<f64>; 3],
) -> Vector3<f64> {
    let Some(other) = bodies.get(second) else { return Vector3::zeros() };
    let further = other.crossed - bodies[first].crossed;
    Vector3::from_fn(|a, _| periods[a].map_or(0.0, |length| (further[a] / length).round()))
}
