//! The methods: each is a type that owns its step, by the trait [`Method`]. [`mixture`] is the
//! paper's, [`sharp`] has body surfaces of second order, and where there are no bodies a [`flow`]
//! is all.

pub(crate) mod collision;
pub mod energy;
pub mod flow;
pub mod mixture;
pub mod momentum;
pub mod prediction;
pub mod sharp;
mod traction;

use crate::Result;
use crate::contact::Contacts;
use crate::domain::Domain;
use crate::geometry::{Cut, Overlap};
use crate::grid::VectorField;
use crate::kernels::faces::FaceCoefficient;
use crate::poisson::pressure::Projected;
use crate::scheme::Scheme;
use crate::state::State;
use momentum::MixtureProperties;
use nalgebra::Vector3;
use std::any::Any;
pub use traction::Traction;

/// Kind of a method, for those who describe it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MethodKind {
    /// A flow without bodies.
    Flow,
    /// The mixture method of the paper.
    Mixture,
    /// Sharp body surfaces.
    Sharp,
}

/// A method, by which a step is made: it owns its step and its scratch, and leaves in the [`State`]
/// what lasts. Another method is a type with this trait, built in `scene::build`.
pub trait Method<const D: usize>: Any {
    /// Its kind.
    fn kind(&self) -> MethodKind;

    /// Advances by `dt` (s). Collective.
    ///
    /// # Errors
    /// When the divergence cannot be brought below D0, a value is no longer finite, or a contact
    /// fails.
    fn step(&mut self, domain: &mut Domain<D>, s: &mut State<D>, dt: f64) -> Result<Projected>;

    /// Makes a consistent start from the cells' velocity: bodies imposed, faces divergence-free to
    /// D0; the pressure of the first moment, or zero where there are bodies. Collective.
    ///
    /// # Errors
    /// When the first projection fails.
    fn start(&mut self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()>;

    /// Finds what follows from a state, its ghosts filled; of the method `before`, if there was one
    /// up to this state, it may take over what belongs to bodies that both have. Collective.
    ///
    /// # Errors
    /// When the state is another case's.
    fn resume(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        before: Option<Box<dyn Method<D>>>,
    ) -> Result<()>;

    /// Finds the acceleration by a pressure whose ghosts have changed.
    fn find_acceleration(&mut self, domain: &Domain<D>, s: &State<D>);

    /// The fluid or mixture in the cells.
    fn mixture(&self) -> &MixtureProperties;

    /// `1/rho` on faces (m3/kg), as far as they are open.
    fn beta(&self) -> &FaceCoefficient<D>;

    /// The time scheme.
    fn scheme(&self) -> Scheme;

    /// Finds what the bodies touch where they lie, for readers of the results.
    fn place(&mut self, _domain: &Domain<D>, _s: &State<D>) {}

    /// The law of contacts, where there is one.
    fn contacts(&self) -> Option<&Contacts> {
        None
    }

    /// The law of contacts, where there is one, to look for contacts with.
    fn contacts_mut(&mut self) -> Option<&mut Contacts> {
        None
    }

    /// The cells of this rank that the body `k` touches; `None` past the last one.
    fn overlaps_of(&self, _k: usize) -> Option<&[Overlap]> {
        None
    }

    /// The faces along an axis of this rank that the body `k` covers; `None` of a method that has
    /// none.
    fn covered_faces(&self, _k: usize, _axis: usize) -> Option<&[Cut]> {
        None
    }

    /// The tractions of the fluid at points of the surfaces of bodies, those of this rank; none of
    /// a method that has no such points. Collective.
    ///
    /// # Errors
    /// When ranks cannot exchange ghosts.
    fn tractions(&self, _: &mut Domain<D>, _: &mut State<D>) -> Result<Vec<Traction>> {
        Ok(Vec::new())
    }

    /// Starts the balance of momentum, where one is kept, with the momentum of what is there now.
    /// Collective.
    ///
    /// # Errors
    /// When the state is another method's.
    fn start_balance(&self, _domain: &mut Domain<D>, _s: &mut State<D>) -> Result<()> {
        Ok(())
    }

    /// Gives the fluid in and about the inserted bodies of these numbers the motion that the method
    /// has there. Collective.
    ///
    /// # Errors
    /// When ranks cannot exchange ghosts, or a projection fails.
    fn impose_inserted(
        &mut self,
        _: &mut Domain<D>,
        _: &mut State<D>,
        _ids: &[usize],
    ) -> Result<()> {
        Ok(())
    }

    /// Lets the bodies of these numbers begin where they are, in a flow that goes on: they have
    /// come in, or other forces act on them. Collective.
    ///
    /// # Errors
    /// When the state is another method's, or ranks cannot exchange ghosts.
    fn begin_bodies(&mut self, _: &mut Domain<D>, _: &mut State<D>, _ids: &[usize]) -> Result<()> {
        Ok(())
    }
}

impl<'a, const D: usize> dyn Method<D> + 'a {
    /// Per body, the cells of this rank that it touches.
    pub fn overlaps_by_body(&self) -> impl Iterator<Item = &[Overlap]> {
        (0..).map_while(|k| self.overlaps_of(k))
    }

    /// The cells of this rank that bodies touch.
    pub fn overlaps(&self) -> impl Iterator<Item = &Overlap> {
        self.overlaps_by_body().flatten()
    }
}

impl<const D: usize> dyn Method<D> {
    /// The method as one of its types.
    pub fn downcast_mut<M: Method<D>>(&mut self) -> Option<&mut M> {
        (self as &mut dyn Any).downcast_mut()
    }
}

fn vector<const D: usize>(field: &VectorField<D>, cell: usize) -> Vector3<f64> {
    Vector3::from_fn(|a, _| if a < D { field[a][cell] } else { 0.0 })
}
