// Poking: mouse, pen, fingers and keys are the tool; what the engine answers is shown live.

import { Quaternion, Vector3 } from "three";
import workerSource from "worker-source";
import type { BodyView } from "./body";
import { seriesColour } from "./colours";
import { bytes, type Contents, floats, largest, type Vector } from "./contents";
import { button, choice, details, html, slider, swatch } from "./dom";
import { Answer, type Ball, kTip } from "./engine";
import { ForceGraph } from "./force-graph";
import type { DrawnTool } from "./glyphs";
import type { Place } from "./surface";
import { ask, type Term } from "./terms";
import { kKeyStep, listenForTool } from "./tool-input";
import type { Batch, News, Order, Turn } from "./worker";
import { millimetres, quantity } from "./words";

const kStates = ["in the air", "sticks", "slides", "touches"];
const kHelp =
  "Hold the button, pen or finger on the coloured window to press, and move to drag; beside it, or with the right button, you turn the body. Wheel or pen pressure sets the depth; a second finger on a touch screen is a second tool. " +
  "With keys, on the body: Space presses and lifts, arrows move the tool, Page Up and Page Down set the depth, V switches to turning. ";
const kUnmeasured = "Not measured here";
const kTurns = "Q and E turn the tool, arrows with Shift lean it. ";
const kDeforms = "The surface moves as the engine shows it; its error is among those of the accuracy.";
const kRemembers = " The body remembers what was done to it, from touch to touch, until it is healed.";
const kAlone = " The scene's tool has balls that this asset does not know to feel each other: a single one presses.";
const kOutside = 64; // PALPATE_FLAG_OUTSIDE
const kKeyTurn = Math.PI / 36; // a key
const kAtRest = "This asset does not say how its surface moves: the body is drawn at rest.";

/** The probe as a tip, and the scene's tools. */
function toolsOf(contents: Contents): { name: string; balls: readonly Ball[] }[] {
  const own = { name: "the measuring probe", balls: kTip };
  const others = (contents.tools ?? []).map(({ name, balls, radius_m, profile }) => ({
    name,
    balls: balls.map((centre_m, i) => ({ centre_m, radius_m: radius_m[i], profile })),
  }));
  return [own, ...others];
}

export class Poke {
  readonly panel: HTMLElement;
  readonly help = html("p", { class: "small hint" });
  /** On the picture: the switch between pressing and turning, the look from the side, what is not measured. */
  readonly turnButton: HTMLButtonElement;
  readonly sideButton: HTMLButtonElement;
  readonly unmeasured = html("p", { class: "unmeasured", id: "poke-where", role: "status", hidden: true }, kUnmeasured);
  isPoking = true;
  private worker: Worker | undefined;
  readonly range_m: number;
  private readonly ball_m: number;
  private readonly fullForce_N: number;
  private readonly tools: { name: string; balls: readonly Ball[] }[];
  private tool: readonly Ball[];
  private readonly turn = new Quaternion();
  /** Number of tools, for as many fingers on a screen. */
  fingers = 1;
  /** Each finger's place, and whether it presses there. */
  private readonly places: (Place | undefined)[] = [undefined, undefined];
  private readonly pressed = [false, false];
  /** A batch that no frame has shown yet. */
  private latest: Batch | undefined;
  /** Poses and answers that the picture shows. */
  private shownState = "";
  private readonly depth: HTMLInputElement;
  private readonly depthText = html("output", {});
  private readonly values = new Map<string, HTMLElement>();
  private readonly graph: ForceGraph;
  private readonly message = html("p", { class: "small", id: "tool-message", "aria-live": "polite" });
  private readonly pressButton: HTMLButtonElement;
  private readonly healButton: HTMLButtonElement;

