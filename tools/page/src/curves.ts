// The curves of one test point with its samples, bands and residuals.

import { seriesColour } from "./colours";
import { across, type Contents, dot, type Experiment, experimentsOf, floats, type Row, vector } from "./contents";
import { choice, figure, html, section } from "./dom";
import { axisOf, flatten, plot, type Series } from "./plot";
import { plain, quantity } from "./words";

/** Samples of the test points, read once. */
class Curves {
  private readonly experiments: Experiment[][];
  private readonly normal: Float32Array;
  private readonly curve: { name: string; knots: number[]; value: Float32Array; deviation: Float32Array }[];

  constructor(private readonly contents: Contents) {
    const points = contents.points;
    this.normal = floats(points?.inward_normal);
    this.curve = (points?.curves ?? []).map((c) => ({
      name: c.name,
      knots: c.knots_m,
      value: floats(c.value_N),
      deviation: floats(c.deviation_N),
    }));
    this.experiments = (points?.name ?? []).map(() => []);
    for (const experiment of experimentsOf(contents)) this.experiments[experiment.point].push(experiment);
  }

  hasDrags(point: number): boolean {
    return this.experiments[point].some((e) => !e.isPress);
  }

  /** A curve of a point from 0 to its last knot, in front of its band where that is known. */
  private curveSeries(kind: number, point: number, colour: string): Series[] {
    const { knots, value, deviation } = this.curve[kind];
    const count = value.length / this.experiments.length;
    const take = (all: Float32Array) => Array.from(all.subarray(point * count, (point + 1) * count));
    const x = Array.from({ length: count }, (_, i) => (knots[knots.length - 1] * i) / (count - 1));
    const y = take(value);
    const half = take(deviation).map((d) => d * this.contents.band_deviations);
    const line: Series = { kind: "line", colour, x, y };
    if (half.length === 0 || !half.every(Number.isFinite)) return [line];
    return [{ kind: "band", colour, x, y: y.map((v, i) => v - half[i]), y2: y.map((v, i) => v + half[i]) }, line];
  }

  /** Force over depth: band, curve, knots, the presses' rows. */
  private pressPlot(point: number): SVGSVGElement {
    const u = vector(this.normal, point);
    const series = this.curveSeries(0, point, seriesColour(0));
    const good: Series = { kind: "dots", look: "sample", x: [], y: [], titles: [] };
    const bad: Series = { kind: "dots", look: "bad", x: [], y: [], titles: [] };
    for (const e of this.experiments[point].filter((e) => e.isPress)) {
      for (const row of e.rows) {
        const into = row.status === "good" ? good : bad;
        into.x.push(dot(row.deflection, u));
        into.y.push(dot(row.force, u));
        into.titles?.push(
          `${quantity(dot(row.deflection, u), "m")}: ${quantity(dot(row.force, u), "N")} ± ${quantity(row.error_N, "N")}, ${plain(row.status)}`,
        );
      }
      // A law that leans answers otherwise than its curve.
      series.push({
        kind: "line",
        look: "thin",
        x: [0, ...e.rows.map((row) => dot(row.deflection, u))],
        y: [0, ...e.rows.map((row) => dot(row.fitted, u))],
      });
    }
    const knots = this.curve[0].knots;
    series.push({
      kind: "dots",
      look: "knot",
      x: knots,
      y: knots.map(() => 0),
      titles: knots.map((k) => `knot at ${quantity(k, "m")}`),
    });
    series.push(good, bad);
    return plot(
      "Normal force over depth",
      axisOf("depth", "m", knots, { min: 0 }),
      axisOf("normal force", "N", [...good.y, ...series[0].y]),
      series,
    );
  }

  /** Lateral force over lateral path of the drags: the rows, and the fitted law's answer to them. */
  private dragPlot(point: number): SVGSVGElement {
    const u = vector(this.normal, point);
    const series: Series[] = [];
    this.experiments[point]
      .filter((e) => !e.isPress)
      .forEach((e, k) => {
        const first = e.rows[0].deflection;
        const offset = (row: Row) => across(row.deflection, u).map((v, i) => v - across(first, u)[i]);
        const middle = offset(e.rows[Math.floor(e.rows.length / 2)]);
        const length = Math.hypot(...middle) || 1;
        const along = middle.map((v) => v / length);
        const depth = quantity(dot(first, u), "m");
        const x = e.rows.map((row) => dot(offset(row), along));
        series.push(
          { kind: "line", colour: seriesColour(k), x, y: e.rows.map((row) => dot(row.fitted, along)) },
          {
            kind: "dots",
            colour: seriesColour(k),
            x,
            y: e.rows.map((row) => (row.status === "good" ? dot(row.force, along) : Number.NaN)),
            titles: e.rows.map(
              (row, i) => `${depth} deep, ${quantity(x[i], "m")} along: ${quantity(dot(row.force, along), "N")}`,
            ),
          },
        );
      });
    return plot(
      "Force along a drag over its path",
      axisOf("path along the drag", "m", flatten(series, "x")),
      axisOf("force along it", "N", flatten(series, "y")),
      series,
    );
  }

