"use strict";
// From the sums of light to the picture: the same single-precision arithmetic as `vitrine view`.

const single = Math.fround;
const WHITE_PERCENT = 99.5;

// The percentile of values that are not negative, interpolated between ranks.
function percentile(values, percent) {
  const rank = ((values.length - 1) * percent) / 100;
  const whole = Math.floor(rank);
  const below = ranked(values, whole);
  const above = rank > whole ? ranked(values, whole + 1) : below;
  return below + (rank - whole) * single(above - below);
}

// The value of a rank. The bits of such values are in the values' order.
function ranked(values, rank) {
  const bits = new Uint32Array(values.buffer, values.byteOffset, values.length);
  const counts = new Uint32Array(1 << 16);
  for (let i = 0; i < bits.length; i++) counts[bits[i] >>> 16]++;
  let bin = 0;
  let before = 0;
  while (rank >= before + counts[bin]) before += counts[bin++];
  const candidates = new Uint32Array(counts[bin]);
  for (let i = 0, found = 0; i < bits.length; i++) if (bits[i] >>> 16 === bin) candidates[found++] = bits[i];
  candidates.sort();
  return new Float32Array(new Uint32Array([candidates[rank - before]]).buffer)[0];
}

// The sums divided by the sum of the weights.
function normalised(sums, weightSum) {
  const divisor = single(weightSum);
  const light = new Float32Array(sums.length);
  if (weightSum > 0) for (let i = 0; i < sums.length; i++) light[i] = sums[i] / divisor;
  return light;
}

function whiteGain(light) {
  const white = percentile(light, WHITE_PERCENT);
  return white > 0 ? 1 / white : 1;
}

function exposed(light, gain) {
  const factor = single(gain);
  const result = new Float32Array(light.length);
  for (let i = 0; i < light.length; i++) result[i] = Math.min(Math.max(single(light[i] * factor), 0), 1);
  return result;
}

// The two pixels between which pixel `index` of a picture drawn out by 1 / `scale` lies, and the part of the second.
function neighbours(index, count, scale) {
  const middle = (count - 1) / 2;
  const place = middle + (index - middle) * scale;
  if (!(place >= 0 && place <= count - 1)) return null;
  const first = Math.floor(place);
  return [first, Math.min(first + 1, count - 1), single(place - first)];
}

// The picture as an oblique viewer sees it undistorted; `values` are interleaved.
function drawnOut(values, width, height, scaleX, scaleY) {
  const result = new Float32Array(values.length);
  const columns = Array.from({ length: width }, (_, column) => neighbours(column, width, scaleX));
  for (let j = 0; j < height; j++) {
    const row = neighbours(j, height, scaleY);
    if (!row) continue;
    const [top, bottom, below] = row;
    for (let i = 0; i < width; i++) {
      if (!columns[i]) continue;
      const [left, right, beside] = columns[i];
      for (let c = 0; c < 3; c++) {
        const across = (line) => {
          const [a, b] = [values[3 * (line * width + left) + c], values[3 * (line * width + right) + c]];
          return single(single(a * single(1 - beside)) + single(b * beside));
        };
        result[3 * (j * width + i) + c] = single(
          single(across(top) * single(1 - below)) + single(across(bottom) * below),
        );
      }
    }
  }
  return result;
}

// The sRGB code value of light (IEC 61966-2-1), by the polynomial of vitrine's own encoder.
const NEARLY_BLACK = single(0.0031308);
const ENCODING = [
  -0.06821407, 0.3567155, -0.82027465, 1.1159585, -1.0788702, 1.3799704, 0.11804458, -0.00333025,
].map(single);
const [STEEPEST, SPREAD, OFFSET] = [12.92, 1.055, 0.055].map(single);

function encoded(light) {
  if (light <= NEARLY_BLACK) return single(STEEPEST * light);
  const root = single(Math.sqrt(single(Math.sqrt(light))));
  let sum = single(0);
  for (let i = 0; i < ENCODING.length; i++) sum = single(single(sum * root) + ENCODING[i]);
  return single(single(SPREAD * sum) - OFFSET);
}

function decoded(code) {
  return code <= 0.04045 ? code / 12.92 : ((code + 0.055) / 1.055) ** 2.4;
}

// Bytes from values in 0..=1; light is encoded where that is asked for.
function bytesOf(values, encode) {
  const bytes = new Uint8Array(values.length);
  for (let i = 0; i < values.length; i++) {
    const value = encode ? encoded(values[i]) : values[i];
    bytes[i] = Math.floor(single(Math.min(Math.max(value, 0), 1) * 255) + 0.5);
  }
  return bytes;
}

// The gain that brings light closest to a pattern of bytes: <P,T> / <P,P>.
function fittingGain(light, pattern) {
  const levels = Float64Array.from({ length: 256 }, (_, code) => (stack.light ? decoded(code / 255) : code / 255));
  let [both, own] = [0, 0];
  for (let i = 0; i < light.length; i++) {
    both += light[i] * levels[pattern[i]];
    own += light[i] * light[i];
  }
  return own > 0 ? both / own : 1;
}

// How far bytes are from a pattern's, as bytes, and the peak signal-to-noise ratio in dB.
function compared(bytes, pattern) {
  const error = new Uint8Array(bytes.length);
  let squares = 0;
  for (let i = 0; i < bytes.length; i++) {
    const difference = Math.abs(bytes[i] - pattern[i]);
    error[i] = difference;
    squares += difference * difference;
  }
  return { error, psnr_db: 10 * Math.log10((255 * 255 * bytes.length) / Math.max(squares, 1e-9)) };
}
