// Measures the page and prints what it finds: the parts of the time from a request to its picture, and frames per second. Times depend
// on the machine: no time is asserted.
import assert from "node:assert/strict";
import { readFile, readdir } from "node:fs/promises";
import { test } from "node:test";
import { session, skip } from "./harness.mjs";

/** Requests of a measurement, after a few that are not counted. */
const REQUESTS = 15;

/** Size of the large result: so many sites give at least so many pieces and triangles. */
const LARGE = { sites: 450, fragments: 300, triangles: 100_000 };

/** Largest difference between the mean colors of a frame with all details and a fast one, of 255. */
const COLOR_DIFFERENCE_MAX = 12;

let page;

session("mug", ["--material", "ceramic", "--fragment-size", "0.018"], (parts) => ({ page } = parts));

/** Times of the parts of each request, ms; the order of the parts is that of time. */
async function partsOf(count) {
  return page.evaluate(async (count) => {
    const { app, settings } = globalThis.shatterView;
    app.go(-Infinity);
    const box = document.getElementById("canvas").getBoundingClientRect();
    const aim = app.pick(box.left + 0.42 * box.width, box.top + 0.55 * box.height) ?? app.pick(box.left + 0.5 * box.width, box.top + 0.5 * box.height);
    const thresholdNs = await app.threshold(aim, settings());
    const base = app.history.now;
    let arrived, parsed;
    app.connection.receive = function (data) {
      arrived = performance.now();
      Object.getPrototypeOf(this).receive.call(this, data);
      parsed = performance.now();
    };
    const draw = () => {
      app.stage.render(false);
      // Waits for the picture.
      app.stage.renderer.getContext().readPixels(0, 0, 1, 1, 6408, 5121, new Uint8Array(4));
    };
    // The service has the processor for itself: the page draws no frame at rest meanwhile.
    const rest = async () => {
      while (app.stage.isMoving || app.stage.pending) await new Promise((resolve) => setTimeout(resolve, 20));
      app.stage.renderer.getContext().readPixels(0, 0, 1, 1, 6408, 5121, new Uint8Array(4));
    };
    await rest();
    const rows = [];
    for (let at = 0; at < count + 4; at++) {
      const request = { ...app.requestOf(aim, thresholdNs, { ...settings(), seed: at }) };
      const begun = performance.now();
      const result = await app.resultOf(request, (effects) => effects);
      const asked = performance.now();
      const layer = app.layer(result, request);
      const built = performance.now();
      app.go(-Infinity);
      const before = performance.now();
      app.history.push({ layers: [layer], last: { request, result, pictureMs: 0 } });
      app.refresh();
      const ready = performance.now();
      if (at >= count) draw();
      const drawn = performance.now();
      const serviceMs = result.head.round_trip_ns / 1e6;
      rows.push({
        service: serviceMs,
        "message, socket": arrived - begun - serviceMs,
        parse: parsed - arrived,
        "reply to request": asked - parsed,
        pieces: built - asked,
        "panel, colors": ready - before,
        "request to picture": built - begun + (ready - before),
        "first frame": at >= count ? drawn - ready : undefined,
        fragments: result.fragments.length,
        triangles: result.integers("indices").length / 3,
        megabytes: result.bytes / 1e6,
      });
      layer.pieces.dispose();
      app.go(-Infinity);
      app.history.push(base);
      app.go(-Infinity);
      await rest();
    }
    delete app.connection.receive;
    return rows.slice(4);
  }, count);
}

const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];

test("the parts from a request to its picture", { skip }, async (context) => {
  const rows = await partsOf(REQUESTS);
  for (const name of Object.keys(rows[0])) {
    const values = rows.map((row) => row[name]).filter((value) => value !== undefined);
    context.diagnostic(`${name}: median ${median(values).toFixed(1)}, least ${Math.min(...values).toFixed(1)}`);
  }
  assert.ok(rows.every((row) => row.fragments > 1));
});

/** Clock ticks per second of /proc. */
const TICKS = 100;

