// The page in Chromium, over a real daemon.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { test } from "node:test";
import { clickPiece, nextState, onObject, pieces, program, session, skip, whole } from "./harness.mjs";

let own, page, notes;

session("mug", ["--material", "ceramic", "--fragment-size", "0.018", "--quality", "draft"], (parts) => ({ own, page, notes } = parts));

test("hovering shows the contact, its radius and the threshold", { skip }, async () => {
  const at = await onObject(page);
  await page.mouse.move(at.x, at.y);
  await page.waitForFunction(() => document.getElementById("tooltip").textContent.includes("breaks at"), null, { timeout: 20_000 });
  assert.match(await page.textContent("#tooltip"), /mm · radius .* · breaks at .*N·s/);
  assert.match(await page.textContent("#strength"), /N·s/);
});

test("a click breaks the object, and a click on a piece breaks that", { skip }, async () => {
  const at = await onObject(page);
  await nextState(page, () => page.mouse.click(at.x, at.y));
  const first = await pieces(page);
  assert.ok(first > 1, `${first} pieces`);
  await page.waitForFunction(() => document.querySelector("#facts dd").textContent !== "…");
  assert.equal(await page.textContent("#facts dd"), `${first} of ${first}`, "all are closed");
  await page.waitForTimeout(700);
  await clickPiece(page);
  assert.ok((await pieces(page)) > first);
  await page.click("#back");
  assert.equal(await pieces(page), first);
  await page.click("#forward");
  assert.ok((await pieces(page)) > first);
  await whole(page);
  assert.equal(await pieces(page), 1);
});

test("the slider goes from whole to shattered across the threshold", { skip }, async () => {
  await whole(page);
  const at = await onObject(page);
  await nextState(page, () => page.mouse.click(at.x, at.y));
  const set = (factor) =>
    nextState(page, () =>
      page.evaluate((factor) => {
        const input = document.getElementById("impulse");
        input.value = String((1000 * Math.log(factor / 0.2)) / Math.log(500));
        input.dispatchEvent(new Event("input", { bubbles: true }));
      }, factor),
    );
  const counts = [];
  for (const factor of [0.5, 0.95, 1.06, 3, 20, 60]) {
    await set(factor);
    counts.push(await page.evaluate(() => globalThis.shatterView.app.history.now.last.result.fragments.length));
  }
  assert.deepEqual(counts.slice(0, 2), [0, 0], `${counts}`);
  assert.ok(counts[2] > 0 && counts[5] > counts[3] && counts[3] >= counts[2], `${counts}`);
  const states = await page.evaluate(() => globalThis.shatterView.app.history.count);
  assert.ok(states <= 3, `${states} states: the slider replaces the last one`);
});

test("20 random rays give the bytes of `shatter impact`", { skip }, async () => {
  const rays = Array.from({ length: 20 }, (_, i) => {
    const [u, v] = [((i * 0.754877) % 1) * 2 * Math.PI, Math.acos(1 - 2 * ((i * 0.569840 + 0.5) % 1))];
    const from = [Math.sin(v) * Math.cos(u), Math.cos(v), Math.sin(v) * Math.sin(u)];
    const target = [0.01 * Math.sin(i), 0.05 + 0.02 * Math.cos(3 * i), 0.01 * Math.cos(i)];
    return { origin: target.map((x, k) => x + from[k]), direction: from.map((x) => -x), impulse: 0.4 + 0.17 * i, seed: 7 * i };
  });
  let broken = 0;
  for (const { origin, direction, impulse, seed } of rays) {
    const ours = await page.evaluate(
      async ([origin, direction, impulse, seed]) => {
        const request = { object: "mug", ray: { originM: origin, direction }, impulseNs: impulse, settings: { quality: "", lift: "", seed } };
        const { app, impactOf } = globalThis.shatterView;
        const impact = impactOf(request, ["normals", "attributes", "bonds"], undefined);
        return app.connection.askResult({ op: "strike", object: "mug", impact, hashes: true }).then(
          (result) => ({ hashes: result.head.hashes, output: result.head.output_hash }),
          (error) => ({ error: error.kind }),
        );
      },
      [origin, direction, impulse, seed],
    );
    const args = ["impact", "mug", "--ray", [...origin, ...direction].join(","), "--impulse-ns", `${impulse}`, "--seed", `${seed}`];
    const theirs = await program(own, "shatter", [...args, "--enable", "normals,attributes,bonds", "--json"]).then(
      JSON.parse,
      (error) => JSON.parse(error.stdout),
    );
    if (theirs.error) {
      assert.equal(ours.error, theirs.error.kind);
      continue;
    }
    broken++;
    assert.equal(ours.output, theirs.output_hash);
    assert.deepEqual(ours.hashes, theirs.sections.map(({ name, hash }) => ({ name, hash })));
  }
  assert.ok(broken >= 12, `${broken} rays met the object`);
});

