//! The constants of the method: what each is, what it trades, and what halving and doubling it
//! does.
//!
//! They are no keys of a case: nobody who computes a flow should have to think about them. To try
//! another value, build with the feature `tune`, which reads `MICS_TUNE="name=value,..."` when the
//! program starts; without it they are compiled in. The figures beside them are of
//!
//! ```text
//!   cargo bench --features tune --bench constants [-- NAME]...
//! ```
//! which runs `mics validate`, a bed of 12 discs that settles and a sphere that rebounds in liquid
//! with half and with twice each value, and prints what changes. What any change moves by chance is
//! left out here: the lift at Re 20, which is zero, the tumbling of the drafting pair, and how fast
//! the last grain of the bed still is. "Nothing" is less than 0.1 %.

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
    /// Openings of faces below this count as this (of a face). What is behind them keeps a
    /// pressure, and the equation constants as its only null space; larger, they leak. Halved:
    /// every measure under 0.6 %. Doubled: under 0.5 %.
    least_opening = 1e-6;
    /// What stays open of a face that bodies share, or beside a wall of the box (of a face).
    /// Smaller, pockets between bodies hold a pressure that pushes them; larger, more flows through
    /// a closed gap. Halved: height of a bed +0.8 %. Doubled: -0.8 %.
    shared_opening = 0.1;
    /// Reynolds number of a spacing and the velocity at the first probe up to which the layer at a
    /// wall is resolved. Smaller, the continued profile is cut off in flows that need it; larger,
    /// it overshoots where the layer is too thin for the grid. Halved: rebound in liquid +1.2 %,
    /// kiss of two discs +0.6 %. Doubled: under 0.1 %.
    resolved_layer = 40.0;
    /// What the continued profile may be, of the velocity at the first probe, where the layer is
    /// just resolved. It trades as `resolved_layer` does. Halved: rebound +8.7 %, else under 6 %.
    /// Doubled: under 2.1 %.
    most_profile = 5.0;
    /// Depth to which the profile is continued into a body (spacings): as deep as the advection of
    /// cells beside the wall reads. Halved: a drafting pair no longer kisses: advection reads cells
    /// that are not set. Doubled: rebound +3.9 %.
    profile_depth = 2.5;
    /// The first probe of the profile (spacings from the wall). Nearer, it reads cells that were
    /// imposed; farther, the profile misses the layer. Halved: rebound +8.1 %. Doubled: it falls on
    /// the second: every body fails.
    first_image_point = 1.0;
    /// The second probe (spacings); likewise. It adds to the layers of ghosts.
    /// Halved: it falls on the first: every body fails. Doubled: rebound +8.9 %.
    second_image_point = 2.0;
    /// What the mean of a cell has beyond its middle, of `h^2 w''` along the normal of a wall. On a
    /// curved wall `h^2/24` of the slope over the radius would come to it, in 3D twice that: with
    /// it the drag of `cases/sphere-array` at a solid fraction of 0.13 and 8 cells a diameter is
    /// 2.9 % too little, without 1.3 %, and all cases but the lift of `channel-cylinder` are better
    /// without.
    cell_mean = 1.0 / 24.0;
    /// The third probe of the finer profile (spacings), which cells near the wall take where no
    /// body moves.
    third_image_point = 3.0;
    /// Depth from which on cells have less of it (spacings), until there is none half a spacing
    /// deeper: so far it needs no more ghosts than the parabola, and only advection reads deeper
    /// cells.
    finer_depth = 1.0;
    /// Gap below which none has it (spacings), over half a spacing: the third probe keeps off what
    /// lies across. A cubic through both walls of narrower gaps, down to 1.75 spacings, had the
    /// drag of spheres that touch within 0.3 % at 16 cells a diameter in place of 0.8 %, but flows
    /// beside slip borders grew.
    finer_gap = 3.25;
    /// Reynolds number of a spacing and the fastest velocity at its probes up to which all of it is
    /// taken; from three times as much on there is none: it is of creeping flow. Without bound the
    /// drag of a cylinder at Re 40 is 0.1 to 0.2 % less on 16 cells a diameter, at Re 100 on 8
    /// cells 1.5 to 4 %, where the layer is too thin for three probes; at 1 the lift of
    /// `channel-cylinder` 2D-1 is a tenth less. Were it less from the outset, drag would grow with
    /// the Reynolds number as inertia has no part in.
    creeping_layer = 0.5;
    /// Distances of two bodies from a cell that differ by less (spacings) share it. Smaller, forces
    /// jump as bodies in contact pass over cells; larger, cells are set by the body that is not the
    /// nearest.
    shared_cells = 0.5;
    /// Between the probes of the wall's slope (spacings). Nearer, noise as the body moves; farther,
    /// less of a thin layer. Halved: height of a bed -4.5 %. Doubled: -5.0 %, a settling disc +2.3
    /// %.
    slope_image_point = 0.7;
    /// Gap below which the grid resolves no profile in it (spacings). Larger, the straight profile
    /// replaces a resolved one. Halved: height of a bed -17 %, rebound +6.3 %. Doubled: rebound -36
    /// %, kiss +10 %.
    unresolved_gap = 1.25;
    /// Rate at which friction slows the flow through a gap that the grid does not resolve (nu over
    /// the width squared): that of a parabola between two walls. Without bound such a gap takes all
    /// momentum of what flows through it in every step, whatever the viscosity.
    gap_friction = 12.0;
    /// Gap beyond which nothing is felt of what lies there (spacings). Larger, more probes know of
    /// neighbours, and cost. Halved: rebound +1.0 %. Doubled: height of a bed +1.1 %.
    near_gap = 2.75;
    /// Courant number over which a step leaves the memory of the faces behind. Smaller, the
    /// pressure beside a wall jitters at small steps; larger, an imposed wall reaches the faces
    /// late. Halved: rebound +0.3 %. Doubled: rebound +8.7 %. Where bodies are fixed, also how far
    /// (spacings that the flow crosses) faces go by the last pressure at once, see `face_time`.
    /// Longer, drag depends on the step: that of a cylinder at Re 100, 8 cells a diameter, is 0.7
    /// and 2.1 % more at Courant numbers of 0.4 and 0.8 than at small ones if faces go by it for
    /// the whole step, 0.1 and 0.2 % so. Around bodies that move they do go by it for the whole
    /// step: the force on a disc that passes through the grid has ten times the noise otherwise,
    /// and at 0.8 the run fails.
    face_memory = 0.2;
    /// Rate at which viscosity takes the memory of the faces (nu/h^2), which is of the size of the
    /// grid, where bodies move: that of faces that none cuts. As little as on cut ones in 2D, what
    /// creeps through the pocket between a body and two walls stays in the faces, grows by 0.05 nu
    /// dt/h^2 in a step and ends the run (test `a_disc_that_creeps_round_in_a_corner`); from 0.2 to
    /// 4 it fades. Of a disc that moves to a wall in Stokes flow it changes the force by less than
    /// 1.5 %, and that of a disc which sinks to one by 2 %, but from 4 on the impulse on one that
    /// swings loses its second order in time.
    face_decay_open = 0.4;
    /// The same on faces that a body cuts, in 2D. Smaller, a creeping flow keeps in its faces what
    /// it no longer has in its cells, and is driven by it; larger, an imposed wall reaches the
    /// faces late. At 0 a creeping disc slows, stands still and rises, and the flow makes energy;
    /// at 0.3 on all faces the force on a disc that moves to a wall in Stokes flow is 8.7 % too
    /// much on 16 cells a diameter, at 0.105 1.0 %, but one that sinks, two of eight cells over the
    /// floor, is 29 % too fast at 0.105 and 21 % at 0.3 (7 and 4 % on twice as many cells). It goes
    /// by the least spacing, or a flow grows fast where cells are longer one way.
    face_decay_cut_2d = 0.105;
    /// The same in 3D. A sphere that creeps through a closed box is 0.7 % slower at 0.2 and 1.4 %
    /// at 0.3, on 8 cells a diameter, than at 0.1.
    face_decay_cut_3d = 0.25;
    /// The same on all faces where no body moves, and nothing has to follow it. As much as that of
    /// moving ones, the flow through an array of spheres in Stokes flow (`cases/sphere-array`) has
    /// 10 % too little drag at 8 cells a diameter, 1.6 % at 16; at 4, 5.6 and 0.8 %.
    face_decay_fixed = 4.0;
    /// The most that faces have at once of the last pressure's acceleration where there are no
    /// bodies. A flow loses `dt <a, (1 - I M) a>` of its energy per unit time by this part (I:
    /// cells to faces, M: faces to cells): first order in time; at 0 a pressure that alternates
    /// from cell to cell stays for ever. At 1 the order in time of a carried vortex is 1.44 with
    /// two stages, and its error on 24^2 cells five times as large. At 0.1 the energy of random
    /// noise grows by 2.5 % in the second step by three stages at a Courant number of 1.2, at 0.2
    /// by 1.1 %, before it falls.
    face_own = 0.2;
    /// How long (h^2/nu) faces go by the last pressure at once; what a step has beyond that they
    /// take from the cells, as they stay where they are. Longer, a steady flow leaks through the
    /// faces by `dt (a - mean of the cells' a)`, and has less drag the longer the step; shorter, a
    /// pressure that alternates from cell to cell takes `0.05 nu dt/h^2` steps and more to fade.
    /// The drag of `cases/sphere-array` at a solid fraction of 0.52, 16 cells a diameter, is 7.0 %
    /// too little at 0.25, 5.2 at 0.05, 4.7 at 0.02; that of a cylinder at Re 20, 8 cells, 0.4, 0.6
    /// and 0.7 %.
    face_time = 0.05;
    /// The least part of a step that they go by it. Where it binds, at 20 Legendre stages and more,
    /// the longer steps leak.
    face_part = 0.01;
    /// Spacings that the flow crosses while a body takes in its force residual. Fewer, its noise
    /// moves bodies; more, light bodies lag. Halved: rebound +2.9 %. Doubled: rebound +4.2 %.
    residual_time = 3.0;
    /// Rate at which viscosity takes it in (nu/h^2). Less, what a body felt when it fell still
    /// pushes it when it lies: a disc on a floor rolled on for hours at 0.
    residual_decay = 0.1;
    /// Part of D0 below which a step leaves the pressure as it is. Larger, the force on a body
    /// jitters in quiet flows; smaller, solves that change nothing. Halved: nothing. Doubled:
    /// nothing.
    idle_divergence = 1e-3;
    /// Part of the stability limits, other than the Courant number's, that steps chosen by
    /// `time.cfl` use. Larger, nearer to the limit; smaller, more steps. Halved: under 7 %, twice
    /// the steps. Doubled: beyond the limits: runs fail.
    limit_share = 0.8;
    /// How much longer a step chosen by `time.cfl` may be than the one before.
    /// Halved: steps only shrink: nothing ends. Doubled: rebound +0.5 %.
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
    /// bodies that lie on others is found. With 12 plain rounds a row of discs that shuts a pipe
    /// carried 0.6 of its weight, and ended its run.
    most_initial_contact_iterations = 40.0;
    /// Part of that which may be missing then.
    initial_contact_tolerance = 1e-9;
    /// What a step counts in the mean force of contacts on a body. Larger, an impact of some steps
    /// counts as lasting before it ends; smaller, a bed that lands is taken for an impact for
    /// longer. A disc eight times as dense as a liquid without viscosity, 8 cells across, strikes
    /// its floor at Courant number 0.1, and keeps 0.83 of its speed at 0.05, 0.87 at 0.02; 0.97 it
    /// should.
    pressed_share = 0.02;
    /// Force of contacts that counts as lasting (of that mean): what the fluid answers to it is
    /// expected of the next step too. Less, a bed at rest is never sure of its weight; without
    /// bound, impacts lose energy.
    lasting_force = 2.0;
    /// Substeps in a contact, where the case leaves them to the program. Fewer, restitution is off;
    /// more, they cost. Halved: rebound +5.2 %, kiss -1.9 %. Doubled: rebound +1.5 %, kiss +2.2 %.
    contact_substeps = 40.0;
    /// Substeps while a gap that only fluid fills changes by its width, up to as many as a contact
    /// has, and at least half of these. Fewer, the approach of two bodies is coarse in time.
    /// Halved: rebound -0.2 %. Doubled: -0.1 %.
    gap_substeps = 4.0;
    /// Overlap, of the smaller radius, that ends a run.
    /// Halved: nothing. Doubled: nothing.
    deepest_overlap = 0.2;
    /// Deepest overlap that the stiffness "auto" is chosen for (of the smallest diameter). Smaller,
    /// stiffer contacts and more substeps; larger, softer ones that overlap. Halved: overlaps half
    /// as deep, else nothing. Doubled: overlaps a quarter deeper.
    auto_overlap = 0.01;
    /// The same in spacings: the less of the two holds.
    /// Halved: overlaps of a bed alone. Doubled: nothing.
    auto_overlap_spacing = 0.1;
    /// Width of the fluid lubrication layer in a contact (of the reduced radius). Smaller, stiffer
    /// lubrication at touch. Halved: rebound -0.9 %. Doubled: rebound +0.5 %.
    lubrication = 0.02;
    /// Gap at which the grid gives half of the lubrication force on a disc (spacings), fitted to
    /// discs that approach each other and a wall in Stokes flow (tests
    /// `the_force_between_two_discs` and `the_force_of_a_narrow_gap`). Two gaps, 1.4 at walls and
    /// 1.7 between discs, would be within 5 % at 8 cells across.
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
    /// Halved: rebound +4.4 %. Doubled: rebound +4.1 %.
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
