"use strict";
// Where the rays of one look meet each film, and what each film weighs: the same sums in the same order as
// `vitrine view`, so that the picture comes out the same to the last bit. Tangents and cosines come from the page,
// because programs do not agree on their last bit.

const stack = JSON.parse(document.getElementById("stack").textContent);

// As far as a picture's place is from a pixel's centre, it still lies on it.
const SNAP = 1e-7;

function tangentAndCosine(degrees) {
  const known = stack.angles[Math.abs(degrees)];
  const radians = (Math.abs(degrees) * Math.PI) / 180;
  const [tangent, cosine] = known ?? [Math.tan(radians), Math.cos(radians)];
  return [degrees < 0 ? -tangent : tangent, cosine];
}

// The slope (x per z, y per z) of the line of sight inside the stack.
function slopeInside(look) {
  let [x] = tangentAndCosine(look.horizontal);
  let [y] = tangentAndCosine(look.vertical);
  const length = Math.sqrt(x * x + y * y + 1);
  x = x / length / stack.index;
  y = y / length / stack.index;
  const z = Math.sqrt(1 - x * x - y * y);
  return [x / z, y / z];
}

// `base` to a whole power, by squaring.
function power(base, exponent) {
  let result = 1;
  for (;;) {
    if (exponent & 1) result *= base;
    exponent >>= 1;
    if (exponent === 0) return result;
    base *= base;
  }
}

// The weight of every film: the ultraviolet that the lamps bring to it times the part of its light that comes out.
function filmWeights(look) {
  const [x, y] = slopeInside(look);
  const cosine = 1 / Math.sqrt(1 + x * x + y * y);
  const last = stack.films - 1;
  return Array.from({ length: stack.films }, (_, k) => {
    if (look.ideal) return 1;
    const ultraviolet = look.top * power(stack.tau_uv, k) + look.bottom * power(stack.tau_uv, last - k);
    return ultraviolet * Math.pow(stack.tau_visible, k / cosine);
  });
}

function filmHeight(film) {
  return ((stack.films - 1) / 2 - film) * stack.pitch_mm;
}

// Where each of `length` pixels of the picture samples a film: its lower neighbour (-1 outside), and the part of the
// upper one.
function places(length, scale, shift) {
  const lower = new Int32Array(length).fill(-1);
  const part = new Float32Array(length);
  const middle = (length - 1) / 2;
  const last = length - 1;
  for (let i = 0; i < length; i++) {
    let place = middle + scale * (i - middle) + shift;
    const whole = Math.round(place);
    if (Math.abs(place - whole) < SNAP) place = whole;
    if (!(place >= 0 && place <= last) || scale <= 0) continue;
    lower[i] = Math.min(Math.floor(place), length - 2);
    part[i] = place - lower[i];
  }
  return { lower, part };
}

// Runs of pixels with neighbours in step: first, one after the last, and whether all have the same part.
function runs({ lower, part }) {
  const found = [];
  for (let i = 0; i < lower.length; i++) {
    if (lower[i] < 0) continue;
    const run = found.at(-1);
    if (run && run.end === i && lower[i] === lower[run.start] + (i - run.start)) {
      run.end++;
      run.even &&= part[i] === part[run.start];
    } else {
      found.push({ start: i, end: i + 1, even: true });
    }
  }
  return found;
}

// A table for the graphics processor, two lines a film. Of each column: lower neighbour, whether p and q weigh the two
// neighbours, p, q; otherwise p is the film's weight and q the part of the upper one. Of each row: lower neighbour, part.
function samplingTable(look, weights) {
  const [slopeX, slopeY] = slopeInside(look);
  const parallel = look.ideal || look.distance === null;
  const line = 4 * Math.max(stack.width_px, stack.height_px);
  const table = new Float32Array(2 * stack.films * line).fill(-1);
  for (let k = 0; k < stack.films; k++) {
    const z = filmHeight(k);
    const scale = parallel ? 1 : 1 - (z * Math.sqrt(1 + slopeX * slopeX + slopeY * slopeY)) / look.distance;
    const columns = places(stack.width_px, scale, (z * slopeX) / stack.pixel_mm);
    const rows = places(stack.height_px, scale, -(z * slopeY) / stack.pixel_mm);
    const weight = Math.fround(weights[k]);
    for (const { start, end, even } of runs(columns)) {
      for (let i = start; i < end; i++) {
        const part = columns.part[i];
        const p = even ? Math.fround(weight * Math.fround(1 - part)) : weight;
        const q = even ? Math.fround(weight * part) : part;
        table.set([columns.lower[i], even ? 1 : 0, p, q], 2 * k * line + 4 * i);
      }
    }
    for (let j = 0; j < stack.height_px; j++) {
      if (rows.lower[j] >= 0) table.set([rows.lower[j], rows.part[j]], (2 * k + 1) * line + 4 * j);
    }
  }
  return table;
}
