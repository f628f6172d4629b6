//! Conjugate gradients with the multigrid, whose numbers are summed over the ranks once an
//! iteration, and which touch each number as seldom as that allows:
//!
//! ```text
//!   z = B r                            cycle of the multigrid, in single precision
//!   w = A z                            sums: (r,z) (z,w) (z,s) (r,w) (r,s) (w,w) (w,s) (r,r) (1,z)
//!   beta = (r,z)/(r,z)_before          (p,Ap) = (z,w) + 2 beta (z,s) + beta^2 (p,Ap)_before
//!   p = z + beta p,  s = w + beta s    s = A p
//!   x += alpha p,  r -= alpha s        alpha = (r,z)/(p,Ap)
//!   (r,r)_next = (r,r) - 2 alpha (r,s) + alpha^2 (s,s)      known before r is
//! ```
//! The method is that of Hestenes and Stiefel in the order of A. Chronopoulos and C. W. Gear (1989,
//! J. Comput. Appl. Math. 25, 153-168); (p,Ap) is not taken for granted to be `(z,w) - beta
//! (r,z)/alpha_before`, which single precision in B makes inexact.

use super::lattice::{Lattice, exchange};
use super::level::Level;
use super::multigrid::Multigrid;
use super::{Cached, Poisson};
use crate::Result;
use crate::grid::{simd, total};
use crate::petsc::{Ended, Goal};

/// The least part of |r|^2 that an iteration is believed to leave: what follows from the sums is
/// rounding below it.
const ROUNDING: f64 = 1e-12;

/// Growth of |r| at which the iteration ends as divergent, as PETSc's does.
const GROWTH: f64 = 1e5;

/// The vectors of the iteration: this rank's cells, x fastest.
#[derive(Default)]
pub(super) struct Conjugate {
    r: Vec<f64>,
    p: Vec<f64>,
    s: Vec<f64>,
    w: Vec<f64>,
}

/// The sums of an iteration, in the order of the module's first lines.
#[derive(Clone, Copy, Default)]
struct Sums {
    rz: f64,
    zw: f64,
    zs: f64,
    rw: f64,
    rs: f64,
    ww: f64,
    ws: f64,
    rr: f64,
    z: f64,
}

/// What an iteration keeps for the next one.
#[derive(Clone, Copy)]
struct Scalars {
    /// 0 in the first iteration, which reads no p and no s.
    beta: f64,
    alpha: f64,
    rz: f64,
    pap: f64,
    ss: f64,
    /// Sums of p and x over all cells.
    p: f64,
    x: f64,
}

impl Sums {
    fn numbers(&self) -> [f64; 9] {
        [self.rz, self.zw, self.zs, self.rw, self.rs, self.ww, self.ws, self.rr, self.z]
    }

    fn of([rz, zw, zs, rw, rs, ww, ws, rr, z]: [f64; 9]) -> Sums {
        Sums { rz, zw, zs, rw, rs, ww, ws, rr, z }
    }

    /// Takes the change of `w` by `change`, where it was `before`.
    fn change(&mut self, before: f64, change: f64, (r, z, s): (f64, f64, f64)) {
        self.zw += z * change;
        self.rw += r * change;
        self.ws += s * change;
        self.ww += change * (2.0 * before + change);
    }
}

impl Poisson {
    /// Solves `A x = b` from zero; see [`crate::petsc::Operator::solve`].
    pub(super) fn conjugate_gradients(
        &mut self,
        b: &mut [f64],
        x: &mut [f64],
        goal: Goal,
        mut residuals: Option<&mut Vec<f64>>,
    ) -> Result<(Ended, u32)> {
        let mut vectors = std::mem::take(&mut self.conjugate);
        let solved = self.iterate(&mut vectors, b, x, goal, &mut |residual| {
            residuals.iter_mut().for_each(|list| list.push(residual));
        });
        self.conjugate = vectors;
        solved
    }

