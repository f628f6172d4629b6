//! Closed outlines in 2D.

use crate::Fault;
use nalgebra::Vector2;

/// The area within an outline (m2), negative where it runs clockwise.
pub(crate) fn area(outline: &[[f64; 2]]) -> f64 {
    let at = |k: usize| Vector2::from(outline[k % outline.len()]);
    (0..outline.len()).map(|k| 0.5 * at(k).perp(&at(k + 1))).sum()
}

/// Refuses an outline that bounds nothing or crosses itself, with its corners by number.
pub(crate) fn check(outline: &[[f64; 2]]) -> Result<(), Fault> {
    let n = outline.len();
    if n < 3 {
        return Err(Fault(format!("an outline has {n} corners, and needs three at least")));
    }
    if let Some(k) = outline.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
        return Err(Fault(format!("corner {} of an outline is no place", k + 1)));
    }
    let at = |k: usize| Vector2::from(outline[k % n]);
    if let Some(k) = (0..n).find(|k| at(*k) == at(k + 1)) {
        return Err(Fault(format!("corners {} and {} are one place", k + 1, (k + 1) % n + 1)));
    }
    let side = |a: &Vector2<f64>, b: &Vector2<f64>, c: &Vector2<f64>| (b - a).perp(&(c - a));
    for i in 0..n {
        for j in i + 2..n - usize::from(i == 0) {
            let a = at(i);
            let b = at(i + 1);
            let c = at(j);
            let d = at(j + 1);
            let apart = side(&a, &b, &c) * side(&a, &b, &d) < 0.0
                && side(&c, &d, &a) * side(&c, &d, &b) < 0.0;
            if apart {
                let why = format!(
                    "the outline crosses itself: its edges after corners {} and {} do",
                    i + 1,
                    j + 1
                );
                return Err(Fault(why));
            }
        }
    }
    Ok(())
}
