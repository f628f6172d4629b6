//! What the flow around a body will ask of the grid, before it runs: the speed that it comes to,
//! its Reynolds number and the boundary layer at its front.
//!
//! ```text
//!   U = terminal_speed        drag against submerged weight ([`crate::particles::terminal_speed`])
//!   U^2 <= 2 a L                      a = |s - 1| g/(s + c), c the added mass (disc 1, sphere
//!                                     1/2), L the way to the boundary
//!   delta                             [`boundary_layer`]
//! ```

use crate::config::{Case, Motion, Particle, Side};
use crate::drag::{boundary_layer, terminal_speed};
use crate::words::{brief, whole};

/// Reynolds number below which the flow along walls has no boundary layer.
const LEAST_REYNOLDS: f64 = 10.0;

/// Reynolds number beyond which the units are in doubt.
const DOUBTFUL: f64 = 1e6;

/// The body whose layer is the thinnest beside the spacing, and what is known of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Its number.
    pub particle: usize,
    /// Whether it falls (or rises) at this speed; else it is held in a stream or moved as told.
    pub falls: bool,
    /// Largest speed expected (m/s).
    pub speed: f64,
    /// Reynolds number of the speed and the diameter.
    pub reynolds: f64,
    /// Thickness of the layer at its front (m); infinite where there is none.
    pub thickness: f64,
    /// Its diameter (m).
    pub diameter: f64,
}

impl Layer {
    /// The thinnest layer of a case, in diameters of its body; `None` where nothing moves past a
    /// body.
    pub fn thinnest(case: &Case) -> Option<Layer> {
        let layers = case.particle.iter().enumerate().filter_map(|(id, p)| Layer::of(case, id, p));
        layers.min_by(|a, b| {
            a.thickness.total_cmp(&b.thickness).then(b.reynolds.total_cmp(&a.reynolds))
        })
    }

    fn of(case: &Case, particle: usize, p: &Particle) -> Option<Layer> {
        let diameter = p.shape.diameter();
        let nu = case.fluid.viscosity / case.fluid.density;
        let falls = p.is_free();
        let stream = case.reference_speed().or_else(|| case.driven_speed()).unwrap_or(0.0);
        let speed = own_speed(case, p) + if falls { 0.0 } else { stream };
        let reynolds = speed * diameter / nu;
        let known = speed > 0.0 && nu > 0.0;
        let thickness = boundary_layer(diameter, reynolds);
        known.then_some(Layer { particle, falls, speed, reynolds, thickness, diameter })
    }

    /// Cells a diameter that put a spacing into the layer; of a body held in a stream 1.4, below
    /// which its drag depends on its place within a cell (a cylinder at Re = 100: 6 % at 8 cells,
    /// 2 % at 12).
    pub fn cells_needed(&self) -> f64 {
        let spacings = if self.falls { 1.0 } else { 1.4 };
        (spacings * self.diameter / self.thickness).ceil()
    }
}

/// The layer along the walls of a box, as thick as `L/sqrt(Re)` where they are L apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walls {
    /// The axis across them.
    pub axis: usize,
    /// Largest speed expected (m/s).
    pub speed: f64,
    /// Reynolds number of the speed and L.
    pub reynolds: f64,
    /// Thickness (m).
    pub thickness: f64,
}

