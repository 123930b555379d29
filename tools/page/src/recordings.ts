// A picture of each recording of an import: force over travel with contact point and fitted curve,
// and the residual of the curve.

import { seriesColour } from "./colours";
import {
  across,
  bytes,
  type Contents,
  dot,
  type Experiment,
  experimentsOf,
  floats,
  type Pictures,
  vector,
} from "./contents";
import { details, figure, html, section, swatch } from "./dom";
import { type Axis, axisOf, plot, type Series } from "./plot";
import { counted, quantity } from "./words";

const kOpen = 24; // pictures that are shown without being asked for
const kTall = 190;
const kFlat = 120;

/** An experiment over the path of its tip. Forces are along the inward normal of its point, and across it. */
interface Traced {
  isPress: boolean;
  /** Depth of a press, or the path of the tip since first touch [m]. */
  at_m: number[];
  normal_N: number[];
  fittedNormal_N: number[];
  lateral_N: number[];
  fittedLateral_N: number[];
  residual_N: number[];
}

function traced({ isPress, rows }: Experiment, u: number[]): Traced {
  const lateral = (v: number[]) => Math.hypot(...across(v, u));
  let [path_m, last] = [0, [0, 0, 0]];
  return {
    isPress,
    at_m: rows.map(({ deflection }) => {
      path_m += Math.hypot(...deflection.map((v, k) => v - last[k]));
      last = deflection;
      return isPress ? dot(deflection, u) : path_m;
    }),
    normal_N: rows.map(({ force }) => dot(force, u)),
    fittedNormal_N: rows.map(({ fitted }) => dot(fitted, u)),
    lateral_N: rows.map(({ force }) => lateral(force)),
    fittedLateral_N: rows.map(({ fitted }) => lateral(fitted)),
    residual_N: rows.map(({ force, fitted }) => Math.hypot(...force.map((v, k) => v - fitted[k]))),
  };
}

/** Between points that rise in x, from (0, 0); NaN beyond the last. */
function between(x: number[], y: number[], at: number): number {
  if (at <= 0) return 0;
  const k = x.findIndex((v) => v >= at);
  if (k < 0) return Number.NaN;
  const [x0, y0] = k > 0 ? [x[k - 1], y[k - 1]] : [0, 0];
  return x[k] > x0 ? y0 + ((y[k] - y0) * (at - x0)) / (x[k] - x0) : y[k];
}

/** The readings of one recording. */
interface Signal {
  contact_m: number;
  deviation_m: number;
  noise_N: number;
  travel_m: number[];
  /** Without its bias. */
  force_N: number[];
  isUsed: boolean[];
  own: Traced | undefined;
}

function signalsOf(contents: Contents, all: Pictures): Signal[] {
  const experiments = new Map(experimentsOf(contents).map((e) => [e.number, e]));
  const normals = floats(contents.points?.inward_normal);
  const [travel, push, used] = [floats(all.travel_m), floats(all.push_N), bytes(all.is_used)];
  const [contact, deviation, noise] = [all.contact_m, all.contact_deviation_m, all.noise_N].map(floats);
  const [bias, drift] = [all.bias_N, all.drift_N_m].map(floats);
  let to = 0;
  return all.readings.map((count, i) => {
    const from = to;
    to += count;
    const travel_m = Array.from(travel.subarray(from, to));
    const experiment = experiments.get(all.experiment[i]);
    return {
      contact_m: contact[i],
      deviation_m: deviation[i],
      noise_N: noise[i],
      travel_m,
      force_N: travel_m.map((t, k) => push[from + k] - bias[i] - drift[i] * t),
      isUsed: travel_m.map((_, k) => used[from + k] > 0),
      own: experiment && traced(experiment, vector(normals, experiment.point)),
    };
  });
}

/** Forces, and below them the residuals of the fit, where there are any, over the same axis. */
function figures(
  [title, residualTitle]: string[],
  x: Axis,
  force: Axis,
  forces: Series[],
  residuals: Series[],
  residual: Axis,
): SVGSVGElement[] {
  const hasFit = residuals[residuals.length - 1].y.length > 0;
  const above = plot(title, hasFit ? { ...x, label: "" } : x, force, forces, kTall);
  return hasFit ? [above, plot(residualTitle, x, residual, residuals, kFlat)] : [above];
}

/** Force over travel of the readings that samples come from. */
function pressPlots(s: Signal, title: string): SVGSVGElement[] {
  const contact = s.contact_m;
  const isKnown = Number.isFinite(contact);
  const deepest = Math.max(...s.travel_m);
  const from = isKnown ? contact - 0.75 * (deepest - contact) : Number.NEGATIVE_INFINITY;
  const hasUsed = isKnown && s.isUsed.some(Boolean);
  const shown = s.travel_m.map((_, k) => k).filter((k) => !hasUsed || (s.travel_m[k] >= from && s.isUsed[k]));
  const pick = (values: number[]) => shown.map((k) => values[k]);
  const x = pick(s.travel_m);
  const own = s.own?.isPress ? s.own : undefined;
  const fitted = own ? x.map((t) => between(own.at_m, own.fittedNormal_N, t - contact)) : [];
  const order = x.map((_, k) => k).sort((a, b) => x[a] - x[b]);
  const half = Math.max(s.deviation_m, 0.002 * (deepest - Math.min(...x)));
  const min = isKnown ? Math.min(...x, contact - half) : Math.min(...x);
  const touch: Series[] = isKnown
    ? [{ kind: "span", look: "contact", x: [Math.max(contact - half, min), contact + half], y: [] }]
    : [];
  const force_N = pick(s.force_N);
  const residual_N = fitted.some(Number.isFinite) ? force_N.map((f, k) => f - fitted[k]) : [];
  return figures(
    [`${title}: force over travel`, `${title}: residual of the curve`],
    { ...axisOf("travel", "m", x), min, max: deepest },
    axisOf("force", "N", s.force_N),
    [
      ...touch,
      { kind: "readings", look: "sample", x, y: force_N },
      { kind: "line", colour: seriesColour(1), x: order.map((k) => x[k]), y: order.map((k) => fitted[k]) },
    ],
    [
      ...touch,
      { kind: "line", look: "thin", x: [min, deepest], y: [0, 0] },
      { kind: "readings", look: "sample", x, y: residual_N },
    ],
    axisOf("residual", "N", residual_N),
  );
}

