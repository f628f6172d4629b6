//! The direct solve where the coefficient is uniform: transforms along all axes but the last, which
//! is tridiagonal.
//!
//! ```text
//!   ends of an axis            vectors, i = 0 .. n-1          eigenvalue 4 g sin^2(t/2)     by
//!   periodic                   cos + sin (t i)                t = 2 pi k/n     Fourier, as Hartley
//!   no gradient on either      cos(t (i + 1/2))               t = pi k/n           DCT-II, DCT-III
//!   zero on the face, either   sin(t (i + 1/2))               t = pi (k + 1)/n     DST-II, DST-III
//!   no gradient low, zero high cos(t (i + 1/2))               t = pi (k + 1/2)/n            DCT-IV
//!   zero low, no gradient high sin(t (i + 1/2))               t = pi (k + 1/2)/n            DST-IV
//! ```
//! Exact in one application where every open face has the same `g = beta/h^2` along an axis;
//! elsewhere, with the mean of them, a preconditioner. A periodic last axis is transformed too.

use realfft::num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};
use rustdct::{DctPlanner, TransformType2And3, TransformType4};
use std::f64::consts::PI;
use std::sync::Arc;

/// What is at the two ends of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Ends {
    Periodic,
    /// Whether the pressure is given (zero on the face) at the low and the high end.
    Boundaries {
        given: [bool; 2],
    },
}

/// The transform of one axis and its scratch.
struct Axis {
    n: usize,
    /// From one number of a line to the next.
    stride: usize,
    kind: Kind,
    /// 4 sin^2(t/2).
    spectrum: Vec<f64>,
    /// Lines beside each other, worked off together so that memory is read in whole cache lines.
    lines: Vec<f64>,
    scratch: Vec<f64>,
}

enum Kind {
    Fourier {
        plan: Arc<dyn RealToComplex<f64>>,
        out: Vec<Complex<f64>>,
        scratch: Vec<Complex<f64>>,
    },
    /// No gradient on either end (false), or zero on both.
    Second(Arc<dyn TransformType2And3<f64>>, bool),
    /// No gradient at the low end and zero at the high one (false), or the other way.
    Fourth(Arc<dyn TransformType4<f64>>, bool),
}

/// Lines worked off together: a cache line of doubles.
const TOGETHER: usize = 8;

impl Axis {
    fn new(n: usize, stride: usize, ends: Ends) -> Axis {
        let angle: fn(f64, f64) -> f64 = match ends {
            Ends::Periodic => |k, n| 2.0 * PI * k / n,
            Ends::Boundaries { given: [false, false] } => |k, n| PI * k / n,
            Ends::Boundaries { given: [true, true] } => |k, n| PI * (k + 1.0) / n,
            Ends::Boundaries { .. } => |k, n| PI * (k + 0.5) / n,
        };
        let (kind, scratch) = match ends {
            Ends::Periodic => {
                let plan = RealFftPlanner::new().plan_fft_forward(n);
                let (out, scratch) = (plan.make_output_vec(), plan.make_scratch_vec());
                (Kind::Fourier { plan, out, scratch }, 0)
            }
            Ends::Boundaries { given: [low, high] } if low == high => {
                let plan = DctPlanner::new().plan_dct2(n);
                let scratch = plan.get_scratch_len();
                (Kind::Second(plan, low), scratch)
            }
            Ends::Boundaries { given: [low, _] } => {
                let plan = DctPlanner::new().plan_dct4(n);
                let scratch = plan.get_scratch_len();
                (Kind::Fourth(plan, low), scratch)
            }
        };
        Axis {
            n,
            stride,
            kind,
            spectrum: (0..n)
                .map(|k| 4.0 * (0.5 * angle(k as f64, n as f64)).sin().powi(2))
                .collect(),
            lines: vec![0.0; if stride == 1 { 0 } else { n * TOGETHER }],
            scratch: vec![0.0; scratch],
        }
    }

    /// What a transform and its inverse multiply by.
    fn gain(&self) -> f64 {
        if matches!(self.kind, Kind::Fourier { .. }) { self.n as f64 } else { 0.5 * self.n as f64 }
    }

    /// Transforms all lines along this axis, or back.
    fn apply(&mut self, data: &mut [f64], back: bool) {
        let Axis { n, stride, kind, lines, scratch, .. } = self;
        let (n, stride) = (*n, *stride);
        if stride == 1 {
            data.chunks_exact_mut(n).for_each(|line| kind.line(line, scratch, back));
            return;
        }
        for block in data.chunks_exact_mut(n * stride) {
            for first in (0..stride).step_by(TOGETHER) {
                let count = TOGETHER.min(stride - first);
                for (i, from) in block.chunks_exact(stride).enumerate() {
                    for (k, v) in from[first..first + count].iter().enumerate() {
                        lines[k * n + i] = *v;
                    }
                }
                lines
                    .chunks_exact_mut(n)
                    .take(count)
                    .for_each(|line| kind.line(line, scratch, back));
                for (i, to) in block.chunks_exact_mut(stride).enumerate() {
                    for (k, v) in to[first..first + count].iter_mut().enumerate() {
                        *v = lines[k * n + i];
                    }
                }
            }
        }
    }
}