    fn iterate(
        &mut self,
        v: &mut Conjugate,
        b: &mut [f64],
        x: &mut [f64],
        goal: Goal,
        residual: &mut dyn FnMut(f64),
    ) -> Result<(Ended, u32)> {
        self.multigrid()?;
        let cells = self.whole.cells() as f64;
        // In single precision numbers have to lie around one.
        let size_of = |rr: f64| (rr / cells).sqrt();
        let mut rr = self.begin(v, b, size_of)?;
        let first = rr.sqrt();
        residual(first);
        let enough = (goal.rtol * first).max(goal.atol);
        if !first.is_finite() {
            return Ok((Ended::NotFinite, 0));
        }
        if first <= enough {
            x.fill(0.0);
            return Ok((Ended::Converged, 0));
        }
        let mut last: Option<Scalars> = None;
        for k in 1..=goal.iterations {
            let (multigrid, bodies) = self.multigrid()?;
            multigrid.cycle(bodies, true)?;
            let up = size_of(rr) / self.largest;
            let sums = self.product(v, last.is_none(), up)?;
            let now = match next(last, &sums) {
                Ok(now) => now,
                Err(ended) => return Ok((ended, k - 1)),
            };
            let rs = sums.rw + now.beta * sums.rs;
            let after = sums.rr - 2.0 * now.alpha * rs + now.alpha * now.alpha * now.ss;
            rr = after.max(ROUNDING * sums.rr);
            residual(rr.sqrt());
            let done = rr.sqrt() <= enough;
            let mean = if self.singular { now.x / cells } else { 0.0 };
            let end = if done { Err(mean) } else { Ok(1.0 / size_of(rr)) };
            self.advance(v, x, &now, (last.is_none(), up), end);
            if done {
                return Ok((Ended::Converged, k));
            }
            if !rr.is_finite() || rr.sqrt() > GROWTH * first {
                let lost = if rr.is_finite() { Ended::Diverged } else { Ended::NotFinite };
                return Ok((lost, k));
            }
            last = Some(now);
        }
        Ok((Ended::TooMany, goal.iterations))
    }

    /// Takes the mean out of b, where constants solve the homogeneous system, begins with r = b,
    /// and gives the multigrid r over its size. Returns |b|^2. Collective.
    fn begin(
        &mut self,
        v: &mut Conjugate,
        b: &mut [f64],
        size_of: impl Fn(f64) -> f64,
    ) -> Result<f64> {
        for vector in [&mut v.r, &mut v.p, &mut v.s, &mut v.w] {
            vector.resize(b.len(), 0.0);
        }
        let row = &*b;
        let mut sums = simd(
            #[inline(always)]
            || {
                [
                    total(
                        row.len(),
                        #[inline(always)]
                        |i| row[i] * row[i],
                    ),
                    total(
                        row.len(),
                        #[inline(always)]
                        |i| row[i],
                    ),
                ]
            },
        );
        self.session.sum(&mut sums)?;
        let mean = if self.singular { sums[1] / self.whole.cells() as f64 } else { 0.0 };
        let bb = (sums[0] - mean * sums[1]).max(0.0);
        let down = 1.0 / size_of(bb);
        let Some(Cached { made: Multigrid { levels, .. }, .. }) = &mut self.multigrid else {
            return Ok(bb);
        };
        let (lattice, nx, given) = (levels[0].lattice, self.lattice.n[0], &mut levels[0].b);
        simd(
            #[inline(always)]
            || {
                for (row, at) in lattice.rows().enumerate() {
                    let range = row * nx..(row + 1) * nx;
                    let (b, r) = (&mut b[range.clone()], &mut v.r[range]);
                    let given = &mut given[at..][..nx];
                    for i in 0..nx {
                        b[i] -= mean;
                        r[i] = b[i];
                        given[i] = (down * b[i]) as f32;
                    }
                }
            },
        );
        Ok(bb)
    }

