//! A body as it cuts the grid: the faces that it covers, the cells inside whose velocity it sets,
//! the points of its surface where its traction is taken. Rebuilt when the body moves.
//! [`super::stencil`] has what is read of the velocity beside its surface.
//!
//! ```text
//!      .   .   .   .      o   ghost cells: inside, in gaps that the grid does not resolve, and
//!   ---o---o---o---o---       within 0.2 h outside a flat surface of a fixed body
//!      o   o  +|   .      +   between two faces that are about as near: the profiles of both
//!   .   .  . --+   .
//! ```

use super::gap::{self, GapFlow, Surroundings, UNRESOLVED, smooth_step};
use super::near::walls_within;
use super::neighbour;
use super::normal::{Foot, Normal};
use super::seen::{CellRanges, Feet, Kept, KeptFace, Known, Moved, SeenCell, Sight};
use super::shared_cell::SharedCell;
use super::stencil::{Cubic, Image, Reading, Stencil, Stencils};
use crate::geometry::{
    Block, Cut, Cuts, FaceCentroids, Overlap, Placed, Pose, Shape, SurfacePoint, aperture,
    fraction, images,
};
use crate::grid::{Grid, VectorField};
use crate::particles::Body;
use nalgebra::Vector3;
use std::sync::Arc;

/// Spacings beyond a body at which a rank has nothing of it.
pub(super) const BEYOND: f64 = 2.0;

/// Distance (spacings) up to which cells outside a fixed flat surface have the profile in place of
/// a momentum of their own, and up to twice that a part of it: a row of them along it would see no
/// more of themselves in their ghost cells, and turn with the row above, faster than eight Legendre
/// stages bear (1.075 times a step at 0.01, 1.015 at 0.05, 0.95 at 0.1).
const CLOSE: f64 = 0.1;

/// Room for the faces that are about as near to a cell.
const MOST_FEET: usize = 16;

/// A body shares at most one of so many of its cells: they lie in the plane between two.
const FEW: usize = 4;

/// Largest distance of a cell's middle from what a face beside it is covered by (m).
fn beside_face<const D: usize>(grid: &Grid<D>) -> f64 {
    let square = |axis: usize| {
        (0..D).map(|a| grid.h[a] * if a == axis { 1.0 } else { 0.5 }).map(|x| x * x).sum::<f64>()
    };
    (0..D).map(square).fold(0.0, f64::max).sqrt()
}

/// A cell whose velocity a body sets.
#[derive(Clone, Debug)]
pub struct GhostCell {
    /// From the body's centre (m).
    pub arm: Vector3<f64>,
    /// Share of its velocity that gives way to the profile: less than 1 outside, in gaps that the
    /// grid does not resolve.
    pub weight: f64,
    /// The velocity that it is set to (m/s), as last found.
    pub target: Vector3<f64>,
    /// Its velocity at the start of the step less the target at its end (m/s), where steps need
    /// that.
    pub offset: Vector3<f64>,
    /// Its index in a field.
    pub cell: u32,
    /// Whether it lies outside by now, and was inside before the body moved.
    pub cleared: bool,
    /// Whether it is the first of the bodies' ghost cells that share a cell, or the only one.
    pub first: bool,
}

/// A cell that a body touches and is nearest to, alone or with others.
#[derive(Clone, Debug)]
pub struct OwnCell<const D: usize> {
    /// From the body's centre (m).
    pub arm: Vector3<f64>,
    /// Ownership weight of the body: 1 where no other body is about as near.
    pub ownership: f64,
    /// Acceleration that its cut faces add to the mean acceleration of its faces (m/s2), as last
    /// found.
    pub cut_change: [f64; D],
    /// Its index in a field.
    pub cell: u32,
}

/// A face in a gap that the grid does not resolve: the cells beside it are set by what bounds the
/// gap, and only its correction has the flow.
#[derive(Clone, Copy, Debug)]
pub struct GapFace {
    /// The face's index in a field.
    pub face: u32,
    /// The flow through it.
    pub flow: GapFlow,
}

/// A ghost cell outside, in such a gap.
#[derive(Clone, Copy, Debug)]
struct GapCell {
    /// Its place among the ghost cells, and among those that the body shares, if it is one.
    place: u32,
    shared: Option<u32>,
    /// The flow in it.
    flow: GapFlow,
}

