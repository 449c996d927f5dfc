use vitrine_exhibit::{
    events::{DarkReason, Event},
    units::{Level, Milliseconds, UtcSeconds},
    viewer::Bearing,
};
use vitrine_protocol::{Refusal, Request, message::Chunk, plan_file};

use super::{NOW, connected, controller, plan_bytes, served};
use crate::{
    controller::{FlashFile, Pace, Viewer, serve},
    link::{Address, Client, LinkError, Progress, Stage},
};

fn upload(client: &mut Client, plan: &[u8]) {
    client.upload(plan, &mut |_| {}).expect("uploaded");
}

fn refusal(outcome: Result<(), LinkError>) -> Refusal {
    match outcome {
        Err(LinkError::Refused { refusal, .. }) => refusal,
        other => panic!("no refusal: {other:?}"),
    }
}

#[test]
fn the_controller_greets_with_its_name_and_plan() {
    let (_served, mut client) = connected();
    assert_eq!(client.hello().serial_number, "SIMULATED");
    assert_eq!(client.hello().name, "");
    upload(&mut client, &plan_bytes("Three photographs"));
    let again = Client::open(client.address()).expect("greeted");
    assert_eq!(again.hello().name, "Three photographs");
}

#[test]
fn an_uploaded_plan_is_active_and_lights_the_view_the_viewer_stands_at() {
    let (served, mut client) = connected();
    served.controller().advance(10_000);
    assert_eq!(client.status().expect("status").snapshot.dark, Some(DarkReason::NoPlan));
    let plan = plan_bytes("Three photographs");
    upload(&mut client, &plan);
    served.controller().advance(5_000);
    served.controller().set_viewer(Some(Viewer::at(Bearing::new(3_000, 500))));
    served.controller().advance(10_000);
    let status = client.status().expect("status");
    let state = status.plan.expect("a plan");
    assert_eq!((state.crc, state.length as usize), (plan_file::crc(&plan), plan.len()));
    assert_eq!((state.views, state.view_id.as_str()), (3, "right"));
    assert_eq!(status.snapshot.dark, None);
    let lamps = served.controller().lamps();
    assert_eq!((lamps.top, lamps.bottom), (Level::OFF, Level::FULL));
    assert_eq!(status.snapshot.levels, lamps);
}

#[test]
fn upload_tells_how_far_it_has_come() {
    let (_served, mut client) = connected();
    let plan = plan_bytes("Three photographs");
    let mut stages = Vec::new();
    client
        .upload(&plan, &mut |Progress { stage, done, total }| {
            assert!(done <= total && total == plan.len());
            if stages.last() != Some(&stage) {
                stages.push(stage);
            }
        })
        .expect("uploaded");
    assert_eq!(stages, [Stage::Sending, Stage::Committing, Stage::ReadingBack]);
    assert_eq!(client.read_plan().expect("read"), plan);
}

#[test]
fn a_bad_plan_is_refused_with_its_reason_and_the_old_one_stays() {
    let (_served, mut client) = connected();
    let old = plan_bytes("Old");
    upload(&mut client, &old);
    assert_eq!(refusal(client.upload(&[1; 100], &mut |_| {})), Refusal::UnreadablePlan);
    let mut buffer = [0; plan_file::MAX_PLAN_BYTES];
    let mut unfit = super::plan("Unfit");
    unfit.views.clear();
    let unfit = plan_file::encode(&unfit, &mut buffer).expect("fits");
    assert!(matches!(refusal(client.upload(unfit, &mut |_| {})), Refusal::UnfitPlan(_)));
    for length in [0, plan_file::MAX_PLAN_BYTES + 1] {
        let error = client.upload(&vec![0; length], &mut |_| {}).expect_err("refused");
        assert!(matches!(error, LinkError::PlanLength { .. }));
    }
    assert_eq!(client.read_plan().expect("read"), old);
}

