// What the tests share: programs, databases, a running `shatter view`, and Chromium.
import { spawn, execFile } from "node:child_process";
import { existsSync } from "node:fs";
import { mkdtemp, mkdir, readFile, readdir, rm } from "node:fs/promises";
import { request } from "node:http";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { after, before } from "node:test";
import { promisify } from "node:util";
import { chromium } from "playwright-core";

const run = promisify(execFile);

/** Folder of the programs `shatter` (with the feature `view`) and `shatterd`. */
export const programs = process.env.SHATTER_PROGRAMS ?? resolve(import.meta.dirname, "../../../target/release");

/** Path of Chromium; `undefined` if there is none. */
export const browserPath = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(existsSync);

/** A reason to skip what needs the programs alone, or false. */
export const skipPrograms = existsSync(join(programs, "shatterd")) ? false : "no shatterd";

/** A reason to skip what needs a browser, or false. */
export const skip = browserPath ? skipPrograms : "no Chromium";

/** Time after which the tests of a file end, whatever still runs, ms. */
const FILE_TIMEOUT_MS = 900_000;

/** Processes that this file started and that have not ended. */
const started = new Set();

/** Kills what is left by its ids. */
function killStarted() {
  for (const child of started) child.kill("SIGKILL");
}

process.on("exit", killStarted);
setTimeout(() => {
  console.error(`the tests of this file did not end within ${FILE_TIMEOUT_MS / 1000} s`);
  process.exit(1);
}, FILE_TIMEOUT_MS).unref();

/** A folder of this run, with an environment that keeps it apart from other services. */
export async function world() {
  const folder = await mkdtemp(join(tmpdir(), "shatter-view-test-"));
  const env = { ...process.env, XDG_RUNTIME_DIR: join(folder, "run"), XDG_DATA_HOME: join(folder, "data"), TMPDIR: join(folder, "temporary"), SHATTER_SERVICE: `view-test-${process.pid}` };
  await mkdir(env.XDG_RUNTIME_DIR, { mode: 0o700 });
  await mkdir(env.TMPDIR);
  return { folder, env, end: () => rm(folder, { recursive: true, force: true }) };
}

/** Runs a program to its end, and returns what it prints. */
export async function program(world, name, args) {
  const running = run(join(programs, name), args, { env: world.env, maxBuffer: 1 << 28 });
  started.add(running.child);
  try {
    return (await running).stdout;
  } finally {
    started.delete(running.child);
  }
}

/** Bakes a generated shape; returns the path of its database. */
export async function bake(world, shape, args = []) {
  await program(world, "shatterd", ["bake", "--shape", shape, "--out", join(world.folder, "databases"), ...args]);
  return join(world.folder, "databases", `${shape}.shatter`);
}

/** A ball as OBJ, without the faces around the vertices `holes`, each a row and a column. */
export function ball(rows, columns, holes = []) {
  const lines = [];
  for (let i = 0; i <= rows; i++) {
    for (let j = 0; j < columns; j++) {
      const [u, v] = [(2 * Math.PI * j) / columns, (Math.PI * i) / rows];
      lines.push(`v ${(0.1 * Math.sin(v) * Math.cos(u)).toFixed(6)} ${(0.1 * Math.cos(v)).toFixed(6)} ${(0.1 * Math.sin(v) * Math.sin(u)).toFixed(6)}`);
    }
  }
  const at = (i, j) => i * columns + (j % columns) + 1;
  const open = new Set(holes.map(([i, j]) => at(i, j)));
  for (let i = 0; i < rows; i++) {
    for (let j = 0; j < columns; j++) {
      for (const face of [[at(i, j), at(i, j + 1), at(i + 1, j)], [at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]]) {
        if (!face.some((corner) => open.has(corner))) lines.push(`f ${face.join(" ")}`);
      }
    }
  }
  return lines.join("\n") + "\n";
}

/** Starts `shatter view`; `address` is the promise of what it prints, and `notes` what it wrote to stderr. */
export function begin(world, args) {
  const child = spawn(join(programs, "shatter"), ["view", ...args], { env: world.env, stdio: ["ignore", "pipe", "pipe"] });
  started.add(child);
  let text = "";
  child.stderr.on("data", (data) => (text += data));
  const ended = new Promise((resolve) => child.on("exit", resolve)).then(() => {
    started.delete(child);
    // A process that it left behind may hold the other ends.
    child.stdout.destroy();
    child.stderr.destroy();
  });
  const address = new Promise((found, failed) => {
    child.stdout.on("data", (data) => found(String(data).split("\n")[0]));
    void ended.then(() => failed(new Error(`shatter view ended with ${child.exitCode ?? child.signalCode}: ${text}`)));
  });
  address.catch(() => undefined);
  const end = (signal = "SIGTERM") => {
    child.kill(signal);
    return ended;
  };
  return { address, end, pid: child.pid, notes: () => text };
}

/** Starts `shatter view`, and waits for the address that it prints. */
export async function view(world, args) {
  const server = begin(world, args);
  return { ...server, address: await server.address };
}

/** Ids of the processes whose command line names the folder of `world`. */
export async function processesOf(world) {
  const ids = (await readdir("/proc")).filter((name) => /^\d+$/.test(name));
  const lines = await Promise.all(ids.map((id) => readFile(`/proc/${id}/cmdline`, "latin1").catch(() => "")));
  return ids.filter((_, at) => lines[at].includes(world.folder));
}

