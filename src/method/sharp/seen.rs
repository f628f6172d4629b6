//! Cells about a body's surface as it sees them by itself, whatever else is near: a body that stays
//! where it is sees them once.

use super::PROFILE_DEPTH;
use super::gap::Surroundings;
use super::normal::{Ahead, Foot};
use super::stencil::Image;
use crate::geometry::{Nearest, Orientation, Planes, Pose};
use crate::particles::{Body, nearest_image};
use nalgebra::Vector3;
use std::ops::Range;

/// The displacement of a body in a step, and its orientation before.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    /// From its centre before the step to the present one (m).
    pub displacement: Vector3<f64>,
    /// Its orientation before the step.
    pub orientation: Orientation,
    /// As far as a point of it went (m).
    pub farthest: f64,
}

impl Moved {
    /// None of a body that lies where it lay.
    pub fn not(body: &Body) -> Moved {
        let orientation = body.orientation();
        Moved { displacement: Vector3::zeros(), orientation, farthest: 0.0 }
    }

    /// The displacement of a body since it had this pose, to the nearest image.
    pub fn since(before: &Pose, body: &Body, periods: &[Option<f64>; 3]) -> Moved {
        let displacement = nearest_image(&before.place, &body.centre, periods);
        let turned = (body.orientation().matrix() - before.orientation.matrix()).norm();
        let farthest = displacement.norm() + turned * body.radius();
        Moved { displacement, orientation: before.orientation, farthest }
    }
}

/// Scratch of the feet of a cell.
#[derive(Clone, Debug, Default)]
pub struct Feet {
    /// As a shape finds them.
    pub near: Vec<Nearest>,
    /// As profiles need them.
    pub of_cell: Vec<Foot>,
}

impl Feet {
    /// Room for so many.
    pub fn with_capacity(n: usize) -> Feet {
        Feet { near: Vec::with_capacity(n), of_cell: Vec::with_capacity(n) }
    }
}

/// Where a cell lies from a body.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// Signed distance from the surface (m), deep inside one that is nearer to zero, and the normal
    /// there of a body that is not round.
    pub s: f64,
    pub normal: Option<Vector3<f64>>,
    /// Whether the body has just left it.
    pub cleared: bool,
}

/// A cell that concerns a body.
#[derive(Clone, Copy, Debug)]
pub struct SeenCell {
    /// The image of the body that it is seen from.
    pub image: Image,
    /// From there to its middle (m), and the same where the body touches it, by the planes that
    /// cut it.
    pub arm: Vector3<f64>,
    pub touched: Option<Vector3<f64>>,
    /// Where it lies.
    pub sight: Sight,
    /// Its index in a field.
    pub cell: u32,
    /// Its feet, from the first to before the last, in the list that it is with.
    pub feet: [u32; 2],
}

impl SeenCell {
    /// Which of the feet are its own.
    pub fn feet(&self) -> Range<usize> {
        self.feet[0] as usize..self.feet[1] as usize
    }

    /// Adds its feet to a list, if the body `k` sets its velocity: one, of a cell inside of a body
    /// with sharp edges those on faces that are about as near, of a deep one none.
    pub fn find_feet<const D: usize>(
        &mut self,
        around: &Surroundings<D>,
        k: usize,
        reach: &CellRanges,
        feet: &mut Vec<Foot>,
        near: &mut Vec<Nearest>,
    ) {
        let Sight { s, normal, cleared } = self.sight;
        let first = feet.len() as u32;
        let body = &around.bodies[k];
        let outside = s > 0.0 && !cleared;
        near.clear();
        if reach.sets(&self.sight)
            && (outside || s > -body.radius().min(PROFILE_DEPTH * around.profiles.h))
        {
            if !outside && around.round.is_none() {
                let within = around.beside_nearest(s) - s;
                around.turned().feet(&self.arm, within, near);
            }
            if near.len() < 2 {
                near.clear();
                let normal = normal.unwrap_or_else(|| self.arm.normalize());
                near.push(Nearest { distance: s, normal });
            }
        }
        feet.extend(near.iter().map(|near| {
            let mut foot = Foot { near: *near, ahead: Ahead::NOTHING };
            foot.ahead = around.ahead(&foot.normal(around.round, &self.arm), true);
            foot
        }));
        self.feet = [first, feet.len() as u32];
    }
}

