//! Two that could meet within a step: who they are, their springs, the fluid between them, and what
//! they have given each other.

use super::arms::{Arms, PairImpulse};
use super::lubrication::Lubrication;
use super::{Impulse, Springs};
use crate::numerics::SLIDING_ONSET;
use crate::particles::{Body, Span};
use mics_shapes::{Part, Touch};
use nalgebra::Vector3;

/// Kind of the second of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Partner {
    /// A body.
    Body,
    /// A body that is a wall to contacts.
    Obstacle,
    /// A wall of the box.
    Wall,
}

/// Two that could meet within the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub(super) first: usize,
    /// A body, or the number of bodies plus that of a wall.
    pub(super) second: usize,
    pub(super) partner: Partner,
    /// Whether both are round, as walls and obstacles are.
    pub(super) round: bool,
    /// The place of its law among [`super::Laws`].
    pub(super) law: usize,
    /// Which image of the second body it is: whole periods from its path to that of the image,
    /// along each axis.
    pub(super) image: Vector3<f64>,
    /// Which parts of both; 0 of round bodies and of walls, of an obstacle the face that holds the
    /// contact, or did so last.
    pub(super) parts: [usize; 2],
    /// Which of the regions of obstacles it is, where the second is one.
    pub(super) region: usize,
    pub(super) springs: PairSprings,
    pub(super) film: Film,
    pub(super) seen: LastMeeting,
    pub(super) sums: PairSums,
}

/// The springs of a pair, which last from step to step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PairSprings {
    /// The tangential spring (m), while the two touch.
    pub(super) tangential: Option<Vector3<f64>>,
    /// The rolling spring (rad).
    pub(super) rolling: Vector3<f64>,
    /// Energy in all springs at the start of the step (J).
    pub(super) stored: f64,
}

/// The fluid between a pair.
#[derive(Clone, Copy, Debug)]
pub(super) struct Film {
    /// Its resistance.
    pub(super) lubrication: Lubrication,
    /// Number of substeps in which it acts once.
    pub(super) stride: usize,
    /// Time for which it has not acted yet (s).
    pub(super) due: f64,
}

/// Meeting of a pair when it was looked at last.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LastMeeting {
    /// The normal that it met with last in the step, zero before it did: where the search for the
    /// next one starts.
    pub(super) normal: Vector3<f64>,
    /// Sum of the ways of the two since the search before which they cannot touch (m).
    pub(super) clear: f64,
    /// Its last meeting, where one of the two is not round.
    pub(super) met: Option<Met>,
}

/// Where a pair touches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    /// From the first to the second.
    pub(super) normal: Vector3<f64>,
    /// Overlap (m); negative where they do not touch.
    pub(super) overlap: f64,
    /// Change of the overlap over the approach at the contact: more than 1 in a patch.
    pub(super) gain: f64,
    pub(super) arms: Arms,
    /// Radius of the patch (m).
    pub(super) spread: f64,
    /// Local radii of curvature (m).
    pub(super) radii: [f64; 2],
    /// Relative velocity of the centres (m/s).
    pub(super) velocity: Vector3<f64>,
    /// Speed of approach at the contact (m/s).
    pub(super) approach: f64,
}

impl Meeting {
    /// Whether they touch during a substep `h` (s) in whose middle this is.
    pub(super) fn touches(&self, h: f64) -> bool {
        self.overlap > 0.0 || self.overlap + 0.5 * h * (self.gain * self.approach).abs() > 0.0
    }

    /// Meeting of two parts whose centres are so far from the place (m) and have a relative
    /// velocity (m/s), and spins (rad/s).
    pub(super) fn of(
        touch: &Touch,
        to: [Vector3<f64>; 2],
        velocity: Vector3<f64>,
        spins: [&Vector3<f64>; 2],
    ) -> Meeting {
        let &Touch { normal, overlap, gain, couple, spread, radii, .. } = touch;
        let arms = Arms { to, normal, couple };
        let approach = (velocity + arms.turning(spins)).dot(&normal);
        Meeting { normal, overlap, gain, arms, spread, radii, velocity, approach }
    }

    /// Meeting of two parts beyond what a soft contact can be: as deep as the skins are thick.
    pub(super) fn too_deep(
        parts: [&Part; 2],
        way: &Vector3<f64>,
        to: [Vector3<f64>; 2],
        velocity: Vector3<f64>,
    ) -> Meeting {
        let normal = way.try_normalize(0.0).unwrap_or_else(Vector3::x);
        Meeting {
            normal,
            overlap: parts[0].rounding + parts[1].rounding,
            gain: 1.0,
            arms: Arms { to, normal, couple: 0.0 },
            spread: 0.0,
            radii: parts.map(|part| part.radius),
            velocity,
            approach: velocity.dot(&normal),
        }
    }
}

