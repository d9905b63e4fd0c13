// The daemon that `shatter view` starts ends with it, however and whenever that ends.
import assert from "node:assert/strict";
import { readdir, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { setTimeout as pause } from "node:timers/promises";
import { bake, ball, begin, processesOf, skipPrograms as skip, socketOf, view, world } from "./harness.mjs";

/** Time for a process to end, ms. */
const TIMEOUT_MS = 20_000;

let own, database;

before(async () => {
  if (skip) return;
  own = await world();
  database = await bake(own, "dumbbell", ["--quality", "draft", "--surface", "lattice"]);
});

after(() => own?.end());

/** Waits until no process of this run is left. Kills those that are, and fails. */
async function noneIsLeft(what, timeoutMs = TIMEOUT_MS) {
  const deadline = Date.now() + timeoutMs;
  let left = await processesOf(own);
  while (left.length > 0 && Date.now() < deadline) {
    await pause(50);
    left = await processesOf(own);
  }
  for (const id of left) process.kill(Number(id), "SIGKILL");
  assert.deepEqual(left, [], `${what}: left running`);
}

const request = {
  op: "strike",
  object: "dumbbell",
  impact: { contacts: [{ point_m: [1, 0, 0], ray: [-1, 0, 0], impulse_along_ray_ns: 40 }], quality: "reference", enable: ["normals", "bonds"] },
};

test("the daemon is gone when the command ends by SIGTERM in the middle of a request", { skip, timeout: 200_000 }, async () => {
  for (let run = 0; run < 12; run++) {
    const server = await view(own, [database]);
    assert.equal((await processesOf(own)).length, 2, "the command and its daemon");
    const socket = await socketOf(server.address);
    for (let id = 1; id < 12; id++) socket.send({ ...request, id });
    await pause(6 * run);
    await server.end();
    // Without a wait: the command ends after its daemon.
    const left = await processesOf(own);
    if (left.length > 0) await noneIsLeft(`SIGTERM after ${6 * run} ms`);
    assert.deepEqual(left, [], "the command ended before its daemon");
    socket.end();
  }
});

test("the daemon ends with a command that is ended while it starts, or killed", { skip, timeout: 200_000 }, async () => {
  for (let run = 0; run < 12; run++) {
    const server = begin(own, [database]);
    await pause(15 * run);
    await server.end(run % 2 === 0 ? "SIGTERM" : "SIGKILL");
    await noneIsLeft(`a signal after ${15 * run} ms`);
  }
  const server = await view(own, [database]);
  const socket = await socketOf(server.address);
  socket.send({ ...request, id: 1 });
  await server.end("SIGKILL");
  await noneIsLeft("SIGKILL in the middle of a request");
});

test("a killed daemon is not started again by a command that ends", { skip, timeout: 200_000 }, async () => {
  for (let run = 0; run < 6; run++) {
    const server = await view(own, [database]);
    const [daemon] = (await processesOf(own)).filter((id) => Number(id) !== server.pid);
    const socket = await socketOf(server.address);
    for (let id = 1; id < 12; id++) socket.send({ ...request, id });
    process.kill(Number(daemon), "SIGKILL");
    await pause(20 * run);
    await server.end();
    await noneIsLeft(`SIGTERM ${20 * run} ms after its daemon was killed`);
    socket.end();
  }
});

/** A tetrahedron as OBJ: its bake with the preset `reference` takes longer than the tests wait. */
const MESH = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

/** Waits until so many processes of this run are there. */
async function areRunning(count) {
  const deadline = Date.now() + TIMEOUT_MS;
  while ((await processesOf(own)).length < count) {
    assert.ok(Date.now() < deadline, `${count} processes do not run`);
    await pause(20);
  }
}

test("a bake of the page ends with the command", { skip, timeout: 200_000 }, async () => {
  for (const signal of ["SIGTERM", "SIGKILL"]) {
    const before = await readdir(own.env.TMPDIR);
    const server = await view(own, [database]);
    const socket = await socketOf(server.address);
    socket.sendFile({ op: "bake", id: 1, file: "mesh.obj", name: "mesh", quality: "reference" }, MESH);
    await areRunning(3);
    await pause(200);
    assert.equal((await processesOf(own)).length, 3, "the command, its daemon and the bake");
    await server.end(signal);
    if (signal === "SIGTERM") {
      assert.deepEqual(await processesOf(own), [], "the command ended before the bake");
      assert.deepEqual(await readdir(own.env.TMPDIR), before, "files of the bake are left");
    }
    await noneIsLeft(signal);
    socket.end();
  }
});

test("the bake of a mesh that the command was given ends with it", { skip, timeout: 200_000 }, async () => {
  const mesh = join(own.folder, "given.obj");
  // Its bake takes longer than the time limit.
  await writeFile(mesh, ball(240, 360));
  for (const signal of ["SIGTERM", "SIGKILL"]) {
    const server = begin(own, [mesh]);
    await areRunning(2);
    await pause(200);
    await server.end(signal);
    await noneIsLeft(signal, 4000);
  }
});
