// The body in three dimensions: its map of colours, markers, the tool that touches it.

import {
  AmbientLight,
  Box3,
  BufferAttribute,
  BufferGeometry,
  Color,
  DirectionalLight,
  DoubleSide,
  type Group,
  InstancedMesh,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  Object3D,
  PerspectiveCamera,
  Raycaster,
  Scene,
  SphereGeometry,
  SRGBColorSpace,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { kUncovered, viridis } from "./colours";
import type { PlaceCurve } from "./curves";
import { type Contents, floats, integers, nearest, vector } from "./contents";
import { setUpGroup, ToolGlyph } from "./glyphs";

export type MapName = "stiffness_N_m" | "force_N" | "friction";
export type MarkerMode = "points" | "held_out" | "none";

/** Where a ray from the eye meets the resting surface. */
export interface Place {
  position: Vector3;
  /** Outward, unit, blended over the triangle. */
  outward: Vector3;
}

const kMarkerShare = 0.01; // of the view's radius

function linear(rgb: [number, number, number]): Color {
  return new Color().setRGB(...rgb, SRGBColorSpace);
}

export class BodyView {
  readonly radius: number;
  /** A window's middle, its mean outward normal. */
  private readonly focus = new Vector3();
  private readonly facing = new Vector3();
  private distance = 0;
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera: PerspectiveCamera;
  private readonly controls: OrbitControls;
  private readonly mesh: Mesh<BufferGeometry, MeshLambertMaterial>;
  private readonly covered: Int32Array;
  /** As `Contents.maps` has them, read once. */
  private readonly maps: Record<MapName, Float32Array>;
  private readonly normals: Float32Array;
  private markers: InstancedMesh | undefined;
  private readonly selection: Mesh;
  private readonly setUp: Group;
  private readonly tool: ToolGlyph;
  private isDue = false;

  constructor(
    private readonly contents: Contents,
    readonly canvas: HTMLCanvasElement,
  ) {
    const surface = contents.surface;
    if (!surface) throw new Error("There is no surface.");
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    const geometry = new BufferGeometry();
    const vertices = floats(surface.vertices_m);
    geometry.setAttribute("position", new BufferAttribute(vertices, 3));
    geometry.setIndex(new BufferAttribute(new Uint32Array(integers(surface.triangles).buffer), 1));
    geometry.computeVertexNormals();
    geometry.computeBoundingSphere();
    this.normals = surface.inward_normal
      ? floats(surface.inward_normal).map((v) => -v)
      : (geometry.getAttribute("normal").array as Float32Array);
    geometry.setAttribute("color", new BufferAttribute(new Float32Array(vertices.length), 3));
    this.mesh = new Mesh(geometry, new MeshLambertMaterial({ vertexColors: true, side: DoubleSide }));
    this.covered = integers(contents.maps?.vertices);
    this.maps = {
      stiffness_N_m: floats(contents.maps?.stiffness_N_m),
      force_N: floats(contents.maps?.force_N),
      friction: floats(contents.maps?.friction),
    };
    this.radius = this.frame(vertices);
    this.camera = new PerspectiveCamera(35, 1, this.radius / 50, this.radius * 50);
    this.camera.up.set(0, 0, 1);
    const light = new DirectionalLight(0xffffff, 2.4);
    light.position.set(-0.5, 0.8, 1);
    this.camera.add(light);
    this.scene.add(new AmbientLight(0xffffff, 1.1), this.camera, this.mesh);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    const size = kMarkerShare * this.radius;
    this.selection = new Mesh(new SphereGeometry(1.9 * size, 24, 16), new MeshBasicMaterial({ color: 0xd55e00 }));
    this.selection.visible = false;
    this.setUp = setUpGroup(contents);
    this.tool = new ToolGlyph(this.radius, 2 * size);
    this.scene.add(this.setUp, this.tool.group);
    this.scene.add(this.selection);
    this.home();
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  /** What the first look is turned to: the window, or the whole body. Returns the body's radius. */
  private frame(vertices: Float32Array): number {
    const sphere = this.mesh.geometry.boundingSphere;
    const whole = sphere?.radius ?? 1;
    this.focus.copy(sphere?.center ?? new Vector3());
    this.facing.set(-0.3, -1, 0.9);
    this.distance = 2.5 * whole;
    const seen = this.covered.length ? this.covered : this.besideTestPoints(vertices);
    const box = new Box3();
    const mean = new Vector3();
    for (const v of seen) {
      box.expandByPoint(new Vector3(...vector(vertices, v)));
      mean.add(new Vector3(...vector(this.normals, v)));
    }
    const window_m = seen.length ? box.getSize(new Vector3()).length() / 2 : whole;
    if (mean.length() < 0.3 * seen.length || window_m > 0.6 * whole) return whole;
    // A little from the front, so that what is up stays up.
    this.facing.copy(mean.normalize()).add(new Vector3(-0.25, -0.75, 0));
    this.focus.lerp(box.getCenter(new Vector3()), 0.8);
    if (this.covered.length) this.distance = Math.max(2 * whole, 3.2 * window_m);
    return whole;
  }

  /** Of a set-up without curves, the vertices nearest to its test points. */
  private besideTestPoints(vertices: Float32Array): Int32Array {
    const points = floats(this.contents.set_up?.points_m);
    return Int32Array.from({ length: points.length / 3 }, (_, p) => nearest(vertices, vector(points, p)));
  }

  showSetUp(isShown: boolean): void {
    this.setUp.visible = isShown;
    this.mesh.material.transparent = isShown;
    this.mesh.material.opacity = isShown ? 0.45 : 1;
    this.mesh.material.depthWrite = !isShown;
    this.mesh.material.needsUpdate = true;
    this.draw();
  }

  /** Back to the first look. */
  home(): void {
    this.controls.target.copy(this.focus);
    this.camera.position.copy(this.focus).addScaledVector(this.facing.clone().normalize(), this.distance);
    this.controls.update();
    this.draw();
  }

  /** Turns the look by angles [rad] and comes nearer by a factor. */
  turn(sideways: number, up: number, nearer = 1): void {
    const from = this.camera.position.clone().sub(this.controls.target);
    const flat = Math.hypot(from.x, from.y);
    const length = from.length() * nearer;
    const azimuth = Math.atan2(from.y, from.x) + sideways;
    const elevation = Math.min(Math.max(Math.atan2(from.z, flat) + up, -1.5), 1.5);
    from.set(Math.cos(azimuth) * Math.cos(elevation), Math.sin(azimuth) * Math.cos(elevation), Math.sin(elevation));
    this.camera.position.copy(this.controls.target).addScaledVector(from, length);
    this.controls.update();
  }

  /** Whether a drag of the pointer turns the look. */
  setOrbit(isOn: boolean): void {
    this.controls.enabled = isOn;
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

  /** Normal force over depth at the covered vertex nearest to a place; none where the place is not covered. */
  curveAt(place: Vector3): PlaceCurve | undefined {
    const maps = this.contents.maps;
    if (!maps) return undefined;
    const vertices = this.mesh.geometry.getAttribute("position").array;
    const i = this.covered.indexOf(nearest(vertices, place.toArray()));
    if (i < 0) return undefined;
    const force = this.maps.force_N;
    return {
      depth_m: [0, ...maps.depths_m],
      force_N: [0, ...maps.depths_m.map((_, k) => force[k * this.covered.length + i])],
    };
  }

  /** Colours the surface; returns the values at the two ends of the colour bar. */
  colour(name: MapName, depth_m: number): [number, number] | undefined {
    const attribute = this.mesh.geometry.getAttribute("color") as BufferAttribute;
    const grey = linear(kUncovered);
    for (let v = 0; v < attribute.count; ++v) attribute.setXYZ(v, grey.r, grey.g, grey.b);
    const values = this.values(name, depth_m);
    let ends: [number, number] | undefined;
    if (values?.some(Number.isFinite)) {
      const finite = Array.from(values.filter((v) => Number.isFinite(v) && v !== 0)).sort((a, b) => a - b);
      ends = [finite[0] ?? 0, finite[finite.length - 1] ?? 1];
      const [low, high] = ends;
      this.covered.forEach((v, i) => {
        if (!Number.isFinite(values[i])) return;
        const c = linear(viridis(high > low ? (values[i] - low) / (high - low) : 0.5));
        attribute.setXYZ(v, c.r, c.g, c.b);
      });
    }
    attribute.needsUpdate = true;
    this.draw();
    return ends;
  }

  /** Balls at places [m], coloured each. */
  mark(places: Float32Array, colours: [number, number, number][]): void {
    if (this.markers) this.scene.remove(this.markers);
    this.markers?.dispose();
    const size = kMarkerShare * this.radius;
    const count = places.length / 3;
    this.markers = new InstancedMesh(new SphereGeometry(size, 16, 12), new MeshBasicMaterial(), count);
    const at = new Object3D();
    for (let i = 0; i < count; ++i) {
      at.position.set(...vector(places, i));
      at.updateMatrix();
      this.markers.setMatrixAt(i, at.matrix);
      this.markers.setColorAt(i, linear(colours[i]));
    }
    this.scene.add(this.markers);
    this.draw();
  }

  select(place: [number, number, number] | undefined): void {
    this.selection.visible = place !== undefined;
    if (place) this.selection.position.set(...place);
    this.draw();
  }

  /** What the pointer at a place of the window looks at; nothing beside the body. */
  under(clientX: number, clientY: number): Place | undefined {
    const box = this.canvas.getBoundingClientRect();
    const caster = new Raycaster();
    caster.setFromCamera(
      new Vector2((2 * (clientX - box.left)) / box.width - 1, 1 - (2 * (clientY - box.top)) / box.height),
      this.camera,
    );
    return this.hit(caster);
  }

  /** Where a ray against an outward normal, through a point [m] near the surface, meets it from outside. */
  beside(point: Vector3, outward: Vector3): Place | undefined {
    return this.hit(new Raycaster(point.clone().addScaledVector(outward, 0.2 * this.radius), outward.clone().negate()));
  }

  private hit(caster: Raycaster): Place | undefined {
    const hit = caster.intersectObject(this.mesh)[0];
    if (!hit?.face || !hit.barycoord) return undefined;
    const outward = new Vector3();
    [hit.face.a, hit.face.b, hit.face.c].forEach((v, k) => {
      outward.addScaledVector(new Vector3(...vector(this.normals, v)), hit.barycoord?.getComponent(k) ?? 0);
    });
    if (outward.lengthSq() < 1e-12) outward.copy(hit.face.normal);
    return { position: hit.point, outward: outward.normalize() };
  }

  /** The screen's right and up as directions in space. */
  screenAxes(): [Vector3, Vector3] {
    const right = new Vector3();
    const up = new Vector3();
    this.camera.matrixWorld.extractBasis(right, up, new Vector3());
    return [right, up];
  }

  /** Draws the tool with its tip at a place and the force on it as an arrow; none hides it. */
  showTool(tip: Vector3 | undefined, outward: Vector3, ball_m: number, force: Vector3, fullForce_N: number): void {
    this.tool.show(tip, outward, ball_m, force, fullForce_N);
    this.draw();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    // Narrow windows see as much across as wide ones see upward.
    this.camera.fov =
      this.camera.aspect < 1
        ? (2 * 180 * Math.atan(Math.tan((35 * Math.PI) / 360) / this.camera.aspect)) / Math.PI
        : 35;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /** Once in the next frame. */
  draw(): void {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      this.renderer.render(this.scene, this.camera);
    });
  }
}
