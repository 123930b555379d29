// Colours of series, of what stands beside the body, and of values. Viridis by its anchors (van der Walt and Smith 2015), readable without hue.

import viridisTable from "../../../libfit/assets/viridis.inc";

/** The CSS colour of a series by its number. */
export function seriesColour(k: number): string {
  return `var(--c${k % 8})`;
}

/** Red, green, blue from 0 to 1 as a CSS colour. */
export function css(rgb: [number, number, number]): string {
  return `rgb(${rgb.map((v) => Math.round(255 * v)).join(" ")})`;
}

export const kSetUpColours = { held: "#cc79a7", window: "#0072b2", lumen: "#009e73", inclusion: "#d55e00" };

// The table that `palpate export` colours by, too.
const numbers = viridisTable.match(/\d+/g)?.map(Number) ?? [];
const anchors = Array.from({ length: numbers.length / 3 }, (_, k) => numbers.slice(3 * k, 3 * k + 3));

/** Red, green, blue from 0 to 1 of a share from 0 to 1. */
export function viridis(share: number): [number, number, number] {
  const at = Math.min(Math.max(share, 0), 1) * (anchors.length - 1);
  const k = Math.min(Math.floor(at), anchors.length - 2);
  const [a, b, t] = [anchors[k], anchors[k + 1], at - k];
  return [0, 1, 2].map((i) => (a[i] + t * (b[i] - a[i])) / 255) as [number, number, number];
}

/** Places that no test point answers for; never a colour of the bar. */
export const kUncovered: [number, number, number] = [0.62, 0.62, 0.62];
/** The same beside tissue, and tissue. */
export const kUncoveredTissue: [number, number, number] = [0.63, 0.54, 0.51];
export const kTissue: [number, number, number] = [0.54, 0.2, 0.17];

export const viridisGradient = `linear-gradient(to right, ${anchors.map((c) => `rgb(${c.join(" ")})`).join(", ")})`;
