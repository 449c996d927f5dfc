//! The JSON schema of exhibit.toml, for editors: made of the keys that reading asks for, so that it cannot differ.
//!
//! Defaults and descriptions are those of the commented exhibit.toml that `vitrine new` writes.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::load::asked_keys;
use super::reader::{AskedKey, Wanted};
use crate::starter::EXHIBIT_TOML;

/// The version of JSON Schema: the newest that editors' TOML extensions know.
const DIALECT: &str = "http://json-schema.org/draft-07/schema#";

/// The JSON schema of exhibit.toml, as draft 7.
pub fn schema() -> Value {
    // Some keys are only asked for where they are written.
    let complete = uncommented(EXHIBIT_TOML);
    let comments = comments(&complete);
    let mut tables: BTreeMap<String, Map<String, Value>> = BTreeMap::new();
    for asked in asked_keys(&complete) {
        let described = described(&asked, &comments);
        let keys = tables.entry(asked.table).or_default();
        if asked.wanted != Wanted::Special || !keys.contains_key(asked.key) {
            keys.insert(asked.key.to_owned(), described);
        }
    }
    tables.remove("exhibit.toml");
    let mut properties = Map::new();
    for (name, keys) in tables {
        let list = name.starts_with("[[");
        let required: &[&str] = match name.as_str() {
            "[[view]]" => &["id"],
            "[object]" => &["model"],
            _ => &[],
        };
        let table = json!({
            "type": "object",
            "additionalProperties": false,
            "required": required,
            "properties": keys,
        });
        let value = if list { json!({ "type": "array", "items": table }) } else { table };
        properties.insert(name.trim_matches(['[', ']']).to_owned(), value);
    }
    json!({
        "$schema": DIALECT,
        "title": "exhibit.toml of Vitrine",
        "type": "object",
        "additionalProperties": false,
        "properties": properties,
    })
}

/// The text with the examples of keys and tables in it that are commented out.
fn uncommented(text: &str) -> String {
    let example = |line: &str| {
        let Some(rest) = line.strip_prefix("# ") else { return line.to_owned() };
        let key = rest.split(" = ").next().unwrap_or_default();
        let is_key = rest.contains(" = ") && key.chars().all(|c| c.is_ascii_lowercase() || c == '_');
        let is_table = rest.starts_with('[') && rest.trim_end().ends_with(']');
        if is_key || is_table { rest.to_owned() } else { line.to_owned() }
    };
    text.lines().map(example).collect::<Vec<_>>().join("\n")
}

/// What stands behind each `key = value`, by table and key.
fn comments(text: &str) -> BTreeMap<(String, String), String> {
    let mut table = String::new();
    let mut comments = BTreeMap::new();
    for line in text.lines() {
        if line.starts_with('[') {
            table = line.trim().to_owned();
        } else if let (Some((key, _)), Some((_, comment))) = (line.split_once(" = "), line.rsplit_once("# "))
        {
            comments.entry((table.clone(), key.to_owned())).or_insert_with(|| comment.to_owned());
        }
    }
    comments
}

fn described(asked: &AskedKey, comments: &BTreeMap<(String, String), String>) -> Value {
    let mut value = match &asked.wanted {
        Wanted::Number { least, most, whole } => {
            let kind = if *whole { "integer" } else { "number" };
            json!({ "type": kind, "minimum": least, "maximum": most })
        }
        Wanted::Text => json!({ "type": "string" }),
        Wanted::Truth => json!({ "type": "boolean" }),
        Wanted::Choice(names) => json!({ "enum": names }),
        Wanted::Special => special(&asked.table, asked.key),
    };
    let comment = comments.get(&(asked.table.clone(), asked.key.to_owned()));
    if let (Some(comment), Some(object)) = (comment, value.as_object_mut()) {
        object.insert("description".to_owned(), json!(comment));
    }
    value
}

