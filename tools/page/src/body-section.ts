// The section of the body: its view and controls, the tool, the curves of the point chosen.

import { BodyView, type MarkerMode } from "./body";
import { css, kSetUpColours, kUncovered, viridis, viridisGradient } from "./colours";
import { type Contents, floats, nearest, vector } from "./contents";
import type { PointSection } from "./curves";
import { choice, html, section, swatch } from "./dom";
import { Poke } from "./poke";
import type { MapName } from "./surface";
import { millimetres, percent, quantity } from "./words";

const kMaps: [MapName, string, string][] = [
  ["stiffness_N_m", "normal stiffness", "N/m"],
  ["force_N", "normal force", "N"],
  ["friction", "friction", ""],
];

const kStatusColours: Record<string, [number, number, number]> = {
  good: [1, 1, 1],
  underdetermined: [0.55, 0.8, 1],
  poor: [0.8, 0.1, 0.1],
  failed: [0.05, 0.05, 0.05],
};

/** Held-out contact points with the largest relative error of their rows; those of which some row counts. */
function heldOutPlaces(contents: Contents): { places: Float32Array; error: number[]; name: string[] } {
  const held = contents.held_out;
  const floor = contents.statement?.floor_N ?? contents.jnd.floor_N;
  const found = new Map<string, { place: number[]; error: number; path: string }>();
  if (held) {
    const [position, force, engine] = [held.position_m, held.force_N, held.engine_N].map(floats);
    held.point.forEach((name, i) => {
      const size = Math.hypot(...vector(force, i));
      const off = Math.hypot(...[0, 1, 2].map((k) => engine[3 * i + k] - force[3 * i + k]));
      const key = `${name} ${held.path[i]}`;
      const entry = found.get(key) ?? { place: vector(position, i), error: Number.NaN, path: held.path[i] };
      if (size > floor) entry.error = Math.max(entry.error || 0, off / size);
      found.set(key, entry);
    });
  }
  const counted = [...found].filter(([, e]) => !Number.isNaN(e.error));
  return {
    places: Float32Array.from(counted.flatMap(([, e]) => e.place)),
    error: counted.map(([, e]) => e.error),
    name: counted.map(([name]) => name),
  };
}

class BodySection {
  private readonly view: BodyView;
  private readonly positions: Float32Array;
  private readonly heldOut;
  private readonly depth: HTMLInputElement;
  private readonly depthText = html("output", {});
  private readonly bar = html("div", {});
  private readonly hint = html("p", { class: "small hint" });
  private map: MapName = "stiffness_N_m";
  private markerMode: MarkerMode = "points";
  private poke: Poke | undefined;
  private setUpBox: HTMLInputElement | undefined;
  readonly element: HTMLElement;

  constructor(
    private readonly contents: Contents,
    engine: string,
    private readonly points: PointSection | undefined,
  ) {
    this.positions = floats(contents.points?.position_m ?? contents.set_up?.points_m);
    this.heldOut = heldOutPlaces(contents);
    const canvas = html("canvas", {
      id: "body-view",
      tabindex: 0,
      role: "application",
      "aria-label": "The body. Arrow keys turn it, plus and minus come nearer and go away, Home looks as at first.",
    });
    this.view = new BodyView(contents, canvas);
    const range = contents.maps?.depths_m.at(-1) ?? 0;
    this.depth = html("input", {
      type: "range",
      id: "map-depth",
      min: 0.05 * range,
      max: range,
      step: range / 200,
      value: 0.6 * range,
      input: () => this.colour(),
    });
    const controls = html("div", { class: "controls" });
    if (contents.maps)
      controls.append(
        choice(
          "Colour",
          kMaps.map(([name, text]) => [name, text]),
          (value) => {
            this.map = value as MapName;
            this.colour();
          },
        ).element,
        html("label", {}, "at depth ", this.depth, " ", this.depthText),
      );
    const modes: [MarkerMode, string][] = [["points", "test points"]];
    if (this.heldOut.error.length) modes.push(["held_out", "held-out errors"]);
    modes.push(["none", "none"]);
    controls.append(
      choice("Marks", modes, (value) => {
        this.markerMode = value as MarkerMode;
        this.mark();
        this.colour();
      }).element,
    );
    if (contents.set_up) {
      const box = html("input", {
        type: "checkbox",
        id: "show-set-up",
        change: () => {
          this.view.showSetUp(box.checked);
          this.colour();
        },
      });
      this.setUpBox = box;
      controls.append(html("label", {}, box, " set-up: held nodes, base mesh, window, inclusions"));
      if (!contents.maps) {
        box.checked = true;
        this.view.showSetUp(true);
      }
    }
    controls.append(html("button", { type: "button", click: () => this.view.home() }, "Look as at first"));
    const stage = html("div", { class: "stage" }, canvas, html("div", { class: "overlay" }, this.bar));
    this.element = section("body", "The body", controls, html("div", { class: "bench" }, stage), this.hint);
    this.listen(canvas);
    if (contents.asset) {
      this.poke = new Poke(contents, engine, this.view);
      this.element.querySelector(".bench")?.append(this.poke.panel);
      this.element.append(this.poke.help);
    }
    this.colour();
    this.mark();
    if (points) points.chosen = (point) => this.select(point);
  }

