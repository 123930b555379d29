// What `palpate report` wrote into the page: docs/formats/report.md describes it.
import type { Profile } from "./engine";

interface Packed {
  type: "f32" | "i32" | "u8";
  bytes: string;
}

/** A number, or null where no row counts. */
export type Figure = number | null;

interface ErrorFigures {
  typical_N: Figure;
  median_N: Figure;
  p95_N: Figure;
  max_N: Figure;
  median_rel: Figure;
  p95_rel: Figure;
  max_rel: Figure;
}

interface ShapeFigures {
  median_m: Figure;
  p95_m: Figure;
  max_m: Figure;
  median_rel: Figure;
  p95_rel: Figure;
  max_rel: Figure;
}

/** Of a torque [N m] on the body. */
export interface TorqueFigures {
  typical_Nm: Figure;
  median_Nm: Figure;
  p95_Nm: Figure;
  max_Nm: Figure;
  median_rel: Figure;
  p95_rel: Figure;
  max_rel: Figure;
}

/** How far off one answer to some rows is. */
export interface StatedError extends ErrorFigures {
  rows: number;
  torque?: TorqueFigures;
  /** On the machine that validated, of all tools together. */
  tick_ns?: Figure;
}

export interface Statement {
  force_error: ErrorFigures & { within_jnd: Figure };
  /** Of all rows; empty where none has a torque. */
  torque_error: Partial<TorqueFigures>;
  /** How good it is, and what to do where it is poor: sentences. */
  verdict: string;
  advice: string[];
  probes: number;
  rows: number;
  rows_above_floor: number;
  reference_failures: number;
  /** Of the relative errors: rows above it count. */
  floor_N: number;
  reference_p95_rel: Figure;
  within_reference: Figure;
  /** On the machine that validated. */
  tick_ns: Figure;
  asset_bytes: number;
  /** Empty where the asset does not say how its surface moves. */
  shape_error: { near?: ShapeFigures; all?: ShapeFigures; penetration_m?: number; rows?: number };
  /** Keys of this object, in order, under which lines by name are, and what they are of. */
  sections: { name: string; title: string }[];
  [section: string]: unknown;
}

/** Lines of a section by name, in order. */
export function linesOf(statement: Statement, section: string): [string, StatedError][] {
  return Object.entries((statement[section] ?? {}) as Record<string, StatedError>);
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
  /** How many there are of each grade, shown or not. */
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
  version: number;
  program: string;
  name: string;
  jnd: { floor_N: number; share: number };
  band_deviations: number;
  warnings: string[];
  files?: { name: string; bytes: number; made_from?: string }[];
  statement?: Statement;
  surface?: {
    vertices_m: Packed;
    triangles: Packed;
    inward_normal?: Packed;
  };
  set_up?: {
    held_m: Packed;
    tets: number;
    nodes_m: Packed;
    boundary: Packed;
    points_m: Packed;
    /** The scene's text, defaults filled in; empty where recordings were made. */
    scene: string;
    window?: Region;
    inclusions: (Region & { is_stiffer: boolean })[];
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
  recordings?: {
    file: string[];
    grade: number[];
    reasons: string[];
    estimator: string[];
    noise_N: Packed;
    young_Pa: Packed;
  };
  pictures?: Pictures;
  held_out?: {
    point: string[];
    path: string[];
    position_m: Packed;
    deflection_m: Packed;
    force_N: Packed;
    engine_N: Packed;
  };
  /** A row per round of placement. */
  placement?: { points: number[]; median_rel: number[]; p95_rel: number[]; max_rel: number[] };
  asset?: { bytes: string; range_m: number; program?: string };
}

export function bytes(base64: string): Uint8Array<ArrayBuffer> {
  const text = atob(base64);
  const out = new Uint8Array(text.length);
  for (let i = 0; i < out.length; ++i) out[i] = text.charCodeAt(i);
  return out;
}

export function floats(packed: Packed | undefined): Float32Array<ArrayBuffer> {
  return new Float32Array(bytes(packed?.bytes ?? "").buffer);
}

export function integers(packed: Packed | undefined): Int32Array<ArrayBuffer> {
  return new Int32Array(bytes(packed?.bytes ?? "").buffer);
}

export function codes(packed: Packed | undefined): Uint8Array<ArrayBuffer> {
  return packed ? bytes(packed.bytes) : new Uint8Array(0);
}

/** Row `i` of a packed array of vectors. */
export function vector(values: ArrayLike<number>, i: number): [number, number, number] {
  return [values[3 * i], values[3 * i + 1], values[3 * i + 2]];
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
