// What the panel says: it belongs to the result that is shown, and its numbers agree.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { join, resolve } from "node:path";
import { test } from "node:test";
import { build } from "esbuild";
import { clickPiece, nextState, onObject, session, skip, whole } from "./harness.mjs";

let own, page, notes;

session("mug", ["--material", "ceramic", "--fragment-size", "0.018", "--quality", "draft"], (parts) => ({ own, page, notes } = parts));

const factor = () => page.evaluate(() => 0.2 * 500 ** (Number(document.getElementById("impulse").value) / 1000));
const text = (selector) => page.locator(selector).innerText();

/** Moves the slider to a multiple of the threshold, as a user who lets it go. */
function slide(multiple) {
  return page.evaluate((multiple) => {
    const input = document.getElementById("impulse");
    input.value = String((1000 * Math.log(multiple / 0.2)) / Math.log(500));
    for (const kind of ["input", "change"]) input.dispatchEvent(new Event(kind, { bubbles: true }));
  }, multiple);
}

/** Strikes the whole object at six times the threshold. */
async function strike() {
  await whole(page);
  await slide(6);
  const at = await onObject(page);
  await nextState(page, () => page.mouse.click(at.x, at.y));
  await page.waitForTimeout(900);
}

test("a drop height is a multiple of the threshold height that the text names", { skip }, async () => {
  await strike();
  assert.match(await text("#breaks"), /^6 × the threshold of [\d.]+ m?N·s$/);
  await page.click("input[value=drop] + span");
  const said = await text("#breaks");
  const [, times, threshold] = said.match(/^(\d+) × the threshold of ([\d.]+ \w+) \(6 × the impulse\)$/) ?? assert.fail(said);
  const metersOf = (length) => Number.parseFloat(length) * { m: 1, cm: 0.01, mm: 0.001 }[length.split(" ")[1]];
  const ratio = metersOf(await text("#strength")) / metersOf(threshold);
  assert.ok(Math.abs(ratio / Number(times) - 1) < 0.03, `${await text("#strength")}: ${said}`);
  await page.click("input[value=impulse] + span");
});

test("back and forward set the slider, the preset and the seed to those of the result", { skip }, async () => {
  await strike();
  const rows = () => page.locator("#facts dd").allTextContents();
  const first = await rows();
  assert.match(first[1], /^[\d.]+ m?N·s, 6 × the threshold$/);
  await nextState(page, () => slide(2));
  await nextState(page, () => page.selectOption("#lift", "euclidean"));
  await nextState(page, () => page.fill("#seed", "5"));
  await page.click("#back");
  await page.click("#back");
  await page.click("#back");
  assert.ok(Math.abs((await factor()) - 6) < 0.05, `${await factor()}`);
  assert.deepEqual([await page.inputValue("#lift"), await page.inputValue("#seed")], ["", "0"]);
  assert.equal((await rows())[1], first[1]);
  assert.match(await text("#breaks"), /^6 × the threshold of/);
  // The slider repeats the request that is shown.
  const last = () => page.evaluate(() => globalThis.shatterView.app.history.now.last.request);
  const before = await last();
  await nextState(page, () => slide(12));
  const after = await last();
  assert.deepEqual([after.ray, after.settings], [before.ray, before.settings]);
  assert.ok(Math.abs(after.impulseNs / before.impulseNs - 2) < 0.02, `${before.impulseNs}, then ${after.impulseNs}`);
  await page.click("#back");
  assert.ok(Math.abs((await factor()) - 6) < 0.05, `${await factor()}`);
});

test("colors by energy say what they mean, and why the whole object has none", { skip }, async () => {
  await strike();
  await page.click("input[value=energy] + span");
  assert.match(await text("#legend b"), /squared distance .* \((linear colors from 0|logarithmic colors: .* more than 100)\)$/);
  const units = [...(await page.locator("#legend span").allTextContents()), (await text("#color-note")).match(/γ = ([\d.,]+ \S+m²)/)[1]];
  assert.equal(new Set(units.map((value) => value.split(" ")[1])).size, 1, units.join("; "));
  assert.match(await text("#color-note"), /estimate of the least with which none exceeds γ; some still can/);
  const [low, high, gamma] = units.map((value) => Number.parseFloat(value.replaceAll(",", "")));
  if (/linear/.test(await text("#legend b"))) {
    assert.equal(low, 0);
    const left = await page.evaluate(() => Number.parseFloat(document.querySelector("#legend em").style.left));
    assert.equal(await page.locator("#legend em").isVisible(), gamma <= high);
    assert.ok(gamma > high || Math.abs(left - (100 * gamma) / high) < 1, `${left} % of the ramp, ${gamma} of ${high}`);
  }
  await page.click("input[value=bonds] + span");
  assert.ok(await page.locator("#legend em").isHidden(), "an area has no threshold");
  await whole(page);
  await page.click("input[value=energy] + span");
  assert.match(await text("#color-note"), /strike it/);
  await page.click("input[value=surface] + span");
  assert.ok(await page.locator("#color-note").isHidden());
});

test("the histogram counts pieces", { skip }, async () => {
  await strike();
  const labels = await page.locator("#volumes text").allTextContents();
  const bars = await page.locator("#volumes rect").count();
  const count = await page.evaluate(() => globalThis.shatterView.app.history.now.last.result.fragments.length);
  const times = await page.locator("#stages b").allTextContents();
  assert.equal(new Set(times.map((time) => time.split(" ").at(-1))).size, 1, times.join("; "));
  assert.ok(labels.includes("0") && labels.some((label) => Number(label) >= count / bars && Number(label) <= count), labels.join("; "));
});

