//! Bodies of a swarm before they have places: which of its shapes each has, its diameter and its
//! orientation.

use super::{Diameters, Orientations, Scatter, Swarm};
use crate::config::{Orientation, Round, Shape, Typed};
use nalgebra::{Quaternion, UnitQuaternion};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A shape of a swarm, built.
#[derive(Clone, Debug, PartialEq)]
pub struct Kind {
    /// Its share of the bodies, as a part of the shares of all.
    pub share: f64,
    /// The shape, built.
    pub shape: Shape,
}

/// A body of a swarm, without its place.
#[derive(Clone, Debug)]
pub(super) struct Made {
    pub shape: Shape,
    pub orientation: Option<Orientation>,
}

impl Kind {
    /// Diameter (m) of the disc or sphere that holds all of it where it is scaled to a `diameter`
    /// (m).
    pub fn bounding(&self, diameter: Option<f64>) -> f64 {
        let own = self.shape.bounding_diameter();
        diameter.map_or(own, |wanted| own * wanted / self.shape.diameter())
    }

    /// A body of this shape, scaled to a diameter (m).
    pub(super) fn made(&self, diameter: Option<f64>, orientation: Option<Orientation>) -> Made {
        let diameter = diameter.or(self.shape.typed().diameter());
        Made { shape: self.shape.of_diameter(diameter), orientation }
    }
}

/// The kinds of its bodies: of a swarm without shapes the disc or sphere, whose diameter is given
/// each time.
pub(super) fn kinds(swarm: &Swarm, dimension: usize) -> Vec<Kind> {
    if !swarm.solids.is_empty() {
        return swarm.solids.clone();
    }
    let round = Round { diameter: 1.0 };
    let shape = if dimension == 2 { Typed::Disc(round) } else { Typed::Sphere(round) };
    vec![Kind { share: 1.0, shape: shape.into() }]
}

/// Kind and orientation of each of the bodies, one after the other, without end.
pub(super) fn choices<'a>(
    swarm: &Swarm,
    dimension: usize,
    kinds: &'a [Kind],
) -> impl Iterator<Item = (&'a Kind, Option<Orientation>)> {
    // A random stream of its own: diameters and places stay the same as for discs.
    let mut random = ChaCha8Rng::seed_from_u64(swarm.seed.unwrap_or(1));
    random.set_stream(1);
    let turns = swarm.orientations.unwrap_or_default() == Orientations::Random;
    let all: f64 = kinds.iter().map(|kind| kind.share).sum();
    let mut missing = vec![0.0; kinds.len()];
    std::iter::repeat_with(move || {
        let parts = kinds.iter().map(|kind| kind.share / all);
        missing.iter_mut().zip(parts).for_each(|(missing, part)| *missing += part);
        // The first of those that lag most.
        let most = missing.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let k = missing.iter().position(|m| *m >= most - 1e-9).unwrap_or(0);
        missing[k] -= 1.0;
        let turned = turns && !kinds[k].shape.is_round();
        (&kinds[k], turned.then(|| turned_anyhow(dimension, &mut random)))
    })
}

/// A random orientation, all equally likely.
fn turned_anyhow(dimension: usize, random: &mut ChaCha8Rng) -> Orientation {
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    if dimension == 2 {
        return Orientation::Plane(360.0 * uniform());
    }
    // Marsaglia (1972): two points in the unit disc make one of the unit sphere in four dimensions.
    let mut disc = || loop {
        let x = 2.0 * uniform() - 1.0;
        let y = 2.0 * uniform() - 1.0;
        let square = x * x + y * y;
        if square < 1.0 && square > 0.0 {
            return (x, y, square);
        }
    };
    let (a, b, first) = disc();
    let (c, d, second) = disc();
    let factor = ((1.0 - first) / second).sqrt();
    let turn = Quaternion::new(a, b, factor * c, factor * d);
    Orientation::by(&UnitQuaternion::new_normalize(turn))
}

/// Its bodies with their diameters (m), and the random numbers that come after these.
pub(super) fn bodies(
    scatter: &Scatter<'_>,
    swarm: &Swarm,
    dimension: usize,
) -> (Vec<Made>, ChaCha8Rng) {
    let kinds = kinds(swarm, dimension);
    let mut random = ChaCha8Rng::seed_from_u64(scatter.seed);
    let mut diameter = || {
        let [least, largest] = scatter.diameter.map(Diameters::bounds)?;
        let part = (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        Some((least + part * (largest - least)).min(largest))
    };
    let diameters: Vec<Option<f64>> = (0..scatter.count).map(|_| diameter()).collect();
    let choices = choices(swarm, dimension, &kinds);
    let made = diameters
        .into_iter()
        .zip(choices)
        .map(|(diameter, (kind, orientation))| kind.made(diameter, orientation));
    (made.collect(), random)
}
