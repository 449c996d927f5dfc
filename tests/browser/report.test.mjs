// report.html in a real browser.

import assert from "node:assert/strict";
import { statSync, writeFileSync } from "node:fs";
import { after, before, describe, test } from "node:test";
import { SIZES, Workshop, differing, faults, launch, picture, withoutAlpha } from "./browser.mjs";

const WICKED = '</script><img src=x onerror=alert(1)>';

// An exhibit of three photographs, small enough to be quick.
function exhibit(workshop, { name = "Small", stack = "", viewer = "", design = "", views = [30, 0, -30] } = {}) {
  const ids = ["astronaut", "coffee", "cat"];
  const tables = ids.map((id, index) => {
    const [horizontal, vertical = 0] = [views[index]].flat();
    const pattern = JSON.stringify(workshop.photo(`${id}.jpg`));
    return `[[view]]\nid = "${id}"\npattern = ${pattern}\nhorizontal_deg = ${horizontal}\nvertical_deg = ${vertical}\n`;
  });
  return `[exhibit]\nname = ${JSON.stringify(name)}\n[stack]\nfilms = 8\npixels = [96, 72]\nwidth_mm = 20.0\n${stack}
[viewer]\n${viewer}\n[design]\niterations = 5\n${design}\n${tables.join("")}`;
}

const workshop = new Workshop();
let browser;

function design(build, settings) {
  workshop.write("exhibit.toml", exhibit(workshop, settings));
  workshop.vitrine("design", "exhibit.toml", "-o", build);
}

async function drawn(page) {
  await page.waitForSelector("canvas[data-drawn=yes]", { timeout: 60_000 });
}

// Opens a build's page in a window of its own.
async function opened(build, options = {}) {
  const context = await browser.newContext({ viewport: SIZES.desktop, ...options });
  const page = await context.newPage();
  page.errors = [];
  page.requests = [];
  page.on("pageerror", (error) => page.errors.push(error.message));
  page.on("dialog", (dialog) => page.errors.push(dialog.message()));
  page.on("console", (message) => message.type() === "error" && page.errors.push(message.text()));
  page.on("request", (request) => page.requests.push(request.url()));
  await page.goto(workshop.report(build));
  if (options.javaScriptEnabled !== false) await drawn(page);
  return page;
}

before(async () => {
  browser = await launch();
  design("light", { design: 'tone = "linear"' });
  design("code", { design: 'tone = "code"\nmethod = "product"', stack: "index = 1.49", viewer: "distance_mm = 300" });
});

after(async () => {
  await browser?.close();
  workshop.remove();
});

// A look as the page is asked for it, and as the command is.
function asked({ horizontal, vertical = 0, top = 1, bottom = 1, distance = null, ideal = false, gain }) {
  const arguments_ = ["--horizontal", horizontal, "--vertical", vertical, "--top", top, "--bottom", bottom];
  if (distance !== null) arguments_.push("--distance", distance);
  if (ideal) arguments_.push("--ideal");
  if (gain) arguments_.push("--gain", gain);
  return { look: { horizontal, vertical, top, bottom, distance, ideal, gain }, arguments_: arguments_.map(String) };
}

const bytesOfLook = (page, look, encode) =>
  page.evaluate(([look, encode]) => Array.from(lookAt(look, { encode }).bytes), [look, encode]).then(Buffer.from);

