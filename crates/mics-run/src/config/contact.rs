//! Contacts of bodies with each other and with walls: `[contact]`, and the contact law of each pair
//! of materials by it.

use super::{Case, Obstacle, Particle};
use crate::config::fault::{Check, Fault, Within, not_negative, positive};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The name of the boundaries' material.
pub const WALL: &str = "wall";
/// Most substeps of one step: more is a mistake in the stiffness.
pub const MOST_SUBSTEPS: f64 = 1e6;

/// The least restitution: a thousandth of the speed.
const LEAST_RESTITUTION: f64 = 1e-3;

/// The restitution where neither it nor a damping is given.
const RESTITUTION: f64 = 0.5;

/// Default height of asperities, as a part of the smallest radius.
const ROUGHNESS: f64 = 2e-4;

/// Bodies that touch: springs with friction and loss, of all materials unless a `pair` says
/// otherwise.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Normal stiffness (N/m^exponent), positive, or "auto", the default: the fastest expected
    /// impact stops within 1 % of the smallest diameter.
    #[serde(default)]
    pub normal_stiffness: Stiffness,
    /// Height of asperities (m), zero or positive: lubrication sees no narrower gap. Default 2e-4
    /// of the smallest radius, as of polished beads.
    pub roughness: Option<f64>,
    /// Power of the overlap in the normal force, 1 (linear) to 3; 1.5 is Hertz's.
    #[serde(default = "linear")]
    pub exponent: f64,
    /// Tangential over normal stiffness, zero or positive.
    #[serde(default = "two_sevenths")]
    pub tangential_ratio: f64,
    /// Coulomb's coefficient of friction, zero or positive.
    #[serde(default)]
    pub friction: f64,
    /// Resistance to rolling: lever of the normal force over the reduced radius (Ai et al. 2011,
    /// elastic-plastic spring and dashpot); zero or positive. It needs friction.
    #[serde(default)]
    pub rolling_friction: f64,
    /// Speed after over speed before a normal impact, from 0.001 to 1; default 0.5 without
    /// `damping`.
    pub restitution: Option<f64>,
    /// Dashpots instead of a restitution.
    pub damping: Option<Damping>,
    /// Contact steps in a step of the fluid.
    #[serde(default)]
    pub substeps: Substeps,
    /// The sign of the tangential dashpot.
    #[serde(default)]
    pub tangential_damping: TangentialDamping,
    /// Pairs of materials whose contact law differs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pair: Vec<Pair>,
}

/// Dashpots of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Damping {
    /// Along the normal (N s/m), zero or positive.
    pub normal: f64,
    /// In the plane of contact (N s/m), zero or positive.
    pub tangential: f64,
}

/// A normal spring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a stiffness is \"auto\" or a number (N/m^exponent)")]
pub enum Stiffness {
    /// By the expected impacts.
    #[default]
    #[serde(serialize_with = "write_auto", deserialize_with = "read_auto")]
    #[schemars(with = "Auto")]
    Auto,
    /// This one (N/m^exponent).
    Given(f64),
}

impl Stiffness {
    /// The number, where one is given.
    pub fn given(self) -> Option<f64> {
        if let Stiffness::Given(stiffness) = self { Some(stiffness) } else { None }
    }
}

/// Contact steps in a step of the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "contact steps in a step of the fluid are \"auto\" or a whole number, 1 or more"
)]
pub enum Substeps {
    /// As many as the contact time needs.
    #[default]
    #[serde(serialize_with = "write_auto", deserialize_with = "read_auto")]
    #[schemars(with = "Auto")]
    Auto,
    /// This number of steps, 1 or more.
    Count(u64),
}

#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Auto {
    Auto,
}

fn write_auto<S: Serializer>(serializer: S) -> Result<S::Ok, S::Error> {
    Auto::Auto.serialize(serializer)
}

fn read_auto<'de, D: Deserializer<'de>>(deserializer: D) -> Result<(), D::Error> {
    Auto::deserialize(deserializer).map(|_| ())
}

/// A law of contact between two materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairLaw {
    /// Normal force over overlap^exponent (N/m^exponent), or automatic: by the expected impacts.
    pub normal_stiffness: Stiffness,
    /// Power of the overlap in the normal force.
    pub exponent: f64,
    /// Tangential over normal stiffness.
    pub tangential_ratio: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Resistance to rolling: lever of the normal force over the reduced radius.
    pub rolling_friction: f64,
    /// Loss of energy.
    pub loss: Loss,
}

/// Loss of energy in a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Loss {
    /// Speed after over speed before a normal impact.
    Restitution(f64),
    /// Dashpots.
    Damping(Damping),
}

/// The loss of energy by the keys that are given, if any.
fn loss(restitution: Option<f64>, damping: Option<Damping>) -> Option<Loss> {
    restitution.map(Loss::Restitution).or(damping.map(Loss::Damping))
}

