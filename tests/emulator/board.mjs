// The board: an emulated RP2040 with the image in its flash, and what is wired to it. Power can go and come back.

import { createHash } from 'node:crypto';
import { ConsoleLogger, BasePeripheral, LogLevel, RP2040, GPIOPinState } from 'rp2040js';
import { Clock } from './clock.mjs';
import { Core, HELP, NOTHING } from './core.mjs';
import { bootRom, FlashChip, PowerCut } from './flash.mjs';
import { Devices } from './i2c.mjs';
import { Motion } from './motion.mjs';
import { SerialPort } from './serial.mjs';
import { UsbHost } from './usb.mjs';

const NANOS_A_CYCLE = 8;
// How often wires are served.
const SERVE_NANOS = 200_000;
// The lamps' pins, the bench image's step and the beginning of its end, the status LED.
const STEP_PIN = 16;
const WATCHED = [2, 3, 8, STEP_PIN, 17, 25];
const INPUTS = [1, 6, 7, 9, 10, 11, 21];
const STACK_PAINT = 0xc5;
const HARD_FAULT = 3;

// The flash chip's own serial number, read by command 0x4b: four bytes that do not count, then the number.
const READ_UNIQUE_ID = 0x4b;
const UNIQUE_ID = [0xe6, 0x61, 0x64, 0x08, 0x43, 0x1f, 0x2a, 0x29];
const DATA_REGISTER = 0x60;
const STATUS_REGISTER = 0x28;
const TRANSMIT_READY = 0x06;
const RECEIVED = 0x08;

function answerUniqueId(serial) {
  const [read, write] = [serial.readUint32.bind(serial), serial.writeUint32.bind(serial)];
  let answer = [];
  serial.writeUint32 = (offset, value) => {
    // The library reads in the mode that clocks in what follows the command without further writes.
    if (offset === DATA_REGISTER && (value & 0xff) === READ_UNIQUE_ID) answer = [0, 0, 0, 0, ...UNIQUE_ID];
    else write(offset, value);
  };
  serial.readUint32 = (offset) => {
    if (offset === STATUS_REGISTER && answer.length) return TRANSMIT_READY | RECEIVED;
    if (offset === DATA_REGISTER && answer.length) return answer.shift();
    return read(offset);
  };
}

const turn = () => new Promise((resolve) => setImmediate(resolve));

class Sum {
  constructor(now, isHigh) {
    [this.rises, this.high, this.since] = [0, 0, isHigh ? now : null];
  }

  note(now, level) {
    if (level === 1 && this.since === null) [this.since, this.rises] = [now, this.rises + 1];
    if (level === 0 && this.since !== null) [this.high, this.since] = [this.high + now - this.since, null];
  }

  take(now) {
    if (this.since !== null) [this.high, this.since] = [this.high + now - this.since, now];
    const { rises, high } = this;
    [this.rises, this.high] = [0, 0];
    return { rises, high };
  }
}

// Not in the emulator: its registers read zero, or a flash write would wait for ever.
class XipControl extends BasePeripheral {
  readUint32() {
    return 0;
  }
  writeUint32() {}
  writeUint32Atomic() {}
}

// Where the boot loader's vector table lies, to which the chip comes after the second stage.
const BOOT_LOADER = 0x10000100;

export class Board {
  // With a boot loader, what the flash holds beside it is the test's business; without one, the firmware is started directly.
  constructor(elf, bootloader = null) {
    this.written = bootloader ?? elf;
    this.symbols = elf.symbols();
    this.table = bootloader ? BOOT_LOADER : this.symbols.get('__vector_table');
    this.core = new Core();
    // Without it, the emulator's interpreter does all.
    this.isQuick = true;
    this.motion = new Motion();
    this.erases = [];
    this.flash = new FlashChip(
      (offset) => this.core.changed(offset),
      (offset) => this.erases.push([offset, this.now - this.motion.since])
    );
    this.devices = new Devices();
    this.usb = new UsbHost();
    this.inputs = new Map(INPUTS.map((gp) => [gp, true]));
    this.analog = [2048, 2048, 0, 0, 0];
    this.edges = [];
    // Rises and nanoseconds high of the pins that are summed instead of kept edge by edge, and when each rose last.
    this.sums = null;
    this.resets = [];
    this.serial = new SerialPort();
    this.radar = new SerialPort();
    this.steps = { running: false, now: 0, counts: [] };
    this.logged = [];
    this.past = 0;
    this.mcu = null;
  }