describe("the picture equals `vitrine view` to the last bit", () => {
  const near = { distance: 300 };
  const looks = [
    { horizontal: 30 },
    { horizontal: -30, top: 0 },
    { horizontal: 0, vertical: 20, bottom: 0.25 },
    { horizontal: 17.3, vertical: -12.1, top: 0.3, bottom: 0.9, distance: 412 },
    { horizontal: -44.4, vertical: 33, distance: 61, gain: 2.5 },
    { horizontal: 79.9, vertical: 5, distance: 1000 },
    { horizontal: 12.5, ideal: true },
    { horizontal: 3, vertical: 60, ideal: true, gain: 1 },
    { horizontal: 10, top: 0, bottom: 0 },
  ];
  for (const build of ["light", "code"]) {
    for (const wanted of looks) {
      // Without a distance `view` takes that of the exhibit.
      const look = build === "code" && !wanted.ideal ? { ...near, ...wanted } : wanted;
      test(`${build}: ${JSON.stringify(look)}`, async () => {
        const page = await (pages[build] ??= opened(build));
        const { look: request, arguments_ } = asked(look);
        assert.equal(differing(await bytesOfLook(page, request, false), workshop.view(build, ...arguments_)), "");
        if (build === "light") {
          const encoded = workshop.view(build, ...arguments_, "--encode");
          assert.equal(differing(await bytesOfLook(page, request, true), encoded), "");
        }
      });
    }
  }

  test("as the oblique viewer sees it undistorted", async () => {
    design("frame", { viewer: 'frame = "viewer"', views: [[25, -10], 0, -25] });
    const page = await opened("frame");
    for (const wanted of [{ horizontal: 25, vertical: -10 }, { horizontal: -61.7, vertical: 31.1, distance: 200 }]) {
      const { look, arguments_ } = asked(wanted);
      assert.equal(differing(await bytesOfLook(page, look, true), workshop.view("frame", ...arguments_, "--encode")), "");
    }
  });

  // An object, pages turned by the lamps, one view, and as many as are still told apart: each under the lamps of its plan.
  const HEAD = '[stack]\nfilms = 8\npixels = [64, 48]\nwidth_mm = 20.0\n[design]\nmethod = "product"\n';
  const view = (id, horizontal, more = "") =>
    `[[view]]\nid = "${id}"\npattern = ${JSON.stringify(workshop.photo("cat.jpg"))}\nhorizontal_deg = ${horizontal}\n${more}\n`;
  const exhibits = {
    object: '[object]\nmodel = "points.txt"\n',
    paging: view("one", 10, 'lamp = "top"') + view("other", 10, 'lamp = "bottom"'),
    single: view("only", 0),
    twelve: Array.from({ length: 12 }, (_, at) =>
      view(`view-${at}`, 24 * (at % 4) - 36, `vertical_deg = ${15 * Math.floor(at / 4) - 15}`),
    ).join(""),
  };
  for (const [build, tables] of Object.entries(exhibits)) {
    test(`as each view is seen: ${build}`, async () => {
      workshop.write("points.txt", "0 0 0 255 0 0\n8 3 1 0 255 0\n-8 -3 2 0 0 255\n4 -4 -2 255 255 255\n");
      workshop.write(`${build}.toml`, HEAD + tables);
      workshop.vitrine("design", `${build}.toml`, "-o", build);
      const page = await opened(build);
      const ids = await page.evaluate(() => stack.views.map((view) => view.id));
      assert.equal(await page.getByRole("button", { name: ids[0], exact: true }).count(), 1);
      for (const id of ids.slice(0, 3)) {
        const look = await page.evaluate((id) => {
          showView(stack.views.findIndex((view) => view.id === id));
          return currentLook();
        }, id);
        const { arguments_ } = asked(look);
        const wanted = workshop.view(build, ...arguments_, "--encode");
        assert.equal(differing(await bytesOfLook(page, look, true), wanted), "", id);
      }
      assert.deepEqual(page.errors, []);
      assert.deepEqual(await faults(page), []);
      await picture(page, `report-${build}`);
      await page.context().close();
    });
  }

  test("on the canvas, under a view's own lamps, when its button is pressed", async () => {
    const page = await opened("light");
    await page.getByRole("button", { name: "cat", exact: true }).click();
    await drawn(page);
    const seen = await page.evaluate(() => {
      const { width, height } = document.querySelector("canvas[data-sight=seen]");
      const context = document.querySelector("canvas[data-sight=seen]").getContext("2d");
      return Array.from(context.getImageData(0, 0, width, height).data);
    });
    const { top, bottom } = await page.evaluate(() => state);
    const { arguments_ } = asked({ horizontal: -30, top, bottom });
    assert.equal(differing(withoutAlpha(Buffer.from(seen)), workshop.view("light", ...arguments_, "--encode")), "");
  });

  const pages = {};
});

