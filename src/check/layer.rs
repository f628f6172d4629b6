//! Demands of the flow around a body on the grid, before it runs: the speed that it comes to, its
//! Reynolds number and the boundary layer at its front.
//!
//! ```text
//!   U = terminal_speed        drag against submerged weight ([`crate::particles::terminal_speed`])
//!   U^2 <= 2 a L                      a = |s - 1| g/(s + c), c the added mass (disc 1, sphere
//!                                     1/2), L the way to the boundary
//!   delta                             [`boundary_layer`]
//! ```

use crate::config::{AXES, Case, Motion, Particle, Side, driven_speed};
use crate::drag::{boundary_layer, terminal_speed};
use crate::words::{brief, whole};

/// Reynolds number below which the flow along walls has no boundary layer.
const LEAST_REYNOLDS: f64 = 10.0;

/// Reynolds number beyond which the units are in doubt.
const DOUBTFUL: f64 = 1e6;

/// Body or walls beside which a boundary layer lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Beside {
    /// The body of this number, which falls, or rises, at the speed of its layer.
    Falling(usize),
    /// The body of this number, which is held in a stream, rests in it by its weight, or is moved
    /// as told.
    Held(usize),
    /// The walls of the box across this axis.
    Walls(usize),
}

/// A boundary layer, and what is known of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Body or walls beside which it lies.
    pub beside: Beside,
    /// Diameter of the body, or distance of the walls (m).
    pub length: f64,
    /// Largest speed expected (m/s).
    pub speed: f64,
    /// Reynolds number of the speed and the length.
    pub reynolds: f64,
    /// Thickness (m), of a body at its front; infinite where there is none.
    pub thickness: f64,
}

impl Layer {
    /// The layer that the grid has to resolve: that of a body, or else that of the walls.
    fn thinnest(case: &Case) -> Option<Layer> {
        Layer::of_bodies(case).or_else(|| Layer::of_walls(case))
    }

    /// The thinnest layer of a body; `None` where nothing moves past a body.
    pub fn of_bodies(case: &Case) -> Option<Layer> {
        let nu = case.fluid.kinematic_viscosity();
        let stream = case.reference_speed().or_else(|| driven_speed(case)).unwrap_or(0.0);
        let layers = case.particle.iter().enumerate().map(|(id, p)| {
            let length = p.shape.diameter();
            let own = own_speed(case, p);
            let rests = p.density() > case.fluid.density && case.fluid.weight() > 0.0;
            let falls = p.is_free() && (own >= stream || !rests);
            let beside = if falls { Beside::Falling(id) } else { Beside::Held(id) };
            let speed = match (falls, p.is_free()) {
                (true, _) => own,
                // A stone that lies on a bed meets the stream.
                (false, true) => stream,
                (false, false) => own + stream,
            };
            let reynolds = speed * length / nu;
            let thickness = boundary_layer(length, reynolds);
            Layer { beside, length, speed, reynolds, thickness }
        });
        layers.filter(|layer| layer.speed > 0.0 && nu > 0.0).min_by(|a, b| {
            a.thickness.total_cmp(&b.thickness).then(b.reynolds.total_cmp(&a.reynolds))
        })
    }

    /// The layer along walls that is thinnest in spacings, as thick as `L/sqrt(Re)` where they are
    /// L apart; `None` where nothing flows along them fast enough.
    fn of_walls(case: &Case) -> Option<Layer> {
        let nu = case.fluid.kinematic_viscosity();
        let speed = case.reference_speed().or_else(|| driven_speed(case))?;
        let wall = |side: &Side| matches!(side, Side::Wall | Side::MovingWall(_));
        let axes = (0..case.dimension()).filter(|axis| case.boundary.ends(*axis).any(wall));
        let layers = axes.map(|axis| {
            let length = case.domain.size[axis];
            let reynolds = speed * length / nu;
            let thickness = length / reynolds.sqrt();
            Layer { beside: Beside::Walls(axis), length, speed, reynolds, thickness }
        });
        let spacings = |layer: &Layer| layer.thickness / layer.spacing(case);
        layers
            .filter(|layer| nu > 0.0 && layer.reynolds >= LEAST_REYNOLDS)
            .min_by(|a, b| spacings(a).total_cmp(&spacings(b)))
    }

    /// The spacing (m) that has to resolve it.
    fn spacing(&self, case: &Case) -> f64 {
        match self.beside {
            Beside::Walls(axis) => case.spacings()[axis],
            _ => case.widest_spacing(),
        }
    }

