// The surface of the body: its map of colours, its rest and how a tool moves it.

import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DoubleSide,
  DynamicDrawUsage,
  Mesh,
  MeshBasicMaterial,
  type Ray,
  Raycaster,
  SRGBColorSpace,
  Vector3,
} from "three";
import { kTissue, kUncovered, kUncoveredTissue, viridis } from "./colours";
import { type Contents, floats, integers } from "./contents";
import { TissueMaterial } from "./tissue";

export type MapName = "stiffness_N_m" | "force_N" | "friction";

/** A place of the resting surface, as a ray from the eye hits it. */
export interface Place {
  position: Vector3;
  /** Outward, unit, blended over the triangle. */
  outward: Vector3;
  /** The curves answer here; of a body without a map, everywhere. */
  isMeasured: boolean;
}

export function linear(rgb: [number, number, number]): Color {
  return new Color().setRGB(...rgb, SRGBColorSpace);
}

export class BodySurface {
  readonly mesh: Mesh<BufferGeometry, TissueMaterial>;
  /** Outward, a vector a vertex. */
  readonly normals: Float32Array;
  readonly covered: Int32Array;
  /** At rest [m], three numbers a vertex. */
  readonly vertices: Float32Array;
  /** Rays meet it, whatever a tool does to the body. */
  private readonly resting: Mesh;
  /** As `Contents.maps` has them, read once. */
  private readonly maps: Record<MapName, Float32Array>;
  /** A flag a vertex. */
  private readonly isCovered: Uint8Array;

  constructor(private readonly contents: Contents) {
    const surface = contents.surface;
    if (!surface) throw new Error("There is no surface.");
    this.vertices = floats(surface.vertices_m);
    const moving = (numbers: Float32Array) => new BufferAttribute(numbers, 3).setUsage(DynamicDrawUsage);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", moving(this.vertices.slice()));
    geometry.setIndex(new BufferAttribute(new Uint32Array(integers(surface.triangles).buffer), 1));
    geometry.computeBoundingSphere();
    this.resting = new Mesh(geometry.clone(), new MeshBasicMaterial({ side: DoubleSide }));
    geometry.computeVertexNormals();
    this.normals = surface.inward_normal
      ? floats(surface.inward_normal).map((v) => -v)
      : (geometry.getAttribute("normal").array as Float32Array).slice();
    geometry.setAttribute("color", new BufferAttribute(new Float32Array(this.vertices.length), 3));
    geometry.setAttribute("rest", new BufferAttribute(this.vertices, 3));
    const range_m = contents.asset?.range_m ?? contents.maps?.depths_m.at(-1) ?? 1;
    this.mesh = new Mesh(geometry, new TissueMaterial(range_m));
    this.covered = integers(contents.maps?.vertices);
    this.isCovered = new Uint8Array(this.vertices.length / 3).fill(contents.maps ? 0 : 1);
    for (const v of this.covered) this.isCovered[v] = 1;
    this.maps = {
      stiffness_N_m: floats(contents.maps?.stiffness_N_m),
      force_N: floats(contents.maps?.force_N),
      friction: floats(contents.maps?.friction),
    };
  }

  /** Moves the vertices by three numbers each [m], none: to rest. Returns the one that moves most, where it is now. */
  deform(displacement: Float32Array | undefined): { by_m: number; at: Vector3 } {
    const position = this.mesh.geometry.getAttribute("position") as BufferAttribute;
    const at = position.array as Float32Array;
    const rest = this.vertices;
    let [most, squared] = [0, 0];
    if (displacement?.length === rest.length)
      for (let i = 0; i < at.length; i += 3) {
        const x = displacement[i];
        const y = displacement[i + 1];
        const z = displacement[i + 2];
        at[i] = rest[i] + x;
        at[i + 1] = rest[i + 1] + y;
        at[i + 2] = rest[i + 2] + z;
        const here = x * x + y * y + z * z;
        if (here > squared) {
          most = i;
          squared = here;
        }
      }
    else at.set(rest);
    this.mesh.geometry.computeVertexNormals();
    position.needsUpdate = true;
    return { by_m: Math.sqrt(squared), at: new Vector3().fromArray(at, most) };
  }

  /** First intersection of a ray with the resting surface. */
  hit(ray: Ray): Place | undefined {
    const [hit] = new Raycaster(ray.origin, ray.direction).intersectObject(this.resting);
    if (!hit?.face || !hit.barycoord) return undefined;
    const corners = [hit.face.a, hit.face.b, hit.face.c];
    const weights = hit.barycoord.toArray();
    const outward = new Vector3();
    corners.forEach((v, k) => {
      outward.addScaledVector(new Vector3().fromArray(this.normals, 3 * v), weights[k]);
    });
    const isMeasured = corners.every((v) => this.isCovered[v] === 1);
    return { position: hit.point, outward: outward.normalize(), isMeasured };
  }

  /** Values of a map at each covered vertex, between the depths that are stored. */
  private values(name: MapName, depth_m: number): Float32Array | undefined {
    const maps = this.contents.maps;
    if (!maps) return undefined;
    const all = this.maps[name];
    const count = this.covered.length;
    const last = maps.depths_m.length - 1;
    const at = Math.min(Math.max((depth_m / maps.depths_m[last]) * (last + 1) - 1, 0), last);
    const k = Math.min(Math.floor(at), last - 1);
    const t = last > 0 ? at - k : 0;
    const upper = last > 0 ? k + 1 : k;
    return Float32Array.from(
      { length: count },
      (_, i) => (1 - t) * all[Math.max(k, 0) * count + i] + t * all[upper * count + i],
    );
  }

  /** Colours the surface, without a map as tissue; returns the values at the two ends of the colour bar. */
  colour(name: MapName | undefined, depth_m: number): [number, number] | undefined {
    this.mesh.material.setWet(name === undefined);
    const attribute = this.mesh.geometry.getAttribute("color") as BufferAttribute;
    const [own, grey] = (name ? [kUncovered, kUncovered] : [kTissue, kUncoveredTissue]).map(linear);
    for (let v = 0; v < attribute.count; ++v) {
      const c = this.isCovered[v] ? own : grey;
      attribute.setXYZ(v, c.r, c.g, c.b);
    }
    attribute.needsUpdate = true;
    const values = name && this.values(name, depth_m);
    if (!values?.some(Number.isFinite)) return undefined;
    const finite = Array.from(values.filter((v) => Number.isFinite(v) && v !== 0)).sort((a, b) => a - b);
    const [low, high] = [finite[0] ?? 0, finite[finite.length - 1] ?? 1];
    this.covered.forEach((v, i) => {
      if (!Number.isFinite(values[i])) return;
      const c = linear(viridis(high > low ? (values[i] - low) / (high - low) : 0.5));
      attribute.setXYZ(v, c.r, c.g, c.b);
    });
    return [low, high];
  }
}