#[test]
fn an_upload_while_the_lamps_fade_waits_and_succeeds() {
    let served =
        serve(controller(FlashFile::in_memory()), "127.0.0.1:0", Pace::RealTime).expect("a free port");
    let mut client = Client::open(&Address::Tcp(served.address().to_string())).expect("greeted");
    upload(&mut client, &plan_bytes("First"));
    served.controller().advance(5_000);
    served.controller().set_viewer(Some(Viewer::at(Bearing::new(3_000, 500))));
    while served.controller().lamps().bottom == Level::OFF {
        served.controller().advance(10);
    }
    let second = plan_bytes("Second");
    upload(&mut client, &second);
    assert_eq!(client.read_plan().expect("read"), second);
}

#[test]
fn a_held_view_is_shown_until_released_or_until_its_lease_ends() {
    let (served, mut client) = connected();
    assert_eq!(refusal(client.hold(0, Milliseconds(1_000))), Refusal::NoPlan);
    upload(&mut client, &plan_bytes("Three photographs"));
    assert_eq!(refusal(client.hold(3, Milliseconds(1_000))), Refusal::NoSuchView { views: 3 });
    assert!(matches!(refusal(client.hold(0, Milliseconds(0))), Refusal::Lease { .. }));
    served.controller().advance(5_000);
    client.hold(2, Milliseconds(60_000)).expect("held");
    served.controller().advance(3_000);
    assert_eq!(served.controller().lamps().bottom, Level::FULL);
    let snapshot = client.status().expect("status").snapshot;
    assert_eq!((snapshot.view, snapshot.lease), (Some(2), Milliseconds(57_010)));
    client.release().expect("released");
    served.controller().advance(10);
    assert_eq!(client.status().expect("status").snapshot.lease, Milliseconds(0));
    client.hold(2, Milliseconds(1_000)).expect("held");
    served.controller().advance(2_000);
    assert_eq!(client.status().expect("status").snapshot.lease, Milliseconds(0));
}

#[test]
fn dark_goes_dark_and_lapses() {
    let (served, mut client) = connected();
    upload(&mut client, &plan_bytes("Three photographs"));
    served.controller().advance(5_000);
    served.controller().set_viewer(Some(Viewer::at(Bearing::new(0, 500))));
    served.controller().advance(5_000);
    assert_ne!(served.controller().lamps().top, Level::OFF);
    client.dark(Milliseconds(20_000)).expect("accepted");
    served.controller().advance(5_000);
    assert_eq!(served.controller().lamps().top, Level::OFF);
    assert_eq!(client.status().expect("status").snapshot.dark, Some(DarkReason::HostRequest));
    served.controller().advance(20_000);
    assert_ne!(served.controller().lamps().top, Level::OFF);
}

#[test]
fn an_opened_door_darkens_and_only_a_rearm_lights_again() {
    let (served, mut client) = connected();
    upload(&mut client, &plan_bytes("Three photographs"));
    served.controller().advance(5_000);
    client.hold(1, Milliseconds(600_000)).expect("held");
    served.controller().advance(3_000);
    assert_ne!(served.controller().lamps().top, Level::OFF);
    served.controller().surroundings.set_door(false);
    served.controller().advance(20);
    assert_eq!(served.controller().lamps().top, Level::OFF);
    assert_eq!(client.status().expect("status").snapshot.dark, Some(DarkReason::InterlockOpen));
    served.controller().surroundings.set_door(true);
    served.controller().advance(5_000);
    assert_eq!(client.status().expect("status").snapshot.dark, Some(DarkReason::InterlockNotArmed));
    client.rearm().expect("accepted");
    served.controller().advance(3_000);
    assert_ne!(served.controller().lamps().top, Level::OFF);
}

