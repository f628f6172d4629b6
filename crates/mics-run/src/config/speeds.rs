//! Speeds that are estimated from a case.
//!
//! ```text
//!   steady   min( G H^2/(2 mu), 50 (G H/rho)^(1/2) )     H: to the middle between walls or to the
//!                                                        far side from one, half the box where
//!                                                        bodies are held
//!   drive    min( steady, G t/rho )                      t: until the end
//! ```
//! The first is laminar, the second twice what turbulence lets through at friction Reynolds numbers
//! of some thousands.

use super::{Case, Side};

/// The stream that a case tells, and the length that its Reynolds number goes by.
pub struct Stream {
    /// Its speed (m/s).
    pub speed: f64,
    /// The largest diameter, or without particles the height of the box (m).
    pub length: f64,
    /// Name of that length, in words.
    pub of: &'static str,
    /// Reynolds number of both.
    pub reynolds: f64,
}

/// The stream in a fluid with viscosity; `None` where nothing but bodies moves.
pub fn stream(case: &Case) -> Option<Stream> {
    let nu = case.fluid.kinematic_viscosity();
    let speed = case.reference_speed().filter(|_| nu > 0.0)?;
    let largest = case.particle.iter().map(|p| p.shape.diameter()).fold(0.0, f64::max);
    let stream = |length: f64, of| Stream { speed, length, of, reynolds: speed * length / nu };
    Some(match largest > 0.0 {
        true => stream(largest, "largest diameter"),
        false => stream(case.domain.size[1], "height"),
    })
}

/// The largest force per volume (N/m3) that drives the fluid, given or of gravity along a slope;
/// `None` where there is no such drive.
fn driving_force(case: &Case) -> Option<f64> {
    let drive = case.drive.as_ref()?;
    Some(drive.largest_factor() * drive.push(case)?.norm())
}

/// The speed (m/s) of the fluid once friction balances that force; infinite where nothing holds
/// it.
fn steady_speed(case: &Case, force: f64) -> f64 {
    let is_wall = |side: &Side| matches!(side, Side::Wall | Side::MovingWall(_));
    let between = |axis: usize| {
        let size = case.domain.size[axis];
        let walls = case.boundary.ends(axis).filter(|side| is_wall(side)).count();
        match walls {
            0 => f64::INFINITY,
            1 => size,
            _ => 0.5 * size,
        }
    };
    let held = case.particle.iter().any(|p| !p.is_free());
    let narrow = case.domain.size.iter().copied().fold(f64::INFINITY, f64::min);
    let among = if held { 0.5 * narrow } else { f64::INFINITY };
    let way = (0..case.dimension()).map(between).fold(among, f64::min);
    (0.5 * force * way * way / case.fluid.viscosity)
        .min(50.0 * (force * way / case.fluid.density).sqrt())
}

/// The speed (m/s) to which the drive may bring the fluid until the end; `None` without a force
/// that drives it.
pub fn driven_speed(case: &Case) -> Option<f64> {
    let force = driving_force(case)?;
    Some(steady_speed(case, force).min(force * case.time.end / case.fluid.density))
}

/// The largest speed of the fluid (m/s) that the case itself tells, whenever it ends: of its
/// stream, its drive or its vortex. Where friction never balances the drive, it is that at the end.
pub fn fluid_speed(case: &Case) -> f64 {
    let driven = driving_force(case)
        .map(|force| steady_speed(case, force))
        .filter(|speed| speed.is_finite());
    let told =
        [case.reference_speed(), driven.or_else(|| driven_speed(case)), case.initial.taylor_green];
    told.into_iter().flatten().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::{driven_speed, fluid_speed};
    use crate::config::written;

    /// Springs go by it, and a run that goes on to a later end keeps its springs.
    #[test]
    fn speed_of_driven_channel_independent_of_end_time() {
        let speeds = |walls: &str, viscosity: f64, end: f64| {
            let text = format!(
                "name = \"d\"\ndomain = {{ size = [2.0, 1.0], cells = [32, 16] }}\n\
                fluid = {{ density = 1000.0, viscosity = {viscosity:?} }}\n\
                boundary = {{ west = \"periodic\", east = \"periodic\", south = {walls:?}, north = \
                {walls:?} }}\n\
                drive = {{ force = [10.0, 0.0] }}\ntime = {{ end = {end:?}, cfl = 0.4 }}\n"
            );
            let case = written(&text).unwrap();
            (fluid_speed(&case), driven_speed(&case).unwrap())
        };
        // Laminar: G H^2/(2 mu) with H = 0.5 m. Turbulent: no faster than 50 (G H/rho)^(1/2).
        for (viscosity, steady) in [(100.0, 0.0125), (0.001, 50.0 * 0.005f64.sqrt())] {
            let [(short, soon), (long, late)] =
                [1e-3, 1e6].map(|end| speeds("wall", viscosity, end));
            assert!(
                (short / steady - 1.0).abs() < 1e-12 && short == long,
                "{short}, {long} of {steady}"
            );
            assert!((soon / 1e-5 - 1.0).abs() < 1e-12 && late == long, "{soon}, {late}");
        }
        // Nothing holds it: as fast as it gets.
        assert_eq!(speeds("periodic", 1.0, 3.0), (0.03, 0.03));
    }
}
