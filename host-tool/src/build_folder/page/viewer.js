"use strict";
// The part of the page that one turns: what is asked for, when it is drawn, and what stands beside it.

const section = document.getElementById("viewer");
const canvas = section.querySelector(".turntable canvas");
const STILL_MS = 200;
const GLANCE_MS = 100;
const FRAME_MS = 1000 / 30;
const COARSEST = 8;

const state = { view: 0, apart: 1, edges: true, ideal: false, shown: Array(stack.films).fill(true) };
const control = (name) => section.querySelector(`[name=${name}]`);
const directed = (view) => view.horizontal === state.horizontal && view.vertical === state.vertical;

let drawing = null;
let ready = false;
let gain = 1;
let detail = COARSEST / 2;
let last = { frame: 0, glance: 0, still: 0, moving: false, took: 0 };
let waiting = false;

// What `vitrine view` writes for the same request: bytes, interleaved red, green and blue. Without a gain the 99.5th
// percentile becomes white; `stride` looks at fewer pixels.
function lookAt(look, { stride = 1, encode = stack.light, weights = filmWeights(look) } = {}) {
  const weightSum = filmWeights(look).reduce((sum, weight) => sum + weight, 0);
  const { sums, width, height } = drawing.sumsOf(look, weights, stride);
  const light = normalised(sums, weightSum);
  const gain = look.gain ?? whiteGain(light);
  const bytes = bytesOf(asSeen(exposed(light, gain), look, width, height), encode);
  return { bytes, light, gain, weightSum, width, height };
}

// What lies on the film, as the oblique viewer sees it, where the exhibit's frame is the viewer's.
function asSeen(values, look, width, height) {
  if (!stack.drawn_out) return values;
  const [, x] = tangentAndCosine(look.horizontal);
  const [, y] = tangentAndCosine(look.vertical);
  return drawnOut(values, width, height, 1 / x, 1 / y);
}

function currentLook() {
  const { horizontal, vertical, top, bottom, ideal } = state;
  return { horizontal, vertical, top, bottom, ideal, distance: state.far ? null : state.distance };
}

function shownWeights(look, hidden) {
  return filmWeights(look).map((weight, film) => (state.shown[film] ? weight : hidden));
}

function drawScene() {
  const base = Math.min(Math.round(canvas.clientWidth * window.devicePixelRatio) || 512, 1024);
  const size = Math.max(Math.round(base / detail), 64);
  if (canvas.width !== size) canvas.width = canvas.height = size;
  const look = currentLook();
  const sum = filmWeights(look).reduce((sum, weight) => sum + weight, 0) || 1;
  const weights = shownWeights(look, -1).map((weight) => (weight < 0 ? -1 : weight / sum));
  drawing.drawScene(look, weights, { gain, apart: state.apart, edges: state.edges });
}

// What the viewer sees, beside the pattern of the nearest view, and where they differ.
function drawSights(stride) {
  const look = currentLook();
  const seen = lookAt(look, { stride, weights: shownWeights(look, 0) });
  gain = seen.gain;
  put("seen", seen.bytes, seen);
  const nearest = nearestView();
  const pattern = patternOf(nearest, stride);
  if (!pattern) return;
  const fitting = fittingGain(seen.light, pattern);
  const fitted = bytesOf(asSeen(exposed(seen.light, fitting), look, seen.width, seen.height), stack.light);
  const { error, psnr_db } = compared(fitted, pattern);
  put("pattern", pattern, seen);
  put("error", error, seen);
  say("seen", `brightest 0.5 % white: gain ${seen.gain.toFixed(2)}`);
  say("pattern", `${stack.views[nearest].id}${directed(stack.views[nearest]) ? "" : ", the nearest view"}`);
  say("error", `${psnr_db.toFixed(1)} dB, fitted in brightness`);
  section.dataset.stride = stride;
}

function put(name, bytes, { width, height }) {
  const target = section.querySelector(`canvas[data-sight=${name}]`);
  const image = new ImageData(width, height);
  for (let i = 0, j = 0; i < bytes.length; i += 3, j += 4) {
    image.data[j] = bytes[i];
    image.data[j + 1] = bytes[i + 1];
    image.data[j + 2] = bytes[i + 2];
    image.data[j + 3] = 255;
  }
  if (target.width !== width || target.height !== height) [target.width, target.height] = [width, height];
  target.getContext("2d", { willReadFrequently: true }).putImageData(image, 0, 0);
}

function say(name, text) {
  section.querySelector(`[data-told=${name}]`).textContent = text;
}

