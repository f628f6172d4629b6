//! A shape of one's own: a triangle of Reuleaux, by a formula, settles in a closed box. It has to
//! be slower than the disc of its area, by one to five hundredths.
//!
//!     cargo run --release --example shape

use mics::config::Case;
use mics::geometry::{Disc, Shape, shapes::Polygon};
use mics::particles::{Body, Freedom, Motion};
use mics::{Error, Result, petsc::Session, scene::Scene};
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

const CASE: &str = r#"
name = "triangle"
domain = { size = [8.0e-3, 16.0e-3], cells = [64, 128] }
fluid = { density = 1000.0, viscosity = 0.05, gravity = [0.0, -9.81] }
boundary = { west = "wall", east = "wall", south = "wall", north = "wall" }
time.end = 0.2
"#;

/// Three arcs of the radius `width` (m), each about the corner across.
fn reuleaux(width: f64) -> Result<Polygon> {
    let point = |i: usize| {
        let about = TAU / 3.0 * (i / 40) as f64;
        let angle = about + PI + PI / 3.0 * ((i % 40) as f64 / 40.0 - 0.5);
        let along = |of: fn(f64) -> f64| width * (of(about) / 3f64.sqrt() + of(angle));
        [along(f64::cos), along(f64::sin)]
    };
    let outline: Vec<_> = (0..120).map(point).collect();
    Polygon::new(&outline, 0.0).map_err(|fault| Error::Usage(fault.0))
}

/// The largest speed (m/s) at which a body of this shape settles.
fn settling_speed(session: &Session, shape: Arc<dyn Shape>) -> Result<f64> {
    let case: Case = CASE.parse()?;
    let mut body = Body::new(shape, 1500.0, 0.05, Vector3::new(4e-3, 12e-3, 0.0));
    let [translation, rotation] = [[true, true, false], [false, false, true]];
    body.motion = Motion::Free(Freedom { translation, rotation });
    let mut scene = Scene::<2>::with_bodies(session, &case, vec![body])?;
    let mut fastest = 0.0f64;
    while scene.state.time < case.time.end {
        scene.step(1e-3)?;
        fastest = fastest.max(-scene.state.bodies[0].velocity.y);
    }
    Ok(fastest)
}

fn main() -> Result<()> {
    let session = Session::start(&[])?;
    let triangle = reuleaux(2e-3)?;
    let disc = Disc { radius: (triangle.volume() / PI).sqrt() };
    let of_triangle = settling_speed(&session, Arc::new(triangle))?;
    let of_disc = settling_speed(&session, Arc::new(disc))?;
    if session.rank() == 0 {
        println!("{of_triangle:.4} m/s, the disc {of_disc:.4} m/s: {:.4}", of_triangle / of_disc);
    }
    Ok(())
}
