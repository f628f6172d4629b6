//! Bodies and obstacles of a 3D run as shaded surfaces: where they are in a snapshot, in colours
//! that say what bodies are.

use super::discs::{Colours, at_rest, materials};
use super::section::upright;
use super::slice::{ALONG, balls, closed_surfaces};
use crate::figure::{Scene, Solid, Surface};
use mics_run::bodies::Pose;
use mics_run::config::{Case, Particle};
use nalgebra::Vector3;

/// The scene of a case with bodies and obstacles in these places, seen from `eye` (a direction from
/// the box, of any length); by default from before it, above and to the left.
pub fn scene(
    case: &Case,
    place: &dyn Fn(usize) -> Option<Pose>,
    colours: &Colours,
    eye: Option<[f64; 3]>,
    title: String,
) -> Scene {
    let up = upright(case).unwrap_or(2);
    let default = if up == 1 { [-0.6, 0.6, 1.0] } else { [-0.6, -1.0, 0.6] };
    let materials = materials(case);
    let bodies = case.particle.iter().enumerate().filter_map(|(id, p)| {
        let pose = place(id).or_else(|| at_rest(p))?;
        let shade = Some(colours.shade(&materials, p, &pose));
        Some(Solid { surfaces: body(p, &pose), shade })
    });
    let first = case.particle.len();
    let obstacles = case.obstacle.iter().enumerate().map(|(k, o)| {
        let surfaces = closed_surfaces(case, o.wall(), place(first + k)).into_iter();
        Solid { surfaces: surfaces.map(Surface::Triangles).collect(), shade: None }
    });
    Scene {
        size: std::array::from_fn(|a| case.domain.size.get(a).copied().unwrap_or(0.0)),
        up,
        eye: eye.unwrap_or(default),
        solids: bodies.chain(obstacles).collect(),
        scale: Some(colours.scale(case)),
        title,
    }
}

/// The surfaces of a body in a pose.
fn body(particle: &Particle, pose: &Pose) -> Vec<Surface> {
    let centre = Vector3::from(pose.centre);
    let Some(solid) = particle.shape.solid() else {
        return vec![Surface::Ball(centre, 0.5 * particle.shape.diameter())];
    };
    let geometry = solid.geometry();
    let turn = pose.orientation.unwrap_or_else(|| particle.turn());
    let balls = balls(solid);
    if !balls.is_empty() {
        let ball = |(place, radius)| Surface::Ball(centre + turn * place, radius);
        return balls.into_iter().map(ball).collect();
    }
    let all = geometry.triangles(2.0 * geometry.radius() / ALONG);
    let all = all.into_iter().map(|corners| corners.map(|x| centre + turn * x));
    vec![Surface::Triangles(all.collect())]
}
