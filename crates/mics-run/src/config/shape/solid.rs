//! The shape of a body as the program sees it: round, in closed form, or a solid.
//!
//! ```text
//!        ,--.__          diameter            of the disc or sphere of its volume: Reynolds
//! numbers,
//!       /      `--.                          drag, stiffness, estimates
//!      (     o     )     bounding diameter   of the disc or sphere about its centre that holds
//!       `-.__     /                          all of it: room, periods, first guess of overlaps
//!            `---'       thickness           of its thinnest part: what the grid resolves
//! ```

use super::Typed;
use mics_shapes::{Scaled, Shape as Geometry};
use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_4, FRAC_PI_6, PI};
use std::sync::{Arc, Mutex, PoisonError};

/// The shape of a body, in its own axes: its typed description, and its solid where it is not
/// round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Shape {
    typed: Typed,
    /// `None` where the shape is round, or has not been built.
    #[serde(skip)]
    solid: Option<Solid>,
}

impl From<Typed> for Shape {
    fn from(typed: Typed) -> Shape {
        Shape { typed, solid: None }
    }
}

impl From<Solid> for Shape {
    fn from(solid: Solid) -> Shape {
        Shape { typed: solid.typed(), solid: Some(solid) }
    }
}

impl Shape {
    /// Its typed description; that of a solid has nothing in other files.
    pub fn typed(&self) -> &Typed {
        &self.typed
    }

    /// Its name, as the key of a case has it.
    pub fn name(&self) -> &'static str {
        self.typed.key()
    }

    /// The solid that it is, where it is not round.
    pub fn solid(&self) -> Option<&Solid> {
        self.solid.as_ref()
    }

    /// Whether it is a disc or a sphere.
    pub fn is_round(&self) -> bool {
        self.solid.is_none()
    }

    /// The diameter (m) of a disc or sphere.
    fn round(&self) -> f64 {
        self.typed.diameter().unwrap_or(0.0)
    }

    /// 2 or 3.
    pub fn dimension(&self) -> usize {
        match &self.solid {
            Some(solid) => solid.geometry.dimension(),
            None => self.typed.dimension().unwrap_or(3),
        }
    }

    /// Diameter (m) of the disc or sphere of the same volume.
    pub fn diameter(&self) -> f64 {
        self.solid().map_or_else(|| self.round(), Solid::diameter)
    }

    /// Diameter (m) of the disc or sphere about its centre that holds all of it.
    pub fn bounding_diameter(&self) -> f64 {
        self.solid().map_or_else(|| self.round(), |solid| 2.0 * solid.geometry.radius())
    }

    /// Width of its thinnest part (m).
    pub fn thickness(&self) -> f64 {
        self.solid().map_or_else(|| self.round(), |solid| solid.geometry.thickness())
    }

    /// Its volume (m3), or area (m2) in 2D.
    pub fn volume(&self) -> f64 {
        let d = self.round();
        match &self.solid {
            Some(solid) => solid.geometry.volume(),
            None if self.dimension() == 2 => FRAC_PI_4 * d * d,
            None => FRAC_PI_6 * d * d * d,
        }
    }

    /// The shape with this diameter (m), or in its own size.
    pub(in crate::config) fn of_diameter(&self, wanted: Option<f64>) -> Shape {
        match &self.solid {
            Some(solid) => solid.of_diameter(wanted).into(),
            None => self.typed.of_diameter(wanted).into(),
        }
    }
}

/// Diameter (m) of the disc or sphere of the volume of a solid.
fn equal_volume_diameter(geometry: &dyn Geometry) -> f64 {
    match geometry.dimension() {
        2 => (4.0 / PI * geometry.volume()).sqrt(),
        _ => (6.0 / PI * geometry.volume()).cbrt(),
    }
}

/// A solid as it is by itself, before it is scaled.
#[derive(Debug)]
pub(in crate::config) struct Base {
    /// Its description in a case, with nothing in other files and no diameter.
    typed: Typed,
    geometry: Arc<dyn Geometry>,
    /// Diameter of the disc or sphere of its volume (m).
    diameter: f64,
    /// Its scaled geometries, by the bits of their diameters.
    scaled: Mutex<HashMap<u64, Arc<dyn Geometry>>>,
}

/// A shape that is not round, in its own axes. Solids of one shape share it.
#[derive(Clone, Debug)]
pub struct Solid {
    base: Arc<Base>,
    /// The diameter (m) to which it is scaled.
    wanted: Option<f64>,
    geometry: Arc<dyn Geometry>,
}

impl PartialEq for Solid {
    fn eq(&self, other: &Solid) -> bool {
        self.wanted == other.wanted && self.is_like(other)
    }
}

impl Solid {
    /// A solid of this description, with nothing in other files and no diameter.
    ///
    /// # Errors
    /// When it is no solid, in words.
    pub(in crate::config) fn new(typed: Typed) -> Result<Solid, String> {
        let geometry = typed.solid()?;
        let diameter = equal_volume_diameter(&*geometry);
        let base = Base { typed, geometry: geometry.clone(), diameter, scaled: Mutex::default() };
        Ok(Solid { base: Arc::new(base), wanted: None, geometry })
    }

    /// The solid scaled to this diameter (m) of the disc or sphere of its volume; `None`: in its
    /// own size.
    pub(in crate::config) fn of_diameter(&self, wanted: Option<f64>) -> Solid {
        let Base { geometry, diameter, scaled, .. } = &*self.base;
        let geometry = match wanted {
            None => geometry.clone(),
            Some(wanted) => {
                let mut scaled = scaled.lock().unwrap_or_else(PoisonError::into_inner);
                let new = || -> Arc<dyn Geometry> {
                    Arc::new(Scaled::new(geometry.clone(), wanted / diameter))
                };
                scaled.entry(wanted.to_bits()).or_insert_with(new).clone()
            }
        };
        Solid { base: self.base.clone(), wanted, geometry }
    }

    /// Its geometry, in its own axes.
    pub fn geometry(&self) -> &Arc<dyn Geometry> {
        &self.geometry
    }

    /// The name of its shape, as the key of a case has it.
    pub fn name(&self) -> &'static str {
        self.base.typed.key()
    }

    /// Diameter (m) of the disc or sphere of its volume.
    pub fn diameter(&self) -> f64 {
        self.wanted.unwrap_or(self.base.diameter)
    }

    /// Whether both have one shape, whatever their sizes.
    pub fn is_like(&self, other: &Solid) -> bool {
        Arc::ptr_eq(&self.base, &other.base) || self.base.typed == other.base.typed
    }

    /// Its description in a case, with nothing in other files.
    pub(in crate::config) fn typed(&self) -> Typed {
        self.base.typed.of_diameter(self.wanted)
    }

    /// The diameter (m) to which it is scaled, if it is.
    pub(in crate::config) fn wanted(&self) -> Option<f64> {
        self.wanted
    }

    /// Number of its corners or balls, in words; empty where that says nothing.
    pub fn detail(&self) -> String {
        self.base.typed.detail()
    }

    /// Extent from its centre along an axis (m), to the low and to the high side, in this
    /// orientation.
    pub fn reach(&self, axis: usize, orientation: &UnitQuaternion<f64>) -> [f64; 2] {
        let along = orientation.inverse() * Vector3::ith(axis, 1.0);
        [-along, along].map(|n| self.geometry.extent(&n))
    }
}
