// Other methods that answer the same touch: `palpate bench rivals --part felt` wrote what they need.

import { bytes, floats, integers, nearest, type Packed, vector } from "./contents";
import { Answer, Engine } from "./engine";
import { GreenRival, type GreenSurface } from "./green";

export type Vector = [number, number, number];

export type FeltRival = { name: string; settings: string } & (
  | { kind: "spring"; stiffness_N_m: number; cone: number }
  | { kind: "curves"; cone: number; position_m: Packed; rows: Packed; depth_m: Packed; push_N: Packed }
  | { kind: "asset"; bytes: string }
  | ({ kind: "green" } & GreenSurface)
);

/** A method that a tip touches. */
export interface Felt {
  /** The tip is outside. */
  start(): void;
  /** Force on the body [N] after a tick with the tip there [m]; inward: of the surface under it. */
  force(tip: Vector, inward: Vector): Vector;
}

const scaled = (v: ArrayLike<number>, by: number): Vector => [by * v[0], by * v[1], by * v[2]];

class SpringRival implements Felt {
  constructor(
    private readonly engine: Engine,
    private readonly cone: number,
    private readonly push_N: (place: Vector, depth_m: number) => number,
  ) {}

  start(): void {
    this.engine.startProxy(this.cone);
  }

  force(tip: Vector): Vector {
    const proxy = this.engine.proxy(tip);
    const depth_m = Math.hypot(proxy[0], proxy[1], proxy[2]);
    return depth_m > 0 ? scaled(proxy, this.push_N(vector(proxy, 1), depth_m) / depth_m) : [0, 0, 0];
  }
}

/** What the press of the nearest test point felt at a depth: straight between its rows. */
function nearestPress(of: FeltRival & { kind: "curves" }): (place: Vector, depth_m: number) => number {
  const [position, rows, depth, push] = [
    floats(of.position_m),
    integers(of.rows),
    floats(of.depth_m),
    floats(of.push_N),
  ];
  const first = [0];
  for (const count of rows) first.push(first[first.length - 1] + count);
  return (place, depth_m) => {
    const point = nearest(position, place);
    let i = first[point] + 1;
    while (i + 1 < first[point + 1] && depth[i] <= depth_m) ++i;
    return push[i - 1] + ((depth_m - depth[i - 1]) / (depth[i] - depth[i - 1])) * (push[i] - push[i - 1]);
  };
}

class AssetRival implements Felt {
  constructor(private readonly engine: Engine) {}

  start(): void {
    this.engine.start();
  }

  force(tip: Vector): Vector {
    this.engine.tick([...tip, 1, 0, 0, 0]);
    return scaled(this.engine.answer().subarray(Answer.force_N), -1);
  }
}

/** engine: of the asset that is touched, whose surface proxies walk on. */
export async function felt(rival: FeltRival, engine: Engine, module: BufferSource): Promise<Felt> {
  if (rival.kind === "spring")
    return new SpringRival(engine, rival.cone, (_, depth_m) => rival.stiffness_N_m * depth_m);
  if (rival.kind === "curves") return new SpringRival(engine, rival.cone, nearestPress(rival));
  if (rival.kind === "green") return new GreenRival(rival);
  return new AssetRival(await Engine.open(module, bytes(rival.bytes)));
}
