//! All bodies on the grid: what they cover of the faces, and the velocity inside them.

use super::apertures::CoveredTogether;
use super::cut_body::{BEYOND, CutBody, GhostCell, GhostCells, KnownSurfaces};
use super::gap::{self, Profiles, Surroundings, smooth_step};
use super::ghost_width;
use super::local::LocalBodies;
use super::near::{NearBodies, are_one, walls_within};
use super::neighbour::{self, Neighbour};
use super::places::CutPlaces;
use super::shared::SharedCells;
use super::stencil::{Cubic, Flow};
use crate::domain::Domain;
use crate::grid::{Grid, VectorField};
use crate::kernels::faces::FaceCoefficient;
use crate::method::vector;
use crate::numerics::{CREEPING_LAYER, LARGEST_PROFILE, RESOLVED_LAYER};
use crate::particles::{Body, Impulse, Velocities, all_fixed};
use crate::reach::BodyRanks;
use crate::state::{BeforeForcing, BodyHistory};
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

/// The bodies as they cut the grid.
pub struct CutBodies<const D: usize> {
    /// The cut bodies that reach this rank.
    pub bodies: LocalBodies<D>,
    /// Which bodies reach which ranks.
    pub reach: BodyRanks,
    /// Open part of faces over the fluid's density (m3/kg).
    pub beta: FaceCoefficient<D>,
    /// Which are near each other.
    pub near: NearBodies,
    /// Per body, the obstacles that are one solid with it, itself among them, and the ways from its
    /// centre to theirs (m); none of what is alone.
    pub(super) joined: Vec<Vec<(usize, Vector3<f64>)>>,
    /// Where they are cut.
    pub places: CutPlaces,
    /// The friction in gaps in this step ([`gap::GapFlow::kept`]).
    pub(super) friction: f64,
    /// Cells to which several bodies are equally near, and that they set.
    shared: SharedCells,
    rebuilding: Rebuilding<D>,
    covered: CoveredTogether,
    /// Correction before a step (m/s) of the faces that bodies cut, and once more of those in
    /// narrow gaps.
    pub(super) corrections_before: Vec<f64>,
    /// The spacing that depths and image points count in (m).
    pub h: f64,
}

/// Scratch of a body that is rebuilt.
pub(super) struct Rebuilding<const D: usize> {
    /// The bodies near it.
    beside: Vec<Neighbour>,
    /// The planes of the lattice about it (m).
    pub planes: [Vec<f64>; 3],
    /// By axis, the arms to the faces that it covers (m).
    pub arms: [Vec<Vector3<f64>>; D],
}

impl<const D: usize> CutBodies<D> {
    /// The bodies in the fluid of a domain. [`CutBodies::settle`] cuts them.
    pub fn new(domain: &Domain<D>, bodies: &[Body]) -> CutBodies<D> {
        let grid = &domain.grid;
        let periods = domain.periods();
        let h = ghost_width(&domain.grid.h).0;
        let size = std::array::from_fn(|a| if a < D { grid.size[a] } else { 1.0 });
        let rank = domain.session.rank();
        let ranks = domain.session.size();
        let open = vec![1.0 / domain.fluid.density; grid.field().len()];
        CutBodies {
            bodies: LocalBodies::none(grid, bodies.len()),
            reach: BodyRanks::new(rank, ranks, bodies.len()),
            beta: FaceCoefficient::Field(std::array::from_fn(|_| open.clone())),
            near: NearBodies::new(
                bodies,
                size,
                periods,
                gap::reach(all_fixed(bodies)) * h,
                // Most bodies have few; on several ranks that is what matters.
                if ranks > 1 { 0 } else { 16 },
            ),
            joined: joined(bodies),
            places: CutPlaces::new(bodies, h),
            friction: 0.0,
            shared: SharedCells::default(),
            rebuilding: Rebuilding {
                beside: Vec::with_capacity(16),
                planes: std::array::from_fn(|_| Vec::new()),
                arms: std::array::from_fn(|_| Vec::new()),
            },
            covered: CoveredTogether::new(grid),
            corrections_before: Vec::new(),
            h,
        }
    }

    /// Most ghost cells that bodies can have.
    pub fn most_ghost_cells(&self) -> usize {
        self.bodies.iter().map(|body| body.ghosts.cells.capacity()).sum()
    }

    /// Cuts the bodies as if they had lain there always: where they were cut by these histories,
    /// and where they lie if they have none. What stays of the bodies `before` is not cut anew.
    pub fn settle(
        &mut self,
        domain: &Domain<D>,
        bodies: &[Body],
        histories: &[BodyHistory],
        before: Option<CutBodies<D>>,
    ) {
        self.places.settle(bodies, histories);
        // Where no body moves, profiles are others.
        let fixed = |cut: &CutBodies<D>| all_fixed(&cut.places.bodies);
        let before = before.filter(|before| fixed(before) == fixed(self));
        let again = before.map_or_else(Vec::new, |before| self.take_over(before));
        self.rebuild(domain, &again);
        self.make_room();
        self.rub(domain, f64::INFINITY);
        self.places.recall(histories);
    }

