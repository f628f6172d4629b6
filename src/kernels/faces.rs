//! From cells to faces and back: eq. (8) and (16), and the acceleration that both share.
//!
//! ```text
//!      p(c-1)   |   p(c)
//!              acceleration a_f = -(1/rho_f) (p(c) - p(c-1))/h + g (1 - rho_fluid/rho_f)
//!     ----------f----------     1/rho_f = 2/(rho(c-1) + rho(c))
//!                               (8)   U_f = (u*(c-1) + u*(c))/2 + dt a_f
//!                               (16)  u(c) = u*(c) + dt (a_low + a_high)/2
//! ```
//! Averaging the face's acceleration back to cells, gravity with pressure, keeps a fluid at rest at
//! rest and density ratios of 10^4 stable.

use crate::grid::{Coefficient, Grid, VectorField, largest, simd};

/// `1/rho` on faces (m3/kg), one place for the predictor, the operator and the correction.
#[derive(Clone, Debug)]
pub enum FaceCoefficient<const D: usize> {
    /// One value for all faces.
    Uniform(f64),
    /// By axis and face.
    Field(VectorField<D>),
}

impl<const D: usize> FaceCoefficient<D> {
    /// The coefficient that goes with a density; a field is filled by [`FaceCoefficient::update`].
    pub fn new(grid: &Grid<D>, density: &Coefficient) -> Self {
        match density {
            Coefficient::Uniform(rho) => FaceCoefficient::Uniform(1.0 / rho),
            Coefficient::Field(_) => FaceCoefficient::Field(grid.vector_field()),
        }
    }

    /// `2/(rho(c-1) + rho(c))` from a density (kg/m3) with its ghosts filled.
    pub fn update(&mut self, grid: &Grid<D>, density: &Coefficient) {
        let (FaceCoefficient::Field(faces), Coefficient::Field(rho)) = (self, density) else {
            return;
        };
        for (axis, face) in faces.iter_mut().enumerate() {
            let s = grid.stride[axis];
            for c in grid.face_rows(axis).flatten() {
                face[c] = 2.0 / (rho[c - s] + rho[c]);
            }
        }
    }

    /// Its values by face; one value for all becomes one for each.
    pub fn field(&mut self, grid: &Grid<D>) -> &mut VectorField<D> {
        if let FaceCoefficient::Uniform(value) = *self {
            *self =
                FaceCoefficient::Field(std::array::from_fn(|_| vec![value; grid.field().len()]));
        }
        match self {
            FaceCoefficient::Field(faces) => faces,
            FaceCoefficient::Uniform(_) => unreachable!("it has just become a field"),
        }
    }

    /// The value at the low face of cell `c` along `axis`.
    #[inline(always)]
    pub fn at(&self, axis: usize, c: usize) -> f64 {
        match self {
            FaceCoefficient::Uniform(value) => *value,
            FaceCoefficient::Field(faces) => faces[axis][c],
        }
    }
}

/// Adds `factor (1/rho) dq/dn` to the faces. Ghosts of `q` carry the boundary's condition.
pub fn add_gradient<const D: usize>(
    grid: &Grid<D>,
    beta: &FaceCoefficient<D>,
    factor: f64,
    q: &[f64],
    faces: &mut VectorField<D>,
) {
    gradient(
        grid,
        beta,
        factor,
        q,
        faces,
        #[inline(always)]
        |face, part| *face += part,
    );
}

/// Hands every face and `factor (1/rho) dq/dn` there to `put`.
#[inline(always)]
fn gradient<const D: usize>(
    grid: &Grid<D>,
    beta: &FaceCoefficient<D>,
    factor: f64,
    q: &[f64],
    faces: &mut VectorField<D>,
    put: impl Fn(&mut f64, f64),
) {
    simd(
        #[inline(always)]
        || {
            for (axis, face) in faces.iter_mut().enumerate() {
                let s = grid.stride[axis];
                let factor = factor / grid.h[axis];
                for row in grid.face_rows(axis) {
                    let low = &q[row.start - s..row.end - s];
                    let high = &q[row.clone()];
                    let out = &mut face[row.clone()];
                    let terms = out.iter_mut().zip(low).zip(high);
                    match beta {
                        FaceCoefficient::Uniform(b) => {
                            terms.for_each(|((f, l), h)| put(f, factor * b * (h - l)))
                        }
                        FaceCoefficient::Field(b) => terms
                            .zip(&b[axis][row])
                            .for_each(|(((f, l), h), b)| put(f, factor * b * (h - l))),
                    }
                }
            }
        },
    );
}