  // Simulated nanoseconds since the bench began, over all starts.
  get now() {
    return this.past + (this.mcu ? this.clock.nanos : 0);
  }

  powerOn() {
    for (const segment of this.written.flashSegments()) this.flash.bytes.set(segment.bytes, segment.offset);
    this.start(null);
  }

  powerOff() {
    if (!this.mcu) return;
    this.past = this.now;
    this.mcu = null;
    for (const gp of WATCHED) this.note(gp, 0);
  }

  // `kept` is what survives a reset of the chip: RAM and the watchdog's registers; nothing after a power cut.
  start(kept) {
    if (this.mcu) this.powerOff();
    this.clock = new Clock();
    const mcu = new RP2040(this.clock);
    mcu.logger = new ConsoleLogger(LogLevel.Error, false);
    // The emulator would blank the 16 MiB that it has room for at each start: most of what a start costs.
    mcu.flash.fill = () => mcu.flash;
    mcu.loadBootrom(bootRom());
    mcu.flash.set(this.flash.bytes);
    // One array for chip and processor: a write by the ROM's functions is seen by both.
    this.flash.bytes = mcu.flash.subarray(0, this.flash.bytes.length);
    mcu.peripherals[0x14000] = new XipControl(mcu, 'XIP_CTRL');
    answerUniqueId(mcu.peripherals[0x18000]);
    mcu.onBreak = (n) => this.onBreak(n);
    const watchdog = mcu.peripherals[0x40058];
    watchdog.onWatchdogTrigger = () => {
      // The emulator's alarm would fire again at the same moment, for ever.
      watchdog.alarm.enable = false;
      this.resetPending = true;
    };
    this.resetPending = false;
    if (kept) {
      mcu.sram.set(kept.sram);
      watchdog.scratchData.set(kept.scratch);
      watchdog.reason = kept.reason;
    } else {
      this.paintStack(mcu);
    }
    this.mcu = mcu;
    this.core.attach(mcu);
    this.attach(mcu);
    mcu.core.VTOR = this.table;
    mcu.core.SP = mcu.readUint32(this.table);
    mcu.core.PC = mcu.readUint32(this.table + 4) & ~1;
  }

  attach(mcu) {
    for (const gp of WATCHED) mcu.gpio[gp].addListener((state) => this.note(gp, state === GPIOPinState.High ? 1 : 0));
    for (const [gp, high] of this.inputs) mcu.gpio[gp].setInputValue(high);
    this.analog.forEach((value, channel) => (mcu.adc.channelValues[channel] = value));
    this.devices.attach(mcu.i2c[0], this.clock);
    this.usb.attach(mcu, this.clock);
    this.serial.attach(mcu, mcu.uart[0], this.clock);
    this.radar.attach(mcu, mcu.uart[1], this.clock);
    mcu.gpio[STEP_PIN].addListener((state) => this.countStep(state === GPIOPinState.High));
    this.steps.running = false;
  }

  // Paints the stack below what is in use of it.
  paintStack(mcu, end = this.symbols.get('_stack_start')) {
    mcu.sram.fill(STACK_PAINT, this.symbols.get('_stack_end') - 0x20000000, end - 0x20000000);
  }

  // One number for all that the program has in memory and the processor in its registers.
  digest() {
    const { sram, core } = this.mcu;
    const flags = [core.N, core.Z, core.C, core.V, core.PM].map(Number);
    return createHash('sha256').update(sram).update(this.flash.bytes).update(core.registers).update(Uint8Array.from(flags)).digest('hex');
  }

  // The most bytes of stack used since it was painted: when the power came, or later.
  stackPeak() {
    const [bottom, top] = [this.symbols.get('_stack_end') - 0x20000000, this.symbols.get('_stack_start') - 0x20000000];
    let at = bottom;
    while (at < top && this.mcu.sram[at] === STACK_PAINT) at++;
    return { used: top - at, of: top - bottom };
  }

