//! The numbers of the method: those that were chosen or fitted once, for all cases.
//!
//! Each says what it is, its unit, what less and more of it does, and the range in which the method
//! has a meaning. `docs/method.md` has what was measured of each. Numbers that follow from the
//! scheme, or bound rounding or iterations, stand beside their use.

/// Aperture (open fraction of a face) that remains where bodies share a face, or beside a wall of
/// the box. Smaller, pockets between bodies hold a pressure that pushes them; larger, more flows
/// through a closed gap. Valid from 0.001 to 0.9.
pub const SHARED_APERTURE: f64 = 0.1;

/// Reynolds number of a spacing and the velocity at the first image point up to which the layer at
/// a wall is resolved. Smaller, the extrapolated profile is cut off in flows that need it; larger,
/// it overshoots where the layer is too thin for the grid. Valid from 0.0 to 1e6.
pub const RESOLVED_LAYER: f64 = 40.0;

/// Largest velocity of the extrapolated profile, of the velocity at the first image point, where
/// the layer is just resolved. Valid from 1.0 to 100.0.
pub const LARGEST_PROFILE: f64 = 5.0;

/// Distance of the first image point from the wall (spacings); the second and the third are twice
/// and three times as far. Nearer, it reads ghost cells; farther, the profile misses the layer.
/// Valid from 0.5 to 2.0.
pub const IMAGE_POINT: f64 = 1.0;

/// Width (spacings) over which one form of the profile passes into another as a gap closes, the
/// cubic ends with depth, and the ownership weight of a cell passes between two bodies. Smaller,
/// forces jump as bodies pass over cells; larger, cells are set by the body that is not the
/// nearest. Valid from 0.01 to 1.5.
pub const BLENDING_WIDTH: f64 = 0.5;

/// Way (spacings) that a body goes until the grid is cut anew where it lies. Smaller, bodies at
/// rest cost as much as those that move; larger, forces on slow ones change in steps. Valid from
/// 0.0 to 0.1.
pub const CUT_ANEW: f64 = 1e-3;

/// Reynolds number of a spacing and the fastest velocity at its image points up to which cells
/// beside fixed bodies take all of the cubic extrapolation; none from three times as much on. Valid
/// from 0.0 to 1e6.
pub const CREEPING_LAYER: f64 = 0.5;

/// Distance between the image points of the slope at the wall (spacings). Smaller, noise as the
/// body moves; larger, less of a thin layer. Valid from 0.1 to 1.0.
pub const SLOPE_IMAGE_POINT: f64 = 0.7;

/// Courant number of a step over which the momentum-interpolation correction of the faces decays;
/// beside fixed bodies also how far (spacings that the flow crosses) faces go by the last pressure
/// at once. Smaller, the pressure beside a wall jitters at small steps; larger, a wall reaches the
/// faces late. Valid from 0.001 to 100.0.
pub const CORRECTION_COURANT: f64 = 0.2;

/// Decay rate of that correction by viscosity (nu/h^2) on faces that no body cuts, where bodies
/// move. Valid from 0.0 to 100.0.
pub const CORRECTION_DECAY_OPEN: f64 = 0.4;

/// Decay rate of that correction on faces that a body cuts, in 2D (nu/h^2). Smaller, a creeping
/// flow keeps in its faces what its cells have lost, and is driven by it; larger, a wall reaches
/// the faces late. Valid from 0.0 to 100.0.
pub const CORRECTION_DECAY_CUT_2D: f64 = 0.105;

/// Decay rate of that correction on cut faces in 3D (nu/h^2). Valid from 0.0 to 100.0.
pub const CORRECTION_DECAY_CUT_3D: f64 = 0.25;

/// Decay rate of that correction where no body moves, all faces (nu/h^2). Valid from 0.0 to 100.0.
pub const CORRECTION_DECAY_FIXED: f64 = 4.0;

/// Largest weight of the pressure gradient at a face itself, in place of the mean of the cells', in
/// the prediction of face velocities where there are no bodies. Valid from 0.001 to 1.0.
pub const PRESSURE_WEIGHT: f64 = 0.2;

