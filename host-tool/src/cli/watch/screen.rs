//! Draws the model: a head line, the exhibit, the last events, the keys.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, LineGauge, Paragraph, Wrap};
use vitrine_exhibit::Snapshot;
use vitrine_exhibit::units::{Lamp, Level, PerLamp};
use vitrine_protocol::Status;
use vitrine_protocol::message::LogEntry;

use super::model::{Connection, Model};
use crate::cli::clock::{source_text, time_text};
use crate::cli::words;

const KEYS: &str = "1-9 hold a view   d dark   r release   a re-arm   q quit";

/// Draws everything.
pub(super) fn draw(frame: &mut Frame<'_>, model: &Model) {
    let rows = Layout::vertical([
        Constraint::Length(2),
        Constraint::Length(15),
        Constraint::Min(3),
        Constraint::Length(2),
    ]);
    let [head, exhibit, events, foot] = rows.areas(frame.area());
    draw_head(frame, head, model);
    draw_exhibit(frame, exhibit, model);
    draw_events(frame, events, model);
    let foot_lines = vec![Line::from(model.note.as_str()), Line::from(KEYS).style(dim())];
    frame.render_widget(Paragraph::new(foot_lines), foot);
}

fn draw_head(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let name = model.status.as_ref().and_then(|status| status.plan.as_ref()).map(|plan| plan.name.as_str());
    let who = match &model.who {
        Some((address, hello)) => format!("{address}, {}, firmware {}", hello.serial_number, hello.firmware),
        None => String::new(),
    };
    let title = Line::from(vec![
        Span::styled(name.unwrap_or("no plan").to_owned(), Style::new().add_modifier(Modifier::BOLD)),
        Span::raw("  "),
        Span::styled(who, dim()),
    ]);
    let state = match &model.connection {
        Connection::Looking => Line::from("looking for the controller"),
        Connection::There => Line::from(Span::styled("connected", Style::new().fg(Color::Green))),
        Connection::Away { since, why, remedy } => {
            let remedy = remedy.as_deref().map(|remedy| format!("; {remedy}")).unwrap_or_default();
            let text = format!("away for {} s: {why}{remedy}", since.elapsed().as_secs());
            Line::from(Span::styled(text, Style::new().fg(Color::Red)))
        }
    };
    frame.render_widget(Paragraph::new(vec![title, state]), area);
}

fn draw_exhibit(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let title = if model.is_there() { " exhibit " } else { " exhibit, as last heard " };
    let block = Block::bordered().title(title);
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let Some(status) = &model.status else { return };
    let style = if model.is_there() { Style::new() } else { dim() };
    let rows = Layout::vertical([Constraint::Length(1), Constraint::Length(1), Constraint::Min(0)]);
    let [top, bottom, rest] = rows.areas(inner);
    draw_lamp(frame, top, "top   ", status.snapshot.levels.top);
    draw_lamp(frame, bottom, "bottom", status.snapshot.levels.bottom);
    let lines: Vec<Line<'_>> = exhibit_lines(model, status)
        .into_iter()
        .map(|(what, text, alarm)| {
            let style = if alarm { style.fg(Color::Yellow) } else { style };
            Line::from(vec![Span::styled(format!("{what:<11}"), dim()), Span::styled(text, style)])
        })
        .collect();
    frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: false }), rest);
}

fn draw_lamp(frame: &mut Frame<'_>, area: Rect, name: &str, level: Level) {
    let ratio = f64::from(level.0) / f64::from(Level::FULL.0);
    let gauge = LineGauge::default()
        .ratio(ratio)
        .label(format!("{name} {:5.1} %", 100.0 * ratio))
        .filled_style(Style::new().fg(Color::Magenta));
    frame.render_widget(gauge, area);
}

/// What, in words, and whether it wants attention.
fn exhibit_lines(model: &Model, status: &Status) -> Vec<(&'static str, String, bool)> {
    let snapshot = &status.snapshot;
    let place = snapshot.bearing.map(|bearing| format!(", {}", words::bearing(bearing))).unwrap_or_default();
    let lease = match snapshot.lease.0 {
        0 => String::new(),
        ms => format!(" (asked for, {} s left)", ms.div_ceil(1_000)),
    };
    let view = snapshot.view.map_or_else(|| "none".to_owned(), |view| model.view_name(view));
    let mut lines = vec![
        ("viewer", format!("{}{place}", words::presence(snapshot.presence)), false),
        ("view", format!("{view}{lease}"), false),
    ];
    if let Some(reason) = snapshot.dark {
        lines.push(("dark", reason.to_string(), true));
    }
    let cuts = cuts(snapshot);
    if !cuts.is_empty() {
        lines.push(("dimmed", cuts, true));
    }
    let armed = snapshot.interlock == vitrine_exhibit::interlock::InterlockState::Armed;
    lines.push(("interlock", words::interlock(snapshot.interlock).to_owned(), !armed));
    let boards = both(snapshot.boards, |board| match board {
        Some(board) => format!("{:.1} C", f64::from(board.0) / 100.0),
        None => "no reading".to_owned(),
    });
    lines.push(("boards", boards, snapshot.boards.top.is_none() || snapshot.boards.bottom.is_none()));
    lines.push(("dose today", both(snapshot.day_dose, |dose| kilojoules(dose.0)), false));
    lines.push(("dose, life", both(snapshot.life_dose, |dose| kilojoules(dose.0)), false));
    let clock = match status.clock.now {
        Some(now) => format!("{} from {}", time_text(now), source_text(status.clock.source)),
        None => "not known".to_owned(),
    };
    lines.push(("clock", clock, status.clock.now.is_none()));
    lines
}

fn cuts(snapshot: &Snapshot) -> String {
    let of = |lamp: Lamp| {
        snapshot.cuts.get(lamp).iter().map(move |cut| format!("{}: {}", words::lamp(lamp), words::cut(cut)))
    };
    of(Lamp::Top).chain(of(Lamp::Bottom)).collect::<Vec<_>>().join(", ")
}

fn draw_events(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let block = Block::bordered().title(" last events, newest first ");
    let lines: Vec<Line<'_>> = model.log.iter().rev().map(event_line).collect();
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

fn event_line(entry: &LogEntry) -> Line<'static> {
    let when = entry.time.map_or_else(|| format!("{} s after the start", entry.uptime_s), time_text);
    Line::from(vec![Span::styled(format!("{when:<22}"), dim()), Span::raw(words::event(entry.event))])
}

fn both<T>(pair: PerLamp<T>, text: impl Fn(T) -> String) -> String {
    let texts = pair.map(text);
    format!("top {}, bottom {}", texts.top, texts.bottom)
}

fn kilojoules(microjoules: u64) -> String {
    format!("{:.1} kJ/m2", microjoules as f64 / 1e9)
}

fn dim() -> Style {
    Style::new().add_modifier(Modifier::DIM)
}

#[cfg(test)]
mod tests;
