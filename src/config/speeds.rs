//! Speeds that a case foretells.
//!
//! ```text
//!   drive    min( G L^2/(c mu), G t/rho )     c = 8 between walls L apart or where bodies are held, 2 beside one wall; t: until the end
//! ```

use super::{Case, Drive, Side};

impl Case {
    /// The speed (m/s) to which a given force, or gravity along a slope, may bring the fluid; `None` where there is no such drive.
    pub fn driven_speed(&self) -> Option<f64> {
        let axes = || (0..self.dimension()).filter(|axis| self.periodic(*axis));
        let force: f64 = match self.drive.as_ref()? {
            Drive::Force(force) => axes().map(|a| force[a] * force[a]).sum::<f64>().sqrt(),
            Drive::Gravity => self.fluid.density * axes().map(|a| self.fluid.gravity[a].powi(2)).sum::<f64>().sqrt(),
            Drive::MeanVelocity(_) | Drive::HoldMixture => return None,
        };
        let is_wall = |side: &Side| matches!(side, Side::Wall | Side::MovingWall(_));
        let between = |axis: usize| {
            let (size, walls) =
                (self.domain.size[axis], self.boundary[axis].iter().filter(|side| is_wall(side)).count());
            match walls {
                0 => f64::INFINITY,
                1 => size * size / 2.0,
                _ => size * size / 8.0,
            }
        };
        let held = self.particle.iter().any(|p| !p.is_free());
        let narrow = self.domain.size.iter().copied().fold(f64::INFINITY, f64::min);
        let among = if held { narrow * narrow / 8.0 } else { f64::INFINITY };
        let squared = (0..self.dimension()).map(between).fold(among, f64::min);
        let viscous = if self.fluid.viscosity > 0.0 { force * squared / self.fluid.viscosity } else { f64::INFINITY };
        Some(viscous.min(force * self.time.end / self.fluid.density))
    }

    /// The largest speed of the fluid (m/s) that the case itself tells: of its stream, its drive or its vortex.
    pub fn fluid_speed(&self) -> f64 {
        let told = [self.reference_speed, self.driven_speed(), self.initial.taylor_green];
        told.into_iter().flatten().fold(0.0, f64::max)
    }
}
