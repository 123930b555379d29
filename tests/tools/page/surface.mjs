// The page's own share of a frame, on 100,352 triangles: node surface.mjs MODULES
// Normals and rays give what three.js gives, in a share of its time. Ends with status 0 where so.
import assert from "node:assert/strict";
import { load } from "./load.mjs";

const { fillNormals, Picker, three } = await load(
  process.argv[2],
  `export * from "./picking"; export * as three from "three";`,
);

// A wavy sheet.
const cells = 224;
const vertices = new Float32Array(3 * (cells + 1) ** 2);
const index = new Uint32Array(6 * cells ** 2);
for (let i = 0; i <= cells; ++i)
  for (let j = 0; j <= cells; ++j) {
    const [x, y] = [i / cells, j / cells];
    vertices.set([x, y, 0.05 * Math.sin(9 * x) * Math.cos(7 * y)], 3 * (i * (cells + 1) + j));
  }
for (let i = 0, at = 0; i < cells; ++i)
  for (let j = 0; j < cells; ++j, at += 6) {
    const a = i * (cells + 1) + j;
    index.set([a, a + cells + 1, a + 1, a + 1, a + cells + 1, a + cells + 2], at);
  }
const geometry = new three.BufferGeometry();
geometry.setAttribute("position", new three.BufferAttribute(vertices, 3));
geometry.setIndex(new three.BufferAttribute(index, 1));
const mesh = new three.Mesh(geometry, new three.MeshBasicMaterial({ side: three.DoubleSide }));
mesh.updateMatrixWorld();

/** Milliseconds of a call: the least of some, so that a busy machine counts for little. */
function time(act) {
  let least = Number.POSITIVE_INFINITY;
  for (let i = 0; i < 9; ++i) {
    const from = performance.now();
    act();
    least = Math.min(least, performance.now() - from);
  }
  return least;
}

const normals = new Float32Array(vertices.length);
const own = time(() => fillNormals(vertices, index, normals));
const theirs = time(() => geometry.computeVertexNormals());
const wanted = geometry.getAttribute("normal").array;
for (let i = 0; i < normals.length; ++i) assert.ok(Math.abs(normals[i] - wanted[i]) < 1e-5, `normal ${i}`);

const picker = new Picker(vertices, index);
const rays = Array.from({ length: 40 }, (_, k) => {
  const from = new three.Vector3(0.5 + 0.4 * Math.cos(k), 0.5 + 0.4 * Math.sin(3 * k), 1);
  return new three.Ray(from, new three.Vector3(0.2 * Math.sin(k), 0.1, -1).normalize());
});
const cast = (ray) => {
  const caster = new three.Raycaster(ray.origin, ray.direction);
  return caster.intersectObject(mesh)[0];
};
for (const ray of rays) {
  const [hit, truth] = [picker.hit(ray), cast(ray)];
  assert.equal(hit === undefined, truth === undefined);
  if (!hit) continue;
  assert.ok(hit.position.distanceTo(truth.point) < 1e-6);
  const corners = [0, 1, 2].map((k) => new three.Vector3().fromArray(vertices, 3 * index[3 * hit.triangle + k]));
  const back = new three.Vector3();
  corners.forEach((corner, k) => back.addScaledVector(corner, hit.weights.getComponent(k)));
  assert.ok(back.distanceTo(hit.position) < 1e-6);
}
assert.ok(rays.some((ray) => cast(ray)));
const picked = time(() => picker.hit(rays[0]));
const brute = time(() => cast(rays[0]));
console.log(`normals ${own.toFixed(2)} ms, three.js ${theirs.toFixed(2)}; a ray ${picked.toFixed(3)} ms, three.js ${brute.toFixed(2)}`);
assert.ok(own < 0.6 * theirs, "normals take more than 0.6 of three.js's time");
assert.ok(picked < 0.2 * brute, "a ray takes more than a fifth of three.js's time");
