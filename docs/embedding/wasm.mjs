// Presses an asset in Node.js; a browser takes bytes from fetch. node wasm.mjs palpate.wasm asset.palp
import { readFileSync } from "node:fs";

const [program, asset] = process.argv.slice(2).map((name) => readFileSync(name));
const engine = (await WebAssembly.instantiate(program)).instance.exports;
new Uint8Array(engine.memory.buffer).set(asset, engine.room());
if (engine.open(asset.length) !== 0) throw new Error("the asset does not open");
const numbers = (at, count) => new Float64Array(engine.memory.buffer, at, count);
const [x, y, , right, back, top] = numbers(engine.box(), 6);
let largest = 0;
for (let i = 0; i < 300; ++i) {
  const force = numbers(engine.tick(0.5 * (x + right) + 0.0013, 0.5 * (y + back) + 0.0007, top + 0.001 - 2e-5 * i), 3);
  largest = Math.max(largest, force[2]);
}
console.log(`${Number(largest.toPrecision(6))} N`);
