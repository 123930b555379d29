// The data that `palpate report` writes into the page (docs/formats/report.md).
import type { Profile } from "./engine";

/** Numbers as their bytes in base64. */
type Packed = string;

export interface Statement {
  /** The accuracy in a sentence, and all of it in words and a table. */
  verdict: string;
  words: string;
  /** Relative errors count rows above this force. */
  floor_N: number;
  /** On the machine that validated. */
  tick_ns: number | null;
  asset_bytes: number;
}

/** A part of space: a ball, a box or a closed surface; without any of these it is not drawn. */
export interface Region {
  center_m?: number[];
  radius_m?: number;
  low_m?: number[];
  high_m?: number[];
  vertices_m?: Packed;
  triangles?: Packed;
}

interface Curve {
  name: string;
  knots_m: number[];
  value_N: Packed;
  deviation_N: Packed;
}

/** Recordings to be drawn, refused ones first; the readings of all of them one after another. */
export interface Pictures {
  grade_names: string[];
  /** Number of recordings of each grade, shown or not. */
  all: number[];
  file: string[];
  point: string[];
  reasons: string[];
  estimator: string[];
  grade: number[];
  experiment: number[];
  readings: number[];
  contact_m: Packed;
  contact_deviation_m: Packed;
  noise_N: Packed;
  bias_N: Packed;
  drift_N_m: Packed;
  travel_m: Packed;
  push_N: Packed;
  is_used: Packed;
}

export interface Contents {
  schema: string;
  program: string;
  name: string;
  jnd: { floor_N: number; share: number; moving: number; direction_deg: number };
  band_deviations: number;
  warnings: string[];
  statement?: Statement;
  surface?: {
    vertices_m: Packed;
    triangles: Packed;
    inward_normal?: Packed;
  };
  set_up?: {
    /** Nodes that are held. */
    held: Packed;
    nodes_m: Packed;
    boundary: Packed;
    /** Triangles of the boundary that a hollow body has inside. */
    lumen: Packed;
    points_m: Packed;
    /** The scene's text, defaults filled in; empty where recordings were made. */
    scene: string;
    window?: Region;
    inclusions: Region[];
  };
  probe?: { shape: string; friction: number; values: Record<string, number[]> };
  /** Tools of the scene beside its probe: balls fixed to each other in their own axes; of one that is no ball how it ends. */
  tools?: { name: string; balls: [number, number, number][]; radius_m: number[]; profile?: Profile }[];
  maps?: {
    depths_m: number[];
    vertices: Packed;
    force_N: Packed;
    stiffness_N_m: Packed;
    friction: Packed;
  };
  family?: string;
  points?: {
    position_m: Packed;
    inward_normal: Packed;
    name: string[];
    status: string[];
    message: string[];
    rms_residual_N: Packed;
    max_residual_N: Packed;
    depth_range_m: Packed;
    curves: Curve[];
  };
  rows?: {
    point: Packed;
    experiment: Packed;
    kind: Packed;
    deflection_m: Packed;
    force_N: Packed;
    force_error_N: Packed;
    fitted_N: Packed;
    status: Packed;
    status_names: string[];
  };
  pictures?: Pictures;
  held_out?: {
    point: string[];
    path: string[];
    position_m: Packed;
    deflection_m: Packed;
    force_N: Packed;
    engine_N: Packed;
    /** There where a recording has a clock. */
    time_s?: Packed;
  };
  asset?: { bytes: string; range_m: number; program?: string };
}

export function bytes(base64: string): Uint8Array<ArrayBuffer> {
  const text = atob(base64);
  const out = new Uint8Array(text.length);
  for (let i = 0; i < out.length; ++i) out[i] = text.charCodeAt(i);
  return out;
}

export function floats(packed: Packed = ""): Float32Array<ArrayBuffer> {
  return new Float32Array(bytes(packed).buffer);
}

export function integers(packed: Packed = ""): Int32Array<ArrayBuffer> {
  return new Int32Array(bytes(packed).buffer);
}

export type Vector = [number, number, number];

export const dot = (a: number[], b: number[]) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** The part of a vector that is normal to a unit vector. */
export const across = (a: number[], u: number[]) => a.map((v, k) => v - dot(a, u) * u[k]);

