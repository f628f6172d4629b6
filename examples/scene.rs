//! A scene that is built in Rust: flow between two walls, driven by a force, in three fluids. The
//! mean speed of Poiseuille flow is `F H^2/(12 mu)`, which it comes to within 0.01 %.
//!
//!     cargo run --release --example scene

use mics::Result;
use mics::config::Case;
use mics::petsc::Session;
use mics::scene::Scene;

/// Distance of the walls (m) and force on the fluid (N/m3).
const WIDTH: f64 = 2.0;
const FORCE: f64 = 1.5;

/// The case of a fluid of this viscosity (Pa s), to when its flow is steady.
fn channel(viscosity: f64) -> Result<Case> {
    let end = 10.0 * WIDTH.powi(2) / (9.8 * viscosity);
    let text = format!(
        r#"
        name = "channel"
        domain = {{ size = [1.0, {WIDTH:?}], cells = [8, 16] }}
        fluid = {{ density = 1.0, viscosity = {viscosity:?} }}
        boundary = {{ west = "periodic", east = "periodic", south = "wall", north = "wall" }}
        drive = {{ force = [{FORCE:?}, 0.0] }}
        time.end = {end:?}
        "#
    );
    text.parse()
}

/// The mean speed (m/s) that the flow of a case comes to.
fn mean_speed(session: &Session, case: &Case) -> Result<f64> {
    let mut scene = Scene::<2>::new(session, case)?;
    while scene.state.time < case.time.end {
        scene.step(0.01)?;
    }
    let mut sum = [scene.domain.grid.rows().flatten().map(|cell| scene.state.u[0][cell]).sum()];
    session.sum(&mut sum)?;
    Ok(sum[0] / scene.domain.grid.total_cells() as f64)
}

fn main() -> Result<()> {
    let session = Session::start(&[])?;
    for viscosity in [0.25, 0.5, 1.0] {
        let speed = mean_speed(&session, &channel(viscosity)?)?;
        let exact = FORCE * WIDTH.powi(2) / (12.0 * viscosity);
        if session.rank() == 0 {
            println!("{viscosity} Pa s: {speed:.4} m/s, theory {exact:.4}");
        }
    }
    Ok(())
}
