// Small plots as SVG, so that they print, scale and follow the colour scheme.

import { largest } from "./contents";
import { svg } from "./dom";
import { scaleFor, tickLabel, ticks } from "./words";

export interface Axis {
  label: string;
  /** Factor from a value to the number on the axis. */
  scale?: number;
  min?: number;
  max?: number;
}

/** Points of a series in data units. `look`: class names (style.css); `colour`: of CSS. `readings` are
 * dots, however many; a `span` is all between its first and second x. */
export interface Series {
  kind: "line" | "dots" | "band" | "readings" | "span";
  look?: string;
  colour?: string;
  x: number[];
  y: number[];
  /** The other edge of a band. */
  y2?: number[];
  /** Text of each dot. */
  titles?: string[];
}

export const flatten = (series: Series[], axis: "x" | "y") => series.flatMap((s) => s[axis]);

const kWidth = 420;
const kHeight = 270;
const kLeft = 52;
const kRight = 12;
const kTop = 12;
const kBottom = 42;

/** An axis in the unit that suits the largest of these values. */
export function axisOf(label: string, base: string, values: number[], limits: Partial<Axis> = {}): Axis {
  const { unit, scale } = scaleFor(largest(values.map(Math.abs)), base);
  return { label: `${label} [${unit}]`, scale, ...limits };
}

/** Both ends of an axis, in its unit. */
function range(axis: Axis, values: number[]): number[] {
  const finite = values.filter(Number.isFinite);
  let low = axis.min ?? Math.min(...finite);
  let high = axis.max ?? Math.max(...finite);
  if (!finite.length && axis.min === undefined) low = 0;
  if (!finite.length && axis.max === undefined) high = low + 1;
  if (!(high > low)) [low, high] = [low - 0.5, low + 0.5];
  const margin = 0.04 * (high - low);
  return [axis.min ?? low - margin, axis.max ?? high + margin].map((v) => v * (axis.scale ?? 1));
}

/** A plot that says `title` to those who do not see it; there is room for a label below that is not empty. */
export function plot(title: string, x: Axis, y: Axis, series: Series[], height = kHeight): SVGSVGElement {
  const bottom = height - (x.label ? kBottom : 22);
  const sx = x.scale ?? 1;
  const sy = y.scale ?? 1;
  const [x0, x1] = range(x, flatten(series, "x"));
  const [y0, y1] = range(y, [...flatten(series, "y"), ...series.flatMap((s) => s.y2 ?? [])]);
  const px = (v: number) => kLeft + ((v * sx - x0) / (x1 - x0)) * (kWidth - kLeft - kRight);
  const py = (v: number) => bottom - ((v * sy - y0) / (y1 - y0)) * (bottom - kTop);
  const root = svg("svg", { viewBox: `0 0 ${kWidth} ${height}`, role: "img", class: "plot", "aria-label": title });
  const middle = (kTop + bottom) / 2;
  const xs = ticks(x0, x1);
  const ys = ticks(y0, y1, Math.max(3, Math.round((bottom - kTop) / 43)));
  for (const v of xs) {
    root.append(
      svg("line", { class: "grid", x1: px(v / sx), x2: px(v / sx), y1: kTop, y2: bottom }),
      svg("text", { x: px(v / sx), y: bottom + 15, "text-anchor": "middle" }, tickLabel(v, xs[1] - xs[0])),
    );
  }
  for (const v of ys) {
    root.append(
      svg("line", { class: "grid", x1: kLeft, x2: kWidth - kRight, y1: py(v / sy), y2: py(v / sy) }),
      svg("text", { x: kLeft - 6, y: py(v / sy) + 4, "text-anchor": "end" }, tickLabel(v, ys[1] - ys[0])),
    );
  }
  root.append(
    svg("text", { x: (kLeft + kWidth - kRight) / 2, y: height - 8, "text-anchor": "middle" }, x.label),
    svg("text", { x: 10, y: middle, "text-anchor": "middle", transform: `rotate(-90 10 ${middle})` }, y.label),
  );
  for (const s of series) {
    const place = (i: number, values: number[]) => `${px(s.x[i]).toFixed(2)},${py(values[i]).toFixed(2)}`;
    const shape = {
      class: `${s.kind === "dots" ? "dot" : s.kind} ${s.look ?? ""}`,
      style: s.colour ? `--c: ${s.colour}` : false,
    };
    const good = s.x.map((_, i) => i).filter((i) => Number.isFinite(s.x[i]) && Number.isFinite(s.y[i]));
    if (s.kind === "span") {
      const width = Math.max(px(s.x[1]) - px(s.x[0]), 0).toFixed(2);
      root.append(svg("rect", { ...shape, x: px(s.x[0]).toFixed(2), y: kTop, width, height: bottom - kTop }));
    } else if (s.kind === "readings") {
      root.append(svg("path", { ...shape, d: good.map((i) => `M${place(i, s.y)}h0`).join("") }));
    } else if (s.kind === "line") {
      root.append(svg("polyline", { ...shape, points: good.map((i) => place(i, s.y)).join(" ") }));
    } else if (s.kind === "band") {
      const back = s.y2 ?? s.y;
      const edge = [...good.map((i) => place(i, s.y)), ...good.reverse().map((i) => place(i, back))];
      root.append(svg("polygon", { ...shape, points: edge.join(" ") }));
    } else {
      for (const i of good) {
        const dot = svg("circle", { ...shape, cx: px(s.x[i]).toFixed(2), cy: py(s.y[i]).toFixed(2), r: 3 });
        if (s.titles) dot.append(svg("title", {}, s.titles[i]));
        root.append(dot);
      }
    }
  }
  return root;
}
