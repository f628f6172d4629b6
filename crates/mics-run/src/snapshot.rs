//! Snapshots: the fields of a scene, as a file ([`crate::vti`]) and in memory.

use crate::vti::{self, Head};
use crate::{Error, Result};
use std::fs;
use std::path::Path;

/// One array of a snapshot, a value or three for each cell, x fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Its name in ParaView.
    pub name: String,
    /// 1 for a scalar, 3 for a vector.
    pub components: usize,
    /// `components` numbers a cell.
    pub values: Vec<f64>,
}

/// The whole grid's fields at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Time (s).
    pub time: f64,
    /// Cells along x, y, z (1 along z in 2D).
    pub cells: [usize; 3],
    /// Spacing (m); in 2D that along z is that along x.
    pub h: [f64; 3],
    /// Velocity (m/s), pressure (Pa), vorticity (1/s), in 3D Q (1/s2), whose isosurfaces show
    /// vortices, solid fraction, density (kg/m3) where it varies. In cells that a body fills by
    /// more than half, velocity, vorticity and Q are those of the body's own motion.
    pub arrays: Vec<Array>,
}

impl Snapshot {
    /// The array of a name.
    pub fn array(&self, name: &str) -> Option<&Array> {
        self.arrays.iter().find(|a| a.name == name)
    }

    /// Reads the file of a snapshot.
    ///
    /// # Errors
    /// When the file is not there or not of that form.
    pub fn read(path: &Path) -> Result<Snapshot> {
        let bytes = fs::read(path).map_err(Error::io(path))?;
        Self::parse(&bytes).ok_or_else(|| vti::strange(path))
    }

    /// The time (s) of the file of a snapshot, from its first lines.
    ///
    /// # Errors
    /// When the file is not there or not of that form.
    pub fn time_of(path: &Path) -> Result<f64> {
        Head::read(path).map(|(head, _)| head.time)
    }

    fn parse(bytes: &[u8]) -> Option<Snapshot> {
        let (Head { time, cells, h, arrays: listed }, data) = Head::parse(bytes)?;
        let mut rest = &bytes[data..];
        let mut arrays = Vec::with_capacity(listed.len());
        for (name, components) in listed {
            let (size, values) = rest.split_first_chunk()?;
            let (values, after) = values.split_at_checked(u64::from_le_bytes(*size) as usize)?;
            let values: Vec<_> = values
                .chunks_exact(8)
                .filter_map(|b| b.try_into().ok().map(f64::from_le_bytes))
                .collect();
            if components * cells.iter().product::<usize>() != values.len() {
                return None;
            }
            arrays.push(Array { name, components, values });
            rest = after;
        }
        Some(Snapshot { time, cells, h, arrays })
    }
}

impl Array {
    /// One value a cell.
    pub fn scalar(name: &str, values: Vec<f64>) -> Array {
        Array { name: name.into(), components: 1, values }
    }

    /// Three components a cell; those that are missing are zero.
    pub fn vector(name: &str, parts: Vec<Vec<f64>>) -> Array {
        let n = parts.first().map_or(0, Vec::len);
        let values = (0..n).flat_map(|c| (0..3).map(move |k| (c, k)));
        let values = values.map(|(c, k)| parts.get(k).map_or(0.0, |p| p[c])).collect();
        Array { name: name.into(), components: 3, values }
    }
}