/// The faces that a body covers.
#[derive(Clone, Debug)]
pub struct CoveredFaces<const D: usize> {
    /// Faces within the box, by axis.
    pub cuts: [Cuts<D>; D],
    /// Faces at the sides of the box that an obstacle covers, by axis.
    pub at_sides: [Cuts<D>; D],
    /// Owners of the cells below and above each face, by axis, of an obstacle that is one solid
    /// with others: numbers among these.
    pub owners: [Vec<[u32; 2]>; D],
    /// Faces in narrow gaps that are nearest to it, by axis.
    pub gaps: [Vec<GapFace>; D],
    /// Whether they may be faces of cells at a closed side of the box.
    pub at_boundary: bool,
}

/// The cells that a body touches and is nearest to.
#[derive(Clone, Debug)]
pub struct OwnCells<const D: usize> {
    /// All of them.
    pub cells: Vec<OwnCell<D>>,
    /// Own cells that it shares with others.
    pub shared: Vec<SharedCell>,
}

/// The cells whose velocity a body sets.
#[derive(Clone, Debug, Default)]
pub struct GhostCells {
    /// All of them.
    pub cells: Vec<GhostCell>,
    /// The profiles of those that are not deep inside: one from each face that is about as near.
    pub profiles: Vec<Reading>,
    /// The cubic extrapolation of those that have one; none where a body moves.
    pub cubic: Vec<Cubic>,
    /// Ghost cells that it shares with others.
    pub shared: Vec<SharedCell>,
    /// Those in narrow gaps.
    in_gaps: Vec<GapCell>,
    /// Scratch of the faces that are about as near to one.
    pub(super) feet: Feet,
}

/// The surface of a body, where its traction is taken.
#[derive(Clone, Debug)]
pub struct SurfaceReadings {
    /// Where all points lie in the body's own axes, about two a spacing; round bodies of one radius
    /// have one list.
    quadrature_points: Arc<[SurfacePoint]>,
    /// Points of this rank, with the slope of the velocity along the outward normal there (1/s), by
    /// their parts of the surface (m2; m per metre of depth).
    pub points: Vec<Reading>,
    /// Whether it is flat in places: two points side by side have one normal.
    pub(super) flat: bool,
}

/// A body on the grid.
#[derive(Clone, Debug)]
pub struct CutBody<const D: usize> {
    /// Faces that it covers.
    pub faces: CoveredFaces<D>,
    /// Cells that it touches, with its fraction of them.
    pub solid: Vec<Overlap>,
    /// Cells that it touches to which no other body is nearer.
    pub own: OwnCells<D>,
    /// Cells whose velocity it sets.
    pub ghosts: GhostCells,
    /// Its surface.
    pub surface: SurfaceReadings,
    /// Stencils by which it reads the velocity beside its surface.
    pub stencils: Stencils<D>,
    /// Faces and cells that it found before, of a body that stays where it is.
    pub(super) kept: Option<Box<Kept<D>>>,
    /// Whether another body or a surface is so near that there may be some in narrow gaps.
    pub has_neighbours: bool,
}

impl<const D: usize> CoveredFaces<D> {
    /// None yet, with room for so many along an axis.
    fn with_capacity(faces: usize) -> CoveredFaces<D> {
        CoveredFaces {
            cuts: std::array::from_fn(|_| Cuts::with_capacity(faces)),
            at_sides: std::array::from_fn(|_| Cuts::with_capacity(0)),
            owners: std::array::from_fn(|_| Vec::new()),
            gaps: std::array::from_fn(|_| Vec::with_capacity(faces)),
            at_boundary: false,
        }
    }
}

impl<const D: usize> OwnCells<D> {
    /// None yet, with room for so many, of which so many touch the body.
    fn with_capacity(cells: usize, touched: usize) -> OwnCells<D> {
        let shared = Vec::with_capacity(touched / FEW);
        OwnCells { cells: Vec::with_capacity(cells), shared }
    }

    fn clear(&mut self) {
        self.cells.clear();
        self.shared.clear();
    }
}

