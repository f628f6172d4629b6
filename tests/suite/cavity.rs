//! The lid-driven cavity at Re 1000 against the spectral solution of Botella & Peyret 1998.

use crate::support::{run, shipped};
use mics_run::snapshot::Snapshot;

/// Extremum of samples at equal spacing `h` (the first at h/2), by the parabola through its three
/// highest points.
fn extremum(values: &[f64], h: f64) -> (f64, f64) {
    let k =
        (1..values.len() - 1).max_by(|a, b| values[*a].abs().total_cmp(&values[*b].abs())).unwrap();
    let (a, b, c) = (values[k - 1], values[k], values[k + 1]);
    let shift = 0.5 * (a - c) / (a - 2.0 * b + c);
    (b - 0.25 * (a - c) * shift, (k as f64 + 0.5 + shift) * h)
}

#[test]
#[ignore = "until it is steady takes long; ci/weekly"]
fn lid_driven_cavity_extrema_within_1_5_percent_of_spectral() {
    let dir = tempfile::tempdir().unwrap();
    let case = shipped("cases/lid-driven-cavity/case.toml");
    let summary = run(&case, dir.path(), &["--set", "output.figures=false"]);
    let fields = std::fs::read_dir(dir.path().join("fields")).unwrap().map(|e| e.unwrap().path());
    let newest = fields.filter(|p| p.extension().unwrap() == "vti").max().unwrap();
    let snapshot = Snapshot::read(&newest).unwrap();
    let velocity = &snapshot.array("velocity").unwrap().values;
    let (n, h) = (snapshot.cells[0], snapshot.h[0]);
    let at = |i: usize, j: usize, a: usize| velocity[3 * (j * n + i) + a];
    // The centre lines lie between two columns (rows) of cells.
    let down: Vec<f64> = (0..n).map(|j| 0.5 * (at(n / 2 - 1, j, 0) + at(n / 2, j, 0))).collect();
    let across: Vec<f64> = (0..n).map(|i| 0.5 * (at(i, n / 2 - 1, 1) + at(i, n / 2, 1))).collect();
    let lower = &down[..n / 2];
    let (left, right) = across.split_at(n / 2);
    let (v_min, x_min) = extremum(right, h);
    let found = [extremum(lower, h), extremum(left, h), (v_min, x_min + 0.5)];

    let table = std::fs::read_to_string(shipped("cases/lid-driven-cavity/cavity.csv")).unwrap();
    let row = table.lines().find(|l| l.starts_with("1000b")).unwrap();
    let exact: Vec<f64> = row.split(',').skip(1).map(|v| v.parse().unwrap()).collect();
    let measures = ["u_least", "v_largest", "v_least"].map(|name| &summary["measures"][name]);
    for (((value, place), exact), measure) in found.into_iter().zip(exact.chunks(2)).zip(measures) {
        assert!((measure.as_f64().unwrap() - value).abs() < 1e-12, "the measure says {measure}");
        println!(
            "{value:.5} at {place:.4}, reference {:.5} at {:.4}: {:+.2} %",
            exact[0],
            exact[1],
            100.0 * (value / exact[0] - 1.0)
        );
        assert!((value / exact[0] - 1.0).abs() < 0.015, "{value} against {}", exact[0]);
        assert!((place - exact[1]).abs() < h, "{place} against {}", exact[1]);
    }
}
