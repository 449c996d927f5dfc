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
    let lines: Vec<Line<'_>> = rows::rows(model, status)
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
