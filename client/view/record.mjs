// Makes the recording and the pictures of the guide: `npm run record`. Needs the programs with the page in target/release, and Chromium.
import { stat, writeFile } from "node:fs/promises";
import { join, resolve } from "node:path";
import { bake, ball, browser, nextState, onObject, open, skip, view, whole, world } from "./tests/harness.mjs";

const GUIDE = resolve(import.meta.dirname, "../guide/src");

/** The page that the guide links. */
const FILE = join(GUIDE, "recordings/statue.html");

/** Largest file that is kept, bytes. */
const BYTES_MAX = 1_500_000;

/** Size of the pictures. */
const VIEWPORT = { width: 1280, height: 800 };

/** Time after which the pieces have moved apart and frames have all details, ms. */
const REST_MS = 2500;

/** Strikes the object where it is in the middle of the picture. */
async function strike(page) {
  const at = await onObject(page);
  await nextState(page, () => page.mouse.click(at.x, at.y));
  await page.waitForTimeout(REST_MS);
}

/** Strikes a statue twice, and keeps that as a page. */
async function record(own, chrome) {
  // Coarse lattices: the file holds each result whole.
  const database = await bake(own, "statue", ["--material", "marble", "--quality", "draft", "--surface", "lattice"]);
  const server = await view(own, [database, "--record", FILE]);
  const { page, context } = await open(chrome, server.address);
  await strike(page);
  await strike(page);
  await context.close();
  await server.end();
  const { size } = await stat(FILE);
  console.log(`${FILE}: ${size} bytes`);
  if (size > BYTES_MAX) throw new Error(`the recording is larger than ${BYTES_MAX} bytes`);
}

/** Pictures of a mug, and of a mesh with holes. */
async function takePictures(own, chrome) {
  const database = await bake(own, "mug", ["--material", "ceramic", "--fragment-size", "0.018"]);
  const server = await view(own, [database]);
  const { page, context } = await open(chrome, server.address, { viewport: VIEWPORT });
  const picture = async (name) => {
    await page.mouse.move(5, 300);
    await page.waitForFunction(() => document.getElementById("hint").textContent === "", null, { timeout: 10_000 });
    await page.waitForTimeout(REST_MS);
    await page.screenshot({ path: join(GUIDE, "pictures", name) });
  };
  await strike(page);
  await page.click("input[value=energy] + span");
  await page.evaluate(() => (document.getElementById("panel").scrollTop = 400));
  await picture("view-energy.png");
  await page.click("input[value=surface] + span");
  await page.evaluate(() => (document.getElementById("panel").scrollTop = 0));
  await strike(page);
  await picture("view.png");
  await whole(page);
  const file = join(own.folder, "ball.obj");
  await writeFile(file, ball(24, 32, [[12, 3], [14, 24]]));
  await page.setInputFiles("#file", file);
  await page.waitForFunction(() => document.querySelectorAll("#defects li").length > 1);
  await page.waitForTimeout(REST_MS);
  await page.screenshot({ path: join(GUIDE, "pictures/view-defects.png") });
  await context.close();
  await server.end();
}

if (skip) throw new Error(skip);
const own = await world();
const chrome = await browser();
await record(own, chrome);
await takePictures(own, chrome);
await chrome.close();
await own.end();
