//! Lever arms of a contact about the centres of its two, and impulses of a pair.

use nalgebra::Vector3;

/// Lever arms of what acts at a contact, about the centres of its two, and its couple.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arms {
    /// From the centres to the contact (m).
    pub(super) to: [Vector3<f64>; 2],
    /// From the first to the second.
    pub(super) normal: Vector3<f64>,
    /// Couple about the normal (N m) of a force along it, over that (N).
    pub(super) couple: f64,
}

/// An impulse on the first of a pair (N s), of which the second has the opposite, and angular
/// impulses on both about their centres (N m s); or forces (N, N m).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PairImpulse {
    pub(super) linear: Vector3<f64>,
    pub(super) turns: [Vector3<f64>; 2],
}

impl Arms {
    /// Angular impulses (N m s) on both about their centres by an impulse (N s) on the first and
    /// its opposite on the second.
    #[inline]
    pub(super) fn turns(&self, impulse: &Vector3<f64>) -> [Vector3<f64>; 2] {
        let turns = [self.to[0].cross(impulse), -self.to[1].cross(impulse)];
        if self.couple == 0.0 {
            return turns;
        }
        let couple = self.couple * impulse.dot(&self.normal) * self.normal;
        [turns[0] + couple, turns[1] - couple]
    }

    /// An impulse (N s) at the contact on the first, its opposite on the second.
    #[inline]
    pub(super) fn impulse(&self, linear: Vector3<f64>) -> PairImpulse {
        PairImpulse { linear, turns: self.turns(&linear) }
    }

    /// Velocity of the first against the second at the contact by their spins (rad/s), with what
    /// the couple makes of them along the normal (m/s).
    #[inline]
    pub(super) fn turning(&self, spins: [&Vector3<f64>; 2]) -> Vector3<f64> {
        self.coupled(spins[0].cross(&self.to[0]) - spins[1].cross(&self.to[1]), spins)
    }

    /// A velocity (m/s) with what the couple makes of spins.
    #[inline]
    pub(super) fn coupled(
        &self,
        velocity: Vector3<f64>,
        spins: [&Vector3<f64>; 2],
    ) -> Vector3<f64> {
        if self.couple == 0.0 {
            return velocity;
        }
        velocity + self.couple * (spins[0] - spins[1]).dot(&self.normal) * self.normal
    }
}

impl PairImpulse {
    /// A multiple of it.
    pub(super) fn times(&self, factor: f64) -> PairImpulse {
        PairImpulse { linear: factor * self.linear, turns: self.turns.map(|turn| factor * turn) }
    }
}

impl std::ops::AddAssign for PairImpulse {
    fn add_assign(&mut self, other: PairImpulse) {
        self.linear += other.linear;
        self.turns.iter_mut().zip(other.turns).for_each(|(sum, turn)| *sum += turn);
    }
}
