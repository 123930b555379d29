// Poking: mouse, pen, fingers, keys and gamepads are the tool; what the engine answers is shown live.

import { Vector3 } from "three";
import workerSource from "worker-source";
import type { BodyView } from "./body";
import { seriesColour } from "./colours";
import { bytes, type Contents, floats, largest } from "./contents";
import { html, swatch } from "./dom";
import { Answer, kInChannel } from "./engine";
import { ForceGraph } from "./force-graph";
import { listenForGamepad } from "./gamepad";
import { ForceSound } from "./sound";
import type { Place } from "./surface";
import { kKeyStep, listenForTool, type Tool } from "./tool-input";
import type { Batch, News, Order, Vector } from "./worker";
import { millimetres, quantity } from "./words";

const kStates = ["in the air", "sticks", "slides", "touches"];
const kHelp =
  "Poke: hold the button, pen or finger on the covered body to press, and move to drag. Wheel, pen pressure or a second finger set the depth. " +
  "With keys, on the body: Space presses and lifts, arrows move the tool, Page Up and Page Down set the depth. A gamepad works, too. ";
const kDeforms = "The surface moves as the engine shows it; its error is stated above.";
const kRemembers = " The body remembers what was done to it, from touch to touch, until it is healed.";
const kAtRest = "This asset does not say how its surface moves: the body is drawn at rest.";

export class Poke implements Tool {
  readonly panel: HTMLElement;
  readonly help = html("p", { class: "small hint" });
  isPoking = false;
  private worker: Worker | undefined;
  readonly range_m: number;
  private readonly ball_m: number;
  private readonly fullForce_N: number;
  private place: Place | undefined;
  /** A batch that no frame has shown yet. */
  private latest: Batch | undefined;
  isPressed = false;
  /** Of the last touch. */
  private isBlended = true;
  private readonly depth: HTMLInputElement;
  private readonly depthText = html("output", {});
  private readonly values = new Map<string, HTMLElement>();
  private readonly graph: ForceGraph;
  private readonly sound: ForceSound;
  private readonly message = html("p", { class: "small", id: "tool-message", "aria-live": "polite" });
  private readonly pressButton: HTMLButtonElement;
  private readonly healButton: HTMLButtonElement;
  private punctures = 0;
  private readonly pokeBox: HTMLInputElement;
  private readonly blendBox: HTMLInputElement;

  constructor(
    private readonly contents: Contents,
    engine: string,
    private readonly view: BodyView,
  ) {
    this.range_m = contents.asset?.range_m ?? 0.01;
    const radius = contents.probe?.shape === "sphere" ? contents.probe.values.radius?.[0] : undefined;
    this.ball_m = radius ?? 0;
    this.fullForce_N = largest(floats(contents.maps?.force_N)) || 1; // of an asset alone nothing is known
    this.graph = new ForceGraph(0.1 * this.fullForce_N);
    this.sound = new ForceSound(this.fullForce_N);
    this.depth = html("input", {
      type: "range",
      id: "poke-depth",
      min: 0,
      max: this.range_m,
      step: this.range_m / 200,
      value: 0.6 * this.range_m,
      input: () => this.follow(),
    });
    this.pokeBox = html("input", { type: "checkbox", id: "poke-on", change: () => this.set(this.pokeBox.checked) });
    this.blendBox = html("input", { type: "checkbox", id: "poke-blend", checked: true, change: () => this.lift() });
    this.pressButton = html(
      "button",
      { type: "button", id: "poke-press", click: () => (this.isPressed ? this.lift() : this.pressHere()) },
      "Press",
    );
    this.healButton = html(
      "button",
      { type: "button", id: "poke-heal", hidden: true, click: () => this.heal() },
      "Heal the body",
    );
    const row = (key: string, label: string) => {
      const value = html("dd", { id: `poke-${key}` }, "0");
      this.values.set(key, value);
      return [html("dt", {}, label), value];
    };
    this.panel = html(
      "div",
      { class: "panel", role: "group", "aria-label": "The tool" },
      html("label", { class: "switch" }, this.pokeBox, " Poke: the pointer is the tool"),
      html("label", {}, "Depth ", this.depth, " ", this.depthText),
      html("label", {}, this.blendBox, " interpolate (off: each facet by itself, which clicks)"),
      this.sound.element,
      this.graph.canvas,
      html("p", { class: "legend" }, swatch("normal", seriesColour(0)), swatch("lateral force [N]", seriesColour(1))),
      html(
        "dl",
        {},
        ...row("state", "contact"),
        ...row("force", "force"),
        ...row("normal", "normal, lateral"),
        ...row("depth-now", "deflections"),
        ...row("dent", "surface moved"),
        ...row("stored", "stored"),
        ...row("dissipated", "dissipated"),
        ...row("rate", "ticks per second"),
      ),
      html(
        "p",
        { class: "buttons" },
        this.pressButton,
        this.healButton,
        html(
          "button",
          { type: "button", id: "poke-save", click: () => this.order({ order: "record" }) },
          "Save path and forces",
        ),
        html("button", { type: "button", id: "poke-measure", click: () => this.measure() }, "Measure speed"),
      ),
      this.message,
    );
    this.help.textContent = kHelp;
    this.showDepth();
    this.open(engine);
    listenForTool(view, this);
    listenForGamepad(view, this, (sentence) => {
      this.message.textContent = sentence;
    });
  }

