//! What contacts have to give beyond what they gave: the fluid answers with a mass of its own, which the substeps can but
//! expect.
//!
//! ```text
//!   deviation   e_i = v_i - (v_i expected),  o_i = w_i - (w_i expected)
//!   normal      P = q m_n e_n,   e_n = n.(e_i - e_j)           1/m_n, 1/m_t as in [`super::law`]
//!   tangential  Q = -q m_t e_t,  e_t = (e_i - e_j)_t + (a_i o_i + a_j o_j) x n
//! ```
//! q is 1 for a pair that touched, along n, and along its surfaces what part of the impulse between them they stuck for: it parts, rests or
//! slips as the substeps found, `|Q + what gripped| <= mu (P + what pressed)`. The film in a gap resists a deviation as it does a speed: `q = x/(1 + x)`,
//! x = dt lambda/m over the step. Spin deviates by what Q turns alone. Pairs are taken one after the other, there and back, until what a sweep changes is
//! small beside what the first one did: in a pile that sticks together each layer slides by little on the one before, and with few sweeps the far ones slide
//! to and fro, more with each step.
//!
//! Discs that move together carry less of the fluid than half of what each does alone, down to what is in the pores. Where that is most of their mass, and
//! their own is not, mending leaves more than there was, the other way. So where light bodies touch, what is left to mend, f, is looked at once the fluid
//! has answered, and where it is against f and more than half of it they are mended again, by
//! Anderson's acceleration over the last two rounds (D. G. Anderson, J. ACM 12, 1965), x the impulses of all pairs:
//!
//! ```text
//!   x' = x + f - c (dx + df),   c = <f, df>/<df, df>,   dx, df: their changes since the round before,   <f, g> = sum f g/m
//! ```
//! Bodies that are alone at one wall or held body are mended again whichever way f points, down to a tenth of what there was (`mend_on`): their
//! contacts go by the mass that the fluid has shown, so that this feeds nothing back. It ends where it would fling two apart that part already, for
//! which no spring has the energy.

use super::substep::Answer;
use super::{Contacts, Impulse, Pair};
use crate::params;
use crate::particles::Body;
use nalgebra::Vector3;

/// The part of f squared, of bodies that are alone at one wall or held body, from which on it counts that two are made to part.
const FLUNG: f64 = 0.1;

/// How far a body is from what the substeps expected of it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Deviation {
    /// Velocity (m/s).
    pub(crate) linear: Vector3<f64>,
    /// Spin, by what mended it in the step (rad/s).
    pub(crate) angular: Vector3<f64>,
}

/// Impulses of a pair (N s): what keeps the two apart, and what the first gets along their surfaces.
#[derive(Clone, Copy, Debug, Default)]
struct Given {
    press: f64,
    grip: Vector3<f64>,
}

/// A pair that gave something in the step, while it is mended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bond {
    /// Its place among the pairs, and its two.
    pair: usize,
    two: [usize; 2],
    /// From the first to the second, and the arms of both (m).
    normal: Vector3<f64>,
    arms: [f64; 2],
    /// `1/m_n`, `1/m_t` (1/kg), and q along both.
    inverse: [f64; 2],
    part: [f64; 2],
    /// The approach that the substeps expected at their end (m/s), and whether those of the two that are free are alone.
    expected: f64,
    alone: bool,
    /// Coulomb's, where the two touch; `None` for a film.
    friction: Option<f64>,
    /// f, now and in the round before, what it was mended by since, and in all.
    found: Given,
    before: Given,
    step: Given,
    whole: Given,
}

/// What a look at the deviations found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    /// The largest deviation of a pair (m/s).
    pub(crate) off: f64,
    /// The size of f (J^1/2), and of that of bodies which are alone at one wall or held body.
    pub(crate) size: f64,
    pub(crate) alone: f64,
    /// Whether it is against what there was in the round before: the fluid has answered with more than was expected.
    pub(crate) turned: bool,
    /// Whether some of the latter would make two part that part already: no spring has the energy for that.
    pub(crate) flung: bool,
}

