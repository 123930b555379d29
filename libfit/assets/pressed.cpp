#include "libfit/assets/pressed.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {
namespace {

constexpr std::size_t kOfEachEnd = 2;
constexpr double kStep_m = 50e-6;  // of a tick on the way in

// The vertex that each test point answers for most, softest first.
std::vector<Eigen::Index> test_vertices(const Model& model, const StiffnessMap& map) {
  std::vector<Eigen::Index> vertex(static_cast<std::size_t>(model.shape.point.rows()), -1);
  std::vector<double> most(vertex.size(), 0.9);
  for (Eigen::Index v = 0; v < model.blend_point.rows(); ++v)
    for (int k = 0; k < 3; ++k) {
      const auto point = static_cast<std::size_t>(model.blend_point(v, k));
      if (!model.is_covered[static_cast<std::size_t>(v)] ||
          !(model.blend_weight(v, k) > most[point]))
        continue;
      most[point] = model.blend_weight(v, k);
      vertex[point] = v;
    }
  std::erase(vertex, -1);
  std::stable_sort(vertex.begin(), vertex.end(), [&](Eigen::Index a, Eigen::Index b) {
    return map.stiffness_N_m[static_cast<std::size_t>(a)] <
           map.stiffness_N_m[static_cast<std::size_t>(b)];
  });
  return vertex;
}

}  // namespace

std::vector<PressedShape> pressed_shapes(const Model& model, const StiffnessMap& map) {
  if (model.shape.point.rows() == 0) return {};
  const AssetBytes bytes = make_asset_bytes(model, {});
  runtime::Status status;
  const runtime::Asset asset = runtime::Asset::open(bytes.data(), bytes.size(), &status);
  std::vector<Eigen::Index> vertices = test_vertices(model, map);
  const std::size_t each = std::min(kOfEachEnd, vertices.size() / 2);
  std::vector<PressedShape> out;
  const auto press = [&](Eigen::Index v, const char* end, std::size_t rank) {
    const double depth_m = model.shape.depth_m;
    const Vec3 inward = model.inward_normal.row(v), place = model.surface.vertices.row(v);
    const int ticks = static_cast<int>(std::ceil(1.1 * depth_m / kStep_m));
    runtime::Contact contact;
    runtime::Output tick;
    for (int i = 0; i <= ticks; ++i) {
      const Vec3 tip = place + inward * depth_m * (1.1 * i / ticks - 0.1);
      runtime::touch(asset, contact, tip.data(), tick, nullptr, runtime::kMaxTimeStep_s);
    }
    if (contact.triangle < 0) return;
    Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> moved(asset.vertices, 3);
    runtime::deform(asset, contact, 0, 0, asset.vertices, moved.data());
    char name[96];
    std::snprintf(name, sizeof name, "press at vertex %lld, %.1f mm, %s %zu",
                  static_cast<long long>(v), depth_m * 1e3, end, rank);
    out.push_back({name, v, moved.cast<double>()});
  };
  for (std::size_t i = 0; i < each; ++i)
    press(vertices[vertices.size() - 1 - i], "stiffest", i + 1);
  for (std::size_t i = 0; i < each; ++i) press(vertices[i], "softest", i + 1);
  return out;
}

}  // namespace palpate
