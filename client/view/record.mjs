// Makes the recording of the guide: `npm run record`. Needs the programs with the page in target/release, and Chromium.
import { stat } from "node:fs/promises";
import { resolve } from "node:path";
import { bake, browser, nextState, onObject, open, skip, view, world } from "./tests/harness.mjs";

/** The page that the guide links. */
const FILE = resolve(import.meta.dirname, "../guide/src/recordings/statue.html");

/** Largest file that is kept, bytes. */
const BYTES_MAX = 1_500_000;

if (skip) throw new Error(skip);
const own = await world();
// Coarse lattices: the file holds each result whole.
const database = await bake(own, "statue", ["--material", "marble", "--quality", "draft", "--surface", "lattice"]);
const server = await view(own, [database, "--record", FILE]);
const chrome = await browser();
const { page, context } = await open(chrome, server.address);
for (let request = 0; request < 2; request++) {
  const at = await onObject(page);
  await nextState(page, () => page.mouse.click(at.x, at.y));
  await page.waitForTimeout(800);
}
await context.close();
await chrome.close();
await server.end();
await own.end();
const { size } = await stat(FILE);
console.log(`${FILE}: ${size} bytes`);
if (size > BYTES_MAX) throw new Error(`the recording is larger than ${BYTES_MAX} bytes`);
