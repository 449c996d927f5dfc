//! `vitrine schema`: what exhibit.toml and the answers of the commands look like, for editors and programs.

use clap::Args;
use miette::{Diagnostic, Report};
use serde_json::{Map, Value, json};
use thiserror::Error;
use vitrine::config::{self, closest};

use super::output::Output;

/// The answers by their commands, and what they are made of.
///
/// As JSON Schema, but shorter: an object has all of its properties except those in `optional`, and no others.
const ANSWERS: [&str; 4] = [
    include_str!("answers/design.json"),
    include_str!("answers/print.json"),
    include_str!("answers/controller.json"),
    include_str!("answers/help.json"),
];

/// The dialect of the answers' schema.
const DIALECT: &str = "https://json-schema.org/draft/2020-12/schema";

/// Print the JSON schema of exhibit.toml, by which editors complete and check it, or that of a command's answer.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine schema > exhibit.schema.json
  vitrine schema status               what `vitrine status --json` prints
  vitrine schema firmware update
  vitrine schema error                what every command prints to stderr when it fails, with --json
  vitrine schema --answers            all of these in one, by the names of the commands in \"$defs\"

`vitrine new` writes the first beside exhibit.toml, whose first line names it: editors with Taplo or Even Better TOML find it so. \
`watch`, `log --live` and `controller` print an answer a line, all others one.")]
pub(super) struct Schema {
    /// The command whose answer is described, or `error`.
    #[arg(value_name = "COMMAND", num_args = 0..=2)]
    command: Vec<String>,
    /// The answers of all commands.
    #[arg(long, conflicts_with = "command")]
    answers: bool,
}

#[derive(Debug, Error, Diagnostic)]
enum SchemaFailure {
    #[error("no command {command} answers in JSON")]
    #[diagnostic(code(vitrine::schema::no_such_answer), help("{help}"))]
    NoSuchAnswer { command: String, help: String },
}

impl Schema {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let schema = match self.command.join(" ") {
            _ if self.answers => schema_of(None, definitions()),
            command if command.is_empty() => config::schema(),
            command => answer(&command)?,
        };
        output.result(&schema, || serde_json::to_string_pretty(&schema).unwrap_or_default());
        Ok(())
    }
}

/// The schema of one command's answer, with only what it is made of.
fn answer(command: &str) -> Result<Value, SchemaFailure> {
    let all = definitions();
    if !all.contains_key(command) {
        let names: Vec<&str> = all.keys().map(String::as_str).collect();
        let help = match closest(command, &names) {
            Some(known) => format!("did you mean {known}? `vitrine schema --answers` has all"),
            None => "`vitrine schema --answers` has all".to_owned(),
        };
        return Err(SchemaFailure::NoSuchAnswer { command: command.to_owned(), help });
    }
    let mut needed = Map::new();
    let mut wanted = vec![command.to_owned()];
    while let Some(name) = wanted.pop() {
        if let Some(definition) = all.get(&name).filter(|_| !needed.contains_key(&name)) {
            references(definition, &mut wanted);
            needed.insert(name, definition.clone());
        }
    }
    Ok(schema_of(Some(command), needed))
}

fn schema_of(command: Option<&str>, definitions: Map<String, Value>) -> Value {
    let mut schema = json!({
        "$schema": DIALECT,
        "title": format!("Answers of vitrine {}", env!("CARGO_PKG_VERSION")),
        "$defs": definitions,
    });
    if let Some(command) = command {
        schema["$ref"] = reference(command).into();
    }
    schema
}

/// How a definition is referred to: RFC 6901 in a URI, where the only special characters are spaces.
fn reference(name: &str) -> String {
    format!("#/$defs/{}", name.replace(' ', "%20"))
}

/// Adds the names of the definitions that a schema refers to.
fn references(schema: &Value, names: &mut Vec<String>) {
    match schema {
        Value::Object(map) => {
            let name = map.get("$ref").and_then(Value::as_str).and_then(|to| to.strip_prefix("#/$defs/"));
            names.extend(name.map(|name| name.replace("%20", " ")));
            map.values().for_each(|value| references(value, names));
        }
        Value::Array(values) => values.iter().for_each(|value| references(value, names)),
        _ => {}
    }
}