  private order(order: Order, transfer: Transferable[] = []): void {
    this.worker?.postMessage(order, transfer);
  }

  private open(engine: string): void {
    const asset = this.contents.asset;
    if (!engine || !asset) {
      this.disable(
        "The engine is not in this page: it was built without a compiler for WebAssembly (Debian's clang, lld, wasi-libc, libclang-rt-14-dev-wasm32 and libc++-14-dev-wasm32).",
      );
      return;
    }
    this.worker = new Worker(URL.createObjectURL(new Blob([workerSource], { type: "text/javascript" })));
    this.worker.onmessage = ({ data }: MessageEvent<News>) => this.hear(data);
    const module = bytes(engine).buffer;
    const content = bytes(asset.bytes).buffer;
    this.order({ order: "open", module, asset: content, speed_m_s: 12 * this.range_m }, [module, content]);
  }

  private disable(sentence: string): void {
    this.message.textContent = sentence;
    this.message.className = "warning";
    for (const control of this.panel.querySelectorAll("input, button")) control.setAttribute("disabled", "");
  }

  private hear(news: News): void {
    if (news.news === "refused") this.disable(`The engine refuses the asset: ${news.sentence}`);
    else if (news.news === "ready") {
      this.panel.dataset.ready = "yes";
      this.help.textContent = kHelp + (news.deforms ? kDeforms : kAtRest) + (news.remembers ? kRemembers : "");
      this.healButton.hidden = !news.remembers;
    } else if (news.news === "batch") this.take(news.batch);
    else if (news.news === "measured")
      this.message.textContent = news.ticks_per_s
        ? `${(news.ticks_per_s / 1e6).toFixed(2)} million ticks per second along the last touch, ${quantity(1 / news.ticks_per_s, "s")} each.`
        : "Touch the body first: the last touch is what is measured.";
    else this.save(news.tip_m, news.force_N);
  }

  private heal(): void {
    if (this.isPressed) this.lift();
    this.order({ order: "heal" });
    this.punctures = 0;
    this.message.textContent = "The body is as it was before the first touch.";
  }

  private measure(): void {
    if (this.isPressed) this.lift();
    this.order({ order: "measure" });
  }

  /** The last touch as a table that `palpate replay` takes for a path. */
  private save(tip_m: Float64Array, force_N: Float64Array): void {
    const lines = ["t_s,x_m,y_m,z_m,fx_N,fy_N,fz_N"];
    for (let i = 0; i < tip_m.length; i += 3)
      lines.push([i / 3000, ...tip_m.subarray(i, i + 3), ...force_N.subarray(i, i + 3)].join(","));
    const url = URL.createObjectURL(new Blob([`${lines.join("\n")}\n`], { type: "text/csv" }));
    html("a", { href: url, download: "touch.csv" }).click();
    setTimeout(() => URL.revokeObjectURL(url), 10000);
    this.message.textContent = this.isBlended
      ? `Saved ${tip_m.length / 3} ticks: palpate replay asset.palp touch.csv -o FORCES.csv gives the same forces.`
      : `Saved ${tip_m.length / 3} ticks without interpolation.`;
  }

  private set(isOn: boolean): void {
    this.isPoking = isOn;
    this.view.canvas.classList.toggle("poking", isOn);
    if (!isOn) this.lift();
  }

  /** Where Press and the keys press: a test point, with its outward normal. */
  aim(position: Vector, outward: Vector): void {
    if (this.isPressed) return;
    this.place = { position: new Vector3(...position), outward: new Vector3(...outward) };
  }

  private at(depth_m: number): Vector {
    const place = this.place as Place;
    return place.position.clone().addScaledVector(place.outward, -depth_m).toArray();
  }

  /** Beside the surface, where a touch begins and ends. */
  private lifted(): Vector {
    return this.at(-0.3 * this.range_m);
  }

