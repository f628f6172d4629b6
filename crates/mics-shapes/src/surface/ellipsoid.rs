//! The surface of an ellipse or an ellipsoid, `sum (x_i/a_i)^2 = 1`.
//!
//! ```text
//!      ,---.         q    nearest point on the surface, where  p - q  is normal to it:
//!     (  o  )  ---- p         q_i = a_i^2 p_i/(t + a_i^2)
//!      `---'
//! ```

/// Thickness of the skin of a curved body (m), by its smallest half width and its smallest radius
/// of curvature (m).
pub fn skin(half: f64, curvature: f64) -> f64 {
    (0.05 * half).min(0.5 * curvature)
}

/// The point of an ellipse or ellipsoid that is nearest to one, with these half axes (m): for a
/// point in the first octant `q_i = a_i^2 p_i/(t + a_i^2)`, with t the largest root of q on the
/// surface (Eberly); `u = t + least a_i^2` keeps its digits where t does not.
pub fn nearest<const D: usize>(half: [f64; D], point: [f64; D]) -> ([f64; D], [f64; D]) {
    let least = half.iter().copied().fold(f64::INFINITY, f64::min);
    let p = point.map(|x| x.abs().max(1e-14 * least));
    let square = half.map(|a| a * a);
    let lowest = least * least;
    let more = square.map(|square| square - lowest);
    // Newton's method for one over the root of the sum, which is concave and nearly straight: it
    // comes from below. Each term by itself is a bound, and so is the whole with all of a_i the
    // least (outside) or the largest one (inside).
    let mut u = 0.0f64;
    let mut norm = 0.0;
    let mut widest = 0.0f64;
    for a in 0..D {
        u = u.max(half[a] * p[a] - more[a]);
        norm += (p[a] / half[a]).powi(2);
        widest = widest.max(square[a]);
    }
    let scale = norm.sqrt() - 1.0;
    u = u.max(lowest + scale * if scale > 0.0 { lowest } else { widest });
    for _ in 0..100 {
        let mut value = 0.0;
        let mut slope = 0.0;
        for a in 0..D {
            let inverse = 1.0 / (u + more[a]);
            let term = half[a] * p[a] * inverse;
            value += term * term;
            slope += term * term * inverse;
        }
        let way = value * (value.sqrt() - 1.0) / slope;
        u += way.max(0.0);
        if way <= 1e-9 * u {
            break;
        }
    }
    let foot = std::array::from_fn(|a| (square[a] * p[a] / (u + more[a])).copysign(point[a]));
    let normal: [f64; D] = std::array::from_fn(|a| foot[a] / square[a]);
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    (foot, normal.map(|x| x / length))
}