/// The sign of the tangential dashpot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TangentialDamping {
    /// Against the sliding.
    #[default]
    Dissipative,
    /// As eq. (22) is printed: along the sliding, which feeds energy.
    Printed,
}

/// Contact law of two materials; the other keys are those of `[contact]`.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pair {
    /// Two materials in any order: a particle's, `default` (particles without one), or `wall`.
    pub between: Vec<String>,
    /// Normal spring (N/m^exponent).
    pub normal_stiffness: Option<f64>,
    /// Power of the overlap in the normal force.
    pub exponent: Option<f64>,
    /// Tangential over normal stiffness.
    pub tangential_ratio: Option<f64>,
    /// Coefficient of friction.
    pub friction: Option<f64>,
    /// Resistance to rolling.
    pub rolling_friction: Option<f64>,
    /// Speed after over speed before a normal impact.
    pub restitution: Option<f64>,
    /// Dashpots instead of a restitution.
    pub damping: Option<Damping>,
}

fn linear() -> f64 {
    1.0
}

fn two_sevenths() -> f64 {
    2.0 / 7.0
}

/// Checks the materials of the laws between pairs, once all bodies of the case are listed.
pub(in crate::config) fn pairs(case: &Case) -> Check {
    case.contact.as_ref().map_or(Ok(()), |contact| contact.check_pairs(case).within("contact"))
}

impl Contact {
    /// Fills in the keys that are not given, of a case whose smallest particle has this diameter
    /// (m).
    pub(in crate::config) fn fill(&mut self, smallest: f64) {
        self.roughness.get_or_insert(0.5 * ROUGHNESS * smallest);
        if self.damping.is_none() {
            self.restitution.get_or_insert(RESTITUTION);
        }
    }

    /// Height of the asperities (m) of a case that has been read.
    pub fn roughness(&self) -> f64 {
        self.roughness.unwrap_or(0.0)
    }

    /// Contact law of all materials that are in no pair.
    pub fn law(&self) -> PairLaw {
        PairLaw {
            normal_stiffness: self.normal_stiffness,
            exponent: self.exponent,
            tangential_ratio: self.tangential_ratio,
            friction: self.friction,
            rolling_friction: self.rolling_friction,
            loss: loss(self.restitution, self.damping).unwrap_or(Loss::Restitution(RESTITUTION)),
        }
    }

    /// Contact law of materials `a` and `b` ([`Particle::material`], [`WALL`]), in either order.
    pub fn between(&self, a: &str, b: &str) -> PairLaw {
        let law = self.law();
        self.pair.iter().find(|pair| pair.is_of(a, b)).map_or(law, |pair| pair.law(law))
    }

    pub(super) fn check(&self) -> Check {
        let law = Pair {
            between: Vec::new(),
            normal_stiffness: self.normal_stiffness.given(),
            exponent: Some(self.exponent),
            tangential_ratio: Some(self.tangential_ratio),
            friction: Some(self.friction),
            rolling_friction: Some(self.rolling_friction),
            restitution: self.restitution,
            damping: self.damping,
        };
        law.check_numbers()?;
        not_negative("roughness", self.roughness.unwrap_or(0.0), "m")?;
        let key = "substeps";
        if let Substeps::Count(count) = self.substeps {
            let most = MOST_SUBSTEPS as u64;
            ensure!(
                (1..=most).contains(&count),
                key,
                "must be \"auto\" or a whole number from 1 to {most}, not {count}"
            );
        }
        for (index, pair) in self.pair.iter().enumerate() {
            let key = format!("pair.{index}");
            pair.materials().within(&key)?;
            pair.check_numbers().within(&key)?;
        }
        Ok(())
    }

    /// Checks that the materials of pairs are those of bodies or walls: once all bodies are listed,
    /// also those that another run brings along.
    fn check_pairs(&self, case: &Case) -> Check {
        let listed = case.particle.iter().map(Particle::material);
        let of_swarms = case.swarm.iter().filter_map(|swarm| swarm.material.as_deref());
        let mut known: Vec<&str> = listed.chain(of_swarms).collect();
        let bodies_of_wall = known.contains(&WALL);
        known.extend([WALL, Particle::DEFAULT_MATERIAL]);
        known.extend(case.obstacle.iter().map(Obstacle::material));
        known.sort_unstable();
        known.dedup();
        for (index, pair) in self.pair.iter().enumerate() {
            let key = format!("pair.{index}.between");
            let [a, b] = pair.materials().within(format_args!("pair.{index}"))?;
            for (end, name) in pair.between.iter().enumerate() {
                let names =
                    known.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
                let holds = known.contains(&name.as_str());
                ensure!(
                    holds,
                    format!("{key}.{end}"),
                    "nothing is of the material \"{name}\"; known here: {names}"
                );
            }
            let holds = bodies_of_wall || [a, b] != [WALL, WALL];
            ensure!(holds, key, "walls do not meet each other: name the material of a particle");
            let earlier = self.pair[..index].iter().position(|other| other.is_of(a, b));
            let message = |other| {
                format!("contact.pair.{other} is of these two already: put all their keys into one")
            };
            ensure!(earlier.is_none(), key, "{}", message(earlier.unwrap_or_default()));
        }
        Ok(())
    }
}

