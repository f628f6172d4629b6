//! The speed at which drag holds the weight of an isolated body.
//!
//! ```text
//!   w V = Cd(Re) U^2 S/2       w: submerged weight over the fluid's mass in its volume, |s - 1| g;
//!              S: the area that it shows
//! ```
//! Cd of a cylinder is the paper's (30), `1 + 10 Re^(-2/3)` (White 1991); that of a sphere `24/Re
//! (1 + 0.15 Re^0.687)`, and 0.44 above Re = 1000 (Schiller & Naumann 1935).

use std::f64::consts::PI;

/// Reynolds number below which the flow has no boundary layer.
const LEAST_REYNOLDS: f64 = 10.0;

/// Thickness (m) of the boundary layer at the front of a body of this diameter (m): Hiemenz' at a
/// cylinder, `2.4 sqrt(nu/(4 U/d))`, which is `1.2 d/sqrt(Re)`; a sphere's has 1.15. Infinite where
/// there is none.
pub fn boundary_layer(diameter: f64, reynolds: f64) -> f64 {
    if reynolds < LEAST_REYNOLDS { f64::INFINITY } else { 1.2 * diameter / reynolds.sqrt() }
}

/// Terminal speed (m/s) of a sphere, or else of a cylinder across its axis, of this diameter (m)
/// and submerged weight (m/s2) in a fluid of this kinematic viscosity (m2/s).
pub fn terminal_speed(sphere: bool, diameter: f64, weight: f64, viscosity: f64) -> f64 {
    // V/S.
    let depth = if sphere { 2.0 / 3.0 * diameter } else { 0.25 * PI * diameter };
    // Terminal speed at Cd = 1 (m/s), and the least Cd, at high Reynolds numbers.
    let plain = (2.0 * weight * depth).sqrt();
    let least = if sphere { 0.44f64 } else { 1.0 };
    if viscosity > 0.0 {
        terminal_reynolds(sphere, plain * diameter / viscosity) * viscosity / diameter
    } else {
        plain / least.sqrt()
    }
}

/// Reynolds number at which `Cd Re^2` is `drive^2`; `drive` is the Reynolds number at Cd = 1.
fn terminal_reynolds(sphere: bool, drive: f64) -> f64 {
    let drag = |re: f64| match sphere {
        true if re > 1000.0 => 0.44,
        true => 24.0 / re * (1.0 + 0.15 * re.powf(0.687)),
        false => 1.0 + 10.0 * re.powf(-2.0 / 3.0),
    };
    // Cd Re^2 grows with Re.
    let mut low = -12.0f64;
    let mut high = 12.0;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let re = 10f64.powf(middle);
        if drag(re).sqrt() * re < drive { low = middle } else { high = middle }
    }
    10f64.powf(low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminal_speed_of_sphere_stokes_and_newton_drag() {
        // U = (s - 1) g d^2/(18 nu): Cd Re^2 = 24 Re.
        let stokes = terminal_reynolds(true, (24.0f64 * 1e-4).sqrt());
        assert!((stokes / 1e-4 - 1.0).abs() < 1e-3, "{stokes}");
        let fast = terminal_reynolds(true, 0.44f64.sqrt() * 5e4);
        assert!((fast / 5e4 - 1.0).abs() < 1e-9, "{fast}");
    }

    #[test]
    fn boundary_layer_thickness_over_reynolds_number() {
        // Hiemenz: 2.4 sqrt(nu/(4 U/d)) of U = 1 m/s, d = 0.2 m, nu = 0.002 m2/s.
        assert!((boundary_layer(0.2, 100.0) - 2.4 * (0.002f64 * 0.2 / 4.0).sqrt()).abs() < 1e-12);
        assert_eq!(boundary_layer(0.2, 9.9), f64::INFINITY);
    }
}
