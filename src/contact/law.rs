//! The force between two bodies that overlap by `d`, as its mean over a substep `h`.
//!
//! ```text
//!   F_n = max(0, k d^g + eta_n d^p v_n)                   p = (g - 1)/2, v_n the speed of approach
//!              (20, 21)
//!   F_t = -(k_t xi + eta_t v_t),  |F_t| <= mu F_n            k_t = ratio k d^(g-1), xi' = v_t
//!              (22-25)
//!   eta_n = 2 zeta sqrt(m_n k),  eta_t = 2 zeta sqrt(m_t k_t)    1/m_n = n.(1/m_i + 1/m_j).n
//!                                                            1/m_t = 1/m_i + 1/m_j + a_i^2/I_i
//!                 + a_j^2/I_j
//! ```
//! `d` runs from `d_0` to `d_1` over a substep. Powers of it enter by their mean over it, zero
//! where `d < 0`: a contact may begin or end anywhere within a substep. Dampers see the mean
//! velocity that this contact alone leaves, `v + h (a - F/m)/2`: right to second order for a pair,
//! to first in a heap, where v is small. The restitution fixes zeta through the collision `x'' =
//! -x^g - 2 zeta x^p x'`, `x(0) = 0`, `x'(0) = 1`, that ends where the force does; e depends on
//! zeta and g alone.
//!
//! Where g is not 1, `k_t` changes under a stretched spring, which takes or feeds a little energy
//! (up to 6e-4 of it in a step, seen in a cloud of 50 with g = 1.5, mu = 0.3, e = 1; 1e-5 with e =
//! 0.9).

use nalgebra::Vector3;

/// Dissipation of a contact, by a restitution or by coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Damping {
    /// Share of its speed that a head-on collision keeps, in (0, 1].
    Restitution(f64),
    /// Coefficients of the dampers themselves.
    Given {
        /// Along the normal (N s/m, times `m^-p` of an exponent other than 1).
        normal: f64,
        /// In the tangent plane (N s/m).
        tangential: f64,
    },
}

/// The law of contact of a pair of materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// `k` (N/m^exponent).
    pub normal_stiffness: f64,
    /// `g`: 1 for a linear spring, 1.5 for Hertz's.
    pub exponent: f64,
    /// Tangential over normal stiffness.
    pub tangential_ratio: f64,
    /// Coulomb's `mu`.
    pub friction: f64,
    /// `mu_r`, the resistance to rolling: the lever of the normal force, of the reduced radius.
    pub rolling_friction: f64,
    /// Dissipation.
    pub damping: Damping,
    /// Turns the tangential damper round, as (22) is printed: it then feeds energy. For
    /// reproduction only.
    pub printed_sign: bool,
}

/// The law of every pair of materials.
#[derive(Clone, Debug)]
pub struct Laws {
    table: Vec<Law>,
    materials: usize,
}

impl Laws {
    /// The laws among `materials` materials; `law_of_pair(a, b)` is asked once per pair, with `a <=
    /// b`.
    pub fn new(materials: usize, law_of_pair: impl Fn(usize, usize) -> Material) -> Laws {
        let mut table: Vec<Law> = Vec::with_capacity(materials * materials);
        for a in 0..materials {
            for b in 0..materials {
                let law =
                    if b < a { table[b * materials + a] } else { Law::new(law_of_pair(a, b)) };
                table.push(law);
            }
        }
        Laws { table, materials }
    }

    /// The law between materials `a` and `b`.
    pub(super) fn of(&self, a: usize, b: usize) -> &Law {
        self.at(self.place(a, b))
    }

    /// The place of the law between materials `a` and `b`.
    pub(super) fn place(&self, a: usize, b: usize) -> usize {
        a * self.materials + b
    }

    /// The law at a place.
    pub(super) fn at(&self, place: usize) -> &Law {
        &self.table[place]
    }

    pub(super) fn materials(&self) -> usize {
        self.materials
    }
}