/// Time (h^2/nu) for which faces go by the last pressure at once; for the rest of a step they take
/// the mean of the cells' acceleration. Longer, a steady flow leaks through the faces and has less
/// drag the longer the step; shorter, a pressure that alternates from cell to cell takes `0.05 nu
/// dt/h^2` steps and more to decay. Valid from 0.0 to 1e6.
pub const PRESSURE_TIME: f64 = 0.05;

/// Spacings that the flow crosses while the filtered force defect of a body follows the force
/// defect. Fewer, its noise moves bodies; more, light bodies lag. Valid from 0.1 to 1000.0.
pub const DEFECT_TIME: f64 = 3.0;

/// Rate at which viscosity makes that filtered defect follow (nu/h^2). Smaller, the force on a
/// falling body still pushes it when it lies. Valid from 0.0 to 100.0.
pub const DEFECT_DECAY: f64 = 0.1;

/// Part of the stability limits, other than the Courant number's, that steps chosen by `time.cfl`
/// use. Larger, nearer to the limit; smaller, more steps. Valid from 0.01 to 1.0.
pub const LIMIT_SHARE: f64 = 0.8;

/// Largest ratio of a step chosen by `time.cfl` to the one before. Valid from 1.001 to 100.0.
pub const STEP_GROWTH: f64 = 1.1;

/// Part of its added mass that a body without mass has in a contact. Valid from 0.0 to 10.0.
pub const ADDED_MASS_SHARE: f64 = 0.4;

/// Increase of that part for each density of the fluid that the body has. Valid from 0.0 to 10.0.
pub const ADDED_MASS_SLOPE: f64 = 0.25;

/// Largest part of its added mass that a body has in a contact. Valid from 0.0 to 100.0.
pub const LARGEST_ADDED_MASS_SHARE: f64 = 1.6;

/// Weight of a step in the mean contact force on a body, in the mixture method. Larger, an impact
/// of some steps counts as sustained before it ends; smaller, a bed that lands counts as an impact
/// for longer. Valid from 0.0001 to 1.0.
pub const MEAN_FORCE_WEIGHT: f64 = 0.02;

/// Largest sustained contact force, over that mean: the fluid's response to it is expected in the
/// next step too. Smaller, a bed at rest is never sure of its weight; without bound, impacts lose
/// energy. Valid from 1.0 to 1e6.
pub const SUSTAINED_FORCE: f64 = 2.0;

/// Substeps in a contact where the case leaves them to the program; a tenth of them while a gap
/// that only fluid fills changes by its width. Fewer, restitution is off; more, they cost. Valid
/// from 5.0 to 10000.0.
pub const CONTACT_SUBSTEPS: f64 = 40.0;

/// Deepest overlap that the stiffness "auto" is chosen for (of the smallest diameter). Smaller,
/// stiffer contacts and more substeps; larger, softer ones that overlap. The lubrication layer of
/// two that touch has this width too, of the diameter of their reduced radius. Valid from 1e-6 to
/// 0.1.
pub const AUTO_OVERLAP: f64 = 0.01;

/// Gap at which the grid gives half of the lubrication force on a disc (spacings), fitted to discs
/// that approach each other and a wall in Stokes flow. Valid from 0.01 to 10.0.
pub const HALF_GAP_2D: f64 = 1.5;

/// Half-force gap of spheres (spacings), fitted to one let go at a wall. Valid from 0.01 to 10.0.
pub const HALF_GAP_3D: f64 = 0.6;

/// Width that the grid adds to a closed gap between discs that slide along it (spacings), fitted to
/// a disc pulled along a wall in Stokes flow; twice that where they roll. Valid from 0.001 to 10.0.
pub const SHEAR_GAP_2D: f64 = 0.28;

/// Width that the grid adds to such a gap between spheres (spacings). Valid from 0.001 to 10.0.
pub const SHEAR_GAP_3D: f64 = 0.22;

/// Gap from which on the grid has all of the lubrication force (spacings). Valid from 0.1 to 100.0.
pub const LUBRICATION_RANGE: f64 = 6.0;

/// Distance to Coulomb's limit, of it, within which a contact passes from sticking to sliding in
/// the correction of contact impulses. Valid from 1e-6 to 1.0.
pub const SLIDING_ONSET: f64 = 0.1;

/// Damping ratio of rolling resistance: a body that rocks in place comes to rest after some swings.
/// Valid from 0.0 to 10.0.
pub const ROLLING_DAMPING: f64 = 0.3;