impl Contacts {
    /// Finds what would take the `deviation` of all bodies from what was expected over the step `dt` (s) back at their contacts; in the `round` of the
    /// step, from 0. Where no pair is off by the `tolerance` (m/s) a first sweep is all.
    pub(crate) fn find_mending(
        &mut self,
        bodies: &[Body],
        deviation: &[Deviation],
        nudges: &mut [Impulse],
        round: usize,
        tolerance: f64,
        dt: f64,
    ) -> Found {
        let mut bonds = std::mem::take(&mut self.bonds);
        if round == 0 {
            bonds.clear();
            let gave = self.pairs.iter().enumerate().filter(|(_, pair)| pair.given != 0.0);
            bonds.extend(gave.map(|(p, pair)| self.bond(p, pair, bodies, dt)));
        }
        nudges.fill(Impulse::default());
        for bond in &mut bonds {
            bond.before = std::mem::take(&mut bond.found);
            if round == 0 {
                bond.expected -= self.deviates(bond, deviation, nudges).0;
            }
        }
        let mut largest = 0.0f64;
        for sweep in 0..params::most_mending_sweeps() as usize {
            let mut off = 0.0f64;
            // There and back, so that neither end of a pile comes first.
            let mut mend = |bond: &mut Bond| off = off.max(self.mend_bond(bond, deviation, nudges));
            if sweep % 2 == 0 {
                bonds.iter_mut().for_each(&mut mend);
            } else {
                bonds.iter_mut().rev().for_each(&mut mend);
            }
            if sweep == 0 {
                largest = off;
            }
            if largest < tolerance || off <= params::mended() * largest {
                break;
            }
        }
        let size = bonds.iter().map(|bond| bond.product(&bond.found, &bond.found)).sum::<f64>().sqrt();
        let turned = bonds.iter().map(|bond| bond.product(&bond.found, &bond.before)).sum::<f64>() < 0.0;
        let (mut alone, mut flung) = (0.0, 0.0);
        for bond in bonds.iter().filter(|bond| bond.alone && bond.found.press.abs() * bond.inverse[0] > tolerance) {
            let square = bond.product(&bond.found, &bond.found);
            alone += square;
            let parts = bond.friction.is_some() && bond.expected < -tolerance && bond.found.press > 0.0;
            flung += if parts { square } else { 0.0 };
        }
        let (alone, flung) = (alone.sqrt(), flung > FLUNG * alone);
        self.bonds = bonds;
        Found { off: largest, size, alone, turned, flung }
    }

    /// Mends the pairs by what was found in the `round`, adds it to the impulses, and leaves it in `nudges`.
    pub(crate) fn mend(&mut self, bodies: &[Body], nudges: &mut [Impulse], round: usize) {
        let mut share = 0.0;
        if round > 0 {
            let (mut along, mut whole) = (0.0, 0.0);
            for bond in &self.bonds {
                let change = bond.found.plus(-1.0, &bond.before);
                along += bond.product(&bond.found, &change);
                whole += bond.product(&change, &change);
            }
            share = if whole > 0.0 { along / whole } else { 0.0 };
        }
        nudges.fill(Impulse::default());
        for bond in &mut self.bonds {
            let change = bond.step.plus(1.0, &bond.found).plus(-1.0, &bond.before);
            let (pair, wanted) = (&mut self.pairs[bond.pair], bond.found.plus(-share, &change));
            let press = bond.most_press(pair, wanted.press);
            let grip = bond.most_grip(pair, press, wanted.grip);
            bond.step = Given { press, grip };
            bond.whole = bond.whole.plus(1.0, &bond.step);
            pair.given += press;
            pair.pressed += if bond.friction.is_some() { press } else { 0.0 };
            pair.grip += grip;
            let (impulse, turn) = (grip - press * bond.normal, bond.normal.cross(&grip));
            bond.nudge(impulse, bond.arms.map(|arm| arm * turn), nudges);
            if let Some(wall) = bond.two[1].checked_sub(bodies.len()) {
                self.wall_impulse -= impulse;
                self.wall_work += impulse.dot(&self.walls[wall].velocity);
            }
        }
        for (impulse, nudge) in self.impulses.iter_mut().zip(nudges.iter()) {
            impulse.linear += nudge.linear;
            impulse.angular += nudge.angular;
        }
    }

