//! The commands that speak to a controller, against a simulated one in a process of its own.

use std::net::TcpListener;

use serde_json::Value;

use super::support::{Simulated, Workshop};

pub(super) fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn a_plan_is_uploaded_and_what_runs_is_told() {
    let workshop = Workshop::built();
    let simulated = Simulated::start(&workshop, &["--flash", "flash.bin"]);
    let to = simulated.address.as_str();
    let status = || json(&workshop.succeed(&["status", "--to", to, "--build", "build", "--json"]));
    assert_eq!((&status()["exhibit"], &status()["runs_this_build"]), (&Value::Null, &Value::from(false)));
    let none = workshop.succeed(&["status", "--to", to, "--build", "build"]);
    assert!(none.contains("stale: the controller runs no plan; `vitrine upload` sends this build"), "{none}");

    let told = json(&workshop.succeed(&["upload", "build", "--to", to, "--dry-run", "--json"]));
    assert_eq!(told["sent"], false);
    assert_eq!(status()["exhibit"], Value::Null);
    let told = json(&workshop.succeed(&["upload", "build", "--to", to, "--json"]));
    assert_eq!((&told["sent"], &told["views"]), (&Value::from(true), &Value::from(3)));
    assert_eq!(
        (&status()["exhibit"], &status()["runs_this_build"]),
        (&Value::from("Small"), &Value::from(true))
    );
    let exposure = &json(&workshop.succeed(&["status", "--exposure", "--to", to, "--json"]))["exposure"];
    assert!(exposure["films_life_dose_j_m2"].as_array().is_some_and(|films| films.len() == 8), "{exposure}");
    assert!(exposure["eye_w_m2"].as_f64().is_some_and(|eye| eye < 0.035), "{exposure}");
    let again = workshop.succeed(&["upload", "build", "--to", to]);
    assert!(again.contains("is active already"), "{again}");

    // The plan outlives the controller's power.
    drop(simulated);
    let simulated = Simulated::start(&workshop, &["--flash", "flash.bin"]);
    let text = workshop.succeed(&["status", "--to", &simulated.address, "--build", "build"]);
    assert!(text.contains("the controller runs this build"), "{text}");
    let log = workshop.succeed(&["log", "--to", &simulated.address, "--csv"]);
    assert!(log.starts_with("number,time,uptime_s,event,"), "{log}");
    assert!(log.contains("another plan is active"), "{log}");
}

#[test]
fn hold_dark_release_and_clock_reach_the_exhibit() {
    let workshop = Workshop::built();
    let simulated = Simulated::start(&workshop, &[]);
    let to = simulated.address.as_str();
    let refused = workshop.run(&["hold", "coffee", "--to", to]);
    assert_eq!(refused.code, Some(1));
    assert!(refused.stderr.contains("vitrine upload"), "{}", refused.stderr);
    workshop.succeed(&["upload", "build", "--to", to]);
    let refused = workshop.run(&["hold", "tea", "--to", to]);
    assert!(refused.stderr.contains("astronaut, coffee, cat"), "{}", refused.stderr);

    let until = |wanted: &dyn Fn(&Value) -> bool| {
        let status = || json(&workshop.succeed(&["status", "--to", to, "--json"]));
        let found = (0..100).map(|_| status()).find(|status| {
            std::thread::sleep(std::time::Duration::from_millis(100));
            wanted(status)
        });
        found.expect("the exhibit followed")
    };
    workshop.succeed(&["hold", "cat", "--for", "2m", "--to", to]);
    let held = until(&|status| status["view"] == "cat" && status["dark"].is_null());
    assert!(held["lease_s"].as_f64().unwrap() > 60.0);
    let told = workshop.succeed(&["status", "--to", to]);
    assert!(told.contains("asked for   hold, dark or open, for another 1"), "{told}");
    workshop.succeed(&["dark", "--for", "2m", "--to", to]);
    let dark = until(&|status| status["dark"] == "a host asked for dark");
    assert_eq!(dark["lamps"]["top"]["level"], 0.0);
    workshop.succeed(&["release", "--to", to]);
    until(&|status| status["dark"] != "a host asked for dark");
    workshop.succeed(&["open", "--for", "2m", "--to", to]);
    until(&|status| status["lease_s"].as_f64().is_some_and(|lease_s| lease_s > 60.0));
    workshop.succeed(&["release", "--to", to]);
    until(&|status| status["lease_s"] == 0.0);

    for dry in [&["hold", "cat"][..], &["dark"], &["release"], &["rearm"], &["new-stack"]] {
        let told = json(&workshop.succeed(&[dry, &["--dry-run", "--json", "--to", to]].concat()));
        assert_eq!(told["sent"], false, "{dry:?}");
    }
    let status = json(&workshop.succeed(&["status", "--to", to, "--json"]));
    assert_eq!((&status["lease_s"], &status["runs_this_build"]), (&Value::from(0.0), &Value::Null));
    let clock = json(&workshop.succeed(&["clock", "--set", "--dry-run", "--to", to, "--json"]));
    assert_eq!(
        (&clock["source"], &clock["set"]),
        (&Value::from("the computer that simulates it"), &Value::from(false))
    );
    let by_number = workshop.succeed(&["status", "--to", "simul"]);
    assert!(by_number.contains(to), "{by_number}");
    let unknown = workshop.run(&["status", "--to", "E661"]);
    assert!(unknown.stderr.contains("vitrine::link::no_such_serial_number"), "{}", unknown.stderr);

    let clock = json(&workshop.succeed(&["clock", "--set", "--to", to, "--json"]));
    assert_eq!((&clock["source"], &clock["set"]), (&Value::from("a host"), &Value::from(true)));
    let refused = workshop.run(&["new-stack", "--to", to]);
    assert_eq!(refused.code, Some(1));
    assert!(refused.stderr.contains("vitrine::link::unconfirmed"), "{}", refused.stderr);
    workshop.succeed(&["new-stack", "--yes", "--to", to]);
}

