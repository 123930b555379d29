// The look of the body: a wet surface with a fine grain, darker where it is pressed in, and flat in one
// colour where it is cut.

import {
  Color,
  Data3DTexture,
  DataUtils,
  DoubleSide,
  HalfFloatType,
  LinearFilter,
  MeshStandardMaterial,
  RedFormat,
  RepeatWrapping,
  type Vector3,
  Vector4,
} from "three";

const kCells = 32; // of the grain, until it repeats
const kWet = 0.36; // roughness of tissue
const kDull = 0.85; // of a map, whose colours highlights would change

const kVertexHead = "attribute vec3 rest; varying vec3 vRest; varying vec3 vHere;\n";
const kVertex = "#include <begin_vertex>\n vRest = rest; vHere = position;";

const kFragmentHead = `
varying vec3 vRest, vHere;
uniform float grain, depth;
uniform vec4 cut;
uniform vec3 inside;
uniform highp sampler3D grains;
float noise(vec3 p) {
  vec3 i = floor(p), f = fract(p);
  return texture(grains, (i + 0.5 + f * f * (3.0 - 2.0 * f)) / ${kCells}.0).r;
}
// Blinn, Simulation of wrinkled surfaces (1978), by differences over the screen.
vec3 bumped(vec3 n, float height) {
  vec3 x = dFdx(-vViewPosition), y = dFdy(-vViewPosition), a = cross(y, n), b = cross(n, x);
  float d = dot(x, a);
  return normalize(abs(d) * n - sign(d) * (dFdx(height) * a + dFdy(height) * b));
}
`;

const kFragment: [string, string][] = [
  [
    "#include <clipping_planes_fragment>",
    "#include <clipping_planes_fragment>\n if (dot(vHere, cut.xyz) > cut.w) discard;",
  ],
  [
    "#include <color_fragment>",
    `#include <color_fragment>
    float grained = grain > 0.0 ? 0.65 * noise(grain * vRest) + 0.35 * noise(2.7 * grain * vRest) : 0.5;
    diffuseColor.rgb *= (0.82 + 0.36 * grained) * (1.0 - 0.45 * smoothstep(0.0, depth, distance(vHere, vRest)));`,
  ],
  [
    "#include <normal_fragment_maps>",
    "#include <normal_fragment_maps>\n if (grain > 0.0) normal = bumped(normal, 0.1 * grained / grain);",
  ],
  [
    "#include <opaque_fragment>",
    `if (dot(cut.xyz, cut.xyz) > 0.0 && !gl_FrontFacing) outgoingLight = inside;
    #include <opaque_fragment>`,
  ],
];

/** Random numbers on a grid: the same on every page. */
function grainTexture(): Data3DTexture {
  let seed = 1;
  const random = () => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0; // Numerical Recipes
    return DataUtils.toHalfFloat(seed / 2 ** 32);
  };
  const texture = new Data3DTexture(Uint16Array.from({ length: kCells ** 3 }, random), kCells, kCells, kCells);
  Object.assign(texture, { format: RedFormat, type: HalfFloatType, minFilter: LinearFilter, magFilter: LinearFilter });
  Object.assign(texture, { wrapS: RepeatWrapping, wrapT: RepeatWrapping, wrapR: RepeatWrapping, needsUpdate: true });
  return texture;
}

export class TissueMaterial extends MeshStandardMaterial {
  private readonly own = {
    grain: { value: 0 },
    grains: { value: grainTexture() },
    depth: { value: 1 },
    cut: { value: new Vector4() },
    inside: { value: new Color(0x6d1f1a) },
  };

  /** size_m: radius of the body. depth_m: how far in it is darkest. */
  constructor(
    private readonly size_m: number,
    depth_m: number,
  ) {
    super({ vertexColors: true, side: DoubleSide });
    this.own.depth.value = depth_m;
    this.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, this.own);
      shader.vertexShader = kVertexHead + shader.vertexShader.replace("#include <begin_vertex>", kVertex);
      shader.fragmentShader = kFragment.reduce(
        (text, [at, with_]) => text.replace(at, with_),
        shader.fragmentShader.replace("#include <common>", `#include <common>\n${kFragmentHead}`),
      );
    };
  }

  /** Wet and grained, or dull beneath a map's colours. */
  setWet(isWet: boolean): void {
    this.own.grain.value = isWet ? 34 / this.size_m : 0;
    this.roughness = isWet ? kWet : kDull;
  }

  /** Takes away what lies beyond a plane; none: nothing. */
  setCut(plane: { normal: Vector3; through: Vector3 } | undefined): void {
    const { normal, through } = plane ?? {};
    if (normal && through) this.own.cut.value.set(normal.x, normal.y, normal.z, normal.dot(through));
    else this.own.cut.value.set(0, 0, 0, 0);
  }
}
