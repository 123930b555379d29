// A ball on Green's functions of a surface, as tools/workshop/rivals/green.cpp solves it.

import { floats, type Packed } from "./contents";

type Vector = [number, number, number];

export interface GreenSurface {
  radius_m: number;
  friction: number;
  sweeps: number;
  tolerance: number;
  /** Nodes this far from the ball may be touched, in radii. */
  margin: number;
  modulus: number;
  /** At rest, three numbers each. */
  node_m: Packed;
  /** The lower triangle, row by row, of the displacement of each node under a force on each. */
  compliance_m_N: Packed;
}

const dot = (a: Vector, b: Vector): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

export class GreenRival {
  private readonly node: Float32Array;
  private readonly lower: Float32Array;
  /** On each node [N]. */
  private readonly load: Float64Array;
  private readonly moved: Float64Array;
  private active: number[] = [];
  private centre: Vector | undefined;

  constructor(private readonly of: GreenSurface) {
    this.node = floats(of.node_m);
    this.lower = floats(of.compliance_m_N);
    this.load = new Float64Array(this.node.length);
    this.moved = new Float64Array(this.node.length);
  }

  start(): void {
    this.load.fill(0);
    this.active = [];
    this.centre = undefined;
  }

  /** Force on the body [N] with the ball's lowest point, along `inward`, at the tip [m]. */
  force(tip: Vector, inward: Vector): Vector {
    const centre = tip.map((x, k) => x - this.of.radius_m * inward[k]) as Vector;
    const before = this.centre ?? centre;
    const shift = centre.map((x, k) => x - before[k]) as Vector;
    this.centre = centre;
    this.gather(centre);
    for (const n of this.active) for (let k = 0; k < 3; ++k) this.moved[3 * n + k] = this.displacement(3 * n + k);
    const last = this.moved.slice();
    for (let sweep = 0; sweep < this.of.sweeps; ++sweep) {
      let change = 0;
      for (const n of this.active) change += this.relax(n, centre, shift, last);
      const all = this.active.reduce((sum, n) => sum + this.of3(this.load, n).reduce((s, f) => s + Math.abs(f), 0), 0);
      if (change <= this.of.tolerance * all) break;
    }
    const sum: Vector = [0, 0, 0];
    for (const n of this.active) for (let k = 0; k < 3; ++k) sum[k] += this.of.modulus * this.load[3 * n + k];
    return sum;
  }

  private compliance(row: number, column: number): number {
    const [r, c] = row < column ? [column, row] : [row, column];
    return this.lower[(r * (r + 1)) / 2 + c];
  }

  private displacement(row: number): number {
    let sum = 0;
    for (const n of this.active)
      for (let k = 0; k < 3; ++k) sum += this.compliance(row, 3 * n + k) * this.load[3 * n + k];
    return sum;
  }

  private of3(values: ArrayLike<number>, n: number): Vector {
    return [values[3 * n], values[3 * n + 1], values[3 * n + 2]];
  }

  /** Nodes about the ball, and those that it pressed at the last tick. */
  private gather(centre: Vector): void {
    const within_m = (1 + this.of.margin) * this.of.radius_m;
    this.active = [];
    for (let n = 0; 3 * n < this.node.length; ++n) {
      const away = this.of3(this.node, n).map((x, k) => x - centre[k]);
      const isPressed = this.of3(this.load, n).some((f) => f !== 0);
      if (isPressed || Math.hypot(...away) < within_m) this.active.push(n);
    }
  }

  /** A node as if the others' forces stayed; returns the change of its force [N]. */
  private relax(n: number, centre: Vector, shift: Vector, last: Float64Array): number {
    const old = this.of3(this.load, n);
    const moved = this.of3(this.moved, n);
    const away = this.of3(this.node, n).map((x, k) => x + moved[k] - centre[k]) as Vector;
    const length = Math.hypot(...away);
    const gap = length - this.of.radius_m;
    if (gap > 0 && old.every((f) => f === 0)) return 0;
    const normal = away.map((x) => x / length) as Vector;
    const own = [0, 1, 2].map((i) => [0, 1, 2].map((k) => this.compliance(3 * n + i, 3 * n + k)) as Vector);
    const give = dot(normal, own.map((row) => dot(row, normal)) as Vector);
    const pressed = Math.max(0, dot(old, normal) - gap / give);
    const slip = moved.map((x, k) => x - last[3 * n + k] - shift[k]) as Vector;
    const softest = Math.max(own[0][0], own[1][1], own[2][2]);
    const [along, slid] = [dot(old, normal), dot(slip, normal)];
    const side = old.map((f, k) => f - along * normal[k] - (slip[k] - slid * normal[k]) / softest) as Vector;
    const held = Math.min(1, (this.of.friction * pressed) / (Math.hypot(...side) || 1));
    const change = side.map((f, k) => pressed * normal[k] + held * f - old[k]) as Vector;
    for (let k = 0; k < 3; ++k) this.load[3 * n + k] += change[k];
    for (const other of this.active)
      for (let i = 0; i < 3; ++i)
        for (let k = 0; k < 3; ++k) this.moved[3 * other + i] += this.compliance(3 * other + i, 3 * n + k) * change[k];
    return Math.hypot(...change);
  }
}
