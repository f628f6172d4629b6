//! The numbers of the method that were chosen once, for all cases.

use crate::config::fault::Check;
use schemars::JsonSchema;
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};

/// A struct of numbers, each with its default and its valid range, which its description gains.
macro_rules! numerics {
    (
        $(#[doc = $about:literal])*
        pub struct Numerics;
        $(
            $(#[doc = $doc:literal])*
            $name:ident = $default:literal, $least:literal to $most:literal;
        )*
    ) => {
        $(#[doc = $about])*
        #[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct Numerics {
            $(
                $(#[doc = $doc])*
                #[doc = concat!("Valid from ", $least, " to ", $most, ".")]
                pub $name: f64,
            )*
        }

        impl Default for Numerics {
            fn default() -> Numerics {
                Numerics { $($name: $default,)* }
            }
        }

        impl Numerics {
            /// The least and the largest valid value of each, in the order of
            /// [`Numerics::named`].
            const RANGES: &[[f64; 2]] = &[$([$least, $most],)*];

            /// All of them, by name.
            pub fn named(&self) -> Vec<(&'static str, f64)> {
                vec![$((stringify!($name), self.$name),)*]
            }
        }
    };
}

numerics! {
    /// The numbers of the method that were chosen once, for all cases: for experiments alone. A run
    /// with another value than the default warns that its results are an experiment, to which no
    /// validation applies. `docs/constants.md` has what was measured of each.
    pub struct Numerics;

    /// Aperture (open fraction of a face) that remains where bodies share a face, or beside a wall
    /// of the box. Smaller, pockets between bodies hold a pressure that pushes them; larger, more
    /// flows through a closed gap.
    shared_aperture = 0.1, 0.001 to 0.9;
    /// Reynolds number of a spacing and the velocity at the first image point up to which the layer
    /// at a wall is resolved. Smaller, the extrapolated profile is cut off in flows that need it;
    /// larger, it overshoots where the layer is too thin for the grid.
    resolved_layer = 40.0, 0.0 to 1e6;
    /// Largest velocity of the extrapolated profile, of the velocity at the first image point,
    /// where the layer is just resolved.
    largest_profile = 5.0, 1.0 to 100.0;
    /// Distance of the first image point from the wall (spacings); the second and the third are
    /// twice and three times as far. Nearer, it reads ghost cells; farther, the profile misses the
    /// layer.
    image_point = 1.0, 0.5 to 2.0;
    /// Width (spacings) over which one form of the profile passes into another as a gap closes, the
    /// cubic ends with depth, and the ownership weight of a cell passes between two bodies.
    /// Smaller, forces jump as bodies pass over cells; larger, cells are set by the body that is
    /// not the nearest.
    blending_width = 0.5, 0.01 to 1.5;
    /// Reynolds number of a spacing and the fastest velocity at its image points up to which cells
    /// beside fixed bodies take all of the cubic extrapolation; none from three times as much on.
    creeping_layer = 0.5, 0.0 to 1e6;
    /// Distance between the image points of the slope at the wall (spacings). Smaller, noise as the
    /// body moves; larger, less of a thin layer.
    slope_image_point = 0.7, 0.1 to 1.0;
    /// Courant number of a step over which the momentum-interpolation correction of the faces
    /// decays; beside fixed bodies also how far (spacings that the flow crosses) faces go by the
    /// last pressure at once. Smaller, the pressure beside a wall jitters at small steps; larger, a
    /// wall reaches the faces late.
    correction_courant = 0.2, 0.001 to 100.0;
    /// Rate at which viscosity takes that correction (nu/h^2) on faces that no body cuts, where
    /// bodies move.
    correction_decay_open = 0.4, 0.0 to 100.0;
    /// The same on faces that a body cuts, in 2D. Smaller, a creeping flow keeps in its faces what
    /// its cells have lost, and is driven by it; larger, a wall reaches the faces late.
    correction_decay_cut_2d = 0.105, 0.0 to 100.0;
    /// The same in 3D.
    correction_decay_cut_3d = 0.25, 0.0 to 100.0;
    /// The same on all faces where no body moves.
    correction_decay_fixed = 4.0, 0.0 to 100.0;
    /// Largest weight of the pressure gradient at a face itself, in place of the mean of the
    /// cells', in the prediction of face velocities where there are no bodies.
    pressure_weight = 0.2, 0.001 to 1.0;
    /// How long (h^2/nu) faces go by the last pressure at once; for the rest of a step they take
    /// the mean of the cells' acceleration. Longer, a steady flow leaks through the faces and has
    /// less drag the longer the step; shorter, a pressure that alternates from cell to cell takes
    /// `0.05 nu dt/h^2` steps and more to decay.
    pressure_time = 0.05, 0.0 to 1e6;
    /// Spacings that the flow crosses while the filtered force defect of a body follows the force
    /// defect. Fewer, its noise moves bodies; more, light bodies lag.
    defect_time = 3.0, 0.1 to 1000.0;
    /// Rate at which viscosity makes it follow (nu/h^2). Smaller, the force on a falling body still
    /// pushes it when it lies.
    defect_decay = 0.1, 0.0 to 100.0;
    /// Part of the stability limits, other than the Courant number's, that steps chosen by
    /// `time.cfl` use. Larger, nearer to the limit; smaller, more steps.
    limit_share = 0.8, 0.01 to 1.0;
    /// Largest ratio of a step chosen by `time.cfl` to the one before.
    step_growth = 1.1, 1.001 to 100.0;
    /// Part of its added mass that a body without mass has in a contact.
    added_mass_share = 0.4, 0.0 to 10.0;
    /// How much larger that part is for each density of the fluid that the body has.
    added_mass_slope = 0.25, 0.0 to 10.0;
    /// Largest part of its added mass that a body has in a contact.
    largest_added_mass_share = 1.6, 0.0 to 100.0;
    /// Weight of a step in the mean contact force on a body, in the mixture method. Larger, an
    /// impact of some steps counts as sustained before it ends; smaller, a bed that lands counts as
    /// an impact for longer.
    mean_force_weight = 0.02, 0.0001 to 1.0;
    /// Largest sustained contact force, of that mean: what the fluid responds to it is expected in
    /// the next step too. Smaller, a bed at rest is never sure of its weight; without bound,
    /// impacts lose energy.
    sustained_force = 2.0, 1.0 to 1e6;
    /// Substeps in a contact where the case leaves them to the program; a tenth of them while a gap
    /// that only fluid fills changes by its width. Fewer, restitution is off; more, they cost.
    contact_substeps = 40.0, 5.0 to 10000.0;
    /// Deepest overlap that the stiffness "auto" is chosen for (of the smallest diameter). Smaller,
    /// stiffer contacts and more substeps; larger, softer ones that overlap. The lubrication layer
    /// of two that touch has this width too, of the diameter of their reduced radius.
    auto_overlap = 0.01, 1e-6 to 0.1;
    /// Gap at which the grid gives half of the lubrication force on a disc (spacings), fitted to
    /// discs that approach each other and a wall in Stokes flow.
    half_gap_2d = 1.5, 0.01 to 10.0;
    /// The same for spheres, fitted to a sphere let go beside a wall.
    half_gap_3d = 0.6, 0.01 to 10.0;
    /// How much wider than it is the grid shows a closed gap between discs that slide along it
    /// (spacings), fitted to a disc pulled along a wall in Stokes flow; twice that where they roll.
    shear_gap_2d = 0.28, 0.001 to 10.0;
    /// The same for spheres.
    shear_gap_3d = 0.22, 0.001 to 10.0;
    /// Gap from which on the grid has all of the lubrication force (spacings).
    lubrication_range = 6.0, 0.1 to 100.0;
    /// Distance to Coulomb's limit, of it, within which a contact passes from sticking to sliding
    /// in the correction of contact impulses.
    sliding_onset = 0.1, 1e-6 to 1.0;
    /// Damping ratio of rolling resistance: a body that rocks in place comes to rest after some
    /// swings.
    rolling_damping = 0.3, 0.0 to 10.0;
}

impl Numerics {
    /// The names of those that differ from their defaults, with value and default.
    pub fn changed(&self) -> Vec<(&'static str, f64, f64)> {
        let pairs = self.named().into_iter().zip(Numerics::default().named());
        let changed = pairs.filter(|((_, value), (_, default))| value != default);
        changed.map(|((name, value), (_, default))| (name, value, default)).collect()
    }

    /// Whether all have their defaults.
    pub fn is_default(&self) -> bool {
        *self == Numerics::default()
    }

    /// Whether the number of this name may have this value.
    pub fn is_valid(name: &str, value: f64) -> bool {
        let names = Numerics::default().named();
        let mut ranges = names.iter().zip(Numerics::RANGES);
        ranges.any(|((own, _), [least, most])| *own == name && (*least..=*most).contains(&value))
    }

    pub(super) fn check(&self) -> Check {
        for ((name, value), [least, most]) in self.named().into_iter().zip(Numerics::RANGES) {
            ensure!(
                Numerics::is_valid(name, value),
                format!("numerics.{name}"),
                "{value:?} is out of its range, from {least} to {most}"
            );
        }
        Ok(())
    }
}

/// Those that differ from their defaults: a case written out says no more.
impl Serialize for Numerics {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let changed = self.changed();
        let mut map = serializer.serialize_map(Some(changed.len()))?;
        for (name, value, _) in changed {
            map.serialize_entry(name, &value)?;
        }
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::Numerics;

    #[test]
    fn defaults_are_in_their_ranges() {
        assert!(Numerics::default().check().is_ok());
    }

    #[test]
    fn changed_numerics_round_trip() {
        let changed = Numerics { shared_aperture: 0.05, ..Numerics::default() };
        let text = toml::to_string(&changed).unwrap();
        assert_eq!(text, "shared_aperture = 0.05\n");
        assert_eq!(toml::from_str::<Numerics>(&text).unwrap(), changed);
        assert_eq!(toml::to_string(&Numerics::default()).unwrap(), "");
        assert!(toml::from_str::<Numerics>("no_such_number = 1.0").is_err());
    }
}
