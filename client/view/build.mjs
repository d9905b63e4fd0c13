// Bundles the page into dist: one script, one style, one page, and the licenses of what the script contains.
import { build } from "esbuild";
import { copyFile, mkdir, readFile, writeFile } from "node:fs/promises";

await mkdir("dist", { recursive: true });
await build({
  entryPoints: ["page/main.ts"],
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  outfile: "dist/view.js",
  legalComments: "none",
  banner: { js: "/* Contains three.js, Copyright 2010-2026 three.js authors, MIT license: see licenses.txt */" },
});
await copyFile("page/index.html", "dist/index.html");
await copyFile("page/view.css", "dist/view.css");
const three = await readFile("node_modules/three/LICENSE", "utf8");
await writeFile("dist/licenses.txt", `three.js\n\n${three}`);
