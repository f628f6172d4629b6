//! The programs in `examples`, which use the library: they run, and print what they should.

use std::process::Command;

/// The numbers in what an example prints.
fn numbers(name: &str, arguments: &[&str]) -> Vec<f64> {
    let mut command = Command::new(env!("CARGO"));
    command.args(["run", "--release", "--quiet", "--example", name, "--"]).args(arguments);
    let output = command.current_dir(env!("CARGO_MANIFEST_DIR")).output().expect("cargo starts");
    let said = String::from_utf8_lossy(&output.stdout);
    print!("{name}: {said}");
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    said.split_whitespace()
        .filter_map(|word| word.trim_end_matches([',', ':']).parse().ok())
        .collect()
}

#[test]
fn examples_print_figures_of_theory() {
    // Viscosity, speed and theory.
    for flow in numbers("scene", &[]).chunks(3) {
        assert!((flow[1] / flow[2] - 1.0).abs() < 1e-3, "Poiseuille flow: {flow:?}");
    }
    let shape = numbers("shape", &[]);
    let ratio = shape[shape.len() - 1];
    assert!(0.9 < ratio && ratio < 1.0, "triangle and disc: {ratio}");
    let force = numbers("force", &[]);
    assert!((force[0] - 1.0).abs() < 0.01, "Kolmogorov flow: {force:?}");
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("energy.csv");
    let steps = numbers("steps", &[table.to_str().unwrap()]);
    assert!((steps[1] / 1.5791 - 1.0).abs() < 0.01, "vortex: {steps:?}");
    let rows = std::fs::read_to_string(table).unwrap().lines().count();
    assert_eq!(rows, 2 + steps[0] as usize, "a row a step");
    let petsc = numbers("petsc", &[]);
    assert!(petsc[0] < 100.0 && petsc[1] < 1e-6, "iterations and |D|: {petsc:?}");
}
