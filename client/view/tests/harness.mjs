// What the tests share: programs, databases, a running `shatter view`, and Chromium.
import { spawn, execFile } from "node:child_process";
import { existsSync } from "node:fs";
import { mkdtemp, mkdir, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { promisify } from "node:util";
import { chromium } from "playwright-core";

const run = promisify(execFile);

/** Folder of the programs `shatter` (with the feature `view`) and `shatterd`. */
export const programs = process.env.SHATTER_PROGRAMS ?? resolve(import.meta.dirname, "../../../target/release");

/** Path of Chromium; `undefined` if there is none. */
export const browserPath = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(existsSync);

/** A reason to skip, or false. */
export const skip = !browserPath ? "no Chromium" : !existsSync(join(programs, "shatterd")) ? "no shatterd" : false;

/** A folder of this run, with an environment that keeps it apart from other services. */
export async function world() {
  const folder = await mkdtemp(join(tmpdir(), "shatter-view-test-"));
  const env = { ...process.env, XDG_RUNTIME_DIR: join(folder, "run"), XDG_DATA_HOME: join(folder, "data"), SHATTER_SERVICE: `view-test-${process.pid}` };
  await mkdir(env.XDG_RUNTIME_DIR, { mode: 0o700 });
  return { folder, env, end: () => rm(folder, { recursive: true, force: true }) };
}

/** Runs a program to its end, and returns what it prints. */
export async function program(world, name, args) {
  const { stdout } = await run(join(programs, name), args, { env: world.env, maxBuffer: 1 << 28 });
  return stdout;
}

/** Bakes a generated shape; returns the path of its database. */
export async function bake(world, shape, args = []) {
  await program(world, "shatterd", ["bake", "--shape", shape, "--out", join(world.folder, "databases"), ...args]);
  return join(world.folder, "databases", `${shape}.shatter`);
}

/** Starts `shatter view`, and waits for the address that it prints. */
export async function view(world, args) {
  const child = spawn(join(programs, "shatter"), ["view", ...args], { env: world.env, stdio: ["ignore", "pipe", "pipe"] });
  let text = "";
  child.stderr.on("data", (data) => (text += data));
  const address = await new Promise((found, failed) => {
    child.stdout.on("data", (data) => found(String(data).split("\n")[0]));
    child.on("exit", (code) => failed(new Error(`shatter view ended with ${code}: ${text}`)));
  });
  const end = () =>
    new Promise((ended) => {
      child.removeAllListeners("exit");
      child.on("exit", ended);
      child.kill("SIGTERM");
    });
  return { address, end, pid: child.pid };
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

/** Calls `change` and waits until the page shows a state that it has not shown before. */
export async function nextState(page, change) {
  await page.evaluate(() => (globalThis.stateBefore = globalThis.shatterView.app.history.now));
  await change();
  await page.waitForFunction(() => globalThis.shatterView.app.history.now !== globalThis.stateBefore, null, { timeout: 60_000 });
}

/** Number of pieces that are shown. */
export function pieces(page) {
  return page.evaluate(() =>
    globalThis.shatterView.app.history.now.layers.reduce((sum, layer) => sum + layer.pieces.result.fragments.length - layer.replaced.size, 0),
  );
}

/** A place of the canvas where the object is. */
export async function onObject(page) {
  return page.evaluate(() => {
    const box = document.getElementById("canvas").getBoundingClientRect();
    for (const [x, y] of [[0.42, 0.55], [0.5, 0.5], [0.46, 0.42], [0.4, 0.45], [0.44, 0.62]]) {
      const at = { x: box.left + x * box.width, y: box.top + y * box.height };
      if (globalThis.shatterView.app.pick(at.x, at.y)) return at;
    }
    throw new Error("the object is nowhere");
  });
}

/** Goes back to the whole object. */
export function whole(page) {
  return page.evaluate(() => globalThis.shatterView.app.go(-Infinity));
}
