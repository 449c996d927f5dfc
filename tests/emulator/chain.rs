//! The whole chain with the real command: photographs to a build, the build to the board, the board to its pins.

use std::fs;
use std::path::Path;
use std::process::Command;

use tempfile::TempDir;
use vitrine_exhibit::duty;
use vitrine_protocol::plan_file;

use crate::bench::{Bench, LAMP_BOTTOM, LAMP_TOP, MILLISECOND, SECOND, vitrine_command, workspace};
use crate::room::{Room, battery_clock};
use crate::signals;

/// Small, so that it is designed in a moment.
const EXHIBIT: &str = r#"
[exhibit]
name = "Bench"

[stack]
films = 4
pixels = 32

[[view]]
id = "left"
pattern = "astronaut.jpg"
horizontal_deg = -30.0

[[view]]
id = "right"
pattern = "coffee.jpg"
horizontal_deg = 30.0
"#;

fn design(folder: &Path) -> String {
    for photo in ["astronaut.jpg", "coffee.jpg"] {
        fs::copy(workspace().join("host-tool/photos").join(photo), folder.join(photo)).expect("a photograph");
    }
    fs::write(folder.join("exhibit.toml"), EXHIBIT).expect("a file");
    let build = folder.join("build");
    let designed = Command::new(vitrine_command())
        .args(["design", "exhibit.toml", "-o", "build"])
        .current_dir(folder)
        .output()
        .expect("the command starts");
    assert!(designed.status.success(), "{}", String::from_utf8_lossy(&designed.stderr));
    build.to_str().expect("a plain path").to_owned()
}

#[test]
fn photographs_become_lamp_levels_at_the_pins() {
    let folder = TempDir::new().expect("a folder");
    let build = design(folder.path());
    let plan =
        plan_file::decode(&fs::read(Path::new(&build).join("plan.bin")).expect("a plan")).expect("a plan");

    let mut bench = Bench::new();
    battery_clock(&mut bench);
    bench.power_on();
    let mut room = Room::empty();
    room.live(&mut bench, 100 * MILLISECOND);
    let address = bench.listen();
    bench.vitrine(&["upload", &build, "--to", &address]);
    let told = bench.vitrine(&["status", "--build", &build, "--to", &address]);
    assert!(told.contains("the controller runs this build"), "{told}");

    room.live(&mut bench, 5 * SECOND);
    for view in &plan.views {
        room.person_deg = Some(f64::from(view.horizontal.0) / 100.0);
        room.live(&mut bench, 5 * SECOND);
        bench.edges();
        bench.run(50 * MILLISECOND);
        let (edges, now) = (bench.edges(), bench.now);
        let lamps = [
            (LAMP_TOP, &plan.lamps.top, view.emphasis.top),
            (LAMP_BOTTOM, &plan.lamps.bottom, view.emphasis.bottom),
        ];
        for (pin, lamp, level) in lamps {
            let wanted = f64::from(duty::counts(lamp, level)) / f64::from(duty::PWM_FULL);
            let measured = signals::duty(&edges, pin, now, 10, wanted > 0.5);
            assert!(
                (measured - wanted).abs() < 0.005,
                "{}, GP{pin}: {measured} instead of {wanted}",
                view.id
            );
        }
    }

    bench.power_off();
    bench.power_on();
    let told = bench.vitrine(&["status", "--build", &build, "--to", &address]);
    assert!(told.contains("the controller runs this build"), "after a power cut: {told}");
}
