// Plays a path with the page's engine in Node: node engine.mjs MODULES SOURCES asset.palp PATH.csv OUT.csv [faceted]
// PATH.csv has t_s,x_m,y_m,z_m; OUT.csv gets the force on the tool of every row, in digits that read
// back as the same double; faceted: without interpolation.
import { createRequire } from "node:module";
import { readFile, writeFile } from "node:fs/promises";
import path from "node:path";

const [modules, sources, asset, from, to, mode] = process.argv.slice(2);
const esbuild = createRequire(path.join(modules, "package.json"))("esbuild");
const built = await esbuild.build({
  entryPoints: [path.join(sources, "engine.ts")],
  bundle: true,
  write: false,
  format: "esm",
});
const { Engine, unturned } = await import(`data:text/javascript,${encodeURIComponent(built.outputFiles[0].text)}`);
const engine = await Engine.open(await readFile(path.join(modules, "engine.wasm")), await readFile(asset));
const rows = (await readFile(from, "utf8")).trim().split("\n").slice(1);
const tips = Float64Array.from(rows.flatMap((row) => row.split(",").slice(1, 4).map(Number)));
const forces = engine.replay(unturned(tips), mode !== "faceted");
const lines = rows.map((_, i) => forces.subarray(3 * i, 3 * i + 3).join(","));
await writeFile(to, `fx_N,fy_N,fz_N\n${lines.join("\n")}\n`);