describe("the stack in three dimensions", () => {
  const scene = (page) => page.evaluate(() => document.querySelector(".turntable canvas").toDataURL());
  const where = (page) => page.evaluate(() => [state.horizontal, state.vertical, state.distance, state.far]);

  test("is turned by mouse, keys, wheel and buttons", async () => {
    const page = await opened("light");
    const canvas = page.locator(".turntable canvas");
    const first = await scene(page);
    const box = await canvas.boundingBox();
    await page.mouse.move(box.x + 200, box.y + 200);
    await page.mouse.down();
    await page.mouse.move(box.x + 260, box.y + 230, { steps: 4 });
    await page.mouse.up();
    await drawn(page);
    assert.deepEqual(await where(page), [10, 10, 600, true]);
    assert.notEqual(await scene(page), first);
    for (const key of ["ArrowRight", "Shift+ArrowUp", "ArrowLeft", "ArrowLeft", "ArrowDown"]) await page.keyboard.press(key);
    assert.deepEqual(await where(page), [9, 14, 600, true]);
    await page.keyboard.press("-");
    assert.deepEqual((await where(page)).slice(2), [660, false]);
    await page.mouse.wheel(0, -100);
    await page.waitForFunction(() => state.distance === 600);
    await page.keyboard.press("Home");
    assert.deepEqual((await where(page)).slice(0, 2), [30, 0]);
    assert.equal(await page.getByRole("button", { name: "astronaut" }).getAttribute("aria-pressed"), "true");
    assert.deepEqual(page.errors, []);
  });

  test("is turned by a finger, and two fingers come nearer", async () => {
    const page = await opened("light", { viewport: SIZES.phone, hasTouch: true, isMobile: true });
    const box = await page.locator(".turntable canvas").boundingBox();
    const devtools = await page.context().newCDPSession(page);
    const touch = (type, ...places) =>
      devtools.send("Input.dispatchTouchEvent", {
        type,
        touchPoints: places.map(([x, y], id) => ({ x: box.x + x, y: box.y + y, id })),
      });
    await touch("touchStart", [100, 100]);
    await touch("touchMove", [70, 100]);
    await touch("touchEnd");
    assert.deepEqual((await where(page)).slice(0, 2), [40, 0]);
    await touch("touchStart", [100, 100], [200, 100]);
    await touch("touchMove", [50, 100], [250, 100]);
    await touch("touchEnd");
    const [, , distance, far] = await where(page);
    assert.ok(distance < 400 && !far, `${distance}`);
  });

  test("comes apart, and each film can be left out", async () => {
    const page = await opened("light");
    const seen = (page) => page.evaluate(() => document.querySelector("canvas[data-sight=seen]").toDataURL());
    const pictures = [await scene(page)];
    await page.locator("[name=apart]").fill("6");
    await drawn(page);
    pictures.push(await scene(page));
    const whole = await seen(page);
    await page.getByText("Each film on and off").click();
    await page.getByLabel("3", { exact: true }).uncheck();
    await drawn(page);
    pictures.push(await scene(page));
    assert.equal(new Set(pictures).size, 3);
    assert.notEqual(await seen(page), whole);
    await page.getByRole("button", { name: "None" }).click();
    await drawn(page);
    assert.equal(await page.evaluate(() => lookAt(currentLook(), { weights: shownWeights(currentLook(), 0) }).bytes.some(Boolean)), false);
    await page.getByRole("button", { name: "All" }).click();
    await drawn(page);
    assert.equal(await seen(page), whole);
  });

  test("stands beside the pattern and the error of the nearest view", async () => {
    const page = await opened("light");
    await page.locator("[name=horizontal]").fill("-22");
    await drawn(page);
    assert.match(await page.locator("[data-told=pattern]").innerText(), /cat, the nearest view/);
    const decibels = async () => Number.parseFloat(await page.locator("[data-told=error]").innerText());
    const beside = await decibels();
    await page.locator("[name=horizontal]").fill("-30");
    await drawn(page);
    assert.equal(await page.locator("[data-told=pattern]").innerText(), "cat");
    assert.ok((await decibels()) > beside);
  });
});

