//! Records at points: velocity and pressure, linear between the centres of cells; inside a body its
//! own velocity, `v + w x r`.

use crate::Result;
use crate::config::Probe;
use crate::particles::nearest_image;
use crate::scene::Scene;
use nalgebra::Vector3;

/// The columns of `probes.csv`.
pub const COLUMNS: &str = "step,time,probe,point,x,y,z,vx,vy,vz,pressure,body";

/// Numbers at a point.
const NUMBERS: usize = 4;

/// The probes of a case.
pub struct Probes {
    probes: Vec<(Probe, Vec<Vec<f64>>)>,
    /// Velocity (m/s) and pressure (Pa) at each point of one probe; zero on ranks that do not have
    /// the point.
    values: Vec<f64>,
}

impl Probes {
    /// The probes of a case.
    pub fn new(probes: &[Probe]) -> Probes {
        Probes {
            probes: probes.iter().map(|probe| (probe.clone(), probe.places())).collect(),
            values: Vec::new(),
        }
    }

    /// Hands a line of `probes.csv` for each point that is due after this step to `put`.
    /// Collective.
    ///
    /// # Errors
    /// When ranks cannot sum.
    pub fn record<const D: usize>(
        &mut self,
        scene: &mut Scene<D>,
        mut put: impl FnMut(std::fmt::Arguments) -> Result<()>,
    ) -> Result<()> {
        let time = scene.state.time;
        let steps = scene.state.steps;
        let due =
            |probe: &Probe| time >= probe.from && steps.is_multiple_of(probe.every.unwrap_or(1));
        if self.probes.iter().any(|(probe, _)| due(probe)) {
            // A place beside another rank's cells lies between them and this one's.
            scene.domain.boundaries.fill_velocity(&mut scene.state.u)?;
        }
        let scene = &*scene;
        let s = &scene.state;
        let periods = scene.domain.periods();
        for (probe, places) in self.probes.iter().filter(|(probe, _)| due(probe)) {
            self.values.clear();
            self.values.resize(NUMBERS * places.len(), 0.0);
            for (values, place) in self.values.chunks_exact_mut(NUMBERS).zip(places) {
                at(scene, place, values);
            }
            scene.domain.session.sum(&mut self.values)?;
            for (point, (place, v)) in
                places.iter().zip(self.values.chunks_exact(NUMBERS)).enumerate()
            {
                let at = Vector3::from_fn(|a, _| place.get(a).copied().unwrap_or(0.0));
                let around = s.bodies.iter().find_map(|body| {
                    let arm = nearest_image(&body.centre, &at, &periods);
                    (body.distance(&arm) < 0.0).then(|| (body.id, body.velocity_at(&arm)))
                });
                let velocity =
                    around.map_or(Vector3::new(v[0], v[1], v[2]), |(_, velocity)| velocity);
                let body = around.map_or(String::new(), |(id, _)| id.to_string());
                let [x, y, z]: [f64; 3] = at.into();
                let [vx, vy, vz]: [f64; 3] = velocity.into();
                put(format_args!(
                    "{},{:?},{},{point},{x:?},{y:?},{z:?},{vx:?},{vy:?},{vz:?},{:?},{body}",
                    s.steps, s.time, probe.name, v[3]
                ))?;
            }
        }
        Ok(())
    }
}

/// Velocity and pressure at a place, if this rank has it.
fn at<const D: usize>(scene: &Scene<D>, place: &[f64], values: &mut [f64]) {
    let grid = &scene.domain.grid;
    // The cell of the place; one on the far side of the box belongs to the last cell.
    let cell: [usize; D] =
        std::array::from_fn(|a| ((place[a] / grid.h[a]) as usize).min(grid.cells[a] - 1));
    let own = (0..D).all(|a| (grid.start[a]..grid.start[a] + grid.local[a]).contains(&cell[a]));
    if !own {
        return;
    }
    let index: usize =
        (0..D).map(|a| (cell[a] - grid.start[a] + grid.ghosts) * grid.stride[a]).sum();
    // Its neighbour on the other side of the place, along each axis, and how near that is.
    let beside: [(usize, f64); D] = std::array::from_fn(|a| {
        let off = place[a] / grid.h[a] - cell[a] as f64 - 0.5;
        (if off < 0.0 { index - grid.stride[a] } else { index + grid.stride[a] }, off.abs())
    });
    for corner in 0..1usize << D {
        let mut c = index;
        let mut share = 1.0;
        for (a, (neighbour, near)) in beside.iter().enumerate() {
            if corner >> a & 1 == 1 {
                c = c + neighbour - index;
                share *= near;
            } else {
                share *= 1.0 - near;
            }
        }
        (0..D).for_each(|a| values[a] += share * scene.state.u[a][c]);
        values[3] += share * scene.state.p[c];
    }
}
