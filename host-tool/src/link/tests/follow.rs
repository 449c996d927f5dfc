use std::time::{Duration, Instant};

use vitrine_exhibit::{events::DarkReason, units::Milliseconds};
use vitrine_protocol::Refusal;

use super::{plan_bytes, served};
use crate::{
    controller::{FlashFile, Pace, serve},
    link::{Address, Ask, Client, Follower, LinkError, Update},
};

/// Waits for an update that answers a question.
fn until<T>(follower: &Follower, mut wanted: impl FnMut(Update) -> Option<T>) -> T {
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(20) {
        if let Some(found) = follower.next(Duration::from_millis(100)).and_then(&mut wanted) {
            return found;
        }
    }
    panic!("nothing of the kind came")
}

#[test]
fn a_controller_that_goes_away_is_found_again_elsewhere_too() {
    let (first, address) = served(FlashFile::in_memory());
    let found = std::sync::Arc::new(std::sync::Mutex::new(address));
    let find = found.clone();
    let follower = Follower::new(move || Ok(find.lock().expect("no panic").clone()));
    until(&follower, |update| matches!(update, Update::Status(_)).then_some(()));
    let controller = first.stop();
    let lost = until(&follower, |update| match update {
        Update::Lost(error) => Some(error),
        _ => None,
    });
    assert!(lost.is_passing(), "{lost:?}");
    let second = serve(controller, "127.0.0.1:0", Pace::Manual).expect("a free port");
    let place = Address::Tcp(second.address().to_string());
    *found.lock().expect("no panic") = place.clone();
    let back = until(&follower, |update| match update {
        Update::Found(address, _) => Some(address),
        _ => None,
    });
    assert_eq!(back, place);
    until(&follower, |update| matches!(update, Update::Status(_)).then_some(()));
}

#[test]
fn what_is_asked_is_done_or_refused_and_the_log_follows() {
    let (served, address) = served(FlashFile::in_memory());
    Client::open(&address).expect("greeted").upload(&plan_bytes("Followed"), &mut |_| {}).expect("uploaded");
    let follower = Follower::new(move || Ok(address.clone()));
    until(&follower, |update| matches!(update, Update::Status(_)).then_some(()));
    served.controller().advance(3_000);
    follower.ask(Ask::Hold(9, Milliseconds(1_000)));
    let refused = until(&follower, |update| match update {
        Update::Answered(Ask::Hold(9, _), outcome) => Some(outcome),
        _ => None,
    });
    let no_such_view = Refusal::NoSuchView { views: 3 };
    assert!(matches!(refused, Err(LinkError::Refused { refusal, .. }) if refusal == no_such_view));
    follower.ask(Ask::Dark(Milliseconds(60_000)));
    until(&follower, |update| matches!(update, Update::Answered(Ask::Dark(_), Ok(()))).then_some(()));
    served.controller().advance(5_000);
    until(&follower, |update| {
        matches!(update, Update::Status(status) if status.snapshot.dark == Some(DarkReason::HostRequest))
            .then_some(())
    });
    follower.ask(Ask::Rearm);
    until(&follower, |update| matches!(update, Update::Answered(Ask::Rearm, Ok(()))).then_some(()));
    served.controller().advance(100);
    let mut last = 0;
    until(&follower, |update| {
        let Update::Logged(entries) = update else { return None };
        for entry in &entries {
            assert!(entry.sequence > last, "no entry twice");
            last = entry.sequence;
        }
        entries.iter().any(|entry| entry.event == vitrine_exhibit::events::Event::Rearmed).then_some(())
    });
}

#[test]
fn another_plan_is_told() {
    let (served, address) = served(FlashFile::in_memory());
    let upload = |name: &str| {
        served.controller().advance(3_000);
        let mut client = Client::open(&address).expect("greeted");
        client.upload(&plan_bytes(name), &mut |_| {}).expect("uploaded");
    };
    upload("First");
    let follower = Follower::new({
        let address = address.clone();
        move || Ok(address.clone())
    });
    let named = |name: &str| {
        until(&follower, |update| {
            matches!(update, Update::Plan(Some(plan)) if plan.name == name).then_some(())
        });
    };
    named("First");
    upload("Other");
    named("Other");
}
