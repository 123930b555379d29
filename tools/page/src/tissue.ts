// The look of the body: a wet surface, darker where it is pressed in, and flat in one colour where it is cut.

import { Color, DoubleSide, MeshStandardMaterial, type Vector3, Vector4 } from "three";

const kWet = 0.36; // roughness of tissue
const kDull = 0.85; // of a map, whose colours highlights would change

const kVertexHead = "attribute vec3 rest; varying vec3 vRest; varying vec3 vHere;\n";
const kVertex = "#include <begin_vertex>\n vRest = rest; vHere = position;";

const kFragmentHead = `
varying vec3 vRest, vHere;
uniform float depth;
uniform vec4 cut;
uniform vec3 inside;
`;

const kFragment: [string, string][] = [
  [
    "#include <clipping_planes_fragment>",
    "#include <clipping_planes_fragment>\n if (dot(vHere, cut.xyz) > cut.w) discard;",
  ],
  [
    "#include <color_fragment>",
    "#include <color_fragment>\n diffuseColor.rgb *= 1.0 - 0.45 * smoothstep(0.0, depth, distance(vHere, vRest));",
  ],
  [
    "#include <opaque_fragment>",
    `if (dot(cut.xyz, cut.xyz) > 0.0 && !gl_FrontFacing) outgoingLight = inside;
    #include <opaque_fragment>`,
  ],
];

export class TissueMaterial extends MeshStandardMaterial {
  private readonly own = {
    depth: { value: 1 },
    cut: { value: new Vector4() },
    inside: { value: new Color(0x6d1f1a) },
  };

  /** depth_m: how far in it is darkest. */
  constructor(depth_m: number) {
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

  /** Wet, or dull beneath a map's colours. */
  setWet(isWet: boolean): void {
    this.roughness = isWet ? kWet : kDull;
  }

  /** Takes away what lies beyond a plane; none: nothing. */
  setCut(plane: { normal: Vector3; through: Vector3 } | undefined): void {
    const { normal, through } = plane ?? {};
    if (normal && through) this.own.cut.value.set(normal.x, normal.y, normal.z, normal.dot(through));
    else this.own.cut.value.set(0, 0, 0, 0);
  }
}
