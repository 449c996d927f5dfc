// Runs the image's code quickly: each instruction is taken apart once, and all are done in one loop that the JavaScript engine
// compiles. The emulator's own interpreter looks at an instruction's bits anew each time; it does what is left: peripherals,
// the special instructions, code in RAM and ROM, and the last cycles before an alarm.
//
// An instruction takes the interpreter's cycles, so that no pin moves at another moment than it would there.

import { ROWS, WIDE } from './thumb.mjs';

const BASE = 0x10000000;
// Boot loader and active image; what is kept for later beyond them is not run where it lies.
const CODE_BYTES = 0x6_0000;
const PLACES = CODE_BYTES / 2;
// No instruction takes more.
const LONGEST = 16;

// What was done: nothing; something, up to an instruction for the interpreter; something.
export const [NOTHING, HELP, SOME] = [0, 1, 2];

const UNKNOWN = 0;
const LEAVE = 1;
const FIRST = 2;

const MATCHES = ROWS.map(([encoding, code, number], row) => {
  const bits = (letters) => [...encoding].reduce((all, letter) => (all << 1) | (letters.includes(letter) ? 1 : 0), 0);
  const field = (letter) => [...encoding].flatMap((found, i) => (found === letter ? [15 - i] : []));
  return { kind: FIRST + row, mask: bits('01'), value: bits('1'), fields: ['d', 'n', 'm', 'i'].map(field), number, leads: code.includes('at = K') };
});
const WIDE_KIND = FIRST + ROWS.length;

// The loop: one case for each row, its operands read from what was taken apart.
const OPERANDS = { D: '(x >> 8 & 15)', N: '(x >> 12 & 15)', M: '(x >> 16 & 15)', K: 'ks[at]' };
const STOP = 'I[15] = base + at * 2; core.N = r < 0; core.Z = r === 0; core.C = C; core.V = V; m.cycles = c; m.count = k;';
const BRANCH = `if (a >= base && a < base + ${CODE_BYTES}) { at = (a - base) >> 1; continue; } ${STOP} core.BXWritePC(a >>> 0); return ${SOME};`;
const meaning = (code) =>
  code
    .replace(/\b[DNMK]\b/g, (operand) => OPERANDS[operand])
    .replaceAll('@LEAVE', `${STOP} return ${HELP};`)
    .replaceAll('@BRANCH', BRANCH);
const CASES = [...ROWS, ...WIDE].map(([, code], i) => `case ${FIRST + i}: ${meaning(code)} break;`).join('\n');
const run = new Function(
  'core', 'm', 'start', 'cycles',
  `"use strict";
  const { I, kinds, ks, ram8, ram16, ram32, flash8, flash16, flash32 } = m;
  const base = ${BASE}, limit = cycles - ${LONGEST};
  let at = start, a = 0, b = 0, o = 0, p = 0, w = 0.5, c = 0, k = 0, r = core.Z ? 0 : core.N ? -1 : 1, { C, V } = core;
  for (;;) {
    if (c > limit) { ${STOP} return k === 0 ? ${NOTHING} : ${SOME}; }
    c++;
    k++;
    const x = kinds[at];
    switch (x & 255) {
      case ${UNKNOWN}: c--; k--; m.takeApart(at); continue;
      ${CASES}
      default: c--; k--; ${STOP} return ${HELP};
    }
    at++;
  }`,
);

export class Core {
  constructor() {
    // One beyond the code is where a stray branch ends.
    this.kinds = new Int32Array(PLACES + 1).fill(UNKNOWN);
    this.kinds[PLACES] = LEAVE;
    this.ks = new Int32Array(PLACES);
    [this.cycles, this.count] = [0, 0];
  }

  // Takes the memory of a chip that starts. What was taken apart stays while the code is the same.
  attach(mcu) {
    const code = mcu.flash.subarray(0, CODE_BYTES);
    if (this.flash8 && Buffer.compare(this.flash8.subarray(0, CODE_BYTES), code) !== 0) this.kinds.fill(UNKNOWN, 0, PLACES);
    this.core = mcu.core;
    this.I = new Int32Array(mcu.core.registers.buffer);
    const [ram, flash] = [mcu.sram.buffer, mcu.flash.buffer];
    [this.ram8, this.ram16, this.ram32] = [new Uint8Array(ram), new Uint16Array(ram), new Int32Array(ram)];
    [this.flash8, this.flash16, this.flash32] = [new Uint8Array(flash), new Uint16Array(flash), new Int32Array(flash)];
  }

  // Flash changes at this offset.
  changed(offset) {
    if (offset < CODE_BYTES) this.kinds.fill(UNKNOWN, 0, PLACES);
  }

  // Runs from where the processor is, for at most so many cycles. `cycles` and `count` then tell what was done.
  run(cycles) {
    const place = (this.core.registers[15] - BASE) >>> 1;
    return place < PLACES && cycles > LONGEST ? run(this.core, this, place, cycles) : NOTHING;
  }

  takeApart(at) {
    const [first, second] = [this.flash16[at], this.flash16[at + 1]];
    const wide = WIDE.findIndex(([is]) => is(first, second));
    if (wide >= 0) return this.keep(at, WIDE_KIND + wide, [0, 0, 0], WIDE[wide][2]({ first, second, at }), wide === 0);
    const match = MATCHES.find(({ mask, value }) => (first & mask) === value);
    if (match === undefined) return (this.kinds[at] = LEAVE);
    const [d, n, m, i] = match.fields.map((places) => places.reduce((all, bit) => (all << 1) | ((first >> bit) & 1), 0));
    const word = (place) => this.flash32[place >> 1];
    const number = match.number?.({ i, at, base: BASE, word }) ?? 0;
    this.keep(at, match.kind, [d, n, m], number, match.leads);
  }

  keep(at, kind, [d, n, m], number, leads) {
    // A branch out of the code is for the interpreter.
    this.kinds[at] = leads && !(number >= 0 && number < PLACES) ? LEAVE : kind | (d << 8) | (n << 12) | (m << 16);
    this.ks[at] = number;
  }
}
