// A real browser, and the command whose pages it is shown.

import { spawn, spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import path from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { chromium } from "playwright-core";
import { PNG } from "pngjs";

export const ROOT = fileURLToPath(new URL("../..", import.meta.url));
const VITRINE = path.join(process.env.CARGO_TARGET_DIR ?? path.join(ROOT, "target"), "debug", "vitrine");
const AXE = createRequire(import.meta.url).resolve("axe-core/axe.min.js");

export const SIZES = {
  phone: { width: 320, height: 640 },
  tablet: { width: 768, height: 1024 },
  desktop: { width: 1440, height: 900 },
};

// Chromium asks nobody for anything, and draws on the processor.
export function launch(...more) {
  return chromium.launch({
    executablePath: process.env.VITRINE_CHROMIUM ?? "/usr/bin/chromium",
    args: [
      "--no-sandbox",
      "--enable-unsafe-swiftshader",
      "--disable-background-networking",
      "--disable-component-update",
      "--disable-sync",
      "--no-first-run",
      ...more,
    ],
  });
}

// A folder to work in with the bundled photographs, gone when the tests are over.
export class Workshop {
  constructor() {
    this.folder = mkdtempSync(path.join(tmpdir(), "vitrine-browser-"));
    this.runtime = mkdtempSync(path.join(tmpdir(), "vitrine-browser-"));
  }

  remove() {
    for (const folder of [this.folder, this.runtime]) rmSync(folder, { recursive: true, force: true });
  }

  path(...names) {
    return path.join(this.folder, ...names);
  }

  write(name, text) {
    writeFileSync(this.path(name), text);
  }

  photo(name) {
    return path.join(ROOT, "host-tool", "photos", name);
  }

  options() {
    return { cwd: this.folder, encoding: "utf8", env: { ...process.env, VITRINE_RUNTIME_DIR: this.runtime } };
  }

  // Runs the command, which must succeed, and gives its standard output.
  vitrine(...arguments_) {
    const { status, stdout, stderr, error } = spawnSync(VITRINE, arguments_, this.options());
    if (status !== 0) throw new Error(`vitrine ${arguments_.join(" ")}: ${error ?? stderr}`);
    return stdout;
  }

  // Starts the command, which goes on until it is killed.
  start(...arguments_) {
    return spawn(VITRINE, arguments_, this.options());
  }

  // A picture that `vitrine view` writes: its bytes, red, green and blue.
  view(build, ...arguments_) {
    this.vitrine("view", build, ...arguments_, "-o", "view.png");
    return withoutAlpha(PNG.sync.read(readFileSync(this.path("view.png"))).data);
  }

  report(build) {
    return pathToFileURL(this.path(build, "report.html")).href;
  }
}

// Every pixel's first three bytes.
export function withoutAlpha(bytes) {
  return Buffer.from(bytes.filter((_, at) => at % 4 !== 3));
}

// How many bytes differ, and the first that does.
export function differing(one, other) {
  if (one.length !== other.length) return `${one.length} bytes and ${other.length}`;
  const places = [...one.keys()].filter((at) => one[at] !== other[at]);
  return places.length === 0 ? "" : `${places.length} of ${one.length}, first at ${places[0]}: ${one[places[0]]} ${other[places[0]]}`;
}

// What an accessibility check finds wrong with a page, in words.
export async function faults(page) {
  if (!(await page.evaluate(() => "axe" in window))) await page.evaluate(readFileSync(AXE, "utf8"));
  const { violations } = await page.evaluate(() => window.axe.run());
  return violations.map(({ id, help, nodes }) => `${id}: ${help} (${nodes.map((node) => node.target).join(", ")})`);
}

// Leaves a picture of the page where VITRINE_SCREENSHOTS asks for it.
export async function picture(page, name) {
  const folder = process.env.VITRINE_SCREENSHOTS;
  if (folder) await page.screenshot({ path: path.join(folder, `${name}.png`), fullPage: true });
}
