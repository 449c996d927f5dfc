// `vitrine serve` in a real browser, against the simulated controller.

import assert from "node:assert/strict";
import http from "node:http";
import net from "node:net";
import { after, before, describe, test } from "node:test";
import { SIZES, Workshop, faults, launch, picture } from "./browser.mjs";

const workshop = new Workshop();
const running = [];
let browser;
let controller;

// Starts a command that says where it listens.
async function listening(...arguments_) {
  const child = workshop.start(...arguments_, "--json");
  running.push(child);
  let told = "";
  for await (const piece of child.stdout) {
    told += piece;
    try {
      return { child, ...JSON.parse(told) };
    } catch {
      // Not whole yet.
    }
  }
  throw new Error(`vitrine ${arguments_.join(" ")} ended: ${told}`);
}

function ended(child) {
  const gone = new Promise((resolve) => child.once("exit", resolve));
  child.kill("SIGKILL");
  return gone;
}

const simulated = (place) => listening("controller", "--listen", place, "--flash", "flash.bin");
const serveAt = (port, ...more) => listening("serve", "--listen", port, "--to", controller.listening, ...more);
const serve = (...more) => serveAt("0", ...more);

async function opened(address, options = {}) {
  const page = await browser.newPage({ viewport: SIZES.phone, ...options });
  page.errors = [];
  page.on("pageerror", (error) => page.errors.push(error.message));
  await page.goto(address);
  await connected(page);
  return page;
}

const connected = (page) => page.locator("#connection.there").waitFor();
const row = (page, what) => page.locator("#rows div").filter({ has: page.locator("dt", { hasText: what }) }).locator("dd");

// Asks without a browser, which would not let a page set these headers.
function asked(address, path, { method = "GET", headers = {}, body = "" } = {}) {
  const { hostname, port } = new URL(address);
  return new Promise((resolve, reject) => {
    const request = http.request({ hostname, port, path, method, headers }, (answer) => {
      let text = "";
      answer.on("data", (piece) => (text += piece));
      answer.on("end", () => resolve({ status: answer.statusCode, headers: answer.headers, text }));
    });
    request.on("error", reject);
    request.end(body);
  });
}

before(async () => {
  browser = await launch();
  const views = ["astronaut", "coffee", "cat"].map((id, index) =>
    `[[view]]\nid = "${id}"\npattern = ${JSON.stringify(workshop.photo(`${id}.jpg`))}\nhorizontal_deg = ${30 - 30 * index}\n`);
  const name = "<b>Small</b> & <script>document.title=1</script>";
  workshop.write("exhibit.toml", `[exhibit]\nname = ${JSON.stringify(name)}\n[stack]\nfilms = 8\npixels = 64\n[design]\nmethod = "product"\n${views.join("")}`);
  workshop.vitrine("design", "exhibit.toml", "-o", "build");
  controller = await simulated("tcp:0");
  workshop.vitrine("upload", "build", "--to", controller.listening);
});

after(async () => {
  await browser?.close();
  for (const child of running) child.kill("SIGKILL");
  workshop.remove();
});