  constructor(
    private readonly contents: Contents,
    engine: string,
    private readonly view: BodyView,
  ) {
    this.range_m = contents.asset?.range_m ?? 0.01;
    const radius = contents.probe?.shape === "sphere" ? contents.probe.values.radius?.[0] : undefined;
    this.ball_m = radius ?? 0;
    this.tools = toolsOf(contents);
    const first = this.tools.length > 1 && this.tools[1].balls.length > 1 ? 1 : 0;
    this.tool = this.tools[first].balls;
    this.fullForce_N = largest(floats(contents.maps?.force_N)) || 1; // of an asset alone nothing is known
    this.graph = new ForceGraph(0.1 * this.fullForce_N);
    this.depth = slider("poke-depth", 0, this.range_m, () => this.follow());
    const isOff = { "aria-pressed": "false" };
    this.turnButton = button("turn-only", "Turn", () => this.set(!this.isPoking), isOff);
    this.sideButton = button("side-view", "Cut", () => this.lookFromSide(!this.view.isCut), isOff);
    this.pressButton = button("poke-press", "Press", () => (this.isPressed ? this.lift() : this.pressHere()));
    this.healButton = button("poke-heal", "Heal the body", () => this.heal(), { hidden: true });
    const row = (key: string, label: string, term: Term, first = "0") => {
      const value = html("dd", { id: `poke-${key}` }, first);
      this.values.set(key, value);
      return html("div", {}, html("dt", {}, label, " ", ask(term)), value);
    };
    this.panel = html(
      "div",
      { class: "panel", role: "group", "aria-label": "The tool" },
      html(
        "dl",
        { class: "big" },
        row("force", "Force", "force", "0 N"),
        row("depth-now", "Depth", "depth", millimetres(0)),
        row("state", "Contact", "contact", kStates[0]),
      ),
      html("p", { class: "buttons" }, this.pressButton, html("label", {}, "to ", this.depth, " ", this.depthText)),
      ...this.toolChoice(first),
      this.healButton,
      this.graph.canvas,
      html("p", { class: "legend" }, swatch("normal", seriesColour(0)), swatch("lateral force", seriesColour(1))),
      this.message,
      details(
        "More numbers",
        html(
          "dl",
          {},
          row("normal", "normal, lateral", "lateral"),
          row("lateral-now", "lateral deflection", "lateral"),
          row("dent", "surface moved", "moved"),
          row("energy", "stored, dissipated", "energy"),
          row("rate", "ticks per second", "ticks"),
        ),
      ),
    );
    this.help.textContent = kHelp;
    this.showDepth();
    this.open(engine);
    listenForTool(view, this);
  }

  private toolChoice(first: number): HTMLElement[] {
    if (this.tools.length < 2) return [];
    const options = this.tools.map(({ name }, i): [string, string] => [String(i), name]);
    const { element, select } = choice("poke-tool", "Tool", options, (value) => {
      this.liftAll();
      this.tool = this.tools[Number(value)].balls;
      this.turn.identity();
      this.order({ order: "take", tool: this.tool });
    });
    select.value = String(first);
    return [element];
  }

  private order(order: Order, transfer: Transferable[] = []): void {
    this.worker?.postMessage(order, transfer);
  }

  private open(engine: string): void {
    const asset = this.contents.asset;
    if (!engine || !asset) {
      this.disable(
        "The engine is not in this page: it was built without a compiler for WebAssembly (Debian's clang, lld, wasi-libc, libclang-rt-dev-wasm32 and libc++-dev-wasm32).",
      );
      return;
    }
    this.worker = new Worker(URL.createObjectURL(new Blob([workerSource], { type: "text/javascript" })));
    this.worker.onmessage = ({ data }: MessageEvent<News>) => this.hear(data);
    const module = bytes(engine).buffer;
    const content = bytes(asset.bytes).buffer;
    const speed_m_s = 12 * this.range_m;
    this.order({ order: "open", module, asset: content, speed_m_s, tool: this.tool }, [module, content]);
  }

  private disable(sentence: string): void {
    this.message.textContent = sentence;
    this.message.className = "warning";
    for (const control of this.panel.querySelectorAll("input, select, button:not(.ask)"))
      control.setAttribute("disabled", "");
  }

  private hear(news: News): void {
    if (news.news === "refused") this.disable(`The engine refuses the asset: ${news.sentence}`);
    else if (news.news === "ready") {
      this.panel.dataset.ready = "yes";
      this.fingers = news.fingers;
      if (!news.isTool) this.tool = this.tool.slice(0, 1);
      this.help.textContent =
        kHelp +
        (this.tool === kTip ? "" : kTurns) +
        (news.deforms ? kDeforms : kAtRest) +
        (news.remembers ? kRemembers : "") +
        (news.isTool ? "" : kAlone);
      this.healButton.hidden = !news.remembers;
    } else this.take(news.batch);
  }

  private heal(): void {
    this.liftAll();
    this.order({ order: "heal" });
    this.message.textContent = "The body is as it was before the first touch.";
  }

  /** The pointer and the arrow keys press, or turn the body. */
  set(isPoking: boolean): void {
    this.isPoking = isPoking;
    this.turnButton.setAttribute("aria-pressed", String(!isPoking));
    if (!isPoking) this.liftAll();
  }

  /** The pointer comes down where nothing was measured, or where something was. */
  note(isMeasured: boolean): void {
    this.unmeasured.hidden = isMeasured;
  }

  lookFromSide(isCut: boolean): void {
    this.view.lookFromSide(isCut ? this.places[0] : undefined);
    if (isCut && !this.places[0]) this.message.textContent = "Press somewhere first: the cut goes through the tool.";
    this.sideButton.setAttribute("aria-pressed", String(this.view.isCut));
  }