impl Kind {
    fn line(&mut self, line: &mut [f64], scratch: &mut [f64], back: bool) {
        match self {
            Kind::Fourier { plan, out, scratch } => {
                // The lengths are the plan's own, so that nothing can be refused.
                let done = plan.process_with_scratch(line, out, scratch);
                debug_assert!(done.is_ok());
                // Hartley's transform: real, and its own inverse.
                let n = line.len();
                line[0] = out[0].re;
                for (k, c) in out.iter().enumerate().skip(1) {
                    line[k] = c.re - c.im;
                    line[n - k] = c.re + c.im;
                }
            }
            Kind::Second(plan, false) if back => plan.process_dct3_with_scratch(line, scratch),
            Kind::Second(plan, false) => plan.process_dct2_with_scratch(line, scratch),
            Kind::Second(plan, true) if back => plan.process_dst3_with_scratch(line, scratch),
            Kind::Second(plan, true) => plan.process_dst2_with_scratch(line, scratch),
            Kind::Fourth(plan, false) => plan.process_dct4_with_scratch(line, scratch),
            Kind::Fourth(plan, true) => plan.process_dst4_with_scratch(line, scratch),
        }
    }
}

/// The last axis of what the transforms leave: a tridiagonal system for each of their numbers, all
/// beside each other.
struct Lines {
    given: [bool; 2],
    n: usize,
    /// The inverse pivots, layer by layer.
    pivots: Vec<f64>,
    g: f64,
}

/// The direct solver.
pub(super) struct Transform {
    axes: Vec<Axis>,
    last: Option<Lines>,
    /// Numbers in a layer of the last axis that is solved by elimination, or in all.
    layer: usize,
    singular: bool,
    /// The transforms' eigenvalues (1/(s2 Pa) per unit), one for each number in a layer; inverted,
    /// and with the transforms' gain, where there is no elimination.
    spectrum: Vec<f64>,
    gain: f64,
}

impl Transform {
    /// For `n` cells along two or three axes.
    pub fn new(n: [usize; 3], axes: usize, ends: [Ends; 3]) -> Transform {
        let last = match ends[axes - 1] {
            Ends::Periodic => None,
            Ends::Boundaries { given } => Some(given),
        };
        let transformed = if last.is_some() { axes - 1 } else { axes };
        let axis = |a: usize| Axis::new(n[a], n[..a].iter().product(), ends[a]);
        let layer = n[..transformed].iter().product();
        let made: Vec<Axis> = (0..transformed).map(axis).collect();
        let fixed = |e: &Ends| matches!(e, Ends::Boundaries { given } if given[0] || given[1]);
        Transform {
            last: last.map(|given| Lines {
                given,
                n: n[axes - 1],
                pivots: vec![0.0; layer * n[axes - 1]],
                g: 0.0,
            }),
            gain: made.iter().map(|axis| 1.0 / axis.gain()).product(),
            singular: !ends[..axes].iter().any(fixed),
            spectrum: vec![0.0; layer],
            axes: made,
            layer,
        }
    }

    /// Takes `g = beta/h^2` of each axis.
    pub fn set(&mut self, g: [f64; 3]) {
        let mut stride = 1;
        self.spectrum.fill(0.0);
        for (axis, g) in self.axes.iter().zip(g) {
            for (k, s) in self.spectrum.iter_mut().enumerate() {
                *s += g * axis.spectrum[k / stride % axis.n];
            }
            stride *= axis.n;
        }
        let (singular, layer) = (self.singular, self.layer);
        match &mut self.last {
            Some(lines) => lines.eliminate(&self.spectrum, g[self.axes.len()], singular),
            None => {
                for s in &mut self.spectrum {
                    *s = self.gain / *s;
                }
                if singular && layer > 0 {
                    // The constants: what is left of them in the right side is rounding.
                    self.spectrum[0] = 0.0;
                }
            }
        }
    }

    /// `A z = r`.
    pub fn solve(&mut self, r: &[f64], z: &mut [f64]) {
        z.copy_from_slice(r);
        self.axes.iter_mut().for_each(|axis| axis.apply(z, false));
        match &self.last {
            Some(lines) => lines.solve(z, self.layer, self.gain),
            None => z.iter_mut().zip(&self.spectrum).for_each(|(z, s)| *z *= s),
        }
        self.axes.iter_mut().rev().for_each(|axis| axis.apply(z, true));
    }
}

