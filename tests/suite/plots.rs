//! `mics plot`: figures from one or several run folders.

use crate::support::{mics, run, shipped};
use std::path::Path;

fn short_run(out: &Path, viscosity: f64) {
    let viscosity = format!("fluid.viscosity={viscosity:?}");
    let words =
        ["--set", &viscosity, "--set", "domain.cells=[80,32]", "--set", "time.end=4.0", "--set", "measure.2.from=1.0"];
    let from = ["--set", "measure.0.from=1.0", "--set", "measure.1.from=1.0"];
    run(&shipped("cases/cylinder-wake/case.toml"), out, &[&words[..], &from].concat());
}

#[test]
fn several_runs_give_their_fields_and_together_drag_over_reynolds() {
    let dir = tempfile::tempdir().unwrap();
    let [a, b, out] = ["a", "b", "out"].map(|n| dir.path().join(n));
    short_run(&a, 20.0);
    short_run(&b, 5.0);
    std::fs::remove_dir_all(a.join("figures")).unwrap();
    let [a, b, out] = [&a, &b, &out].map(|p| p.to_str().unwrap());
    let output = mics(&["plot", a, b, "--out", out]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let listed = String::from_utf8(output.stdout).unwrap();
    for (folder, name) in
        [(a, "figures/vorticity"), (b, "figures/streamlines"), (b, "figures/forces"), (out, "drag_over_reynolds")]
    {
        for kind in ["png", "svg"] {
            let path = Path::new(folder).join(format!("{name}.{kind}"));
            assert!(listed.contains(path.to_str().unwrap()), "{listed}");
            let bytes = std::fs::read(&path).unwrap();
            assert!(bytes.len() > 2000 && (bytes.starts_with(b"\x89PNG") || bytes.starts_with(b"<svg")), "{path:?}");
        }
    }
}

#[test]
fn a_folder_without_a_run_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let output = mics(&["plot", dir.path().to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("not a run's folder") && said.contains("case.toml"), "{said}");
}