describe("the page", () => {
  test("shows the exhibit live, in plain words, without commands", async () => {
    const { listening } = await serve();
    const page = await opened(listening);
    assert.match(await page.locator("h1").innerText(), /^<b>Small<\/b> & <script>/);
    for (const what of ["viewer", "view", "interlock", "boards", "dose today", "dose, life", "clock"]) {
      assert.notEqual(await row(page, what).first().innerText(), "", what);
    }
    assert.ok((await page.locator("#log li").count()) > 0);
    assert.ok(await page.getByText("Read-only").isVisible());
    assert.ok(!(await page.locator("#unlock").isVisible()) && !(await page.locator("#buttons").isVisible()));
    workshop.vitrine("dark", "--to", controller.listening);
    await row(page, "dark").waitFor();
    workshop.vitrine("release", "--to", controller.listening);
    await row(page, "dark").waitFor({ state: "detached" });
    assert.deepEqual(page.errors, []);
  });

  test("commands with the token alone", async () => {
    const { listening, token } = await serve("--commands");
    const page = await opened(listening);
    const unlock = async (text) => {
      await page.getByLabel("Access token").fill(text);
      await page.getByRole("button", { name: "Unlock" }).click();
    };
    for (const wrong of ["not-the-token-at-all", "nor thís"]) {
      await unlock(wrong);
      await page.getByText("this is not the access token").waitFor();
      assert.ok(!(await page.locator("#buttons").isVisible()));
      await page.evaluate(() => (document.getElementById("note").textContent = ""));
    }
    await unlock(token);
    await page.getByRole("button", { name: "Hold cat" }).click();
    await page.getByText("cat is held for 10 min").waitFor();
    await page.waitForFunction(() => document.getElementById("rows").textContent.includes("viewcat"));
    assert.match(await row(page, "asked for").innerText(), /^hold, dark or open, for another \d+ s/);
    await page.getByRole("button", { name: "Dark for an hour" }).click();
    await row(page, "dark").waitFor();
    await page.getByRole("button", { name: "Release" }).click();
    await row(page, "dark").waitFor({ state: "detached" });
    await page.getByRole("button", { name: "Re-arm" }).click();
    await page.getByText("re-arm asked for").waitFor();
    await page.reload();
    await connected(page);
    assert.ok(await page.getByRole("button", { name: "Hold cat" }).isVisible());
    await page.getByRole("button", { name: "Lock", exact: true }).click();
    assert.ok(await page.getByLabel("Access token").isVisible());
    assert.deepEqual(page.errors, []);
  });

  test("survives a controller that disappears and comes back", async () => {
    const { listening, token } = await serve("--commands");
    const page = await opened(listening);
    const { child, listening: place } = controller;
    await ended(child);
    await page.locator("#connection.away").waitFor();
    assert.match(await page.locator("#connection").innerText(), /^away: .+/);
    assert.match(await page.locator("#since").innerText(), /^for \d+ s$/);
    assert.equal((await asked(listening, "/status.json")).status, 503);
    await page.getByLabel("Access token").fill(token);
    await page.getByRole("button", { name: "Unlock" }).click();
    assert.ok(await page.getByRole("button", { name: "Hold cat" }).isDisabled());
    assert.match(await row(page, "interlock").innerText(), /armed/);
    controller = await simulated(place);
    await connected(page);
    assert.equal((await asked(listening, "/status.json")).status, 200);
    assert.ok(await page.getByRole("button", { name: "Hold cat" }).isEnabled());
  });

  test("survives a server that disappears and comes back", async () => {
    const first = await serve();
    const page = await opened(first.listening);
    await ended(first.child);
    await page.locator("#connection.away", { hasText: "vitrine serve does not answer" }).waitFor();
    await serveAt(new URL(first.listening).port);
    await connected(page);
  });

  for (const [size, viewport] of Object.entries(SIZES)) {
    for (const colorScheme of ["light", "dark"]) {
      test(`has no fault of accessibility and does not overflow: ${size}, ${colorScheme}`, async () => {
        const { listening, token } = await serve("--commands");
        const page = await opened(listening, { viewport, colorScheme, bypassCSP: true });
        await page.getByLabel("Access token").fill(token);
        assert.deepEqual(await faults(page), []);
        await page.getByRole("button", { name: "Unlock" }).click();
        assert.deepEqual(await faults(page), []);
        assert.equal(await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth), 0);
        await picture(page, `serve-${size}-${colorScheme}`);
      });
    }
  }
});