#[test]
fn a_plan_that_asks_for_more_is_taken_when_that_is_confirmed() {
    let workshop = Workshop::built();
    let simulated = Simulated::start(&workshop, &[]);
    let to = simulated.address.as_str();
    workshop.succeed(&["upload", "build", "--to", to]);
    let more = format!("{}[limits]\ndaily_dose_j_m2 = 20000\n", super::support::SMALL);
    workshop.write("exhibit.toml", more);
    workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
    // Nobody can be asked here whether the plan may be replaced.
    for more in [&[][..], &["--json"]] {
        let unasked = workshop.run(&[&["upload", "build", "--to", to], more].concat());
        assert_eq!(unasked.code, Some(1));
        assert!(unasked.stderr.contains("vitrine::upload::unasked"), "{}", unasked.stderr);
        assert!(unasked.stderr.contains("--yes"), "{}", unasked.stderr);
    }
    let stale = workshop.succeed(&["status", "--build", "build", "--to", to]);
    assert!(stale.contains("the controller runs another plan"), "{stale}");
    let told = json(&workshop.succeed(&["upload", "build", "--yes", "--to", to, "--json"]));
    assert_eq!((&told["sent"], &told["asks_for_more"]), (&Value::from(true), &Value::from(false)));

    let less_again = workshop.path("exhibit.toml");
    std::fs::write(less_again, super::support::SMALL).unwrap();
    workshop.succeed(&["design", "exhibit.toml", "-o", "build"]);
    let stale = workshop.succeed(&["status", "--build", "build", "--to", to]);
    assert!(stale.contains("the controller runs another plan"), "{stale}");
    let refused = workshop.run(&["upload", "build", "--yes", "--to", to]);
    assert_eq!(refused.code, Some(1));
    assert!(refused.stderr.contains("vitrine upload --allow-more"), "{}", refused.stderr);
    let told = json(&workshop.succeed(&["upload", "build", "--to", to, "--dry-run", "--json"]));
    assert_eq!((&told["sent"], &told["asks_for_more"]), (&Value::from(false), &Value::from(true)));
    let told = json(&workshop.succeed(&["upload", "build", "--yes", "--to", to, "--allow-more", "--json"]));
    assert_eq!(told["sent"], true);
}

#[test]
fn settings_are_told_changed_and_kept() {
    let workshop = Workshop::small();
    let simulated = Simulated::start(&workshop, &["--flash", "flash.bin"]);
    let to = simulated.address.as_str();
    let told = json(&workshop.succeed(&["settings", "--to", to, "--json"]));
    assert_eq!((&told["supply_divider"], &told["place"]), (&Value::from(11.0), &Value::from("")));
    let change = ["--set", "place=Hall 3", "--set", "viewer_pitch_deg=-5", "--to", to];
    let change = |more: &[&str]| workshop.run(&[&["settings"], &change[..], more].concat());
    let dry = change(&["--dry-run"]);
    assert!(dry.stdout.contains("Hall 3  (is not named until it is set)"), "{}", dry.stdout);
    let refused = change(&[]);
    assert_eq!(refused.code, Some(1));
    assert!(refused.stderr.contains("--yes"), "{}", refused.stderr);
    assert_eq!(json(&workshop.succeed(&["settings", "--to", to, "--json"]))["place"], "");
    assert_eq!(change(&["--yes"]).code, Some(0));
    let wrong = workshop.run(&["settings", "--set", "top_beta_kelvin=1", "--yes", "--to", to]);
    assert!(wrong.stderr.contains("vitrine::settings::bounds"), "{}", wrong.stderr);

    drop(simulated);
    let simulated = Simulated::start(&workshop, &["--flash", "flash.bin"]);
    let told = json(&workshop.succeed(&["settings", "--to", &simulated.address, "--json"]));
    assert_eq!((&told["place"], &told["viewer_pitch_deg"]), (&Value::from("Hall 3"), &Value::from(-5.0)));
}

