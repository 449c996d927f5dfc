// The Thumb instructions that have to do with registers, RAM and flash alone, as rows of encoding and meaning.
//
// Encodings and flags are of the ARMv6-M Architecture Reference Manual, A5 and A6.7; cycles are the emulator's. In an encoding,
// d, n and m are registers and i is a number, which `number` scales. In a meaning, I are the registers, D, N and M the numbers of
// those named, K the number, r the last result (for the flags of sign and zero), C and V the other flags, c the cycles beyond the
// first, k the instructions done, `at` the place in the code in half-words.

const LEAVE = '{ c--; k--; @LEAVE }';
// What a + b and a - b leave in r, C and V.
const ADDED = 'r = (a + b) | 0; C = (r >>> 0) < (a >>> 0); V = (~(a ^ b) & (a ^ r)) < 0;';
const SUBTRACTED = 'r = (a - b) | 0; C = (a >>> 0) >= (b >>> 0); V = ((a ^ b) & (a ^ r)) < 0;';
// The locks between the cores: nothing else hears of them, and they take a cycle less.
const IN_LOCKS = '(a & 0xffffff80) === (0xd0000100 | 0)';
const RAM_BYTES = 264 * 1024;

const inRam = (bytes) => `(o = a - 0x20000000) >>> 0 <= ${RAM_BYTES - bytes} && (o & ${Math.min(bytes, 4) - 1}) === 0`;
const inFlash = (bytes) => `(a & 0xff000000) === 0x10000000 && (a & ${bytes - 1}) === 0`;

function load(address, bytes, signed = '') {
  const from = (memory, place) => `I[D] = ${memory}${bytes * 8}[${place} >> ${bytes >> 1}]${signed};`;
  const lock = bytes === 4 ? `else if (${IN_LOCKS}) { I[D] = core.rp2040.sio.readUint32(a & 0xfff); c--; }` : '';
  return `a = (${address}) | 0; if (${inRam(bytes)}) { ${from('ram', 'o')} } else if (${inFlash(bytes)}) { ${from('flash', '(a & 0xffffff)')} } ${lock} else ${LEAVE} c++;`;
}

function store(address, bytes) {
  const lock = bytes === 4 ? `else if (${IN_LOCKS}) { core.rp2040.sio.writeUint32(a & 0xfff, I[D]); c--; }` : '';
  return `a = (${address}) | 0; if (${inRam(bytes)}) ram${bytes * 8}[o >> ${bytes >> 1}] = I[D]; ${lock} else ${LEAVE} c++;`;
}

// Words one after another in RAM, from the address in a: those of the registers in K.
const EACH = 'for (b = K & 255, p = o >> 2; b !== 0; b &= b - 1, c++)';
const ALL_OF_THEM = `if (!(${inRam(36)})) ${LEAVE}`;
const REGISTER = '31 - Math.clz32(b & -b)';

const branch = (condition, address) => [`if (${condition}) { at = K; c++; continue; }`, address];
const CONDITIONS = ['r === 0', 'r !== 0', 'C', '!C', 'r < 0', 'r >= 0', 'V', '!V', 'C && r !== 0', '!C || r === 0', 'r < 0 === V', 'r < 0 !== V', 'r !== 0 && r < 0 === V', 'r === 0 || r < 0 !== V'];

const by = (code) => `a = I[D]; b = I[M] & 255; if (b !== 0) { ${code} } r = I[D] = a;`;
const same = ({ i }) => i;
const times = (scale) => ({ i }) => i * scale;
const place = (bits) => ({ i, at }) => at + 2 + ((i << (32 - bits)) >> (32 - bits));
const ahead = ({ at, base }) => base + at * 2 + 4;

