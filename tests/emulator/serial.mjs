// A serial port's other end, byte by byte in time.
//
// The emulator's UART raises its transmit interrupt again whenever it is cleared, and the image would do nothing else.
// Here it is raised, as in the chip, when the last byte has left. The register that hands the port over to DMA is not
// emulated: it would read as all ones, and the image would leave every byte to the DMA.

const DMA_CONTROL = 0x48;
const TRANSMIT = 1 << 5;
const FIFO_BYTES = 32;
const TRANSMIT_FULL = 1 << 5;
const BITS_A_BYTE = 10;

export class SerialPort {
  constructor() {
    this.toDevice = [];
    this.fromDevice = [];
  }

  attach(mcu, uart, clock) {
    this.uart = uart;
    this.sending = [];
    const byteNanos = () => Math.round((BITS_A_BYTE * 1e9) / (uart.baudRate || 115200));
    const read = uart.readUint32.bind(uart);
    uart.readUint32 = (offset) => (offset === DMA_CONTROL ? 0 : read(offset));
    uart.checkInterrupts = () => mcu.setInterrupt(uart.irq, !!(uart.interruptStatus & uart.interruptMask));
    Object.defineProperty(uart, 'flags', {
      get: () => (uart.rxFIFO.full ? 0x40 : 0) | (uart.rxFIFO.empty ? 0x10 : 0) | (this.sending.length ? 0 : 0x80) | (this.sending.length >= FIFO_BYTES ? TRANSMIT_FULL : 0),
    });
    this.sent = clock.createAlarm(() => {
      this.fromDevice.push(this.sending.shift());
      if (this.sending.length) return this.sent.schedule(byteNanos());
      uart.interruptStatus |= TRANSMIT;
      uart.checkInterrupts();
    });
    uart.onByte = (byte) => {
      this.sending.push(byte);
      if (this.sending.length === 1) this.sent.schedule(byteNanos());
    };
    this.received = clock.createAlarm(() => {
      if (!uart.rxFIFO.full && this.toDevice.length) uart.feedByte(this.toDevice.shift());
      if (this.toDevice.length) this.received.schedule(byteNanos());
    });
    this.byteNanos = byteNanos;
  }

  // Starts the next bytes on their way to the device.
  pump() {
    if (this.toDevice.length && !this.received.scheduled) this.received.schedule(this.byteNanos());
  }
}
