//! Messages of the deserialiser in the user's words.

use super::fault::Fault;
use std::collections::BTreeSet;
use toml::de::DeValue;

/// Message of the deserialiser in the user's words: the key and what would be right; `choices` has
/// the names of which the table at a place has exactly one.
pub(super) fn reword(
    raw: &str,
    mut path: Vec<String>,
    node: &DeValue,
    choices: fn(&[String]) -> Option<Vec<String>>,
) -> Fault {
    let mut quoted = raw.split('`').skip(1).step_by(2);
    let names: Vec<_> =
        path.iter().filter(|key| key.parse::<usize>().is_err()).map(String::as_str).collect();
    let table = names.join(".");
    let last = path.last().cloned().unwrap_or_default();
    let message = if raw.starts_with("unknown ") {
        let what = if raw.starts_with("unknown field") { "key" } else { "value" };
        let unknown = quoted.next().unwrap_or_default();
        format!("unknown {what} `{unknown}`; {}", suggest(unknown, &quoted.collect::<Vec<_>>()))
    } else if raw.starts_with("missing field") {
        let missing = quoted.next().unwrap_or_default();
        let table = path.join(".");
        path.push(missing.to_owned());
        match table.as_str() {
            "" => format!("missing key `{missing}` at the top level of the file"),
            table => format!("missing key `{missing}` in [{table}]"),
        }
    } else if let (true, DeValue::String(name)) = (raw.contains("expected newtype variant"), node) {
        format!("`{name}` needs its value: write {{ {name} = ... }} instead of \"{name}\"")
    } else if raw.starts_with("expected empty") || raw.starts_with("expected table, found") {
        format!("`{last}` takes no value: write \"{last}\" instead of {{ {last} = ... }}")
    } else if raw.starts_with("wanted string or table") {
        format!("found {}, wanted a name in quotes or {{ name = ... }}", describe(node))
    } else if let (true, DeValue::Table(table)) =
        (raw.starts_with("wanted exactly 1 element"), node)
    {
        let keys: Vec<_> = table.keys().map(|key| format!("`{}`", key.get_ref())).collect();
        let found = if keys.is_empty() { "none".into() } else { keys.join(" and ") };
        let known = choices(&path).unwrap_or_default();
        // The table over time is a part of what varies.
        let within = keys.iter().any(|key| key == "`over_time`") && keys.len() > 1;
        let cure = if within {
            "; `over_time` stands within it, as in inflow = { velocity = [1.0, 0.0], over_time = \
            { ... } }"
        } else {
            ""
        };
        format!("found {found}, wanted exactly one of `{}`{cure}", known.join("`, `"))
    } else if let Some((_, wanted)) = raw.split_once(", expected ") {
        let wanted = match wanted {
            "f64" => "a number",
            "usize" | "u64" => "a whole number, 0 or more",
            "a string" => "text in quotes",
            "a boolean" => "true or false",
            "a sequence" if matches!(node, DeValue::Table(_)) => {
                &format!("a list: begin each entry with [[{table}]]")
            }
            "a sequence" => "a list in [ ]",
            other if other.starts_with("struct") => "a table of keys",
            other => other,
        };
        format!("found {}, wanted {wanted}", describe(node))
    } else {
        raw.to_owned()
    };
    Fault { key: path.join("."), message }
}

/// The known name that was probably meant, or all of them.
pub fn suggest(unknown: &str, known: &[&str]) -> String {
    let likeness = |name: &str| strsim::jaro_winkler(&unknown.to_lowercase(), name);
    match known.iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b))) {
        Some(name) if likeness(name) > 0.8 => format!("did you mean `{name}`?"),
        _ => format!(
            "known here: {}",
            known.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
        ),
    }
}

/// A value as an error message names it.
fn describe(value: &DeValue) -> String {
    match value {
        DeValue::String(text) => format!("the text \"{text}\""),
        DeValue::Integer(number) => format!("the number {number}"),
        DeValue::Float(number) => format!("the number {number}"),
        DeValue::Boolean(value) => value.to_string(),
        DeValue::Datetime(date) => format!("the date {date}"),
        DeValue::Array(_) => "a list".into(),
        DeValue::Table(_) => "a table".into(),
    }
}

/// The refusal of a name that no particle, or obstacle, has, where these are known.
pub(super) fn unnamed<'a>(
    kind: &str,
    wanted: &str,
    known: impl Iterator<Item = &'a str>,
) -> String {
    let known: Vec<&str> = known.collect::<BTreeSet<_>>().into_iter().collect();
    let cure = match &known[..] {
        [] => format!("give it one, as in name = \"pier\" in its [[{kind}]]"),
        known => suggest(wanted, known),
    };
    format!("no {kind} has the name \"{wanted}\"; {cure}")
}
