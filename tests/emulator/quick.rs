//! The bench's quick core does what the emulator's interpreter does, instruction for instruction.

use serde_json::{Value, json};

use crate::bench::{Bench, LAMP_TOP, MILLISECOND, SECOND};
use crate::exhibit::neutral_on;
use crate::room::Room;
use crate::signals::Edge;

/// What a board did and is after it was started, was given a plan, was lit, and was looked at by somebody.
fn life(prepare: impl FnOnce(&mut Bench)) -> (Vec<Edge>, Value) {
    let mut bench = Bench::new();
    prepare(&mut bench);
    let (mut bench, _host) = neutral_on(bench);
    let mut room = Room::empty();
    room.person_deg = Some(10.0);
    room.live(&mut bench, SECOND);
    bench.run(123 * MILLISECOND);
    (bench.edges(), bench.call(json!({"op": "digest"}))["digest"].clone())
}

#[test]
fn the_quick_core_and_the_interpreter_come_to_the_same_in_every_bit() {
    let quick = life(|_| {});
    let interpreted = life(|bench| drop(bench.call(json!({"op": "interpret"}))));
    assert!(quick.0.iter().any(|edge| edge.pin == LAMP_TOP && edge.high), "the lamps were lit");
    assert_eq!(quick, interpreted);
}
