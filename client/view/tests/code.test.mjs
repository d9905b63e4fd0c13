// Copied code: it compiles, runs, and gives the bytes of the request that it repeats.
import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { existsSync } from "node:fs";
import { copyFile, mkdir, readdir, rm, writeFile } from "node:fs/promises";
import { join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { promisify } from "node:util";
import { build } from "esbuild";
import { bake, program, programs, skipPrograms as skip, view, world } from "./harness.mjs";

const run = promisify(execFile);
const client = resolve(import.meta.dirname, "../..");

/** Effects that the page asks for. */
const EFFECTS = ["normals", "attributes", "bonds"];

let own, server, codeOf, service, request, expected;

before(async () => {
  if (skip) return;
  own = await world();
  // Not the name that programs connect to if they name none.
  service = own.env.SHATTER_SERVICE;
  server = await view(own, [await bake(own, "dumbbell", ["--quality", "draft"])]);
  const file = join(own.folder, "impact_request.mjs");
  await build({ entryPoints: [join(client, "view/page/impact_request.ts")], bundle: true, format: "esm", outfile: file });
  ({ codeOf } = await import(file));
  delete own.env.SHATTER_SERVICE;
  const first = {
    object: "dumbbell",
    ray: { originM: [1, 0.0125, 0.004], direction: [-1, 0.003, 0] },
    impulseNs: 9.5,
    settings: { quality: "draft", lift: "euclidean", seed: 7 },
  };
  const largest = (one, other) => (other.volume_m3 > one.volume_m3 ? other : one);
  const piece = JSON.parse(await shell(first)).fragments.reduce(largest);
  const [x, y, z] = piece.center_m;
  const again = { ...first, ray: { originM: [x - 1, y, z], direction: [2, 0, 0] }, impulseNs: 400, settings: { quality: "", lift: "", seed: 123456789012 } };
  request = { ...again, parent: { request: first, fragment: piece.id } };
  const broken = JSON.parse(await shell(request));
  assert.ok(broken.fragments.length > 1, "the piece breaks");
  expected = broken.output_hash;
});

after(async () => {
  await server?.end();
  await own?.end();
});

/** Runs the copied command lines. Writing a file adds the effects that its format needs: the hash is that without a file. */
async function shell(request, hasFile = false) {
  const code = codeOf(request, "shell", EFFECTS, service);
  const env = { ...own.env, PATH: `${programs}:${own.env.PATH}` };
  const { stdout } = await run("sh", ["-ec", hasFile ? code : code.replace(" --out broken.glb", "")], { env, cwd: own.folder, maxBuffer: 1 << 26 });
  return stdout;
}

test("code of a piece's request says that its file has the new pieces alone", { skip }, () => {
  for (const language of ["shell", "rust", "python", "c"]) {
    assert.match(codeOf(request, language), /^(#|\/\/) The file has the pieces of the last request alone\./, language);
    assert.doesNotMatch(codeOf(request.parent.request, language), /The file has/, language);
  }
});

test("the command line repeats both requests", { skip }, async () => {
  assert.match(expected, /^[0-9a-f]{16}$/);
  const written = JSON.parse(await shell(request, true));
  assert.equal(written.fragments.length, JSON.parse(await shell(request)).fragments.length);
  assert.ok((await readdir(own.folder)).includes("broken.glb"));
  const other = { ...request, settings: { ...request.settings, seed: 1 } };
  assert.notEqual(JSON.parse(await shell(other)).output_hash, expected, "the seed is part of the code");
});

test("the C code gives the same bytes", { skip }, async (context) => {
  const code = codeOf(request, "c", EFFECTS, service);
  const print = "ShatterHash hash;\n    if (shatter_result_hash(result, &hash, NULL)) return 6;\n    puts(hash.text);";
  const printing = code.replace(/(?= {4}if \(shatter_result_write_glb)/, `    ${print}\n`);
  assert.notEqual(printing, code);
  const [source, out] = [join(own.folder, "copied.c"), join(own.folder, "copied")];
  await writeFile(source, printing);
  const flags = ["-std=c11", "-Wall", "-Werror", "-I", join(client, "c/include"), source, "-o", out];
  const link = ["-L", programs, "-lshatter", `-Wl,-rpath,${resolve(programs)}`, "-lm"];
  try {
    await run("cc", ["--version"]);
  } catch {
    return context.skip("no C compiler");
  }
  await run("cc", [...flags, ...link]);
  await rm(join(own.folder, "broken.glb"), { force: true });
  const { stdout } = await run(out, [], { env: own.env, cwd: own.folder });
  assert.equal(stdout.trim(), expected);
  assert.ok((await readdir(own.folder)).includes("broken.glb"));
  // As it is copied, also for a single request.
  for (const unchanged of [code, codeOf(request.parent.request, "c", EFFECTS, service)]) {
    await writeFile(source, unchanged);
    await run("cc", [...flags, ...link]);
    await run(out, [], { env: own.env, cwd: own.folder });
  }
  const absent = codeOf({ ...request.parent.request, object: "vase" }, "c", EFFECTS, service);
  await writeFile(source, absent);
  await run("cc", [...flags, ...link]);
  await assert.rejects(run(out, [], { env: own.env, cwd: own.folder }), /vase/, "an error is told");
});

test("the Python code gives the same bytes", { skip }, async (context) => {
  const python = process.env.SHATTER_PYTHON ?? "python3";
  try {
    await run(python, ["-c", "import numpy"]);
  } catch {
    return context.skip("no Python with numpy");
  }
  const site = join(own.folder, "site/shatter");
  await mkdir(site, { recursive: true });
  const sources = join(client, "python/python/shatter");
  for (const name of await readdir(sources)) if (name.endsWith(".py")) await copyFile(join(sources, name), join(site, name));
  await copyFile(join(programs, "lib_shatter.so"), join(site, "_shatter.abi3.so"));
  const code = `${codeOf(request, "python", EFFECTS, service)}\nprint(result.output_hash)\n`;
  const env = { ...own.env, PYTHONPATH: join(own.folder, "site") };
  const { stdout } = await run(python, ["-c", code], { env, cwd: own.folder });
  assert.equal(stdout.trim(), expected);
});

test("the Rust code gives the same bytes", { skip }, async (context) => {
  const library = join(programs, "libshatter_client.rlib");
  if (!existsSync(library)) return context.skip("no Rust library beside the programs");
  try {
    await run("rustc", ["--version"]);
  } catch {
    return context.skip("no rustc");
  }
  const code = codeOf(request, "rust", EFFECTS, service);
  const print = '    println!("{}", result.digest().output_hash);\n    Ok(())';
  const [source, out] = [join(own.folder, "copied.rs"), join(own.folder, "copied-rust")];
  await writeFile(source, code.replace("    Ok(())", print));
  const crates = ["--extern", `shatter_client=${library}`, "-L", `dependency=${join(programs, "deps")}`];
  await run("rustc", ["--edition=2024", "-D", "warnings", ...crates, "-o", out, source]);
  const { stdout } = await run(out, [], { env: own.env, cwd: own.folder });
  assert.equal(stdout.trim(), expected);
});
