//! Draws the model: a head line, the exhibit, the last events, the keys.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, LineGauge, Paragraph, Wrap};
use vitrine_exhibit::units::Level;
use vitrine_protocol::message::LogEntry;

use crate::cli::model::{Connection, Model};
use crate::cli::rows;
use crate::cli::words;

const KEYS: &str = "1-9 hold a view   d dark   r release   a re-arm   q quit";
const SHORT_KEYS: &str = "1-9 hold d dark r release a arm q quit";
/// Fewer rows have no room for frames, nor for events.
const ROOMY: u16 = 18;
/// Columns of a row's name.
const NAME: usize = 11;

/// Draws everything.
pub(super) fn draw(frame: &mut Frame<'_>, model: &Model) {
    let area = frame.area();
    let is_roomy = area.height >= ROOMY;
    let head = head(model, is_roomy);
    let head_rows = wrapped(&head, area.width).min(4);
    let told = rows_to_show(model, !is_roomy);
    let told_rows = wrapped(&told, area.width.saturating_sub(2));
    let (exhibit_rows, event_rows) = match is_roomy {
        true => (Constraint::Max(told_rows + 4), Constraint::Min(3)),
        false => (Constraint::Min(0), Constraint::Length(0)),
    };
    let has_note = is_roomy || !model.note.is_empty();
    let foot_rows = if has_note { 2 } else { 1 };
    let rows = [Constraint::Length(head_rows), exhibit_rows, event_rows, Constraint::Length(foot_rows)];
    let [top, exhibit, events, foot] = Layout::vertical(rows).areas(area);
    frame.render_widget(Paragraph::new(head).wrap(Wrap { trim: false }), top);
    draw_exhibit(frame, exhibit, model, told, is_roomy);
    if is_roomy {
        draw_events(frame, events, model);
    }
    let keys = if usize::from(area.width) < KEYS.len() { SHORT_KEYS } else { KEYS };
    let note = has_note.then(|| Line::from(model.note.as_str()));
    let foot_lines: Vec<Line<'_>> = note.into_iter().chain([Line::from(keys).style(dim())]).collect();
    frame.render_widget(Paragraph::new(foot_lines), foot);
}

/// The rows that lines take at this width.
fn wrapped(lines: &[Line<'_>], width: u16) -> u16 {
    lines.iter().map(|line| line.width().div_ceil(usize::from(width.max(1))).max(1) as u16).sum()
}

/// What is watched, and whether it is there; `in_full` with its address and versions.
fn head(model: &Model, in_full: bool) -> Vec<Line<'_>> {
    let name = model.status.as_ref().and_then(|status| status.plan.as_ref()).map(|plan| plan.name.as_str());
    let who = match &model.who {
        Some((address, hello)) if in_full => {
            format!("{address}, {}, firmware {}", hello.serial_number, hello.firmware)
        }
        _ => String::new(),
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
    vec![title, state]
}

/// The state in words, and which key holds which view; what wants attention first, where there is room for little.
fn rows_to_show(model: &Model, alarms_first: bool) -> Vec<Line<'static>> {
    let style = if model.is_there() { Style::new() } else { dim() };
    let mut told = model.status.as_ref().map(|status| rows::rows(model, status)).unwrap_or_default();
    if alarms_first {
        told.sort_by_key(|(_, _, alarm)| !alarm);
    }
    let views = model.plan.iter().flat_map(|plan| &plan.views).take(9).enumerate();
    let keys: Vec<String> = views.map(|(index, view)| format!("{} {}", index + 1, view.id)).collect();
    if !keys.is_empty() {
        told.push(("keys", keys.join(", "), false));
    }
    let line = |(what, text, alarm): (&'static str, String, bool)| {
        let style = if alarm { style.fg(Color::Yellow) } else { style };
        Line::from(vec![Span::styled(format!("{what:<NAME$}"), dim()), Span::styled(text, style)])
    };
    told.into_iter().map(line).collect()
}

fn draw_exhibit(frame: &mut Frame<'_>, area: Rect, model: &Model, told: Vec<Line<'_>>, is_framed: bool) {
    let inner = if is_framed {
        let title = if model.is_there() { " exhibit " } else { " exhibit, as last heard " };
        let block = Block::bordered().title(title);
        let inner = block.inner(area);
        frame.render_widget(block, area);
        inner
    } else {
        area
    };
    let Some(status) = &model.status else { return };
    let rows = Layout::vertical([Constraint::Length(1), Constraint::Length(1), Constraint::Min(0)]);
    let [top, bottom, rest] = rows.areas(inner);
    draw_lamp(frame, top, "top   ", status.snapshot.levels.top);
    draw_lamp(frame, bottom, "bottom", status.snapshot.levels.bottom);
    // Where there is little room, a row that is cut hides no other.
    let told = Paragraph::new(told);
    frame.render_widget(if is_framed { told.wrap(Wrap { trim: false }) } else { told }, rest);
}

fn draw_lamp(frame: &mut Frame<'_>, area: Rect, name: &str, level: Level) {
    let ratio = f64::from(level.0) / f64::from(Level::FULL.0);
    let gauge = LineGauge::default()
        .ratio(ratio)
        .label(format!("{name} {:5.1} %", 100.0 * ratio))
        // The bar is told from the rest without colours, too.
        .filled_symbol("█")
        .unfilled_symbol("·")
        .filled_style(Style::new().fg(Color::Magenta));
    frame.render_widget(gauge, area);
}

fn draw_events(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let block = Block::bordered().title(" last events, newest first ");
    let lines: Vec<Line<'_>> = model.log.iter().rev().map(event_line).collect();
    frame.render_widget(Paragraph::new(lines).block(block), area);
}

fn event_line(entry: &LogEntry) -> Line<'static> {
    let when = words::moment(entry);
    Line::from(vec![Span::styled(format!("{when:<22}"), dim()), Span::raw(words::event(entry.event))])
}

fn dim() -> Style {
    Style::new().add_modifier(Modifier::DIM)
}

#[cfg(test)]
mod tests;