    /// Cells a length that put one spacing into the layer, or 1.4 at a body held in a stream: below
    /// that its drag depends on its place within a cell (a cylinder at Re = 100: 6 % at 8 cells, 2
    /// % at 12).
    pub fn cells_needed(&self) -> f64 {
        let spacings = if let Beside::Held(_) = self.beside { 1.4 } else { 1.0 };
        (spacings * self.length / self.thickness).ceil()
    }
}

/// The speed (m/s) of a body by its weight or as it is told.
fn own_speed(case: &Case, p: &Particle) -> f64 {
    let size = |v: &[f64]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    match &p.motion {
        Motion::Free => fall_speed(case, p).max(size(&p.velocity())),
        Motion::Fixed => 0.0,
        Motion::Prescribed(told) => {
            size(&told.velocity) + told.oscillation.as_ref().map_or(0.0, |o| o.speed())
        }
    }
}

/// The largest speed to be expected (m/s), of the fluid and of bodies.
pub fn largest_speed(case: &Case) -> f64 {
    let of_fluid = [case.reference_speed(), driven_speed(case), case.initial.taylor_green];
    let of_bodies = case.particle.iter().map(|p| own_speed(case, p));
    of_fluid.into_iter().flatten().chain(of_bodies).fold(0.0, f64::max)
}

/// The speed that an isolated body comes to under its submerged weight (m/s): its terminal speed,
/// or what it gathers until the end on its way to the boundaries, whichever is less. Where one
/// stops it along one axis, it goes on along the others.
pub fn fall_speed(case: &Case, p: &Particle) -> f64 {
    let gravity = &case.fluid.gravity;
    let g = case.fluid.weight();
    let s = p.density() / case.fluid.density;
    let diameter = p.shape.diameter();
    let nu = case.fluid.kinematic_viscosity();
    let weight = (s - 1.0).abs() * g;
    if weight == 0.0 {
        return 0.0;
    }
    let sphere = p.shape.is_round() && p.shape.dimension() == 3;
    let terminal =
        if nu > 0.0 { terminal_speed(sphere, diameter, weight, nu) } else { f64::INFINITY };
    let added = if sphere { 0.5 } else { 1.0 };
    let square = gravity.iter().enumerate().filter(|(_, g)| **g != 0.0).map(|(axis, along)| {
        let down = (*along < 0.0) == (s > 1.0);
        let at = p.position[axis];
        let size = case.domain.size[axis];
        let to_boundary = if down { at } else { size - at } - 0.5 * diameter;
        let way = if case.periodic(axis) { f64::INFINITY } else { to_boundary.max(0.0) };
        let acceleration = (s - 1.0).abs() * along.abs() / (s + added);
        (2.0 * acceleration * way).min((acceleration * case.time.end).powi(2))
    });
    terminal.min(square.sum::<f64>().sqrt())
}

/// The boundary layer that the grid has to resolve.
pub fn describe(case: &Case) -> Vec<String> {
    let Some(layer) = Layer::thinnest(case) else { return Vec::new() };
    let speed = brief(layer.speed);
    let flow = match layer.beside {
        Beside::Falling(id) => format!("{} comes to {speed} m/s, by its drag,", case.called(id)),
        Beside::Held(id) => format!("{} meets a flow of {speed} m/s,", case.called(id)),
        Beside::Walls(axis) => format!("along the walls across {}, at {speed} m/s,", AXES[axis]),
    };
    let line = format!("layer        {flow} Re = {}", number_of_flow(layer.reynolds));
    if layer.thickness.is_infinite() {
        return vec![line + ": no boundary layer"];
    }
    let thickness = layer.thickness;
    let spacings = thickness / layer.spacing(case);
    let warning =
        thin_layer(case).map(|thin| format!("warning      {thin}{}", doubt(layer.reynolds)));
    let line = format!("{line}: a boundary layer of {thickness:.3e} m, {spacings:.2} h");
    [line].into_iter().chain(warning).collect()
}

/// The boundary layer, where the grid does not resolve it, and how many cells would.
pub(crate) fn thin_layer(case: &Case) -> Option<String> {
    let layer = Layer::thinnest(case)?;
    let h = layer.spacing(case);
    let needed = whole(layer.cells_needed());
    let [whose, across, there] = match layer.beside {
        Beside::Falling(id) | Beside::Held(id) => {
            [case.called(id), "a diameter".into(), format!("{:.1}", layer.length / h)]
        }
        Beside::Walls(axis) => {
            let x = AXES[axis];
            let cells = case.domain.cells[axis].to_string();
            [format!("the walls across {x}"), format!("along {x}"), cells]
        }
    };
    (layer.thickness < h).then(|| {
        format!(
            "the boundary layer of {whose} is thinner than a spacing: {needed} cells {across} \
            would resolve it, and there are {there}"
        )
    })
}