/** CPU time of the process in which the browser of this file draws, s. */
async function drawingSeconds() {
  const text = (id, name) => readFile(`/proc/${id}/${name}`, "latin1").catch(() => "");
  const stat = async (id) => (await text(id, "stat")).replace(/^.*\) /, "").split(" ");
  const isOurs = async (id) => id === process.pid || (id > 1 && isOurs(Number((await stat(id))[1])));
  for (const id of (await readdir("/proc")).filter((name) => /^\d+$/.test(name))) {
    if (!(await text(id, "cmdline")).includes("--type=gpu-process") || !(await isOurs(Number(id)))) continue;
    const own = await stat(id);
    return (Number(own[11]) + Number(own[12])) / TICKS;
  }
  return NaN;
}

test("frames per second of a large result that is turned", { skip }, async (context) => {
  let drawing = 0;
  await page.exposeFunction("noteDrawing", async () => {
    drawing = await drawingSeconds();
  });
  const found = await page.evaluate(async (wanted) => {
    const { app, connection, impactOf, settings } = globalThis.shatterView;
    const { stage } = app;
    const request = { object: "mug", ray: { originM: [0, 0, 10], direction: [0, 0, -1] }, impulseNs: 1, settings: settings() };
    const impact = { ...impactOf(request, app.effectsOf("mug"), undefined), degree: wanted.sites, gamma_j_m2: 1e-9, surface: "lattice" };
    const result = await connection.askResult({ op: "strike", object: "mug", impact });
    const layer = app.layer(result, request);
    app.go(-Infinity);
    app.history.push({ layers: [layer], last: { request, result, pictureMs: 0 } });
    app.setExplode(0.22);
    app.refresh();
    const gl = stage.renderer.getContext();
    const turn = async () => {
      stage.orbit(0.05, 0);
      await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
      // Waits for the picture.
      gl.readPixels(0, 0, 1, 1, 6408, 5121, new Uint8Array(4));
    };
    for (let at = 0; at < 8; at++) await turn();
    await globalThis.noteDrawing();
    const [frames, begun] = [stage.frames, performance.now()];
    for (let at = 0; at < 20; at++) await turn();
    const seconds = (performance.now() - begun) / 1000;
    return {
      fragments: result.fragments.length,
      triangles: result.integers("indices").length / 3,
      perSecond: (stage.frames - frames) / seconds,
      frames: stage.frames - frames,
      scale: stage.renderer.getPixelRatio(),
      drawn: stage.renderer.info.render.triangles,
    };
  }, LARGE);
  const cpuMs = (1000 * (await drawingSeconds() - drawing)) / found.frames;
  context.diagnostic(`${JSON.stringify(found)}, ${cpuMs.toFixed(0)} ms of CPU time per frame`);
  assert.ok(found.fragments >= LARGE.fragments && found.triangles >= LARGE.triangles, JSON.stringify(found));
  assert.ok(found.frames >= 15, `${found.frames} frames`);
});

test("a frame while something moves has the colors of the frame at rest", { skip }, async () => {
  const means = await page.evaluate(() => {
    const { stage } = globalThis.shatterView.app;
    const copy = Object.assign(document.createElement("canvas"), { width: 96, height: 80 });
    const context = copy.getContext("2d", { willReadFrequently: true });
    return [false, true].map((isFast) => {
      stage.render(isFast);
      context.clearRect(0, 0, 96, 80);
      context.drawImage(stage.renderer.domElement, 0, 0, 96, 80);
      const { data } = context.getImageData(0, 0, 96, 80);
      const [sum, pixels] = [[0, 0, 0], data.length / 4];
      let count = 0;
      for (let at = 0; at < pixels; at++) {
        if (data[4 * at + 3] < 250) continue;
        count++;
        for (let k = 0; k < 3; k++) sum[k] += data[4 * at + k];
      }
      return [...sum.map((value) => value / count), count];
    });
  });
  const [rest, fast] = means;
  for (let k = 0; k < 3; k++) assert.ok(Math.abs(rest[k] - fast[k]) < COLOR_DIFFERENCE_MAX, JSON.stringify(means));
  assert.ok(Math.abs(rest[3] - fast[3]) < 0.05 * rest[3], JSON.stringify(means));
});
