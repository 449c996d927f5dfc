//! The book's commands, each chapter's in its order, in a folder of its own with a simulated controller at hand.

use std::path::{Path, PathBuf};

use super::support::{SMALL, Simulated, Workshop};

/// The chapters, by their path in the book.
fn chapters(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            chapters(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "md") {
            found.push(path);
        }
    }
}

fn book() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("book/src")
}

/// The lines of a chapter's blocks of this kind.
fn commands(text: &str, kind: &str) -> Vec<String> {
    let mut inside = false;
    let mut commands = Vec::new();
    for line in text.lines() {
        match (inside, line) {
            (false, line) if line.strip_prefix("```") == Some(kind) => inside = true,
            (true, "```") => inside = false,
            (true, command) => commands.push(command.to_owned()),
            _ => {}
        }
    }
    commands
}

/// Makes the exhibit that `vitrine new` wrote small, so that its design is quick.
pub(super) fn shrink(workshop: &Workshop, folder: &str) {
    let exhibit = format!("{folder}/exhibit.toml");
    let text = std::fs::read_to_string(workshop.path(&exhibit)).unwrap();
    let pixels = text.lines().find(|line| line.starts_with("pixels = ")).unwrap();
    let small = text.replace(pixels, "pixels = 32").replace("\"least-squares\"", "\"product\"");
    let small = small.replace("films = 20", "films = 6");
    assert_ne!(text, small);
    workshop.write(&exhibit, small);
}

#[test]
fn the_books_commands_work() {
    let mut paths = Vec::new();
    chapters(&book(), &mut paths);
    let mut run = 0;
    for path in paths {
        let commands = commands(&std::fs::read_to_string(&path).unwrap(), "sh");
        if commands.is_empty() {
            continue;
        }
        let workshop = Workshop::built();
        std::fs::create_dir(workshop.path("photos")).unwrap();
        for name in ["cat.jpg", "coffee.jpg"] {
            std::fs::copy(workshop.path(name), workshop.path("photos").join(name)).unwrap();
        }
        let simulated = Simulated::start(&workshop, &[]);
        workshop.succeed(&["upload", "build", "--to", &simulated.address]);
        workshop.succeed(&["clock", "--set", "--to", &simulated.address]);
        for command in commands {
            let mut words: Vec<&str> = command.split_whitespace().collect();
            assert_eq!(words.remove(0), "vitrine", "{}: {command}", path.display());
            let finished = workshop.run(&words);
            assert_eq!(
                finished.code,
                Some(0),
                "{}: {command}: {}{}",
                path.display(),
                finished.stdout,
                finished.stderr
            );
            run += 1;
            if words[0] == "new" {
                shrink(&workshop, words[1]);
            }
        }
    }
    assert!(run >= 30, "{run}");
    assert!(SMALL.contains("coffee"));
}

/// What runs on or takes long is not run, but the command line takes it.
#[test]
fn every_command_that_the_book_and_the_readme_name_is_one() {
    let workshop = Workshop::new();
    let mut paths = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md")];
    chapters(&book(), &mut paths);
    let mut named = std::collections::BTreeSet::new();
    for path in paths {
        let text = std::fs::read_to_string(&path).unwrap();
        let in_blocks = commands(&text, "text");
        named.extend(in_blocks.iter().filter_map(|line| line.strip_prefix("vitrine ")).map(str::to_owned));
        let spans = text.split("`vitrine ").skip(1).filter_map(|rest| rest.split_once('`'));
        let command = |span: &str| span.split_whitespace().next().map(str::to_owned);
        named.extend(spans.filter_map(|(span, _)| command(span)).filter(|word| word != "COMMAND"));
    }
    assert!(named.len() > 20, "{named:?}");
    for command in named {
        let words: Vec<&str> = command.split_whitespace().chain(["--help"]).collect();
        workshop.succeed(&words);
    }
}

#[test]
fn every_chapter_is_in_the_summary_and_every_link_leads_somewhere() {
    let mut paths = Vec::new();
    chapters(&book(), &mut paths);
    let summary = std::fs::read_to_string(book().join("SUMMARY.md")).unwrap();
    for path in &paths {
        let name = path.strip_prefix(book()).unwrap().to_str().unwrap();
        assert!(name == "SUMMARY.md" || summary.contains(&format!("({name})")), "{name}");
        let text = std::fs::read_to_string(path).unwrap();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link) {
            let there = path.parent().unwrap().join(link).exists();
            assert!(there || link.starts_with("http"), "{name}: {link}");
        }
    }
}
