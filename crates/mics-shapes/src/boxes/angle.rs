//! An arctangent that a loop over many numbers can do four at a time, which libm's cannot.
//!
//! ```text
//!   atan(q) = q + q^3 P(q^2)/Q(q^2)   |q| < 0.66, to 2e-16   (Moshier's Cephes library, atan.c)
//!   steeper: pi/4 + atan((y - x)/(y + x)),  steepest: pi/2 - atan(x/y)
//! ```

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Angle of the point (x, y) from the x-axis, within pi/2 (rad); x is at least zero. Zero of (0,
/// 0); odd in y to the last bit.
#[inline(always)]
pub fn angle(y: f64, x: f64) -> f64 {
    let high = y.abs();
    let is_steep = high > 0.66 * x;
    let is_steepest = high > 2.4 * x;
    let above = if is_steepest { -x } else { high - x };
    let below = if is_steepest { high } else { high + x };
    let base = if is_steepest { FRAC_PI_2 } else { FRAC_PI_4 };
    let above = if is_steep { above } else { high };
    let below = if is_steep { below } else { x };
    let base = if is_steep { base } else { 0.0 };
    let q = above / (below + f64::MIN_POSITIVE);
    let z = q * q;
    let p = (((-8.750608600031904e-1 * z - 16.15753718733365) * z - 75.00855792314705) * z
        - 122.8866684490136)
        * z
        - 64.85021904942025;
    let divisor = ((((z + 24.85846490142306) * z + 165.0270098316988) * z + 432.8810604912903) * z
        + 485.3903996359137)
        * z
        + 194.5506571482614;
    (base + (q + q * z * (p / divisor))).copysign(y)
}

/// Sign of a number, and zero of zero.
#[inline(always)]
pub fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { 1f64.copysign(x) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scatter::scatter;

    #[test]
    fn angle_equals_arctangent_of_libm() {
        let mut worst = 0.0f64;
        for k in 0..100_000 {
            let y = scatter(2 * k) * 10f64.powf(4.0 * scatter(2 * k + 1));
            worst = worst.max((angle(y, 1.0) - y.atan2(1.0)).abs());
        }
        for [y, x] in [[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [1e-300, 1.0], [0.66, 1.0]]
        {
            worst = worst.max((angle(y, x) - f64::atan2(y, x)).abs());
        }
        println!("largest difference: {worst:.1e}");
        assert!(worst < 5e-16, "{worst:e}");
    }
}