/** Rows of a drag or path over the path of the tip. */
function pathPlots(own: Traced, title: string): SVGSVGElement[] {
  return figures(
    [`${title}: normal and lateral force over the path`, `${title}: residual of the curves`],
    axisOf("path since first touch", "m", own.at_m, { min: 0 }),
    axisOf("force", "N", [...own.normal_N, ...own.lateral_N]),
    [
      { kind: "readings", look: "sample", x: own.at_m, y: own.normal_N },
      { kind: "line", colour: seriesColour(1), x: own.at_m, y: own.fittedNormal_N },
      { kind: "readings", colour: seriesColour(2), x: own.at_m, y: own.lateral_N },
      { kind: "line", colour: seriesColour(2), x: own.at_m, y: own.fittedLateral_N },
    ],
    [{ kind: "readings", look: "sample", x: own.at_m, y: own.residual_N }],
    axisOf("residual", "N", own.residual_N, { min: 0 }),
  );
}

/** One recording; its plots come when `draw` is called. */
function picture(all: Pictures, i: number, s: Signal): { element: HTMLElement; draw: () => void } {
  const name = all.grade_names[all.grade[i]];
  const facts = [];
  if (Number.isFinite(s.contact_m))
    facts.push(
      `contact ${quantity(s.contact_m, "m")} ± ${quantity(s.deviation_m, "m", 2)}` +
        (all.estimator[i] ? ` (${all.estimator[i]})` : ""),
    );
  if (Number.isFinite(s.noise_N)) facts.push(`noise ${quantity(s.noise_N, "N", 2)}`);
  const plots = html("div", { class: "plots" });
  const point = all.point[i] && !all.file[i].includes(all.point[i]) ? `, point ${all.point[i]}` : "";
  const element = figure(
    `${all.file[i]}${point}`,
    html("p", { class: "facts" }, html("span", { class: `grade ${name}` }, name), " ", facts.join("; ")),
    ...(all.reasons[i] ? [html("p", { class: "reasons" }, all.reasons[i])] : []),
    plots,
  );
  element.classList.add("recording");
  const draw = () => {
    if (plots.childElementCount) return;
    element.classList.add("drawn");
    if (!s.travel_m.length) plots.append(html("p", { class: "small" }, "No signal was read."));
    else if (s.own && !s.own.isPress) plots.append(...pathPlots(s.own, all.file[i]));
    else plots.append(...pressPlots(s, all.file[i]));
  };
  return { element, draw };
}

export function recordingsSection(contents: Contents): HTMLElement | undefined {
  const all = contents.pictures;
  if (!all) return undefined;
  const signals = signalsOf(contents, all);
  const total = all.all.reduce((a, b) => a + b, 0);
  const counts = all.grade_names.map((name, k) => `${all.all[k]} ${name}`).join(", ");
  const out = section(
    "recordings",
    "Recordings",
    html("p", {}, `${counted(total, "recording", "recordings")}: ${counts}. The doubtful ones come first.`),
    html(
      "p",
      { class: "legend" },
      swatch("readings that count", "var(--text)"),
      swatch("contact point ± its standard deviation", "", "contact"),
      swatch("fitted curve", seriesColour(1)),
      ...(contents.rows && bytes(contents.rows.kind).some((kind) => kind > 0)
        ? [swatch("lateral force of a drag", seriesColour(2))]
        : []),
    ),
  );
  const drawing = new Map<Element, () => void>();
  const visible = new IntersectionObserver(
    (entries) => {
      for (const entry of entries) if (entry.isIntersecting) drawing.get(entry.target)?.();
    },
    { rootMargin: "600px" },
  );
  const grid = (from: number, to: number) => {
    const pictures = html("div", { class: "figures recordings" });
    for (let i = from; i < to; ++i) {
      const { element, draw } = picture(all, i, signals[i]);
      drawing.set(element, draw);
      if (i < kOpen) draw();
      else visible.observe(element);
      pictures.append(element);
    }
    return pictures;
  };
  out.append(grid(0, Math.min(kOpen, signals.length)));
  if (signals.length > kOpen) {
    const more = details(`${signals.length - kOpen} more`);
    more.addEventListener("toggle", () => more.childElementCount < 2 && more.append(grid(kOpen, signals.length)));
    out.append(more);
  }
  if (total > signals.length)
    out.append(html("p", { class: "small" }, `${total - signals.length} others are not shown here.`));
  return out;
}
