//! Parts of a case in words, for `mics check` and reports.

use super::{Case, Drive, Motion, Particle, Side};

impl Case {
    /// What is said of the particles, each line with its label: of few one by one, of many their ranges.
    pub fn describe_particles(&self) -> Vec<(String, String)> {
        let widest = self.spacings().into_iter().fold(0.0, f64::max);
        let cells = |d: f64| d / widest;
        let ratio = |p: &Particle| p.density / self.fluid.density;
        if self.particle.len() > 5 {
            let range = |f: &dyn Fn(&Particle) -> f64| {
                let values = self.particle.iter().map(f);
                values.fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)))
            };
            let (d, s) = (range(&|p| p.shape.diameter()), range(&ratio));
            let words = format!(
                "{}: d = {} to {} m, d/h = {:.1} to {:.1}, density ratio {:.4} to {:.4}",
                self.particle.len(),
                d.0,
                d.1,
                cells(d.0),
                cells(d.1),
                s.0,
                s.1
            );
            let entering: Vec<_> = self.particle.iter().filter_map(|p| p.enter.as_ref()).collect();
            let first = entering.iter().map(|enter| enter.time).fold(f64::INFINITY, f64::min);
            let come = format!("{} of them come in while the run goes on, the first at {first} s", entering.len());
            let come = (!entering.is_empty()).then(|| ("enter".into(), come));
            return [("particles".into(), words)].into_iter().chain(come).collect();
        }
        let line = |(id, p): (usize, &Particle)| {
            let motion = match &p.motion {
                Motion::Free { .. } => "free".into(),
                Motion::Fixed => "fixed".into(),
                Motion::Prescribed { oscillation: None, .. } => "prescribed motion".into(),
                Motion::Prescribed { oscillation: Some(o), .. } => format!(
                    "prescribed motion, to and fro by {:?} m at {} 1/s ({:.4} m/s)",
                    o.amplitude,
                    o.frequency,
                    o.speed()
                ),
            };
            let d = p.shape.diameter();
            let enters = p.enter.as_ref().map_or(String::new(), |enter| format!(", enters at {} s", enter.time));
            let words = format!("d = {d} m, d/h = {:.1}, density ratio {:.4}, {motion}{enters}", cells(d), ratio(p));
            (format!("particle {id}"), words)
        };
        self.particle.iter().enumerate().map(line).collect()
    }
}

impl Drive {
    /// What drives the fluid, in words.
    pub fn describe(&self) -> String {
        match self {
            Drive::Force(force) => format!("a force of {force:?} N/m3 on the fluid"),
            Drive::Gravity => "gravity along the periodic axes, on the fluid as well".into(),
            Drive::MeanVelocity(held) => format!(
                "the gradient of the pressure that holds a mean velocity of {} m/s along {}",
                held.value,
                ["x", "y", "z"][held.axis.index()]
            ),
            Drive::HoldMixture => "the gradient of the pressure that carries the weight of the free particles".into(),
        }
    }
}

impl Case {
    /// The axis along which a periodic box of free bodies accelerates as a whole: gravity acts along it, and nothing holds it.
    pub fn falls_as_a_whole(&self) -> Option<usize> {
        let free = self.particle.iter().all(Particle::is_free);
        let heavy = self.particle.iter().any(|p| p.density != self.fluid.density);
        let boxed = (0..self.dimension()).all(|axis| self.periodic(axis));
        let axis = (0..self.dimension()).find(|axis| self.fluid.gravity[*axis] != 0.0)?;
        (free && heavy && boxed && self.drive.is_none()).then_some(axis)
    }
}

impl Side {
    /// The condition in words.
    pub fn describe(&self) -> String {
        match self {
            Side::Periodic => "periodic".into(),
            Side::Outflow => "outflow".into(),
            Side::Wall => "wall".into(),
            Side::Slip => "slip".into(),
            Side::MovingWall(v) => format!("moving wall {v:?} m/s"),
            Side::Inflow(v) => format!("inflow {v:?} m/s"),
            Side::InflowParabola(v) => format!("parabolic inflow, {v:?} m/s in the middle"),
            Side::InflowProfile(p) => format!("inflow profile of {} points", p.at.len()),
        }
    }
}