  get depth_m(): number {
    return Number(this.depth.value);
  }

  private showDepth(): void {
    this.depthText.textContent = millimetres(Number(this.depth.value));
  }

  private follow(): void {
    this.showDepth();
    if (this.isPressed && this.place) this.order({ order: "move", to: this.at(Number(this.depth.value)) });
  }

  press(place: Place): void {
    this.place = place;
    this.isPressed = true;
    this.pressButton.textContent = "Lift";
    this.isBlended = this.blendBox.checked;
    this.order({
      order: "touch",
      from: this.lifted(),
      to: this.at(Number(this.depth.value)),
      interpolates: this.isBlended,
    });
  }

  pressHere(): void {
    if (!this.place) {
      this.message.textContent = "Choose a test point first.";
      return;
    }
    this.pokeBox.checked = true;
    this.set(true);
    this.press(this.place);
  }

  lift(): void {
    if (!this.isPressed) return;
    this.isPressed = false;
    this.pressButton.textContent = "Press";
    if (this.place) this.order({ order: "move", to: this.lifted() });
  }

  drag(place: Place | undefined): void {
    if (!place || !this.isPressed) return;
    this.place = place;
    this.follow();
  }

  setDepth(depth_m: number): void {
    this.depth.value = String(Math.min(Math.max(depth_m, 0), this.range_m));
    this.follow();
  }

  moveBy(right: number, up: number, share = kKeyStep): void {
    if (!this.place) return;
    const [x, y] = this.view.screenAxes();
    const way = x.multiplyScalar(right).addScaledVector(y, up);
    way.addScaledVector(this.place.outward, -way.dot(this.place.outward));
    const to = this.place.position.clone().addScaledVector(way.normalize(), share * this.range_m);
    const next = this.view.beside(to, this.place.outward);
    if (!next) return;
    this.place = next;
    this.follow();
    if (!this.isPressed) this.view.showTool(next.position, next.outward, this.ball_m, new Vector3(), this.fullForce_N);
  }

  /** Ticks are heard and remembered as they come; what is seen follows once a frame. */
  private take(batch: Batch): void {
    this.sound.play(batch);
    this.graph.add(batch.pressing_N, batch.sliding_N);
    const before = this.latest;
    batch.displacement ??= before?.displacement;
    batch.slid ||= before?.slid ?? false;
    batch.punctured ||= before?.punctured ?? false;
    this.latest = batch;
    this.view.inFrame(() => {
      this.latest = undefined;
      this.show(batch);
    });
  }

  private show(batch: Batch): void {
    const a = batch.answer;
    this.graph.draw();
    const force = new Vector3().fromArray(a, Answer.force_N);
    const last = batch.pressing_N.length - 1;
    const state = a[Answer.state];
    const isIn = (a[Answer.flags] & kInChannel) !== 0;
    if (batch.punctured) {
      ++this.punctures;
      this.message.textContent = `The tool broke into the body (${this.punctures} so far): it is in a channel now, which it finds again.`;
    }
    const text: Record<string, string> = {
      state: (kStates[state === 1 && batch.slid ? 2 : state] ?? "") + (isIn ? " in its channel" : ""),
      force: quantity(force.length(), "N"),
      normal: `${quantity(batch.pressing_N[last], "N")}, ${quantity(batch.sliding_N[last], "N")}`,
      "depth-now": Number.isFinite(a[Answer.normal_m])
        ? `${millimetres(a[Answer.normal_m])}, ${millimetres(a[Answer.lateral_m])}`
        : "unknown",
      stored: quantity(a[Answer.stored_J], "J"),
      dissipated: quantity(a[Answer.dissipated_J], "J"),
      rate: batch.ticks_per_s.toFixed(0),
    };
    for (const [key, value] of Object.entries(text)) {
      const element = this.values.get(key);
      if (element) element.textContent = value;
    }
    const tip = new Vector3(...batch.tip);
    const outward = state === 0 ? (this.place as Place).outward : new Vector3().fromArray(a, Answer.normal).negate();
    const isAway = !this.isPressed && state === 0 && tip.distanceTo(new Vector3(...this.lifted())) < 1e-5;
    if (batch.displacement || isAway) {
      const most = this.view.deform(isAway ? undefined : batch.displacement);
      const dent = this.values.get("dent");
      if (dent) {
        dent.textContent = millimetres(most.by_m);
        dent.dataset.from_tip_m = String(most.at.distanceTo(tip)); // for those who look closer
      }
    }
    this.view.showTool(isAway ? undefined : tip, outward, this.ball_m, force, this.fullForce_N);
    if (isAway) this.order({ order: "rest" });
  }
}
