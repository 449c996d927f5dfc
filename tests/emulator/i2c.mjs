// The sensor bus at 400 kHz, byte by byte in time. A device is a file of 256 registers whose pointer moves on.

const BIT_NANOS = 2_500;
const BYTE_NANOS = 9 * BIT_NANOS;

export class Devices {
  constructor() {
    this.registers = new Map();
    this.selected = null;
    this.pointer = 0;
    this.expectsPointer = false;
  }

  set(address, start, bytes) {
    if (!this.registers.has(address)) this.registers.set(address, new Uint8Array(256));
    this.registers.get(address).set(bytes, start);
  }

  remove(address) {
    this.registers.delete(address);
  }

  attach(controller, clock) {
    const later = (nanos, action) => clock.createAlarm(action).schedule(nanos);
    controller.onStart = () => later(BIT_NANOS, () => controller.completeStart());
    controller.onStop = () => later(BIT_NANOS, () => controller.completeStop());
    controller.onConnect = (address, mode) =>
      later(BYTE_NANOS, () => {
        this.selected = this.registers.get(address) ?? null;
        this.expectsPointer = mode === 0;
        controller.completeConnect(this.selected !== null);
      });
    controller.onWriteByte = (value) =>
      later(BYTE_NANOS, () => {
        if (this.expectsPointer) this.pointer = value;
        else this.selected[this.pointer++ & 255] = value;
        this.expectsPointer = false;
        controller.completeWrite(true);
      });
    controller.onReadByte = () => later(BYTE_NANOS, () => controller.completeRead(this.selected[this.pointer++ & 255]));
  }
}
