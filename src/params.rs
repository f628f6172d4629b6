//! The constants of the method: what each is, its unit and what it trades.
//!
//! They are no keys of a case: nobody who computes a flow should have to think about them. To try
//! another value, build with the feature `tune`, which reads `MICS_TUNE="name=value,..."` when the
//! program starts; without it they are compiled in. What was measured of each, and what half and
//! twice its value change, is on the page docs/constants.md, with the command.

macro_rules! constants {
    ($($(#[doc = $doc:literal])* $name:ident = $value:expr;)*) => {
        $(
            $(#[doc = $doc])*
            #[inline(always)]
            pub fn $name() -> f64 {
                #[cfg(not(feature = "tune"))]
                return $value;
                #[cfg(feature = "tune")]
                {
                    static TUNED: std::sync::OnceLock<f64> = std::sync::OnceLock::new();
                    *TUNED.get_or_init(|| tune::value(stringify!($name), $value))
                }
            }
        )*

        /// All of them, with their values.
        pub const ALL: &[(&str, f64)] = &[$((stringify!($name), $value)),*];
    };
}

constants! {
    /// Openings of faces below this count as this (of a face).
    least_opening = 1e-6;
    /// What stays open of a face that bodies share, or beside a wall of the box (of a face).
    /// Smaller, pockets between bodies hold a pressure that pushes them; larger, more flows through
    /// a closed gap.
    shared_opening = 0.1;
    /// Reynolds number of a spacing and the velocity at the first image point up to which the layer
    /// at a wall is resolved. Smaller, the continued profile is cut off in flows that need it;
    /// larger, it overshoots where the layer is too thin for the grid.
    resolved_layer = 40.0;
    /// What the continued profile may be, of the velocity at the first image point, where the layer
    /// is just resolved.
    most_profile = 5.0;
    /// Depth to which the profile is continued into a body (spacings): as deep as the advection of
    /// cells beside the wall reads.
    profile_depth = 2.5;
    /// The first image point of the profile (spacings from the wall). Nearer, it reads cells that
    /// were imposed; farther, the profile misses the layer.
    first_image_point = 1.0;
    /// The second image point (spacings); likewise.
    second_image_point = 2.0;
    /// What the mean of a cell has beyond its middle, of `h^2 w''` along the normal of a wall.
    cell_mean = 1.0 / 24.0;
    /// The third image point of the finer profile (spacings), which cells near the wall take where
    /// no body moves.
    third_image_point = 3.0;
    /// Depth from which on cells have less of it (spacings), until there is none half a spacing
    /// deeper: so far it needs no more ghosts than the parabola, and only advection reads deeper
    /// cells.
    finer_depth = 1.0;
    /// Gap below which none has it (spacings), over half a spacing: the third image point keeps off
    /// what lies across.
    finer_gap = 3.25;
    /// Reynolds number of a spacing and the fastest velocity at its image points up to which all of
    /// it is taken; from three times as much on there is none: it is of creeping flow.
    creeping_layer = 0.5;
    /// Distances of two bodies from a cell that differ by less (spacings) share it. Smaller, forces
    /// jump as bodies in contact pass over cells; larger, cells are set by the body that is not the
    /// nearest.
    shared_cells = 0.5;
    /// Between the image points of the wall's slope (spacings). Nearer, noise as the body moves;
    /// farther, less of a thin layer.
    slope_image_point = 0.7;
    /// Gap below which the grid resolves no profile in it (spacings). Larger, the straight profile
    /// replaces a resolved one.
    unresolved_gap = 1.25;
    /// Rate at which friction slows the flow through a gap that the grid does not resolve (nu over
    /// the width squared): that of a parabola between two walls.
    gap_friction = 12.0;
    /// Gap beyond which nothing is felt of what lies there (spacings). Larger, more image points
    /// know of neighbours, and cost.
    near_gap = 2.75;
    /// Courant number over which a step leaves the memory of the faces behind. Smaller, the
    /// pressure beside a wall jitters at small steps; larger, an imposed wall reaches the faces
    /// late.
    face_memory = 0.2;
    /// Rate at which viscosity takes the memory of the faces (nu/h^2), which is of the size of the
    /// grid, where bodies move: that of faces that none cuts.
    face_decay_open = 0.4;
    /// The same on faces that a body cuts, in 2D. Smaller, a creeping flow keeps in its faces what
    /// it no longer has in its cells, and is driven by it; larger, an imposed wall reaches the
    /// faces late.
    face_decay_cut_2d = 0.105;
    /// The same in 3D.
    face_decay_cut_3d = 0.25;
    /// The same on all faces where no body moves, and nothing has to follow it.
    face_decay_fixed = 4.0;
    /// The most that faces have at once of the last pressure's acceleration where there are no
    /// bodies.
    face_own = 0.2;
    /// How long (h^2/nu) faces go by the last pressure at once; what a step has beyond that they
    /// take from the cells, as they stay where they are. Longer, a steady flow leaks through the
    /// faces by `dt (a - mean of the cells' a)`, and has less drag the longer the step; shorter, a
    /// pressure that alternates from cell to cell takes `0.05 nu dt/h^2` steps and more to fade.
    face_time = 0.05;
    /// The least part of a step that they go by it.
    face_part = 0.01;
    /// Spacings that the flow crosses while a body takes in its force residual. Fewer, its noise
    /// moves bodies; more, light bodies lag.
    residual_time = 3.0;
    /// Rate at which viscosity takes it in (nu/h^2). Less, what a body felt when it fell still
    /// pushes it when it lies: a disc on a floor rolled on for hours at 0.
    residual_decay = 0.1;
    /// Part of D0 below which a step leaves the pressure as it is. Larger, the force on a body
    /// jitters in quiet flows; smaller, solves that change nothing.
    idle_divergence = 1e-3;
    /// Part of the stability limits, other than the Courant number's, that steps chosen by
    /// `time.cfl` use. Larger, nearer to the limit; smaller, more steps.
    limit_share = 0.8;
    /// How much longer a step chosen by `time.cfl` may be than the one before.
    step_growth = 1.1;
    /// Part of the digits asked for to which the pressure is found that shows the response to
    /// contact impulses.
    response_digits = 0.5;
    /// Part of its speed that lubrication has to be able to take from a pair in a step for contacts
    /// to be corrected.
    faint_lubrication = 0.01;
    /// The sweeps of a correction end where one changes less than this part of what the first one
    /// did.
    sweep_tolerance = 1e-2;
    /// Most sweeps of a correction.
    most_sweeps = 200.0;
    /// Part of its added mass that a body in contact has, where it weighs nothing.
    added_mass_of_light = 0.4;
    /// How much larger that part is for each density of the fluid.
    added_mass_by_density = 0.25;
    /// The largest part.
    most_added_mass = 1.6;
    /// Most times that the first step is taken with the paper's mixing until what contacts give
    /// bodies that lie on others is found.
    most_initial_contact_iterations = 40.0;
    /// Part of that which may be missing then.
    initial_contact_tolerance = 1e-9;
    /// What a step counts in the mean force of contacts on a body. Larger, an impact of some steps
    /// counts as lasting before it ends; smaller, a bed that lands is taken for an impact for
    /// longer.
    pressed_share = 0.02;
    /// Force of contacts that counts as lasting (of that mean): what the fluid answers to it is
    /// expected of the next step too. Less, a bed at rest is never sure of its weight; without
    /// bound, impacts lose energy.
    lasting_force = 2.0;
    /// Substeps in a contact, where the case leaves them to the program. Fewer, restitution is off;
    /// more, they cost.
    contact_substeps = 40.0;
    /// Substeps while a gap that only fluid fills changes by its width, up to as many as a contact
    /// has, and at least half of these. Fewer, the approach of two bodies is coarse in time.
    gap_substeps = 4.0;
    /// Overlap, of the smaller radius, that ends a run.
    deepest_overlap = 0.2;
    /// Deepest overlap that the stiffness "auto" is chosen for (of the smallest diameter). Smaller,
    /// stiffer contacts and more substeps; larger, softer ones that overlap.
    auto_overlap = 0.01;
    /// The same in spacings: the less of the two holds.
    auto_overlap_spacing = 0.1;
    /// Width of the fluid lubrication layer in a contact (of the reduced radius). Smaller, stiffer
    /// lubrication at touch.
    lubrication = 0.02;
    /// Gap at which the grid gives half of the lubrication force on a disc (spacings), fitted to
    /// discs that approach each other and a wall in Stokes flow (tests
    /// `the_force_between_two_discs` and `the_force_of_a_narrow_gap`).
    half_gap_of_discs = 1.5;
    /// The same for spheres, fitted to a sphere let go beside a wall at gaps of 0.05 to 0.5 radii,
    /// 8 and 16 cells across (`cases/approach/gaps.study.toml`).
    half_gap_of_spheres = 0.6;
    /// How much wider than it is the grid shows a closed gap between discs that slide along it
    /// (spacings), fitted to a disc pulled along a wall in Stokes flow, free to turn, at gaps of
    /// 0.001 to 0.2 radii, 8 and 16 cells across; twice that where they roll.
    shear_gap_of_discs = 0.28;
    /// The same for spheres (`cases/approach/along.study.toml`).
    shear_gap_of_spheres = 0.22;
    /// Gap from which on the grid has all of the lubrication force (spacings).
    lubrication_range = 6.0;
}

#[cfg(feature = "tune")]
mod tune {
    /// The value that `MICS_TUNE` gives to a constant, or its own. A name that is no constant's, or
    /// a value that is no number, ends the program: an experiment that measures nothing would pass
    /// for one.
    pub fn value(name: &str, own: f64) -> f64 {
        let Ok(text) = std::env::var("MICS_TUNE") else { return own };
        let mut found = own;
        for pair in text.split(',').filter(|pair| !pair.is_empty()) {
            let (key, value) = pair.split_once('=').unwrap_or((pair, ""));
            let known = super::ALL.iter().any(|(known, _)| *known == key);
            let Some(value) = value.parse::<f64>().ok().filter(|_| known) else {
                eprintln!("MICS_TUNE: \"{pair}\" is no constant of src/params.rs with a number");
                std::process::exit(2);
            };
            if key == name {
                found = value;
            }
        }
        found
    }
}