/// A [`Material`] with what follows from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Law {
    pub(super) material: Material,
    /// Damping ratio that gives the restitution; 0 where the damping is given.
    pub(super) zeta: f64,
    /// Duration of an undamped contact over the time that its depth takes at the speed of impact.
    duration: f64,
}

/// Kinematics of two bodies in contact over a substep.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kinematics {
    /// Substep (s).
    pub(super) h: f64,
    /// Overlap at its middle (m), from the velocities at its start.
    pub(super) overlap: f64,
    /// Change of the overlap over the approach at the contact: more than 1 in a patch.
    pub(super) gain: f64,
    /// From the first to the second.
    pub(super) normal: Vector3<f64>,
    /// Speed of approach at the start of the substep (m/s).
    pub(super) approach: f64,
    /// Velocity of the first one's surface along the other's at the start (m/s).
    pub(super) slip: Vector3<f64>,
    /// Acceleration of the approach without contacts (m/s2).
    pub(super) accelerations: f64,
    /// Acceleration of the slip without contacts (m/s2).
    pub(super) push_slip: Vector3<f64>,
    /// `1/m_n` (1/kg).
    pub(super) inverse_normal: f64,
    /// `1/m_t` (1/kg).
    pub(super) inverse_tangential: f64,
}

impl Kinematics {
    /// Mass that an overlap stops (kg): that of the two at the contact, but for a patch, where the
    /// overlap grows faster.
    pub(super) fn mass_of_overlap(&self) -> f64 {
        1.0 / (self.inverse_normal * self.gain * self.gain)
    }

    /// Overlaps at the two ends of the substep, the smaller one first (m).
    fn interval(&self) -> (f64, f64) {
        let half = 0.5 * self.h * (self.gain * self.approach).abs();
        (self.overlap - half, self.overlap + half)
    }
}

impl Law {
    pub(super) fn new(material: Material) -> Law {
        let zeta = match material.damping {
            Damping::Restitution(e) => damping_ratio(material.exponent, e),
            Damping::Given { .. } => 0.0,
        };
        // int_0^1 ds/sqrt(1 - s^(g+1)) with s = 1 - u^2, which takes the pole away.
        let n = 1000;
        let share = |i: usize| {
            let u = (i as f64 + 0.5) / n as f64;
            2.0 * u / (1.0 - (1.0 - u * u).powf(material.exponent + 1.0)).sqrt()
        };
        Law { material, zeta, duration: 2.0 * (0..n).map(share).sum::<f64>() / n as f64 }
    }

    /// Duration of an undamped head-on collision (s) at mass `m_n` (kg) and a speed (m/s).
    pub(super) fn contact_time(&self, mass: f64, speed: f64) -> f64 {
        let k = self.material.normal_stiffness;
        let g = self.material.exponent;
        if g == 1.0 {
            return self.duration * (mass / k).sqrt();
        }
        let depth = (0.5 * (g + 1.0) * mass * speed * speed / k).powf(1.0 / (g + 1.0));
        if speed > 0.0 { self.duration * depth / speed } else { f64::INFINITY }
    }

    /// Energy in the normal spring (J).
    pub(super) fn stored(&self, overlap: f64) -> f64 {
        let g = self.material.exponent;
        self.material.normal_stiffness * overlap.max(0.0).powf(g + 1.0) / (g + 1.0)
    }

    /// Energy in the normal spring and in the tangential one, stretched by `spring` (m), at an
    /// overlap (J): as much of that as friction can hold.
    pub(super) fn stored_with(&self, overlap: f64, spring: &Vector3<f64>) -> f64 {
        if overlap <= 0.0 {
            return 0.0;
        }
        let Material { normal_stiffness, exponent, tangential_ratio, friction, .. } = self.material;
        let tangential = tangential_ratio * normal_stiffness * overlap.powf(exponent - 1.0);
        let held =
            (tangential * spring.norm()).min(friction * normal_stiffness * overlap.powf(exponent));
        self.stored(overlap) + if held > 0.0 { 0.5 * held * held / tangential } else { 0.0 }
    }