/** The reply to a GET: its head, and the connection if it became a WebSocket. */
function get(url, headers) {
  return new Promise((resolve, reject) => {
    const sent = request(url, { headers, agent: false });
    sent.on("response", (response) => {
      response.resume();
      resolve(response);
    });
    sent.on("upgrade", (_, socket) => resolve(socket));
    sent.on("error", reject);
    sent.end();
  });
}

/** Opens the WebSocket of the page without a browser; `send` sends a request, and `sendFile` a file, whose replies are not read. */
export async function socketOf(address) {
  const { headers } = await get(address, {});
  const upgrade = { Connection: "Upgrade", Upgrade: "websocket", "Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==" };
  const cookie = headers["set-cookie"][0].split(";")[0];
  const { origin } = new URL(address);
  const socket = await get(new URL("socket", origin + headers.location), { ...upgrade, Cookie: cookie, Origin: origin });
  socket.on("error", () => undefined);
  socket.resume();
  // One frame of less than 64 KiB, with a mask of zeros.
  const frame = (kind, bytes) => socket.write(Buffer.concat([Buffer.from([0x80 | kind, 0x80 | 126, bytes.length >> 8, bytes.length & 255, 0, 0, 0, 0]), bytes]));
  const send = (document) => frame(1, Buffer.from(JSON.stringify(document)));
  const sendFile = (document, contents) => {
    const text = Buffer.from(JSON.stringify(document));
    const length = Buffer.from(new Uint32Array([text.length]).buffer);
    frame(2, Buffer.concat([length, text, Buffer.from(contents)]));
  };
  return { send, sendFile, end: () => socket.destroy() };
}

/** Starts Chromium with a software renderer. */
export function browser() {
  const args = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox", "--enable-precise-memory-info", "--js-flags=--expose-gc"];
  return chromium.launch({ executablePath: browserPath, args });
}

/** Opens the page, and waits until an object is shown. Notes errors of the page, and requests to other places. */
export async function open(browser, address, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1100, height: 720 }, acceptDownloads: true, ...options });
  const page = await context.newPage();
  const notes = { errors: [], foreign: [] };
  page.on("pageerror", (error) => notes.errors.push(error.message));
  page.on("console", (line) => {
    if (line.type() === "error" || line.text().includes("GL_")) notes.errors.push(line.text());
  });
  const own = new URL(address).origin;
  await context.route("**/*", (route) => {
    const target = route.request().url();
    if (target.startsWith(own) || /^(blob|data|file):/.test(target)) return route.continue();
    notes.foreign.push(target);
    return route.abort();
  });
  await page.goto(address);
  await page.waitForFunction(() => globalThis.shatterView?.app.history.count > 0, null, { timeout: 60_000 });
  return { page, context, notes };
}

/**
 * Sets up the tests of a file, and ends it all after them: a world, `shatter view` with a generated shape, Chromium, the page. `take`
 * receives these parts before the first test.
 */
export function session(shape, args, take, options = {}) {
  const parts = {};
  before(async () => {
    if (skip) return;
    parts.own = await world();
    parts.server = await view(parts.own, [await bake(parts.own, shape, args)]);
    parts.chrome = await browser();
    Object.assign(parts, await open(parts.chrome, parts.server.address, options));
    await take(parts);
  });
  after(async () => {
    await parts.chrome?.close();
    await parts.server?.end();
    await parts.own?.end();
  });
}

/** Calls `change` and waits until the page shows a state that it has not shown before. */
export async function nextState(page, change) {
  await page.evaluate(() => (globalThis.stateBefore = globalThis.shatterView.app.history.now));
  await change();
  await page.waitForFunction(() => globalThis.shatterView.app.history.now !== globalThis.stateBefore, null, { timeout: 60_000 });
}

/** Clicks on places of the object until the page shows a new state: pieces can move away from a click, or stay whole. */
export async function clickPiece(page) {
  await page.evaluate(() => (globalThis.stateBefore = globalThis.shatterView.app.history.now));
  for (let first = 0; first < 5; first++) {
    const at = await onObject(page, first);
    await page.mouse.click(at.x, at.y);
    const isNew = () => globalThis.shatterView.app.history.now !== globalThis.stateBefore;
    if (await page.waitForFunction(isNew, null, { timeout: 15_000 }).catch(() => undefined)) return;
  }
  throw new Error("no click on the object changed it");
}

/** Number of pieces that are shown. */
export function pieces(page) {
  return page.evaluate(() =>
    globalThis.shatterView.app.history.now.layers.reduce((sum, layer) => sum + layer.pieces.result.fragments.length - layer.replaced.size, 0),
  );
}

/** A place of the canvas where the object is. The search begins at candidate `first`. */
export async function onObject(page, first = 0) {
  return page.evaluate((first) => {
    const box = document.getElementById("canvas").getBoundingClientRect();
    const candidates = [[0.42, 0.55], [0.5, 0.5], [0.46, 0.42], [0.4, 0.45], [0.44, 0.62]];
    // Pieces that moved apart may leave all of them bare.
    const grid = Array.from({ length: 81 }, (_, k) => [0.3 + 0.04 * (k % 9), 0.3 + 0.05 * Math.floor(k / 9)]);
    for (const [x, y] of [...candidates.slice(first), ...candidates.slice(0, first), ...grid]) {
      const at = { x: box.left + x * box.width, y: box.top + y * box.height };
      if (globalThis.shatterView.app.pick(at.x, at.y)) return at;
    }
    throw new Error("the object is nowhere");
  }, first);
}

/** Goes back to the whole object. */
export function whole(page) {
  return page.evaluate(() => globalThis.shatterView.app.go(-Infinity));
}