  // Counts the instructions of each step of the state, on the bench image.
  countStep(begins) {
    const { steps } = this;
    if (!begins && steps.running) steps.counts.push(steps.now);
    [steps.running, steps.now] = [begins, 0];
  }

  note(gp, level) {
    this.motion.note(this.now, gp, level);
    if (this.sums === null) this.edges.push([this.now, gp, level]);
    else this.sums.get(gp)?.note(this.now, level);
  }

  // From now on, sums what these pins do; gives the sums since the last call.
  sum(gps) {
    const sums = gps.map((gp) => this.sums?.get(gp)?.take(this.now) ?? { rises: 0, high: 0 });
    this.sums ??= new Map(gps.map((gp) => [gp, new Sum(this.now, this.isHigh(gp))]));
    return sums;
  }

  isHigh(gp) {
    return this.mcu !== null && this.mcu.gpio[gp].value === GPIOPinState.High;
  }

  setInput(gp, high) {
    this.inputs.set(gp, high);
    this.mcu?.gpio[gp].setInputValue(high);
  }

  setAnalog(channel, value) {
    this.analog[channel] = value;
    if (this.mcu) this.mcu.adc.channelValues[channel] = value;
  }

  onBreak(n) {
    const { core } = this.mcu;
    if (core.PC < 0x4000) this.clock.tick(this.flash.call(this.mcu, n));
    // What the processor does with an undefined instruction or a breakpoint without a debugger.
    else core.exceptionEntry(HARD_FAULT);
  }

  resetByWatchdog() {
    const watchdog = this.mcu.peripherals[0x40058];
    this.drainLog();
    this.resets.push({ at: this.now, reason: watchdog.reason });
    this.start({ sram: this.mcu.sram, scratch: watchdog.scratchData, reason: watchdog.reason });
  }

  // Runs until a moment of the simulated time, or until `stop` holds. Says whether the power was cut on the way.
  async run(until, stop = null) {
    if (!this.mcu) return { cut: true };
    // A host that has just come is let in.
    if (this.usb.server) await turn();
    try {
      while (this.now < until && !stop?.()) {
        this.runStretch(Math.min(until, this.now + SERVE_NANOS), stop);
        if (this.resetPending) this.resetByWatchdog();
        await this.serve();
      }
    } catch (error) {
      if (!(error instanceof PowerCut)) throw error;
      this.powerOff();
      return { cut: true };
    }
    await this.serve();
    return { cut: false };
  }

  // The innermost loop: nearly all of the bench's time is spent here.
  runStretch(until, stop) {
    const { clock, steps, core: quick } = this;
    const { core } = this.mcu;
    const end = until - this.past;
    while (clock.nanos < end && !this.resetPending) {
      if (core.waiting) clock.tick(Math.min(Math.max(clock.nanosToNextAlarm, 1), end - clock.nanos));
      else {
        // Nothing that comes from outside may fall within what is run at once.
        const free = Math.ceil(Math.min(end - clock.nanos, clock.nanosToNextAlarm) / NANOS_A_CYCLE);
        const ran = this.isQuick && !core.interruptsUpdated ? quick.run(free) : NOTHING;
        if (ran !== NOTHING) {
          if (steps.running) steps.now += quick.count;
          clock.nanos += quick.cycles * NANOS_A_CYCLE;
        }
        if (ran === NOTHING || ran === HELP) {
          if (steps.running) steps.now++;
          clock.advance(core.executeInstruction() * NANOS_A_CYCLE);
        }
      }
      if (stop !== null && stop()) return;
    }
  }

  async serve() {
    this.usb.pump();
    this.serial.pump();
    this.radar.pump();
    this.drainLog();
    if (this.usb.socket) await turn();
  }

  // Takes the defmt frames out of the RTT buffer, as a probe would.
  drainLog() {
    const { mcu } = this;
    const channel = this.symbols.get('_SEGGER_RTT') + 24;
    const [buffer, size, write, read] = [4, 8, 12, 16].map((at) => mcu.readUint32(channel + at));
    if (buffer < 0x20000000 || size === 0 || size > 65536) return;
    let at = read;
    for (; at !== write; at = (at + 1) % size) this.logged.push(mcu.readUint8(buffer + at));
    if (at !== read) mcu.writeUint32(channel + 16, at);
  }
}