    /// The pair at the place `p`, of which nothing is mended yet.
    fn bond(&self, p: usize, pair: &Pair, bodies: &[Body], dt: f64) -> Bond {
        let (kinematics, arms) = self.kinematics(pair, bodies, 0.0);
        let (normal, along) = (kinematics.inverse_normal, kinematics.inverse_tangential);
        // What touches for a part of the step, and is held by its film in all, is held.
        let touched = pair.pressed > 0.0 && pair.given > 0.0;
        let film = |resistance: f64, inverse: f64| {
            let x = dt * resistance * inverse;
            x / (1.0 + x)
        };
        Bond {
            pair: p,
            two: [pair.first, pair.second],
            normal: kinematics.normal,
            arms,
            inverse: [normal, along],
            part: if touched {
                [1.0, pair.stuck / pair.pressed]
            } else {
                [film(pair.film.normal, normal), film(pair.film.sliding, along)]
            },
            expected: kinematics.approach,
            alone: [pair.first, pair.second].iter().all(|&k| !is_free(bodies, k) || self.is_alone(k)),
            friction: touched.then(|| self.law(pair).material.friction),
            found: Given::default(),
            before: Given::default(),
            step: Given::default(),
            whole: Given::default(),
        }
    }

    /// Finds what mends a pair as the nudges now are; by how much that changes its deviation (m/s).
    fn mend_bond(&self, bond: &mut Bond, deviation: &[Deviation], nudges: &mut [Impulse]) -> f64 {
        let (n, pair, found, whole) = (bond.normal, &self.pairs[bond.pair], bond.found, bond.whole);
        // As if the pair had not been mended yet.
        let off = whole.press + found.press + self.deviates(bond, deviation, nudges).0 / bond.inverse[0];
        let press = bond.most_press(pair, bond.part[0] * off - whole.press);
        let pressed = press - found.press;
        bond.nudge(-pressed * n, [Vector3::zeros(); 2], nudges);

        let slips = whole.grip + found.grip - self.deviates(bond, deviation, nudges).1 / bond.inverse[1];
        let grip = bond.most_grip(pair, press, bond.part[1] * slips - whole.grip);
        let along = grip - found.grip;
        let turn = n.cross(&along);
        bond.nudge(along, bond.arms.map(|arm| arm * turn), nudges);

        bond.found = Given { press, grip };
        (pressed.abs() * bond.inverse[0]).max(along.norm() * bond.inverse[1])
    }

    /// By how much the approach and the slip of a pair are off (m/s), the nudges counted.
    fn deviates(&self, bond: &Bond, deviation: &[Deviation], nudges: &[Impulse]) -> (f64, Vector3<f64>) {
        let off = |k: usize| {
            let Some(nudge) = nudges.get(k) else { return (Vector3::zeros(), Vector3::zeros()) };
            let (Answer { mass, inertia, .. }, deviation) = (&self.answers[k], &deviation[k]);
            let moved = deviation.linear + mass.component_mul(&nudge.linear);
            (moved, deviation.angular + inertia.component_mul(&nudge.angular))
        };
        let ([(one, spun), (other, its)], n) = (bond.two.map(off), bond.normal);
        let (moved, turned) = (one - other, bond.arms[0] * spun + bond.arms[1] * its);
        (moved.dot(&n), moved - moved.dot(&n) * n + turned.cross(&n))
    }

