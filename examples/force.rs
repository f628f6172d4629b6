//! A force of one's own on the fluid: `F sin(k y)` along x in a periodic box, which drives the flow
//! of Kolmogorov. Its speed comes to `F/(mu k^2)`, here 1 m/s.
//!
//!     cargo run --release --example force

use mics::Result;
use mics::config::Case;
use mics::force::Force;
use mics::petsc::Session;
use mics::scene::Scene;
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::sync::Arc;

/// The force `strength sin(wavenumber y)` (N/m3) along x.
struct Kolmogorov {
    strength: f64,
    wavenumber: f64,
}

impl Force for Kolmogorov {
    fn at(&self, place: &Vector3<f64>, _time: f64, _velocity: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(self.strength * (self.wavenumber * place.y).sin(), 0.0, 0.0)
    }
}

const CASE: &str = r#"
name = "kolmogorov"
domain = { size = [0.25, 1.0], cells = [8, 32] }
fluid = { density = 1.0, viscosity = 0.1 }
boundary = { west = "periodic", east = "periodic", south = "periodic", north = "periodic" }
time.end = 2.0
"#;

fn main() -> Result<()> {
    let session = Session::start(&[])?;
    let case: Case = CASE.parse()?;
    let force = Kolmogorov { strength: 0.1 * TAU * TAU, wavenumber: TAU };
    let mut scene = Scene::<2>::extended(&session, &case, None, vec![Arc::new(force)])?;
    while scene.state.time < case.time.end {
        scene.step(2e-3)?;
    }
    let speeds = scene.domain.grid.rows().flatten().map(|cell| scene.state.u[0][cell]);
    let mut largest = [speeds.fold(0.0, f64::max)];
    session.max(&mut largest)?;
    if session.rank() == 0 {
        println!("largest speed {:.4} m/s of 1 m/s", largest[0]);
    }
    Ok(())
}
