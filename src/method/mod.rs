//! The methods: each is a type that owns its step. [`mics2003`] is the paper's, [`sharp`] has walls
//! of second order, and where there are no bodies a [`flow`] is all.

pub(crate) mod collision;
pub mod energy;
pub mod flow;
pub mod mics2003;
pub mod momentum;
pub mod sharp;
mod stabilised;

use crate::Result;
use crate::contact::Contacts;
use crate::domain::Domain;
use crate::geometry::Overlap;
use crate::grid::{Coefficient, Grid, VectorField};
use crate::kernels::faces::FaceCoefficient;
use crate::poisson::pressure::Projected;
use crate::scheme::Scheme;
use crate::state::State;
use flow::Flow;
use mics2003::Mics2003;
use momentum::Mixture;
use nalgebra::Vector3;
use sharp::Sharp;

/// How a step is made.
// There is one in a scene.
#[allow(clippy::large_enum_variant)]
pub enum Method<const D: usize> {
    /// No bodies.
    Plain(Flow<D>),
    /// Bodies by the paper's mixing (27).
    Mics2003(Mics2003<D>),
    /// Bodies with sharp walls.
    Sharp(Sharp<D>),
}

impl<const D: usize> Method<D> {
    /// Advances by `dt` (s). Collective.
    ///
    /// # Errors
    /// When the divergence cannot be brought below D0, a value is no longer finite, or a contact
    /// fails.
    pub fn step(&mut self, domain: &mut Domain<D>, s: &mut State<D>, dt: f64) -> Result<Projected> {
        match self {
            Method::Plain(flow) => flow.step(domain, s, dt),
            Method::Mics2003(method) => method.step(domain, s, dt),
            Method::Sharp(method) => method.step(domain, s, dt),
        }
    }