/// A Reynolds number, with what a creeping flow has of it.
pub fn number_of_flow(reynolds: f64) -> String {
    if reynolds < 10.0 { brief(reynolds) } else { whole(reynolds) }
}

/// Usual cause of a Reynolds number that is far too large, in words; empty for other numbers.
fn doubt(reynolds: f64) -> &'static str {
    let units = "; so large a Reynolds number often comes of a viscosity in other units: \
        fluid.viscosity is dynamic, in Pa s, that of water 1e-3";
    if reynolds > DOUBTFUL { units } else { "" }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn thinnest(position: &str, more: &str) -> Layer {
        let text = format!(
            "name = \"t\"\ntime.end = 9.0\ndomain = {{ size = [0.1, 0.15], cells = [8, 12] }}\n\
            fluid = {{ density = 1000.0, viscosity = 1e-3, gravity = [0.0, -9.81] }}\n\
            boundary = {{ west = \"wall\", east = \"wall\", south = \"wall\", north = \"wall\" }}\n\
            particle = [{{ shape = {{ disc = {{ diameter = 0.02 }} }}, position = {position}, \
            {more} }}]\n"
        );
        Layer::of_bodies(&crate::config::written(&text).unwrap()).unwrap()
    }

    #[test]
    fn boundary_layer_of_paper_falling_cylinder() {
        let layer = thinnest("[0.015, 0.1]", "density = 1200.0");
        assert_eq!(layer.beside, Beside::Falling(0));
        // By hand: U^2 = 2 0.2 g (pi d/4)/Cd, Cd = 1 + 10 Re^(-2/3) = 1.035 at Re = 4880.
        assert!((layer.reynolds / 4880.0 - 1.0).abs() < 0.01, "{layer:?}");
        assert!(
            (layer.thickness / 3.43e-4 - 1.0).abs() < 0.01 && layer.cells_needed() == 59.0,
            "{layer:?}"
        );
        // One that rises has less way: sqrt(2 a L) with a = g/(0.0 + 1), L = 11 mm.
        let short = thinnest("[0.015, 0.129]", "density = 1e-3");
        assert!((short.speed - (2.0 * 9.81 * 0.011f64).sqrt()).abs() < 1e-6, "{short:?}");
    }

    #[test]
    fn boundary_layer_of_body_accelerating_on_slope() {
        let text = "name = \"t\"\ntime.end = 0.5\n\
            domain = { size = [0.06, 0.06], cells = [24, 24] }\n\
            fluid = { density = 1.0, viscosity = 1e-5, gravity = [3.0, -9.0] }\n\
            boundary = { west = \"periodic\", east = \"periodic\", south = \"wall\", north = \
            \"wall\" }\n\
            particle = [{ shape.disc.diameter = 0.01, position = [0.03, 0.005], density = 1e6 \
            }]\n";
        let case = crate::config::written(text).unwrap();
        assert!((fall_speed(&case, &case.particle[0]) - 1.5).abs() < 1e-5);
    }

    #[test]
    fn stone_at_rest_meets_the_stream_and_light_body_goes_with_it() {
        let layer = |density: f64| {
            let text = format!(
                "name = \"t\"\ntime.end = 9.0\ndomain = {{ size = [0.2, 0.1], cells = [40, 20] }}\n\
                fluid = {{ density = 1000.0, viscosity = 1e-3, gravity = [0.0, -9.81] }}\n\
                boundary = {{ west = {{ inflow = [0.9, 0.0] }}, east = \"outflow\", south = \
                \"wall\", north = \"slip\" }}\n\
                particle = [{{ shape = {{ disc = {{ diameter = 0.02 }} }}, position = [0.1, 0.01], \
                density = {density:?} }}]\n"
            );
            Layer::of_bodies(&crate::config::written(&text).unwrap())
        };
        let stone = layer(2650.0).unwrap();
        assert_eq!((stone.beside, stone.speed), (Beside::Held(0), 0.9));
        assert!((stone.reynolds / 18_000.0 - 1.0).abs() < 1e-9, "{stone:?}");
        assert!(layer(1000.0).is_none_or(|light| light.speed < 0.9));
    }

    #[test]
    fn no_boundary_layer_at_low_reynolds_number() {
        let layer = thinnest("[0.015, 0.1]", "density = 1000.0, velocity = [1e-4, 0.0]");
        assert_eq!((layer.thickness, layer.cells_needed()), (f64::INFINITY, 0.0));
        assert!((layer.reynolds - 2.0).abs() < 1e-12);
    }
}