/// A meeting as it was found, of a pair of which one is not round.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    pub(super) meeting: Meeting,
    /// Time since then (s); negative where it is of the middle of a substep to come.
    pub(super) age: f64,
    /// Sum of the ways that the two had gone since the search (m).
    pub(super) gone: f64,
}

/// Impulses of a pair over the step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PairSums {
    /// Impulse by touch and lubrication (N s, N m s).
    pub(super) impulse: PairImpulse,
    /// Normal impulse by touch and lubrication, positive where it parts the two (N s).
    pub(super) normal: f64,
    /// Normal impulse of touch alone (N s).
    pub(super) touch: f64,
    /// The part of that while the two stick (N s).
    pub(super) stuck: f64,
    /// Tangential impulse of touch on the first (N s).
    pub(super) tangential: Vector3<f64>,
    /// Time in which the two touched (s).
    pub(super) time: f64,
}

impl Pair {
    /// The region of a pair of which none was searched for yet.
    pub(super) const NO_REGION: usize = usize::MAX;

    /// Two round bodies under the first law; [`super::setup::Setup::pair`] finds form and law.
    pub(super) fn new(first: usize, second: usize, image: Vector3<f64>) -> Pair {
        Pair {
            first,
            second,
            partner: Partner::Body,
            round: true,
            law: 0,
            image,
            parts: [0; 2],
            region: Pair::NO_REGION,
            springs: PairSprings::default(),
            film: Film { lubrication: Lubrication::UNKNOWN, stride: 1, due: 0.0 },
            seen: LastMeeting::default(),
            sums: PairSums::default(),
        }
    }

    /// Its springs as they are saved, of a sustained contact; `crossed` as in [`crossed`].
    pub(super) fn sustained(&self, crossed: &Vector3<f64>) -> Option<Springs> {
        Some(Springs {
            image: self.image + crossed,
            parts: self.parts,
            tangential: self.springs.tangential?,
            rolling: self.springs.rolling,
        })
    }

    /// Whether the second is an image of the first itself.
    pub(super) fn is_own_image(&self) -> bool {
        self.first == self.second
    }

    /// Whether it gave an impulse by touch in the step.
    pub(super) fn touched(&self) -> bool {
        self.sums.touch > 0.0
    }

    /// Numbers of its two, and their impulses by one of the pair.
    pub(super) fn each(&self, impulse: &PairImpulse) -> [(usize, Impulse); 2] {
        let &PairImpulse { linear, turns: [turn, its_turn] } = impulse;
        [
            (self.first, Impulse { linear, angular: turn }),
            (self.second, Impulse { linear: -linear, angular: its_turn }),
        ]
    }

    /// From the centre of the first body to that of the image of the second (m).
    pub(super) fn apart(&self, bodies: &[Body], periods: &[Option<f64>; 3]) -> Vector3<f64> {
        let way = bodies[self.second].centre - bodies[self.first].centre;
        let image = self.image + crossed(bodies, self.first, self.second, periods);
        Vector3::from_fn(|a, _| way[a] + periods[a].map_or(0.0, |length| length * image[a]))
    }

    /// Where it is; walls and obstacles are where the body is.
    pub(super) fn span(&self, bodies: &[Body], periods: &[Option<f64>; 3]) -> Span {
        let way = match self.partner {
            Partner::Body => self.apart(bodies, periods),
            Partner::Obstacle | Partner::Wall => Vector3::zeros(),
        };
        Span { from: bodies[self.first].centre, way }
    }
}

impl PairSums {
    /// Counts the normal and the tangential force of a touch over a substep `h` (s), under this
    /// coefficient of friction.
    pub(super) fn add_touch(
        &mut self,
        h: f64,
        normal: f64,
        tangential: &Vector3<f64>,
        friction: f64,
    ) {
        self.normal += h * normal;
        self.tangential += h * tangential;
        self.time += if normal > 0.0 { h } else { 0.0 };
        let limit = friction * normal;
        let held = (1.0 - tangential.norm() / limit.max(f64::MIN_POSITIVE)) / SLIDING_ONSET;
        self.touch += h * normal;
        self.stuck += h * normal * held.clamp(0.0, 1.0);
    }

    /// Leaves a part of what it gave, which is a `change` of its impulse.
    pub(super) fn reduce(&mut self, factor: f64, change: PairImpulse) {
        self.impulse += change;
        self.normal *= factor;
        self.touch *= factor;
        self.tangential *= factor;
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
