//! `vitrine check`: validates an exhibit.toml and sums it up.

use std::path::PathBuf;

use clap::Args;
use miette::Report;
use vitrine::config::{self, Exhibit};

use super::output::Output;

/// Validate an exhibit.toml and sum it up.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  vitrine check exhibit.toml\n  vitrine check exhibit.toml --json | jq .stack"
)]
pub(super) struct Check {
    /// The file to check.
    exhibit: PathBuf,
}

impl Check {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let exhibit = config::load(&self.exhibit)?;
        output.result(&exhibit, || summary(&exhibit));
        Ok(())
    }
}

fn summary(exhibit: &Exhibit) -> String {
    let stack = &exhibit.stack;
    let [width, height] = stack.pixels;
    let depth_mm = f64::from(stack.films.saturating_sub(1)) * stack.film_pitch_mm();
    let mut lines = vec![
        exhibit.name.clone(),
        format!(
            "stack   {} films of {width} x {height} pixels, {} mm wide, {depth_mm:.1} mm deep",
            stack.films, stack.width_mm
        ),
        match exhibit.viewer.distance_mm {
            Some(distance_mm) => format!("viewer  {distance_mm} mm away"),
            None => "viewer  far away (parallel rays)".to_owned(),
        },
    ];
    for view in &exhibit.views {
        lines.push(format!(
            "view    {:<16} {:>6.1} deg horizontal {:>6.1} deg vertical  {}",
            view.id,
            view.horizontal_deg,
            view.vertical_deg,
            view.pattern.display()
        ));
    }
    lines.join("\n")
}
