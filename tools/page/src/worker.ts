// The force thread: ticks the engine at 1 kHz beside the page, whatever the frames do. A browser
// wakes a worker every few milliseconds at best, so ticks that are due come in small batches.

import { type Vector, vector } from "./contents";
import { Answer, type Ball, Engine, kMaxBalls, kRate_Hz } from "./engine";

/** A quaternion w, x, y, z. */
export type Turn = [number, number, number, number];

/** finger: which of the tools; all have one turn. */
export type Order =
  | { order: "open"; module: ArrayBuffer; asset: ArrayBuffer; speed_m_s: number; tool: readonly Ball[] }
  | { order: "take"; tool: readonly Ball[] }
  | { order: "touch"; finger: number; from: Vector; to: Vector; turn: Turn }
  | { order: "move"; finger: number; to: Vector; turn: Turn }
  | { order: "lift"; finger: number; to: Vector }
  | { order: "rest" }
  | { order: "heal" };

/** A batch of ticks. pressing_N, sliding_N: normal and lateral force of each, of all tools together. */
export interface Batch {
  /** Place of each tool [m]. */
  at: Vector[];
  isIdle: boolean[];
  answer: Float64Array[];
  turn: Turn;
  /** Displacements of the vertices [m], three numbers each; none where the asset has none or nothing moved. */
  displacement: Float32Array<ArrayBuffer> | undefined;
  /** A tick of the batch slid. */
  slid: boolean;
  pressing_N: Float32Array;
  sliding_N: Float32Array;
  ticks_per_s: number;
}

export type News =
  | { news: "ready"; deforms: boolean; remembers: boolean; fingers: number; isTool: boolean }
  | { news: "refused"; sentence: string }
  | { news: "batch"; batch: Batch };

const kSlip = 2; // PALPATE_SLIP
const kMaxDue = 100; // after a pause the tool goes on where it was
const kNews_ms = 15;
const kNearing = 0.08; // of the distance to the target, a tick, twice: 25 ms until the tool has followed, without a jerk
const kDeformShare = 0.3; // of the time: large bodies are drawn less often than forces are reported
const kMaxFingers = 2;
const kIdle = 20; // of the approach of a touch: distance at which a tool waits that nobody holds

/** A tool and where it goes. */
interface Finger {
  at: Vector;
  /** Between tool and target: smoothed twice. */
  lead: Vector;
  target: Vector;
  isDown: boolean;
  /** It waits far off: it did not come down in this touch. */
  isIdle: boolean;
}

let engine: Engine;
let step_m = 0;
let fingers: Finger[] = [];
let turn: Turn = [1, 0, 0, 0];
let turnTarget: Turn = [1, 0, 0, 0];
let started_ms = 0;
let done = 0;
let slid = false;
let pressing: number[] = [];
let sliding: number[] = [];
let reported_ms = 0;
let deforms_ms = 0;
let reportedState = ""; // tools and contact points when the surface was reported last
let rate: { at_ms: number; ticks: number }[] = [];
let ticks = 0;
let timer: ReturnType<typeof setTimeout> | undefined;

const say = (news: News, transfer: Transferable[] = []) => postMessage(news, { transfer });

function approach(finger: Finger): void {
  const offset = finger.target.map((t, k) => t - finger.lead[k]);
  const length = Math.hypot(...offset);
  const share = length > 0 ? Math.min(Math.max(kNearing, 1e-6 / length), step_m / length, 1) : 0;
  finger.lead = finger.lead.map((v, k) => v + share * offset[k]) as Vector;
  finger.at = finger.at.map((v, k) => v + kNearing * (finger.lead[k] - v)) as Vector;
}

function turnOn(): void {
  if (turn.every((v, k) => v === turnTarget[k])) return;
  const near = turn.map((v, k) => v + kNearing * (turnTarget[k] - v));
  const length = Math.hypot(...near);
  const isThere = turn.every((v, k) => Math.abs(v - turnTarget[k]) < 1e-9);
  turn = isThere ? turnTarget : (near.map((v) => v / length) as Turn);
}

function answerOf(finger: number): Float64Array {
  return engine.answer().subarray(finger * Answer.size, (finger + 1) * Answer.size);
}

function tick(): void {
  turnOn();
  fingers.forEach(approach);
  engine.tick(fingers.flatMap(({ at }) => [...at, ...turn]));
  let [down, aside] = [0, 0];
  fingers.forEach((_, i) => {
    const a = answerOf(i);
    const force = vector(a.subarray(Answer.force_N), 0);
    const inward = vector(a.subarray(Answer.normal), 0);
    const normal = -force.reduce((sum, f, k) => sum + f * inward[k], 0);
    down += normal;
    aside += Math.hypot(...force.map((f, k) => f + normal * inward[k]));
    slid ||= a[Answer.state] === kSlip;
  });
  pressing.push(down);
  sliding.push(aside);
  ++ticks;
}

