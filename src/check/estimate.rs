//! The speed that a case will come to, before it runs, and the step that it then takes.
//!
//! ```text
//!   stream   U      beside what is held in it 1.5 U: round a cylinder in a wide box, with its wake
//!   fall     terminal speed, or what is gathered on the way to the boundary ([`super::layer`])
//!   told     the fastest of what is prescribed
//!   drive    [`Case::driven_speed`]
//!   bed      1.5 U/(1 - phi): a mean velocity U held over free bodies that fill phi of the box
//! ```
//! The flow over a bed is by continuity. The one that begins there runs through the pores too, and
//! has left them some steps later. Where several bodies fall together the fluid between them is
//! faster than they are. In a box with a floor they lie once they have had the time to fall twice
//! through it, and from there on the fluid comes to rest:
//!
//! ```text
//!   step   its own before T0,   grows as (t/T0)^n from there on, up to the step of a fluid at rest
//!            T0 = 2 height/speed
//! ```

use super::layer::fall_speed;
use crate::config::{Case, Drive, Motion, Side, Step};
use crate::numerics::STEP_GROWTH;
use crate::scheme::Limits;
use crate::step_size::{Rest, choose_step};

/// The largest speed over that of the stream, where something is held in it.
const BESIDE: f64 = 1.5;
/// The same over that of bodies that fall together, in 2D and 3D: in a plane the fluid finds
/// fewer ways past them.
const BETWEEN: [f64; 2] = [2.0, 1.5];
/// In how many falls through the box bodies come to lie on its floor.
const FALLS: f64 = 2.0;
/// The power of time with which steps grow while the fluid above them comes to rest, in 2D and 3D:
/// seen in `cases/packing` and `cases/size-sorting`.
const FADES: [f64; 2] = [1.0, 2.0];
/// Density over the fluid's from which on they hop for longer.
const HOPPING: f64 = 100.0;

/// How a particle has the speed of its fall.
const COMES_TO: &str = "comes to";

/// The largest speed to be expected in a case.
#[derive(Clone, Debug, PartialEq)]
pub struct LargestSpeed {
    /// Its speed (m/s).
    pub speed: f64,
    /// What it is, in words that follow on the speed.
    pub words: String,
    /// The spacing that it goes by (m): along a stream; the least where the direction is open.
    spacing: f64,
    /// The particle that comes to it by its weight.
    falling: Option<usize>,
}

impl LargestSpeed {
    /// The fastest that is to be expected; `None` where nothing is known to move.
    pub fn expected(case: &Case) -> Option<LargestSpeed> {
        let spacing = case.spacings().into_iter().fold(f64::INFINITY, f64::min);
        let at = |speed, words: &str| {
            let words = words.to_owned();
            LargestSpeed { speed, words, spacing, falling: None }
        };
        let vortex = case.initial.taylor_green.map(|speed| at(speed, "that of the vortex"));
        let driven =
            case.driven_speed().map(|speed| at(speed, "to which the drive may bring the fluid"));
        let particle = fastest_particle(case).map(|(speed, id, does)| LargestSpeed {
            falling: (does == COMES_TO).then_some(id),
            ..at(speed, &format!("which {} {does}", case.called(id)))
        });
        let all = LargestSpeed::of_stream(case, spacing)
            .into_iter()
            .chain(vortex)
            .chain(driven)
            .chain(particle)
            .filter(|largest| largest.speed > 0.0);
        all.max_by(|a, b| (a.speed / a.spacing).total_cmp(&(b.speed / b.spacing)))
    }

    /// That of the stream, beside what is held in it or over a bed; it goes by the spacing along
    /// the stream where there are no bodies, and by the `least` one (m) beside them.
    fn of_stream(case: &Case, least: f64) -> Option<LargestSpeed> {
        let speed = case.reference_speed?;
        let held = !case.obstacle.is_empty() || case.particle.iter().any(|p| !p.is_free());
        let (factor, beside) =
            if held { (BESIDE, " beside what is held in it") } else { (1.0, "") };
        let open = if passes_over_a_bed(case) { 1.0 - solid_fraction(case) } else { 1.0 };
        let stream = case.stream.as_ref().filter(|_| !case.has_bodies());
        let along = |v: &Vec<f64>| {
            speed / v.iter().zip(case.spacings()).map(|(v, h)| v.abs() / h).sum::<f64>()
        };
        Some(LargestSpeed {
            speed: factor * speed / open,
            words: format!("that of the stream{beside}"),
            spacing: stream.map_or(least, along),
            falling: None,
        })
    }