impl GhostCells {
    /// None yet, with room for so many.
    fn with_capacity(cells: usize) -> GhostCells {
        GhostCells {
            cells: Vec::with_capacity(cells),
            profiles: Vec::with_capacity(cells),
            cubic: Vec::new(),
            shared: Vec::with_capacity(cells / FEW),
            in_gaps: Vec::with_capacity(cells / FEW),
            feet: Feet::with_capacity(MOST_FEET),
        }
    }

    fn clear(&mut self) {
        self.cells.clear();
        self.profiles.clear();
        self.cubic.clear();
        self.shared.clear();
        self.in_gaps.clear();
    }

    /// Weights of those in narrow gaps in a step with this friction there: as far as friction makes
    /// the profile across.
    pub fn rub(&mut self, friction: f64) {
        for GapCell { place, shared, flow } in &self.in_gaps {
            let weight = flow.share * (1.0 - flow.kept(friction));
            self.cells[*place as usize].weight = weight;
            if let Some(shared) = shared {
                self.shared[*shared as usize].weight = weight;
            }
        }
    }
}

impl SurfaceReadings {
    /// With these points, of which none has been read.
    fn new(quadrature_points: Arc<[SurfacePoint]>) -> SurfaceReadings {
        let points = Vec::with_capacity(quadrature_points.len());
        SurfaceReadings { quadrature_points, points, flat: false }
    }
}

/// The points on the surfaces of round bodies, by their radii (m): one list for all of a radius.
#[derive(Default)]
pub struct KnownSurfaces(Vec<(f64, Arc<[SurfacePoint]>)>);

impl KnownSurfaces {
    /// The points on a body's surface, about two a spacing `h` (m).
    fn of(&mut self, body: &Body, h: f64) -> Arc<[SurfacePoint]> {
        let round = neighbour::round(body);
        if let Some((_, points)) = self.0.iter().find(|(other, _)| Some(*other) == round) {
            return points.clone();
        }
        let points: Arc<[_]> = body.shape().surface(h).into();
        self.0.extend(round.map(|radius| (radius, points.clone())));
        points
    }
}

impl<const D: usize> CutBody<D> {
    /// One with room for all that a body can touch, its image points counting in spacings of `h`
    /// (m). Of several ranks a body touches few: there it takes room as it comes.
    pub fn new(grid: &Grid<D>, body: &Body, surfaces: &mut KnownSurfaces, h: f64) -> CutBody<D> {
        let shape = body.shape();
        let quadrature_points = surfaces.of(body, h);
        if shape.is_obstacle() {
            // It takes the room that it needs when it is first built.
            let surface = SurfaceReadings::new(quadrature_points);
            return CutBody { surface, ..CutBody::elsewhere(grid) };
        }
        let cells = |beyond: f64| fraction::most_cells(grid, shape.radius() + beyond * h);
        let own = if shape.is_round() { 0.0 } else { 1.0 };
        let tight = shape.radius() + gap::UNRESOLVED * h;
        let ghosts = fraction::most_middles(grid, tight);
        let points = quadrature_points.len();
        CutBody {
            faces: CoveredFaces::with_capacity(cells(1.0)),
            solid: Vec::with_capacity(cells(0.0)),
            own: OwnCells::with_capacity(cells(own), cells(0.0)),
            ghosts: GhostCells::with_capacity(ghosts),
            surface: SurfaceReadings::new(quadrature_points),
            stencils: Stencils::new(grid, ghosts, points, shape.is_round()),
            kept: None,
            has_neighbours: false,
        }
    }

    /// Nothing: of a body that does not reach into this rank's box.
    pub fn elsewhere(grid: &Grid<D>) -> CutBody<D> {
        CutBody {
            faces: CoveredFaces::with_capacity(0),
            solid: Vec::new(),
            own: OwnCells::with_capacity(0, 0),
            ghosts: GhostCells::default(),
            surface: SurfaceReadings::new(Arc::new([])),
            stencils: Stencils::new(grid, 0, 0, true),
            kept: None,
            has_neighbours: false,
        }
    }

    /// Whether it has to be built, having just come, or has nothing here.
    pub fn is_empty(&self) -> bool {
        self.surface.quadrature_points.is_empty()
    }