  private liftAll(): void {
    for (let finger = 0; finger < this.fingers; ++finger) this.lift(finger);
  }

  /** The first finger presses, as keys and buttons do. */
  get isPressed(): boolean {
    return this.pressed[0];
  }

  /** Sets the place of Press and the keys to a test point, with its outward normal. */
  aim(position: Vector, outward: Vector): void {
    if (this.isPressed) return;
    this.places[0] = { position: new Vector3(...position), outward: new Vector3(...outward), isMeasured: true };
  }

  /** Distance from the tool's origin to its lowest point along an outward normal. */
  private reach(outward: Vector3): number {
    const lowest = this.tool.map(
      ({ centre_m, radius_m }) => radius_m - new Vector3(...centre_m).applyQuaternion(this.turn).dot(outward),
    );
    return Math.max(...lowest);
  }

  /** Place of the tool's origin at a depth of the tool. */
  private at(finger: number, depth_m: number): Vector {
    const { position, outward } = this.places[finger] as Place;
    return position
      .clone()
      .addScaledVector(outward, this.reach(outward) - depth_m)
      .toArray();
  }

  /** Beside the surface, where a touch begins and ends. */
  private lifted(finger: number): Vector {
    return this.at(finger, -0.3 * this.range_m);
  }

  private get wxyz(): Turn {
    const { w, x, y, z } = this.turn;
    return [w, x, y, z];
  }

  get depth_m(): number {
    return Number(this.depth.value);
  }

  private showDepth(): void {
    this.depthText.textContent = millimetres(Number(this.depth.value));
  }

  private follow(): void {
    this.showDepth();
    this.pressed.forEach((isPressed, finger) => {
      if (isPressed) this.order({ order: "move", finger, to: this.at(finger, this.depth_m), turn: this.wxyz });
    });
  }

  press(place: Place, finger = 0): void {
    this.places[finger] = place;
    this.pressed[finger] = true;
    if (finger === 0) this.view.cutThrough(place.position);
    this.pressButton.textContent = this.isPressed ? "Lift" : "Press";
    this.order({
      order: "touch",
      finger,
      from: this.lifted(finger),
      to: this.at(finger, this.depth_m),
      turn: this.wxyz,
    });
  }

  pressHere(): void {
    if (!this.places[0]) {
      this.message.textContent = "Choose a test point first.";
      return;
    }
    this.set(true);
    this.press(this.places[0]);
  }

  lift(finger = 0): void {
    if (!this.pressed[finger]) return;
    this.pressed[finger] = false;
    this.pressButton.textContent = this.isPressed ? "Lift" : "Press";
    this.order({ order: "lift", finger, to: this.lifted(finger) });
  }

  drag(place: Place | undefined, finger = 0): void {
    if (!place || !this.pressed[finger]) return;
    this.places[finger] = place;
    this.follow();
  }

  setDepth(depth_m: number): void {
    this.depth.value = String(Math.min(Math.max(depth_m, 0), this.range_m));
    this.follow();
  }

  /** Along the surface, as the screen has right and up, by a share of the range. */
  moveBy(right: number, up: number, share = kKeyStep): void {
    const place = this.places[0];
    if (!place) return;
    const [x, y] = this.view.screenAxes();
    const direction = x.multiplyScalar(right).addScaledVector(y, up);
    direction.addScaledVector(place.outward, -direction.dot(place.outward));
    const to = place.position.clone().addScaledVector(direction.normalize(), share * this.range_m);
    const next = this.view.beside(to, place.outward);
    if (!next) return;
    this.places[0] = next;
    this.view.cutThrough(next.position);
    this.hover();
  }

  /** By a key's angle about the screen's right and up, and about the surface's normal. */
  turnBy(right: number, up: number, outward: number): void {
    const place = this.places[0];
    if (!place || this.tool === kTip) return;
    const [x, y] = this.view.screenAxes();
    const axis = x.multiplyScalar(right).addScaledVector(y, up).addScaledVector(place.outward, outward);
    this.turn.premultiply(new Quaternion().setFromAxisAngle(axis.normalize(), kKeyTurn)).normalize();
    this.hover();
  }

  /** After a key: the tool follows, or shows where it would come down. */
  private hover(): void {
    this.follow();
    const place = this.places[0];
    if (this.isPressed || !place) return;
    const drawn = this.drawn(new Vector3(...this.at(0, 0)), place.outward, this.turn);
    this.view.showTool(0, { ...drawn, acts_at: place.position, force: new Vector3() }, this.fullForce_N);
  }

