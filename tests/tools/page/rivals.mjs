// Plays the path of rivals.json with the methods of the page, in Node:
// node rivals.mjs MODULES SOURCES asset.palp rivals.json
// Ends with status 0 where each answers as `palpate bench rivals` did.
import { createRequire } from "node:module";
import { readFile } from "node:fs/promises";
import path from "node:path";

const [modules, sources, asset, from] = process.argv.slice(2);
const esbuild = createRequire(path.join(modules, "package.json"))("esbuild");
const built = await esbuild.build({
  stdin: { contents: 'export { felt } from "./rivals"; export { Engine } from "./engine";', resolveDir: sources },
  bundle: true,
  write: false,
  format: "esm",
});
const { Engine, felt } = await import(`data:text/javascript,${encodeURIComponent(built.outputFiles[0].text)}`);
const module = await readFile(path.join(modules, "engine.wasm"));
const engine = await Engine.open(module, await readFile(asset));
const { rivals, check } = JSON.parse(await readFile(from, "utf8"));
let bad = rivals.length < 3 ? 1 : 0;
for (const [i, rival] of rivals.entries()) {
  const method = await felt(rival, engine, module);
  method.start();
  let [worst, most] = [0, 0];
  for (const [row, tip] of check.tip_m.entries()) {
    const force = method.force(tip, check.inward);
    const wanted = check.force_N[i][row];
    worst = Math.max(worst, Math.hypot(...force.map((f, k) => f - wanted[k])));
    most = Math.max(most, Math.hypot(...wanted));
  }
  // Tables are in single precision; Green's functions stop at 2e-4 of the force.
  const isAlike = most > 0 && worst < (rival.kind === "green" ? 5e-3 : 1e-4) * most;
  if (!isAlike) ++bad;
  console.log(`${rival.name}: ${check.tip_m.length} ticks, off by ${worst} N of ${most}${isAlike ? "" : " BAD"}`);
}
process.exit(bad);
