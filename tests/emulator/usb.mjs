// The host's side of the image's USB serial port, offered as a TCP port.

import net from 'node:net';
import { USBCDC } from 'rp2040js';

const AVAILABLE = 1 << 10;
const inControl = (endpoint) => 0x80 + endpoint * 8;
const outControl = (endpoint) => inControl(endpoint) + 4;

export class UsbHost {
  constructor(clock) {
    this.clock = clock;
    this.toDevice = [];
    this.fromDevice = [];
    this.socket = null;
    this.server = null;
    this.connectedAt = null;
    this.reading = true;
    this.held = [];
  }

  attach(mcu, clock) {
    const usb = mcu.usbCtrl;
    this.cdc = new USBCDC(usb);
    this.usb = usb;
    this.pending = null;
    this.held = [];
    this.connectedAt = null;
    this.toDevice.length = 0;
    this.cdc.onDeviceConnected = () => (this.connectedAt ??= clock.nanos);
    this.cdc.onSerialData = (bytes) => {
      if (this.socket) this.socket.write(bytes);
      else this.fromDevice.push(...bytes);
    };
    // The emulator clears AVAILABLE as soon as the device offers a buffer, and the device then takes it for filled.
    const setAvailable = (at) => mcu.usbDPRAMView.setUint32(at, mcu.usbDPRAMView.getUint32(at, true) | AVAILABLE, true);
    const clearAvailable = (at) => mcu.usbDPRAMView.setUint32(at, mcu.usbDPRAMView.getUint32(at, true) & ~AVAILABLE, true);
    usb.onEndpointRead = (endpoint, size) => {
      setAvailable(outControl(endpoint));
      if (endpoint === this.cdc.outEndpoint) this.pending = { endpoint, size };
    };
    const finish = usb.finishRead.bind(usb);
    usb.finishRead = (endpoint, bytes) => {
      clearAvailable(outControl(endpoint));
      finish(endpoint, bytes);
    };
    // A host that does not read leaves the device's buffer where it is, and offered.
    const ready = usb.indicateBufferReady.bind(usb);
    usb.indicateBufferReady = (endpoint, out) => {
      if (out || endpoint !== this.cdc.inEndpoint || this.reading) ready(endpoint, out);
      else {
        setAvailable(inControl(endpoint));
        this.held.push(endpoint);
      }
    };
    this.take = (endpoint) => {
      clearAvailable(inControl(endpoint));
      ready(endpoint, false);
    };
  }

  setReading(reading) {
    this.reading = reading;
    if (reading) for (const endpoint of this.held.splice(0)) this.take(endpoint);
  }

  setTerminalReady(ready) {
    if (this.connectedAt !== null) this.cdc.cdcSetControlLineState(ready ? 3 : 0);
  }

  // Gives the device the next packet, when it has a buffer for it.
  pump() {
    if (this.pending === null || this.toDevice.length === 0) return;
    const { endpoint, size } = this.pending;
    this.pending = null;
    this.usb.endpointReadDone(endpoint, new Uint8Array(this.toDevice.splice(0, size)));
  }

  listen() {
    if (this.server) return this.server.address().port;
    return new Promise((resolve) => {
      this.server = net.createServer((socket) => {
        this.socket?.destroy();
        this.socket = socket;
        socket.setNoDelay(true);
        socket.write(Uint8Array.from(this.fromDevice.splice(0)));
        this.setTerminalReady(true);
        socket.on('data', (bytes) => {
          for (const byte of bytes) this.toDevice.push(byte);
        });
        socket.on('error', () => {});
        socket.on('close', () => {
          if (this.socket !== socket) return;
          this.socket = null;
          this.setTerminalReady(false);
        });
      });
      this.server.listen(0, '127.0.0.1', () => resolve(this.server.address().port));
    });
  }
}
