// A recording: one file that replays the requests without a service and without a network.
import assert from "node:assert/strict";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { stat } from "node:fs/promises";
import { after, before, test } from "node:test";
import { bake, browser, clickPiece, nextState, onObject, open, pieces, skip, view, whole, world } from "./harness.mjs";

let own, chrome;

before(async () => {
  if (skip) return;
  own = await world();
  chrome = await browser();
});

after(async () => {
  await chrome?.close();
  await own?.end();
});

/** Checksums of the results that are shown (FNV-1a), by section. Runs in the page. */
function checksums() {
  const of = (bytes) => bytes.reduce((hash, byte) => Math.imul(hash ^ byte, 0x01000193), 0x811c9dc5);
  return globalThis.shatterView.app.history.now.layers.map(({ pieces: { result } }) =>
    result.head.sections.map(({ name }) => [name, of(result.raw(name))]),
  );
}

test("a recording replays what was struck", { skip }, async () => {
  const database = await bake(own, "dumbbell", ["--quality", "draft", "--surface", "lattice"]);
  const file = join(own.folder, "requests.html");
  const server = await view(own, [database, "--record", file]);
  const { page, context } = await open(chrome, server.address);
  const at = await onObject(page);
  await nextState(page, () => page.mouse.click(at.x, at.y));
  const first = await pieces(page);
  await page.waitForTimeout(800);
  await clickPiece(page);
  const second = await pieces(page);
  const struck = await page.evaluate(checksums);
  await context.close();
  await server.end();
  assert.ok((await stat(file)).size > 10_000);
  const replayed = await open(chrome, pathToFileURL(file).href, { offline: true });
  await replayed.page.waitForFunction(() => globalThis.shatterView.app.history.count === 3, null, { timeout: 20_000 });
  assert.equal(await pieces(replayed.page), 1);
  await replayed.page.click("#forward");
  assert.equal(await pieces(replayed.page), first);
  await replayed.page.click("#forward");
  assert.equal(await pieces(replayed.page), second);
  assert.deepEqual(await replayed.page.evaluate(checksums), struck);
  assert.ok(await replayed.page.locator("#hulls + span").isHidden(), "a recording has no hulls");
  await replayed.page.keyboard.press("h");
  await replayed.page.waitForTimeout(200);
  assert.ok(await replayed.page.locator("#message").isHidden());
  await replayed.page.screenshot({ path: join(own.folder, "replay.png") });
  assert.deepEqual(replayed.notes.foreign, []);
  assert.deepEqual(replayed.notes.errors, []);
  await whole(replayed.page);
});