/// The acceleration by pressure on faces (m/s2); closed faces are left to the caller.
pub fn acceleration<const D: usize>(
    grid: &Grid<D>,
    beta: &FaceCoefficient<D>,
    p: &[f64],
    faces: &mut VectorField<D>,
) {
    gradient(
        grid,
        beta,
        -1.0,
        p,
        faces,
        #[inline(always)]
        |face, part| *face = part,
    );
}

/// The means of the cells along a row of faces, of fourth order: `(-1, 9, 9, -1)/16` across each.
#[inline(always)]
pub fn means(q: &[f64], row: std::ops::Range<usize>, stride: usize) -> impl Fn(usize) -> f64 {
    let [far_low, low, high, far_high] =
        std::array::from_fn(|k| &q[row.start + k * stride - 2 * stride..][..row.len()]);
    move |i| 0.5625 * (low[i] + high[i]) - 0.0625 * (far_low[i] + far_high[i])
}

/// Eq. (8): `U = mean of u* + dt a` on every face; ghosts of `u` filled. Boundaries are the
/// caller's. The mean is of two cells, as printed, or of `four`, with which the carrying velocity
/// is of fourth order as well.
pub fn predict<const D: usize>(
    grid: &Grid<D>,
    u: &VectorField<D>,
    four: bool,
    dt: f64,
    acceleration: &VectorField<D>,
    faces: &mut VectorField<D>,
) {
    simd(
        #[inline(always)]
        || {
            for (axis, face) in faces.iter_mut().enumerate() {
                let s = grid.stride[axis];
                for row in grid.face_rows(axis) {
                    let face = &mut face[row.clone()];
                    if four {
                        let mean = means(&u[axis], row.clone(), s);
                        face.iter_mut().enumerate().for_each(|(i, f)| *f = mean(i));
                    } else {
                        let low = &u[axis][row.start - s..row.end - s];
                        let high = &u[axis][row.clone()];
                        face.iter_mut()
                            .zip(low)
                            .zip(high)
                            .for_each(|((f, l), h)| *f = 0.5 * (l + h));
                    }
                    face.iter_mut().zip(&acceleration[axis][row]).for_each(|(f, a)| *f += dt * a);
                }
            }
        },
    );
}

/// Eq. (16): adds `dt (a_low + a_high)/2` to the cells.
pub fn add_to_cells<const D: usize>(
    grid: &Grid<D>,
    dt: f64,
    acceleration: &VectorField<D>,
    u: &mut VectorField<D>,
) {
    simd(
        #[inline(always)]
        || {
            for (axis, field) in u.iter_mut().enumerate() {
                let a = &acceleration[axis];
                for row in grid.rows() {
                    let low = &a[row.clone()];
                    let high = &a[row.start + grid.stride[axis]..][..row.len()];
                    for ((u, l), h) in field[row].iter_mut().zip(low).zip(high) {
                        *u += 0.5 * dt * (l + h);
                    }
                }
            }
        },
    );
}

/// Start or end of a stage, in the cells: `to = from + factor rate + dt (a_low + a_high)/2`.
pub fn step_cells<const D: usize>(
    grid: &Grid<D>,
    from: &VectorField<D>,
    factor: f64,
    rate: &VectorField<D>,
    dt: f64,
    acceleration: &VectorField<D>,
    to: &mut VectorField<D>,
) {
    simd(
        #[inline(always)]
        || {
            for (axis, to) in to.iter_mut().enumerate() {
                let a = &acceleration[axis];
                for row in grid.rows() {
                    let low = &a[row.clone()];
                    let high = &a[row.start + grid.stride[axis]..][..row.len()];
                    let terms = rate[axis][row.clone()].iter().zip(low).zip(high);
                    let fields = to[row.clone()].iter_mut().zip(&from[axis][row]);
                    for ((to, u), ((r, l), h)) in fields.zip(terms) {
                        *to = u + factor * r + 0.5 * dt * (l + h);
                    }
                }
            }
        },
    );
}