describe("the page", () => {
  for (const [size, viewport] of Object.entries(SIZES)) {
    for (const colorScheme of ["light", "dark"]) {
      test(`has no fault of accessibility and does not overflow: ${size}, ${colorScheme}`, async () => {
        const page = await opened("light", { viewport, colorScheme });
        for (const details of await page.locator("summary").all()) await details.click();
        assert.deepEqual(await faults(page), []);
        const blank = await page.evaluate(() => [...document.querySelectorAll("canvas")].filter((shown) => !shown.dataset.drawn && shown.width === 300).length);
        assert.equal(blank, 0, "a canvas was never drawn on");
        assert.equal(await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth), 0);
        assert.deepEqual(page.errors, []);
        await picture(page, `report-${size}-${colorScheme}`);
      });
    }
  }

  test("fetches nothing, and may not", async () => {
    const page = await opened("light");
    assert.deepEqual(page.requests.filter((url) => !url.startsWith("data:")), [workshop.report("light")]);
    const refused = await page.evaluate(() => fetch("data:text/plain,no").then(() => "fetched", () => "refused"));
    assert.equal(refused, "refused");
  });

  test("holds all that was found out, and all that went in", async () => {
    const page = await opened("light");
    const text = await page.locator("body").innerText();
    for (const wanted of ["Cross-talk", "Brightness", "Spread", "Emphasis over the angle", "Day's budget", "exhibit.toml"]) {
      assert.ok(text.includes(wanted), wanted);
    }
    assert.equal(await page.locator("svg[role=img]").count(), 3);
    assert.match(await page.locator("pre").textContent(), /"daily_dose_j_m2": 30000/);
    assert.match(await page.locator(".hash").first().innerText(), /^[0-9a-f]{64}$/);
  });

  test("shows pictures where there is no WebGL2, and where there are no scripts", async () => {
    const blind = await launch("--disable-3d-apis");
    const page = await blind.newPage({ viewport: SIZES.phone });
    await page.goto(workshop.report("light"));
    const instead = page.locator(".pictures-instead");
    await page.waitForFunction(() => document.querySelector(".pictures-instead").textContent.includes("no WebGL2"));
    assert.ok((await instead.isVisible()) && !(await page.locator(".stage").isVisible()));
    assert.ok(await page.locator("article img").nth(1).isVisible());
    assert.deepEqual(await faults(page), []);
    await blind.close();

    const still = await opened("light", { javaScriptEnabled: false });
    assert.ok(!(await still.locator(".stage").isVisible()) && (await still.locator(".pictures-instead").isVisible()));
    assert.equal(await still.locator("article img").count(), 9);
  });

  test("prints on few sheets: a still of the stack, everything opened, no controls, and is as before afterwards", async () => {
    const page = await opened("light");
    await page.getByRole("button", { name: "cat", exact: true }).click();
    await page.locator("[name=vertical]").fill("20");
    await drawn(page);
    await page.emulateMedia({ media: "print", colorScheme: "dark" });
    assert.ok(!(await page.locator(".controls").isVisible()) && (await page.locator("article img").first().isVisible()));
    assert.ok(await page.locator(".turntable canvas").isVisible());
    const paper = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    assert.equal(paper, "rgb(255, 255, 255)");
    const folded = () => page.locator("details:not([open])").count();
    const before = await folded();
    assert.ok(before >= 3);
    await page.evaluate(() => addEventListener("beforeprint", () => (globalThis.foldedInPrint = document.querySelectorAll("details:not([open])").length)));
    const pdf = await page.pdf({ format: "A4" });
    assert.equal(await page.evaluate(() => globalThis.foldedInPrint), 0);
    assert.equal(await folded(), before);
    assert.match(
      await page.locator("[data-told=stack]").textContent(),
      /^The stack from 30° to the left, 20° above, far away; top lamp \d+ %, bottom lamp \d+ %\.$/,
    );
    const text = pdf.toString("latin1");
    const { width, height } = await page.evaluate(() => {
      const { width, height } = document.querySelector(".turntable canvas");
      return { width, height };
    });
    assert.ok(width >= 256, `${width}`);
    assert.match(text, new RegExp(`/Width ${width}\\s+/Height ${height}\\b`), "the stack is not in the print");
    const sheets = text.match(/\/Type \/Page\b/g).length;
    assert.ok(sheets >= 3 && sheets <= 7, `${sheets} sheets`);
    if (process.env.VITRINE_SCREENSHOTS) writeFileSync(`${process.env.VITRINE_SCREENSHOTS}/report.pdf`, pdf);
  });

  test("is ready to be printed when it is loaded", async () => {
    const context = await browser.newContext({ viewport: SIZES.phone });
    const page = await context.newPage();
    await page.addInitScript(() => addEventListener("load", () => (globalThis.readyWhenLoaded = ready)));
    await page.goto(workshop.report("light"), { waitUntil: "load" });
    assert.equal(await page.evaluate(() => globalThis.readyWhenLoaded), true);
  });

  test("is not broken into by a name", async () => {
    design("wicked", { name: WICKED });
    const page = await opened("wicked");
    assert.equal(await page.locator("h1").innerText(), WICKED);
    assert.equal(await page.title(), `${WICKED} - Vitrine`);
    assert.equal(await page.locator("img[src=x]").count(), 0);
    assert.deepEqual(page.errors, []);
  });
});

test("twenty films of 512 x 512 make a page of at most 25 MB that is drawn and turned", async () => {
  const text = exhibit(workshop, { name: "Large" }).replace("films = 8", "films = 20").replace("[96, 72]", "512");
  workshop.write("exhibit.toml", text.replace("iterations = 5", 'method = "product"'));
  workshop.vitrine("design", "exhibit.toml", "-o", "large");
  const { size } = statSync(workshop.path("large", "report.html"));
  assert.ok(size <= 25e6, `${size} bytes`);
  const page = await opened("large");
  const { look, arguments_ } = asked({ horizontal: 21.7, vertical: 3, distance: 500 });
  assert.equal(differing(await bytesOfLook(page, look, true), workshop.view("large", ...arguments_, "--encode")), "");
});