describe("the server", () => {
  test("tells the status as `vitrine status --json` does", async () => {
    const { listening } = await serve();
    const page = await opened(listening);
    const keys = (value) => (value && typeof value === "object" ? Object.entries(value).flatMap(([key, of]) => [key, ...keys(of)]) : []);
    const told = JSON.parse((await asked(listening, "/status.json")).text);
    const command = JSON.parse(workshop.vitrine("status", "--to", controller.listening, "--json"));
    assert.deepEqual(keys(told), keys(command));
    assert.equal(told.serial_number, command.serial_number);
    await page.close();
  });

  test("answers its own names and its own pages alone", async () => {
    const { listening, token } = await serve("--commands", "--name", "gallery.local");
    await opened(listening);
    const { host, port } = new URL(listening);
    const status = async (path, options) => (await asked(listening, path, options)).status;
    assert.equal(await status("/", { headers: { Host: `evil.example:${port}` } }), 421);
    assert.equal(await status("/", { headers: { Host: `gallery.local:${port}` } }), 200);
    assert.equal(await status("/events", { headers: { Origin: "http://evil.example" } }), 403);
    const good = { Host: host, Origin: `http://${host}`, "Content-Type": "application/json", Authorization: `Bearer ${token}` };
    const ask = (headers, body = '{"ask":"release"}') => status("/ask", { method: "POST", headers: { ...good, ...headers }, body });
    assert.equal(await ask({}), 202);
    assert.equal(await ask({ Origin: "http://evil.example" }), 403);
    assert.equal(await ask({ "Sec-Fetch-Site": "cross-site" }), 403);
    assert.equal(await ask({ "Content-Type": "text/plain" }), 403);
    assert.equal(await ask({ Authorization: "Bearer 0" }), 401);
    assert.equal(await ask({}, '{"ask":"new-stack"}'), 400);
    assert.equal(await ask({}, "x".repeat(5000)), 400);
    assert.equal(await status("/ask"), 403);
    assert.equal(await status("/nothing"), 404);
    const { headers } = await asked(listening, "/");
    assert.match(headers["content-security-policy"], /default-src 'none'.*frame-ancestors 'none'/);
    assert.equal(headers["access-control-allow-origin"], undefined);
  });

  test("lets no page of another site read or command", async () => {
    const { listening, token } = await serve("--commands");
    const { port } = new URL(listening);
    const page = await browser.newPage();
    await page.goto("about:blank");
    const tried = await page.evaluate(async ([address, token]) => {
      const outcome = (path, options) => fetch(address + path, options).then((answer) => `${answer.type} ${answer.status}`, () => "refused");
      return [
        await outcome("status.json"),
        await outcome("ask", { method: "POST", headers: { "Content-Type": "application/json", Authorization: `Bearer ${token}` }, body: '{"ask":"dark"}' }),
        await outcome("ask", { method: "POST", mode: "no-cors", headers: { "Content-Type": "text/plain" }, body: '{"ask":"dark"}' }),
      ];
    }, [listening, token]);
    assert.deepEqual(tried.slice(0, 2), ["refused", "refused"], `${port}`);
    assert.match(tried[2], /^(opaque 0|refused)$/);
    const watching = await opened(listening);
    assert.equal(await row(watching, "dark").count(), 0);
  });

  test("is read-only by default", async () => {
    const { listening } = await serve();
    await opened(listening);
    const { host } = new URL(listening);
    const headers = { Host: host, "Content-Type": "application/json", Authorization: "Bearer " };
    const { status, text } = await asked(listening, "/ask", { method: "POST", headers, body: '{"ask":"dark"}' });
    assert.deepEqual([status, /read-only/.test(text)], [403, true]);
  });

  test("outlives nonsense, and crowds of which nobody says anything", async () => {
    const { listening } = await serve();
    await opened(listening);
    const { hostname, port } = new URL(listening);
    const connect = () => new Promise((resolve, reject) => {
      const socket = net.connect(Number(port), hostname, () => resolve(socket));
      socket.on("error", reject);
    });
    const nonsense = await connect();
    nonsense.on("error", () => {});
    nonsense.end("\0\0 nonsense\r\n\r\n");
    const crowd = await Promise.all(Array.from({ length: 70 }, connect));
    for (const socket of crowd) socket.on("error", () => {});
    const page = async () => asked(listening, "/").then(({ status }) => status, () => 0);
    assert.notEqual(await page(), 200);
    for (const socket of crowd) socket.destroy();
    while ((await page()) !== 200) await new Promise((resolve) => setTimeout(resolve, 20));
  });
});
