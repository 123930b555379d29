// First intersection of a ray with a surface, quickly enough for every move of a pointer over
// 100,000 triangles: neighbours share a ball, and only balls that the ray crosses are searched.

import { type Ray, Triangle, Vector3 } from "three";

const kTogether = 32; // triangles of a ball

interface Hit {
  triangle: number;
  position: Vector3;
  /** Weights of its corners. */
  weights: Vector3;
}

/** A number whose order keeps places together: bits of three coordinates in turn (Morton 1966). */
function morton(x: number, y: number, z: number): number {
  let code = 0;
  for (let bit = 9; bit >= 0; --bit) code = code * 8 + ((x >> bit) & 1) * 4 + ((y >> bit) & 1) * 2 + ((z >> bit) & 1);
  return code;
}

export class Picker {
  /** Triangles in the order of their places. */
  private readonly order: Uint32Array;
  /** Middle and radius of each ball. */
  private readonly balls: Float64Array;
  private readonly corners = [new Vector3(), new Vector3(), new Vector3()];

  /** vertices: at rest [m], three numbers each; index: three corners of each triangle. */
  constructor(
    private readonly vertices: Float32Array,
    private readonly index: ArrayLike<number>,
  ) {
    const count = index.length / 3;
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    vertices.forEach((v, i) => {
      low[i % 3] = Math.min(low[i % 3], v);
      high[i % 3] = Math.max(high[i % 3], v);
    });
    const cell = Math.max(high[0] - low[0], high[1] - low[1], high[2] - low[2], 1e-12) / 1023;
    const keys = new Float64Array(count);
    for (let t = 0; t < count; ++t) {
      const at = [0, 1, 2].map((k) => {
        let sum = 0;
        for (let c = 0; c < 3; ++c) sum += vertices[3 * index[3 * t + c] + k] / 3;
        return Math.floor((sum - low[k]) / cell);
      });
      keys[t] = morton(at[0], at[1], at[2]) * 2 ** 22 + t;
    }
    keys.sort();
    this.order = Uint32Array.from(keys, (key) => key % 2 ** 22);
    this.balls = new Float64Array(4 * Math.ceil(count / kTogether));
    for (let b = 0; b < this.balls.length / 4; ++b) this.bound(b);
  }

  private bound(ball: number): void {
    const [a] = this.corners;
    const own = this.order.subarray(ball * kTogether, (ball + 1) * kTogether);
    const middle = new Vector3();
    const each = (act: (corner: Vector3) => void) => {
      for (const t of own) for (let c = 0; c < 3; ++c) act(a.fromArray(this.vertices, 3 * this.index[3 * t + c]));
    };
    each((corner) => middle.addScaledVector(corner, 1 / (3 * own.length)));
    let squared = 0;
    each((corner) => {
      squared = Math.max(squared, corner.distanceToSquared(middle));
    });
    this.balls.set([middle.x, middle.y, middle.z, Math.sqrt(squared)], 4 * ball);
  }

  /** The first triangle that a ray meets, from either side. */
  hit(ray: Ray): Hit | undefined {
    const [a, b, c] = this.corners;
    const middle = new Vector3();
    const at = new Vector3();
    let [first, nearest] = [-1, Number.POSITIVE_INFINITY];
    const position = new Vector3();
    for (let k = 0; k < this.balls.length / 4; ++k) {
      const reach = this.balls[4 * k + 3];
      if (ray.distanceSqToPoint(middle.fromArray(this.balls, 4 * k)) > reach * reach) continue;
      for (let i = k * kTogether; i < Math.min((k + 1) * kTogether, this.order.length); ++i) {
        const t = this.order[i];
        [a, b, c].forEach((corner, n) => {
          corner.fromArray(this.vertices, 3 * this.index[3 * t + n]);
        });
        if (!ray.intersectTriangle(a, b, c, false, at)) continue;
        const squared = at.distanceToSquared(ray.origin);
        if (squared >= nearest) continue;
        [first, nearest] = [t, squared];
        position.copy(at);
      }
    }
    if (first < 0) return undefined;
    [a, b, c].forEach((corner, n) => {
      corner.fromArray(this.vertices, 3 * this.index[3 * first + n]);
    });
    const weights = Triangle.getBarycoord(position, a, b, c, new Vector3()) ?? new Vector3(1, 0, 0);
    return { triangle: first, position, weights };
  }
}

/** Outward normals of vertices, each weighted by the areas of its triangles; fills `normals`. */
export function fillNormals(at: Float32Array, index: ArrayLike<number>, normals: Float32Array): void {
  normals.fill(0);
  for (let i = 0; i < index.length; i += 3) {
    // One by one: taking arrays apart costs more than the arithmetic here.
    const a = 3 * index[i];
    const b = 3 * index[i + 1];
    const c = 3 * index[i + 2];
    const ux = at[b] - at[a];
    const uy = at[b + 1] - at[a + 1];
    const uz = at[b + 2] - at[a + 2];
    const vx = at[c] - at[a];
    const vy = at[c + 1] - at[a + 1];
    const vz = at[c + 2] - at[a + 2];
    const nx = uy * vz - uz * vy;
    const ny = uz * vx - ux * vz;
    const nz = ux * vy - uy * vx;
    for (let k = 0; k < 3; ++k) {
      const v = 3 * index[i + k];
      normals[v] += nx;
      normals[v + 1] += ny;
      normals[v + 2] += nz;
    }
  }
  for (let v = 0; v < normals.length; v += 3) {
    const length =
      Math.sqrt(normals[v] * normals[v] + normals[v + 1] * normals[v + 1] + normals[v + 2] * normals[v + 2]) || 1;
    normals[v] /= length;
    normals[v + 1] /= length;
    normals[v + 2] /= length;
  }
}