    /// Makes a consistent start from the cells' velocity: bodies imposed, faces divergence-free to
    /// D0; the pressure of the first moment, or zero where there are bodies. Collective.
    ///
    /// # Errors
    /// When the first projection fails.
    pub fn start(&mut self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()> {
        match self {
            Method::Plain(flow) => {
                flow.start(domain, s)?;
                flow.start_pressure(domain, s)
            }
            Method::Mics2003(method) => method.start(domain, s),
            Method::Sharp(method) => method.start(domain, s),
        }
    }

    /// Finds what follows from a state, its ghosts filled. Collective.
    ///
    /// # Errors
    /// When the state is another case's.
    pub fn resume(&mut self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()> {
        match self {
            Method::Plain(flow) => flow.resume(domain, s),
            Method::Mics2003(method) => method.resume(domain, s),
            Method::Sharp(method) => method.resume(domain, s),
        }
    }

    /// Finds what the bodies touch where they lie, for readers of the results.
    pub fn place(&mut self, domain: &Domain<D>, s: &State<D>) {
        match self {
            Method::Plain(_) => {}
            Method::Mics2003(method) => method.find_overlaps(domain, s, |_| true),
            Method::Sharp(method) => method.place(domain, &s.bodies),
        }
    }

    /// What fills the cells.
    pub fn mixture(&self) -> &Mixture {
        match self {
            Method::Plain(flow) => &flow.mixture,
            Method::Mics2003(method) => method.mixture(),
            Method::Sharp(method) => method.mixture(),
        }
    }

    /// `1/rho` on faces (m3/kg), as far as they are open.
    pub fn beta(&self) -> &FaceCoefficient<D> {
        match self {
            Method::Plain(flow) => &flow.beta,
            Method::Mics2003(method) => &method.flow().beta,
            Method::Sharp(method) => method.beta(),
        }
    }

    /// The time scheme.
    pub fn scheme(&self) -> Scheme {
        match self {
            Method::Plain(flow) => flow.momentum.scheme,
            Method::Mics2003(method) => method.flow().momentum.scheme,
            Method::Sharp(method) => method.momentum().scheme,
        }
    }

    /// The law of contacts, where there is one.
    pub fn contacts(&self) -> Option<&Contacts> {
        match self {
            Method::Plain(_) => None,
            Method::Mics2003(method) => method.contacts(),
            Method::Sharp(method) => method.contacts(),
        }
    }

    /// Finds which bodies are in contact as they lie, and what their springs hold (J).
    pub fn find_springs(&mut self, s: &State<D>) -> f64 {
        let contacts = match self {
            Method::Plain(_) => None,
            Method::Mics2003(method) => method.contacts_mut(),
            Method::Sharp(method) => method.contacts_mut(),
        };
        contacts.map_or(0.0, |contacts| {
            contacts.meet(&s.bodies);
            contacts.stored(&s.bodies, |k| s.displacement(k))
        })
    }

    /// Calls `take` with the cells of this rank that bodies touch.
    pub fn with_overlaps<R>(
        &self,
        take: impl FnOnce(&mut dyn Iterator<Item = &Overlap>) -> R,
    ) -> R {
        match self {
            Method::Plain(_) => take(&mut std::iter::empty()),
            Method::Mics2003(method) => take(&mut method.overlaps()),
            Method::Sharp(method) => take(&mut method.overlaps()),
        }
    }

    /// Finds the acceleration by a pressure whose ghosts have changed.
    pub fn find_acceleration(&mut self, domain: &Domain<D>, s: &State<D>) {
        match self {
            Method::Plain(flow) => flow.find_acceleration(domain, s),
            Method::Mics2003(method) => method.find_acceleration(domain, s),
            Method::Sharp(method) => method.find_acceleration(domain, s),
        }
    }

    /// Takes the momentum of what is there now for that of the last step, where a balance is kept.
    /// Collective.
    ///
    /// # Errors
    /// When the state is another method's.
    pub fn rebalance(&self, domain: &mut Domain<D>, s: &mut State<D>) -> Result<()> {
        match self {
            Method::Plain(_) => Ok(()),
            Method::Mics2003(method) => method.start_balance(domain, s),
            Method::Sharp(method) => method.start_balance(domain, s),
        }
    }

    /// Gives the fluid in and about the bodies of these numbers, which have not been where they
    /// are, the motion that the method has there. Collective.
    ///
    /// # Errors
    /// When ranks cannot exchange ghosts, or a projection fails.
    pub fn mix_in(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        ids: &[usize],
    ) -> Result<()> {
        match self {
            Method::Mics2003(method) => method.mix_in(domain, s, ids),
            Method::Sharp(method) if !ids.is_empty() => {
                method.give_way(domain, s, |id| ids.contains(&id))
            }
            _ => Ok(()),
        }
    }

    /// Lets the bodies of these numbers begin where they are, in a flow that goes on: they have
    /// come in, or other forces act on them. Collective.
    ///
    /// # Errors
    /// When the state is another method's, or ranks cannot exchange ghosts.
    pub fn begin_bodies(
        &mut self,
        domain: &mut Domain<D>,
        s: &mut State<D>,
        ids: &[usize],
    ) -> Result<()> {
        match self {
            Method::Sharp(method) if !ids.is_empty() => {
                method.begin_bodies(domain, s, |id| ids.contains(&id))
            }
            Method::Mics2003(method) => method.begin_bodies(domain, s, ids),
            _ => Ok(()),
        }
    }

    /// Calls `take` with every body's number and the cells of this rank that it touches.
    pub fn with_body_overlaps(&self, mut take: impl FnMut(usize, &[Overlap])) {
        match self {
            Method::Plain(_) => {}
            Method::Mics2003(method) => {
                method.by_body().enumerate().for_each(|(k, overlaps)| take(k, overlaps))
            }
            Method::Sharp(method) => {
                method.by_body().enumerate().for_each(|(k, overlaps)| take(k, overlaps))
            }
        }
    }
}

fn vector<const D: usize>(field: &VectorField<D>, cell: usize) -> Vector3<f64> {
    Vector3::from_fn(|a, _| if a < D { field[a][cell] } else { 0.0 })
}

/// The momentum of this rank's cells (kg m/s).
fn cells_momentum<const D: usize>(
    grid: &Grid<D>,
    density: &Coefficient,
    u: &VectorField<D>,
) -> Vector3<f64> {
    let mut sum = Vector3::zeros();
    for (a, u) in u.iter().enumerate() {
        sum[a] = match density {
            Coefficient::Uniform(rho) => {
                rho * grid.rows().map(|row| u[row].iter().sum::<f64>()).sum::<f64>()
            }
            Coefficient::Field(rho) => {
                let row_sum = |row: std::ops::Range<usize>| -> f64 {
                    u[row.clone()].iter().zip(&rho[row]).map(|(u, rho)| u * rho).sum()
                };
                grid.rows().map(row_sum).sum()
            }
        };
    }
    sum * grid.cell_volume()
}
