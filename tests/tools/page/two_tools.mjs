// Plays the path of two tools that walk_bits printed with the page's engine, in Node:
// node two_tools.mjs MODULES COUPLED.palp TWO.csv RADIUS_m
// Ends with status 0 where force and torque of every row have the bits of C.
import { load, openEngine, rowsOf } from "./load.mjs";

const [modules, asset, from, radius] = process.argv.slice(2);
const { Answer } = await load(modules, `export * from "./engine";`);
const engine = await openEngine(modules, asset);
const radius_m = Number(radius);
const ball = { centre_m: [0, 0, radius_m], radius_m };
const capsule = [-1, 0, 1].map((at) => ({ centre_m: [at * radius_m, 0, 0], radius_m }));
engine.take([[ball], capsule]);
engine.start();

const rows = await rowsOf(from);
let different = 0;
let both = 0;
for (let i = 0; i + 1 < rows.length; i += 2) {
  engine.tick([0, 1].flatMap((k) => [...rows[i + k].slice(1, 4), rows[i + k][7], ...rows[i + k].slice(4, 7)]));
  const answer = engine.answer();
  for (const k of [0, 1]) {
    const of = answer.subarray(k * Answer.size);
    const felt = [...of.subarray(Answer.force_N, Answer.force_N + 3), ...of.subarray(Answer.torque_Nm, Answer.torque_Nm + 3)];
    if (!felt.every((v, n) => Object.is(v, rows[i + k][9 + n]))) ++different;
  }
  if (answer[Answer.touching] > 0 && answer[Answer.size + Answer.touching] > 1) ++both;
}
console.log(`${rows.length / 2} ticks, in ${both} both tools touch, ${different} rows differ from C`);
process.exit(different === 0 && both > 100 ? 0 : 1);
