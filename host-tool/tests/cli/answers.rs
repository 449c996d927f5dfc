//! Holds every answer in JSON that any test makes to the schema that `vitrine schema --answers` publishes.

use std::collections::BTreeMap;
use std::process::Command;
use std::sync::LazyLock;

use jsonschema::Validator;
use serde_json::{Deserializer, Value};

use super::support::Finished;

/// A validator for each command, by its words, and for `error`.
static VALIDATORS: LazyLock<BTreeMap<String, Validator>> = LazyLock::new(|| {
    let printed = Command::new(env!("CARGO_BIN_EXE_vitrine")).args(["schema", "--answers"]).output().unwrap();
    let all: Value = serde_json::from_slice(&printed.stdout).unwrap();
    let names = all["$defs"].as_object().unwrap().keys();
    let validator = |name: &String| {
        let mut schema = all.clone();
        schema["$ref"] = format!("#/$defs/{}", name.replace(' ', "%20")).into();
        (name.clone(), jsonschema::validator_for(&schema).unwrap())
    };
    names.map(validator).collect()
});

/// Whether a command is asked for JSON.
pub(crate) fn are_wanted(arguments: &[&str]) -> bool {
    arguments.contains(&"--json")
}

/// Holds what a command has printed to the schema: answers on stdout, nothing or one error on stderr.
pub(crate) fn check(arguments: &[&str], finished: &Finished) {
    let told = documents(&finished.stdout);
    let words = |count: usize| arguments.iter().take(count).copied().collect::<Vec<_>>().join(" ");
    if let Some(validator) = VALIDATORS.get(&words(2)).or_else(|| VALIDATORS.get(&words(1))) {
        told.iter().for_each(|answer| hold(arguments, validator, answer));
    }
    let errors = documents(&finished.stderr);
    let expected = if finished.code == Some(0) { 0 } else { 1 };
    assert_eq!(errors.len(), expected, "{arguments:?}: {}", finished.stderr);
    errors.iter().for_each(|error| hold(arguments, &VALIDATORS["error"], error));
}

fn documents(text: &str) -> Vec<Value> {
    let read: Result<Vec<Value>, _> = Deserializer::from_str(text).into_iter().collect();
    read.unwrap_or_else(|error| panic!("{error}: {text}"))
}

fn hold(arguments: &[&str], validator: &Validator, answer: &Value) {
    let faults: Vec<String> =
        validator.iter_errors(answer).map(|fault| format!("{}: {fault}", fault.instance_path())).collect();
    assert!(faults.is_empty(), "{arguments:?} answers {answer:#}\n{}", faults.join("\n"));
}

#[test]
fn wrong_usage_is_told_in_json_too() {
    let workshop = super::support::Workshop::new();
    for arguments in [&["status", "--to", "tcp:", "--json"][..], &["polish", "--json"], &["view", "--json"]] {
        let finished = workshop.run(arguments);
        assert_eq!((finished.code, finished.stdout.as_str()), (Some(2), ""), "{arguments:?}");
        assert_eq!(documents(&finished.stderr)[0]["code"], "vitrine::cli::usage", "{arguments:?}");
    }
    let help = workshop.succeed(&["status", "--help"]);
    assert!(help.contains("Examples:"), "{help}");
}

#[test]
fn an_answer_that_is_not_as_published_is_found() {
    let lies = |stdout: &str, code: i32| {
        let finished = Finished { code: Some(code), stdout: stdout.to_owned(), stderr: String::new() };
        std::panic::catch_unwind(|| check(&["release", "--json"], &finished)).is_err()
    };
    assert!(!lies(r#"{"released": true, "sent": false}"#, 0));
    assert!(lies(r#"{"released": true}"#, 0), "a property is missing");
    assert!(lies(r#"{"released": true, "sent": false, "more": 1}"#, 0), "a property is not described");
    assert!(lies(r#"{"released": true, "sent": "no"}"#, 0), "a property has another type");
    assert!(lies("released", 0), "no JSON");
    assert!(lies("", 1), "no error");
}
