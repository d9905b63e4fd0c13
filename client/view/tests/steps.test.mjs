// Steps of the history: each request and each change of it by the panel is one, and is what the pointer struck.
import assert from "node:assert/strict";
import { test } from "node:test";
import { clickPiece, nextState, onObject, pieces, session, skip, whole } from "./harness.mjs";

let page, notes;

session("mug", ["--material", "ceramic", "--fragment-size", "0.018", "--quality", "draft"], (parts) => ({ page, notes } = parts));

const count = () => page.evaluate(() => globalThis.shatterView.app.history.count);
const last = () =>
  page.evaluate(() => {
    const { request, result } = globalThis.shatterView.app.history.now.last;
    return { ray: request.ray, impulseNs: request.impulseNs, isWhole: result.isWhole };
  });

/** Moves the slider to multiples of the threshold, one after the other, and lets it go. */
async function slide(...factors) {
  for (const factor of factors) {
    await nextState(page, () =>
      page.evaluate((factor) => {
        const input = document.getElementById("impulse");
        input.value = String((1000 * Math.log(factor / 0.2)) / Math.log(500));
        input.dispatchEvent(new Event("input", { bubbles: true }));
      }, factor),
    );
  }
  await page.evaluate(() => document.getElementById("impulse").dispatchEvent(new Event("change", { bubbles: true })));
}

/** Strikes the whole object at six times the threshold. */
async function strike() {
  await whole(page);
  await page.evaluate(() => (document.getElementById("impulse").value = String((1000 * Math.log(6 / 0.2)) / Math.log(500))));
  const at = await onObject(page);
  await nextState(page, () => page.mouse.click(at.x, at.y));
  await page.waitForTimeout(900);
  return at;
}

test("each movement of the slider is a step that back and forward find", { skip }, async () => {
  await strike();
  const [first, steps] = [await pieces(page), await count()];
  await slide(3, 9, 20);
  const second = await pieces(page);
  assert.equal(await count(), steps + 1, "one movement is one step");
  await slide(0.5);
  assert.equal(await count(), steps + 2);
  assert.equal(await pieces(page), 1, "below the threshold the object is whole");
  await page.click("#back");
  assert.equal(await pieces(page), second);
  await page.click("#back");
  assert.equal(await pieces(page), first);
  await page.click("#forward");
  assert.equal(await pieces(page), second);
});

test("the slider repeats the request, wherever the pointer went since", { skip }, async () => {
  const at = await strike();
  const struck = await last();
  await page.mouse.move(at.x - 60, at.y + 40, { steps: 3 });
  await page.waitForTimeout(400);
  await slide(8);
  const again = await last();
  assert.deepEqual(again.ray, struck.ray);
  assert.ok(Math.abs(again.impulseNs / struck.impulseNs - 8 / 6) < 0.02, `${struck.impulseNs}, then ${again.impulseNs}`);
});

test("a request that breaks nothing keeps the result before it", { skip }, async () => {
  await strike();
  const [shown, impulse] = [await pieces(page), (await last()).impulseNs];
  await page.evaluate(() => (document.getElementById("impulse").value = "50"));
  await clickPiece(page);
  assert.equal((await last()).isWhole, true);
  assert.equal(await pieces(page), shown);
  await page.click("#back");
  assert.equal((await last()).impulseNs, impulse);
  assert.equal(await pieces(page), shown);
});

test("closed pieces are counted of the result that is shown", { skip }, async () => {
  await strike();
  await slide(20);
  const made = await page.evaluate(() => globalThis.shatterView.app.history.now.last.result.fragments.length);
  // Another result is shown while the pieces of the first are about to be counted.
  await page.evaluate(() => {
    const { app } = globalThis.shatterView;
    app.go(-1);
    app.go(1);
  });
  await page.waitForFunction(() => document.querySelector("#facts dd").textContent !== "…");
  assert.equal(await page.textContent("#facts dd"), `${made} of ${made}`);
});

test("the panel says whether there is a request to repeat", { skip }, async () => {
  await strike();
  assert.match(await page.textContent("#repeats"), /^The slider, preset, lift and seed repeat/);
  await whole(page);
  assert.match(await page.textContent("#repeats"), /^Strike the object first\. /);
});

test("away from what was struck the panel names no threshold", { skip }, async () => {
  await strike();
  assert.match(await page.textContent("#breaks"), /N·s/);
  await page.mouse.move(4, 300);
  await whole(page);
  assert.doesNotMatch(await page.textContent("#breaks"), /N·s/);
});

test("the headline counts all pieces that are shown", { skip }, async () => {
  await strike();
  assert.equal(await page.textContent("#pieces"), `${await pieces(page)} pieces`);
  await clickPiece(page);
  const shown = await pieces(page);
  assert.equal(await page.textContent("#pieces"), `${shown} pieces`);
  const made = await page.evaluate(() => globalThis.shatterView.app.history.now.last.result.fragments.length);
  assert.match(await page.textContent("#took"), new RegExp(`^${made} new, in `));
});

/** Meshes that are on the stage while a picture of the comparison is taken, with the number of pieces of each that are visible. */
async function compared() {
  return page.evaluate(async () => {
    const { app } = globalThis.shatterView;
    const { last } = app.history.now;
    const seen = [];
    const picture = app.stage.picture;
    app.stage.picture = () => {
      const shown = new Set(app.stage.group.children);
      const layers = [...app.history.pieces()].filter((pieces) => shown.has(pieces.mesh));
      seen.push(layers.reduce((sum, pieces) => sum + pieces.result.fragments.filter((_, id) => pieces.isVisible(id)).length, 0), shown.size - layers.length);
      return "";
    };
    app.pictureOf(last, last.result, last.request, 8, 8);
    app.stage.picture = picture;
    return seen;
  });
}

test("a comparison of a request that broke nothing shows the pieces alone", { skip }, async () => {
  await strike();
  const shown = await pieces(page);
  await page.evaluate(() => (document.getElementById("impulse").value = "50"));
  await clickPiece(page);
  assert.deepEqual(await compared(), [shown, 0]);
});

test("the scale of colors names its unit on both ends, and which request its values are of", { skip }, async () => {
  await strike();
  await page.click("input[value=energy] + span");
  assert.doesNotMatch(await page.textContent("#legend b"), /in the request/);
  await clickPiece(page);
  assert.match(await page.textContent("#legend b"), /in the request that made it/);
  const ends = await page.locator("#legend span").allTextContents();
  assert.ok(ends.every((text) => /J·m²$/.test(text)), ends.join(" to "));
  await page.click("input[value=bonds] + span");
  assert.ok((await page.locator("#legend span").allTextContents()).every((text) => /[cm]m²$/.test(text)));
  await whole(page);
  assert.ok(await page.locator("#legend").isHidden(), "the whole object has no values");
  await page.click("input[value=surface] + span");
});

test("no error was reported", { skip }, async () => {
  assert.deepEqual(notes.errors, []);
});
