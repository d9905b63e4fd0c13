// A mesh of the user: defects marked with their places, bake with progress, errors of broken files.
import assert from "node:assert/strict";
import { writeFile } from "node:fs/promises";
import { join, resolve } from "node:path";
import { test } from "node:test";
import { build } from "esbuild";
import { ball, nextState, onObject, pieces, program, session, skip, whole } from "./harness.mjs";

let own, page, notes;

session("dumbbell", ["--quality", "draft", "--surface", "lattice"], (parts) => ({ own, page, notes } = parts));

/** Direction from the object to the camera. */
const view = () =>
  page.evaluate(() => {
    const { camera, controls } = globalThis.shatterView.app.stage;
    return camera.position.clone().sub(controls.target).normalize().toArray();
  });

/** Shows an object of the service. */
async function choose(name) {
  await page.selectOption("#object", name);
  await page.waitForFunction((name) => globalThis.shatterView.app.object?.name === name, name);
}

test("holes of a dropped mesh are marked, it is baked with progress, and breaks", { skip }, async () => {
  const file = join(own.folder, "ball with holes.obj");
  await writeFile(file, ball(24, 32, [[12, 3], [12, 16]]));
  await page.setInputFiles("#file", file);
  await page.waitForFunction(() => document.querySelectorAll("#defects li").length > 1);
  const listed = await page.locator("#defects li").allTextContents();
  assert.ok((await page.evaluate(() => globalThis.shatterView.app.stage.marks.children.length)) >= 3);
  const seen = new Set();
  await page.exposeFunction("noteProgress", (text) => seen.add(text));
  await page.evaluate(() => {
    const line = document.getElementById("progress-line");
    new MutationObserver(() => globalThis.noteProgress(line.textContent)).observe(line, { childList: true });
  });
  assert.equal(listed.filter((text) => /^hole of 6 edges at \S+, \S+, \S+ m$/.test(text)).length, 2, listed.join("; "));
  assert.equal(listed[0], "4 defects");
  assert.match(listed.at(-1), /The bake looks for more/);
  assert.equal(await page.textContent("#hint"), "Bake it to strike it: that repairs its defects");
  await page.evaluate(() => globalThis.shatterView.app.stage.orbit(0.7, 0.1));
  const before = await view();
  await nextState(page, async () => {
    await page.click("#bake");
    assert.equal(await page.textContent("#hint"), "", "it is being baked");
  });
  await page.waitForFunction(() => globalThis.shatterView.app.object?.name === "ball-with-holes", null, { timeout: 60_000 });
  assert.ok((await view()).every((x, axis) => Math.abs(x - before[axis]) < 0.02), "the bake keeps the view");
  await page.waitForFunction(() => /^Baked in/.test(document.getElementById("progress-line").textContent));
  assert.ok((await page.locator("#progress").isHidden()) && (await page.locator("#cancel").isHidden()));
  assert.equal(await page.textContent("#hint"), "Click to break it");
  assert.ok(seen.size > 3, [...seen].join("; "));
  assert.match(await page.textContent("#mesh-size"), /^Size: (20|19\.\d+) cm × 20 cm × /);
  const actions = (await page.locator("#defects li").allTextContents()).join("; ");
  assert.match(await page.textContent("#progress-line"), /^Baked in [\d.]+ s\.( [A-Z][^`]*\.)?$/);
  assert.match(actions, /The object is a solid of 4\.\d+ L\. .*open sheets.*2 holes /);
  const at = await onObject(page);
  await nextState(page, () => page.mouse.click(at.x, at.y));
  assert.ok((await pieces(page)) > 1);
  assert.match(await page.textContent("#facts"), /Surface/);
});

test("a broken file is refused with its name, and the page goes on", { skip }, async () => {
  const endings = ".obj, .ply, .stl, .glb, .gltf, .msh, .vtk, .mesh";
  const picture = Buffer.from([0x89, 0x50, 0x4e, 0x47, 13, 10, 26, 10, ...Array.from({ length: 400 }, (_, at) => (at * 97) % 251)]);
  const other = JSON.stringify({ asset: { version: "2.0" }, buffers: [{ uri: "mesh.bin", byteLength: 8 }] });
  const solid = ball(8, 12);
  for (const [name, contents, told] of [
    ["letter.txt", "Dear reader", `letter.txt is no mesh file that is read here: the name of one ends with ${endings}`],
    ["letter.obj", "Dear reader,\nthis is no mesh.\n", "it is no OBJ file: no line of it is a vertex or a face"],
    ["picture.obj", picture, "it is no OBJ file: no line of it is a vertex or a face"],
    ["points.obj", solid.replace(/^f .*\n/gm, ""), "it has vertices, but no faces"],
    ["letter.stl", "this is no mesh", "the file ends early or is no STL file"],
    ["picture.stl", picture, "the file ends early or is no STL file"],
    ["picture.ply", picture, "it is no PLY file: its first line is not “ply”"],
    ["short.ply", "ply\nformat ascii 1.0\n", "the file ends early or is no PLY file"],
    ["letter.glb", "Dear reader", "it is no glTF file: it begins with neither “glTF” nor a description in JSON"],
    ["short.glb", "glTF", "the file ends early"],
    ["parts.gltf", other, "its triangles are in another file (mesh.bin); save it as .glb, which holds all"],
  ]) {
    const file = join(own.folder, name);
    await writeFile(file, contents);
    await page.setInputFiles("#file", file);
    await page.waitForFunction((name) => document.getElementById("message").textContent.includes(name), name);
    const wanted = name.endsWith(".txt") ? told : `${name} cannot be read: ${told}`;
    assert.equal(await page.textContent("#message span"), wanted);
    assert.doesNotMatch(await page.textContent("#mesh-name"), new RegExp(name), "what is refused leaves no part of the panel");
  }
  assert.equal(await page.textContent("#drop"), `Drop a mesh: ${endings}`);
  assert.equal(await page.getAttribute("#file", "accept"), endings);
  const vtk = join(own.folder, "broken.vtk");
  await writeFile(vtk, "this is no mesh");
  await page.setInputFiles("#file", vtk);
  await page.waitForFunction(() => document.getElementById("mesh-name").textContent.includes("broken.vtk"));
  await page.click("#bake");
  await page.waitForFunction(() => !document.getElementById("message").hidden && document.getElementById("progress").hidden, null, { timeout: 20_000 });
  assert.match(await page.textContent("#message"), /broken\.vtk/);
  assert.doesNotMatch(await page.textContent("#message"), /shatter-view-|mesh\.vtk/, "no folder of the server is named");
  assert.ok(await page.locator("#mesh").isHidden(), "nothing of the file can be baked again");
  await page.selectOption("#object", "dumbbell");
  await page.waitForFunction(() => globalThis.shatterView.app.object?.name === "dumbbell");
  const at = await onObject(page);
  await nextState(page, () => page.mouse.click(at.x, at.y));
  assert.ok((await pieces(page)) > 1);
});

test("a file with a coordinate that is no number is refused, and the object stays", { skip }, async () => {
  const before = await page.evaluate(() => globalThis.shatterView.app.object.name);
  const file = join(own.folder, "bent.obj");
  await writeFile(file, ball(8, 12).replace(/^v \S+/m, "v nan"));
  await page.setInputFiles("#file", file);
  await page.waitForFunction(() => document.getElementById("message").textContent.includes("bent.obj"));
  assert.match(await page.textContent("#message"), /infinite or not a number/);
  assert.equal(await page.evaluate(() => globalThis.shatterView.app.object?.name), before);
  await page.click("#message button");
});

test("an opened file is listed, and the object before it can be chosen again", { skip }, async () => {
  const file = join(own.folder, "plain.obj");
  await writeFile(file, ball(8, 12));
  const before = await page.evaluate(() => globalThis.shatterView.app.object.name);
  await page.setInputFiles("#file", file);
  await page.waitForFunction(() => !globalThis.shatterView.app.object);
  assert.equal(await page.evaluate(() => document.querySelector("#object option:checked").textContent), "plain.obj (not baked)");
  assert.ok(await page.locator("#strike").isHidden(), "what is not baked cannot be struck");
  assert.equal(await page.textContent("#mesh-size"), "Size: 20 cm × 20 cm × 20 cm");
  assert.match(await page.textContent("#defects"), /12 triangles without area at \S+, \S+, \S+ m.*The bake looks for more/);
  // The next file has the defaults again.
  await page.selectOption("#mesh-unit", "mm");
  assert.match(await page.textContent("#mesh-size"), /^Size: 0\.2 mm/);
  await page.selectOption("#mesh-up", "z");
  assert.equal(await page.textContent("#progress-line"), "", "nothing is told of another bake");
  await choose(before);
  assert.equal(await page.textContent("#hint"), "Its earlier results were not kept. Click to break it");
  assert.ok(await page.locator("#strike").isVisible());
});

test("warnings of a bake are sentences in the words of the page", { skip }, async () => {
  const file = join(own.folder, "bake_report.mjs");
  await build({ entryPoints: [resolve(import.meta.dirname, "../page/bake_report.ts")], bundle: true, format: "esm", outfile: file });
  const { warningText } = await import(file);
  assert.equal(
    warningText("the mesh is 658 m large and 9.87e10 kg (unit m); with --unit mm it would be 0.658 m large and 98.7 kg"),
    "The mesh is 658 m large and 9.87e10 kg (unit m); with unit mm it would be 0.658 m large and 98.7 kg.",
  );
  assert.equal(warningText("it is turned: check `--unit`."), "It is turned: check the unit.");
});

test("open edges that close no loop are no hole, and equal lines are counted", { skip }, async () => {
  const file = join(own.folder, "fins.obj");
  // A triangle that stands on an edge of the ball, and two small ones beside each other.
  const small = (x) => `v ${x} 0 0\nv ${x} 0.0001 0\nv ${x} 0 0.0001\n`;
  await writeFile(file, `${ball(8, 12)}v 0.2 0 0\n${small(0.3)}${small(0.30001)}f 49 50 109\nf 110 111 112\nf 113 114 115\n`);
  await page.setInputFiles("#file", file);
  await page.waitForFunction(() => document.getElementById("mesh-name").textContent.startsWith("fins.obj"));
  const listed = await page.locator("#defects li").allTextContents();
  assert.equal(listed[0], "6 defects", listed.join("; "));
  assert.ok(listed.some((text) => /^2 open edges at /.test(text)), listed.join("; "));
  assert.ok(listed.includes("hole of 3 edges at 0.3, 0, 0 m (2 times)"), listed.join("; "));
  await choose("dumbbell");
});

test("the part for a mesh belongs to what is shown, and a mesh that is not baked can be shown again", { skip }, async () => {
  const file = join(own.folder, "high.obj");
  // Two holes, and twice as high along z as along the other axes.
  await writeFile(file, ball(24, 32, [[12, 3], [12, 16]]).replace(/^(v \S+ \S+) (\S+)/gm, (_, first, z) => `${first} ${2 * Number(z)}`));
  await page.setInputFiles("#file", file);
  await page.waitForFunction(() => document.getElementById("mesh-name").textContent.startsWith("high.obj"));
  await choose("dumbbell");
  assert.ok(await page.locator("#mesh").isHidden(), "the panel is that of the object shown");
  assert.ok((await page.locator("#object option").allTextContents()).includes("high.obj (not baked)"));
  await page.selectOption("#object", "");
  await page.waitForFunction(() => !globalThis.shatterView.app.object);
  assert.ok(await page.locator("#mesh").isVisible());
  const shown = () =>
    page.evaluate(() => {
      const { group, marks } = globalThis.shatterView.app.stage;
      const size = (part) => {
        part.updateWorldMatrix(true, true);
        const geometry = part.geometry;
        geometry.computeBoundingBox();
        const box = geometry.boundingBox.clone().applyMatrix4(part.matrixWorld);
        return { size: box.getSize(box.min.clone()).toArray().map((x) => Number(x.toFixed(2))), center: box.getCenter(box.min.clone()) };
      };
      let mesh;
      group.traverse((part) => (mesh ??= part.geometry ? part : undefined));
      return { mesh: size(mesh), marks: size(marks.children[0]), count: marks.children.length };
    });
  const y = await shown();
  assert.deepEqual(y.mesh.size, [0.2, 0.2, 0.4]);
  assert.equal(await page.textContent("#mesh-size"), "Size: 19.9 cm × 20 cm × 40 cm");
  await page.selectOption("#mesh-up", "z");
  const z = await shown();
  assert.deepEqual(z.mesh.size, [0.2, 0.4, 0.2], "the preview stands");
  assert.equal(await page.textContent("#mesh-size"), "Size: 19.9 cm × 40 cm × 20 cm");
  assert.deepEqual([z.marks.size[1], z.marks.size[2]], [y.marks.size[2], y.marks.size[1]], "the marks turn with it");
  assert.equal(z.count, y.count);
  await page.selectOption("#mesh-up", "y");
  await choose("dumbbell");
});

test("bodies that a request leaves whole are shown once", { skip }, async () => {
  const [one, other] = [ball(8, 12), ball(8, 12).replace(/^v (\S+)/gm, (_, x) => `v ${Number(x) + 0.3}`)];
  const count = one.match(/^v/gm).length;
  const file = join(own.folder, "two.obj");
  await writeFile(file, one + other.replace(/^f (\d+) (\d+) (\d+)/gm, (_, ...corners) => `f ${corners.slice(0, 3).map((at) => Number(at) + count).join(" ")}`));
  await page.setInputFiles("#file", file);
  await page.waitForFunction(() => !globalThis.shatterView.app.object);
  await page.click("#bake");
  await page.waitForFunction(() => globalThis.shatterView.app.object?.name === "two", null, { timeout: 60_000 });
  const volume = () =>
    page.evaluate(() => {
      const shown = globalThis.shatterView.app.history.now.layers.flatMap(({ pieces, replaced }) => pieces.result.fragments.filter(({ id }) => !replaced.has(id)));
      return shown.reduce((sum, { volumeM3 }) => sum + volumeM3, 0);
    });
  const before = await volume();
  await nextState(page, async () => {
    const box = await page.locator("#canvas").boundingBox();
    await page.mouse.click(box.x + 0.33 * box.width, box.y + 0.5 * box.height);
  });
  assert.ok((await pieces(page)) > 2);
  assert.ok(Math.abs((await volume()) / before - 1) < 0.05, `${before} m³, then ${await volume()} m³`);
  await page.selectOption("#object", "dumbbell");
  await page.waitForFunction(() => globalThis.shatterView.app.object?.name === "dumbbell");
});

test("presets and lifts stand side by side", { skip }, async () => {
  const at = await onObject(page);
  await nextState(page, () => page.mouse.click(at.x, at.y));
  await page.evaluate(() => (document.getElementById("compare").open = true));
  await page.click("#run-compare");
  await page.waitForFunction(() => document.querySelectorAll("#compared figure").length === 7 && !document.getElementById("run-compare").disabled, null, { timeout: 90_000 });
  const texts = await page.locator("#compared figure").allTextContents();
  assert.ok(texts.filter((text) => /pieces? in .*ms/.test(text)).length >= 5, texts.join(" | "));
  assert.ok((await page.locator("#compared img").count()) >= 5);
});

test("200 requests take no more memory", { skip, timeout: 400_000 }, async () => {
  await whole(page);
  const request = async (count) => {
    for (let i = 0; i < count; i++) {
      await page.evaluate(async (i) => {
        const { app, settings } = globalThis.shatterView;
        app.go(-Infinity);
        const box = document.getElementById("canvas").getBoundingClientRect();
        let aim;
        for (let k = 0; !aim && k < 50; k++) {
          const [u, v] = [((i + k) * 0.754877) % 1, ((i + k) * 0.56984) % 1];
          aim = app.pick(box.left + (0.3 + 0.4 * u) * box.width, box.top + (0.3 + 0.4 * v) * box.height);
        }
        await app.strikeAt(aim, { ...settings(), seed: i });
      }, i);
    }
    return page.evaluate(async () => {
      globalThis.shatterView.app.go(-Infinity);
      for (let i = 0; i < 3; i++) {
        globalThis.gc?.();
        await new Promise((resolve) => setTimeout(resolve, 200));
      }
      const { geometries, textures } = globalThis.shatterView.app.stage.memory();
      return { bytes: performance.memory.usedJSHeapSize, geometries, textures };
    });
  };
  const before = await request(20);
  const after = await request(200);
  assert.ok(after.bytes <= 1.1 * before.bytes, `${before.bytes} bytes, then ${after.bytes}`);
  assert.ok(after.geometries <= before.geometries + 2 && after.textures <= before.textures + 4, JSON.stringify([before, after]));
});

test("no error was reported, and nothing was loaded from elsewhere", { skip }, async () => {
  assert.deepEqual(notes.foreign, []);
  assert.deepEqual(notes.errors, []);
});