    /// Takes over how bodies are cut that were among those `before`, in the same place and beside
    /// the same ones. Returns the numbers of those among them that are cut anew all the same: they
    /// have just left cells that others may be near to.
    fn take_over(&mut self, before: CutBodies<D>) -> Vec<usize> {
        let found = self.places.find(&before.places);
        let stays = |(old, near): (usize, &Vec<usize>)| {
            found[old].filter(|_| near.iter().all(|j| found[*j].is_some()))
        };
        let kept: Vec<Option<usize>> = before.near.near.iter().enumerate().map(stays).collect();
        self.bodies.take_over(before.bodies, &kept);
        let kept = kept.into_iter().flatten();
        kept.clone().for_each(|k| self.places.stirred[k] = false);
        kept.filter(|k| self.bodies[*k].has_left_shared_cells()).collect()
    }

    /// Cuts the bodies anew that have moved since they were cut last, for a step of `dt` (s).
    /// Returns whether there are any.
    pub fn rebuild_moved(&mut self, domain: &Domain<D>, bodies: &[Body], dt: f64) -> bool {
        let any = self.places.follow(bodies, &domain.periods());
        if any {
            self.rebuild(domain, &[]);
        }
        self.rub(domain, dt);
        any
    }

    /// Cuts the bodies anew that are stirred, and those that such were or are near to, whose image
    /// points that changes; and, where they are, those of the numbers `again`.
    fn rebuild(&mut self, domain: &Domain<D>, again: &[usize]) {
        self.uncover_faces(domain);
        self.near.find(&self.places.bodies, &self.places.stirred);
        again.iter().for_each(|k| self.near.restless[*k] = true);
        self.places.stay(&self.near.restless);
        self.find_reach(domain);
        let grid = &domain.grid;
        let boundaries = &domain.boundaries;
        let CutPlaces { bodies, moved, stirred, .. } = &self.places;
        let viscous = domain.fluid.viscosity > 0.0;
        let profiles = Profiles::new(self.h, viscous, all_fixed(bodies));
        let reach = profiles.reach;
        let periods = domain.periods();
        let Rebuilding { beside, planes, arms } = &mut self.rebuilding;
        for (k, cut) in self.bodies.each_mut() {
            let near = &self.near.near[k];
            if !stirred[k] && !self.near.restless[k] && !cut.is_empty() {
                continue;
            }
            beside.clear();
            // Obstacles that are one solid are one neighbour.
            let is_first = |(place, j): &(usize, &usize)| {
                near[..*place].iter().all(|i| !are_one(&bodies[*i], &bodies[**j]))
            };
            let near = near.iter().enumerate().filter(is_first);
            beside.extend(near.flat_map(|(_, &j)| Neighbour::all(bodies, k, j, &periods, reach)));
            beside.extend(Neighbour::images(bodies, k, &periods, reach));
            beside.extend(Neighbour::reflections(bodies, k, grid, boundaries, reach));
            let orientation = bodies[k].orientation();
            let reached = bodies[k].reach().add_scalar(1.001 * reach);
            let around = Surroundings {
                grid,
                boundaries,
                bodies,
                body: k,
                orientation,
                round: neighbour::round(&bodies[k]),
                near: beside,
                walls: walls_within(grid, &bodies[k].centre, &reached),
                profiles: &profiles,
            };
            cut.rebuild(&around, k, &moved[k], planes, arms);
        }
        self.covered.set_apertures(domain, &mut self.bodies, &mut self.beta);
    }

    /// Gives the ghost cells in narrow gaps, and those that bodies share, their weights for a step
    /// of `dt` (s).
    fn rub(&mut self, domain: &Domain<D>, dt: f64) {
        // A fluid without viscosity has none, however long the time.
        let rate =
            gap::POISEUILLE * domain.fluid.viscosity / (domain.fluid.density * self.h * self.h);
        self.friction = if rate > 0.0 { 0.5 * dt * rate } else { 0.0 };
        self.bodies.iter_mut().for_each(|cut| cut.ghosts.rub(self.friction));
        self.shared.share(self.bodies.as_mut_slice());
    }