impl Walls {
    /// The thinnest in spacings; `None` where nothing flows along walls fast enough.
    pub fn thinnest(case: &Case) -> Option<Walls> {
        let (speed, nu) = (
            case.reference_speed().or_else(|| case.driven_speed())?,
            case.fluid.viscosity / case.fluid.density,
        );
        let walls = |axis: &usize| {
            case.boundary.ends(*axis).any(|s| matches!(s, Side::Wall | Side::MovingWall(_)))
        };
        let of = |axis: usize| {
            let length = case.domain.size[axis];
            let reynolds = speed * length / nu;
            Walls { axis, speed, reynolds, thickness: length / reynolds.sqrt() }
        };
        let spacings = case.spacings();
        let all = (0..case.dimension())
            .filter(walls)
            .map(of)
            .filter(|w| nu > 0.0 && w.reynolds >= LEAST_REYNOLDS);
        all.min_by(|a, b| {
            (a.thickness / spacings[a.axis]).total_cmp(&(b.thickness / spacings[b.axis]))
        })
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
    let of_fluid = [case.reference_speed(), case.driven_speed(), case.initial.taylor_green];
    let of_bodies = case.particle.iter().map(|p| own_speed(case, p));
    of_fluid.into_iter().flatten().chain(of_bodies).fold(0.0, f64::max)
}

/// The speed that an isolated body comes to under its submerged weight (m/s): its terminal speed,
/// or what it gathers until the end on its way to the boundaries, whichever is less. Where one
/// stops it along one axis, it goes on along the others.
pub fn fall_speed(case: &Case, p: &Particle) -> f64 {
    let gravity = &case.fluid.gravity;
    let g = gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
    let s = p.density() / case.fluid.density;
    let diameter = p.shape.diameter();
    let nu = case.fluid.viscosity / case.fluid.density;
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

/// The boundary layer that the grid has to resolve: that of a body, or else that of the walls of
/// the box.
pub fn describe(case: &Case) -> Vec<String> {
    let Some(layer) = Layer::thinnest(case) else { return wall_layer(case) };
    let Layer { particle, falls, speed, reynolds, thickness, .. } = layer;
    let h = case.spacings().into_iter().fold(0.0, f64::max);
    let meets = if falls { "comes to" } else { "meets a flow of" };
    let by = if falls { ", by its drag," } else { "," };
    let mut line = format!(
        "layer        {} {meets} {} m/s{by} Re = {}",
        case.called(particle),
        brief(speed),
        number_of_flow(reynolds)
    );
    if thickness.is_infinite() {
        return vec![line + ": no boundary layer"];
    }
    line += &format!(": a boundary layer of {thickness:.3e} m, {:.2} h", thickness / h);
    let warning = thin_layer(case).map(|thin| format!("warning      {thin}{}", doubt(reynolds)));
    [Some(line), warning].into_iter().flatten().collect()
}

/// That of the walls of the box, where the flow along them is fast enough for one.
fn wall_layer(case: &Case) -> Vec<String> {
    let Some(Walls { axis, speed, reynolds, thickness }) = Walls::thinnest(case) else {
        return Vec::new();
    };
    let x = ["x", "y", "z"][axis];
    let h = case.spacings()[axis];
    let line = format!(
        "layer        along the walls across {x}, at {} m/s, Re = {}: a boundary layer of \
        {thickness:.3e} m, {:.2} h",
        brief(speed),
        number_of_flow(reynolds),
        thickness / h
    );
    let warning = thin_layer(case).map(|thin| format!("warning      {thin}{}", doubt(reynolds)));
    [Some(line), warning].into_iter().flatten().collect()
}

/// The boundary layer, where the grid does not resolve it, and how many cells would.
pub(crate) fn thin_layer(case: &Case) -> Option<String> {
    let (whose, needed, there, thickness, h) = match (Layer::thinnest(case), Walls::thinnest(case))
    {
        (Some(layer), _) => {
            let h = case.spacings().into_iter().fold(0.0, f64::max);
            let needed = format!("{} cells a diameter", whole(layer.cells_needed()));
            (
                case.called(layer.particle),
                needed,
                format!("{:.1}", layer.diameter / h),
                layer.thickness,
                h,
            )
        }
        (None, Some(Walls { axis, thickness, .. })) => {
            let x = ["x", "y", "z"][axis];
            let needed =
                format!("{} cells along {x}", whole((case.domain.size[axis] / thickness).ceil()));
            (
                format!("the walls across {x}"),
                needed,
                case.domain.cells[axis].to_string(),
                thickness,
                case.spacings()[axis],
            )
        }
        (None, None) => return None,
    };
    (thickness < h).then(|| {
        format!(
            "the boundary layer of {whose} is thinner than a spacing: {needed} would resolve it, \
            and there are {there}"
        )
    })
}

/// A Reynolds number, with what a creeping flow has of it.
pub fn number_of_flow(reynolds: f64) -> String {
    if reynolds < 10.0 { brief(reynolds) } else { whole(reynolds) }
}

/// What a Reynolds number often comes of that is far too large.
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
        Layer::thinnest(&crate::config::written(&text).unwrap()).unwrap()
    }

    #[test]
    fn boundary_layer_of_paper_falling_cylinder() {
        let layer = thinnest("[0.015, 0.1]", "density = 1200.0");
        // By hand: U^2 = 2 0.2 g (pi d/4)/Cd, Cd = 1 + 10 Re^(-2/3) = 1.035 at Re = 4880.
        assert!(layer.falls && (layer.reynolds / 4880.0 - 1.0).abs() < 0.01, "{layer:?}");
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
    fn no_boundary_layer_at_low_reynolds_number() {
        let layer = thinnest("[0.015, 0.1]", "density = 1000.0, velocity = [1e-4, 0.0]");
        assert_eq!((layer.thickness, layer.cells_needed()), (f64::INFINITY, 0.0));
        assert!((layer.reynolds - 2.0).abs() < 1e-12);
    }
}