/// Findings about cells before that say something of those after them.
#[derive(Default)]
pub struct Known {
    planes: Planes,
    /// A point deep inside, and a signed distance from the surface (m) no further from zero.
    deep: Option<(Vector3<f64>, f64)>,
}

impl Known {
    /// A signed distance (m) no further from zero than that of a point near a deep one.
    fn near(&self, arm: &Vector3<f64>) -> Option<f64> {
        self.deep.map(|(point, near)| near + (arm - point).norm())
    }
}

/// Distances outside a body up to which cells concern it (m).
pub struct CellRanges {
    /// In gaps that the grid does not resolve.
    pub tight: f64,
    /// As far as a point of the body went.
    pub travelled: f64,
    /// Beside the faces that it covers.
    pub beside: f64,
    /// With a profile as those inside have.
    pub outside: f64,
}

impl CellRanges {
    /// Sight of the cell at `arm` (m) by the body, which `moved`; none where the cell is nothing to
    /// it.
    pub fn sight<const D: usize>(
        &self,
        around: &Surroundings<D>,
        moved: &Moved,
        arm: &Vector3<f64>,
        touched: bool,
        known: &mut Known,
    ) -> Option<Sight> {
        let body = around.turned();
        let point = Vector3::zeros();
        let far = self.tight.max(self.travelled).max(self.beside);
        if !touched && around.round.is_none() && known.planes.clears(&body, arm, &point, far) {
            return None;
        }
        let deep = -PROFILE_DEPTH * around.profiles.h;
        let near = known.near(arm).filter(|near| *near < deep).or_else(|| {
            let near = body.clearance(arm)?;
            known.deep = (near < deep).then_some((*arm, near)).or(known.deep);
            Some(near)
        });
        if !touched && near.is_some_and(|near| near > far) {
            return None;
        }
        let (s, normal) = match near.filter(|near| *near < deep) {
            Some(near) => (near, None),
            None => around.nearest(arm),
        };
        let cleared = s > 0.0
            && s <= self.travelled
            && around.distance(&moved.orientation, &(arm + moved.displacement)) <= 0.0;
        let concerns = touched || cleared || s <= self.tight || s < self.beside;
        (concerns && body.owns(arm)).then_some(Sight { s, normal, cleared })
    }

    /// Whether the body sets the velocity of a cell of which it has this sight, so far as it owns
    /// it.
    pub fn sets(&self, sight: &Sight) -> bool {
        sight.s <= self.tight.max(self.outside) || sight.cleared
    }
}

/// Findings about the grid of a body that stays where it is.
#[derive(Clone, Debug)]
pub struct Kept<const D: usize> {
    /// Where it stays (m), and how it is turned.
    centre: Vector3<f64>,
    orientation: Orientation,
    /// The faces that it covers, by axis.
    pub faces: [Vec<KeptFace>; D],
    /// Whether the cells of a body that is not round have been seen, these, and their feet.
    pub sees: bool,
    pub cells: Vec<SeenCell>,
    pub feet: Vec<Foot>,
    /// Distances to itself along the normals at the points of its surface, if it is not round.
    ahead: Vec<Ahead>,
}

/// A face that such a body covers.
#[derive(Clone, Copy, Debug)]
pub struct KeptFace {
    /// From the body's centre to the face's (m), and the signed distance from its surface there
    /// (m), where it covers a part.
    pub arm: Vector3<f64>,
    pub distance: f64,
}

impl<const D: usize> Kept<D> {
    /// Empty for a body that does not move; `None` for one that does.
    pub fn of(body: &Body) -> Option<Box<Kept<D>>> {
        let kept = || Kept {
            centre: body.centre,
            orientation: body.orientation(),
            faces: std::array::from_fn(|_| Vec::new()),
            sees: false,
            cells: Vec::new(),
            feet: Vec::new(),
            ahead: Vec::new(),
        };
        (!body.moves()).then(|| Box::new(kept()))
    }

    /// Distances to itself along the normal at a point, the next one or one of those before.
    pub fn ahead_of(&mut self, point: usize, ahead: impl FnOnce() -> Ahead) -> Ahead {
        if point == self.ahead.len() {
            self.ahead.push(ahead());
        }
        self.ahead[point]
    }

    /// Whether it is of a body as that lies now.
    pub fn is_of(&self, body: &Body) -> bool {
        let turned = || self.orientation != body.orientation() && !body.shape().is_round();
        !body.moves() && self.centre == body.centre && !turned()
    }
}
