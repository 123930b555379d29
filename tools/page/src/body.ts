// The body in three dimensions: its surface, markers, the tool that touches it, and the look at them.

import {
  Box3,
  DirectionalLight,
  Group,
  HemisphereLight,
  InstancedMesh,
  Mesh,
  MeshBasicMaterial,
  MOUSE,
  Object3D,
  PerspectiveCamera,
  Ray,
  Raycaster,
  Scene,
  SphereGeometry,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { type Contents, floats, nearest, type Region, vector } from "./contents";
import { type DrawnTool, drawRegion, setUpGroup, ToolGlyph } from "./glyphs";
import { BodySurface, linear, type MapName, type Place } from "./surface";

export type MarkerMode = "points" | "held_out" | "none";

const kMarkerShare = 0.01; // of the view's radius
const kSideLift = 0.3; // rad: from the side one looks down a little on what is pressed

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
  private readonly surface: BodySurface;
  private markers: InstancedMesh | undefined;
  private readonly selection: Mesh;
  private readonly marks = new Group();
  private readonly sketched = new Group();
  private readonly setUp: Group;
  private readonly tools: ToolGlyph[];
  /** A plane through the tool, what lies beyond it is not drawn; and the look before. */
  private cut: { normal: Vector3; through: Vector3; eye: Vector3; target: Vector3 } | undefined;
  private isDue = false;
  private isChanged = false;
  private before: (() => void) | undefined;

  constructor(
    private readonly contents: Contents,
    readonly canvas: HTMLCanvasElement,
  ) {
    this.surface = new BodySurface(contents);
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.radius = this.frame(this.surface.vertices);
    this.camera = new PerspectiveCamera(35, 1, this.radius / 50, this.radius * 50);
    this.camera.up.set(0, 0, 1);
    const key = new DirectionalLight(0xfff4e8, 2.6);
    key.position.set(-0.6, this.facing.z < 0 ? -0.8 : 0.8, 1); // from where the window faces
    const rim = new DirectionalLight(0xcfe0ff, 1.1);
    rim.position.set(1.2, 0.5, -0.6);
    this.camera.add(key, key.target, rim, rim.target); // else they shine from the origin
    const sky = new HemisphereLight(0xffffff, 0x8a6a60, 1.5);
    sky.position.copy(this.facing);
    this.scene.add(sky, this.camera, this.surface.mesh);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.mouseButtons = { LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.PAN, RIGHT: MOUSE.ROTATE };
    this.controls.addEventListener("change", () => this.draw());
    const size = kMarkerShare * this.radius;
    this.selection = new Mesh(new SphereGeometry(1.9 * size, 24, 16), new MeshBasicMaterial({ color: 0xd55e00 }));
    this.selection.visible = false;
    this.setUp = setUpGroup(contents);
    this.tools = [0, 1].map(() => new ToolGlyph(this.radius, 2 * size));
    this.marks.add(this.selection);
    this.scene.add(this.setUp, this.marks, this.sketched, ...this.tools.map(({ group }) => group));
    this.home();
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  /** Points the first look at the window, or at the whole body. Returns the body's radius. */
  private frame(vertices: Float32Array): number {
    const sphere = this.surface.mesh.geometry.boundingSphere;
    const whole = sphere?.radius ?? 1;
    this.focus.copy(sphere?.center ?? new Vector3());
    this.facing.set(-0.3, -1, 0.9);
    this.distance = 2.5 * whole;
    const shown = this.surface.covered.length ? this.surface.covered : this.besideTestPoints(vertices);
    const box = new Box3();
    const mean = new Vector3();
    for (const v of shown) {
      box.expandByPoint(new Vector3(...vector(vertices, v)));
      mean.add(new Vector3(...vector(this.surface.normals, v)));
    }
    const window_m = shown.length ? box.getSize(new Vector3()).length() / 2 : whole;
    if (mean.length() < 0.3 * shown.length || window_m > 0.6 * whole) return whole;
    // A little from the front, so that what is up stays up.
    this.facing.copy(mean.normalize()).add(new Vector3(-0.25, -0.75, 0));
    this.focus.lerp(box.getCenter(new Vector3()), 0.8);
    if (this.surface.covered.length) this.distance = Math.max(2 * whole, 3.2 * window_m);
    return whole;
  }

  /** The vertices nearest to the test points of a set-up without curves. */
  private besideTestPoints(vertices: Float32Array): Int32Array {
    const points = floats(this.contents.set_up?.points_m);
    return Int32Array.from({ length: points.length / 3 }, (_, p) => nearest(vertices, vector(points, p)));
  }

  showSetUp(isShown: boolean): void {
    this.setUp.visible = isShown;
    this.surface.mesh.material.transparent = isShown;
    this.surface.mesh.material.opacity = isShown ? 0.45 : 1;
    this.surface.mesh.material.depthWrite = !isShown;
    this.surface.mesh.material.needsUpdate = true;
    this.draw();
  }

  /** Back to the first look. */
  home(): void {
    this.cut = undefined;
    this.surface.mesh.material.setCut(undefined);
    this.controls.target.copy(this.focus);
    this.camera.position.copy(this.focus).addScaledVector(this.facing.clone().normalize(), this.distance);
    this.controls.update();
    this.draw();
  }

  get isCut(): boolean {
    return this.cut !== undefined;
  }

  /** From the side, the body cut through a place; none: whole and as it was looked at before. */
  lookFromSide(place: Place | undefined): void {
    if (place) {
      const { outward, position } = place;
      const towards = this.camera.position.clone().sub(this.controls.target);
      const normal = towards.clone().addScaledVector(outward, -towards.dot(outward));
      if (normal.length() < 0.05 * towards.length()) normal.set(0, -1, 0).addScaledVector(outward, outward.y);
      normal.normalize();
      this.cut ??= {
        normal,
        through: position,
        eye: this.camera.position.clone(),
        target: this.controls.target.clone(),
      };
      this.cut.normal.copy(normal);
      const from = normal.clone().multiplyScalar(Math.cos(kSideLift)).addScaledVector(outward, Math.sin(kSideLift));
      this.controls.target.copy(position);
      this.camera.position.copy(position).addScaledVector(from, 0.42 * this.distance);
      this.cutThrough(position);
    } else if (this.cut) {
      this.camera.position.copy(this.cut.eye);
      this.controls.target.copy(this.cut.target);
      this.cut = undefined;
      this.surface.mesh.material.setCut(undefined);
    }
    this.controls.update();
    this.draw();
  }

  /** Moves the cut of a cut body through another place. */
  cutThrough(place: Vector3): void {
    if (!this.cut) return;
    this.cut.through = place.clone();
    this.surface.mesh.material.setCut(this.cut);
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

  /** Lets a drag of the pointer turn the look, or not. */
  setOrbit(isOn: boolean): void {
    this.controls.enabled = isOn;
  }

  /** Colours the surface; returns the values at the two ends of the colour bar. */
  colour(name: MapName | undefined, depth_m: number): [number, number] | undefined {
    const ends = this.surface.colour(name, depth_m);
    this.draw();
    return ends;
  }

  /** Moves the surface's vertices by three numbers each [m], none: to rest. Returns the one that moves most. */
  deform(displacement: Float32Array | undefined): { by_m: number; at: Vector3 } {
    const most = this.surface.deform(displacement);
    this.draw();
    return most;
  }

  /** Balls at places [m], coloured each; small ones through the surface where the places are of a tool in the body. */
  mark(places: Float32Array, colours: [number, number, number][], isInside: boolean): void {
    if (this.markers) this.marks.remove(this.markers);
    this.markers?.dispose();
    const size = (isInside ? 0.5 : 1) * kMarkerShare * this.radius;
    const count = places.length / 3;
    const material = new MeshBasicMaterial({ depthTest: !isInside, transparent: isInside });
    this.markers = new InstancedMesh(new SphereGeometry(size, 16, 12), material, count);
    const at = new Object3D();
    for (let i = 0; i < count; ++i) {
      at.position.set(...vector(places, i));
      at.updateMatrix();
      this.markers.setMatrixAt(i, at.matrix);
      this.markers.setColorAt(i, linear(colours[i]));
    }
    this.marks.add(this.markers);
    this.draw();
  }

  /** Draws these regions and no others. */
  sketch(regions: { region: Region; colour: string }[]): void {
    this.sketched.clear();
    for (const { region, colour } of regions) drawRegion(region, this.sketched, colour, 0.6);
    this.draw();
  }

  select(place: [number, number, number] | undefined): void {
    this.selection.visible = place !== undefined;
    if (place) this.selection.position.set(...place);
    this.draw();
  }

  /** The place of the body under the pointer; none beside the body. */
  under(clientX: number, clientY: number): Place | undefined {
    const box = this.canvas.getBoundingClientRect();
    const caster = new Raycaster();
    caster.setFromCamera(
      new Vector2((2 * (clientX - box.left)) / box.width - 1, 1 - (2 * (clientY - box.top)) / box.height),
      this.camera,
    );
    const { ray } = caster;
    if (this.cut) {
      const speed = ray.direction.dot(this.cut.normal);
      const ahead = this.cut.through.clone().sub(ray.origin).dot(this.cut.normal) / speed;
      if (speed < 0 && ahead > 0) ray.origin.addScaledVector(ray.direction, ahead);
    }
    const place = this.surface.hit(ray);
    return place && place.outward.dot(ray.direction) < 0 ? place : undefined;
  }

  /** First intersection of the surface with a ray against an outward normal through a point [m] near it. */
  beside(point: Vector3, outward: Vector3): Place | undefined {
    return this.surface.hit(
      new Ray(point.clone().addScaledVector(outward, 0.2 * this.radius), outward.clone().negate()),
    );
  }

  /** The screen's right and up as directions in space. */
  screenAxes(): [Vector3, Vector3] {
    const right = new Vector3();
    const up = new Vector3();
    this.camera.matrixWorld.extractBasis(right, up, new Vector3());
    return [right, up];
  }

  /** Draws one of the tools and the force on it as an arrow; none hides it. Marks make way for it. */
  showTool(finger: number, tool: DrawnTool | undefined, fullForce_N: number): void {
    this.tools[finger].show(tool, fullForce_N);
    this.marks.visible = this.tools.every(({ group }) => !group.visible);
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

  /** Does something in the next frame, which is drawn if that asks for it; of several asked for, the latest. */
  inFrame(act: () => void): void {
    this.before = act;
    this.schedule();
  }

  /** Once in the next frame. */
  draw(): void {
    this.isChanged = true;
    this.schedule();
  }

  private schedule(): void {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.before?.();
      this.before = undefined;
      this.isDue = false;
      if (!this.isChanged) return;
      this.isChanged = false;
      this.renderer.render(this.scene, this.camera);
    });
  }
}