    /// Finds which bodies reach which ranks, as far as a rank can have anything of one: by where
    /// they lie and lay, whatever is near them.
    fn find_reach(&mut self, domain: &Domain<D>) {
        let CutBodies { reach, places: CutPlaces { bodies, moved, .. }, h, .. } = self;
        let tight = gap::UNRESOLVED * *h;
        reach.find(&domain.grid, bodies, |k| {
            let body = &bodies[k];
            let shape = body.shape();
            let bounds = body.reach().sup(&shape.turned(&moved[k].orientation).bounds());
            bounds.add_scalar(moved[k].displacement.norm().max(tight) + BEYOND * *h)
        });
        let grid = &domain.grid;
        let mut surfaces = KnownSurfaces::default();
        self.bodies.keep(grid, self.reach.here(), |k| match self.reach.is_alone() {
            true => CutBody::new(grid, &bodies[k], &mut surfaces, *h),
            false => CutBody::elsewhere(grid),
        });
    }

    /// Makes room for what steps keep of all bodies.
    fn make_room(&mut self) {
        let room = |cut: &CutBody<D>| cut.faces.cuts[0].capacity();
        let faces: usize = self.bodies.iter().map(room).sum();
        let shared = self.bodies.iter().map(|cut| cut.ghosts.shared.capacity()).sum();
        self.shared.reserve(shared);
        self.covered.reserve(faces / 4);
        self.corrections_before.reserve(2 * D * faces);
    }

    /// Sets the apertures of all faces to one that the bodies cover.
    fn uncover_faces(&mut self, domain: &Domain<D>) {
        let whole = 1.0 / domain.fluid.density;
        let beta = self.beta.field(&domain.grid);
        for (axis, beta) in beta.iter_mut().enumerate() {
            let cuts = self.bodies.iter().flat_map(|body| &body.faces.cuts[axis]);
            cuts.for_each(|cut| beta[cut.face as usize] = whole);
        }
    }

    /// Whether a body is so near to a side of the box that its image points are deep in the ghosts
    /// there.
    pub fn near_boundaries(&self, grid: &Grid<D>, bodies: &[Body]) -> bool {
        let near = |b: &Body, a: usize| {
            let extent = b.radius() + grid.ghosts as f64 * grid.h[a];
            b.centre[a] < extent || b.centre[a] > grid.size[a] - extent
        };
        bodies.iter().any(|b| (0..D).any(|a| near(b, a)))
    }

    /// Sets the velocity of the ghost cells; ghosts of `u` filled. With `cleared`, also that of
    /// cells which the bodies have just left. The momentum that this adds goes to the `exchanged`
    /// of each body.
    pub fn set_ghost_cells(
        &mut self,
        domain: &Domain<D>,
        velocities: impl Velocities,
        cleared: bool,
        exchanged: Option<&mut Vec<Impulse>>,
        u: &mut VectorField<D>,
    ) {
        self.find_targets(domain, velocities, cleared, u);
        self.apply_targets(domain, cleared, exchanged.map(|exchanged| (1.0, exchanged)), u);
    }

    /// Finds what [`CutBodies::set_ghost_cells`] sets; nothing of those that it leaves.
    pub fn find_targets(
        &mut self,
        domain: &Domain<D>,
        velocities: impl Velocities,
        cleared: bool,
        u: &VectorField<D>,
    ) {
        let fluid = &domain.fluid;
        let resolved = RESOLVED_LAYER * fluid.viscosity / (fluid.density * self.h);
        let limit = Some((resolved, LARGEST_PROFILE));
        let cuts = &mut self.bodies;
        Arch::new().dispatch(FindTargets { cuts, velocities, domain, u, limit, cleared });
        self.shared.share_targets(self.bodies.as_mut_slice(), cleared);
    }

    /// Finds by the velocity `u` (m/s), ghosts filled, what the cubic extrapolation adds from now
    /// on, where no body moves.
    pub fn find_cubic(
        &mut self,
        domain: &Domain<D>,
        velocities: impl Velocities,
        u: &VectorField<D>,
    ) {
        let Domain { grid, boundaries, fluid, .. } = domain;
        let creeping = CREEPING_LAYER * fluid.viscosity / (fluid.density * self.h);
        for (k, cut) in self.bodies.each_mut() {
            let CutBody { ghosts: GhostCells { profiles, cubic, .. }, stencils, .. } = cut;
            let flow = Flow { grid, u, boundaries, velocities, k };
            for cubic in cubic.iter_mut().filter(|_| creeping > 0.0) {
                let profile = &profiles[cubic.profile as usize];
                let own = stencils.value(profile, &flow);
                let all = stencils.value(&cubic.cubic, &flow);
                let numbers = stencils.fastest(&cubic.cubic, &flow) / creeping;
                let share = profile.share * (1.0 - smooth_step(numbers, 1.0, 3.0));
                cubic.added = share * (all - cubic.part * own);
            }
        }
    }

