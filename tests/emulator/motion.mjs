// Since when the lamps' pins do the same thing period after period: a fade seen from outside.

const LAMPS = [2, 3];
const LAMP_ENABLE = 8;
// A little more than a period of the dimming, and a little more than one of its counts.
const PERIOD_NANOS = 2.1e6;
const COUNT_NANOS = 40;

export class Motion {
  constructor() {
    this.since = 0;
    this.pins = new Map(LAMPS.map((gp) => [gp, { at: 0, high: 0 }]));
  }

  note(now, gp, level) {
    if (gp === LAMP_ENABLE) this.since = now;
    const pin = this.pins.get(gp);
    if (pin === undefined) return;
    const lasted = now - pin.at;
    pin.at = now;
    // A pin that rested at its level is dimmed again.
    if (lasted > PERIOD_NANOS) this.since = now;
    if (level === 1) return;
    if (Math.abs(lasted - pin.high) > COUNT_NANOS) this.since = now;
    pin.high = lasted;
  }
}
