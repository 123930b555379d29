// Plays a path with the page's engine in Node: node engine.mjs MODULES asset.palp PATH.csv OUT.csv
// PATH.csv has t_s,x_m,y_m,z_m; OUT.csv gets the force on the tool of every row, in digits that read
// back as the same double.
import { writeFile } from "node:fs/promises";
import { openEngine, replay, rowsOf } from "./load.mjs";

const [modules, asset, from, to] = process.argv.slice(2);
const places = (await rowsOf(from)).map((row) => row.slice(1, 4));
const forces = replay(await openEngine(modules, asset), places);
await writeFile(to, `fx_N,fy_N,fz_N\n${forces.map((force) => force.join(",")).join("\n")}\n`);
