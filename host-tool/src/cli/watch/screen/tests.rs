use ratatui::Terminal;
use ratatui::backend::TestBackend;
use vitrine::link::{Address, Ask, LinkError, Update};
use vitrine_exhibit::events::{DarkReason, Event};
use vitrine_exhibit::interlock::InterlockState;
use vitrine_exhibit::units::{Level, Milliseconds, PerLamp, UtcSeconds};
use vitrine_exhibit::viewer::Bearing;
use vitrine_exhibit::{Presence, Snapshot};
use vitrine_protocol::message::LogEntry;
use vitrine_protocol::status::PlanState;
use vitrine_protocol::{Hello, Status};

use super::draw;
use crate::cli::model::{Key, Model};

fn address() -> Address {
    Address::Tcp("127.0.0.1:7470".into())
}

fn hello(serial_number: &str) -> Hello {
    Hello {
        version: 1,
        fingerprint: 0,
        serial_number: serial_number.try_into().expect("short"),
        firmware: "0.1.0".try_into().expect("short"),
        name: "Three photographs".try_into().expect("short"),
    }
}

fn status() -> Box<Status> {
    Box::new(Status {
        snapshot: Snapshot {
            presence: Presence::Somebody,
            bearing: Some(Bearing::new(-3_000, 500)),
            view: Some(1),
            levels: PerLamp::new(Level::FULL, Level(16_384)),
            dark: None,
            interlock: InterlockState::Armed,
            ..Snapshot::default()
        },
        plan: Some(PlanState {
            name: "Three photographs".try_into().expect("short"),
            ..PlanState::default()
        }),
        ..Status::default()
    })
}

fn entry(sequence: u32) -> LogEntry {
    LogEntry { sequence, time: Some(UtcSeconds(1_795_379_862)), uptime_s: 5, event: Event::Rearmed }
}

fn connected() -> Model {
    let mut model = Model::new();
    model.take(Update::Found(address(), hello("E660")));
    model.take(Update::Status(status()));
    model
}

fn screen(model: &Model, width: u16, height: u16) -> String {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("a terminal in memory");
    terminal.draw(|frame| draw(frame, model)).expect("drawn");
    terminal.backend().to_string()
}

#[test]
fn the_exhibit_stands_on_the_screen_in_plain_words() {
    let text = screen(&connected(), 100, 30);
    for words in [
        "Three photographs",
        "E660",
        "connected",
        "somebody is there, 30.0 deg left",
        "top    100.0 %",
        "bottom  25.0 %",
        "closed and armed",
        "q quit",
    ] {
        assert!(text.contains(words), "{words} is missing in\n{text}");
    }
}

#[test]
fn a_controller_that_is_away_is_said_to_be_and_its_last_state_stays() {
    let mut model = connected();
    model.take(Update::Lost(LinkError::Silent { address: address(), seconds: 6.0 }));
    let text = screen(&model, 100, 30);
    for words in ["away for 0 s", "does not answer", "as last heard", "somebody is there"] {
        assert!(text.contains(words), "{words} is missing in\n{text}");
    }
    assert_eq!(model.press(Key::Dark), None, "nothing is asked of a controller that is away");
    model.take(Update::Found(address(), hello("E660")));
    assert!(screen(&model, 100, 30).contains("connected"));
    assert_eq!(model.press(Key::Dark), Some(Ask::Dark(Milliseconds(3_600_000))));
}

#[test]
fn a_dark_exhibit_says_why() {
    let mut model = connected();
    let mut dark = status();
    dark.snapshot.dark = Some(DarkReason::InterlockOpen);
    dark.snapshot.interlock = InterlockState::Open;
    model.take(Update::Status(dark));
    assert!(screen(&model, 100, 30).contains("the interlock is open"));
}

#[test]
fn events_come_once_and_the_newest_first_and_another_controller_has_its_own() {
    let mut model = connected();
    model.take(Update::Logged(vec![entry(1), entry(2)]));
    model.take(Update::Logged(vec![entry(2), entry(3)]));
    assert_eq!(model.log.iter().map(|entry| entry.sequence).collect::<Vec<_>>(), [1, 2, 3]);
    assert!(screen(&model, 100, 30).contains("2026-11-22T20:37:42Z  re-armed"));
    model.take(Update::Found(address(), hello("E660")));
    assert_eq!(model.log.len(), 3);
    // Its log has begun anew.
    model.take(Update::Logged(vec![entry(1)]));
    assert_eq!(model.log.iter().map(|entry| entry.sequence).collect::<Vec<_>>(), [1]);
    let another = LogEntry { uptime_s: 77, ..entry(1) };
    model.take(Update::Logged(vec![another, entry(2)]));
    assert_eq!(model.log, [another, entry(2)]);
    model.take(Update::Found(address(), hello("OTHER")));
    assert_eq!(model.log.len(), 0);
}

#[test]
fn what_a_host_has_asked_for_is_told_with_when_it_ends() {
    let mut model = connected();
    assert!(!screen(&model, 100, 30).contains("asked for"));
    let mut asked = status();
    asked.snapshot.lease = Milliseconds(89_001);
    model.take(Update::Status(asked));
    assert!(screen(&model, 100, 30).contains("asked for  hold, dark or open, for another 90 s"));
}

#[test]
fn it_draws_on_any_size_of_screen() {
    let model = connected();
    for (width, height) in [(1, 1), (20, 5), (40, 10), (80, 24), (300, 100)] {
        screen(&model, width, height);
    }
}

#[test]
fn a_small_screen_shows_what_wants_attention_and_no_frames() {
    let mut model = connected();
    let mut dark = status();
    dark.snapshot.dark = Some(DarkReason::InterlockOpen);
    dark.snapshot.interlock = InterlockState::Open;
    model.take(Update::Status(dark));
    let text = screen(&model, 40, 10);
    for words in ["the interlock is open", "interlock  open", "bottom  25.0 %", "somebody is there", "q quit"]
    {
        assert!(text.contains(words), "{words} is missing in\n{text}");
    }
}

#[test]
fn levels_show_without_colours_and_each_key_tells_its_view() {
    let mut model = connected();
    model.take(Update::Plan(Some(Box::new(vitrine_exhibit::testing::plan()))));
    let text = screen(&model, 100, 30);
    let bottom = text.lines().find(|line| line.contains("bottom")).expect("a lamp");
    assert!(bottom.contains("█·"), "{bottom}");
    let first = &vitrine_exhibit::testing::plan().views[0].id;
    assert!(text.contains(&format!("1 {first}")), "{text}");
    assert!(text.contains(" of "), "the day's budget is missing in\n{text}");
}

#[test]
fn keys_ask_for_what_they_say() {
    let mut model = connected();
    assert_eq!(model.press(Key::View(2)), Some(Ask::Hold(2, Milliseconds(600_000))));
    assert_eq!(model.press(Key::Release), Some(Ask::Release));
    assert_eq!(model.press(Key::Rearm), Some(Ask::Rearm));
    assert_eq!(model.press(Key::Other), None);
    assert!(!model.wants_to_quit());
    assert_eq!(model.press(Key::Quit), None);
    assert!(model.wants_to_quit());
}