/// Start of a stage of a recurrence, in the cells: `to = before to + sum of factor field + dt
/// (a_low + a_high)/2`.
pub fn recur_cells<const D: usize>(
    grid: &Grid<D>,
    before: f64,
    terms: [(f64, &VectorField<D>); 4],
    dt: f64,
    acceleration: &VectorField<D>,
    to: &mut VectorField<D>,
) {
    simd(
        #[inline(always)]
        || {
            for (axis, to) in to.iter_mut().enumerate() {
                let a = &acceleration[axis];
                for row in grid.rows() {
                    let [p, q, r, s] =
                        terms.map(|(factor, field)| (factor, &field[axis][row.clone()]));
                    let low = &a[row.clone()];
                    let high = &a[row.start + grid.stride[axis]..][..row.len()];
                    let fields =
                        p.1.iter().zip(q.1).zip(r.1.iter().zip(s.1)).zip(low.iter().zip(high));
                    for (to, (((u, v), (f, g)), (l, h))) in to[row].iter_mut().zip(fields) {
                        *to = before * *to
                            + p.0 * u
                            + q.0 * v
                            + r.0 * f
                            + s.0 * g
                            + 0.5 * dt * (l + h);
                    }
                }
            }
        },
    );
}

/// Eq. (16) as printed: adds `-dt (p_high - p_low)/(2 h rho)` to the cells; ghosts of `p` (Pa)
/// filled. Decoupled from the faces' gradient, it does not survive large density ratios.
pub fn add_cell_gradient<const D: usize>(
    grid: &Grid<D>,
    density: &Coefficient,
    dt: f64,
    p: &[f64],
    u: &mut VectorField<D>,
) {
    for (axis, field) in u.iter_mut().enumerate() {
        for c in grid.rows().flatten() {
            field[c] -= dt / density.at(c) * cell_gradient(grid, axis, c, p);
        }
    }
}

/// The gradient of `p`, ghosts filled, along an axis at a cell, from its two neighbours.
#[inline]
pub fn cell_gradient<const D: usize>(grid: &Grid<D>, axis: usize, cell: usize, p: &[f64]) -> f64 {
    let s = grid.stride[axis];
    (p[cell + s] - p[cell - s]) / (2.0 * grid.h[axis])
}

/// Divergence of the face velocities in the owned cells (1/s), put into `out`, which is indexed as
/// a field.
pub fn divergence<const D: usize>(grid: &Grid<D>, faces: &VectorField<D>, out: &mut [f64]) {
    simd(
        #[inline(always)]
        || {
            for row in grid.rows() {
                for axis in 0..D {
                    let s = grid.stride[axis];
                    let factor = 1.0 / grid.h[axis];
                    let low = &faces[axis][row.clone()];
                    let high = &faces[axis][row.start + s..row.end + s];
                    for ((d, l), h) in out[row.clone()].iter_mut().zip(low).zip(high) {
                        let part = factor * (h - l);
                        *d = if axis == 0 { part } else { *d + part };
                    }
                }
            }
        },
    );
}

/// The largest velocity through a face of this rank (m/s).
pub fn fastest<const D: usize>(grid: &Grid<D>, faces: &VectorField<D>) -> f64 {
    simd(
        #[inline(always)]
        || {
            let mut most = 0.0f64;
            for (axis, faces) in faces.iter().enumerate() {
                for row in grid.face_rows(axis) {
                    let u = &faces[row];
                    let in_row = largest(
                        u.len(),
                        #[inline(always)]
                        |i| u[i].abs(),
                    );
                    most = most.max(in_row);
                }
            }
            most
        },
    )
}

/// The largest over this rank's cells of the Courant number for `dt = 1`: `sum_a max(|U_low|,
/// |U_high|)/h_a` (1/s), or the largest of these terms where advection goes axis by axis.
pub fn courant_rate<const D: usize>(grid: &Grid<D>, faces: &VectorField<D>, by_axis: bool) -> f64 {
    simd(
        #[inline(always)]
        || {
            let mut most = 0.0f64;
            for row in grid.rows() {
                let low: [&[f64]; D] = std::array::from_fn(|a| &faces[a][row.clone()]);
                let high: [&[f64]; D] =
                    std::array::from_fn(|a| &faces[a][row.start + grid.stride[a]..][..row.len()]);
                let rate =
                    |a: usize, i: usize| greater(low[a][i].abs(), high[a][i].abs()) / grid.h[a];
                let in_row = if by_axis {
                    largest(
                        row.len(),
                        #[inline(always)]
                        |i| (0..D).fold(0.0, |most, a| greater(rate(a, i), most)),
                    )
                } else {
                    largest(
                        row.len(),
                        #[inline(always)]
                        |i| (0..D).fold(0.0, |sum, a| sum + rate(a, i)),
                    )
                };
                most = most.max(in_row);
            }
            most
        },
    )
}

/// The greater of two numbers, one instruction; not to be asked about NaN.
#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
