// The force along one held-out path: the reference's and the engine's, chosen from a list or on the body.

import { seriesColour } from "./colours";
import { type Contents, type HeldOutPath, heldOutPaths, nearest } from "./contents";
import { choice, figure, html, swatch } from "./dom";
import { axisOf, flatten, plot, type Series } from "./plot";
import { percent, plain } from "./words";

const kComponents = ["x", "y", "z"];

function forces({ point, path, rows }: HeldOutPath): SVGSVGElement {
  const isTimed = rows.every(({ time_s }) => Number.isFinite(time_s));
  const x = rows.map(({ time_s }, i) => (isTimed ? time_s - rows[0].time_s : i));
  const series = kComponents.flatMap((_, k): Series[] => {
    const colour = seriesColour(k);
    return [
      { kind: "readings", colour, x, y: rows.map(({ force }) => force[k]) },
      { kind: "line", colour, x, y: rows.map(({ engine }) => engine[k]) },
    ];
  });
  const across = isTimed ? axisOf("time", "s", x) : { label: "row" };
  return plot(`Force along ${point}, ${plain(path)}`, across, axisOf("force", "N", flatten(series, "y")), series);
}

/** The worst path first. */
export class PathFigure {
  readonly element = html("div", { id: "path-forces" });
  private readonly paths: HeldOutPath[];
  private readonly picture = html("div", { class: "figures" });
  private readonly list: HTMLSelectElement;

  constructor(contents: Contents) {
    this.paths = heldOutPaths(contents);
    const { element, select } = choice(
      "path-choice",
      "Held-out path",
      this.paths.map(({ point, path, p95_rel }, i) => [String(i), `${point}, ${plain(path)}: ${percent(p95_rel)}`]),
      (value) => this.choose(Number(value)),
    );
    this.list = select;
    if (!this.paths.length) return;
    this.element.append(html("p", {}, element, " (95th percentile of the error, the worst first)"), this.picture);
    this.choose(0);
  }

  private choose(path: number): void {
    this.list.value = String(path);
    this.picture.replaceChildren(
      figure(
        "Force on the body along it: dots of the reference, lines of the engine",
        forces(this.paths[path]),
        html("p", { class: "legend" }, ...kComponents.map((name, k) => swatch(name, seriesColour(k)))),
      ),
    );
  }

  /** Chooses the path on which the tool came nearest to a place [m]. */
  chooseNearest(place_m: ArrayLike<number>): void {
    const owner = this.paths.flatMap(({ rows }, path) => rows.map(() => path));
    const places = this.paths.flatMap(({ rows }) => rows.flatMap((row) => row.place_m));
    if (places.length) this.choose(owner[nearest(places, place_m)]);
  }
}
