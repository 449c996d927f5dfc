//! Everything that went into a design, and what came out beside the page.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::super::manifest::Manifest;
use super::tables::table;

/// Inputs with their hashes, the resolved configuration, the version, and the other files' hashes.
pub(super) fn section(manifest: &Manifest) -> Markup {
    let configuration = serde_json::to_string_pretty(&manifest.exhibit).unwrap_or_default();
    html! {
        section aria-labelledby="inputs" {
            h2 id="inputs" { "Everything that went in" }
            p { "Vitrine " (manifest.vitrine) ", build layout " (manifest.layout) ", " (manifest.ink_bits) " bits of ink." }
            (hashes("Files read, by their BLAKE3", &manifest.inputs))
            details {
                summary { "The exhibit with every default filled in" }
                pre tabindex="0" role="region" aria-label="Resolved configuration" { (configuration) }
            }
            details {
                summary { "Files written beside this page" }
                (hashes("Files written, by their BLAKE3", &manifest.outputs))
            }
        }
    }
}

fn hashes(caption: &str, files: &BTreeMap<String, String>) -> Markup {
    html! {
        div class="files" {
            (table(caption, &["File", "BLAKE3"], html! {
                @for (name, hash) in files {
                    tr { th scope="row" { (name) } td class="hash" { (hash) } }
                }
            }))
        }
    }
}
