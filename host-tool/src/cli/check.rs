//! `vitrine check`: validates an exhibit.toml, sums it up, and predicts what its design will reach.

use std::path::{Path, PathBuf};

use clap::Args;
use miette::Report;
use vitrine::build_folder::BuildError;
use vitrine::config::{self, Exhibit};
use vitrine::object::{self, ObjectReport};
use vitrine::picture::Picture;
use vitrine::year::{Year, year};

use super::design::folder_of;
use super::frontier::{draw, try_place};
use super::outlook::Outlook;
use super::output::Output;
use super::progress::Progress;

/// Validate an exhibit.toml and sum it up: the year's calendar, the dose it may cost, how well its views
/// will show and what would show them better.
#[derive(Args)]
#[command(after_help = "\
Examples:
  vitrine check exhibit.toml
  vitrine check exhibit.toml --year 2027
  vitrine check exhibit.toml --quick
  vitrine check exhibit.toml --frontier frontier.svg
  vitrine check exhibit.toml --json | jq .exhibit.stack")]
pub(super) struct Check {
    /// The file to check.
    exhibit: PathBuf,
    /// The year whose calendar is shown; without it, this one.
    #[arg(long, value_parser = clap::value_parser!(u16).range(2025..2199))]
    year: Option<u16>,
    /// Only read the file: predict and advise nothing.
    #[arg(long)]
    quick: bool,
    /// Draw what quality costs in brightness and contrast into this SVG file, and its points as JSON beside it.
    #[arg(long, value_name = "SVG", conflicts_with = "quick")]
    frontier: Option<PathBuf>,
    /// With --frontier: try everything, and write nothing.
    #[arg(long, requires = "frontier")]
    dry_run: bool,
}

impl Check {
    pub(super) fn run(self, output: Output) -> Result<(), Report> {
        let exhibit = config::load(&self.exhibit)?;
        self.frontier.as_deref().map_or(Ok(()), try_place)?;
        let this_year = || jiff::Timestamp::now().to_zoned(jiff::tz::TimeZone::UTC).year().unsigned_abs();
        let number = self.year.unwrap_or_else(this_year);
        let calendar = exhibit.plan_calendar().map_err(BuildError::from)?;
        let year = year(&calendar, &exhibit.plan_limits(), exhibit.full_level(), number);
        if exhibit.lamps.ultraviolet_at_full_w_m2.is_none() {
            output.note(
                "note: `ultraviolet_at_full_w_m2` in [lamps] is not measured: the controller cannot tell a lamp that is \
                 too bright, lit while it should be dark, or aged",
            );
        }
        for note in coarse_pictures(&exhibit, folder_of(&self.exhibit)) {
            output.note(&note);
        }
        if year.open_h == 0.0 {
            output.note(&format!("note: the schedule lights the exhibit never in {number}"));
        }
        let foretold = !self.quick && exhibit.object.is_none();
        if !self.quick && exhibit.object.is_some() {
            output.note(
                "note: how well pictures and an object will show together is not predicted: design them, and look at the report",
            );
        }
        let object = if self.quick { None } else { sliced(&exhibit, folder_of(&self.exhibit))? };
        let outlook = if !foretold {
            None
        } else {
            let mut progress = Progress::new(output.is_json());
            Some(Outlook::of(&exhibit, &self.exhibit, self.frontier.is_some(), &mut progress)?)
        };
        let drawing = self.frontier.filter(|_| !self.dry_run);
        if let (Some(points), Some(drawing)) = (outlook.as_ref().and_then(Outlook::frontier), drawing) {
            draw(points, &drawing)?;
        }
        let result =
            serde_json::json!({ "exhibit": exhibit, "year": year, "outlook": outlook, "object": object });
        output.result(&result, || {
            let mut parts = vec![summary(&exhibit), year_summary(&exhibit, &year)];
            parts.extend(
                object.iter().flat_map(|report| [report.summary(), object::foretold(&exhibit, report)]),
            );
            parts.extend(outlook.as_ref().map(Outlook::summary));
            parts.join("\n")
        });
        Ok(())
    }
}

/// A note for each picture of less than half the films' pixels in either direction: it will look soft.
fn coarse_pictures(exhibit: &Exhibit, folder: &Path) -> Vec<String> {
    let [film_width, film_height] = exhibit.stack.pixels.map(|pixels| pixels as usize);
    let patterns = exhibit.views.iter().filter_map(|view| view.pattern.as_deref());
    let coarse = patterns.filter_map(|pattern| {
        let [width, height] = Picture::check(&folder.join(pattern)).ok()?;
        let is_coarse = 2 * width < film_width || 2 * height < film_height;
        is_coarse.then(|| {
            let pattern = pattern.display();
            format!(
                "note: {pattern} has {width} x {height} pixels, the films {film_width} x {film_height}: it will look soft"
            )
        })
    });
    coarse.collect()
}

/// What becomes of the exhibit's object, where there is one.
fn sliced(exhibit: &Exhibit, folder: &Path) -> Result<Option<ObjectReport>, Report> {
    let Some(object) = &exhibit.object else { return Ok(None) };
    let model = folder.join(&object.model);
    Ok(Some(object::slice(&model, object, &exhibit.film_stack(), &exhibit.sights())?.report))
}

fn year_summary(exhibit: &Exhibit, year: &Year) -> String {
    let mut lines = Vec::new();
    if exhibit.schedule.is_empty() && exhibit.calendar.closed.is_empty() {
        lines.push("open    at any time: there is no [[schedule]]".to_owned());
    } else {
        lines.push(format!(
            "open    {:.0} h on {} days of {}, {}",
            year.open_h, year.open_days, year.year, exhibit.calendar.time_zone
        ));
        lines.extend(year.calendar_lines().into_iter().map(|line| format!("  {line}")));
    }
    let limits = &exhibit.limits;
    let minutes = 60.0 * year.full_level_h_a_day;
    lines.push(format!(
        "dose    a lamp at full level uses the day's {:.0} kJ/m2 in {minutes:.0} minutes; then the idle glow",
        limits.daily_dose_j_m2 / 1000.0
    ));
    lines.push(format!(
        "        at most {:.2} MJ/m2 a lamp in {}, with somebody there all the time",
        year.dose_j_m2 / 1e6,
        year.year
    ));
    if let Some(hours) = exhibit.presence.expected_h_a_day {
        let kilojoules = exhibit.expected_dose_j_m2() / 1000.0;
        lines
            .push(format!("        expected {kilojoules:.1} kJ/m2 a day, with somebody there for {hours} h"));
    }
    lines.push(format!("life    {}", exhibit.life_in_words(year)));
    lines.join("\n")
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
    if let Some(object) = &exhibit.object {
        lines.push(format!("object  {}", object.model.display()));
    }
    let wide = exhibit.views.iter().map(|view| view.id.len()).fold(16, usize::max);
    for view in &exhibit.views {
        lines.push(format!(
            "view    {:<wide$} {:>6.1} deg horizontal {:>6.1} deg vertical  {}",
            view.id,
            view.horizontal_deg,
            view.vertical_deg,
            view.pattern.as_deref().map_or("the object".into(), Path::to_string_lossy)
        ));
    }
    lines.join("\n")
}