  /** Curves beside the normal one: lateral force, limit. */
  private otherPlot(kind: number, point: number): SVGSVGElement {
    const name = this.curve[kind].name;
    const series = this.curveSeries(kind, point, seriesColour(2));
    return plot(
      `${name} force`,
      axisOf(name === "lateral" ? "lateral deflection" : "depth", "m", flatten(series, "x"), { min: 0 }),
      axisOf(name === "limit" ? "force at which it slides" : `${name} force`, "N", flatten(series, "y"), { min: 0 }),
      series,
    );
  }

  /** All that is known of a test point. */
  show(point: number): Node[] {
    const points = this.contents.points;
    if (!points) return [];
    const residual = floats(points.rms_residual_N)[point];
    const facts = [
      `${points.status[point]} fit`,
      `residual ${quantity(residual, "N")} (root mean square), ${quantity(floats(points.max_residual_N)[point], "N")} at most`,
      `deepest good row ${quantity(floats(points.depth_range_m)[point], "m")}`,
    ];
    const hasRows = this.experiments[point].length > 0;
    if (hasRows) facts.push(this.hasDrags(point) ? "pressed and dragged" : "pressed, not dragged");
    const pictures = [
      figure("Pressing: curve, its 90 % band, knots, rows, and the law through them", this.pressPlot(point)),
    ];
    if (this.hasDrags(point))
      pictures.push(figure("Dragging: rows, and lines of the fitted law", this.dragPlot(point)));
    this.curve.forEach((c, kind) => {
      if (kind > 0)
        pictures.push(
          figure(
            c.name === "limit" ? "Friction limit" : `${c.name[0].toUpperCase()}${c.name.slice(1)} curve`,
            this.otherPlot(kind, point),
          ),
        );
    });
    const out: Node[] = [html("p", {}, `${points.name[point]}: ${facts.join("; ")}.`)];
    if (points.message[point]) out.push(html("p", { class: "warning" }, points.message[point]));
    out.push(html("div", { class: "figures" }, ...pictures));
    return out;
  }
}

/** The section of the curves of one point, chosen from a list or on the body. */
export class PointSection {
  readonly element: HTMLElement;
  /** Called with every point that is chosen. */
  chosen: (point: number) => void = () => {};
  private readonly curves: Curves;
  private readonly detail = html("div", { id: "point-detail", "aria-live": "polite" });
  private readonly list: HTMLSelectElement;

  constructor(private readonly contents: Contents) {
    this.curves = new Curves(contents);
    const names = contents.points?.name ?? [];
    const { element, select } = choice(
      "point-choice",
      "Test point",
      names.map((name, i) => [String(i), this.curves.hasDrags(i) ? `${name} (dragged)` : name]),
      (value) => this.choose(Number(value)),
    );
    this.list = select;
    this.element = section("curves", "Point curves", html("p", {}, element), this.detail);
  }

  choose(point: number): void {
    this.list.value = String(point);
    this.detail.replaceChildren(...this.curves.show(point));
    this.chosen(point);
  }

  /** Chooses the point nearest to the middle of all, a dragged one if there is any. */
  chooseFirst(): void {
    const places = floats(this.contents.points?.position_m);
    const count = places.length / 3;
    const middle = [0, 1, 2].map((k) => places.reduce((sum, v, i) => (i % 3 === k ? sum + v / count : sum), 0));
    const away = (i: number) => Math.hypot(...vector(places, i).map((v, k) => v - middle[k]));
    const all = Array.from({ length: count }, (_, i) => i);
    const dragged = all.filter((i) => this.curves.hasDrags(i));
    this.choose((dragged.length ? dragged : all).reduce((a, b) => (away(b) < away(a) ? b : a)));
  }
}