function nearestView() {
  if (directed(stack.views[state.view])) return state.view;
  const distance = (view) => Math.hypot(view.horizontal - state.horizontal, view.vertical - state.vertical);
  return stack.views.reduce((best, view, index, all) => (distance(view) < distance(all[best]) ? index : best), 0);
}

const patterns = [];

// The bytes of a view's pattern, of every `stride`th pixel and row.
function patternOf(index, stride) {
  const whole = patterns[index];
  if (!whole || stride === 1) return whole;
  const part = [];
  for (let j = 0; j < stack.height_px; j += stride) {
    for (let i = 0; i < stack.width_px; i += stride) {
      const at = 3 * (j * stack.width_px + i);
      part.push(whole[at], whole[at + 1], whole[at + 2]);
    }
  }
  return Uint8Array.from(part);
}

function frame(now) {
  waiting = false;
  if (!ready) return;
  // Where the whole picture takes long, a pause has to be longer before it is drawn.
  const moving = now - last.still < Math.max(STILL_MS, last.took);
  if (moving) {
    // The first frame after a rest tells nothing of how long one takes.
    const took = last.moving ? now - last.frame : FRAME_MS;
    if (took > FRAME_MS * 1.2) detail = fitting(detail, took);
    else if (took < FRAME_MS * 0.6) detail = Math.max(detail / 1.2, 1);
    const stride = last.took > 500 ? 8 : 4;
    if (now - last.glance > GLANCE_MS + last.took / stride) {
      drawSights(stride);
      last.glance = now;
    }
    drawScene();
    performance.mark("glance");
    next();
  } else {
    const began = performance.now();
    drawSights(1);
    last.took = Math.min(performance.now() - began, 2000);
    detail = 1;
    drawScene();
    // So finely the next turn begins.
    detail = fitting(1, drawing.timeToFinish());
    canvas.dataset.drawn = "yes";
    performance.mark("whole");
  }
  last.frame = now;
  last.moving = moving;
}

// The detail with which a frame takes no longer than it may, where one of `detail` took so long: there are as many pixels
// as its square.
function fitting(detail, took) {
  return Math.min(Math.max(detail * Math.sqrt(took / FRAME_MS), 1), COARSEST);
}

function next() {
  if (ready && !waiting) waiting = requestAnimationFrame(frame) > 0;
}

// Shows what has changed, in the controls too.
function change(changes) {
  Object.assign(state, changes);
  const limit = (value, name) => Math.min(Math.max(value, Number(control(name).min)), Number(control(name).max));
  for (const name of ["horizontal", "vertical", "distance"]) state[name] = limit(state[name], name);
  for (const name of ["horizontal", "vertical", "distance", "top", "bottom", "apart"]) {
    const input = control(name);
    input.value = state[name];
    section.querySelector(`output[for=${name}]`).value = `${Number(state[name].toFixed(2))}${input.dataset.unit}`;
  }
  for (const name of ["far", "ideal", "edges"]) control(name).checked = state[name];
  control("distance").disabled = state.far || state.ideal;
  for (const lamp of ["top", "bottom"]) control(lamp).disabled = state.ideal;
  for (const button of section.querySelectorAll("button[data-view]")) {
    button.setAttribute("aria-pressed", directed(stack.views[button.dataset.view]) ? "true" : "false");
  }
  canvas.dataset.drawn = "no";
  last.still = performance.now();
  next();
}

function showView(index) {
  const { horizontal, vertical, top, bottom, distance } = stack.views[index];
  change({ view: index, horizontal, vertical, top, bottom, far: distance === null, distance: distance ?? state.distance });
}

section.addEventListener("input", ({ target }) => {
  if (target.name === "film") state.shown[target.value] = target.checked;
  else if (target.type === "checkbox") state[target.name] = target.checked;
  else state[target.name] = Number(target.value);
  change({});
});
for (const button of section.querySelectorAll("button[data-view]")) {
  button.addEventListener("click", () => showView(Number(button.dataset.view)));
}
for (const button of section.querySelectorAll("button[data-films]")) {
  button.addEventListener("click", () => {
    const shown = button.dataset.films === "all";
    for (const box of section.querySelectorAll("[name=film]")) box.checked = shown;
    change({ shown: Array(stack.films).fill(shown) });
  });
}

const tenth = (value) => Math.round(value * 10) / 10;
const step = (horizontal, vertical) =>
  change({ horizontal: tenth(state.horizontal + horizontal), vertical: tenth(state.vertical + vertical) });
const draw_near = (factor) => change({ far: false, distance: Math.round(state.distance * factor) });