    /// Damping ratio at mass `m_n` (kg).
    pub(super) fn damping_ratio(&self, mass: f64) -> f64 {
        match self.material.damping {
            Damping::Restitution(_) => self.zeta,
            Damping::Given { normal, .. } => {
                0.5 * normal / (mass * self.material.normal_stiffness).sqrt()
            }
        }
    }

    /// Mean normal force and tangential force on the first one over the substep (N). `spring` is
    /// `xi` (m) at the middle of the last substep, `None` where that found no contact, and becomes
    /// that at the middle of this one.
    pub(super) fn force(
        &self,
        kinematics: &Kinematics,
        spring: &mut Option<Vector3<f64>>,
    ) -> (f64, Vector3<f64>) {
        let law = &self.material;
        let k = law.normal_stiffness;
        let g = law.exponent;
        let h = kinematics.h;
        let (low, high) = kinematics.interval();
        let mean = |power: f64| mean_power(low, high, power);
        let root = mean(0.5 * (g - 1.0));
        let (damper, damper_tangential) = match law.damping {
            Damping::Restitution(_) => {
                let eta = 2.0 * self.zeta * k.sqrt() * root;
                (
                    eta / (kinematics.gain * kinematics.inverse_normal.sqrt()),
                    eta * (law.tangential_ratio / kinematics.inverse_tangential).sqrt(),
                )
            }
            Damping::Given { normal, tangential } => (normal * root, tangential * mean(0.0)),
        };

        let elastic = k * mean(g);
        // Along the overlap: the force that does its work acts on the bodies `gain` times.
        let gain = kinematics.gain;
        let slowing = 0.5 * h * kinematics.inverse_normal * gain * gain;
        let approach =
            gain * (kinematics.approach + 0.5 * h * kinematics.accelerations) - slowing * elastic;
        let normal = gain * (elastic + damper * approach / (1.0 + slowing * damper)).max(0.0);
        let stiffness = law.tangential_ratio * k * mean(g - 1.0);
        let lasted = mean(0.0) * h;
        (normal, self.tangential(kinematics, stiffness, damper_tangential, lasted, normal, spring))
    }

    /// Tangential force on the first one (N) by a spring (N/m) and a damper (N s/m) of a contact
    /// that has `lasted` (s) in the substep.
    fn tangential(
        &self,
        kinematics: &Kinematics,
        stiffness: f64,
        damper: f64,
        lasted: f64,
        normal: f64,
        spring: &mut Option<Vector3<f64>>,
    ) -> Vector3<f64> {
        let law = &self.material;
        let h = kinematics.h;
        // Stretch of a contact that begins now (m), at its own middle and (continued) at the middle
        // of the substep.
        let (stretch, middle) = match *spring {
            None => (0.5 * lasted * kinematics.slip, (lasted - 0.5 * h) * kinematics.slip),
            Some(last) => {
                let flat = last - last.dot(&kinematics.normal) * kinematics.normal;
                let turned = flat.try_normalize(0.0).map_or(flat, |along| along * last.norm());
                (turned + h * kinematics.slip, turned + h * kinematics.slip)
            }
        };
        let damper = if law.printed_sign { -damper } else { damper };
        let slowing = 0.5 * h * kinematics.inverse_tangential;
        let slip = kinematics.slip + 0.5 * h * kinematics.push_slip;
        let tangential = stiffness * stretch
            + damper * (slip - slowing * stiffness * stretch) / (1.0 + slowing * damper);
        let limit = law.friction * normal;
        if tangential.norm_squared() <= limit * limit {
            *spring = Some(middle);
            return -tangential;
        }
        let sliding = tangential * (limit / tangential.norm());
        let held = (sliding - damper * (slip - slowing * sliding)) / stiffness;
        *spring = Some(if stiffness > 0.0 { held } else { Vector3::zeros() });
        -sliding
    }
}

