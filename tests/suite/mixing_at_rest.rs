//! With the paper's mixing a body that lies on a floor leaves the fluid still.

use crate::support::{columns, run};

/// What contacts hold a body with acts on faces as gravity does. Given to the cells after each step instead, it drove a flow around a disc at rest whose
/// energy grew to 1.8e-6 J in 0.05 s, at any step, until the run ended with energy from nothing. What holds a body that lies there from the start is found
/// before the first step, without which that alone leaves 7e-7 J to the fluid in a step of 1e-3 s.
#[test]
fn a_disc_on_a_floor_leaves_the_fluid_still() {
    // In steps as short as the contact the disc first sinks into it.
    for (x, step, bounds) in
        [(0.0252, "", [1e-11, 1e-13]), (0.0252, ", step = 2e-4", [1e-7, 1e-9]), (0.0246, ", step = 1e-3", [1e-7, 1e-9])]
    {
        let text = format!(
            "name = \"floor\"\ndomain = {{ size = [0.05, 0.04], cells = [40, 32] }}\n\
             fluid = {{ density = 1000.0, viscosity = 1e-3, gravity = [0.0, -9.81] }}\n\
             coupling = {{ wall = \"mixing\" }}\ncontact = {{ friction = 0.4 }}\ntime = {{ end = 0.1{step} }}\n\
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
        println!("x = {x}{step}: at most {most:.1e} J, {last:.1e} J at the end");
        assert!(most < bounds[0] && last < bounds[1], "x = {x}{step}: at most {most} J, {last} J at the end");
    }
}
