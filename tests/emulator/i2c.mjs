// The sensor bus at 400 kHz, byte by byte in time. A device is a file of 256 registers whose pointer moves on.

const BIT_NANOS = 2_500;
const BYTE_NANOS = 9 * BIT_NANOS;

const INTERRUPT_MASK = 0x30;
const RECEIVE_FULL = 1 << 2;
const TRANSMIT_EMPTY = 1 << 4;

// The emulator keeps no interrupt mask, so that a driver that waits for an interrupt waits for ever; and its FIFO
// levels are only looked at when a byte comes or goes.
function completeInterrupts(controller) {
  const write = controller.writeUint32.bind(controller);
  controller.writeUint32 = (offset, value) => {
    if (offset !== INTERRUPT_MASK) return write(offset, value);
    controller.intEnable = value & 0x1fff;
    controller.intRaw &= ~(RECEIVE_FULL | TRANSMIT_EMPTY);
    if (controller.rxFIFO.itemCount > controller.rxThreshold) controller.intRaw |= RECEIVE_FULL;
    if (controller.txFIFO.itemCount <= controller.txThreshold) controller.intRaw |= TRANSMIT_EMPTY;
    controller.checkInterrupts();
  };
}

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
    completeInterrupts(controller);
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
