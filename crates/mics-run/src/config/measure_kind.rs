//! Kinds of measures, with their units and what each needs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use MeasureKind::*;

/// Kind of a measure. Coefficients are forces over `0.5 rho_f speed^2 d` (2D, per unit depth) or
/// `0.5 rho_f speed^2 pi d^2/4` (3D), with d the key `length` or else the diameter, for shapes that
/// are not round that of the disc or sphere of equal volume; means are over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MeasureKind {
    /// Mean of the force along the stream, or `direction`, as a coefficient.
    DragCoefficient,
    /// Largest force along the stream, as a coefficient.
    DragCoefficientMax,
    /// Mean of the force across the stream, or along `direction`, as a coefficient.
    LiftCoefficient,
    /// Largest force across the stream, as a coefficient.
    LiftCoefficientMax,
    /// Mean magnitude of the force across the stream, or across `direction`, as a coefficient.
    LiftMagnitude,
    /// Mean of the force by the fluid on all of `particles` together, along the stream or
    /// `direction` (N, in 2D N/m).
    Force,
    /// Mean of the torque by the fluid on a particle or an obstacle, about the axis through its
    /// centre, or the point `about`, that is along z or, in 3D, `direction` (N m, in 2D N m/m).
    Torque,
    /// Root mean square of the lift coefficient about its mean.
    LiftRms,
    /// Half the span of the lift coefficient.
    LiftAmplitude,
    /// `f d/speed` of the lift, from its upward crossings of the mean.
    Strouhal,
    /// `C_D` of Morison's formula for an oscillating particle, a least-squares fit of `F = -C_D 0.5
    /// rho_f S |U| U - C_M rho_f V dU/dt`: U its velocity, S and V its frontal area and volume (2D:
    /// d and pi d^2/4 per unit depth).
    MorisonDrag,
    /// `C_M` of the same fit: 1 for a disc in an unbounded inviscid fluid.
    MorisonInertia,
    /// Root mean square of the residual of that fit, over that of the force.
    MorisonResidual,
    /// Root mean square of the force along the stream about its least-squares quadratic in time,
    /// over its mean, weighted by the steps: the noise of a particle that moves steadily over the
    /// grid.
    ForceNoise,
    /// Largest speed of the fluid over domain and time (m/s), in cells at most half solid.
    MaxSpeed,
    /// Least velocity along x on the line x = size/2 at the end (m/s), by a parabola through three
    /// cells; 2D only.
    MidlineULeast,
    /// Least velocity along y on the line y = size/2 at the end (m/s); 2D only.
    MidlineVLeast,
    /// Largest velocity along y on the line y = size/2 at the end (m/s); 2D only.
    MidlineVLargest,
    /// Reattachment point (m): x at which the shear on the south side is zero at the end, where the
    /// flow there last turns from backward to forward; 2D only.
    Reattachment,
    /// Largest speed of the particle's centre from `from` on (m/s), steady or not.
    #[serde(alias = "terminal_velocity")]
    LargestSpeed,
    /// Speed of a steady fall (m/s): the mean over the quarter of the way, from `from` on, where
    /// the speed changes least, with a remark whether it is steady within 1 %.
    TerminalSpeed,
    /// x of the particle's centre at the end, or `when` (m).
    PositionX,
    /// y of the particle's centre at the end, or `when` (m).
    PositionY,
    /// z of the particle's centre at the end, or `when` (m), 3D only.
    PositionZ,
    /// Mean of the particle's velocity along x, or that `when` (m/s).
    VelocityX,
    /// Mean of the particle's velocity along y, or that `when` (m/s).
    VelocityY,
    /// Mean of the particle's velocity along z, or that `when` (m/s), 3D only.
    VelocityZ,
    /// Mean of the particle's angular velocity about z, or that `when` (rad/s).
    Spin,
    /// Largest magnitude of the particle's angular velocity about z, from `from` on (rad/s).
    LargestSpin,
    /// Least magnitude of the particle's angular velocity about z, from `from` on (rad/s).
    LeastSpin,
    /// Time in which the particle turns once about z (s): twice that of its latest half turn.
    TurnPeriod,
    /// Angle about z by which the particle is turned at the end, or `when`, from its `orientation`
    /// of 0 on, all turns counted (rad).
    Angle,
    /// First contact of the particle with a body or wall (s); in a viscous fluid a gap of
    /// `contact.roughness`.
    ContactStart,
    /// Mean height of `particles` at the end, against gravity and above the lowest centre of all
    /// (m).
    MeanHeight,
    /// Mean rank of `particles` at the end by height against gravity; 1 is the lowest.
    HeightRank,
    /// Fastest of the centres of `particles` at the end (m/s).
    FastestParticle,
    /// Deepest overlap of a contact over time (m).
    LargestOverlap,
    /// Mean speed of the centres of `particles` (m/s), and over time.
    MeanSpeed,
    /// Root mean square of the speeds of the centres of `particles` (m/s); its mean over time.
    RmsSpeed,
    /// Mean volume rate of `particles` through a cross-section (m3/s; m2/s in 2D): `sum V v/L`
    /// along `axis`, L the length of the box.
    TransportRate,
    /// Mean volume rate of `particles` per width of the bed (m2/s), `sum V v/A` along `axis`: A the
    /// plan area of the box; default all particles that are not fixed.
    BedloadRate,
    /// `bedload_rate` over `sqrt((s - 1) g d^3)`: Einstein's number, with s and d the mean density
    /// over the fluid's and the mean diameter of `particles`.
    Einstein,
    /// Mean over time of the shear stress on the bed along `axis` (Pa). Where the flow is periodic
    /// along it, by the balance of momentum of the flow over the bed: the force of the drive times
    /// the depth over `bed_height` at `threshold`, and the shear on the side above, less what a
    /// mean velocity over time accelerates. A flow that a force still accelerates has to be
    /// measured in a `region`. Otherwise, or in a `region` (of which the extent along the bed
    /// counts), the shear on the side below and the force on all particles and obstacles there,
    /// over the plan area. With `particles` or `obstacle` the force on these over the plan area.
    BedShearStress,
    /// Shields number: `bed_shear_stress` over `(rho_s - rho) g d`, with the mean density and
    /// diameter of `particles`; default all that are not fixed.
    Shields,
    /// Mean over time of the fluid's velocity along `axis` over the whole box, zero in bodies
    /// (m/s).
    SuperficialVelocity,
    /// Mean over time of the flow rate of fluid and bodies along `axis` (m3/s; m2/s in 2D).
    FlowRate,
    /// Mean over time of the pressure drop over the box along `axis`, the drive included (Pa).
    PressureDrop,
    /// Mean over time of the force of the drive on the fluid along `axis` (N/m3).
    DriveForce,
    /// Mean over time of the solid fraction of `region`.
    SolidFraction,
    /// Mean over time of the height, over the low end of the box, at which the solid fraction of
    /// layers falls to `threshold` (m).
    BedHeight,
    /// Mean over time of the kinetic energy of the fluid (J; per metre of depth in 2D).
    FluidEnergy,
    /// Largest rate of loss of the fluid's kinetic energy over a step, per mass of the fluid that
    /// fills the box (m2/s3).
    Dissipation,
    /// Time of that largest rate of loss, `dissipation` (s).
    DissipationTime,
    /// Mean over time of the kinetic energy of the free bodies (J; per metre of depth in 2D).
    BodyEnergy,
}

