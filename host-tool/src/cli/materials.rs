//! `vitrine materials`: the films and spacers that exhibit.toml may name.

use clap::Args;
use miette::Report;
use serde_json::json;
use vitrine::material::{FILMS, SPACERS};

use super::output::Output;

/// List the films and spacers that exhibit.toml may name, what they let through, and where that is from.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine materials
  vitrine materials --json

In exhibit.toml:
  [stack]
  film = \"polyester\"
  spacer = \"bonded-acrylic\"
  tau_uv = 0.9             # measured yourself: numbers go before the library's

A spacer that is bonded to the films takes away the reflections of their faces: the films then let more through.")]
pub(super) struct Materials {}

impl Materials {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let films = FILMS.iter().map(|film| {
            json!({
                "film": film.name,
                "film_mm": film.film_mm,
                "index": film.index,
                "tau_uv": film.tau_uv,
                "tau_visible": film.tau_visible,
                "source": film.source,
            })
        });
        let spacers = SPACERS.iter().map(|spacer| {
            let layer = spacer.on_film(&FILMS[0], 1.0);
            json!({
                "spacer": spacer.name,
                "index": spacer.index,
                "bonded": spacer.bonded,
                "spacer_tau_uv_of_1_mm": layer.spacer_tau_uv,
                "spacer_tau_visible_of_1_mm": layer.spacer_tau_visible,
                "tau_uv_of_polyester": layer.tau_uv,
                "tau_visible_of_polyester": layer.tau_visible,
                "source": spacer.source,
            })
        });
        let value = json!({ "films": films.collect::<Vec<_>>(), "spacers": spacers.collect::<Vec<_>>() });
        output.result(&value, text);
        Ok(())
    }
}

fn text() -> String {
    let mut text = "film            thick mm  index  tau_uv  tau_visible  from".to_owned();
    for film in &FILMS {
        text += &format!(
            "\n{:15} {:8}  {:5.3}  {:6.2}  {:11.2}  {}",
            film.name, film.film_mm, film.index, film.tau_uv, film.tau_visible, film.source
        );
    }
    text += "\n\nspacer of 1 mm            index  tau_uv  tau_visible  polyester against it: tau_uv  tau_visible  from";
    for spacer in &SPACERS {
        let layer = spacer.on_film(&FILMS[0], 1.0);
        text += &format!(
            "\n{:25} {:5.3}  {:6.3}  {:11.3}  {:28.3}  {:11.3}  {}",
            spacer.name,
            spacer.index,
            layer.spacer_tau_uv,
            layer.spacer_tau_visible,
            layer.tau_uv,
            layer.tau_visible,
            spacer.source
        );
    }
    text
}
