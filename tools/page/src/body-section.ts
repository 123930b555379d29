// The section of the body: its view and controls, the tool, the curves of the point chosen.

import { BodyView, type MarkerMode } from "./body";
import { css, kSetUpColours, kUncovered, kUncoveredTissue, viridis, viridisGradient } from "./colours";
import { type Contents, floats, type HeldOutPath, heldOutPaths, nearest, vector } from "./contents";
import type { PointSection } from "./curves";
import { button, checkbox, choice, details, html, section, slider, swatch } from "./dom";
import type { PathFigure } from "./paths";
import { Pick } from "./pick";
import { Poke } from "./poke";
import type { MapName } from "./surface";
import { ask } from "./terms";
import { millimetres, percent, quantity } from "./words";

const kMaps: [MapName | "tissue", string, string][] = [
  ["tissue", "tissue", ""],
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

class BodySection {
  private readonly view: BodyView;
  private readonly positions: Float32Array;
  private readonly heldOut: HeldOutPath[];
  private readonly depth: HTMLInputElement;
  private readonly depthText = html("output", {});
  private readonly bar = html("div", {});
  private readonly hint = html("p", { class: "small hint" });
  private readonly maps: HTMLSelectElement;
  private markerMode: MarkerMode;
  private poke: Poke | undefined;
  private pick: Pick | undefined;
  private readonly setUpBox: HTMLInputElement;
  readonly element: HTMLElement;

  constructor(
    private readonly contents: Contents,
    engine: string,
    private readonly points: PointSection | undefined,
    private readonly paths: PathFigure,
  ) {
    this.positions = floats(contents.points?.position_m ?? contents.set_up?.points_m);
    this.heldOut = heldOutPaths(contents);
    const canvas = html("canvas", {
      id: "body-view",
      tabindex: 0,
      role: "application",
      "aria-label":
        "The body. Space presses and lifts, arrow keys move the tool; V switches to turning with the arrow keys; plus and minus come nearer and go away, Home resets the view.",
    });
    this.view = new BodyView(contents, canvas);
    const range = contents.maps?.depths_m.at(-1) ?? 0;
    this.depth = slider("map-depth", 0.05 * range, range, () => this.colour());
    const maps = choice(
      "map-choice",
      "Colour",
      kMaps.filter(([name]) => contents.maps || name === "tissue").map(([name, text]) => [name, text]),
      () => this.colour(),
    );
    this.maps = maps.select;
    const modes: [MarkerMode, string][] = [
      ["none", "none"],
      ["points", "test points"],
    ];
    if (this.heldOut.length) modes.push(["held_out", "held-out errors"]);
    const marks = choice("mark-choice", "Marks", modes, (value) => {
      this.markerMode = value as MarkerMode;
      this.mark();
      this.colour();
    });
    // A body that can be poked is shown without marks; a set-up is there to show its own.
    this.markerMode = contents.asset ? "none" : "points";
    marks.select.value = this.markerMode;
    this.setUpBox = checkbox("show-set-up", !contents.asset && !!contents.set_up, () => this.showSetUp());
    const controls = html("div", { class: "controls" });
    if (contents.maps)
      controls.append(
        html("span", {}, maps.element, " ", ask("stiffness")),
        html("label", {}, "at depth ", this.depth, " ", this.depthText),
      );
    controls.append(html("span", {}, marks.element, " ", ask(this.heldOut.length ? "held-out points" : "test points")));
    if (contents.set_up)
      controls.append(html("span", {}, html("label", {}, this.setUpBox, " set-up"), " ", ask("set-up")));
    const reset = button("reset-view", "Reset view", () => this.resetView());
    const buttons = html("div", { class: "on-picture buttons" }, reset);
    const stage = html("div", { class: "stage" }, canvas, buttons, html("div", { class: "overlay" }, this.bar));
    const bench = html("div", { class: "bench" }, stage);
    this.element = section("body", "Body", bench);
    this.listen(canvas);
    if (contents.asset) {
      const poke = new Poke(contents, engine, this.view);
      this.poke = poke;
      buttons.prepend(poke.turnButton, poke.sideButton);
      stage.append(poke.unmeasured);
      bench.append(poke.panel);
    }
    if (!contents.asset && contents.set_up) {
      this.pick = new Pick(contents, this.view);
      this.element.append(html("h3", {}, "Pick on the picture"), this.pick.element);
    }
    this.element.append(
      details("Colours, marks and help", controls, this.hint, ...(this.poke ? [this.poke.help] : [])),
    );
    this.showSetUp();
    this.mark();
    if (points) points.chosen = (point) => this.select(point);
  }

  private resetView(): void {
    this.view.home();
    this.poke?.lookFromSide(false);
  }

  private showSetUp(): void {
    this.view.showSetUp(this.setUpBox.checked);
    this.colour();
  }

  private colour(): void {
    const depth = Number(this.depth.value);
    this.depthText.textContent = millimetres(depth);
    const [map, name, unit] = kMaps.find(([key]) => key === this.maps.value) ?? kMaps[0];
    const ends = this.view.colour(map === "tissue" ? undefined : map, depth);
    this.depth.disabled = map === "tissue";
    const text = (v: number) => (unit ? quantity(v, unit) : v.toPrecision(2));
    this.bar.replaceChildren();
    if (ends)
      this.bar.append(
        html("div", {}, `${name} at ${millimetres(depth)}`),
        html("div", { class: "gradient", style: `background: ${viridisGradient}` }),
        html("div", { class: "ends" }, html("span", {}, text(ends[0])), html("span", {}, text(ends[1]))),
      );
    const patches = this.contents.maps
      ? [swatch("not measured", css(map === "tissue" ? kUncoveredTissue : kUncovered))]
      : [];
    if (this.setUpBox.checked) {
      patches.push(swatch("held", kSetUpColours.held));
      if (this.contents.set_up?.lumen) patches.push(swatch("inner surface", kSetUpColours.lumen));
      if (this.contents.set_up?.window) patches.push(swatch("window", kSetUpColours.window));
      if (this.contents.set_up?.inclusions.length) patches.push(swatch("inclusions", kSetUpColours.inclusion));
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
    this.hint.textContent = `Wheel or two fingers come nearer.${points ? " A click chooses the point whose curves are below." : ""}${maps ? " Grey is not measured: the body answers with its mean there, or not at all." : ""}`;
    if (this.markerMode === "points") {
      places = this.positions;
      colours = Array.from({ length: places.length / 3 }, (_, i) => kStatusColours[points?.status[i] ?? "good"]);
    } else if (this.markerMode === "held_out") {
      // Bright where twice what is noticeable is reached.
      const rows = this.heldOut.flatMap((path) => path.rows).filter(({ force_N }) => force_N > jnd.floor_N);
      places = Float32Array.from(rows.flatMap(({ place_m }) => place_m));
      colours = rows.map(({ error_N, force_N }) => viridis(error_N / force_N / (2 * jnd.moving)));
      this.hint.textContent = `The tool's places on held-out paths, from dark (no error) to bright (${percent(2 * jnd.moving, 0)} of the force and more). A click shows the path's forces under Accuracy.`;
    }
    this.view.mark(places, colours, this.markerMode === "held_out");
  }

  private select(point: number): void {
    const place = vector(this.positions, point);
    if (this.markerMode !== "none") this.view.select(place);
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
      if (!isClick || event.button !== 0) return;
      const place = this.view.under(event.clientX, event.clientY);
      if (!place) return;
      const at = place.position.toArray();
      if (this.pick) this.pick.add(place.position.toArray());
      else if (this.markerMode === "held_out") this.paths.chooseNearest(at);
      else this.points?.choose(nearest(this.positions, at));
    });
    canvas.addEventListener("keydown", (event) => {
      if (this.poke?.isPoking && event.key.startsWith("Arrow")) return; // they move the tool
      const step = 0.12;
      const turns: Record<string, () => void> = {
        ArrowLeft: () => this.view.turn(-step, 0),
        ArrowRight: () => this.view.turn(step, 0),
        ArrowUp: () => this.view.turn(0, step),
        ArrowDown: () => this.view.turn(0, -step),
        "+": () => this.view.turn(0, 0, 0.9),
        "-": () => this.view.turn(0, 0, 1.1),
        Home: () => this.resetView(),
      };
      const turn = turns[event.key];
      if (!turn) return;
      event.preventDefault();
      turn();
    });
  }
}

/** The section of the body, where test points and held-out paths can be chosen, too. */
export function bodySection(
  contents: Contents,
  engine: string,
  points: PointSection | undefined,
  paths: PathFigure,
): HTMLElement {
  try {
    return new BodySection(contents, engine, points, paths).element;
  } catch (failure) {
    // Without WebGL the rest of the page still works.
    const sentence = `It cannot be drawn here: ${failure instanceof Error ? failure.message : failure}`;
    return section("body", "Body", html("p", { class: "warning" }, sentence));
  }
}
