// The bench: an emulated board behind a line protocol. One JSON object a line goes in and one comes out.
//
//   node bench.mjs IMAGE.elf [BOOTLOADER.elf]
//
// In: {"op": "run", "ns": 1000000, ...}. Out: {"now": ..., ...} or {"error": "..."}. All times are simulated nanoseconds.

import fs from 'node:fs';
import readline from 'node:readline';
import { Board } from './board.mjs';
import { Elf } from './elf.mjs';

const [image, bootloader] = process.argv.slice(2).map((path) => new Elf(fs.readFileSync(path)));
const board = new Board(image, bootloader);
const hex = (bytes) => Buffer.from(bytes).toString('hex');
const unhex = (text) => Buffer.from(text, 'hex');

let saved = null;

const operations = {
  power_on: () => board.powerOn(),
  power_off: () => board.powerOff(),
  run: ({ ns }) => board.run(board.now + ns),
  pin: ({ gp, high }) => board.setInput(gp, high),
  analog: ({ channel, value }) => board.setAnalog(channel, value),
  i2c: ({ address, start, bytes }) => board.devices.set(address, start, unhex(bytes)),
  i2c_remove: ({ address }) => board.devices.remove(address),
  edges: () => ({ edges: board.edges.splice(0) }),
  sums: ({ gps }) => ({ sums: board.sum(gps).map(({ rises, high }) => [rises, high]) }),
  levels: ({ gps }) => ({ levels: gps.map((gp) => board.isHigh(gp)) }),
  resets: () => ({ resets: board.resets.splice(0) }),
  listen: async () => ({ port: await board.usb.listen() }),
  usb: () => ({ connected_at: board.usb.connectedAt }),
  usb_write: ({ bytes }) => void board.usb.toDevice.push(...unhex(bytes)),
  usb_pending: () => ({ bytes: board.usb.toDevice.length }),
  usb_read: () => ({ bytes: hex(board.usb.fromDevice.splice(0)) }),
  usb_reading: ({ reading }) => board.usb.setReading(reading),
  usb_terminal: ({ ready }) => board.usb.setTerminalReady(ready),
  serial_write: ({ bytes }) => void board.serial.toDevice.push(...unhex(bytes)),
  serial_read: () => ({ bytes: hex(board.serial.fromDevice.splice(0)) }),
  radar_write: ({ bytes }) => void board.radar.toDevice.push(...unhex(bytes)),
  step_instructions: () => ({ counts: board.steps.counts.splice(0) }),
  log: () => ({ bytes: hex(board.logged.splice(0)) }),
  interpret: () => void (board.isQuick = false),
  digest: () => ({ digest: board.digest() }),
  stack: () => board.stackPeak(),
  paint_stack: () => board.paintStack(board.mcu, board.mcu.core.SP & ~3),
  flash: ({ start, length }) => ({ bytes: hex(board.flash.bytes.subarray(start, start + length)) }),
  flash_write: ({ start, bytes }) => void board.flash.bytes.set(unhex(bytes), start),
  flash_steps: () => ({ steps: board.flash.steps, log: board.flash.log.splice(0) }),
  erase_time: ({ ns }) => void (board.flash.eraseNanos = ns),
  erases: () => ({ erases: board.erases.splice(0) }),
  flash_save: () => void (saved = board.flash.bytes.slice()),
  flash_restore: () => void board.flash.bytes.set(saved),
  cut: ({ step, part, order }) => board.flash.setCut(step, part, order),
  poke: ({ symbol, value }) => board.mcu.writeUint32(address(symbol), value),
  peek: ({ symbol }) => ({ value: board.mcu.readUint32(address(symbol)) }),
  trip,
};

const LAMP_ENABLE = 8;

function address(symbol) {
  const at = board.symbols.get(symbol);
  if (at === undefined) throw new Error(`the image has no symbol ${symbol}`);
  return at;
}

// Changes an input after a while and runs until all of `gps` are low; says when each last fell after the change.
async function trip({ gp, high, after, limit, gps }) {
  let changedAt = null;
  let wasLit = false;
  const change = board.clock.createAlarm(() => {
    changedAt = board.now;
    wasLit = gps.every((pin) => pin !== LAMP_ENABLE || board.isHigh(pin));
    board.setInput(gp, high);
  });
  change.schedule(after);
  const allLow = () => changedAt !== null && gps.every((pin) => !board.isHigh(pin));
  const { cut } = await board.run(board.now + after + limit, allLow);
  const dark = allLow();
  const fellAt = gps.map((pin) => board.edges.findLast(([at, which, level]) => which === pin && level === 0 && at >= changedAt)?.[0] ?? changedAt);
  return { cut, dark, was_lit: wasLit, changed_at: changedAt, latencies: fellAt.map((at) => at - changedAt) };
}

for await (const line of readline.createInterface({ input: process.stdin })) {
  let answer;
  try {
    const { op, ...parameters } = JSON.parse(line);
    if (!Object.hasOwn(operations, op)) throw new Error(`no operation ${op}`);
    answer = { now: board.now, ...(await operations[op](parameters)) };
    answer.now = board.now;
  } catch (error) {
    answer = { error: String(error?.stack ?? error) };
  }
  process.stdout.write(JSON.stringify(answer) + '\n');
}
process.exit(0);
