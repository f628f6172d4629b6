//! Where fluid and particles meet, one of two ways: [`mixing`], as the paper prints it, and [`sharp`].

mod meeting;
pub mod mixing;
pub mod sharp;

use crate::Result;
use crate::geometry::Overlap;
use crate::grid::VectorField;
use crate::solids::Body;
use crate::solids::contact::Contacts;
use crate::tape::{Lasting, Tape};
use meeting::refuse_meetings;
use mixing::Mixing;
use nalgebra::Vector3;
use sharp::Sharp;

/// The particles and how they are coupled to the fluid.
// There is one in a scene.
#[allow(clippy::large_enum_variant)]
pub enum Coupling<const D: usize> {
    /// By mixing (27), as the paper prints it.
    Mixing(Mixing<D>),
    /// By sharp walls.
    Sharp(Sharp<D>),
}

impl<const D: usize> Coupling<D> {
    /// The bodies, in the case's order.
    pub fn bodies(&self) -> &[Body] {
        match self {
            Coupling::Mixing(c) => c.bodies(),
            Coupling::Sharp(c) => c.bodies(),
        }
    }

    /// What each body exchanged with the fluid in the last step.
    pub fn exchange(&self) -> &[Exchange] {
        match self {
            Coupling::Mixing(c) => c.exchange(),
            Coupling::Sharp(c) => c.exchange(),
        }
    }

    /// The law of contacts, where there is one.
    pub fn contacts(&self) -> Option<&Contacts> {
        match self {
            Coupling::Mixing(c) => c.contacts(),
            Coupling::Sharp(c) => c.contacts(),
        }
    }

    /// The cells of this rank that bodies touch.
    pub fn overlaps(&self) -> Box<dyn Iterator<Item = &Overlap> + '_> {
        match self {
            Coupling::Mixing(c) => Box::new(c.overlaps().iter().flatten()),
            Coupling::Sharp(c) => Box::new(c.overlaps()),
        }
    }

    /// Whether any body changes place.
    pub fn moves(&self) -> bool {
        self.bodies().iter().any(Body::moves)
    }

    /// Whether any body is moved by forces.
    pub fn flies(&self) -> bool {
        self.bodies().iter().any(|b| b.freedom().is_some())
    }

    /// Largest acceleration (m/s2) by which gravity may set a free particle off, its added mass half its volume's.
    pub fn largest_fall(&self) -> f64 {
        let (g, fluid) = match self {
            Coupling::Mixing(c) => (c.gravity(), c.fluid_density()),
            Coupling::Sharp(c) => (c.gravity(), c.fluid_density()),
        };
        let fall =
            |b: &Body| Some(b.freedom()?.along(&g).norm() * (b.density - fluid).abs() / (b.density + 0.5 * fluid));
        self.bodies().iter().filter_map(fall).fold(0.0, f64::max)
    }

    /// The mixing, where that is the coupling.
    pub fn mixing(&mut self) -> Option<&mut Mixing<D>> {
        if let Coupling::Mixing(mixing) = self { Some(mixing) } else { None }
    }

    /// The sharp walls, where they are the coupling.
    pub fn sharp(&mut self) -> Option<&mut Sharp<D>> {
        if let Coupling::Sharp(sharp) = self { Some(sharp) } else { None }
    }
}

/// What fluid and one particle exchange over a step. Forces in N (per metre of depth in 2D), torques in N m about the
/// particle's centre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exchange {
    /// Force by the momentum that the fluid around the body loses: what the mixing (27) removes, the body's own inertia
    /// apart, or what sharp walls take.
    pub momentum: Vector3<f64>,
    /// Its torque.
    pub momentum_torque: Vector3<f64>,
    /// Convective part of (19).
    pub convective: Vector3<f64>,
    /// Pressure part of (19).
    pub pressure: Vector3<f64>,
    /// Viscous part of (19).
    pub viscous: Vector3<f64>,
    /// Torque of the three parts of (19).
    pub literal_torque: Vector3<f64>,
    /// Mean force of contacts over the step.
    pub contact: Vector3<f64>,
    /// `sum alpha (rho_k - rho_f) dV` times the convective rate: what fields carry of the particle's excess mass.
    carried: Vector3<f64>,
    carried_torque: Vector3<f64>,
    /// What accelerates the mass of a held body as prescribed, `m dV/dt`: the mixture takes it up, and nobody around it.
    driven: Vector3<f64>,
    /// Angular momentum that the mixing gave the cells (N m s).
    spun: Vector3<f64>,
}

impl Exchange {
    /// Numbers that ranks sum.
    const NUMBERS: usize = 30;

    /// What holds a body in its motion has to stand (N): the fluid's force less what the motion itself takes.
    pub fn held(&self) -> Vector3<f64> {
        self.momentum - self.driven
    }

    /// Force by (19) as printed: the sum of its parts (N).
    pub fn literal(&self) -> Vector3<f64> {
        self.convective + self.pressure + self.viscous
    }

    fn vectors(&mut self) -> [&mut Vector3<f64>; Exchange::NUMBERS / 3] {
        [
            &mut self.momentum,
            &mut self.momentum_torque,
            &mut self.convective,
            &mut self.pressure,
            &mut self.viscous,
            &mut self.literal_torque,
            &mut self.carried,
            &mut self.carried_torque,
            &mut self.driven,
            &mut self.spun,
        ]
    }
}

impl Lasting for Exchange {
    fn pass(&mut self, tape: &mut Tape) -> Result<()> {
        // `contact` is the only one that ranks do not sum.
        self.contact.pass(tape)?;
        self.vectors().into_iter().try_for_each(|v| v.pass(tape))
    }
}

fn vector<const D: usize>(field: &VectorField<D>, cell: usize) -> Vector3<f64> {
    Vector3::from_fn(|a, _| if a < D { field[a][cell] } else { 0.0 })
}