    /// Whether it has just left cells that other bodies or surfaces may be near to.
    pub fn has_left_shared_cells(&self) -> bool {
        self.has_neighbours && self.ghosts.cells.iter().any(|ghost| ghost.cleared)
    }

    /// The faces along `axis` that it covers.
    pub fn covered(&self, axis: usize) -> impl Iterator<Item = (&Cut, &FaceCentroids<D>)> {
        self.faces.cuts[axis].with_centroids()
    }

    /// Gives the faces that it covers, whose velocity is the fluid's (m/s), their part of its own.
    pub fn cover_faces(&self, body: &Body, faces: &mut VectorField<D>) {
        for (axis, faces) in faces.iter_mut().enumerate() {
            for (cut, centroids) in self.covered(axis) {
                let face = &mut faces[cut.face as usize];
                *face += cut.solid_fraction * (body.velocity[axis] - *face)
                    + body.spin.cross(&centroids.lever())[axis];
            }
        }
    }

    /// Finds the faces and cells of the body `k`, as it lies now and lay `before`; in `planes` and
    /// `arms` is scratch.
    pub fn rebuild(
        &mut self,
        around: &Surroundings<D>,
        k: usize,
        moved: &Moved,
        planes: &mut [Vec<f64>; 3],
        arms: &mut [Vec<Vector3<f64>>; D],
    ) {
        let grid = around.grid;
        let body = &around.bodies[k];
        let shape = body.shape();
        self.has_neighbours = around.has_neighbours(k);
        let tight = if self.has_neighbours { gap::UNRESOLVED * around.profiles.h } else { 0.0 };
        let bounds = body.reach().sup(&shape.turned(&moved.orientation).bounds());
        let reached = bounds
            .add_scalar(moved.displacement.norm().max(tight))
            .add_scalar(BEYOND * around.profiles.h);
        if images(grid, body.shape(), &body.centre)
            .all(|image| Block::owned(grid, &image, &reached).ends().is_none())
        {
            if !self.surface.quadrature_points.is_empty() {
                // It has left: its room goes with it.
                *self = CutBody::elsewhere(grid);
            }
            return;
        }
        if self.surface.quadrature_points.is_empty() {
            self.surface.quadrature_points = shape.surface(around.profiles.h).into();
        }
        self.find_covered(around, k, &bounds, planes, arms);
        self.own.clear();
        self.ghosts.clear();
        self.faces.gaps.iter_mut().for_each(Vec::clear);
        self.stencils.begin(grid, &body.centre);
        self.find_cells(around, k, moved, &bounds, tight);
        if tight > 0.0 {
            self.find_gaps(around, k, arms);
        }
        self.place_points(around, k);
    }

    fn is_kept(&self, body: &Body) -> bool {
        self.kept.as_ref().is_some_and(|kept| kept.is_of(body))
    }

    /// Finds the faces and the parts of cells that the body `k` covers, within `bounds` about its
    /// centre (m), and the `arms` to the faces (m); of one that lies where it was found, they are
    /// as they were.
    fn find_covered(
        &mut self,
        around: &Surroundings<D>,
        k: usize,
        bounds: &Vector3<f64>,
        planes: &mut [Vec<f64>; 3],
        arms: &mut [Vec<Vector3<f64>>; D],
    ) {
        let grid = around.grid;
        let body = &around.bodies[k];
        let orientation = around.orientation;
        if self.is_kept(body) {
            return;
        }
        let shape = body.shape();
        let placed = Placed { shape, pose: Pose { place: body.centre, orientation } };
        let mut points = self.surface.quadrature_points.windows(2);
        self.surface.flat = points.any(|two| two[0].normal == two[1].normal);
        // A face along an axis has a cell on either side.
        let reached = bounds + Vector3::from_fn(|a, _| if a < D { 2.0 * grid.h[a] } else { 0.0 });
        let walls = walls_within(grid, &body.centre, &reached);
        self.faces.at_boundary = walls.as_flattened().contains(&true);
        let CoveredFaces { cuts, at_sides, .. } = &mut self.faces;
        for (axis, cuts) in cuts.iter_mut().enumerate() {
            if shape.is_obstacle() {
                let sides = &mut at_sides[axis];
                aperture::cuts_at_sides(grid, axis, &placed, planes, sides, &mut arms[axis]);
            }
            aperture::cuts(grid, axis, &placed, planes, cuts, &mut arms[axis]);
        }
        self.find_owners(grid, shape, arms);
        fraction::overlaps(grid, &placed, fraction::Rule::Exact, planes, &mut self.solid);
        self.kept = Kept::of(body);
        if let Some(kept) = &mut self.kept {
            for ((kept, cuts), arms) in kept.faces.iter_mut().zip(&self.faces.cuts).zip(arms) {
                kept.extend(cuts.iter().zip(arms).map(|(cut, arm)| {
                    let distance = || around.distance(&orientation, arm);
                    let distance = if cut.solid_fraction < 1.0 { distance() } else { 0.0 };
                    KeptFace { arm: *arm, distance }
                }));
            }
        }
    }

