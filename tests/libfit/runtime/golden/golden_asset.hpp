#pragma once

// The asset that stands for its version: small, refined unevenly.

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {

/// Keeps the first `ticks` check ticks, so that a golden file is small.
inline AssetBytes with_fewer_check_ticks(const AssetBytes& whole, int ticks) {
  runtime::Header from, to;
  std::memcpy(&from, whole.data(), sizeof from);
  to = from;
  to.check_ticks = ticks;
  to.file_bytes = runtime::lay_out(to, to.offset);
  AssetBytes out(to.file_bytes);
  for (int section = 0; section < runtime::kSections; ++section)
    std::memcpy(out.data() + to.offset[section], whole.data() + from.offset[section],
                runtime::section_bytes(to, section));
  std::memcpy(out.data(), &to, sizeof to);
  to.checksum = runtime::asset_checksum(out.data(), out.size());
  std::memcpy(out.data(), &to, sizeof to);
  return out;
}

inline bool is_bare(const Vec3& x) { return x[2] <= -0.02 && x[0] <= 0; }
/// A sphere of 30 mm, stiffer towards +x; a quarter not covered.
inline Model golden_model() {
  Model model = sphere_model(0.03, 4, uniform(400, 300, 0.3));
  const Eigen::Index vertices = model.surface.vertices.rows();
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    const CurveBasis basis{3, {0, 0.002, 0.006, 0.01}};
    model.curves.basis[kind] = basis;
    model.curves.control[kind] = Controls::Zero(vertices, basis.size());
    for (Eigen::Index v = 0; v < vertices; ++v)
      for (int j = 1; j < basis.size(); ++j)
        model.curves.control[kind](v, j) = (kind == 1   ? 3
                                            : kind == 0 ? 4
                                                        : 1.5) *
                                           (1 + 10 * model.surface.vertices(v, 0)) * j * j / 25.0;
  }
  uncover(model, is_bare);
  model.probe = sphere_spec(0.005);
  return model;
}

/// The same body with rings, a side force included.
inline AssetBytes golden_rings() {
  Model model = golden_model();
  make_rings(
      model, 1, 0.03, [](const Vec3& x) { return 1 + 10 * x[0]; },
      [](const Vec3& x) { return Vec3(900 * x[1] / 0.03, -500 * x[0] / 0.03, 0); });
  uncover(model, is_bare);
  for (Controls& control : model.curves.control)  // as a fit rounds them
    control = control.cast<float>().cast<double>();
  return with_fewer_check_ticks(make_asset_bytes(model, {.meta_json = "{\"golden\": \"rings\"}"}),
                                64);
}

inline AssetBytes golden_asset(int version) {
  const std::string meta = "{\"golden\": \"version " + std::to_string(version) + "\"}";
  return with_fewer_check_ticks(make_asset_bytes(golden_model(), {.meta_json = meta}), 64);
}

}  // namespace palpate::test
