//! The widest vectors that the processor at hand has, chosen while running: one binary is fast
//! everywhere.
//!
//! A kernel is compiled twice, for AVX2 and for the baseline. The same sums are done in the same
//! order: the compiler forms no fused multiply-add by itself, so that the results agree to the last
//! bit.

/// Numbers that a loop treats at once.
const LANES: usize = 8;

/// Runs `kernel` compiled for the widest vectors. All that it calls has to be `#[inline(always)]`,
/// itself included.
#[inline(always)]
pub fn simd<R>(kernel: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(kernel)
}

/// The largest of the values that `value` gives to the places of a row, of 0 at least; a NaN counts
/// as infinity.
#[inline(always)]
pub fn largest(places: usize, value: impl Fn(usize) -> f64) -> f64 {
    // Separate lanes, and no branch: a NaN fails every comparison, so it is looked for beside.
    let mut most = [0.0f64; LANES];
    let mut lost = [0.0f64; LANES];
    let whole = places - places % LANES;
    for start in (0..whole).step_by(LANES) {
        for lane in 0..LANES {
            let v = value(start + lane);
            most[lane] = if v > most[lane] { v } else { most[lane] };
            // Zero times infinity is no number either, and counts as infinity all the same.
            lost[lane] += 0.0 * v;
        }
    }
    for place in whole..places {
        let v = value(place);
        most[0] = if v > most[0] { v } else { most[0] };
        lost[0] += 0.0 * v;
    }
    if lost.iter().any(|l| l.is_nan()) {
        f64::INFINITY
    } else {
        most.into_iter().fold(0.0, f64::max)
    }
}

/// The sum of what `value` gives to the places of a row, in eight partial sums.
#[inline(always)]
pub fn total(places: usize, value: impl Fn(usize) -> f64) -> f64 {
    let mut sums = [0.0; LANES];
    let whole = places - places % LANES;
    for start in (0..whole).step_by(LANES) {
        for lane in 0..LANES {
            sums[lane] += value(start + lane);
        }
    }
    (whole..places).for_each(|place| sums[0] += value(place));
    sums.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simd_maximum_at_any_position_keeps_nan() {
        for n in [1, 7, 8, 9, 30] {
            for at in 0..n {
                assert_eq!(largest(n, |i| if i == at { 2.0 } else { 1.0 }), 2.0);
                assert_eq!(largest(n, |i| if i == at { f64::NAN } else { 1.0 }), f64::INFINITY);
            }
        }
    }
}