impl MeasureKind {
    /// Names that kinds had in earlier versions, each with the present one.
    pub(in crate::config) const RENAMED: [(&str, &str); 1] =
        [("terminal_velocity", "largest_speed")];

    /// The unit of its value, where the case is in SI units; empty for numbers without one. Forces
    /// and energies in 2D are per metre of depth.
    pub fn unit(self, dimension: usize) -> &'static str {
        match self {
            DragCoefficient | DragCoefficientMax | LiftCoefficient | LiftCoefficientMax
            | LiftMagnitude | LiftRms | LiftAmplitude | Strouhal | MorisonDrag | MorisonInertia
            | MorisonResidual | ForceNoise | HeightRank | SolidFraction | Einstein | Shields => "",
            MaxSpeed | MidlineULeast | MidlineVLeast | MidlineVLargest | LargestSpeed
            | TerminalSpeed | VelocityX | VelocityY | VelocityZ | FastestParticle | MeanSpeed
            | RmsSpeed | SuperficialVelocity => "m/s",
            Reattachment | PositionX | PositionY | PositionZ | MeanHeight | LargestOverlap
            | BedHeight => "m",
            ContactStart | DissipationTime | TurnPeriod => "s",
            Spin | LargestSpin | LeastSpin => "rad/s",
            Angle => "rad",
            Force if dimension == 2 => "N/m",
            Force => "N",
            Torque if dimension == 2 => "N m/m",
            Torque => "N m",
            TransportRate | FlowRate if dimension == 2 => "m2/s",
            TransportRate | FlowRate => "m3/s",
            BedloadRate => "m2/s",
            PressureDrop | BedShearStress => "Pa",
            DriveForce => "N/m3",
            FluidEnergy | BodyEnergy if dimension == 2 => "J/m",
            FluidEnergy | BodyEnergy => "J",
            Dissipation => "m2/s3",
        }
    }

    /// Whether its value is found from all samples from `from` on, so that an impulsive start at
    /// time 0 counts in it.
    pub fn counts_the_start(self) -> bool {
        matches!(
            self,
            DragCoefficient
                | LiftCoefficient
                | LiftMagnitude
                | LiftRms
                | LiftAmplitude
                | Force
                | Torque
        )
    }

    /// Whether it is of one particle.
    pub fn needs_particle(self) -> bool {
        !matches!(self, MaxSpeed | LargestOverlap)
            && !self.is_of_line()
            && !self.is_of_group()
            && !self.is_of_box()
    }

    /// Whether it is of several particles.
    pub fn is_of_group(self) -> bool {
        matches!(
            self,
            MeanHeight
                | HeightRank
                | FastestParticle
                | Force
                | MeanSpeed
                | RmsSpeed
                | TransportRate
        ) || self.is_of_grains()
    }

    /// Whether it can be of several particles.
    pub fn takes_group(self) -> bool {
        self.is_of_group() || self == BedShearStress
    }

    /// Whether it is of the grains of a bed.
    pub fn is_of_grains(self) -> bool {
        matches!(self, BedloadRate | Einstein | Shields)
    }

    /// Whether it is of a bed and what moves over it.
    pub fn is_of_bed(self) -> bool {
        self.is_of_grains() || matches!(self, BedHeight | BedShearStress | TransportRate)
    }

    /// Whether it is of the shear stress on a bed.
    pub fn is_of_shear(self) -> bool {
        matches!(self, BedShearStress | Shields)
    }

    /// Whether it is of the density and size of its particles, which must be heavier than the
    /// fluid.
    pub fn needs_heavy(self) -> bool {
        matches!(self, Einstein | Shields)
    }

    /// Whether it is along a bed, across which gravity acts.
    pub fn is_along_bed(self) -> bool {
        self.is_of_grains() || self.is_of_shear()
    }

    /// Whether the height of the bed counts in it.
    pub fn has_threshold(self) -> bool {
        self == BedHeight || self.is_of_shear()
    }

    /// Whether it is taken of the whole box after every step.
    pub fn is_of_box(self) -> bool {
        self.has_axis()
            || matches!(
                self,
                SolidFraction | FluidEnergy | BodyEnergy | Dissipation | DissipationTime
            )
    }

    /// Whether it is along an axis.
    pub fn has_axis(self) -> bool {
        matches!(
            self,
            SuperficialVelocity | FlowRate | PressureDrop | DriveForce | TransportRate | BedHeight
        ) || self.is_along_bed()
    }

    /// Whether it needs gravity, to tell what is high.
    pub fn needs_gravity(self) -> bool {
        matches!(self, MeanHeight | HeightRank | BedHeight) || self.is_along_bed()
    }

    /// Whether it is of the velocities on a line of cells of the box.
    pub fn is_of_line(self) -> bool {
        matches!(self, MidlineULeast | MidlineVLeast | MidlineVLargest | Reattachment)
    }

    /// Whether a reference speed makes it dimensionless: a coefficient of a force, or a frequency.
    pub fn needs_speed(self) -> bool {
        matches!(
            self,
            DragCoefficient
                | DragCoefficientMax
                | LiftCoefficient
                | LiftCoefficientMax
                | LiftMagnitude
                | LiftRms
                | LiftAmplitude
                | Strouhal
        )
    }

    /// Whether it can be taken at a moment of the particle's way.
    pub fn has_moments(self) -> bool {
        matches!(
            self,
            PositionX | PositionY | PositionZ | VelocityX | VelocityY | VelocityZ | Spin | Angle
        )
    }

    /// Whether it is made of the force or torque on a particle.
    pub fn is_of_force(self) -> bool {
        self.needs_speed() || self.fits_morison() || matches!(self, ForceNoise | Force | Torque)
    }

    /// Whether it is of a force or torque along or about a direction, or across one.
    pub fn has_direction(self) -> bool {
        self.is_of_force() && !self.fits_morison()
    }

    /// Whether it is of the component of a force across the stream.
    pub fn is_across(self) -> bool {
        matches!(self, LiftCoefficient | LiftCoefficientMax | LiftRms | LiftAmplitude | Strouhal)
    }

    /// Whether its samples are means over their steps, as forces are, and not values at their ends.
    pub fn is_mean_of_step(self) -> bool {
        matches!(
            self,
            DragCoefficient
                | LiftCoefficient
                | LiftMagnitude
                | LiftRms
                | Force
                | Torque
                | DriveForce
                | PressureDrop
        ) || self.is_of_shear()
    }

    /// Whether it is a fit of Morison's formula, of a particle with a prescribed oscillation.
    pub fn fits_morison(self) -> bool {
        matches!(self, MorisonDrag | MorisonInertia | MorisonResidual)
    }
}
