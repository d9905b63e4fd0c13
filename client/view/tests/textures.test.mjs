// A dropped .glb with several textures: the pieces show each of them.
import assert from "node:assert/strict";
import { readFile, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { test } from "node:test";
import { crc32, deflateSync } from "node:zlib";
import { nextState, onObject, session, skip } from "./harness.mjs";

let own, page, notes;

session("dumbbell", ["--quality", "draft", "--surface", "lattice"], (parts) => ({ own, page, notes } = parts));

/** A PNG file of four pixels of one color. */
function png(color) {
  const chunk = (name, data) => {
    const body = Buffer.concat([Buffer.from(name), data]);
    const [length, sum] = [Buffer.alloc(4), Buffer.alloc(4)];
    length.writeUInt32BE(data.length);
    sum.writeUInt32BE(crc32(body));
    return Buffer.concat([length, body, sum]);
  };
  const head = Buffer.from([0, 0, 0, 2, 0, 0, 0, 2, 8, 2, 0, 0, 0]);
  const row = [0, ...color, ...color];
  const signature = Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);
  return Buffer.concat([signature, chunk("IHDR", head), chunk("IDAT", deflateSync(Buffer.from([...row, ...row]))), chunk("IEND", Buffer.alloc(0))]);
}

/** A box as .glb. Each of three textures covers two opposite faces; the fourth material is of no face. */
function box(colors) {
  const [chunks, views, accessors, primitives] = [[], [], [], []];
  let length = 0;
  const add = (data, accessor) => {
    views.push({ buffer: 0, byteOffset: length, byteLength: data.length });
    if (accessor) accessors.push({ ...accessor, bufferView: views.length - 1 });
    chunks.push(data, Buffer.alloc(-data.length & 3));
    length += (data.length + 3) & ~3;
    return accessor ? accessors.length - 1 : views.length - 1;
  };
  const floats = (rows) => Buffer.from(new Float32Array(rows.flat()).buffer);
  for (let axis = 0; axis < 3; axis++) {
    const [positions, normals, indices] = [[], [], []];
    for (const side of [-1, 1]) {
      const corner = (u, v) => {
        const point = [0, 0, 0];
        [point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3]] = [side * 0.05, u * 0.05, v * 0.05];
        return point;
      };
      const first = positions.length;
      for (const [u, v] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
        positions.push(corner(u, v));
        normals.push([0, 1, 2].map((k) => (k === axis ? side : 0)));
      }
      const order = side > 0 ? [0, 1, 2, 0, 2, 3] : [0, 2, 1, 0, 3, 2];
      indices.push(...order.map((at) => first + at));
    }
    const uvs = positions.map((_, at) => [[0, 0], [1, 0], [1, 1], [0, 1]][at % 4]);
    const vector = { componentType: 5126, type: "VEC3", count: positions.length };
    const attributes = {
      POSITION: add(floats(positions), { ...vector, min: [-0.05, -0.05, -0.05], max: [0.05, 0.05, 0.05] }),
      NORMAL: add(floats(normals), vector),
      TEXCOORD_0: add(floats(uvs), { componentType: 5126, type: "VEC2", count: uvs.length }),
    };
    const order = add(Buffer.from(new Uint16Array(indices).buffer), { componentType: 5123, type: "SCALAR", count: indices.length });
    primitives.push({ attributes, indices: order, material: axis });
  }
  const images = colors.map((color) => ({ mimeType: "image/png", bufferView: add(png(color)) }));
  const material = (_, index) => ({ pbrMetallicRoughness: { baseColorTexture: { index }, metallicFactor: 0 } });
  const document = {
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }], meshes: [{ primitives }],
    materials: [...colors.map(material), { name: "of no face" }], textures: colors.map((_, source) => ({ source })), images,
    accessors, bufferViews: views, buffers: [{ byteLength: length }],
  };
  const text = Buffer.from(JSON.stringify(document));
  const json = Buffer.concat([text, Buffer.alloc(-text.length & 3, " ")]);
  const head = (size, name) => Buffer.concat([Buffer.from(new Uint32Array([size]).buffer), Buffer.from(name)]);
  const body = Buffer.concat([head(json.length, "JSON"), json, head(length, "BIN\0"), ...chunks]);
  return Buffer.concat([Buffer.from("glTF"), Buffer.from(new Uint32Array([2, 12 + body.length]).buffer), body]);
}

/** Pixels of the picture by their strongest channel, of a frame with all details or a fast one. */
function channels(isFast) {
  return page.evaluate((isFast) => {
    const { app } = globalThis.shatterView;
    app.stage.render(isFast);
    const copy = Object.assign(document.createElement("canvas"), { width: 200, height: 150 });
    const context = copy.getContext("2d", { willReadFrequently: true });
    context.drawImage(app.stage.renderer.domElement, 0, 0, 200, 150);
    const { data } = context.getImageData(0, 0, 200, 150);
    const counts = [0, 0, 0];
    for (let at = 0; at < data.length; at += 4) {
      const color = [...data.subarray(at, at + 3)];
      const strongest = color.indexOf(Math.max(...color));
      const others = color.filter((_, k) => k !== strongest);
      if (data[at + 3] > 250 && color[strongest] > 2 * Math.max(...others)) counts[strongest]++;
    }
    return counts;
  }, isFast);
}

test("every texture of a dropped .glb is on the pieces", { skip }, async () => {
  const file = join(own.folder, "box.glb");
  await writeFile(file, box([[230, 20, 20], [20, 200, 20], [20, 20, 230]]));
  await page.setInputFiles("#file", file);
  await page.waitForFunction(() => document.getElementById("mesh-name").textContent.includes("box.glb"));
  await nextState(page, () => page.click("#bake"));
  await page.waitForFunction(() => globalThis.shatterView.app.object?.name === "box", null, { timeout: 60_000 });
  for (const isFast of [false, true]) {
    const whole = await channels(isFast);
    assert.ok(Math.min(...whole) > 500, `${whole} pixels, fast: ${isFast}`);
  }
  const at = await onObject(page);
  await nextState(page, () => page.mouse.click(at.x, at.y));
  const broken = await channels(false);
  assert.ok(Math.min(...broken) > 400, `${broken} pixels of pieces`);
  for (const format of ["glb", "obj"]) {
    const [download] = await Promise.all([page.waitForEvent("download"), page.click(`[data-format=${format}]`)]);
    assert.match((await readFile(await download.path())).toString("latin1"), /"TEXCOORD_0"|\nvt /, `${format} has texture coordinates`);
  }
  assert.deepEqual([notes.foreign, notes.errors], [[], []]);
});
