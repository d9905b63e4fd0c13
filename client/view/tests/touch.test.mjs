// The page on a phone: a small screen, touched by one finger or two.
import assert from "node:assert/strict";
import { test } from "node:test";
import { nextState, onObject, pieces, session, skip, whole } from "./harness.mjs";

const phone = { viewport: { width: 390, height: 780 }, hasTouch: true, isMobile: true };
let page, touches, notes;

const take = async (parts) => {
  ({ page, notes } = parts);
  touches = await page.context().newCDPSession(page);
};

session("dumbbell", ["--quality", "draft", "--surface", "lattice"], take, phone);

/** Touches the screen with fingers that move along straight lines. */
async function fingers(from, to, steps = 8) {
  const at = (share) => from.map(({ x, y }, k) => ({ x: x + share * (to[k].x - x), y: y + share * (to[k].y - y), id: k }));
  await touches.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: at(0) });
  for (let step = 1; step <= steps; step++) {
    await touches.send("Input.dispatchTouchEvent", { type: "touchMove", touchPoints: at(step / steps) });
  }
  await touches.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
}

/** Place of the camera, relative to what it looks at. */
function camera() {
  return page.evaluate(() => {
    const { camera, controls } = globalThis.shatterView.app.stage;
    return camera.position.clone().sub(controls.target).toArray();
  });
}

const length = (vector) => Math.hypot(...vector);

test("a tap breaks the object", { skip }, async () => {
  const at = await onObject(page);
  await nextState(page, () => page.touchscreen.tap(at.x, at.y));
  assert.ok((await pieces(page)) > 1);
});

test("a drag turns, and breaks nothing", { skip }, async () => {
  const [count, before] = [await page.evaluate(() => globalThis.shatterView.app.history.count), await camera()];
  await fingers([{ x: 195, y: 250 }], [{ x: 275, y: 270 }]);
  await page.waitForTimeout(300);
  const after = await camera();
  const cosine = before.reduce((sum, x, axis) => sum + x * after[axis], 0) / (length(before) * length(after));
  assert.ok(cosine < 0.98, `cosine ${cosine}`);
  assert.ok(Math.abs(length(after) / length(before) - 1) < 0.01, "a drag keeps the distance");
  assert.equal(await page.evaluate(() => globalThis.shatterView.app.history.count), count);
});

test("two fingers that part come nearer", { skip }, async () => {
  const [count, before] = [await page.evaluate(() => globalThis.shatterView.app.history.count), await camera()];
  await fingers([{ x: 180, y: 250 }, { x: 210, y: 250 }], [{ x: 100, y: 250 }, { x: 290, y: 250 }]);
  await page.waitForTimeout(300);
  assert.ok(length(await camera()) < 0.8 * length(before));
  assert.equal(await page.evaluate(() => globalThis.shatterView.app.history.count), count);
});

test("a message does not cover the object, and the list of objects has room", { skip }, async () => {
  await page.evaluate(() => globalThis.shatterView.app.guarded(() => Promise.reject(new Error("a long message of many words. ".repeat(30)))));
  const box = (id) => page.locator(id).boundingBox();
  const [canvas, message, list] = [await box("#canvas"), await box("#message"), await box("header")];
  assert.ok(message.y >= canvas.y + canvas.height, `the message begins at ${message.y}`);
  assert.ok(message.y + message.height <= 780 && list.x + list.width <= 390);
  await page.click("#message button");
  // The longest name of a file that was opened.
  await page.evaluate(() => document.getElementById("object").add(new Option("teapot.obj (not baked)", "")));
  assert.ok((await box("#object")).width > 180);
  await page.evaluate(() => document.querySelector("#object option:last-child").remove());
});

test("the panel begins at its top for another object", { skip }, async () => {
  await whole(page);
  const top = () => page.evaluate(() => document.getElementById("panel").scrollTop);
  await page.evaluate(() => (document.getElementById("panel").scrollTop = 400));
  assert.ok((await top()) > 100);
  await page.evaluate(() => document.getElementById("object").dispatchEvent(new Event("input")));
  await page.waitForFunction(() => document.getElementById("panel").scrollTop === 0, null, { timeout: 20_000 });
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.equal(wide, 390, "nothing is wider than the screen");
  assert.deepEqual(notes.errors, []);
});