  private colour(): void {
    const depth = Number(this.depth.value);
    this.depthText.textContent = millimetres(depth);
    const ends = this.view.colour(this.map, depth);
    const [, name, unit] = kMaps.find(([key]) => key === this.map) ?? kMaps[0];
    const text = (v: number) => (unit ? quantity(v, unit) : v.toPrecision(2));
    this.bar.replaceChildren();
    if (ends)
      this.bar.append(
        html("div", {}, `${name} at ${millimetres(depth)}`),
        html("div", { class: "gradient", style: `background: ${viridisGradient}` }),
        html("div", { class: "ends" }, html("span", {}, text(ends[0])), html("span", {}, text(ends[1]))),
      );
    const patches = this.contents.maps ? [swatch("not measured", css(kUncovered))] : [];
    if (this.setUpBox?.checked) {
      const keys = Object.keys(this.contents.set_up?.settings ?? {});
      patches.push(swatch("held nodes", kSetUpColours.held));
      if (keys.some((key) => key.startsWith("experiments/region")))
        patches.push(swatch("window", kSetUpColours.window));
      if (keys.some((key) => key.startsWith("inclusion"))) patches.push(swatch("inclusions", kSetUpColours.inclusion));
    }
    const status = this.contents.points?.status ?? (this.contents.set_up ? ["good"] : []);
    if (this.markerMode === "points")
      for (const [name, colour] of Object.entries(kStatusColours))
        if (status.includes(name))
          patches.push(swatch(name === "good" ? "test points" : `${name} point`, css(colour), "point"));
    this.bar.append(...patches.map((patch) => html("div", {}, patch)));
  }

  private mark(): void {
    const { jnd, maps, points } = this.contents;
    let [places, colours]: [Float32Array, [number, number, number][]] = [new Float32Array(0), []];
    this.hint.textContent = `Drag to turn, wheel or two fingers to come nearer${points ? "; click a test point for its curves" : ""}.${maps ? " Grey is not measured: the body answers with its mean there, or not at all." : ""}`;
    if (this.markerMode === "points") {
      places = this.positions;
      colours = Array.from({ length: places.length / 3 }, (_, i) => kStatusColours[points?.status[i] ?? "good"]);
    } else if (this.markerMode === "held_out") {
      const most = Math.max(...this.heldOut.error, jnd.share);
      places = this.heldOut.places;
      colours = this.heldOut.error.map((e) => viridis(e / most));
      this.hint.textContent = `Held-out points from dark (0 %) to bright (${percent(most)}), by the largest error of their rows.`;
    }
    this.view.mark(places, colours);
  }

  private select(point: number): void {
    const place = vector(this.positions, point);
    this.view.select(place);
    const [x, y, z] = vector(floats(this.contents.points?.inward_normal), point);
    this.poke?.aim(place, [-x, -y, -z]);
  }

  private listen(canvas: HTMLCanvasElement): void {
    let pressed: [number, number] | undefined;
    canvas.addEventListener("pointerdown", (event) => {
      pressed = [event.clientX, event.clientY];
    });
    canvas.addEventListener("pointerup", (event) => {
      const isClick = pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) < 4;
      pressed = undefined;
      if (!isClick || this.poke?.isPoking) return;
      const place = this.view.under(event.clientX, event.clientY);
      if (!place) return;
      const point = nearest(this.positions, place.position.toArray());
      this.points?.choose(point, this.view.curveAt(place.position));
    });
    canvas.addEventListener("keydown", (event) => {
      if (this.poke?.isPoking) return;
      const step = 0.12;
      const turns: Record<string, () => void> = {
        ArrowLeft: () => this.view.turn(-step, 0),
        ArrowRight: () => this.view.turn(step, 0),
        ArrowUp: () => this.view.turn(0, step),
        ArrowDown: () => this.view.turn(0, -step),
        "+": () => this.view.turn(0, 0, 0.9),
        "-": () => this.view.turn(0, 0, 1.1),
        Home: () => this.view.home(),
      };
      const turn = turns[event.key];
      if (!turn) return;
      event.preventDefault();
      turn();
    });
  }
}

/** The section of the body, where the points of `points` can be chosen, too. */
export function bodySection(contents: Contents, engine: string, points: PointSection | undefined): HTMLElement {
  try {
    return new BodySection(contents, engine, points).element;
  } catch (failure) {
    // Without WebGL the rest of the page still tells what it can.
    const sentence = `It cannot be drawn here: ${failure instanceof Error ? failure.message : failure}`;
    return section("body", "The body", html("p", { class: "warning" }, sentence));
  }
}
