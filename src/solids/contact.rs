//! stub
use crate::Result;
use crate::solids::Body;
use nalgebra::Vector3;
#[derive(Clone, Copy, Debug, Default, PartialEq)]
/// Push
pub struct Push {
    /// a
    pub acceleration: Vector3<f64>,
    /// a
    pub angular: Vector3<f64>,
}
#[derive(Clone, Copy, Debug, Default, PartialEq)]
/// Impulse
pub struct Impulse {
    /// a
    pub linear: Vector3<f64>,
    /// a
    pub angular: Vector3<f64>,
}
/// Contacts
pub struct Contacts;
impl Contacts {
    /// a
    pub fn advance(&mut self, _b: &mut [Body], _p: &[Push], _dt: f64) -> Result<usize> {
        Ok(0)
    }
    /// a
    pub fn impulses(&self) -> &[Impulse] {
        &[]
    }
}
