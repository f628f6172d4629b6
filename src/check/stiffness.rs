//! Whether the springs of contacts suit the impacts to be expected, and the step.

use super::layer::Layer;
use super::steps::later_step;
use crate::Result;
use crate::config::{Case, Contact, Loaded, MOST_SUBSTEPS, Substeps};
use crate::contact::{DEEPEST_OVERLAP, Impact};
use crate::numerics::CONTACT_SUBSTEPS;
use crate::scene::{Scene, impact};
use crate::words::brief;

/// Substeps in a contact below which its restitution is no longer the one asked for.
const COARSE: f64 = 20.0;
/// Substeps of a step in which two touch, and their ratio to those of the stiffness "auto", above
/// both of which a stiffness is reported as costly; where the bodies themselves ask for the
/// substeps, the limit is the product of both.
const COSTLY: [f64; 2] = [1000.0, 10.0];

/// The shortest contact (s) after a fall of a diameter, for springs whose time depends on the
/// speed; `None` without contacts.
pub(super) fn shortest<const D: usize>(scene: &Scene<D>) -> Option<f64> {
    let bodies = &scene.state.bodies;
    let pull = scene.largest_fall();
    let fall = bodies
        .iter()
        .map(|b| (4.0 * b.radius() * pull).sqrt() + b.top_speed())
        .fold(1e-12, f64::max);
    // The time is infinite where all bodies have yet to come in.
    scene
        .method
        .contacts()
        .map(|contacts| contacts.setup().contact_time(bodies, fall))
        .filter(|time| time.is_finite())
}

/// The stiffnesses that are given (N/m^exponent), with their exponents.
fn given(law: &Contact) -> impl Iterator<Item = (f64, f64)> {
    let own = law.law();
    let laws = [own].into_iter().chain(law.pair.iter().map(move |pair| pair.law(own)));
    laws.filter_map(|pair| Some((pair.normal_stiffness.given()?, pair.exponent)))
}

/// Refuses a stiffness for which a step in which two touch would need more substeps than a run
/// takes.
///
/// # Errors
/// An error of the case, with the stiffness that would do.
pub fn refuse_too_stiff<const D: usize>(loaded: &Loaded, scene: &Scene<D>) -> Result<()> {
    let case = &loaded.case;
    let (Some(law), Some(time)) = (&case.contact, shortest(scene)) else { return Ok(()) };
    let stiffest = given(law).max_by(|a, b| a.0.total_cmp(&b.0));
    let (Some((stiffness, exponent)), Substeps::Auto) = (stiffest, law.substeps) else {
        return Ok(());
    };
    let dt = later_step(case, &scene.limits()?);
    let wanted = CONTACT_SUBSTEPS * dt / time;
    if wanted <= MOST_SUBSTEPS {
        return Ok(());
    }
    let key = if law.normal_stiffness.given().is_some() {
        "contact.normal_stiffness"
    } else {
        "contact.pair"
    };
    Err(loaded.error_at(
        key,
        format!(
            "{stiffness:e} N/m^exponent is too stiff: a contact would last {time:.1e} s, and a \
            step of {dt:.1e} s in which two touch would need {wanted:.1e} substeps, where \
            {MOST_SUBSTEPS:.0e} are the most; give less, \"auto\" takes {:.1e}",
            impact(case, &scene.state.bodies).stiffness(exponent)
        ),
    ))
}

/// The time of a contact beside the substep, where steps are `dt` (s); and what is wrong with the
/// springs.
pub fn contacts<const D: usize>(case: &Case, scene: &Scene<D>, dt: f64) -> Vec<String> {
    let (Some(law), Some(time)) = (&case.contact, shortest(scene)) else { return Vec::new() };
    let Substeps::Count(n) = law.substeps else {
        let line = format!(
            "contact      shortest {time:.3e} s; substeps chosen by it, where two are in reach"
        );
        let warnings = [too_soft(case, scene, law), too_stiff(case, scene, law, dt / time)];
        return [Some(line)].into_iter().chain(warnings).flatten().collect();
    };
    let substep = dt / n as f64;
    let ratio = time * n as f64 / dt;
    let line = format!(
        "contact      shortest {time:.3e} s, substep {substep:.3e} s: {ratio:.1} substeps a contact"
    );
    let few = format!(
        "warning      {ratio:.1} substeps a contact are too few (below {COARSE}): raise \
        contact.substeps to {:.0}, or \"auto\"",
        (COARSE * dt / time).ceil()
    );
    [Some(line), too_soft(case, scene, law), (ratio < COARSE).then_some(few)]
        .into_iter()
        .flatten()
        .collect()
}

/// Warning of stiffnesses that are given and do not hold the impacts to be expected.
fn too_soft<const D: usize>(case: &Case, scene: &Scene<D>, law: &Contact) -> Option<String> {
    let bodies = &scene.state.bodies;
    let bound = impact(case, bodies);
    // The speed that a fall comes to by its drag, where that is known.
    let speed = Layer::of_bodies(case).map_or(bound.speed, |layer| layer.speed.min(bound.speed));
    let impact = Impact { speed, ..bound };
    let radius = bodies.iter().fold(0.0f64, |most, body| most.max(body.radius()));
    let depth =
        |(stiffness, exponent): (f64, f64)| (impact.depth_at(stiffness, exponent), exponent);
    let (deepest, exponent) = given(law).map(depth).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (deepest > DEEPEST_OVERLAP * radius).then(|| {
        format!(
            "warning      contact.normal_stiffness is too small: an impact at {} m/s would go \
            {deepest:.2e} m deep, {:.2} of the radius, and {} ends the run; \"auto\" takes {:.1e}",
            brief(impact.speed),
            deepest / radius,
            DEEPEST_OVERLAP,
            bound.stiffness(exponent),
        )
    })
}

/// Warning of stiffnesses that ask for many more substeps than the impacts need, or of bodies that
/// do; a step lasts as long as so many `contacts`.
fn too_stiff<const D: usize>(
    case: &Case,
    scene: &Scene<D>,
    law: &Contact,
    contacts: f64,
) -> Option<String> {
    let wanted = CONTACT_SUBSTEPS * contacts;
    let [many, over] = COSTLY;
    let Some((stiffness, exponent)) = given(law).max_by(|a, b| a.0.total_cmp(&b.0)) else {
        return (wanted > over * many).then(|| {
            format!(
                "warning      a step in which two touch takes about {wanted:.0} substeps, since \
                springs that hold the heaviest body throw the lightest off at once: bodies of like \
                weight, or a softer contact.normal_stiffness, cost less"
            )
        });
    };
    let enough = impact(case, &scene.state.bodies).stiffness(exponent);
    // A contact lasts as long as the root of its mass over its stiffness.
    let of_enough = wanted * (enough / stiffness).sqrt();
    (wanted > many && wanted > over * of_enough).then(|| {
        format!(
            "warning      contact.normal_stiffness is stiffer than the impacts ask for: a step in \
            which two touch takes {wanted:.0} substeps; \"auto\" takes {enough:.1e}, and {:.0} of \
            them",
            of_enough.max(1.0)
        )
    })
}