    /// w = A z of the z that the multigrid has found, times `up`, and the sums of it all over the
    /// ranks. Collective.
    fn product(&mut self, v: &mut Conjugate, first: bool, up: f64) -> Result<Sums> {
        let Poisson { session, lattice, g, bodies, held, multigrid, .. } = self;
        let Some(Cached { made: Multigrid { levels, .. }, .. }) = multigrid else {
            return Ok(Sums::default());
        };
        let level = &mut levels[0];
        exchange(&mut level.halo, lattice.axes, &mut level.x)?;
        let (z, nx) = (&level.x, lattice.n[0]);
        let value = |place: usize| up * f64::from(z[place]);
        if bodies.any() {
            let ny = lattice.n[1];
            bodies.respond(|row| lattice.row(row % ny, row / ny), value)?;
        }
        let (bodies, Conjugate { r, s, w, .. }) = (&*bodies, v);
        let mut sums = simd(
            #[inline(always)]
            || {
                let mut lanes = [[0.0; LANES]; 9];
                for (row, at) in lattice.rows().enumerate() {
                    let range = row * nx..(row + 1) * nx;
                    let w = &mut w[range.clone()];
                    lattice.for_row(
                        g,
                        z,
                        at,
                        w,
                        #[inline(always)]
                        |_, _, flux: f64| -up * flux,
                    );
                    bodies.terms(row).for_each(
                        #[inline(always)]
                        |(at, term)| w[at] += term,
                    );
                    let (r, s, z) = (&r[range.clone()], &s[range], &z[at..][..nx]);
                    match first {
                        true => add_row::<true>(&mut lanes, (r, z, w, s), up),
                        false => add_row::<false>(&mut lanes, (r, z, w, s), up),
                    }
                }
                Sums::of(lanes.map(|lane| lane.iter().sum()))
            },
        );
        let of_row = |row: usize| value(lattice.place(row));
        held.add_product(session, of_row, |row, change| {
            let s = if first { 0.0 } else { s[row] };
            sums.change(w[row], change, (r[row], of_row(row), s));
            w[row] += change;
        })?;
        let mut numbers = sums.numbers();
        session.sum(&mut numbers)?;
        Ok(Sums::of(numbers))
    }

    /// The new p, s, x and r, and r times a factor for the multigrid; of a last iteration only x,
    /// less its mean.
    fn advance(
        &mut self,
        v: &mut Conjugate,
        x: &mut [f64],
        now: &Scalars,
        (first, up): (bool, f64),
        goes_on: std::result::Result<f64, f64>,
    ) {
        let Some(Cached { made: Multigrid { levels, .. }, .. }) = &mut self.multigrid else {
            return;
        };
        let Level { lattice, x: z, b, .. } = &mut levels[0];
        let (lattice, z) = (&*lattice, &z[..]);
        match (first, goes_on) {
            (true, Ok(down)) => advance::<true>(v, x, now, (lattice, z, up), (b, down)),
            (false, Ok(down)) => advance::<false>(v, x, now, (lattice, z, up), (b, down)),
            (true, Err(mean)) => end::<true>(v, x, now, mean, (lattice, z, up)),
            (false, Err(mean)) => end::<false>(v, x, now, mean, (lattice, z, up)),
        }
    }
}

/// The numbers of an iteration, from those of the one before and the sums.
fn next(last: Option<Scalars>, sums: &Sums) -> std::result::Result<Scalars, Ended> {
    let Sums { rz, zw, zs, ww, ws, z, .. } = *sums;
    if !sums.numbers().iter().all(|n| n.is_finite()) {
        return Err(Ended::NotFinite);
    }
    if rz <= 0.0 {
        return Err(Ended::IndefinitePreconditioner);
    }
    let beta = last.map_or(0.0, |last| rz / last.rz);
    let of_last = |f: fn(&Scalars) -> f64| last.as_ref().map_or(0.0, f);
    let pap = zw + beta * (2.0 * zs + beta * of_last(|last| last.pap));
    if pap <= 0.0 {
        return Err(Ended::IndefiniteOperator);
    }
    let alpha = rz / pap;
    let ss = ww + beta * (2.0 * ws + beta * of_last(|last| last.ss));
    let p = z + beta * of_last(|last| last.p);
    let x = of_last(|last| last.x) + alpha * p;
    Ok(Scalars { beta, alpha, rz, pap, ss, p, x })
}