/// All definitions, in full.
fn definitions() -> Map<String, Value> {
    let mut all = Map::new();
    for text in ANSWERS {
        // A test reads them.
        let short: Map<String, Value> = serde_json::from_str(text).unwrap_or_default();
        all.extend(short.into_iter().map(|(name, definition)| (name, in_full(definition))));
    }
    all
}

/// Writes out what the short form of a schema means.
fn in_full(schema: Value) -> Value {
    match schema {
        Value::Object(mut map) => {
            if let Some(Value::Object(properties)) = map.get("properties") {
                let optional = map.get("optional").and_then(Value::as_array).cloned().unwrap_or_default();
                let is_required = |name: &&String| !optional.contains(&Value::from(name.as_str()));
                let required: Vec<&String> = properties.keys().filter(is_required).collect();
                let required = json!(required);
                map.insert("required".to_owned(), required);
                map.insert("additionalProperties".to_owned(), false.into());
                map.remove("optional");
            }
            let full = |(name, value): (String, Value)| match value {
                Value::String(to) if name == "$ref" => (name, to.replace(' ', "%20").into()),
                value => (name, in_full(value)),
            };
            Value::Object(map.into_iter().map(full).collect())
        }
        Value::Array(values) => values.into_iter().map(in_full).collect(),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use clap::CommandFactory;

    use super::*;
    use crate::cli::Cli;

    /// The commands that do something, by their words.
    fn commands(command: &clap::Command, words: &str, found: &mut Vec<String>) {
        for inner in command.get_subcommands().filter(|inner| inner.get_name() != "help") {
            let words = format!("{words} {}", inner.get_name()).trim().to_owned();
            match inner.has_subcommands() {
                true => commands(inner, &words, found),
                false => found.push(words),
            }
        }
    }

    #[test]
    fn every_command_has_the_schema_of_its_answer() {
        let mut names = Vec::new();
        commands(&Cli::command(), "", &mut names);
        assert!(names.len() > 30, "{names:?}");
        for name in names.iter().map(String::as_str).chain(["error"]) {
            let schema = answer(name).unwrap();
            assert!(jsonschema::meta::is_valid(&schema), "{name}");
            jsonschema::validator_for(&schema).unwrap();
        }
        assert!(answer("colour").is_err());
    }

    /// What only reads; `watch` and `serve` ask a controller for what a person presses, and for nothing by themselves.
    const WITHOUT_DRY_RUN: [&str; 10] = [
        "completions",
        "devices",
        "doctor",
        "explain",
        "log",
        "materials",
        "schema",
        "serve",
        "status",
        "watch",
    ];

    #[test]
    fn all_that_writes_or_sends_runs_dry() {
        let mut names = Vec::new();
        commands(&Cli::command(), "", &mut names);
        for name in &names {
            let whole = Cli::command();
            let find = |command: &clap::Command, word: &str| command.find_subcommand(word).cloned();
            let command = name.split(' ').try_fold(whole, |command, word| find(&command, word)).unwrap();
            let runs_dry = command.get_arguments().any(|argument| argument.get_id() == "dry_run");
            assert_eq!(runs_dry, !WITHOUT_DRY_RUN.contains(&name.as_str()), "{name}");
        }
    }

    #[test]
    fn every_definition_is_used_and_every_property_described() {
        let all = definitions();
        let mut commands_and_error = vec!["error".to_owned()];
        commands(&Cli::command(), "", &mut commands_and_error);
        let mut used: Vec<String> = commands_and_error;
        all.values().for_each(|definition| references(definition, &mut used));
        let used: BTreeSet<&str> = used.iter().map(String::as_str).collect();
        assert_eq!(used, all.keys().map(String::as_str).collect());
        for (name, definition) in &all {
            assert!(definition["description"].is_string(), "{name}");
            let properties = definition.get("properties").and_then(Value::as_object);
            for (property, schema) in properties.into_iter().flatten() {
                assert!(schema["description"].is_string(), "{name}: {property}");
            }
        }
    }
}
