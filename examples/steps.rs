//! A loop that reads the state in each step: the energy of a decaying vortex of Taylor and Green
//! goes into a table of one's own, `energy.csv` or the file that the command line names. In 2D it
//! decays at the rate `4 nu k^2`, here 1.5791 1/s.
//!
//!     cargo run --release --example steps -- energy.csv

use mics::config::Case;
use mics::petsc::Session;
use mics::scene::Scene;
use mics::step_size::choose_step;
use mics::{Error, Result};
use std::fmt::Write as _;

const CASE: &str = r#"
name = "vortex"
domain = { size = [1.0, 1.0], cells = [48, 48] }
fluid = { density = 1.0, viscosity = 0.01 }
boundary = { west = "periodic", east = "periodic", south = "periodic", north = "periodic" }
initial.taylor_green = 1.0
time = { end = 1.0, cfl = 0.4 }
"#;

/// The kinetic energy of the fluid (J/m). Every rank has a part of the cells.
fn energy(scene: &Scene<2>) -> Result<f64> {
    let square = |cell: usize| scene.state.u.iter().map(|u| u[cell] * u[cell]).sum::<f64>();
    let mut sum = [scene.domain.grid.rows().flatten().map(square).sum()];
    scene.domain.session.sum(&mut sum)?;
    Ok(0.5 * scene.domain.fluid.density * scene.domain.grid.cell_volume() * sum[0])
}

fn main() -> Result<()> {
    let session = Session::start(&[])?;
    let case: Case = CASE.parse()?;
    let mut scene = Scene::<2>::new(&session, &case)?;
    let begin = energy(&scene)?;
    let mut table = format!("time,energy\n0,{begin}\n");
    let mut before = None;
    while scene.state.time < case.time.end * (1.0 - 1e-12) {
        let left = case.time.end - scene.state.time;
        let dt = choose_step(&case, &scene.limits()?, before, left).0;
        scene.step(dt)?;
        before = Some(dt);
        // Writing into a String cannot fail.
        let _ = writeln!(table, "{},{}", scene.state.time, energy(&scene)?);
    }
    let rate = (begin / energy(&scene)?).ln() / scene.state.time;
    if session.rank() == 0 {
        let path = std::env::args().nth(1).unwrap_or("energy.csv".to_owned());
        std::fs::write(&path, table).map_err(Error::io(&path))?;
        println!("{} steps, the energy decays at {rate:.4} 1/s", scene.state.steps);
    }
    Ok(())
}
