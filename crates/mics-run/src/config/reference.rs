//! The key reference of the book, `docs/keys.md`: the schema of a case as Markdown.
//!
//! A section for each table of a case in the schema's order, with a row a key; after it the types
//! that its keys name, each where it is met first.

use super::Case;
use serde_json::{Map, Value};
use std::collections::HashSet;

const HEAD: &str = "# Keys of a case

This page is what `mics schema --markdown` prints, from the same descriptions that the program \
checks a case by. To make
it again: `mics schema --markdown > docs/keys.md`.

A case is a TOML file. Its tables are below, in the order in which they usually stand. A name in \
the column *type* leads
to what it stands for. Units are SI where they are named, and any consistent set works. Every key \
can be overridden on
the command line, `--set time.end=1.0`, and entries of lists by their number from 0, `--set \
particle.0.density=1200`.
[Writing a case](case.md) has most of the keys on one page.
";

/// The JSON Schema of a case, for editors.
pub fn schema() -> Value {
    schemars::schema_for!(Case).to_value()
}

/// The names of which the table at this place of a case has exactly one, if that is how it is.
pub(super) fn choices(path: &[String]) -> Option<Vec<String>> {
    let schema = schema();
    let definitions = &schema["$defs"];
    let mut here = &schema;
    for key in path {
        let entry = match key.parse::<usize>() {
            Ok(_) => &here["items"],
            Err(_) => here["properties"].get(key).or_else(|| {
                let mut all = here["oneOf"].as_array()?.iter();
                all.find_map(|choice| choice["properties"].get(key))
            })?,
        };
        here = match definition(entry).filter(|_| entry["type"] != "array") {
            Some(name) => &definitions[name],
            None => entry,
        };
    }
    let all = here["oneOf"].as_array()?;
    let names = all.iter().filter_map(|choice| choice["properties"].as_object()?.keys().next());
    Some(names.cloned().collect())
}

/// The reference as a page of Markdown.
pub fn reference() -> String {
    let schema = schema();
    let nothing = Map::new();
    let definitions = schema["$defs"].as_object().unwrap_or(&nothing);
    let tables = schema["properties"].as_object().unwrap_or(&nothing);
    let mut page = Page { definitions, done: HashSet::new(), text: HEAD.to_owned() };
    page.done.extend(tables.values().filter_map(definition));
    page.text += "\n## The top level\n\n";
    page.table(&schema, |name, value| {
        let of = if value["type"] == "array" { "list of tables" } else { "table" };
        match definition(value).filter(|_| name != "preset") {
            Some(_) => (format!("[`{}`](#{name})", heading(name, value)), of.to_owned()),
            None => plain(name, value),
        }
    });
    page.done.remove("Preset");
    page.types_of(&tables["preset"]);
    for (name, value) in tables {
        let Some(table) = definition(value).filter(|_| name != "preset") else { continue };
        let description = sentence(value);
        page.text += &format!("\n## `{}`\n\n{description}\n\n", heading(name, value));
        if let Some(given) = value.get("default").map(toml_inline).filter(|text| text != "{}") {
            page.text += &format!("Without the table: `{given}`.\n\n");
        }
        page.keys_or_choices(&definitions[table]);
        page.types_of(&definitions[table]);
    }
    page.text
}

/// The page as far as it is written.
struct Page<'a> {
    definitions: &'a Map<String, Value>,
    /// The types that have their section.
    done: HashSet<&'a str>,
    text: String,
}

