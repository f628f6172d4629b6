//! The velocities on lines of cells of a 2D box: extrema on those through its middle, and where
//! what flows along the south side attaches.
//!
//! ```text
//!   +---|---+     | x = size/2: the mean of the columns beside it, or the middle column
//!   |   |   |     - y = size/2: rows alike
//!   |---+---|     extremum: the parabola through the cell that has it and its two neighbours
//!   |   |   |
//!   +---|---+     shear at the side, by the parabola through 0 there and two cells above it:
//!                 du/dy = (9 u_0 - u_1)/(3 h)
//! ```

use crate::Result;
use crate::config::MeasureKind;
use crate::scene::Scene;

/// The value of a measure `kind` of a line; `None` for other kinds, and in 3D. Collective.
///
/// # Errors
/// When ranks cannot add up what they have of the line.
pub fn value<const D: usize>(kind: MeasureKind, scene: &Scene<D>) -> Result<Option<f64>> {
    if kind == MeasureKind::Reattachment {
        return reattachment(scene);
    }
    let (axis, along, sign) = match kind {
        MeasureKind::MidlineULeast => (0, 1, -1.0),
        MeasureKind::MidlineVLeast => (1, 0, -1.0),
        MeasureKind::MidlineVLargest => (1, 0, 1.0),
        _ => return Ok(None),
    };
    let grid = &scene.domain.grid;
    let u = &scene.state.u[axis];
    let Ok(cells) = <[usize; 2]>::try_from(&grid.cells[..]) else { return Ok(None) };
    let own = |cell: [usize; 2]| {
        grid.owned_index(std::array::from_fn(|a| cell[a])).map_or(0.0, |c| sign * u[c])
    };
    let mut values = line(cells, along, own);
    scene.domain.session.sum(&mut values)?;
    Ok(Some(sign * peak(&values)))
}

/// The largest x at which the shear at the south side turns from backward to forward (m); `None`
/// where it does not, and in 3D. Collective.
fn reattachment<const D: usize>(scene: &Scene<D>) -> Result<Option<f64>> {
    let grid = &scene.domain.grid;
    let u = &scene.state.u[0];
    let Ok(cells) = <[usize; 2]>::try_from(&grid.cells[..]) else { return Ok(None) };
    let at = |i: usize, j: usize| {
        grid.owned_index(std::array::from_fn(|a| [i, j][a])).map_or(0.0, |c| u[c])
    };
    let mut shear: Vec<f64> = (0..cells[0]).map(|i| 9.0 * at(i, 0) - at(i, 1)).collect();
    scene.domain.session.sum(&mut shear)?;
    Ok(last_rise(&shear).map(|place| (place + 0.5) * grid.h[0]))
}

/// Where samples last pass from below 0 to above, on the line between two of them.
fn last_rise(values: &[f64]) -> Option<f64> {
    let k = values.windows(2).rposition(|pair| pair[0] < 0.0 && pair[1] >= 0.0)?;
    Some(k as f64 + values[k] / (values[k] - values[k + 1]))
}

/// The values of cells on the line along an axis through the middle of the other.
fn line(cells: [usize; 2], along: usize, value: impl Fn([usize; 2]) -> f64) -> Vec<f64> {
    let across = cells[1 - along];
    // The two cells, or twice the one, in the middle.
    let pair = [(across - 1) / 2, across / 2];
    let at = |i: usize, j: usize| value(if along == 0 { [i, j] } else { [j, i] });
    (0..cells[along]).map(|i| 0.5 * pair.iter().map(|j| at(i, *j)).sum::<f64>()).collect()
}

/// The largest of samples at equal spacing, by a parabola where it has neighbours on both sides.
fn peak(values: &[f64]) -> f64 {
    let top = (0..values.len()).max_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap_or(0);
    let Some(&[a, b, c]) =
        top.checked_sub(1).and_then(|low| values.get(low..top + 2)?.first_chunk())
    else {
        return values.get(top).copied().unwrap_or(f64::NAN);
    };
    let bend = a - 2.0 * b + c;
    if bend < 0.0 { b - (a - c) * (a - c) / (8.0 * bend) } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn last_rise_is_between_two_samples() {
        assert_eq!(last_rise(&[-1.0, 1.0, -1.0, -3.0, 1.0, 2.0]), Some(3.75));
        assert_eq!(last_rise(&[1.0, 2.0, -1.0]), None);
    }

    #[test]
    fn midline_extrema_exact_for_parabola() {
        for cells in [[8, 8], [9, 7]] {
            let place = |cell: [usize; 2], a: usize| (cell[a] as f64 + 0.5) / cells[a] as f64;
            // On the midlines 1 - 3 (y - 0.3)^2 and 2 - (x - 0.6)^2; a slope across them is
            // averaged out.
            let u = line(cells, 1, |at| {
                (place(at, 0) - 0.5) + 1.0 - 3.0 * (place(at, 1) - 0.3).powi(2)
            });
            let v = |sign: f64| {
                line(cells, 0, |at| {
                    sign * (2.0 * (place(at, 1) - 0.5) + 2.0 - (place(at, 0) - 0.6).powi(2))
                })
            };
            assert!((peak(&u) - 1.0).abs() < 1e-12);
            assert!((peak(&v(1.0)) - 2.0).abs() < 1e-12);
            // The least is in an outermost cell, which has no neighbour beyond.
            let first = 0.5 / cells[0] as f64;
            assert!((-peak(&v(-1.0)) - 2.0 + (first - 0.6).powi(2)).abs() < 1e-12);
        }
    }
}
