// What the picture holds: all pieces, marks on them, and the tooltip.
import assert from "node:assert/strict";
import { test } from "node:test";
import { nextState, onObject, session, skip, whole } from "./harness.mjs";

let page, notes;

session("mug", ["--material", "ceramic", "--fragment-size", "0.018", "--quality", "draft"], (parts) => ({ page, notes } = parts));

/** Farthest that a vertex of a piece is from the middle of the picture, as a share of half its size. Runs in the page. */
function farthest() {
  const { app } = globalThis.shatterView;
  const { camera } = app.stage;
  camera.updateMatrixWorld();
  let most = 0;
  for (const { pieces } of app.history.now.layers) {
    const [positions, factor] = [pieces.result.floats("positions"), 1 + app.look.uniforms.uExplode.value];
    pieces.result.fragments.forEach((fragment, id) => {
      if (!pieces.isVisible(id)) return;
      const place = fragment.centerM.map((x, axis) => (x - pieces.centerM[axis]) * factor);
      for (let at = 3 * fragment.vertexFirst; at < 3 * (fragment.vertexFirst + fragment.vertexCount); at += 30) {
        const point = camera.position.clone().set(...place.map((x, axis) => x + positions[at + axis])).project(camera);
        most = Math.max(most, Math.abs(point.x), Math.abs(point.y));
      }
    });
  }
  return most;
}

test("pieces that are moved apart stay in the picture", { skip }, async () => {
  const before = await page.evaluate(farthest);
  const at = await onObject(page);
  await nextState(page, () => page.mouse.click(at.x, at.y));
  await page.waitForTimeout(900);
  await page.locator("#explode").fill("100");
  const apart = await page.evaluate(farthest);
  assert.ok(apart > 0.4 && apart < 1, `${apart} of half the picture`);
  await whole(page);
  assert.equal(await page.textContent("#hint"), "", "the hint was about pieces");
  const again = await page.evaluate(farthest);
  assert.ok(Math.abs(again - before) < 0.01, `${before} at first, ${again} when whole again`);
});

test("a mark is where it was clicked, and moves with its piece", { skip }, async () => {
  const at = await onObject(page);
  await nextState(page, () => page.mouse.click(at.x, at.y));
  await page.waitForTimeout(900);
  await page.evaluate(() => (document.getElementById("art").open = true));
  await page.click("input[value=anchor] + span");
  assert.match(await page.textContent("#tool-note"), /Holds/);
  const place = await onObject(page);
  await page.mouse.move(place.x, place.y);
  const tooltip = await page.textContent("#tooltip");
  const seen = await page.evaluate(({ x, y }) => globalThis.shatterView.app.pick(x, y).pick.shown.toArray(), place);
  await page.mouse.click(place.x, place.y);
  const marks = () => page.evaluate(() => globalThis.shatterView.app.stage.marks.children.map((mark) => mark.position.toArray()));
  const gap = (one, other) => Math.hypot(...one.map((x, axis) => x - other[axis]));
  assert.ok(gap((await marks())[0], seen) < 1e-6, "the mark is where the pointer is");
  const [listed] = await page.locator("#art-list li").allTextContents();
  assert.equal(listed.match(/at (.*) mm,/)[1], tooltip.match(/^(.*?) mm/)[1], "both name one place");
  assert.match(tooltip, /anchor, radius/);
  const slid = await page.evaluate(() => {
    const { app } = globalThis.shatterView;
    const { centerM, carried } = { centerM: app.history.now.layers.map(({ pieces }) => pieces), carried: globalThis.shatterView.art.marks[0].carried.toArray() };
    app.setExplode(1);
    const places = centerM.flatMap((pieces) => pieces.result.fragments.map((row) => row.centerM.map((x, axis) => x - pieces.centerM[axis])));
    return { carried, places };
  });
  assert.ok(slid.places.some((own) => gap(own, slid.carried) < 1e-6), "it is carried by a piece");
  // Pictures of the comparison show pieces alone.
  const [marked, bare] = await page.evaluate(() => {
    const { stage } = globalThis.shatterView.app;
    const marked = stage.picture(120, 100);
    stage.marks.visible = false;
    stage.ring.visible = false;
    return [marked, stage.picture(120, 100)];
  });
  assert.ok(marked === bare, "the mark is in no picture");
  await whole(page);
  const rest = await page.evaluate(() => globalThis.shatterView.art.marks[0].rest.toArray());
  assert.ok(gap((await marks())[0], rest) < 1e-9, "on the whole object it is at rest");
  await page.click("input[value=strike] + span");
});

test("the tooltip stays in the picture", { skip }, async () => {
  await page.setViewportSize({ width: 390, height: 844 });
  await page.waitForTimeout(300);
  const at = await onObject(page);
  await page.mouse.move(at.x + 40, at.y);
  await page.waitForFunction(() => document.getElementById("tooltip").textContent.includes("breaks at"), null, { timeout: 20_000 });
  const box = await page.locator("#tooltip").boundingBox();
  assert.ok(box.x >= 0 && box.x + box.width <= 390, JSON.stringify(box));
  await page.setViewportSize({ width: 1100, height: 720 });
});

test("the rule of the slider names the multiple that it is set to", { skip }, async () => {
  const gap = await page.evaluate(() => {
    const [slider, ticks] = [document.getElementById("impulse"), [...document.querySelectorAll("#ticks span")]];
    const box = slider.getBoundingClientRect();
    const lineOf = (tick) => tick.getBoundingClientRect().left + Number.parseFloat(getComputedStyle(tick, "::before").left);
    return ticks.map((tick) => {
      const share = Math.log(Number.parseFloat(tick.textContent) / 0.2) / Math.log(500);
      return Math.abs(lineOf(tick) - (box.left + 8 + share * (box.width - 16)));
    });
  });
  assert.ok(gap.length >= 5 && Math.max(...gap) < 1, `${gap}`);
});

test("nothing of the panel is wider than it, and rows of choices do not break", { skip }, async () => {
  for (const width of [1280, 800, 390]) {
    await page.setViewportSize({ width, height: 844 });
    const found = await page.evaluate(() => {
      document.getElementById("art").open = true;
      const panel = document.getElementById("panel");
      const rows = ["by", "tools"].map((id) => new Set([...document.querySelectorAll(`#${id} label`)].map((label) => label.offsetTop)).size);
      const cut = [...panel.querySelectorAll("label > span")].filter((own) => own.scrollWidth > own.clientWidth + 1).map((own) => own.textContent);
      return { rows, cut, wide: panel.scrollWidth - panel.clientWidth };
    });
    assert.deepEqual(found, { rows: [1, 1], cut: [], wide: 0 }, `at ${width} pixels`);
  }
  await page.setViewportSize({ width: 1100, height: 720 });
});

test("no error was reported", { skip }, async () => {
  assert.deepEqual(notes.errors, []);
});