/** Row `i` of a packed array of vectors. */
export function vector(values: ArrayLike<number>, i: number): Vector {
  return [values[3 * i], values[3 * i + 1], values[3 * i + 2]];
}

/** A row of an experiment, and the answer of the curves of its point. */
export interface Row {
  deflection: Vector;
  force: Vector;
  fitted: Vector;
  error_N: number;
  status: string;
}

export interface Experiment {
  number: number;
  point: number;
  isPress: boolean;
  rows: Row[];
}

/** Experiments at points with curves. */
export function experimentsOf(contents: Contents): Experiment[] {
  const found: Experiment[] = [];
  const rows = contents.rows;
  if (!rows) return found;
  const [points, numbers] = [integers(rows.point), integers(rows.experiment)];
  const [kind, status] = [bytes(rows.kind), bytes(rows.status)];
  const [deflection, force, fitted] = [rows.deflection_m, rows.force_N, rows.fitted_N].map(floats);
  const error = floats(rows.force_error_N);
  points.forEach((point, i) => {
    if (point < 0) return;
    const [number, last] = [numbers[i], found.at(-1)];
    if (last?.number !== number || last.point !== point)
      found.push({ number, point, isPress: kind[i] === 0, rows: [] });
    found[found.length - 1].rows.push({
      deflection: vector(deflection, i),
      force: vector(force, i),
      fitted: vector(fitted, i),
      error_N: error[i],
      status: rows.status_names[status[i]],
    });
  });
  return found;
}

/** A row of validation.csv: the tool's place, the reference's force, the engine's and its error. */
export interface HeldOutRow {
  place_m: Vector;
  force: Vector;
  engine: Vector;
  force_N: number;
  error_N: number;
  time_s: number;
}

/** A held-out path: its rows in order, the 95th percentile of their relative errors above the floor. */
export interface HeldOutPath {
  point: string;
  path: string;
  rows: HeldOutRow[];
  p95_rel: number;
}

/** From the worst to the best. */
export function heldOutPaths({ held_out, statement, jnd }: Contents): HeldOutPath[] {
  if (!held_out) return [];
  const { position_m, deflection_m, force_N, engine_N, time_s } = held_out;
  const [position, deflection, forces, engines, times] = [position_m, deflection_m, force_N, engine_N, time_s].map(
    floats,
  );
  const found = new Map<string, HeldOutPath>();
  held_out.point.forEach((point, i) => {
    const path = held_out.path[i];
    const own = found.get(`${point} ${path}`) ?? { point, path, rows: [], p95_rel: 0 };
    found.set(`${point} ${path}`, own);
    const [force, engine] = [vector(forces, i), vector(engines, i)];
    own.rows.push({
      place_m: vector(position, i).map((v, k) => v + deflection[3 * i + k]) as Vector,
      force,
      engine,
      force_N: Math.hypot(...force),
      error_N: Math.hypot(...engine.map((v, k) => v - force[k])),
      time_s: times.length ? times[i] : Number.NaN,
    });
  });
  const floor_N = statement?.floor_N ?? jnd.floor_N;
  for (const own of found.values()) {
    const shares = own.rows.filter((row) => row.force_N > floor_N).map((row) => row.error_N / row.force_N);
    shares.sort((a, b) => a - b);
    own.p95_rel = shares.length ? shares[Math.floor(0.95 * (shares.length - 1))] : 0;
  }
  return [...found.values()].sort((a, b) => b.p95_rel - a.p95_rel);
}

/** Number of the place nearest to another [m]; -1 where there are none. places_m: three numbers each. */
export function nearest(places_m: ArrayLike<number>, to_m: ArrayLike<number>): number {
  let [best, least] = [-1, Number.POSITIVE_INFINITY];
  for (let i = 0; i < places_m.length / 3; ++i) {
    let squared = 0;
    for (let k = 0; k < 3; ++k) squared += (places_m[3 * i + k] - to_m[k]) ** 2;
    if (squared < least) [best, least] = [i, squared];
  }
  return best;
}

/** The largest finite value; 0 where none is above it. However many: Math.max(...values) has a limit. */
export function largest(values: Iterable<number>): number {
  let most = 0;
  for (const value of values) if (value > most && Number.isFinite(value)) most = value;
  return most;
}
