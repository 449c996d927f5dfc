// What a page looks like when it is opened:
//   node tests/browser/screenshot.mjs BUILD/report.html PICTURE.png

import { pathToFileURL } from "node:url";
import { launch } from "./browser.mjs";

const [file, picture] = process.argv.slice(2);
if (!picture) throw new Error("name a report.html and the picture to write");
const browser = await launch();
const page = await browser.newPage({ viewport: { width: 1200, height: 900 } });
await page.goto(pathToFileURL(file).href);
await page.waitForSelector("canvas[data-drawn=yes]", { timeout: 120_000 });
await page.screenshot({ path: picture });
await browser.close();