/// Partial sums at once.
const LANES: usize = 4;

/// Adds a row to the sums; `FIRST`, where there is no s yet.
#[inline(always)]
fn add_row<const FIRST: bool>(
    lanes: &mut [[f64; LANES]; 9],
    (r, z, w, s): (&[f64], &[f32], &[f64], &[f64]),
    up: f64,
) {
    let n = r.len();
    let (z, w, s) = (&z[..n], &w[..n], &s[..n]);
    let whole = n - n % LANES;
    for start in (0..whole).step_by(LANES) {
        for lane in 0..LANES {
            let i = start + lane;
            let s = if FIRST { 0.0 } else { s[i] };
            add_cell::<FIRST>(lanes, lane, (r[i], up * f64::from(z[i]), w[i], s));
        }
    }
    for i in whole..n {
        let s = if FIRST { 0.0 } else { s[i] };
        add_cell::<FIRST>(lanes, 0, (r[i], up * f64::from(z[i]), w[i], s));
    }
}

/// Adds a cell to one of the partial sums.
#[inline(always)]
fn add_cell<const FIRST: bool>(
    lanes: &mut [[f64; LANES]; 9],
    lane: usize,
    (r, z, w, s): (f64, f64, f64, f64),
) {
    lanes[0][lane] += r * z;
    lanes[1][lane] += z * w;
    lanes[3][lane] += r * w;
    lanes[5][lane] += w * w;
    lanes[7][lane] += r * r;
    lanes[8][lane] += z;
    if !FIRST {
        lanes[2][lane] += z * s;
        lanes[4][lane] += r * s;
        lanes[6][lane] += w * s;
    }
}

/// The new p, s, x and r, and r times `down`.
fn advance<const FIRST: bool>(
    v: &mut Conjugate,
    x: &mut [f64],
    now: &Scalars,
    (lattice, z, up): (&Lattice, &[f32], f64),
    (given, down): (&mut [f32], f64),
) {
    let (Conjugate { r, p, s, w }, nx, beta, alpha) = (v, lattice.n[0], now.beta, now.alpha);
    simd(
        #[inline(always)]
        || {
            for (row, at) in lattice.rows().enumerate() {
                let range = row * nx..(row + 1) * nx;
                let (z, w) = (&z[at..][..nx], &w[range.clone()]);
                let (r, p) = (&mut r[range.clone()], &mut p[range.clone()]);
                let (s, x) = (&mut s[range.clone()], &mut x[range]);
                let given = &mut given[at..][..nx];
                for i in 0..nx {
                    let z = up * f64::from(z[i]);
                    let (new_p, new_s) =
                        if FIRST { (z, w[i]) } else { (z + beta * p[i], w[i] + beta * s[i]) };
                    (p[i], s[i]) = (new_p, new_s);
                    x[i] = if FIRST { alpha * new_p } else { x[i] + alpha * new_p };
                    r[i] -= alpha * new_s;
                    given[i] = (down * r[i]) as f32;
                }
            }
        },
    );
}

/// The last x, less its mean.
fn end<const FIRST: bool>(
    v: &Conjugate,
    x: &mut [f64],
    now: &Scalars,
    mean: f64,
    (lattice, z, up): (&Lattice, &[f32], f64),
) {
    let (nx, beta, alpha) = (lattice.n[0], now.beta, now.alpha);
    simd(
        #[inline(always)]
        || {
            for (row, at) in lattice.rows().enumerate() {
                let range = row * nx..(row + 1) * nx;
                let (z, p, x) = (&z[at..][..nx], &v.p[range.clone()], &mut x[range]);
                for i in 0..nx {
                    let z = up * f64::from(z[i]);
                    x[i] = match FIRST {
                        true => alpha * z - mean,
                        false => x[i] + alpha * (z + beta * p[i]) - mean,
                    };
                }
            }
        },
    );
}
