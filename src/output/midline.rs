//! The velocities on the lines through the middle of a 2D box, and their extrema.
//!
//! ```text
//!   +---|---+     | x = size/2: the mean of the columns beside it, or the middle column
//!   |   |   |     - y = size/2: rows alike
//!   |---+---|     extremum: the parabola through the cell that has it and its two neighbours
//!   |   |   |
//!   +---|---+
//! ```

use super::snapshot::Snapshot;
use crate::config::MeasureKind;

/// The value of a measure `kind` of a midline; `None` for other kinds, and where there is no 2D velocity.
pub fn extremum(kind: MeasureKind, snapshot: &Snapshot) -> Option<f64> {
    let velocity = &snapshot.array("velocity")?.values;
    let [nx, ny, 1] = snapshot.cells else { return None };
    let at = |i: usize, j: usize, axis: usize| velocity.get(3 * (j * nx + i) + axis).copied();
    // The two cells, or twice the one, in the middle of n.
    let pair = |n: usize| [(n - 1) / 2, n / 2];
    let down =
        || (0..ny).map(|j| Some(0.5 * pair(nx).map(|i| at(i, j, 0)).into_iter().sum::<Option<f64>>()?)).collect();
    let across =
        || (0..nx).map(|i| Some(0.5 * pair(ny).map(|j| at(i, j, 1)).into_iter().sum::<Option<f64>>()?)).collect();
    let (values, sign): (Option<Vec<f64>>, f64) = match kind {
        MeasureKind::MidlineULeast => (down(), -1.0),
        MeasureKind::MidlineVLeast => (across(), -1.0),
        MeasureKind::MidlineVLargest => (across(), 1.0),
        _ => return None,
    };
    let values: Vec<f64> = values?.into_iter().map(|v| sign * v).collect();
    Some(sign * peak(&values))
}

/// The largest of samples at equal spacing, by a parabola where it has neighbours on both sides.
fn peak(values: &[f64]) -> f64 {
    let top = (0..values.len()).max_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap_or(0);
    let Some(&[a, b, c]) = top.checked_sub(1).and_then(|low| values.get(low..top + 2)?.first_chunk()) else {
        return values.get(top).copied().unwrap_or(f64::NAN);
    };
    let bend = a - 2.0 * b + c;
    if bend < 0.0 { b - (a - c) * (a - c) / (8.0 * bend) } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::snapshot::Array;

    #[test]
    fn parabolas_of_velocity_give_their_own_extrema_on_even_and_odd_grids() {
        for cells in [[8, 8, 1], [9, 7, 1]] {
            let mut values = Vec::new();
            for k in 0..cells[0] * cells[1] {
                let place = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
                let (x, y) = (place(k % cells[0], cells[0]), place(k / cells[0], cells[1]));
                // On the midlines -1 + 3 (y - 0.3)^2 and 2 - (x - 0.6)^2; a slope across them is averaged out.
                values.extend([
                    (x - 0.5) - 1.0 + 3.0 * (y - 0.3).powi(2),
                    2.0 * (y - 0.5) + 2.0 - (x - 0.6).powi(2),
                    0.0,
                ]);
            }
            let velocity = Array { name: "velocity".into(), components: 3, values };
            let snapshot = Snapshot { time: 0.0, cells, h: [1.0; 3], arrays: vec![velocity] };
            let of = |kind| extremum(kind, &snapshot).unwrap();
            assert!((of(MeasureKind::MidlineULeast) + 1.0).abs() < 1e-12);
            assert!((of(MeasureKind::MidlineVLargest) - 2.0).abs() < 1e-12);
            // The least is in an outermost cell, which has no neighbour beyond.
            let first = 0.5 / cells[0] as f64;
            assert!((of(MeasureKind::MidlineVLeast) - 2.0 + (first - 0.6).powi(2)).abs() < 1e-12);
        }
        let empty = Snapshot { time: 0.0, cells: [4, 4, 4], h: [1.0; 3], arrays: Vec::new() };
        assert_eq!(extremum(MeasureKind::MidlineULeast, &empty), None);
    }
}