impl Lines {
    fn eliminate(&mut self, spectrum: &[f64], g: f64, singular: bool) {
        self.g = g;
        let (layer, last) = (spectrum.len(), self.n - 1);
        for i in 0..self.n {
            let end = |at: usize, given: bool| {
                if i != at {
                    1.0
                } else if given {
                    2.0
                } else {
                    0.0
                }
            };
            let diagonal = g * (end(0, self.given[0]) + end(last, self.given[1]));
            let (before, here) = self.pivots.split_at_mut(i * layer);
            let here = &mut here[..layer];
            match before.len().checked_sub(layer) {
                None => here.iter_mut().zip(spectrum).for_each(|(p, s)| *p = 1.0 / (diagonal + s)),
                Some(at) => {
                    for ((p, s), b) in here.iter_mut().zip(spectrum).zip(&before[at..]) {
                        *p = 1.0 / (diagonal + s - g * g * b);
                    }
                }
            }
        }
        if singular {
            // Constants are left over: the last layer's mean is set to zero in their place.
            self.pivots[last * layer] = 0.0;
        }
    }

    fn solve(&self, z: &mut [f64], layer: usize, gain: f64) {
        let g = self.g;
        for i in 0..self.n {
            let (before, here) = z.split_at_mut(i * layer);
            let (here, pivots) = (&mut here[..layer], &self.pivots[i * layer..][..layer]);
            match before.len().checked_sub(layer) {
                None => here.iter_mut().zip(pivots).for_each(|(z, p)| *z *= gain * p),
                Some(at) => {
                    for ((z, p), b) in here.iter_mut().zip(pivots).zip(&before[at..]) {
                        *z = (gain * *z + g * b) * p;
                    }
                }
            }
        }
        for i in (0..self.n.saturating_sub(1)).rev() {
            let (here, after) = z.split_at_mut((i + 1) * layer);
            let (here, pivots) = (&mut here[i * layer..], &self.pivots[i * layer..][..layer]);
            for ((z, p), a) in here.iter_mut().zip(pivots).zip(&after[..layer]) {
                *z += g * p * a;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every pair of ends in two and three dimensions, odd and even numbers of cells: what comes
    /// out solves the system.
    #[test]
    fn transform_solves_uniform_system_in_one_application() {
        let ends = [[false, false], [true, true], [false, true], [true, false]]
            .map(|given| Ends::Boundaries { given });
        let ends = [Ends::Periodic].into_iter().chain(ends).collect::<Vec<_>>();
        for (x, y) in ends.iter().flat_map(|x| ends.iter().map(move |y| (*x, *y))) {
            for (n, axes) in
                [([7, 8, 1], 2), ([12, 5, 1], 2), ([1, 6, 1], 2), ([6, 5, 9], 3), ([5, 2, 4], 3)]
            {
                check(n, axes, [x, y, x], [1.5, 0.7, 2.2]);
            }
        }
    }

    fn check(n: [usize; 3], axes: usize, ends: [Ends; 3], g: [f64; 3]) {
        let total = n.iter().product::<usize>();
        let singular = !ends[..axes]
            .iter()
            .any(|e| matches!(e, Ends::Boundaries { given } if given[0] || given[1]));
        let mut r: Vec<f64> = (0..total).map(|c| (3.7 * c as f64 + 0.3).cos()).collect();
        if singular {
            let mean = r.iter().sum::<f64>() / total as f64;
            r.iter_mut().for_each(|r| *r -= mean);
        }
        let mut z = vec![0.0; total];
        let mut transform = Transform::new(n, axes, ends);
        transform.set(g);
        transform.solve(&r, &mut z);
        let size = z.iter().fold(1.0f64, |m, z| m.max(z.abs()));
        for c in 0..total {
            let mut left = -r[c];
            for a in 0..axes {
                let stride: usize = n[..a].iter().product();
                let at = c / stride % n[a];
                for (end, round, near) in [(0, n[a] - 1, -1isize), (n[a] - 1, 0, 1)] {
                    let side = usize::from(near == 1);
                    let flux = match ends[a] {
                        _ if at != end => z[c] - z[c.wrapping_add_signed(near * stride as isize)],
                        Ends::Periodic => z[c] - z[c - at * stride + round * stride],
                        Ends::Boundaries { given } if given[side] => 2.0 * z[c],
                        Ends::Boundaries { .. } => 0.0,
                    };
                    left += g[a] * flux;
                }
            }
            assert!(
                left.abs() < 1e-12 * size,
                "{n:?} {ends:?}: {left:e} in cell {c} of values of {size:e}"
            );
        }
    }
}
