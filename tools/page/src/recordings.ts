// A picture of each recording of an import: force over travel with contact point and fitted curve,
// and what the curve leaves.

import { seriesColour } from "./colours";
import { type Contents, codes, floats, integers, largest, type Pictures, vector } from "./contents";
import { figure, html, section, swatch } from "./dom";
import { type Axis, plot, type Series } from "./plot";
import { counted, quantity, scaleFor } from "./words";

const kOpen = 24; // pictures that are shown without being asked for
const kTall = 190;
const kFlat = 120;

const dot = (a: number[], b: number[]) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** Rows of one experiment: what was measured, and what the curves of its point answer. */
interface Experiment {
  isPress: boolean;
  /** Depth of a press, or the way of the tip since first touch [m]. */
  at_m: number[];
  normal_N: number[];
  fittedNormal_N: number[];
  lateral_N: number[];
  fittedLateral_N: number[];
  left_N: number[];
}

/** Experiments by number; none without curves that answer. */
function experiments(contents: Contents): Map<number, Experiment> {
  const found = new Map<number, Experiment>();
  const rows = contents.rows;
  if (!rows) return found;
  const normals = floats(contents.points?.inward_normal);
  const [point, experiment, kind] = [integers(rows.point), integers(rows.experiment), codes(rows.kind)];
  const [deflection, force, fitted] = [rows.deflection_m, rows.force_N, rows.fitted_N].map(floats);
  let last = [0, 0, 0];
  point.forEach((p, i) => {
    if (p < 0) return;
    let own = found.get(experiment[i]);
    if (!own) {
      own = {
        isPress: kind[i] === 0,
        at_m: [],
        normal_N: [],
        fittedNormal_N: [],
        lateral_N: [],
        fittedLateral_N: [],
        left_N: [],
      };
      found.set(experiment[i], own);
      last = [0, 0, 0];
    }
    const [u, d, f, a] = [vector(normals, p), vector(deflection, i), vector(force, i), vector(fitted, i)];
    const across = (v: number[]) => Math.hypot(...v.map((c, k) => c - dot(v, u) * u[k]));
    const way = (own.at_m.at(-1) ?? 0) + Math.hypot(...d.map((v, k) => v - last[k]));
    last = d;
    own.at_m.push(own.isPress ? dot(d, u) : way);
    own.normal_N.push(dot(f, u));
    own.fittedNormal_N.push(dot(a, u));
    own.lateral_N.push(across(f));
    own.fittedLateral_N.push(across(a));
    own.left_N.push(Math.hypot(...f.map((v, k) => v - a[k])));
  });
  return found;
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
  travel_m: number[];
  /** Without its bias. */
  force_N: number[];
  isUsed: boolean[];
  /** By the curve; empty without one. */
  fitted_N: number[];
}

class Recordings {
  private readonly first: number[] = [];
  private readonly travel: Float32Array;
  private readonly push: Float32Array;
  private readonly used: Uint8Array;
  private readonly contact: Float32Array;
  private readonly deviation: Float32Array;
  private readonly noise: Float32Array;
  private readonly bias: Float32Array;
  private readonly drift: Float32Array;
  private readonly experiments: Map<number, Experiment>;

  constructor(
    contents: Contents,
    private readonly all: Pictures,
  ) {
    let next = 0;
    for (const count of all.readings) {
      this.first.push(next);
      next += count;
    }
    [this.travel, this.push] = [all.travel_m, all.push_N].map(floats);
    [this.contact, this.deviation, this.noise] = [all.contact_m, all.contact_deviation_m, all.noise_N].map(floats);
    [this.bias, this.drift] = [all.bias_N, all.drift_N_m].map(floats);
    this.used = codes(all.is_used);
    this.experiments = experiments(contents);
  }

  get count(): number {
    return this.all.file.length;
  }

  private signal(i: number): Signal {
    const [from, to] = [this.first[i], this.first[i] + this.all.readings[i]];
    const take = (values: Float32Array | Uint8Array) => Array.from(values.subarray(from, to));
    const travel_m = take(this.travel);
    const own = this.experiments.get(this.all.experiment[i]);
    return {
      travel_m,
      force_N: take(this.push).map((f, k) => f - this.bias[i] - this.drift[i] * travel_m[k]),
      isUsed: take(this.used).map((u) => u > 0),
      fitted_N: own?.isPress ? travel_m.map((t) => between(own.at_m, own.fittedNormal_N, t - this.contact[i])) : [],
    };
  }

