// The set-up, and the tool with its force, in the view of the body.

import {
  Box3,
  Box3Helper,
  BufferAttribute,
  BufferGeometry,
  Color,
  ConeGeometry,
  CylinderGeometry,
  DoubleSide,
  Group,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  MeshPhongMaterial,
  Points,
  PointsMaterial,
  SphereGeometry,
  Vector3,
} from "three";
import { kSetUpColours } from "./colours";
import { type Contents, floats, integers, type Region, vector } from "./contents";

const geometry = (places_m: Float32Array<ArrayBuffer>, triangles?: Uint32Array<ArrayBuffer>) => {
  const made = new BufferGeometry().setAttribute("position", new BufferAttribute(places_m, 3));
  return triangles ? made.setIndex(new BufferAttribute(triangles, 1)) : made;
};
const unsigned = (packed?: string) => new Uint32Array(integers(packed).buffer);
const wire = (color: string, opacity: number, depthTest: boolean) =>
  new MeshBasicMaterial({ color, wireframe: true, transparent: true, opacity, depthTest });

/** A ball, a box or a surface; nothing of other regions. */
export function drawRegion(region: Region, group: Group, colour: string, opacity: number): void {
  const { center_m, radius_m, low_m, high_m, vertices_m, triangles } = region;
  if (low_m && high_m) {
    const box = new Box3(new Vector3().fromArray(low_m), new Vector3().fromArray(high_m));
    group.add(new Box3Helper(box, new Color(colour)));
  } else if (vertices_m) {
    group.add(new Mesh(geometry(floats(vertices_m), unsigned(triangles)), wire(colour, opacity, true)));
  } else if (center_m) {
    const ball = new Mesh(new SphereGeometry(radius_m, 20, 12), wire(colour, opacity, true));
    ball.position.fromArray(center_m);
    group.add(ball);
  }
}

/** The held part, the base mesh, the window and the inclusions. Not visible yet. */
export function setUpGroup(contents: Contents): Group {
  const group = new Group();
  group.visible = false;
  const set_up = contents.set_up;
  if (!set_up) return group;
  const [nodes, boundary] = [floats(set_up.nodes_m), unsigned(set_up.boundary)];
  const held = new Set(integers(set_up.held));
  const heldFaces = boundary.filter((_, i) => [0, 1, 2].every((k) => held.has(boundary[i - (i % 3) + k])));
  const heldNodes = Float32Array.from([...held].flatMap((node) => vector(nodes, node)));
  // In front of the finer surface beside it, and seen through the body's far side, dimmer.
  const paint = { color: kSetUpColours.held, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: -8 };
  group.add(
    new Mesh(geometry(nodes, heldFaces), new MeshBasicMaterial(paint)),
    new Points(geometry(heldNodes), new PointsMaterial({ color: kSetUpColours.held, size: 6, sizeAttenuation: false })),
    new Mesh(geometry(nodes, boundary), wire("#808080", 0.35, false)),
  );
  if (set_up.lumen)
    drawRegion({ vertices_m: set_up.nodes_m, triangles: set_up.lumen }, group, kSetUpColours.lumen, 0.6);
  if (set_up.window) drawRegion(set_up.window, group, kSetUpColours.window, 0.22);
  for (const inclusion of set_up.inclusions) drawRegion(inclusion, group, kSetUpColours.inclusion, 0.5);
  return group;
}

/** A drawn tool: its balls, and the force on it, which acts at a place. */
export interface DrawnTool {
  balls: { at: Vector3; radius_m: number }[];
  acts_at: Vector3;
  force: Vector3;
}

/** Balls, or a small one for a tip, and an arrow for the force on them. */
export class ToolGlyph {
  readonly group = new Group();
  private readonly balls = new Group();
  private readonly arrow = new Group();
  private readonly ball = new SphereGeometry(1, 40, 28);
  private readonly glass = new MeshPhongMaterial({
    color: 0xe8eef4,
    shininess: 90,
    transparent: true,
    opacity: 0.5,
    depthWrite: false,
  });

  /** tip_m: size of the ball that stands for a tip. */
  constructor(
    private readonly radius: number,
    private readonly tip_m: number,
  ) {
    // Along +y, of length 1 until it is stretched, and visible through the body.
    const material = new MeshLambertMaterial({ color: 0xf0701a, depthTest: false, transparent: true });
    const thick = 0.009 * radius;
    const shaft = new Mesh(new CylinderGeometry(thick, thick, 1, 20).translate(0, 0.5, 0), material);
    const head = new Mesh(new ConeGeometry(3 * thick, 6 * thick, 24).translate(0, 3 * thick, 0), material);
    for (const part of [shaft, head]) part.renderOrder = 2;
    this.arrow.add(shaft, head);
    this.group.add(this.balls, this.arrow);
    this.group.visible = false;
  }

  show(tool: DrawnTool | undefined, fullForce_N: number): void {
    this.group.visible = tool !== undefined;
    if (!tool) return;
    while (this.balls.children.length < tool.balls.length) this.balls.add(new Mesh(this.ball, this.glass));
    this.balls.children.forEach((ball, i) => {
      ball.visible = i < tool.balls.length;
      if (!ball.visible) return;
      ball.position.copy(tool.balls[i].at);
      ball.scale.setScalar(tool.balls[i].radius_m || this.tip_m);
    });
    const strength = tool.force.length();
    this.arrow.visible = strength > 0;
    if (strength === 0) return;
    const length = Math.min((strength / fullForce_N) * 0.7, 1) * this.radius;
    const [shaft, head] = this.arrow.children;
    shaft.scale.set(1, Math.max(length, 1e-9), 1);
    head.position.set(0, length, 0);
    this.arrow.position.copy(tool.acts_at);
    this.arrow.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), tool.force.clone().normalize());
  }
}