impl<'a> Page<'a> {
    /// The rows of an object's keys; `begin` writes the first two cells, key and type.
    fn table(&mut self, object: &Value, begin: impl Fn(&str, &Value) -> (String, String)) {
        let Some(keys) = object["properties"].as_object() else { return };
        let required: Vec<&str> =
            object["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        self.text += "| key | type | default | what it is |\n|---|---|---|---|\n";
        for (name, value) in keys {
            let given = match value.get("default").filter(|v| !v.is_object()).map(toml_inline) {
                _ if required.contains(&name.as_str()) => "required".to_owned(),
                Some(text) => format!("`{text}`"),
                None => String::new(),
            };
            let (key, kind) = begin(name, value);
            self.text += &format!("| {key} | {kind} | {given} | {} |\n", cell(value));
        }
    }

    /// A section for each type that a schema names and that has none yet, and then for those that
    /// these name.
    fn types_of(&mut self, schema: &'a Value) {
        let mut names = Vec::new();
        named(schema, &mut names);
        for name in names {
            let Some(value) = self.definitions.get(name).filter(|_| self.done.insert(name)) else {
                continue;
            };
            if value.get("enum").is_some() {
                continue;
            }
            self.text += &format!("\n### {name}\n\n{}\n\n", sentence(value));
            self.keys_or_choices(value);
            self.types_of(value);
        }
    }

    /// The rows of a table's keys, or of the values of which it is one.
    fn keys_or_choices(&mut self, schema: &Value) {
        let Some(choices) = ["oneOf", "anyOf"].iter().find_map(|key| schema[key].as_array()) else {
            return self.table(schema, plain);
        };
        self.text += "| value | what it is |\n|---|---|\n";
        for choice in choices {
            self.text += &format!("| {} | {} |\n", kind(choice), cell(choice));
        }
    }
}

/// A key and its type, as most tables have them.
fn plain(name: &str, value: &Value) -> (String, String) {
    (format!("`{name}`"), kind(value))
}

/// Heading of a table of the top level: `[fluid]`, or `[[particle]]` where there may be several.
fn heading(name: &str, value: &Value) -> String {
    if value["type"] == "array" { format!("[[{name}]]") } else { format!("[{name}]") }
}

/// Name of the definition that a schema refers to, by itself, as a list's entries or where it may
/// be missing.
fn definition(value: &Value) -> Option<&str> {
    let direct = value["$ref"].as_str().or_else(|| value["items"]["$ref"].as_str());
    let choice = || value["anyOf"].as_array()?.iter().find_map(|choice| choice["$ref"].as_str());
    direct.or_else(choice).and_then(|path| path.rsplit('/').next())
}

/// All definitions that a schema names, in order.
fn named<'a>(value: &'a Value, names: &mut Vec<&'a str>) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                match value.as_str().filter(|_| key == "$ref") {
                    Some(path) => names.extend(path.rsplit('/').next()),
                    None => named(value, names),
                }
            }
        }
        Value::Array(list) => list.iter().for_each(|value| named(value, names)),
        _ => {}
    }
}

/// The type of a value in words, with a link where it has a section.
fn kind(value: &Value) -> String {
    if let Some(text) = value["const"].as_str() {
        return format!("`\"{text}\"`");
    }
    if let Some(keys) = value["properties"].as_object().filter(|keys| keys.len() == 1) {
        // A choice with its value: `{ inflow = ... }`.
        return keys
            .iter()
            .map(|(name, value)| format!("`{{ {name} = `{}` }}`", kind(value)))
            .collect();
    }
    if let Some(path) = value["$ref"].as_str() {
        let name = path.rsplit('/').next().unwrap_or(path);
        return match name {
            "Auto" => "`\"auto\"`".to_owned(),
            _ => format!("[{name}](#{})", name.to_lowercase()),
        };
    }
    if let Some(choices) = value["anyOf"].as_array() {
        let some = choices.iter().filter(|choice| choice["type"] != "null");
        return some.map(kind).collect::<Vec<_>>().join(" or ");
    }
    let simple = match &value["type"] {
        Value::Array(types) => types.iter().find(|name| *name != "null").and_then(Value::as_str),
        other => other.as_str(),
    };
    match simple {
        Some("number") => "number".to_owned(),
        Some("integer") => "whole number".to_owned(),
        Some("string") => "text".to_owned(),
        Some("boolean") => "true or false".to_owned(),
        Some("array") => match value["minItems"].as_u64() {
            Some(count) => format!("list of {count}: {}", kind(&value["items"])),
            None => format!("list: {}", kind(&value["items"])),
        },
        other => other.unwrap_or("anything").to_owned(),
    }
}

/// Description of a schema, on one line.
fn sentence(value: &Value) -> String {
    value["description"]
        .as_str()
        .unwrap_or_default()
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
}

/// Description of a schema, for a cell of a table.
fn cell(value: &Value) -> String {
    sentence(value).replace('|', "\\|")
}

/// A default as a case would have it.
fn toml_inline(value: &Value) -> String {
    match value {
        Value::Object(map) if map.is_empty() => "{}".to_owned(),
        Value::Object(map) => {
            let pairs: Vec<String> =
                map.iter().map(|(key, value)| format!("{key} = {}", toml_inline(value))).collect();
            format!("{{ {} }}", pairs.join(", "))
        }
        other => other.to_string(),
    }
}
