// A recording: one file that replays the requests without a service and without a network.
import assert from "node:assert/strict";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { stat } from "node:fs/promises";
import { after, before, test } from "node:test";
import { bake, browser, clickPiece, nextState, onObject, open, pieces, skip, view, whole, world } from "./harness.mjs";

let own, chrome, server;

before(async () => {
  if (skip) return;
  own = await world();
  chrome = await browser();
});

after(async () => {
  await chrome?.close();
  await server?.end();
  await own?.end();
});

/** Checksums of the results that are shown (FNV-1a), by section. Runs in the page. */
function checksums() {
  const of = (bytes) => bytes.reduce((hash, byte) => Math.imul(hash ^ byte, 0x01000193), 0x811c9dc5);
  return globalThis.shatterView.app.history.now.layers.map(({ pieces: { result } }) =>
    result.head.sections.map(({ name }) => [name, of(result.raw(name))]),
  );
}

/** A click and the pointer do what a recording can: it has no service. */
async function nothingIsStruck(page) {
  const at = await onObject(page);
  await page.mouse.move(at.x, at.y);
  await page.mouse.click(at.x, at.y);
  assert.match(await page.textContent("#hint"), /nothing can be struck/);
  assert.ok(await page.locator("#tooltip").isHidden());
  assert.ok(await page.locator("#message").isHidden());
  assert.ok(!(await page.evaluate(() => globalThis.shatterView.app.stage.marks.visible && globalThis.shatterView.app.aim)));
  await page.keyboard.press("?");
  assert.doesNotMatch(await page.locator("#keys").innerText(), /strike|hulls/);
  await page.keyboard.press("Escape");
}

test("a recording replays what was struck", { skip }, async () => {
  const databases = [];
  for (const shape of ["dumbbell", "mug"]) databases.push(await bake(own, shape, ["--quality", "draft", "--surface", "lattice"]));
  const file = join(own.folder, "requests.html");
  server = await view(own, [...databases, "--record", file]);
  const { page, context } = await open(chrome, server.address);
  assert.equal(await page.inputValue("#object"), "mug", "the mug is first unless another object is asked for");
  const at = await onObject(page);
  await nextState(page, () => page.mouse.click(at.x, at.y));
  const first = await pieces(page);
  await page.waitForTimeout(800);
  // Hulls are another result of the request: they add no step, and the next request still finds its piece.
  await page.keyboard.press("h");
  await page.waitForFunction(() => {
    const { app } = globalThis.shatterView;
    return app.hulls.has(app.history.now.layers[0].request);
  });
  await page.keyboard.press("h");
  // A movement of the slider is one step, with the result at its end.
  for (const factor of [3, 9, 20]) {
    await nextState(page, () =>
      page.evaluate((factor) => {
        const input = document.getElementById("impulse");
        input.value = String((1000 * Math.log(factor / 0.2)) / Math.log(500));
        input.dispatchEvent(new Event("input"));
      }, factor),
    );
  }
  await page.evaluate(() => document.getElementById("impulse").dispatchEvent(new Event("change")));
  const slid = await pieces(page);
  await clickPiece(page);
  const second = await pieces(page);
  const [struck, impulse] = [await page.evaluate(checksums), await page.textContent("#facts dd >> nth=1")];
  await nextState(page, () => page.selectOption("#object", "dumbbell"));
  await clickPiece(page);
  const other = await pieces(page);
  await server.end();
  await page.waitForFunction(() => document.getElementById("message").textContent.includes("does not run any more"));
  assert.equal(await page.textContent("#hint"), "", "without a service nothing can be struck");
  await context.close();
  assert.ok((await stat(file)).size > 10_000);
  assert.match(server.notes(), /writing .*requests\.html/);
  const replayed = await open(chrome, pathToFileURL(file).href, { offline: true });
  await replayed.page.waitForFunction(() => globalThis.shatterView.app.history.count === 4, null, { timeout: 20_000 });
  assert.equal(await pieces(replayed.page), 1);
  // Longer than a hint stays that goes away by itself.
  await replayed.page.waitForTimeout(6500);
  assert.match(await replayed.page.textContent("#hint"), /^A recording: the button → shows the next result/);
  await replayed.page.click("#forward");
  assert.equal(await replayed.page.textContent("#hint"), "");
  assert.equal(await pieces(replayed.page), first);
  await replayed.page.click("#forward");
  assert.equal(await pieces(replayed.page), slid);
  await replayed.page.click("#forward");
  assert.equal(await pieces(replayed.page), second);
  assert.deepEqual(await replayed.page.evaluate(checksums), struck);
  assert.match(impulse, /N·s, 20 × the threshold/);
  assert.equal(await replayed.page.textContent("#facts dd >> nth=1"), impulse);
  assert.equal(await replayed.page.textContent("#object option:checked"), "mug (3)");
  await nothingIsStruck(replayed.page);
  await replayed.page.selectOption("#object", { label: "dumbbell (1)" });
  await replayed.page.click("#forward");
  assert.equal(await pieces(replayed.page), other, "the steps of the second object are kept");
  assert.ok(await replayed.page.locator("#hulls + span").isHidden(), "a recording has no hulls");
  await replayed.page.keyboard.press("h");
  await replayed.page.waitForTimeout(200);
  assert.ok(await replayed.page.locator("#message").isHidden());
  await replayed.page.screenshot({ path: join(own.folder, "replay.png") });
  assert.deepEqual(replayed.notes.foreign, []);
  assert.deepEqual(replayed.notes.errors, []);
  await whole(replayed.page);
});
