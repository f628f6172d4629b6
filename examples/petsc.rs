//! The pressure equation solved by options of PETSc; without any by conjugate gradients with
//! PETSc's algebraic multigrid. A free disc falls for ten steps.
//! Whatever solves, |D| of every cell is below the limit of the case.
//!
//!     cargo run --release --example petsc -- -ksp_type cg -pc_type gamg

use mics::Result;
use mics::config::Case;
use mics::petsc::Session;
use mics::scene::Scene;

const CASE: &str = r#"
name = "falling"
domain = { size = [0.5, 1.0], cells = [64, 128] }
fluid = { density = 1000.0, viscosity = 0.1, gravity = [0.0, -9.81] }
boundary = { west = "wall", east = "wall", south = "wall", north = "wall" }
particle = [{ shape.disc.diameter = 0.1, density = 2650.0, position = [0.25, 0.7] }]
pressure.divergence_limit = 1e-6
time.end = 1.0
"#;

fn main() -> Result<()> {
    let mut options: Vec<String> = std::env::args().skip(1).collect();
    if options.is_empty() {
        options = ["-ksp_type", "cg", "-pc_type", "gamg"].map(str::to_owned).into();
    }
    let session = Session::start(&options)?;
    let case: Case = CASE.parse()?;
    let mut scene = Scene::<2>::new(&session, &case)?;
    let steps = 10;
    let mut iterations = 0;
    let mut divergence = 0.0f64;
    for _ in 0..steps {
        let report = scene.step(1e-3)?;
        iterations += report.projected.krylov;
        divergence = divergence.max(report.projected.divergence_max);
    }
    let solver = scene.solver()?;
    if session.rank() == 0 {
        let mean = f64::from(iterations) / f64::from(steps);
        println!("{solver}: {mean:.1} iterations a step, |D| up to {divergence:.1e} 1/s");
    }
    Ok(())
}
