// The force thread: ticks the engine at 1 kHz beside the page, whatever the frames do. A browser
// wakes a worker every few milliseconds at best, so ticks that are due come in small batches.

import { vector } from "./contents";
import { Answer, Engine, kPunctured } from "./engine";

export type Vector = [number, number, number];

export type Order =
  | { order: "open"; module: ArrayBuffer; asset: ArrayBuffer; speed_m_s: number }
  | { order: "touch"; from: Vector; to: Vector; interpolates: boolean }
  | { order: "move"; to: Vector }
  | { order: "rest" }
  | { order: "heal" }
  | { order: "record" }
  | { order: "measure" };

/** A batch of ticks. pressing_N, sliding_N: normal and lateral force of each. */
export interface Batch {
  tip: Vector;
  answer: Float64Array;
  /** Of each vertex [m], three numbers; none where the engine does not say, or said it just now. */
  displacement: Float32Array<ArrayBuffer> | undefined;
  /** A tick of the batch slid. */
  slid: boolean;
  /** The tool broke into the body. */
  punctured: boolean;
  pressing_N: Float32Array;
  sliding_N: Float32Array;
  ticks_per_s: number;
}

export type News =
  | { news: "ready"; deforms: boolean; remembers: boolean }
  | { news: "refused"; sentence: string }
  | { news: "batch"; batch: Batch }
  | { news: "record"; tip_m: Float64Array; force_N: Float64Array }
  | { news: "measured"; ticks_per_s: number };

const kRate_Hz = 1000;
const kSlip = 2; // PALPATE_SLIP
const kMaxDue = 100; // after a pause the tool goes on where it stood
const kNews_ms = 15;
const kNearing = 0.08; // of the way that is left, a tick, twice: 25 ms until the tool has followed, without a jerk
const kDeformShare = 0.3; // of the time: large bodies are drawn less often than forces are told
const kRecorded = 600 * kRate_Hz; // ticks; ten minutes

let engine: Engine;
let step_m = 0;
let tip: Vector = [0, 0, 0];
let lead: Vector = [0, 0, 0]; // on the way to the target, ahead of the tip
let target: Vector = [0, 0, 0];
let started_ms = 0;
let done = 0;
let recorded = 0;
let slid = false;
let punctured = false;
let tips = new Float64Array(0);
let forces = new Float64Array(0);
let pressing: number[] = [];
let sliding: number[] = [];
let told_ms = 0;
let deforms_ms = 0;
let stood = ""; // where tool and contact point were when the surface was told last
let rate: { at_ms: number; ticks: number }[] = [];
let ticks = 0;
let timer: ReturnType<typeof setTimeout> | undefined;

const say = (news: News, transfer: Transferable[] = []) => postMessage(news, { transfer });

function tick(): void {
  const way = target.map((t, k) => t - lead[k]);
  const length = Math.hypot(...way);
  const share = length > 0 ? Math.min(Math.max(kNearing, 1e-6 / length), step_m / length, 1) : 0;
  lead = lead.map((v, k) => v + share * way[k]) as Vector;
  tip = tip.map((v, k) => v + kNearing * (lead[k] - v)) as Vector;
  engine.tick(...tip);
  const a = engine.answer();
  const force = vector(a.subarray(Answer.force_N), 0);
  const inward = vector(a.subarray(Answer.normal), 0);
  if (recorded < kRecorded) {
    tips.set(tip, 3 * recorded);
    forces.set(force, 3 * recorded);
    ++recorded;
  }
  slid ||= a[Answer.state] === kSlip;
  punctured ||= (a[Answer.flags] & kPunctured) !== 0;
  const normal = -force.reduce((sum, f, k) => sum + f * inward[k], 0);
  pressing.push(normal);
  sliding.push(Math.hypot(...force.map((f, k) => f + normal * inward[k])));
  ++ticks;
}

function deformed(now: number): Float32Array<ArrayBuffer> | undefined {
  if (!engine.deforms || now < deforms_ms) return undefined;
  const a = engine.answer();
  const stands = [...tip, a[Answer.state], ...vector(a.subarray(Answer.contact_m), 0)].join();
  if (stands === stood) return undefined;
  stood = stands;
  const displacement = new Float32Array(engine.deform());
  const spent = performance.now() - now;
  deforms_ms = now + spent / kDeformShare;
  return displacement;
}

function tell(now: number): void {
  if (now - told_ms < kNews_ms || pressing.length === 0) return;
  told_ms = now;
  rate.push({ at_ms: now, ticks });
  rate = rate.filter((r) => now - r.at_ms < 1500);
  const [first, last] = [rate[0], rate[rate.length - 1]];
  const displacement = deformed(now);
  const batch: Batch = {
    tip,
    answer: engine.answer().slice(),
    displacement,
    slid,
    punctured,
    pressing_N: Float32Array.from(pressing),
    sliding_N: Float32Array.from(sliding),
    ticks_per_s: last.at_ms > first.at_ms ? (1e3 * (last.ticks - first.ticks)) / (last.at_ms - first.at_ms) : 0,
  };
  say({ news: "batch", batch }, displacement ? [displacement.buffer] : []);
  pressing = [];
  sliding = [];
  slid = false;
  punctured = false;
}

function run(): void {
  const now = performance.now();
  let due = Math.floor(((now - started_ms) * kRate_Hz) / 1e3) - done;
  if (due > kMaxDue) {
    done += due - kMaxDue;
    due = kMaxDue;
  }
  for (let k = 0; k < due; ++k) tick();
  done += due;
  tell(now);
  timer = setTimeout(run, 1);
}

function begin(from: Vector, to: Vector, interpolates: boolean): void {
  if (tips.length === 0) {
    tips = new Float64Array(3 * kRecorded);
    forces = new Float64Array(3 * kRecorded);
  }
  engine.start(interpolates);
  recorded = 0;
  stood = "";
  [tip, lead, target] = [from, from, to];
  if (timer !== undefined) return;
  [started_ms, done, rate] = [performance.now(), 0, []];
  run();
}

/** Ticks per second along the record, as fast as they go. */
function measure(): number {
  if (recorded === 0) return 0;
  const path = tips.subarray(0, 3 * recorded);
  const from = performance.now();
  let count = 0;
  let spent = 0;
  while (spent < 200) {
    engine.replay(path);
    count += recorded;
    spent = performance.now() - from;
  }
  return (1e3 * count) / spent;
}

addEventListener("message", async ({ data }: MessageEvent<Order>) => {
  if (data.order === "open") {
    try {
      engine = await Engine.open(data.module, new Uint8Array(data.asset));
      step_m = data.speed_m_s / kRate_Hz;
      say({ news: "ready", deforms: engine.deforms, remembers: engine.remembers });
    } catch (failure) {
      say({ news: "refused", sentence: failure instanceof Error ? failure.message : String(failure) });
    }
  } else if (data.order === "touch") begin(data.from, data.to, data.interpolates);
  else if (data.order === "move") target = data.to;
  else if (data.order === "heal") engine.heal();
  else if (data.order === "record")
    say({ news: "record", tip_m: tips.slice(0, 3 * recorded), force_N: forces.slice(0, 3 * recorded) });
  else {
    clearTimeout(timer);
    timer = undefined;
    if (data.order === "measure") say({ news: "measured", ticks_per_s: measure() });
  }
});
