// The page's sources and its engine in Node.
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import path from "node:path";
import { fileURLToPath } from "node:url";

const sources = fileURLToPath(new URL("../../../tools/page/src", import.meta.url));

/** What a text of imports and exports, resolved among the sources, exports. modules: with npm's packages. */
export async function load(modules, contents) {
  const esbuild = createRequire(path.join(modules, "package.json"))("esbuild");
  const built = await esbuild.build({
    stdin: { contents, resolveDir: sources },
    bundle: true,
    write: false,
    format: "esm",
    nodePaths: [path.join(modules, "node_modules")],
  });
  return import(`data:text/javascript;base64,${Buffer.from(built.outputFiles[0].text).toString("base64")}`);
}

export async function openEngine(modules, asset) {
  const { Engine } = await load(modules, `export * from "./engine";`);
  return Engine.open(await readFile(path.join(modules, "engine.wasm")), await readFile(asset));
}

/** Forces on a tip [N] at places [m], a tick each from a fresh start. */
export function replay(engine, places) {
  engine.start();
  return places.map((place) => {
    engine.tick([...place, 1, 0, 0, 0]);
    return Array.from(engine.answer().subarray(0, 3));
  });
}

/** Rows of numbers of a table. */
export async function rowsOf(csv) {
  const lines = (await readFile(csv, "utf8")).trim().split("\n");
  return lines.slice(1).map((row) => row.split(",").map(Number));
}
