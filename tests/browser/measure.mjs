// How long a page takes to open, and how often a second it is drawn while it is turned:
//   node tests/browser/measure.mjs BUILD/report.html
// Chromium draws on the processor here, so this tells the least that a computer with graphics of its own can do. Seconds of
// the processor are told beside those of the clock, because a busy machine has more of these.

import { readFileSync, readdirSync, statSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { SIZES, launch } from "./browser.mjs";

const TICKS_A_SECOND = 100;
const TURN_MS = 6000;

// Seconds that this process's descendants have had of the processor.
function processorSeconds() {
  const processes = readdirSync("/proc").filter((name) => /^\d+$/.test(name)).flatMap((id) => {
    try {
      const fields = readFileSync(`/proc/${id}/stat`, "utf8").replace(/^.*\) /, "").split(" ");
      return [{ id: Number(id), parent: Number(fields[1]), ticks: Number(fields[11]) + Number(fields[12]) }];
    } catch {
      return [];
    }
  });
  const ours = new Set([process.pid]);
  for (const _ of processes) for (const { id, parent } of processes) if (ours.has(parent)) ours.add(id);
  ours.delete(process.pid);
  return processes.filter(({ id }) => ours.has(id)).reduce((sum, { ticks }) => sum + ticks, 0) / TICKS_A_SECOND;
}

const file = process.argv[2];
if (!file) throw new Error("name a report.html");
const browser = await launch();
const page = await browser.newPage({ viewport: SIZES.desktop });
await page.goto("about:blank");
const before = processorSeconds();
await page.goto(pathToFileURL(file).href);
await page.waitForSelector("canvas[data-drawn=yes]", { timeout: 120_000 });
const opening = processorSeconds() - before;
const marks = await page.evaluate(() => performance.getEntriesByType("mark").map(({ name, startTime }) => [name, startTime / 1000]));
const first = Object.fromEntries([...marks].reverse());
const turned = await page.evaluate(async (ms) => {
  let frames = 0;
  const details = [];
  const draw = drawScene;
  window.drawScene = () => {
    frames++;
    details.push(Math.round(canvas.clientWidth / detail));
    draw();
  };
  const began = performance.now();
  const tick = () => {
    if (performance.now() - began > ms) return;
    change({ horizontal: Math.round(400 * Math.sin((performance.now() - began) / 700)) / 10 });
    requestAnimationFrame(tick);
  };
  tick();
  await new Promise((resolve) => setTimeout(resolve, ms));
  window.drawScene = draw;
  return { frames, pixels: details.at(-1) };
}, TURN_MS);
console.log({
  megabytes: statSync(file).size / 1e6,
  first_picture_s: first.glance,
  whole_picture_s: first.whole,
  opening_processor_s: opening,
  frames_a_second: (turned.frames / TURN_MS) * 1000,
  pixels_across_while_turned: turned.pixels,
});
await browser.close();
