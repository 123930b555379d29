// A window, held parts and test points, picked on a set-up; the lines of the scene for them, to copy.

import type { BodyView } from "./body";
import { kSetUpColours } from "./colours";
import type { Contents, Region, Vector } from "./contents";
import { button, choice, html, slider } from "./dom";

type Part = "window" | "held" | "points";

/** In millimetres with two decimals, as a scene has them. */
const length = (value_m: number) => `"${(1e3 * value_m).toFixed(2)} mm"`;

function ball({ center_m = [], radius_m = 0 }: Region): string {
  return `{ sphere = { center = [${center_m.map(length).join(", ")}], radius = ${length(radius_m)} } }`;
}

export class Pick {
  readonly element: HTMLElement;
  private readonly part: HTMLSelectElement;
  private readonly radius: HTMLInputElement;
  private readonly lines = html("textarea", {
    id: "pick-lines",
    rows: 6,
    readonly: true,
    "aria-label": "Lines for the scene",
  });
  private window: Region | undefined;
  private held: Region[] = [];
  private points: Vector[] = [];

  constructor(
    contents: Contents,
    private readonly view: BodyView,
  ) {
    const parts = choice(
      "pick-part",
      "A click on the body is",
      [
        ["window", "the middle of the window"],
        ["held", "the middle of a held part"],
        ["points", "a test point"],
      ],
      () => {},
    );
    this.part = parts.select;
    this.radius = slider("pick-radius", 0.02 * view.radius, view.radius, () => this.resize());
    this.radius.value = String(contents.set_up?.window?.radius_m ?? 0.3 * view.radius);
    const again = button("pick-again", "Start over", () => {
      this.window = undefined;
      [this.held, this.points] = [[], []];
      this.show();
    });
    this.element = html(
      "div",
      {},
      html("p", { class: "controls" }, parts.element, html("label", {}, "radius ", this.radius), again),
      this.lines,
    );
    this.show();
  }

  /** A place of the surface [m] that was clicked. */
  add(center_m: Vector): void {
    const region = { center_m, radius_m: Number(this.radius.value) };
    const part = this.part.value as Part;
    if (part === "window") this.window = region;
    else if (part === "held") this.held.push(region);
    else this.points.push(center_m);
    this.show();
  }

  /** The slider is of the ball that was picked last. */
  private resize(): void {
    const last = this.part.value === "window" ? this.window : this.held.at(-1);
    if (last && this.part.value !== "points") last.radius_m = Number(this.radius.value);
    this.show();
  }

  private show(): void {
    const text: string[] = [];
    if (this.held.length) text.push("# [body]", `fixed = [ ${this.held.map(ball).join(",\n          ")} ]`);
    if (this.window) text.push("# [experiments]", `region = ${ball(this.window)}`);
    if (this.points.length)
      text.push(
        '# test_points = "points.csv" in [experiments]; points.csv:',
        "x_m,y_m,z_m",
        ...this.points.map((at) => at.map((v) => v.toFixed(6)).join(",")),
      );
    this.lines.value = text.join("\n") || "# Click on the body: lines for the scene appear here.";
    this.view.sketch([
      ...(this.window ? [{ region: this.window, colour: kSetUpColours.window }] : []),
      ...this.held.map((region) => ({ region, colour: kSetUpColours.held })),
      ...this.points.map((center_m) => ({
        region: { center_m, radius_m: 0.012 * this.view.radius },
        colour: kSetUpColours.inclusion,
      })),
    ]);
  }
}