test("side by side belongs to the result that is shown, and refuses what pieces lack in plain words", { skip }, async () => {
  await strike();
  await clickPiece(page);
  await page.evaluate(() => (document.getElementById("compare").open = true));
  assert.match(await text("#compare > .note"), /same impulse/);
  await page.click("#run-compare");
  await page.waitForFunction(() => document.querySelectorAll("#compared figure").length === 7 && !document.getElementById("run-compare").disabled, null, { timeout: 90_000 });
  const told = await page.locator("#compared figure").allInnerTexts();
  assert.match(told[6], /not for pieces/);
  assert.match(told[0], /gap of the cells [\d.]+ %/);
  await whole(page);
  assert.equal(await page.locator("#compared figure").count(), 0, "the whole object has no pictures");
  await strike();
  await page.click("#run-compare");
  await page.waitForFunction(() => document.querySelectorAll("#compared figure").length > 1);
  await whole(page);
  await page.waitForFunction(() => !document.getElementById("run-compare").disabled, null, { timeout: 30_000 });
  assert.equal(await page.locator("#compared figure").count(), 0, "a comparison under way ends");
});

test("controls keep their places", { skip }, async () => {
  await strike();
  const box = () => page.evaluate(() => {
    const [first, button] = ["shell", "c"].map((name) => document.querySelector(`[data-language=${name}]`).getBoundingClientRect());
    return { top: button.top - first.top, left: button.left, width: button.width };
  });
  const before = await box();
  await page.click("[data-language=c]");
  await page.waitForFunction(() => document.querySelector("[data-language=c]").textContent === "✓");
  assert.deepEqual(await box(), before, "the button keeps its place and its size");
  const [tick, slider] = await Promise.all(["#ticks span:last-child", "#impulse"].map((selector) => page.locator(selector).boundingBox()));
  assert.ok(tick.x + tick.width <= slider.x + slider.width + 0.5, "100× ends with the slider");
});

test("lengths side by side have one unit", { skip }, async () => {
  await whole(page);
  const at = await onObject(page);
  await page.mouse.move(at.x, at.y);
  await page.waitForFunction(() => !document.getElementById("tooltip").hidden);
  assert.match(await text("#tooltip"), /^-?\d+, -?\d+, -?\d+ mm · radius [\d.]+ mm/);
  await page.evaluate(() => (document.getElementById("art").open = true));
  await page.click("input[value=site] + span");
  await page.mouse.move(at.x + 1, at.y);
  await page.mouse.move(at.x, at.y);
  const shown = (await text("#tooltip")).match(/^(.*) mm/)[1];
  await page.mouse.click(at.x, at.y);
  assert.equal((await text("#art-list li")).match(/at (.*) mm/)[1], shown, "both name one place");
  await page.click("#undo");
  await page.click("input[value=paint] + span");
  await page.mouse.click(at.x, at.y);
  assert.equal((await text("#art-list li")).match(/radius (.*)/)[1], await text("#tool-radius-value"));
  await page.click("#undo");
  await page.click("input[value=strike] + span");
  await page.evaluate(() => (document.getElementById("art").open = false));
});

test("a place has as many digits as the size of its object needs", { skip }, async () => {
  const file = join(own.folder, "format.mjs");
  await build({ entryPoints: [resolve(import.meta.dirname, "../page/format.ts")], bundle: true, format: "esm", outfile: file });
  const { place } = await import(file);
  assert.equal(place([0.0123, -0.0001, 1], 0.15), "12, 0, 1000");
  assert.equal(place([0.0000123, -0.0001, 0], 0.0005), "0.012, -0.100, 0.000");
});

test("the label follows the wheel, and goes with what it was about", { skip }, async () => {
  await whole(page);
  // The events of a wheel have whole pixels.
  const { x, y } = await onObject(page);
  const at = { x: Math.round(x), y: Math.round(y) };
  await page.mouse.move(at.x, at.y);
  const shown = () => page.locator("#tooltip").innerText().then((told) => told.match(/^(.*?) mm/)[1]);
  const before = await shown();
  await page.mouse.wheel(0, -800);
  await page.waitForTimeout(300);
  const there = await page.evaluate(({ x, y }) => {
    const { app } = globalThis.shatterView;
    return app.placeOf(app.pick(x, y)).map((x) => Math.round(1000 * x) + 0).join(", ");
  }, at);
  assert.notEqual(there, before, "the camera has moved");
  assert.equal(await shown(), there);
  await page.mouse.wheel(0, 800);
  await page.evaluate(() => globalThis.shatterView.app.refresh());
  assert.ok(await page.locator("#tooltip").isHidden(), "another state is shown");
});

test("what stays whole is not called broken", { skip }, async () => {
  await strike();
  await nextState(page, () => slide(0.5));
  for (const [format, name] of [["glb", "mug.glb"], ["obj", "mug-obj.zip"]]) {
    const [download] = await Promise.all([page.waitForEvent("download"), page.click(`[data-format=${format}]`)]);
    assert.equal(download.suggestedFilename(), name);
  }
});

test("the page says what a model for MuJoCo does with the pieces", { skip }, async () => {
  await strike();
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("[data-format=mjcf]")]);
  assert.equal(download.suggestedFilename(), "mug-broken-mjcf.zip");
  assert.match((await readFile(await download.path())).toString("latin1"), /<weld name="bond_/);
  await page.waitForFunction(() => /welds touching pieces/.test(document.getElementById("away-note").textContent));
});

test("no error was reported", { skip }, async () => {
  assert.deepEqual(notes.errors, []);
});