    /// When bodies have fallen to the floor of their box (s), if nothing drives; `None` where they
    /// have none, come in later, or hop for long.
    fn fallen(&self, case: &Case) -> Option<f64> {
        let id = self.falling?;
        let driven = case.drive.is_some()
            || case.stream.is_some()
            || case.particle.iter().any(|p| p.enter.is_some());
        let (ratio, mut height) = (case.particle[id].density / case.fluid.density, 0.0f64);
        for (axis, g) in case.fluid.gravity.iter().enumerate().filter(|(_, g)| **g != 0.0) {
            let floor = &case.boundary[axis][usize::from((*g > 0.0) == (ratio > 1.0))];
            if matches!(floor, Side::Outflow | Side::Periodic) {
                return None;
            }
            height = height.max(case.domain.size[axis]);
        }
        (!driven && ratio < HOPPING).then(|| FALLS * height / self.speed)
    }

    /// The step (s) that `time.cfl` gives at this speed; infinite where the step is given.
    pub fn step(&self, case: &Case) -> f64 {
        let Step::Courant(number) = case.time.step else { return f64::INFINITY };
        number * self.spacing / self.speed
    }
}

/// The speed (m/s) of the fastest particle, its number, and how it has that speed.
fn fastest_particle(case: &Case) -> Option<(f64, usize, &'static str)> {
    let size = |v: &[f64]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let all = case.particle.iter().enumerate().filter_map(|(id, p)| match &p.motion {
        Motion::Fixed => None,
        Motion::Free { velocity, .. } => {
            let (fall, start) = (fall_speed(case, p), size(velocity));
            Some((fall.max(start), id, if fall > start { COMES_TO } else { "begins with" }))
        }
        Motion::Prescribed { velocity, oscillation, .. } => {
            let swing = oscillation.as_ref().map_or(0.0, |o| o.speed());
            Some((size(velocity) + swing, id, "is told to have"))
        }
    });
    all.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// Whether a mean velocity is held in a box whose free bodies sink to its floor or rise to its
/// ceiling: the flow passes beside them.
fn passes_over_a_bed(case: &Case) -> bool {
    let across = |held: usize| {
        (0..case.dimension())
            .any(|a| a != held && case.fluid.gravity[a] != 0.0 && !case.periodic(a))
    };
    let free = case.particle.iter().any(|p| p.is_free() && p.density != case.fluid.density);
    free && matches!(&case.drive, Some(Drive::MeanVelocity(held)) if across(held.axis.index()))
}

/// The part of the box that bodies fill, at most that of discs packed as densely as can be.
fn solid_fraction(case: &Case) -> f64 {
    let volume = case.domain.size.iter().product::<f64>();
    let filled = case.particle.iter().map(|p| p.shape.volume()).sum::<f64>();
    (filled / volume).min(std::f64::consts::PI / 12.0f64.sqrt())
}

/// The step (s) of a run that has come to its speed, where that is known: by the scheme's `limits`,
/// with all stages that viscosity asks for.
pub fn later_step(case: &Case, limits: &Limits) -> f64 {
    let first = choose_step(case, limits, None, case.time.end).0;
    let (Step::Courant(number), Some(largest)) = (case.time.step, LargestSpeed::expected(case))
    else {
        return first;
    };
    let begins = if passes_over_a_bed(case) { 0.0 } else { limits.courant_rate };
    let courant_rate = begins.max(number / largest.step(case));
    let limits = Limits { courant_rate, courant_growth: 0.0, ..*limits };
    choose_step(case, &limits, Some(f64::INFINITY), case.time.end).0
}

/// How the steps of a case will grow under the scheme's `limits`; `None` where nothing comes to
/// rest.
pub fn expected_rest(case: &Case, limits: &Limits) -> Option<Rest> {
    let from = LargestSpeed::expected(case)
        .filter(|largest| largest.step(case).is_finite())?
        .fallen(case)?;
    let limits = Limits { courant_rate: 0.0, courant_growth: 0.0, ..*limits };
    let still = choose_step(case, &limits, Some(f64::INFINITY), case.time.end).0;
    Some(Rest { from, still, power: FADES[case.dimension() - 2] })
}

/// How many steps a run takes from the `first` (s), each hardly longer than the one before, to the
/// `later` ones (s), and to those that `limits` leave a box that comes to rest.
pub fn steps(case: &Case, limits: &Limits, first: f64, later: f64) -> f64 {
    let end = case.time.end;
    let largest = LargestSpeed::expected(case)
        .filter(|largest| largest.step(case).is_finite() && later < first);
    let several = case.particle.iter().filter(|p| p.is_free()).count() > 1;
    let falls = largest.as_ref().is_some_and(|largest| largest.falling.is_some());
    let later = if several && falls { later / BETWEEN[case.dimension() - 2] } else { later };
    let growing = ((later / first).ln() / STEP_GROWTH.ln()).clamp(0.0, 1e3);
    let gone = (first * (STEP_GROWTH.powf(growing) - 1.0) / (STEP_GROWTH - 1.0)).min(end);
    let rest = largest.and_then(|_| expected_rest(case, limits));
    (growing + rest.map_or(end - gone, |rest| rest.stretched(gone, end, later)) / later).ceil()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(sides: [&str; 4], more: &str) -> Case {
        let [west, east, south, north] = sides;
        let text = format!(
            "name = \"t\"\ntime = {{ end = 9.0, cfl = 0.4 }}\n\
            domain = {{ size = [2.0, 0.5], cells = [32, 16] }}\n\
            fluid = {{ density = 2.0, viscosity = 0.1, gravity = [0.0, -9.81] }}\n\
            boundary = {{ west = {west}, east = {east}, south = {south}, north = {north} }}\n\
            {more}"
        );
        crate::config::written(&text).unwrap()
    }

    /// Limits of viscosity alone, in steps of rk2.
    fn limits() -> Limits {
        Limits {
            courant_rate: 0.0,
            courant_growth: 0.0,
            diffusion_rate: 10.0,
            damping_rate: 5.0,
            scheme: crate::scheme::RK2,
        }
    }

    const ROUND: [&str; 4] = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"wall\""];

    #[test]
    fn expected_speed_of_driven_channel() {
        let speed = |sides, more| LargestSpeed::expected(&case(sides, more)).unwrap().speed;
        // G L^2/(8 mu), and over a film G L^2/(2 mu).
        assert!((speed(ROUND, "drive.force = [0.3, 0.0]") - 0.3 * 0.25 / 0.8).abs() < 1e-12);
        let film = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"slip\""];
        assert!((speed(film, "drive.force = [0.3, 0.0]") - 0.3 * 0.25 / 0.2).abs() < 1e-12);
        let open = ["\"periodic\"", "\"periodic\"", "\"slip\"", "\"slip\""];
        assert!((speed(open, "drive.force = [0.3, 0.0]") - 0.3 * 9.0 / 2.0).abs() < 1e-12);
    }

    #[test]
    fn step_estimate_from_fastest_body() {
        let disc = |name: &str, x: f64, more: &str| {
            format!(
                "[[particle]]\nname = \"{name}\"\nshape = {{ disc = {{ diameter = 0.1 }} }}\n\
                position = [{x:?}, 0.3]\n{more}\n"
            )
        };
        let both = disc("stone", 0.5, "density = 5.0") + &disc("cork", 1.5, "density = 1.9");
        let case = case(["{ inflow = [0.01, 0.0] }", "\"outflow\"", "\"slip\"", "\"slip\""], &both);
        let largest = LargestSpeed::expected(&case).unwrap();
        assert_eq!(
            (largest.speed, largest.words.as_str()),
            (fall_speed(&case, &case.particle[0]), "which stone comes to")
        );
        assert!((largest.step(&case) - 0.4 * 0.03125 / largest.speed).abs() < 1e-15);
    }

    #[test]
    fn step_estimate_of_many_falling_bodies() {
        let disc = |x: f64, more: &str| {
            format!(
                "[[particle]]\nshape = {{ disc = {{ diameter = 0.1 }} }}\n\
                position = [{x:?}, 0.3]\ndensity = 5.0\n{more}\n"
            )
        };
        let counted = |sides, more: &str| {
            let case = case(sides, more);
            let limits = limits();
            let later = later_step(&case, &limits);
            (steps(&case, &limits, 0.05, later), later)
        };
        let open = ["\"periodic\"", "\"periodic\"", "\"outflow\"", "\"wall\""];
        let (one, step) = counted(open, &disc(0.5, ""));
        assert!((one * step / 9.0 - 1.0).abs() < 0.05, "{one} steps of {step} s");
        let (two, step) = counted(open, &(disc(0.5, "") + &disc(1.5, "")));
        assert!((two * step / 18.0 - 1.0).abs() < 0.05, "{two} steps of {step} s");
        let (settled, _) = counted(ROUND, &(disc(0.5, "") + &disc(1.5, "")));
        assert!(settled < 0.7 * two, "{settled} and {two}");
    }

    #[test]
    fn step_estimate_grows_after_bodies_have_settled() {
        let in_a_plane = Rest { from: 1.0, still: 0.4, power: 1.0 };
        // 0.5 s at 0.1 s, and from 1 s on at t/10 s up to 4 s, where they are 0.4 s.
        let close = |found: f64, steps: f64| {
            assert!((found / (0.1 * steps) - 1.0).abs() < 1e-12, "{found}")
        };
        close(in_a_plane.stretched(0.5, 3.0, 0.1), 5.0 + 10.0 * 3.0f64.ln());
        close(in_a_plane.stretched(0.5, 6.0, 0.1), 5.0 + 10.0 * 4.0f64.ln() + 2.0 / 0.4);
        // A step at 2 s, when they grow already; with the square of time, up to 2 s.
        close(in_a_plane.stretched(2.0, 3.0, 0.1), 20.0 * 1.5f64.ln());
        close(
            Rest { power: 2.0, ..in_a_plane }.stretched(0.0, 3.0, 0.1),
            10.0 + 10.0 * (1.0 - 0.5) + 1.0 / 0.4,
        );
        // Nothing shortens a step that is longer than that of a fluid at rest, and nothing is left
        // at the end.
        assert!((in_a_plane.stretched(1.5, 2.0, 0.8) - 0.5).abs() < 1e-12);
        assert_eq!(in_a_plane.stretched(2.0, 2.0, 0.1), 0.0);
        let disc = "[[particle]]\nshape = { disc = { diameter = 0.1 } }\nposition = [0.5, 0.3]\n\
            density = 5.0\n";
        let limits = limits();
        let (closed, open) = (
            case(ROUND, disc),
            case(["\"periodic\"", "\"periodic\"", "\"outflow\"", "\"wall\""], disc),
        );
        // Twice 0.5 m at the speed of its fall.
        let lies = expected_rest(&closed, &limits).unwrap();
        assert!(
            (lies.from * fall_speed(&closed, &closed.particle[0]) - 1.0).abs() < 1e-12,
            "{lies:?}"
        );
        assert_eq!(expected_rest(&open, &limits), None);
    }

    #[test]
    fn step_estimate_of_stream_beside_fixed_body() {
        let pier = "[[particle]]\nshape = { disc = { diameter = 0.1 } }\nposition = [0.5, 0.3]\n\
            motion = \"fixed\"\n";
        let largest = LargestSpeed::expected(&case(
            ["{ inflow = [2.0, 0.0] }", "\"outflow\"", "\"slip\"", "\"slip\""],
            pier,
        ));
        assert_eq!(largest.map(|largest| largest.speed), Some(3.0));
        assert_eq!(LargestSpeed::expected(&case(ROUND, "")), None);
    }
}