  /** The balls of the tool with its origin at a place; a tip's is the one that it stands for, beside the surface. */
  private drawn(at: Vector3, outward: Vector3, turn: Quaternion): Pick<DrawnTool, "balls"> {
    if (this.tool === kTip)
      return { balls: [{ at: at.clone().addScaledVector(outward, this.ball_m), radius_m: this.ball_m }] };
    const ball = ({ centre_m, radius_m }: Ball) => ({
      at: new Vector3(...centre_m).applyQuaternion(turn).add(at),
      radius_m,
    });
    return { balls: this.tool.map(ball) };
  }

  /** Ticks are heard and remembered as they come; the picture follows once a frame. */
  private take(batch: Batch): void {
    this.graph.add(batch.pressing_N, batch.sliding_N);
    const before = this.latest;
    batch.displacement ??= before?.displacement;
    batch.slid ||= before?.slid ?? false;
    this.latest = batch;
    this.view.inFrame(() => {
      this.latest = undefined;
      this.show(batch);
    });
  }

  private show(batch: Batch): void {
    this.graph.draw();
    this.write(batch);
    const isAway = batch.at.map((at, finger) => this.isAway(batch, new Vector3(...at), finger));
    const isOver = isAway.every((away) => away);
    const state = [batch.at, batch.turn, ...batch.answer].join();
    const isStill = state === this.shownState && !batch.displacement && !isOver;
    this.shownState = state;
    if (isStill) return; // the picture is as it was
    if (batch.displacement || isOver) {
      const most = this.view.deform(isOver ? undefined : batch.displacement);
      const dent = this.values.get("dent");
      if (dent) {
        dent.textContent = millimetres(most.by_m);
        dent.dataset.from_tip_m = String(most.at.distanceTo(new Vector3(...batch.at[0]))); // for those who look closer
      }
    }
    batch.at.forEach((at, finger) => {
      const drawn = isAway[finger] || batch.isIdle[finger] ? undefined : this.toolIn(batch, new Vector3(...at), finger);
      this.view.showTool(finger, drawn, this.fullForce_N);
    });
    if (isOver) this.order({ order: "rest" });
  }

  /** Nobody holds it, and it is back beside the surface, or never was there. */
  private isAway(batch: Batch, at: Vector3, finger: number): boolean {
    if (this.pressed[finger] || batch.answer[finger][Answer.state] !== 0) return false;
    return batch.isIdle[finger] || at.distanceTo(new Vector3(...this.lifted(finger))) < 1e-5;
  }

  private toolIn(batch: Batch, at: Vector3, finger: number): DrawnTool {
    const a = batch.answer[finger];
    const place = this.places[finger] as Place;
    const outward = a[Answer.state] === 0 ? place.outward : new Vector3().fromArray(a, Answer.normal).negate();
    const [w, x, y, z] = batch.turn;
    const isTip = this.tool === kTip || a[Answer.state] === 0;
    return {
      ...this.drawn(at, outward, new Quaternion(x, y, z, w)),
      acts_at: isTip ? at : new Vector3().fromArray(a, Answer.contact_m),
      force: new Vector3().fromArray(a, Answer.force_N),
    };
  }

  /** Writes the numbers of the tools that touch, or of the first one. */
  private write(batch: Batch): void {
    const touching = batch.answer.filter((a) => a[Answer.state] !== 0);
    const all = touching.length ? touching : batch.answer.slice(0, 1);
    const last = batch.pressing_N.length - 1;
    const each = (of: (a: Float64Array) => string) => all.map(of).join(" and ");
    const sum = (key: number) => batch.answer.reduce((total, a) => total + a[key], 0);
    if (touching.length) this.note(touching.every((a) => (a[Answer.flags] & kOutside) === 0));
    const length = (key: number) => each((a) => (touching.length ? millimetres(a[key]) : millimetres(0)));
    const text: Record<string, string> = {
      state: each((a) => kStates[a[Answer.state] === 1 && batch.slid ? 2 : a[Answer.state]] ?? ""),
      force: each((a) => quantity(new Vector3().fromArray(a, Answer.force_N).length(), "N")),
      "depth-now": length(Answer.normal_m),
      normal: `${quantity(batch.pressing_N[last], "N")}, ${quantity(batch.sliding_N[last], "N")}`,
      "lateral-now": length(Answer.lateral_m),
      energy: `${quantity(sum(Answer.stored_J), "J")}, ${quantity(batch.answer[0][Answer.dissipated_J], "J")}`,
      rate: batch.ticks_per_s.toFixed(0),
    };
    for (const [key, value] of Object.entries(text)) {
      const element = this.values.get(key);
      if (element) element.textContent = value;
    }
  }
}