/// Keys with a form of their own. A key that is not named here may be anything, which a test forbids.
fn special(table: &str, key: &str) -> Value {
    let number_or = |word: &str| json!({ "anyOf": [{ "type": "number" }, { "const": word }] });
    let numbers = |count: usize| json!({ "type": "array", "items": { "type": "number" }, "minItems": count, "maxItems": count });
    let texts = json!({ "type": "array", "items": { "type": "string" } });
    match (table, key) {
        ("[stack]", "pixels") => {
            let side = json!({ "type": "integer", "minimum": 8, "maximum": 65_536 });
            json!({ "anyOf": [side, { "type": "array", "items": side, "minItems": 2, "maxItems": 2 }] })
        }
        (_, "distance_mm") => number_or("parallel"),
        ("[print]", "levels") => json!({ "enum": [2, 4, 16, "continuous"] }),
        ("[print]", "inks") => {
            json!({ "type": "array", "items": { "type": "string" }, "minItems": 3, "maxItems": 3 })
        }
        ("[print]", "yields" | "quench") | ("[stack]", "ink_yields") => numbers(3),
        ("[lamps]", "calibration") => json!({ "type": "array", "items": numbers(2) }),
        ("[lamps]", "ultraviolet_at_full_w_m2") => {
            json!({ "anyOf": [numbers(2), { "const": "not measured" }] })
        }
        ("[object]", "unit_mm") => number_or("fit"),
        ("[object]", "turn_deg") => numbers(3),
        ("[presence]", "expected_h_a_day") => number_or("unknown"),
        ("[calendar]", "closed") => texts,
        ("[[schedule]]", "days") => json!({ "anyOf": [{ "type": "string" }, texts] }),
        ("[[schedule]]", "from" | "to") => {
            json!({ "type": "string", "pattern": "^[0-9]{1,2}:[0-9]{1,2}(:00)?$" })
        }
        ("[[schedule]]", "first" | "last") => {
            json!({ "type": "string", "pattern": "^[0-9]{4}-[0-9]{2}-[0-9]{2}$" })
        }
        _ => json!({}),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn schema_of(table: &str) -> Value {
        let described = schema()["properties"][table].clone();
        if described["type"] == "array" { described["items"].clone() } else { described }
    }

    fn is_valid(text: &str) -> bool {
        let value: Value = toml::from_str(text).unwrap();
        jsonschema::draft7::new(&schema()).unwrap().is_valid(&value)
    }

    #[test]
    fn every_key_is_described_and_has_a_form() {
        let described = schema();
        let tables = described["properties"].as_object().unwrap();
        assert!(tables.len() >= 12, "{:?}", tables.keys());
        for table in tables.keys() {
            for (key, value) in schema_of(table)["properties"].as_object().unwrap() {
                let forms = ["type", "enum", "anyOf"];
                assert!(forms.iter().any(|form| value.get(form).is_some()), "[{table}] {key}: {value}");
            }
        }
        let brightness = &schema_of("design")["properties"]["brightness"];
        assert_eq!(brightness["maximum"], 1.0);
        assert_eq!(brightness["description"], "wanted white; more is brighter, less is truer");
    }

    #[test]
    fn what_is_read_is_valid_and_what_is_refused_is_not() {
        assert!(is_valid(EXHIBIT_TOML));
        assert!(is_valid(&uncommented(EXHIBIT_TOML)));
        let view = "[[view]]\nid = \"a\"\npattern = \"a.png\"\n";
        for right in ["", "[stack]\npixels = [64, 48]\n", "[viewer]\ndistance_mm = 600\n"] {
            assert!(is_valid(&format!("{right}{view}")), "{right}");
        }
        for wrong in [
            "[stack]\nfilm = 3\n",
            "[stack]\npixels = [64]\n",
            "[design]\nmethod = \"magic\"\n",
            "[design]\nbrightness = 2.0\n",
            "[design]\nadapt = 1\n",
            "[viewer]\ndistance_mm = \"far\"\n",
            "[[schedule]]\nfrom = \"noon\"\n",
        ] {
            assert!(!is_valid(&format!("{wrong}{view}")), "{wrong}");
        }
    }
}