    /// Takes the velocity `u` (m/s) of all ghost cells, each once, before they are set.
    pub fn take_before_forcing(
        &self,
        u: &VectorField<D>,
        before_forcing: &mut Vec<BeforeForcing<D>>,
    ) {
        before_forcing.clear();
        let cells = self.bodies.iter().flat_map(|cut| &cut.ghosts.cells).filter(|g| g.first);
        before_forcing.extend(cells.map(|ghost| BeforeForcing {
            cell: ghost.cell,
            velocity: std::array::from_fn(|a| u[a][ghost.cell as usize]),
        }));
    }

    /// Finds what the velocity `u` (m/s) has in all ghost cells beyond their targets.
    pub fn find_offsets(&mut self, u: &VectorField<D>) {
        for ghost in self.bodies.iter_mut().flat_map(|cut| &mut cut.ghosts.cells) {
            ghost.offset = vector(u, ghost.cell as usize) - ghost.target;
        }
    }

    /// Adds a part of these to the targets.
    pub fn add_offsets(&mut self, part: f64) {
        for ghost in self.bodies.iter_mut().flat_map(|cut| &mut cut.ghosts.cells) {
            ghost.target += part * ghost.offset;
        }
    }

    /// Sets the ghost cells to their targets; a share of the momentum that this adds goes to the
    /// exchanged momentum of each body.
    pub fn apply_targets(
        &self,
        domain: &Domain<D>,
        cleared: bool,
        mut exchanged: Option<(f64, &mut Vec<Impulse>)>,
        u: &mut VectorField<D>,
    ) {
        let mass = domain.fluid.density * domain.grid.cell_volume();
        for (k, cut) in self.bodies.each() {
            for ghost in cut.ghosts.cells.iter().filter(|ghost| cleared || !ghost.cleared) {
                let mut added = Vector3::zeros();
                let cell = ghost.cell as usize;
                for (a, field) in u.iter_mut().enumerate() {
                    let change = ghost.weight * (ghost.target[a] - field[cell]);
                    added[a] = mass * change;
                    field[cell] += change;
                }
                if let Some((share, exchanged)) = &mut exchanged {
                    exchanged[k].add(&ghost.arm, &(*share * added));
                }
            }
        }
    }

    /// Sets the ghost cells within the step: `part` of the way from `start`, at its start, to their
    /// targets, those at its end.
    pub fn set_ghost_cells_within(
        &self,
        part: f64,
        start: &VectorField<D>,
        u: &mut VectorField<D>,
    ) {
        for ghost in self.bodies.iter().flat_map(|cut| &cut.ghosts.cells) {
            for (a, (start, u)) in start.iter().zip(u.iter_mut()).enumerate() {
                let cell = ghost.cell as usize;
                let start = start[ghost.cell as usize];
                u[cell] += ghost.weight * (start + part * (ghost.target[a] - start) - u[cell]);
            }
        }
    }
}

/// Per body, the obstacles that are one solid with it.
fn joined(bodies: &[Body]) -> Vec<Vec<(usize, Vector3<f64>)>> {
    let others = |body: &Body| {
        let own = bodies.iter().enumerate().filter(|(_, other)| are_one(body, other));
        own.map(|(j, other)| (j, other.centre - body.centre)).collect()
    };
    let alone = |all: Vec<_>| if all.len() > 1 { all } else { Vec::new() };
    bodies.iter().map(others).map(alone).collect()
}

/// Finds the targets of ghost cells by a velocity, ghosts filled.
struct FindTargets<'a, V: Velocities, const D: usize> {
    cuts: &'a mut LocalBodies<D>,
    velocities: V,
    domain: &'a Domain<D>,
    u: &'a VectorField<D>,
    /// As in [`super::stencil::Stencils::values`].
    limit: Option<(f64, f64)>,
    /// Whether cells that the bodies have just left have targets as well.
    cleared: bool,
}

impl<V: Velocities, const D: usize> WithSimd for FindTargets<'_, V, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let FindTargets { cuts, velocities, domain, u, limit, cleared } = self;
        let Domain { grid, boundaries, .. } = domain;
        for (k, cut) in cuts.each_mut() {
            let CutBody { ghosts: GhostCells { cells, profiles, cubic, .. }, stencils, .. } = cut;
            let sets = |ghost: &GhostCell| cleared || !ghost.cleared;
            let own = velocities(k);
            for ghost in cells.iter_mut() {
                let rigid = own.at(&ghost.arm);
                ghost.target = if sets(ghost) { rigid } else { Vector3::zeros() };
            }
            let flow = Flow { grid, u, boundaries, velocities, k };
            stencils.values(
                simd,
                profiles,
                &flow,
                limit,
                #[inline(always)]
                |profile, value| {
                    let ghost = &mut cells[profile.place as usize];
                    if sets(ghost) {
                        ghost.target += profile.share * value;
                    }
                },
            );
            for Cubic { cubic, added, .. } in cubic {
                cells[cubic.place as usize].target += *added;
            }
        }
    }
}