    /// Finds what each body gave to or got from: a wall or a held body counts once, a free one twice.
    pub(super) fn find_company(&mut self, bodies: &[Body]) {
        self.company.fill(0);
        for pair in self.pairs.iter().filter(|pair| pair.given != 0.0) {
            for (k, other) in [(pair.first, pair.second), (pair.second, pair.first)] {
                if let Some(count) = self.company.get_mut(k) {
                    *count += if is_free(bodies, other) { 2 } else { 1 };
                }
            }
        }
    }

    /// Whether a body had to do with one wall or held body at most in the last [`advance`](Contacts::advance). In a corner the fluid answers with
    /// several times the mass that it has at one wall: a disc there that went by what it had shown rattled and made energy.
    pub(crate) fn is_alone(&self, body: usize) -> bool {
        self.company.get(body).is_none_or(|count| *count < 2)
    }

    /// The largest speed at which a pair that touched comes together or parts (m/s).
    pub(crate) fn pace(&self, bodies: &[Body]) -> f64 {
        let touched = self.pairs.iter().filter(|pair| pair.pressed > 0.0);
        touched.fold(0.0, |most, pair| most.max(self.kinematics(pair, bodies, 0.0).0.approach.abs()))
    }

    /// Whether a pair gave something over a step of `dt` (s) that may be worth mending, and one with a body lighter than the fluid did: a film that
    /// could hardly slow two in that time is none.
    pub(crate) fn gave(&self, bodies: &[Body], dt: f64) -> (bool, bool) {
        let lighter = |k: usize| bodies.get(k).is_some_and(|body| self.is_light(body));
        let slows = |pair: &Pair| {
            let kinematics = self.kinematics(pair, bodies, 0.0).0;
            let [normal, sliding] =
                [pair.film.normal * kinematics.inverse_normal, pair.film.sliding * kinematics.inverse_tangential];
            dt * normal.max(sliding) >= params::faint_film()
        };
        let gave = self.pairs.iter().filter(|pair| pair.given != 0.0 && (pair.pressed > 0.0 || slows(pair)));
        gave.fold((false, false), |(_, light), pair| (true, light || lighter(pair.first) || lighter(pair.second)))
    }
}

/// Whether what has this place among the partners of contacts, walls after bodies, moves as it is pushed.
fn is_free(bodies: &[Body], k: usize) -> bool {
    bodies.get(k).is_some_and(|body| body.freedom().is_some())
}

impl Bond {
    /// What of an impulse it can press with: contacts hold nothing back.
    fn most_press(&self, pair: &Pair, press: f64) -> f64 {
        if self.friction.is_some() { press.max(-pair.given.max(0.0)) } else { press }
    }

    /// What of an impulse along the surfaces it can hold, pressing by so much more.
    fn most_grip(&self, pair: &Pair, press: f64, grip: Vector3<f64>) -> Vector3<f64> {
        let Some(friction) = self.friction else { return grip };
        let (limit, whole) = (friction * (pair.pressed + press).max(0.0), pair.grip + grip);
        grip + whole * ((limit / whole.norm().max(f64::MIN_POSITIVE)).min(1.0) - 1.0)
    }

    /// `<f, g>` of this pair (J).
    fn product(&self, f: &Given, g: &Given) -> f64 {
        self.inverse[0] * f.press * g.press + self.inverse[1] * f.grip.dot(&g.grip)
    }

    /// Nudges the first of a pair by an impulse (N s) and the second the other way, and turns them (N m s).
    fn nudge(&self, impulse: Vector3<f64>, turns: [Vector3<f64>; 2], nudges: &mut [Impulse]) {
        for (k, impulse, turn) in [(self.two[0], impulse, turns[0]), (self.two[1], -impulse, turns[1])] {
            if let Some(nudge) = nudges.get_mut(k) {
                nudge.linear += impulse;
                nudge.angular += turn;
            }
        }
    }
}

impl Given {
    /// That with a part of another one.
    fn plus(&self, part: f64, other: &Given) -> Given {
        Given { press: self.press + part * other.press, grip: self.grip + part * other.grip }
    }
}
