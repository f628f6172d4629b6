//! What contacts have to give beyond what they gave: the fluid answers with a mass of its own, which the substeps can but
//! expect.
//!
//! ```text
//!   deviation   e_i = v_i - (v_i expected)               along n of a pair that touched or that stiff fluid holds:
//!   impulse     P = n.(e_i - e_j)/(1/m_i + 1/m_j)        so that the pair parts, rests or approaches as the substeps found
//! ```
//! Pairs are taken one after the other, a few times over.

use super::Contacts;
use crate::params;
use crate::particles::Body;
use nalgebra::Vector3;

impl Contacts {
    /// Finds for each body the impulse (N s) that takes the `deviation` (m/s) of its velocity from the expected one back along
    /// its contacts, adds it to the impulses, and leaves it in `nudges`. Returns the largest deviation of a pair before (m/s).
    pub(crate) fn mend(
        &mut self,
        bodies: &[Body],
        deviation: &mut [Vector3<f64>],
        nudges: &mut [Vector3<f64>],
        tolerance: f64,
    ) -> f64 {
        nudges.fill(Vector3::zeros());
        let mut largest = 0.0f64;
        for sweep in 0..params::mending_sweeps() as usize {
            for p in 0..self.pairs.len() {
                let off = self.mend_pair(p, bodies, deviation, nudges);
                if sweep == 0 {
                    largest = largest.max(off);
                }
            }
            if sweep == 0 && largest < tolerance {
                // Nothing worth a solve: what little there was is the next step's.
                return largest;
            }
        }
        for (impulse, nudge) in self.impulses.iter_mut().zip(nudges.iter()) {
            impulse.linear += nudge;
        }
        largest
    }

    /// The same for the pair `p`, as the deviations now are; that of the pair before (m/s).
    fn mend_pair(
        &mut self,
        p: usize,
        bodies: &[Body],
        deviation: &mut [Vector3<f64>],
        nudges: &mut [Vector3<f64>],
    ) -> f64 {
        let pair = self.pairs[p];
        if pair.given == 0.0 {
            return 0.0;
        }
        let (i, j) = (pair.first, pair.second);
        let (kinematics, _) = self.kinematics(&pair, bodies, 0.0);
        // Fluid in a gap that is not stiff needs none of this.
        let stiff = params::stiff_gap() * kinematics.approach.abs();
        if !pair.touched && pair.given.abs() * kinematics.inverse_normal < stiff {
            return 0.0;
        }
        let n = kinematics.normal;
        let off = (deviation[i] - deviation.get(j).copied().unwrap_or_default()).dot(&n);
        let mut impulse = off / kinematics.inverse_normal;
        // Contacts hold nothing back, the fluid in a gap does.
        if pair.touched {
            impulse = impulse.max(-pair.given.max(0.0));
        }
        self.pairs[p].given += impulse;
        let push = impulse * n;
        deviation[i] -= self.answers[i].mass.component_mul(&push);
        nudges[i] -= push;
        if let Some(other) = deviation.get_mut(j) {
            *other += self.answers[j].mass.component_mul(&push);
            nudges[j] += push;
        }
        impulse.abs() * kinematics.inverse_normal
    }

    /// The largest speed at which a pair that touched comes together or parts (m/s).
    pub(crate) fn pace(&self, bodies: &[Body]) -> f64 {
        let touched = self.pairs.iter().filter(|pair| pair.touched);
        touched.fold(0.0, |most, pair| most.max(self.kinematics(pair, bodies, 0.0).0.approach.abs()))
    }

    /// Whether any pair gave something.
    pub(crate) fn gave(&self) -> bool {
        self.pairs.iter().any(|pair| pair.given != 0.0)
    }
}