canvas.addEventListener("keydown", (event) => {
  const degrees = event.shiftKey ? 5 : 1;
  const keys = {
    ArrowRight: () => step(degrees, 0),
    ArrowLeft: () => step(-degrees, 0),
    ArrowUp: () => step(0, degrees),
    ArrowDown: () => step(0, -degrees),
    "+": () => draw_near(1 / 1.1),
    "-": () => draw_near(1.1),
    Home: () => showView(0),
  };
  if (!keys[event.key] || event.ctrlKey || event.altKey || event.metaKey) return;
  event.preventDefault();
  keys[event.key]();
});
canvas.addEventListener("wheel", (event) => {
  if (document.activeElement !== canvas) return;
  event.preventDefault();
  draw_near(1.1 ** Math.sign(event.deltaY));
}, { passive: false });

// One finger or the mouse turns, two fingers change the distance. Dragging to the right turns the stack to the right,
// which is to walk to its left.
const fingers = new Map();
const spread = () => {
  const [one, other] = [...fingers.values()];
  return Math.hypot(one.x - other.x, one.y - other.y);
};
canvas.addEventListener("pointerdown", (event) => {
  canvas.focus({ preventScroll: true });
  canvas.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
});
canvas.addEventListener("pointermove", (event) => {
  const before = fingers.get(event.pointerId);
  if (!before) return;
  const was = fingers.size === 2 ? spread() : 0;
  fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  if (fingers.size === 2) draw_near(was / Math.max(spread(), 1));
  else if (fingers.size === 1) step((before.x - event.clientX) / 3, (event.clientY - before.y) / 3);
});
for (const end of ["pointerup", "pointercancel"]) {
  canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
}

// What comes of it comes before the page counts as loaded, so that a program that prints it then finds the stack in it.
function imageOf(source) {
  return new Promise((resolve, reject) => {
    const image = new Image();
    image.onload = () => resolve(image);
    image.onerror = reject;
    image.src = source;
  });
}

// The bytes of a picture, without its alpha.
async function bytesOfPicture(source) {
  const image = await imageOf(source);
  const paper = Object.assign(document.createElement("canvas"), { width: image.width, height: image.height });
  const context = paper.getContext("2d", { willReadFrequently: true });
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, image.width, image.height).data.filter((_, at) => at % 4 !== 3);
}

function fallBack(reason) {
  ready = false;
  section.querySelector(".stage").hidden = true;
  section.querySelector(".pictures-instead").hidden = false;
  section.querySelector(".pictures-instead").textContent = `${reason}: the pictures below show each view.`;
}

async function load() {
  try {
    drawing = new Drawing(canvas);
  } catch (error) {
    fallBack(error.message);
    return;
  }
  canvas.addEventListener("webglcontextlost", () => fallBack("The graphics processor was lost"));
  section.querySelector(".stage").hidden = false;
  section.querySelector(".pictures-instead").hidden = true;
  const films = stack.pictures.map((film) => imageOf(`data:image/png;base64,${film}`));
  for (const [film, image] of films.entries()) drawing.putFilm(film, await image);
  const shown = document.querySelectorAll("img[data-pattern]");
  patterns.push(...(await Promise.all([...shown].map((picture) => bytesOfPicture(picture.src)))));
  ready = true;
  // A glance first, and the whole picture when it has been seen.
  change({});
}

window.addEventListener("resize", () => change({}));
// What is folded is printed, and folded again; the stack is printed as it was turned, in full, with where it is seen from.
const unfolded = [];
window.addEventListener("beforeprint", () => {
  unfolded.push(...document.querySelectorAll("details:not([open])"));
  for (const details of unfolded) details.open = true;
  if (!ready) return;
  detail = 1;
  drawSights(1);
  drawScene();
  say("stack", placeInWords());
});
window.addEventListener("afterprint", () => {
  for (const details of unfolded.splice(0)) details.open = false;
});

function placeInWords() {
  const side = (degrees, one, other) => (degrees ? `${Math.abs(degrees)}° ${degrees > 0 ? one : other}` : "");
  const places = [side(state.horizontal, "to the right", "to the left"), side(state.vertical, "above", "below")];
  const direction = places.filter(Boolean).join(", ") || "straight ahead";
  const percent = (level) => `${Math.round(100 * level)} %`;
  const distance = state.ideal || state.far ? "far away" : `${state.distance} mm away`;
  return `The stack from ${direction}, ${distance}; top lamp ${percent(state.top)}, bottom lamp ${percent(state.bottom)}.`;
}
state.distance = Number(control("distance").value);
showView(0);
load();