    /// Finds to which obstacles the cells beside its faces belong, by the arms to these (m), where
    /// it is one solid with others.
    fn find_owners(&mut self, grid: &Grid<D>, shape: &dyn Shape, arms: &[Vec<Vector3<f64>>; D]) {
        let Some(obstacle) = shape.obstacle().filter(|obstacle| obstacle.is_joined()) else {
            return;
        };
        for (axis, (owners, arms)) in self.faces.owners.iter_mut().zip(arms).enumerate() {
            let step = 0.5 * grid.h[axis] * Vector3::ith(axis, 1.0);
            owners.clear();
            owners.extend(
                arms.iter().map(|arm| [arm - step, arm + step].map(|x| obstacle.owner(&x))),
            );
        }
    }

    /// Finds the faces in gaps that the grid does not resolve, by the arms to their centres (m).
    fn find_gaps(&mut self, around: &Surroundings<D>, k: usize, arms: &[Vec<Vector3<f64>>; D]) {
        let kept = self.kept.as_ref();
        let CoveredFaces { cuts, gaps, .. } = &mut self.faces;
        for (axis, gaps) in gaps.iter_mut().enumerate() {
            let cuts = cuts[axis].with_centroids().enumerate();
            for (n, (cut, _)) in cuts.filter(|(_, (_, centroids))| centroids.alone < 1.0) {
                let (arm, own) = kept.map_or_else(
                    || {
                        let arm = &arms[axis][n];
                        (arm, around.distance(&around.orientation, arm))
                    },
                    |kept| (&kept.faces[axis][n].arm, kept.faces[axis][n].distance),
                );
                let flow = around.flow(around.width_at(k, arm, own));
                if let Some(flow) = flow.filter(|_| around.is_nearest(k, arm, own)) {
                    gaps.push(GapFace { face: cut.face, flow });
                }
            }
        }
    }

    /// The points of the surface; each belongs to the rank of its cell.
    fn place_points(&mut self, around: &Surroundings<D>, k: usize) {
        self.surface.points.clear();
        let grid = around.grid;
        let body = &around.bodies[k];
        let bounds = body.reach();
        let inside = Block::is_inside(grid, &body.centre, &bounds)
            .then(|| self.stencils.image(grid, body.centre));
        let mut kept = self.kept.take();
        let SurfaceReadings { quadrature_points, points, .. } = &mut self.surface;
        for SurfacePoint { place, normal, area } in quadrature_points.iter() {
            let arm = around.orientation * place;
            let image = || {
                let centre = images(grid, body.shape(), &body.centre)
                    .find(|image| grid.owns(&(image + arm)))?;
                Some(self.stencils.image(grid, centre))
            };
            let Some(image) = inside.or_else(image) else { continue };
            let mut normal = Normal::new(around.round, &arm, 0.0, around.orientation * normal);
            let ahead = || around.ahead(&normal, false);
            normal.ahead = match &mut kept {
                Some(kept) if around.round.is_none() => kept.ahead_of(points.len(), ahead),
                _ => ahead(),
            };
            let stencil = self.stencils.slope(around, &image, &normal);
            let place = points.len() as u32;
            points.push(Reading { arm, stencil, place, share: *area });
        }
        self.kept = kept;
    }

