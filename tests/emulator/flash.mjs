// The flash chip and the boot ROM's functions that erase and program it.
//
// The emulator has no boot ROM. This one has a look-up routine and, for each function, "bkpt n; bx lr": the bench does
// the work when the processor arrives there. A power cut can be set on any step, and tears that step.

const ROM_BYTES = 16 * 1024;
const LOOK_UP = 0;
const ERASE = 3;
const PROGRAM = 4;
const COPY = 7;
const FILL = 8;
const UNKNOWN = 20;

const FUNCTIONS = { IF: 1, EX: 2, RE: ERASE, RP: PROGRAM, FC: 5, CX: 6, C4: COPY, MC: COPY, MS: FILL, S4: FILL };

// W25Q16JV: typical times of a sector erase and a page program. A sector takes 400 ms at worst.
const SECTOR_BYTES = 4096;
const SECTOR_ERASE_NANOS = 45e6;
const PAGE_BYTES = 256;
const PAGE_PROGRAM_NANOS = 0.4e6;

export class PowerCut extends Error {}

const entry = (n) => 0x100 + n * 4;

export function bootRom() {
  const rom = new Uint8Array(ROM_BYTES);
  const view = new DataView(rom.buffer);
  rom.set([0x4d, 0x75, 0x01, 0x03], 0x10);
  view.setUint16(0x14, 0x80, true);
  view.setUint16(0x16, 0x90, true);
  view.setUint16(0x18, entry(LOOK_UP) | 1, true);
  for (let n = 0; n < 64; n++) {
    view.setUint16(entry(n), 0xbe00 | n, true);
    view.setUint16(entry(n) + 2, 0x4770, true);
  }
  return new Uint32Array(rom.buffer);
}

export class FlashChip {
  // `changed` hears where every step begins, `erases` where an erase does.
  constructor(changed, erases) {
    [this.changed, this.erases] = [changed, erases];
    this.bytes = new Uint8Array(2 * 1024 * 1024).fill(0xff);
    this.eraseNanos = SECTOR_ERASE_NANOS;
    this.steps = 0;
    this.cut = null;
    this.log = [];
  }

  // Cuts the power at the step with this number, counted from now; `part` (0 to 1) of it is done, in this order.
  setCut(step, part, order) {
    this.cut = { step: this.steps + step, part, order };
  }

  // Does what a ROM function does; tells how long it takes.
  call(mcu, n) {
    const [r0, r1, r2] = [0, 1, 2].map((i) => mcu.core.registers[i] >>> 0);
    switch (n) {
      case LOOK_UP: {
        const code = String.fromCharCode(r1 & 255, (r1 >> 8) & 255);
        mcu.core.registers[0] = entry(FUNCTIONS[code] ?? UNKNOWN) | 1;
        return 0;
      }
      case ERASE: {
        this.erases(r0);
        this.step(r0, r1, (at) => 0xff);
        return (r1 / SECTOR_BYTES) * this.eraseNanos;
      }
      case PROGRAM: {
        const data = Uint8Array.from({ length: r2 }, (_, i) => mcu.readUint8(r1 + i));
        this.step(r0, r2, (at) => this.bytes[at] & data[at - r0]);
        return (r2 / PAGE_BYTES) * PAGE_PROGRAM_NANOS;
      }
      case COPY:
        for (let i = 0; i < r2; i++) mcu.writeUint8(r0 + i, mcu.readUint8(r1 + i));
        return 0;
      case FILL:
        for (let i = 0; i < r2; i++) mcu.writeUint8(r0 + i, r1 & 255);
        return 0;
      case UNKNOWN:
        throw new Error('the image called a ROM function that the bench does not have');
      default:
        return 0;
    }
  }

  step(start, length, value) {
    this.steps++;
    this.changed(start);
    this.log.push({ start, length });
    const torn = this.cut !== null && this.steps === this.cut.step;
    const places = Array.from({ length }, (_, i) => start + i);
    if (torn && this.cut.order === 'falling') places.reverse();
    if (torn && this.cut.order === 'shuffled') shuffle(places);
    const done = torn ? Math.floor(length * this.cut.part) : length;
    for (const at of places.slice(0, done)) this.bytes[at] = value(at);
    if (torn) {
      this.cut = null;
      throw new PowerCut();
    }
  }
}

// Fisher-Yates over a fixed linear congruential sequence: the same tear every time.
function shuffle(places) {
  let state = 1;
  for (let i = places.length - 1; i > 0; i--) {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    const j = state % (i + 1);
    [places[i], places[j]] = [places[j], places[i]];
  }
}
