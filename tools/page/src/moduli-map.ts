// Moduli where the recordings are, seen along the axis in which they differ least.

import { css, viridis, viridisGradient } from "./colours";
import { floats, type Pictures, vector } from "./contents";
import { figure, html } from "./dom";
import { plot, type Series } from "./plot";
import { quantity, scaleFor } from "./words";

const kColours = 24;
const kLeastSpan = 1.1; // of the colours, stiffest over softest
const kAspect = 1.65; // of a plot, width over height

/** Nothing below two places with a modulus. */
export function moduliMap(all: Pictures): HTMLElement | undefined {
  const [young, deviation, position] = [all.young_Pa, all.young_deviation_Pa, all.position_m].map(floats);
  const placed = all.file.map((_, i) => i).filter((i) => young[i] > 0 && vector(position, i).every(Number.isFinite));
  const range = [0, 1, 2].map((k) => {
    const at = placed.map((i) => position[3 * i + k]);
    return [Math.min(...at), Math.max(...at)];
  });
  const extent = range.map(([low, high]) => high - low);
  const size = Math.max(...extent);
  if (placed.length < 2 || !(size > 1e-12)) return undefined;
  const least = extent.lastIndexOf(Math.min(...extent));
  const [u, v] = [0, 1, 2].filter((k) => k !== least);
  const soft = Math.min(...placed.map((i) => young[i]));
  const stiff = Math.max(kLeastSpan * soft, ...placed.map((i) => young[i]));
  const share = (i: number) => Math.log(young[i] / soft) / Math.log(stiff / soft);
  const series: Series[] = Array.from({ length: kColours }, (_, c) => {
    const own = placed.filter((i) => Math.round(share(i) * (kColours - 1)) === c);
    return {
      kind: "dots",
      look: "place",
      colour: css(viridis(c / (kColours - 1))),
      x: own.map((i) => position[3 * i + u]),
      y: own.map((i) => position[3 * i + v]),
      titles: own.map(
        (i) =>
          `${all.point[i]}: ${quantity(young[i], "Pa")} ± ${quantity(deviation[i], "Pa", 2)}, ${all.grade_names[all.grade[i]]}`,
      ),
    };
  });
  // One scale for both axes.
  const half = 0.55 * Math.max(extent[v], extent[u] / kAspect);
  const axis = (k: number, width: number) => {
    const middle = (range[k][0] + range[k][1]) / 2;
    return { min: middle - width, max: middle + width, label: `${"xyz"[k]} [${unit.unit}]`, scale: unit.scale };
  };
  const unit = scaleFor(Math.max(...range.flat().map(Math.abs)), "m");
  return html(
    "div",
    { class: "figures" },
    figure(
      "Young's modulus where it was measured",
      plot("Young's modulus over place", axis(u, half * kAspect), axis(v, half), series),
      html("div", { class: "gradient", style: `background: ${viridisGradient}` }),
      html(
        "div",
        { class: "ends small" },
        html("span", {}, quantity(soft, "Pa")),
        html("span", {}, quantity(stiff, "Pa")),
      ),
    ),
  );
}