#[test]
fn the_clock_is_read_and_set_and_remembers_its_correction() {
    let (served, mut client) = connected();
    assert_eq!(client.clock().expect("clock").now, Some(NOW));
    served.controller().advance(10_000);
    assert_eq!(client.clock().expect("clock").now, Some(UtcSeconds(NOW.0 + 10)));
    let clock = client.set_clock(UtcSeconds(NOW.0 + 7)).expect("set");
    assert_eq!((clock.now, clock.record.last_error_s), (Some(UtcSeconds(NOW.0 + 7)), Some(3)));
    let error = client.set_clock(UtcSeconds(5)).expect_err("refused");
    assert!(matches!(error, LinkError::Refused { refusal: Refusal::ImplausibleTime, .. }));
}

#[test]
fn the_log_is_read_in_order_and_in_part() {
    let (served, mut client) = connected();
    upload(&mut client, &plan_bytes("Three photographs"));
    for _ in 0..20 {
        served.controller().advance(1_000);
        client.rearm().expect("accepted");
    }
    served.controller().advance(100);
    let log = client.log(0).expect("log");
    assert!(log.len() > 20, "{log:?}");
    assert!(log.iter().map(|entry| entry.sequence).eq(1..=log.len() as u32));
    assert!(log.iter().any(|entry| entry.event == Event::PlanChanged));
    let later = client.log(10).expect("log");
    assert_eq!(later, log[9..]);
    assert_eq!(client.log(1_000_000).expect("log"), []);
}

#[test]
fn several_hosts_talk_at_once() {
    let (served, address) = served(FlashFile::in_memory());
    let hosts: Vec<_> = (0..4)
        .map(|_| {
            let address = address.clone();
            std::thread::spawn(move || {
                let mut client = Client::open(&address).expect("greeted");
                (0..50).for_each(|_| drop(client.status().expect("status")));
            })
        })
        .collect();
    for _ in 0..100 {
        served.controller().advance(10);
    }
    hosts.into_iter().for_each(|host| host.join().expect("no panic"));
}

#[test]
fn a_power_cycle_keeps_plan_log_and_doses() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("flash.bin");
    let plan = plan_bytes("Three photographs");
    let (log, life) = {
        let (served, address) = served(FlashFile::open(&path).expect("a new file"));
        let mut client = Client::open(&address).expect("greeted");
        upload(&mut client, &plan);
        served.controller().advance(5_000);
        client.hold(2, Milliseconds(600_000)).expect("held");
        served.controller().advance(60_000);
        (client.log(0).expect("log"), client.status().expect("status").snapshot.life_dose.bottom)
    };
    let (served, address) = served(FlashFile::open(&path).expect("the same file"));
    let mut client = Client::open(&address).expect("greeted");
    served.controller().advance(10);
    assert_eq!(client.hello().name, "Three photographs");
    assert_eq!(client.read_plan().expect("read"), plan);
    let again = client.log(0).expect("log");
    assert_eq!(again[..log.len()], log);
    let status = client.status().expect("status");
    assert!(life.0 > 0 && status.snapshot.life_dose.bottom >= life, "counts what was reserved");
    assert_eq!(status.snapshot.power_cycles, 2);
}

#[test]
fn an_upload_that_broke_off_is_continued_by_the_next_connection() {
    let (_served, address) = served(FlashFile::in_memory());
    let plan = plan_bytes("Three photographs");
    let mut first = Client::open(&address).expect("greeted");
    let begin = Request::BeginUpload { length: plan.len() as u32, crc: plan_file::crc(&plan) };
    first.ask(&begin).expect("begun");
    let bytes = Chunk::from_slice(&plan[..100]).expect("short");
    first.ask(&Request::UploadChunk { offset: 0, bytes }).expect("accepted");
    drop(first);
    let mut second = Client::open(&address).expect("greeted");
    while matches!(second.ask(&begin), Err(LinkError::Refused { refusal: Refusal::OtherUpload { .. }, .. })) {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let mut first_offset = None;
    second
        .upload(&plan, &mut |progress| {
            if progress.stage == Stage::Sending {
                first_offset.get_or_insert(progress.done);
            }
        })
        .expect("uploaded");
    assert_eq!(first_offset, Some(100));
    assert_eq!(second.read_plan().expect("read"), plan);
}