/// Mean of `max(0, d)^q` for `d` from `low` to `high`, with `0^0` taken as 0 outside the contact.
fn mean_power(low: f64, high: f64, q: f64) -> f64 {
    if high <= 0.0 {
        return 0.0;
    }
    let from = low.max(0.0);
    let share = if low < 0.0 { high / (high - low) } else { 1.0 };
    share
        * if q == 0.0 {
            1.0
        } else if q == 1.0 {
            0.5 * (from + high)
        } else if high - from < 1e-3 * high {
            // The difference below would cancel; this one is off by 1e-7 at most.
            (0.5 * (from + high)).powf(q)
        } else {
            (high.powf(q + 1.0) - from.powf(q + 1.0)) / ((q + 1.0) * (high - from))
        }
}

/// The zeta that gives a clipped collision the restitution `e`.
fn damping_ratio(exponent: f64, e: f64) -> f64 {
    if e >= 1.0 {
        return 0.0;
    }
    let mut low = 0.0;
    let mut high = 1.0;
    while restitution(exponent, high) > e && high < 1e3 {
        high *= 2.0;
    }
    for _ in 0..45 {
        let middle = 0.5 * (low + high);
        *(if restitution(exponent, middle) > e { &mut low } else { &mut high }) = middle;
    }
    0.5 * (low + high)
}

/// Restitution of the clipped collision.
fn restitution(exponent: f64, zeta: f64) -> f64 {
    if exponent == 1.0 { linear_restitution(zeta) } else { integrated_restitution(exponent, zeta) }
}

/// Restitution of a linear spring in closed form: with `x = exp(-zeta t) sin(w t)/w`, `w = cos b`,
/// `zeta = sin b`, the force is zero at `w t = pi - 2 b`, where the speed is `exp(-zeta t)`. Beyond
/// `zeta = 1` b is complex.
fn linear_restitution(zeta: f64) -> f64 {
    let cosine = (1.0 - zeta * zeta).abs().sqrt();
    if cosine < 1e-6 {
        return (-2.0f64).exp();
    }
    let angle = if zeta < 1.0 { 2.0 * cosine.atan2(zeta) } else { 2.0 * zeta.acosh() };
    (-zeta / cosine * angle).exp()
}

/// Restitution of any spring, in `w = x' + 2 zeta x^s/s`, `s = (g+1)/2`: `w' = -x^g`, free of the
/// damper's infinite slope at contact. It ends at `x^s + 2 zeta x' = 0`.
pub(super) fn integrated_restitution(exponent: f64, zeta: f64) -> f64 {
    let s = 0.5 * (exponent + 1.0);
    let speed = |x: f64, w: f64| w - 2.0 * zeta * x.max(0.0).powf(s) / s;
    let rate = |x: f64, w: f64| (speed(x, w), -x.max(0.0).powf(exponent));
    let force =
        |x: f64, w: f64| if zeta > 0.0 { x.max(0.0).powf(s) + 2.0 * zeta * speed(x, w) } else { x };
    let h = 5e-3 / (1.0 + zeta);
    let mut x = 0.0;
    let mut w = 1.0;
    loop {
        let a = rate(x, w);
        let b = rate(x + 0.5 * h * a.0, w + 0.5 * h * a.1);
        let c = rate(x + 0.5 * h * b.0, w + 0.5 * h * b.1);
        let d = rate(x + h * c.0, w + h * c.1);
        let next = (
            x + h / 6.0 * (a.0 + 2.0 * (b.0 + c.0) + d.0),
            w + h / 6.0 * (a.1 + 2.0 * (b.1 + c.1) + d.1),
        );
        let before = force(x, w);
        let after = force(next.0, next.1);
        if after <= 0.0 || next.0.is_nan() {
            // The acceleration is 0 there: the speed is that of either end to second order.
            let share = before / (before - after);
            return -((1.0 - share) * speed(x, w) + share * speed(next.0, next.1));
        }
        (x, w) = next;
    }
}
