//! With the paper's mixing a body that lies on a floor leaves the fluid still.

use crate::support::{columns, run};

/// What contacts hold a body with acts on faces as gravity does. Given to the cells after each step instead, it drove a flow around a disc at rest whose
/// energy grew to 1.8e-6 J in 0.05 s, at any step, until the run ended with energy from nothing.
#[test]
fn a_disc_on_a_floor_leaves_the_fluid_still() {
    for (x, step) in [(0.0252, "1e-3"), (0.0252, "2e-4"), (0.0246, "5e-4")] {
        let text = format!(
            "name = \"floor\"\ndomain = {{ size = [0.05, 0.04], cells = [40, 32] }}\n\
             fluid = {{ density = 1000.0, viscosity = 1e-3, gravity = [0.0, -9.81] }}\n\
             coupling = {{ wall = \"mixing\" }}\ncontact = {{ friction = 0.4 }}\ntime = {{ end = 0.1, step = {step} }}\n\
             boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" }}\n\
             [[particle]]\nshape.disc.diameter = 0.01\ndensity = 2650.0\nposition = [{x:?}, 0.005]\n"
        );
        let dir = tempfile::tempdir().unwrap();
        let (case, out) = (dir.path().join("case.toml"), dir.path().join("run"));
        std::fs::write(&case, text).unwrap();
        run(&case, &out, &["--set", "output.figures=false"]);
        let steps = columns(&out.join("steps.csv"));
        let energy = &steps["kinetic_energy"];
        let (last, most) = (*energy.last().unwrap(), energy.iter().copied().fold(0.0, f64::max));
        println!("x = {x}, step {step} s: {last:.1e} J of {most:.1e} J are left");
        assert!(last < 2e-9, "x = {x}, step {step} s: {last} J");
    }
}