function deformed(now: number): Float32Array<ArrayBuffer> | undefined {
  if (!engine.deforms || now < deforms_ms) return undefined;
  const stands = fingers
    .flatMap(({ at }, i) => [
      ...at,
      ...turn,
      answerOf(i)[Answer.state],
      ...vector(answerOf(i).subarray(Answer.contact_m), 0),
    ])
    .join();
  if (stands === reportedState) return undefined;
  reportedState = stands;
  const displacement = new Float32Array(engine.deform());
  const spent = performance.now() - now;
  deforms_ms = now + spent / kDeformShare;
  return displacement;
}

function report(now: number): void {
  if (now - reported_ms < kNews_ms || pressing.length === 0) return;
  reported_ms = now;
  rate.push({ at_ms: now, ticks });
  rate = rate.filter((r) => now - r.at_ms < 1500);
  const [first, last] = [rate[0], rate[rate.length - 1]];
  const displacement = deformed(now);
  const batch: Batch = {
    at: fingers.map(({ at }) => at),
    isIdle: fingers.map(({ isIdle }) => isIdle),
    answer: fingers.map((_, i) => answerOf(i).slice()),
    turn,
    displacement,
    slid,
    pressing_N: Float32Array.from(pressing),
    sliding_N: Float32Array.from(sliding),
    ticks_per_s: last.at_ms > first.at_ms ? (1e3 * (last.ticks - first.ticks)) / (last.at_ms - first.at_ms) : 0,
  };
  say({ news: "batch", batch }, displacement ? [displacement.buffer] : []);
  pressing = [];
  sliding = [];
  slid = false;
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
  report(now);
  timer = setTimeout(run, 1);
}

/** A touch. Of the first tool that comes down all begins anew; another one joins it. */
function begin(finger: number, from: Vector, to: Vector, turned: Turn): void {
  if (!fingers.some(({ isDown }, i) => isDown && i !== finger)) {
    engine.start();
    [turn, turnTarget, reportedState] = [turned, turned, ""];
    const idle = from.map((v, k) => v + kIdle * (v - to[k])) as Vector;
    for (const each of fingers) Object.assign(each, { at: idle, lead: idle, target: idle, isIdle: true });
  }
  Object.assign(fingers[finger], { at: from, lead: from, target: to, isDown: true, isIdle: false });
  if (timer !== undefined) return;
  [started_ms, done, rate] = [performance.now(), 0, []];
  run();
}

async function open(module: ArrayBuffer, asset: ArrayBuffer, tool: readonly Ball[]): Promise<News> {
  engine = await Engine.open(module, new Uint8Array(asset));
  return take(tool);
}

/** Another tool is taken in hand, in the air. */
function take(tool: readonly Ball[]): News {
  const isTool = tool.length === 1 || (engine.couples && tool.length <= kMaxBalls);
  const balls = isTool ? tool : tool.slice(0, 1);
  const count = Math.min(kMaxFingers, Math.floor(kMaxBalls / balls.length));
  const nowhere: Vector = [0, 0, 0];
  const one = { at: nowhere, lead: nowhere, target: nowhere, isDown: false, isIdle: true };
  fingers = Array.from({ length: count }, () => ({ ...one }));
  engine.take(fingers.map(() => balls));
  engine.start();
  return { news: "ready", deforms: engine.deforms, remembers: engine.remembers, fingers: count, isTool };
}

function rest(): void {
  clearTimeout(timer);
  timer = undefined;
}

addEventListener("message", async ({ data }: MessageEvent<Order>) => {
  if (data.order === "open") {
    try {
      step_m = data.speed_m_s / kRate_Hz;
      say(await open(data.module, data.asset, data.tool));
    } catch (failure) {
      say({ news: "refused", sentence: failure instanceof Error ? failure.message : String(failure) });
    }
  } else if (data.order === "take") {
    rest();
    say(take(data.tool));
  } else if (data.order === "touch") begin(data.finger, data.from, data.to, data.turn);
  else if (data.order === "move") {
    fingers[data.finger].target = data.to;
    turnTarget = data.turn;
  } else if (data.order === "lift") Object.assign(fingers[data.finger], { target: data.to, isDown: false });
  else if (data.order === "heal") engine.heal();
  else rest();
});