test("colors, X-ray, hulls, crack faces and explode change the picture", { skip }, async () => {
  await whole(page);
  const at = await onObject(page);
  await nextState(page, () => page.mouse.click(at.x, at.y));
  await page.waitForTimeout(900);
  // The picture of a movement may differ: pictures at rest are compared.
  const shown = async () => {
    await page.waitForFunction(() => !globalThis.shatterView.app.stage.isMoving && !globalThis.shatterView.app.stage.pending);
    return page.locator("#canvas").screenshot();
  };
  let before = await shown();
  const changes = async (what) => {
    const deadline = Date.now() + 10_000;
    let now = await shown();
    while (now.equals(before)) {
      assert.ok(Date.now() < deadline, `${what} changes nothing`);
      now = await shown();
    }
    before = now;
  };
  for (const click of ["input[value=pieces] + span", "input[value=energy] + span", "input[value=bonds] + span", "#xray + span", "#xray + span", "#hulls + span", "#cracks + span"]) {
    await page.click(click);
    await changes(click);
  }
  await page.click("#cracks + span");
  await page.click("#hulls + span");
  await page.click("input[value=surface] + span");
  await page.keyboard.press("Escape");
  before = await shown();
  await page.locator("#explode").fill("80");
  await changes("explode");
});

test("the keyboard alone strikes, turns and goes back", { skip }, async () => {
  await whole(page);
  await page.locator("#canvas").focus();
  await page.keyboard.press("ArrowLeft");
  await nextState(page, () => page.keyboard.press("Enter"));
  assert.ok((await pieces(page)) > 1);
  await page.keyboard.press("b");
  assert.equal(await pieces(page), 1);
});

test("downloads hold all pieces that are shown, of several requests", { skip }, async () => {
  await page.click("#forward");
  await page.waitForTimeout(800);
  await clickPiece(page);
  const shown = await pieces(page);
  const layers = await page.evaluate(() => globalThis.shatterView.app.history.now.layers.length);
  assert.ok(layers > 1, "pieces of two results");
  // The daemon forgets results in time: then the page repeats the requests.
  for (const forgets of [false, true]) {
    for (const [format, start, ending] of [["glb", "glTF", "glb"], ["obj", "PK", "zip"], ["mjcf", "PK", "zip"]]) {
      if (forgets) {
        await page.evaluate(() => {
          const { app } = globalThis.shatterView;
          for (const { request } of app.history.now.layers) if (request) app.handles.set(request, "999999999");
        });
      }
      const [download] = await Promise.all([page.waitForEvent("download"), page.click(`[data-format=${format}]`)]);
      const bytes = await readFile(await download.path());
      assert.ok(download.suggestedFilename().endsWith(ending));
      assert.equal(bytes.subarray(0, start.length).toString("latin1"), start);
      const text = bytes.toString("latin1");
      if (format === "glb") assert.equal(JSON.parse(text.slice(20, 20 + bytes.readUInt32LE(12))).meshes.length, shown);
      if (format === "mjcf") assert.equal(text.match(/<body /g).length, shown);
    }
  }
  assert.ok(await page.locator("#message").isHidden());
});

test("a lost graphics context comes back", { skip }, async () => {
  await page.evaluate(() => globalThis.shatterView.app.stage.loseContext(600));
  await page.waitForFunction(() => !document.getElementById("message").hidden, null, { timeout: 5000 });
  await page.waitForFunction(() => document.getElementById("message").hidden, null, { timeout: 10_000 });
  await page.waitForTimeout(800);
  const colors = await page.evaluate(() => {
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [80, 60];
    globalThis.shatterView.app.stage.picture(10, 10);
    copy.getContext("2d").drawImage(document.getElementById("canvas"), 0, 0, 80, 60);
    return new Set(new Uint32Array(copy.getContext("2d").getImageData(0, 0, 80, 60).data.buffer)).size;
  });
  assert.ok(colors > 20, `${colors} colors: something is drawn again`);
});

test("a daemon that was killed is started again", { skip }, async () => {
  const status = JSON.parse(await program(own, "shatter", ["status", "--json"]));
  process.kill(status.pid, "SIGKILL");
  await whole(page);
  const at = await onObject(page);
  await nextState(page, () => page.mouse.click(at.x, at.y));
  assert.ok((await pieces(page)) > 1);
  assert.ok(await page.locator("#message").isHidden());
});

test("nothing was loaded from elsewhere, and no error was reported", { skip }, async () => {
  assert.deepEqual(notes.foreign, []);
  assert.deepEqual(notes.errors.filter((text) => !text.includes("CONTEXT_LOST")), []);
});
