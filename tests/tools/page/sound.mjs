// What is heard of one slide over a ball of facets: node sound.mjs MODULES ball.palp RADIUS_m
// Prints the peaks of the samples that the page hands to the loudspeaker, of the slide and of the
// same with a step of 0.1 N in it; a step of 1 N would be 1.
import { load, openEngine, replay } from "./load.mjs";

const [modules, asset, radius] = process.argv.slice(2);
const { ForceSignal } = await load(modules, `export * from "./sound";`);
const engine = await openEngine(modules, asset);

// In from outside, then 60 mm around the ball at 50 mm/s, 20 degrees beside its equator.
const tips = [];
const ticks = 1500;
for (let i = 0; i < ticks; ++i) {
  const out = Number(radius) + Math.max(0.001 - 3e-5 * i, -0.006);
  const along = -1 + (2 * Math.max(i - 300, 0)) / (ticks - 300);
  tips.push([Math.cos(0.35) * Math.cos(along), Math.cos(0.35) * Math.sin(along), Math.sin(0.35)].map((v) => v * out));
}
const slide_N = Float32Array.from(replay(engine, tips), (force) => Math.hypot(...force));
for (const step_N of [0, 0.1]) {
  const sizes = slide_N.map((size, i) => (i < ticks / 2 ? size : size + step_N));
  const signal = new ForceSignal(1, 48000);
  let peak = 0;
  let count = 0;
  for (let i = 0; i < ticks; i += 15) {
    const samples = signal.samples({ pressing_N: sizes.subarray(i, i + 15), sliding_N: new Float32Array(15) });
    count += samples.length;
    // Not of first touch, which is a jerk of the path.
    if (i > 450) peak = samples.reduce((most, v) => Math.max(most, Math.abs(v)), peak);
  }
  console.log(peak, count);
}