// In the order in which they are tried.
export const ROWS = [
  ['0000000000mmmddd', 'r = I[D] = I[M];'],
  ['00000iiiiimmmddd', 'a = I[M]; C = (a >>> (32 - K) & 1) !== 0; r = I[D] = a << K;', same],
  ['0000100000mmmddd', 'C = I[M] < 0; r = I[D] = 0;'],
  ['00001iiiiimmmddd', 'a = I[M]; C = (a >>> (K - 1) & 1) !== 0; r = I[D] = a >>> K;', same],
  ['0001000000mmmddd', 'a = I[M]; C = a < 0; r = I[D] = a >> 31;'],
  ['00010iiiiimmmddd', 'a = I[M]; C = (a >>> (K - 1) & 1) !== 0; r = I[D] = a >> K;', same],
  ['0001100mmmnnnddd', `a = I[N]; b = I[M]; ${ADDED} I[D] = r;`],
  ['0001101mmmnnnddd', `a = I[N]; b = I[M]; ${SUBTRACTED} I[D] = r;`],
  ['0001110iiinnnddd', `a = I[N]; b = K; ${ADDED} I[D] = r;`, same],
  ['0001111iiinnnddd', `a = I[N]; b = K; ${SUBTRACTED} I[D] = r;`, same],
  ['00100dddiiiiiiii', 'r = I[D] = K;', same],
  ['00101nnniiiiiiii', `a = I[N]; b = K; ${SUBTRACTED}`, same],
  ['00110dddiiiiiiii', `a = I[D]; b = K; ${ADDED} I[D] = r;`, same],
  ['00111dddiiiiiiii', `a = I[D]; b = K; ${SUBTRACTED} I[D] = r;`, same],

  ['0100000000mmmddd', 'r = I[D] = I[D] & I[M];'],
  ['0100000001mmmddd', 'r = I[D] = I[D] ^ I[M];'],
  ['0100000010mmmddd', by('C = b <= 32 && (a >>> (32 - b) & 1) !== 0; a = b < 32 ? a << b : 0;')],
  ['0100000011mmmddd', by('C = b <= 32 && (a >>> (b - 1) & 1) !== 0; a = b < 32 ? a >>> b | 0 : 0;')],
  ['0100000100mmmddd', by('b = b < 32 ? b : 32; C = (a >> (b - 1) & 1) !== 0; a = b < 32 ? a >> b : a >> 31;')],
  ['0100000101mmmddd', `a = I[D]; b = I[M]; w = (a >>> 0) + (b >>> 0) + (C ? 1 : 0); r = w | 0; C = w > 4294967295; V = (~(a ^ b) & (a ^ r)) < 0; I[D] = r;`],
  ['0100000110mmmddd', `a = I[D]; b = I[M]; w = (a >>> 0) - (b >>> 0) - (C ? 0 : 1); r = w | 0; C = w >= 0; V = ((a ^ b) & (a ^ r)) < 0; I[D] = r;`],
  ['0100000111mmmddd', by('b &= 31; a = b === 0 ? a : a >>> b | a << (32 - b); C = a < 0;')],
  ['0100001000mmmddd', 'r = I[D] & I[M];'],
  ['0100001001mmmddd', `a = 0; b = I[M]; ${SUBTRACTED} I[D] = r;`],
  ['0100001010mmmddd', `a = I[D]; b = I[M]; ${SUBTRACTED}`],
  ['0100001011mmmddd', `a = I[D]; b = I[M]; ${ADDED}`],
  ['0100001100mmmddd', 'r = I[D] = I[D] | I[M];'],
  ['0100001101mmmddd', 'r = I[D] = Math.imul(I[D], I[M]);'],
  ['0100001110mmmddd', 'r = I[D] = I[D] & ~I[M];'],
  ['0100001111mmmddd', 'r = I[D] = ~I[M];'],

  ['010001001mmmm111', LEAVE],
  ['010001001mmmm101', 'I[13] = (I[13] + I[M]) & ~3;'],
  ['01000100d1111ddd', 'I[D] = I[D] + K;', ahead],
  ['01000100dmmmmddd', 'I[D] = I[D] + I[M];'],
  ['01000101dmmmmddd', `a = I[D]; b = I[M]; ${SUBTRACTED}`],
  ['010001101mmmm111', LEAVE],
  ['010001101mmmm101', 'I[13] = I[M] & ~3;'],
  ['01000110d1111ddd', 'I[D] = K;', ahead],
  ['01000110dmmmmddd', 'I[D] = I[M];'],
  ['010001110mmmm000', 'c++; a = I[M]; @BRANCH'],
  ['010001111mmmm000', 'c++; a = I[M]; I[14] = K - 1; @BRANCH', ahead],

  ['01001dddiiiiiiii', 'I[D] = K; c++;', ({ i, at, word }) => word((at & ~1) + 2 + i * 2)],
  ['0101000mmmnnnddd', store('I[N] + I[M]', 4)],
  ['0101001mmmnnnddd', store('I[N] + I[M]', 2)],
  ['0101010mmmnnnddd', store('I[N] + I[M]', 1)],
  ['0101011mmmnnnddd', load('I[N] + I[M]', 1, ' << 24 >> 24')],
  ['0101100mmmnnnddd', load('I[N] + I[M]', 4)],
  ['0101101mmmnnnddd', load('I[N] + I[M]', 2)],
  ['0101110mmmnnnddd', load('I[N] + I[M]', 1)],
  ['0101111mmmnnnddd', load('I[N] + I[M]', 2, ' << 16 >> 16')],
  ['01100iiiiinnnddd', store('I[N] + K', 4), times(4)],
  ['01101iiiiinnnddd', load('I[N] + K', 4), times(4)],
  ['01110iiiiinnnddd', store('I[N] + K', 1), same],
  ['01111iiiiinnnddd', load('I[N] + K', 1), same],
  ['10000iiiiinnnddd', store('I[N] + K', 2), times(2)],
  ['10001iiiiinnnddd', load('I[N] + K', 2), times(2)],
  ['10010dddiiiiiiii', store('I[13] + K', 4), times(4)],
  ['10011dddiiiiiiii', load('I[13] + K', 4), times(4)],
  ['10100dddiiiiiiii', 'I[D] = K;', ({ i, at, base }) => base + ((at & ~1) + 2 + i * 2) * 2],
  ['10101dddiiiiiiii', 'I[D] = I[13] + K;', times(4)],
  ['101100000iiiiiii', 'I[13] = I[13] + K;', times(4)],
  ['101100001iiiiiii', 'I[13] = I[13] - K;', times(4)],

  ['1011001000mmmddd', 'I[D] = I[M] << 16 >> 16;'],
  ['1011001001mmmddd', 'I[D] = I[M] << 24 >> 24;'],
  ['1011001010mmmddd', 'I[D] = I[M] & 0xffff;'],
  ['1011001011mmmddd', 'I[D] = I[M] & 0xff;'],
  ['1011010iiiiiiiii', `for (a = I[13], b = K; b !== 0; b &= b - 1) a = a - 4 | 0; ${ALL_OF_THEM} ${EACH} ram32[p++] = I[${REGISTER}]; if (K & 256) ram32[p] = I[14]; I[13] = a;`, same],
  ['10111100iiiiiiii', `a = I[13]; ${ALL_OF_THEM} ${EACH} I[${REGISTER}] = ram32[p++]; I[13] = 0x20000000 + p * 4;`, same],
  ['10111101iiiiiiii', `a = I[13]; ${ALL_OF_THEM} ${EACH} I[${REGISTER}] = ram32[p++]; a = ram32[p]; I[13] = 0x20000004 + p * 4; c += 2; @BRANCH`, same],
  ['1011101000mmmddd', 'a = I[M]; I[D] = a << 24 | (a >> 8 & 255) << 16 | (a >> 16 & 255) << 8 | a >>> 24;'],
  ['1011111100000000', ''],
  ['1011011001110010', 'core.PM = true;'],
  // Interrupts let in again: the interpreter takes the one that waits.
  ['1011011001100010', `if (core.pendingInterrupts || core.pendingPendSV || core.pendingSVCall || core.pendingSystick || core.pendingNMI) ${LEAVE} core.PM = false;`],
  ['11000nnniiiiiiii', `a = I[N]; ${ALL_OF_THEM} ${EACH} ram32[p++] = I[${REGISTER}]; if ((K >> N & 1) === 0) I[N] = 0x20000000 + p * 4;`, same],
  ['11001nnniiiiiiii', `a = I[N]; ${ALL_OF_THEM} ${EACH} I[${REGISTER}] = ram32[p++]; if ((K >> N & 1) === 0) I[N] = 0x20000000 + p * 4;`, same],

  ...CONDITIONS.map((condition, code) => [`1101${code.toString(2).padStart(4, '0')}iiiiiiii`, ...branch(condition, place(8))]),
  ['11100iiiiiiiiiii', 'at = K; c++; continue;', place(11)],
];

// The instructions of two halves: how they are told, what they mean, and their number.
export const WIDE = [
  [(first, second) => first >> 11 === 30 && second >> 14 === 3 && second & 0x1000, 'I[14] = base + at * 2 + 5; at = K; c += 2; continue;', callee],
  [(first, second) => first === 0xf3ef && second >> 12 === 8 && (second & 255) === 16, 'I[K] = core.PM ? 1 : 0; at++; c += 2;', ({ second }) => (second >> 8) & 15],
  [(first, second) => first === 0xf3bf && [0x8f40, 0x8f50, 0x8f60].includes(second & 0xfff0), 'at++; c += 2;', () => 0],
];

function callee({ first, second, at }) {
  const [s, j1, j2] = [(first >> 10) & 1, (second >> 13) & 1, (second >> 11) & 1];
  const [i1, i2] = [1 - (s ^ j1), 1 - (s ^ j2)];
  return at + 2 + ((s ? -0x800000 : 0) | (i1 << 22) | (i2 << 21) | ((first & 0x3ff) << 11) | (second & 0x7ff));
}
