//! A cell in a list of a body that other bodies are about as near to ([`super::shared`]).

/// A cell in a list of a body, which shares it with others.
#[derive(Clone, Copy, Debug)]
pub struct SharedCell {
    /// Its index in a field.
    pub cell: u32,
    /// Its place in the list.
    pub place: u32,
    /// The body's ownership weight to it.
    pub owned: f64,
    /// Weight that it would have there were the body alone.
    pub weight: f64,
    /// Whether the body has just left it.
    pub cleared: bool,
}

impl SharedCell {
    /// The shared cell that comes next to a list.
    pub fn next<T>(list: &[T], cell: u32, owned: f64, weight: f64, cleared: bool) -> SharedCell {
        SharedCell { cell, place: list.len() as u32, owned, weight, cleared }
    }
}