#[test]
fn a_port_that_is_missing_busy_or_no_controller_is_named_with_the_remedy() {
    let workshop = Workshop::built();
    let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let missing = workshop.run(&["status", "--to", &format!("tcp:{free}")]);
    assert_eq!(missing.code, Some(1));
    assert!(
        missing.stderr.contains(&free) && missing.stderr.contains("vitrine controller"),
        "{}",
        missing.stderr
    );

    let missing = workshop.run(&["upload", "build", "--to", "/dev/ttyNONE"]);
    assert_eq!(missing.code, Some(1));
    assert!(
        missing.stderr.contains("/dev/ttyNONE") && missing.stderr.contains("help:"),
        "{}",
        missing.stderr
    );

    let stranger = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = stranger.local_addr().unwrap().to_string();
    let answers = std::thread::spawn(move || {
        for stream in stranger.incoming().take(1) {
            use std::io::{Read, Write};
            let mut stream = stream.unwrap();
            stream.write_all(b"HTTP/1.1 400 Bad Request\r\n\r\n").unwrap();
            let mut ignored = [0; 512];
            while stream.read(&mut ignored).is_ok_and(|count| count > 0) {}
        }
    });
    let no_controller = workshop.run(&["upload", "build", "--to", &format!("tcp:{place}")]);
    answers.join().unwrap();
    assert_eq!(no_controller.code, Some(1));
    assert!(no_controller.stderr.contains(&place), "{}", no_controller.stderr);
    assert!(no_controller.stderr.contains("vitrine devices"), "{}", no_controller.stderr);

    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = taken.local_addr().unwrap().to_string();
    let busy = workshop.run(&["controller", "--listen", &format!("tcp:{place}")]);
    assert_eq!(busy.code, Some(1));
    assert!(busy.stderr.contains(&place) && busy.stderr.contains("--listen"), "{}", busy.stderr);

    assert_eq!(workshop.run(&["status", "--to", "tcp:127.0.0.1:ninety"]).code, Some(2));
}

#[test]
fn a_damaged_plan_is_not_sent() {
    let workshop = Workshop::built();
    let mut plan = std::fs::read(workshop.path("build/plan.bin")).unwrap();
    plan[3] ^= 1;
    workshop.write("build/plan.bin", plan);
    let finished = workshop.run(&["upload", "build", "--to", "tcp:127.0.0.1:1"]);
    assert_eq!(finished.code, Some(1));
    assert!(
        finished.stderr.contains("plan.bin") && finished.stderr.contains("design"),
        "{}",
        finished.stderr
    );
}

#[test]
fn devices_lists_a_simulated_controller_and_it_needs_no_address() {
    let workshop = Workshop::built();
    let simulated = Simulated::start(&workshop, &[]);
    let devices = json(&workshop.succeed(&["devices", "--json"]));
    let found =
        devices.as_array().unwrap().iter().find(|device| device["port"] == simulated.address.as_str());
    assert_eq!(found.unwrap()["ready"], true);
    assert!(workshop.succeed(&["devices"]).contains(&simulated.address));
    // A machine that runs the tests may have boards of its own.
    if devices.as_array().unwrap().iter().filter(|device| device["ready"] == true).count() == 1 {
        workshop.succeed(&["upload", "build"]);
        assert!(workshop.succeed(&["status"]).starts_with("Small at tcp:"));
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_controller_withdraws_its_announcement() {
    let workshop = Workshop::built();
    let mut simulated = Simulated::start(&workshop, &[]);
    let pid = simulated.child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    assert_eq!(simulated.child.wait().unwrap().code(), Some(0));
    let devices = workshop.succeed(&["devices", "--json"]);
    assert!(!devices.contains(&simulated.address), "{devices}");
}

#[test]
fn a_self_test_prints_a_sheet_and_fails_when_a_part_does() {
    let workshop = Workshop::built();
    let simulated = Simulated::start(&workshop, &[]);
    let to = simulated.address.as_str();
    let finished = workshop.run(&["self-test", "-o", "sheet.txt", "--to", to]);
    assert_eq!(finished.code, Some(1));
    assert!(finished.stdout.contains("[ FAILED  ]  plan"), "{}", finished.stdout);
    assert!(finished.stderr.contains("vitrine::self_test::failed"), "{}", finished.stderr);
    assert_eq!(
        std::fs::read_to_string(workshop.path("sheet.txt")).unwrap().trim_end(),
        finished.stdout.trim_end()
    );
    workshop.succeed(&["self-test", "--dry-run", "--to", to]);
}