  /** Force over travel of the readings that samples come from, and below what the fit leaves. */
  private pressPlots(i: number, s: Signal, title: string): SVGSVGElement[] {
    const contact = this.contact[i];
    const isKnown = Number.isFinite(contact);
    const deepest = Math.max(...s.travel_m);
    const from = isKnown ? contact - 0.75 * (deepest - contact) : Number.NEGATIVE_INFINITY;
    const hasUsed = isKnown && s.isUsed.some(Boolean);
    const shown = s.travel_m.map((_, k) => k).filter((k) => !hasUsed || (s.travel_m[k] >= from && s.isUsed[k]));
    const pick = (values: number[]) => shown.map((k) => values[k]);
    const x = pick(s.travel_m);
    const fitted = s.fitted_N.length ? pick(s.fitted_N) : [];
    const order = x.map((_, k) => k).sort((a, b) => x[a] - x[b]);
    const length = scaleFor(largest(x.map(Math.abs)), "m");
    const force = scaleFor(largest(s.force_N.map(Math.abs)), "N");
    const half = Math.max(this.deviation[i], 0.002 * (deepest - Math.min(...x)));
    const across: Axis = {
      label: "",
      scale: length.scale,
      min: isKnown ? Math.min(...x, contact - half) : Math.min(...x),
      max: deepest,
    };
    const touch: Series[] = isKnown
      ? [{ kind: "span", look: "contact", x: [Math.max(contact - half, across.min ?? 0), contact + half], y: [] }]
      : [];
    const hasFit = fitted.some(Number.isFinite);
    const label = `travel [${length.unit}]`;
    const out = [
      plot(
        `${title}: force over travel`,
        { ...across, label: hasFit ? "" : label },
        { label: `force [${force.unit}]`, scale: force.scale },
        [
          ...touch,
          { kind: "readings", look: "sample", x, y: pick(s.force_N) },
          { kind: "line", colour: seriesColour(1), x: order.map((k) => x[k]), y: order.map((k) => fitted[k]) },
        ],
        kTall,
      ),
    ];
    if (hasFit) {
      const left = pick(s.force_N).map((f, k) => f - fitted[k]);
      const unit = scaleFor(largest(left.map(Math.abs)), "N");
      out.push(
        plot(
          `${title}: what the curve leaves`,
          { ...across, label },
          { label: `left [${unit.unit}]`, scale: unit.scale },
          [
            ...touch,
            { kind: "line", look: "thin", x: [across.min ?? 0, deepest], y: [0, 0] },
            { kind: "readings", look: "sample", x, y: left },
          ],
          kFlat,
        ),
      );
    }
    return out;
  }

  /** Of a drag or path: its rows over the way of the tip. */
  private wayPlots(own: Experiment, title: string): SVGSVGElement[] {
    const length = scaleFor(largest(own.at_m), "m");
    const force = scaleFor(largest([...own.normal_N, ...own.lateral_N].map(Math.abs)), "N");
    const unit = scaleFor(largest(own.left_N), "N");
    const x: Axis = { label: `way since first touch [${length.unit}]`, scale: length.scale, min: 0 };
    return [
      plot(
        `${title}: normal and lateral force over the way`,
        { ...x, label: "" },
        { label: `force [${force.unit}]`, scale: force.scale },
        [
          { kind: "readings", look: "sample", x: own.at_m, y: own.normal_N },
          { kind: "line", colour: seriesColour(1), x: own.at_m, y: own.fittedNormal_N },
          { kind: "readings", colour: seriesColour(2), x: own.at_m, y: own.lateral_N },
          { kind: "line", colour: seriesColour(2), x: own.at_m, y: own.fittedLateral_N },
        ],
        kTall,
      ),
      plot(
        `${title}: what the curves leave`,
        x,
        { label: `left [${unit.unit}]`, scale: unit.scale, min: 0 },
        [{ kind: "readings", look: "sample", x: own.at_m, y: own.left_N }],
        kFlat,
      ),
    ];
  }

  /** One recording; its plots come when `draw` is called. */
  picture(i: number): { element: HTMLElement; draw: () => void } {
    const all = this.all;
    const name = all.grade_names[all.grade[i]];
    const facts = [];
    if (Number.isFinite(this.contact[i]))
      facts.push(
        `contact ${quantity(this.contact[i], "m")} ± ${quantity(this.deviation[i], "m", 2)}` +
          (all.estimator[i] ? ` (${all.estimator[i]})` : ""),
      );
    if (Number.isFinite(this.noise[i])) facts.push(`noise ${quantity(this.noise[i], "N", 2)}`);
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
      const s = this.signal(i);
      if (!s.travel_m.length) {
        plots.append(html("p", { class: "small" }, "No signal was read."));
        return;
      }
      const own = this.experiments.get(all.experiment[i]);
      plots.append(...(own && !own.isPress ? this.wayPlots(own, all.file[i]) : this.pressPlots(i, s, all.file[i])));
    };
    return { element, draw };
  }
}

export function recordingsSection(contents: Contents): HTMLElement | undefined {
  const all = contents.pictures;
  if (!all) return undefined;
  const recordings = new Recordings(contents, all);
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
      ...(contents.rows && codes(contents.rows.kind).some((kind) => kind > 0)
        ? [swatch("lateral force of a drag", seriesColour(2))]
        : []),
    ),
  );
  const drawing = new Map<Element, () => void>();
  const seen = new IntersectionObserver(
    (entries) => {
      for (const entry of entries) if (entry.isIntersecting) drawing.get(entry.target)?.();
    },
    { rootMargin: "600px" },
  );
  const grid = (from: number, to: number) => {
    const pictures = html("div", { class: "figures recordings" });
    for (let i = from; i < to; ++i) {
      const { element, draw } = recordings.picture(i);
      drawing.set(element, draw);
      if (i < kOpen) draw();
      else seen.observe(element);
      pictures.append(element);
    }
    return pictures;
  };
  out.append(grid(0, Math.min(kOpen, recordings.count)));
  if (recordings.count > kOpen) {
    const more = html("details", {}, html("summary", {}, `${recordings.count - kOpen} more`));
    more.addEventListener(
      "toggle",
      () => more.open && more.childElementCount < 2 && more.append(grid(kOpen, recordings.count)),
    );
    out.append(more);
  }
  if (total > recordings.count)
    out.append(html("p", { class: "small" }, `${total - recordings.count} others are not shown here.`));
  return out;
}
