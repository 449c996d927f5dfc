// What of an ELF file the bench needs: the segments that go to flash, and the symbols' addresses.

const LOAD = 1;
const SYMBOL_TABLE = 2;

export class Elf {
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
    if (this.view.getUint32(0) !== 0x7f454c46 || bytes[4] !== 1) throw new Error('not a 32-bit ELF file');
  }

  // Each loaded segment that lies in flash, with its offset there.
  *flashSegments() {
    const { view } = this;
    const [table, size, count] = [view.getUint32(28, true), view.getUint16(42, true), view.getUint16(44, true)];
    for (let i = 0; i < count; i++) {
      const header = table + i * size;
      const [type, offset, , physical, length] = [0, 4, 8, 12, 16].map((at) => view.getUint32(header + at, true));
      if (type === LOAD && length && physical >= 0x10000000 && physical < 0x11000000)
        yield { offset: physical - 0x10000000, bytes: this.bytes.subarray(offset, offset + length) };
    }
  }

  symbols() {
    const { view } = this;
    const [table, size, count] = [view.getUint32(32, true), view.getUint16(46, true), view.getUint16(48, true)];
    const section = (index) => {
      const header = table + index * size;
      const [, type, , , offset, length, link] = [0, 4, 8, 12, 16, 20, 24].map((at) => view.getUint32(header + at, true));
      return { type, offset, length, link };
    };
    const found = new Map();
    for (let i = 0; i < count; i++) {
      const symbols = section(i);
      if (symbols.type !== SYMBOL_TABLE) continue;
      const names = section(symbols.link);
      for (let at = symbols.offset; at < symbols.offset + symbols.length; at += 16) {
        let end = names.offset + view.getUint32(at, true);
        const start = end;
        while (this.bytes[end]) end++;
        if (end > start) found.set(this.bytes.toString('latin1', start, end), view.getUint32(at + 4, true));
      }
    }
    return found;
  }
}
