// The simulated time. The emulator's own clock loses alarms: cancelling one that is not the next drops all before it.

class Alarm {
  constructor(clock, callback) {
    this.clock = clock;
    this.callback = callback;
    this.nanos = 0;
    this.scheduled = false;
  }

  schedule(deltaNanos) {
    this.cancel();
    this.nanos = this.clock.nanos + deltaNanos;
    this.scheduled = true;
    const { alarms } = this.clock;
    let place = alarms.length;
    // The next alarm stands last, where it is cheap to take; of two at one time, the first scheduled goes first.
    while (place > 0 && alarms[place - 1].nanos <= this.nanos) place--;
    alarms.splice(place, 0, this);
  }

  cancel() {
    if (!this.scheduled) return;
    this.scheduled = false;
    this.clock.alarms.splice(this.clock.alarms.indexOf(this), 1);
  }
}

export class Clock {
  constructor() {
    this.frequency = 125e6;
    this.nanos = 0;
    this.alarms = [];
  }

  get micros() {
    return this.nanos / 1000;
  }

  get nanosToNextAlarm() {
    const { alarms } = this;
    return alarms.length ? Math.max(alarms[alarms.length - 1].nanos - this.nanos, 0) : Infinity;
  }

  createAlarm(callback) {
    return new Alarm(this, callback);
  }

  // The same as `tick`, for the many short steps in which no alarm comes.
  advance(deltaNanos) {
    const { alarms } = this;
    const target = this.nanos + deltaNanos;
    if (alarms.length !== 0 && alarms[alarms.length - 1].nanos <= target) this.tick(deltaNanos);
    else this.nanos = target;
  }

  tick(deltaNanos) {
    const target = this.nanos + deltaNanos;
    const { alarms } = this;
    while (alarms.length && alarms[alarms.length - 1].nanos <= target) {
      const alarm = alarms.pop();
      alarm.scheduled = false;
      this.nanos = Math.max(this.nanos, alarm.nanos);
      alarm.callback();
    }
    this.nanos = target;
  }
}