    /// Finds its own cells and its ghost cells within `bounds` about its centre (m), of which those
    /// in gaps narrower than `tight` (m) lie outside. A body that stays where it is sees each cell
    /// once, as far as it ever may.
    fn find_cells(
        &mut self,
        around: &Surroundings<D>,
        k: usize,
        moved: &Moved,
        bounds: &Vector3<f64>,
        tight: f64,
    ) {
        let reach = self.reach(around, k, moved, tight);
        let mut kept = self.kept.take();
        let mut feet = std::mem::take(&mut self.ghosts.feet);
        if let Some(kept) = kept.as_mut().filter(|_| around.round.is_none()) {
            if !kept.sees {
                let reach = self.reach(around, k, moved, UNRESOLVED * around.profiles.h);
                self.see_cells(around, k, moved, bounds, &reach, |_, mut seen| {
                    seen.find_feet(around, k, &reach, &mut kept.feet, &mut feet.near);
                    kept.cells.push(seen);
                });
                kept.sees = true;
            }
            for seen in &kept.cells {
                let owned = around.ownership(&seen.arm, seen.sight.s);
                self.add_cell(around, &reach, seen, owned, &kept.feet);
            }
        } else {
            let Feet { near, of_cell } = &mut feet;
            self.see_cells(around, k, moved, bounds, &reach, |body, mut seen| {
                let owned = around.ownership(&seen.arm, seen.sight.s);
                of_cell.clear();
                if owned > 0.0 {
                    seen.find_feet(around, k, &reach, of_cell, near);
                }
                body.add_cell(around, &reach, &seen, owned, of_cell);
            });
        }
        self.kept = kept;
        self.ghosts.feet = feet;
    }

    /// Calls with the cells that concern it, of those within `bounds` about its centre (m) and the
    /// reach beyond.
    fn see_cells(
        &mut self,
        around: &Surroundings<D>,
        k: usize,
        moved: &Moved,
        bounds: &Vector3<f64>,
        reach: &CellRanges,
        mut found: impl FnMut(&mut CutBody<D>, SeenCell),
    ) {
        let grid = around.grid;
        let body = &around.bodies[k];
        let mut touched_cells = 0;
        let extent = bounds.add_scalar(moved.displacement.norm().max(reach.tight));
        let extent = extent.add_scalar(reach.beside);
        for centre in images(grid, body.shape(), &body.centre) {
            let image = self.stencils.image(grid, centre);
            let mut known = Known::default();
            for at in Block::owned(grid, &centre, &extent) {
                let arm = Vector3::from_fn(|a, _| {
                    if a < D { (at[a] as f64 + 0.5) * grid.h[a] - centre[a] } else { 0.0 }
                });
                let Some(cell) = grid.owned_index(at) else { continue };
                // Cells that it touches come in the same order, image by image; the next one may be
                // the first that another image touches.
                let own = |solid: &Overlap| {
                    solid.cell == cell && (solid.arm - arm).amax() < around.profiles.h
                };
                let touched = self.solid.get(touched_cells).filter(|solid| own(solid));
                let touched = touched.map(|solid| solid.arm);
                touched_cells += usize::from(touched.is_some());
                let sight = reach.sight(around, moved, &arm, touched.is_some(), &mut known);
                if let Some(sight) = sight {
                    let cell = cell as u32;
                    found(self, SeenCell { image, arm, touched, sight, cell, feet: [0; 2] });
                }
            }
        }
        debug_assert_eq!(touched_cells, self.solid.len());
    }

    /// Adds a cell, so far as it is `owned`, with its feet among those given.
    fn add_cell(
        &mut self,
        around: &Surroundings<D>,
        reach: &CellRanges,
        seen: &SeenCell,
        owned: f64,
        feet: &[Foot],
    ) {
        if owned <= 0.0 {
            return;
        }
        // A cell beside a covered face counts from where it does not touch the body yet: as the
        // surface passes a line of the grid, nothing jumps.
        if seen.touched.is_some() || seen.sight.s < reach.beside {
            self.add_own_cell(seen.touched.unwrap_or(seen.arm), owned, seen.cell);
        }
        if reach.sets(&seen.sight) {
            self.add_ghost_cell(around, seen, owned, &feet[seen.feet()]);
        }
    }

