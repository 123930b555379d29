#pragma once

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate::tools {

/// The paper's body: a cylinder of 30 mm radius and 100 mm length about z, open at its ends.
inline constexpr double kCylinderRadius_m = 0.03, kCylinderLength_m = 0.1;

/// f^z = k(x) d^2 / 10 mm [N]: k varies by 30 % around and 20 % along [N/m].
double cylinder_stiffness_N_m(const Vec3& x);

/// The cylinder with `around` x `along` x 2 triangles; cubic curves of `pieces` pieces over 8 mm,
/// f^r linear, friction falling from 0.4 to 0.2 with depth. 25 x 10 is the paper's, 500 triangles.
/// scatter: each node's curves times a random number (seeded, the same each time) of mean 1 and
/// this deviation, on top of that: a body whose curves differ from node to node.
Model bench_cylinder(int around, int along, int pieces = 12, double scatter = 0);

/// The same body with rings of lambda 0.71 and a friction of 0.28 + 16 d/m on the same normal
/// curves, with a small side force; as it is for `separable`.
Model with_family(Model model, CurveFamily family);

/// An opened asset with its bytes.
struct BenchAsset {
  AssetBytes bytes;
  runtime::Asset asset;
};
/// Throws Error when the engine refuses the bytes. Borders are not faded: nothing is lost at the
/// ends.
BenchAsset make_bench_asset(const Model& model);

}  // namespace palpate::tools