impl Pair {
    /// Its contact law; keys that are not given are those of `law`.
    pub fn law(&self, law: PairLaw) -> PairLaw {
        PairLaw {
            normal_stiffness: self.normal_stiffness.map_or(law.normal_stiffness, Stiffness::Given),
            exponent: self.exponent.unwrap_or(law.exponent),
            tangential_ratio: self.tangential_ratio.unwrap_or(law.tangential_ratio),
            friction: self.friction.unwrap_or(law.friction),
            rolling_friction: self.rolling_friction.unwrap_or(law.rolling_friction),
            loss: loss(self.restitution, self.damping).unwrap_or(law.loss),
        }
    }

    /// The names of the two materials that it is of.
    pub(in crate::config) fn materials(&self) -> Result<[&str; 2], Fault> {
        let names: Vec<&str> = self.between.iter().map(String::as_str).collect();
        let count = names.len();
        let message =
            format!("needs the names of 2 materials, as in [\"steel\", \"{WALL}\"], not {count}");
        names.try_into().map_err(|_| Fault { key: "between".to_owned(), message })
    }

    fn is_of(&self, a: &str, b: &str) -> bool {
        matches!(&self.between[..], [c, d] if (c == a && d == b) || (c == b && d == a))
    }

    fn check_numbers(&self) -> Check {
        positive("normal_stiffness", self.normal_stiffness, "N/m^exponent")?;
        if let Some(exponent) = self.exponent {
            ensure!(
                (1.0..=3.0).contains(&exponent),
                "exponent",
                "must be from 1 to 3, not {exponent:?}"
            );
        }
        not_negative(
            "tangential_ratio",
            self.tangential_ratio,
            "tangential over normal stiffness",
        )?;
        not_negative("friction", self.friction, "a coefficient, such as 0.4")?;
        not_negative(
            "rolling_friction",
            self.rolling_friction,
            "a lever over a radius, such as 0.1",
        )?;
        let lever = self.rolling_friction.unwrap_or(0.0);
        let holds = lever <= 1.0;
        ensure!(
            holds,
            "rolling_friction",
            "no lever is longer than the radius: it must be at most 1, not {lever:?}"
        );
        let one = self.restitution.is_none() || self.damping.is_none();
        ensure!(one, "damping", "restitution and damping exclude each other: remove one of them");
        if let Some(restitution) = self.restitution {
            let holds = (LEAST_RESTITUTION..=1.0).contains(&restitution);
            let why =
                "of less nothing would be seen, and friction could not follow so stiff a dashpot";
            ensure!(
                holds,
                "restitution",
                "must be at least {LEAST_RESTITUTION} and at most 1, not {restitution:?}: {why}"
            );
        }
        if let Some(Damping { normal, tangential }) = self.damping {
            not_negative("damping.normal", normal, "N s/m")?;
            not_negative("damping.tangential", tangential, "N s/m")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contact(keys: &str) -> Contact {
        toml::from_str(&format!("normal_stiffness = 1e5\n{keys}")).unwrap()
    }

    #[test]
    fn substeps_auto_or_number() {
        assert_eq!(contact("").substeps, Substeps::Auto);
        assert_eq!(contact("substeps = \"auto\"").substeps, Substeps::Auto);
        assert_eq!(contact("substeps = 40").substeps, Substeps::Count(40));
    }

    fn filled(keys: &str) -> Contact {
        let mut contact = contact(keys);
        contact.fill(0.1);
        contact
    }

    #[test]
    fn contact_law_without_pairs_has_table_defaults() {
        let expected = PairLaw {
            normal_stiffness: Stiffness::Given(1e5),
            exponent: 1.0,
            tangential_ratio: 2.0 / 7.0,
            friction: 0.0,
            rolling_friction: 0.0,
            loss: Loss::Restitution(0.5),
        };
        assert_eq!(filled("").between("steel", WALL), expected);
    }

    #[test]
    fn contact_pair_overrides_its_keys_only() {
        let contact = filled(
            "damping = { normal = 1.0, tangential = 2.0 }\nfriction = 0.1\n\
            pair = [{ between = [\"steel\", \"wall\"], friction = 0.4, restitution = 0.9 }]",
        );
        let pair = contact.between(WALL, "steel");
        let rest = contact.between("steel", "steel");
        assert_eq!((pair.friction, pair.loss), (0.4, Loss::Restitution(0.9)));
        assert_eq!(pair, contact.between("steel", WALL));
        assert_eq!(
            (rest.friction, rest.loss),
            (0.1, Loss::Damping(Damping { normal: 1.0, tangential: 2.0 }))
        );
        assert_eq!(pair.normal_stiffness, rest.normal_stiffness);
    }
}