    /// Distances from a body up to which cells concern it, those in gaps up to `tight` (m).
    fn reach(&self, around: &Surroundings<D>, k: usize, moved: &Moved, tight: f64) -> CellRanges {
        let body = &around.bodies[k];
        CellRanges {
            tight,
            // No body has left a cell that is further off than a point of it went.
            travelled: moved.farthest + 1e-9 * body.radius(),
            beside: if self.surface.flat { beside_face(around.grid) } else { 0.0 },
            outside: if self.surface.flat && around.profiles.cubic {
                2.0 * CLOSE * around.profiles.h
            } else {
                0.0
            },
        }
    }

    fn add_own_cell(&mut self, arm: Vector3<f64>, owned: f64, cell: u32) {
        let OwnCells { cells, shared } = &mut self.own;
        if owned < 1.0 {
            shared.push(SharedCell::next(cells, cell, owned, 1.0, false));
        }
        cells.push(OwnCell { arm, ownership: owned, cut_change: [0.0; D], cell });
    }

    /// Adds a ghost cell, and the profiles that it needs, from these feet; the deep ones have none.
    fn add_ghost_cell(
        &mut self,
        around: &Surroundings<D>,
        seen: &SeenCell,
        owned: f64,
        feet: &[Foot],
    ) {
        let SeenCell { image, arm, cell, .. } = seen;
        let shared = owned < 1.0;
        let Sight { s, cleared, .. } = seen.sight;
        let mut weight = 1.0;
        if let (true, [foot]) = (s > 0.0 && !cleared, feet) {
            let normal = foot.normal(around.round, arm);
            weight = 0.0;
            let across = self.stencils.profile_across(around, image, &normal, s);
            if let Some((across, flow)) = across {
                let place = self.ghosts.cells.len() as u32;
                let shared = shared.then_some(self.ghosts.shared.len() as u32);
                self.ghosts.in_gaps.push(GapCell { place, shared, flow });
                self.add_profile(arm, across, 1.0);
            } else if self.surface.flat
                && around.profiles.cubic
                && s < 2.0 * CLOSE * around.profiles.h
            {
                weight = 1.0 - smooth_step(s / around.profiles.h, CLOSE, 2.0 * CLOSE);
                self.add_profile_at(around, image, arm, &normal, foot, 1.0);
            } else if !shared {
                return;
            }
        } else if let [foot] = feet {
            self.add_profile_at(around, image, arm, &foot.normal(around.round, arm), foot, 1.0);
        } else {
            let all: f64 = (0..feet.len()).map(|i| around.share_of(s, i, feet)).sum();
            for (i, foot) in feet.iter().enumerate() {
                let share = around.share_of(s, i, feet) / all;
                self.add_profile_at(
                    around,
                    image,
                    arm,
                    &foot.normal(around.round, arm),
                    foot,
                    share,
                );
            }
        }
        if shared {
            let next = SharedCell::next(&self.ghosts.cells, *cell, owned, weight, cleared);
            self.ghosts.shared.push(next);
        }
        self.ghosts.cells.push(GhostCell {
            arm: *arm,
            weight,
            target: Vector3::zeros(),
            offset: Vector3::zeros(),
            cell: *cell,
            cleared,
            first: true,
        });
    }

    /// Adds the profile from a foot along its normal to the ghost cell that comes next.
    fn add_profile_at(
        &mut self,
        around: &Surroundings<D>,
        image: &Image,
        arm: &Vector3<f64>,
        normal: &Normal,
        foot: &Foot,
        share: f64,
    ) {
        let s = foot.near.distance;
        let stencil = self.stencils.profile(around, image, normal, s);
        if around.profiles.cubic {
            let place = self.ghosts.cells.len() as u32;
            let own = Reading { arm: *arm, stencil, place, share };
            let profile = self.ghosts.profiles.len();
            let cubic = self.stencils.cubic(around, image, normal, s, profile, &own);
            self.ghosts.cubic.extend(cubic);
        }
        self.add_profile(arm, stencil, share);
    }

    fn add_profile(&mut self, arm: &Vector3<f64>, stencil: Stencil, share: f64) {
        if stencil.is_still() {
            return;
        }
        let place = self.ghosts.cells.len() as u32;
        self.ghosts.profiles.push(Reading { arm: *arm, stencil, place, share });
    }
}
