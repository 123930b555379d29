#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "data/generators/bodies.hpp"

namespace palpate::bodies {

Surface clot_mm() {
  constexpr int kRings = 10, kSides = 6;  // 6 k vertices on ring k
  constexpr double kRadius_mm = 30, kTop_mm = 16, kRim_mm = 6, kBreadth = 0.85;
  constexpr int kLayers = 2;  // of the rim
  std::vector<Vec3> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;
  // A disc of rings, its rim last; first: number of its middle. faces_up: outward is +z.
  const auto add_disc = [&](bool faces_up, const auto& height_mm) {
    const auto first = static_cast<std::int32_t>(vertices.size());
    vertices.emplace_back(0, 0, height_mm(0));
    for (int k = 1; k <= kRings; ++k)
      for (int i = 0; i < kSides * k; ++i) {
        const double angle = 2 * std::numbers::pi * i / (kSides * k), share = double(k) / kRings,
                     r = kRadius_mm * share;
        vertices.emplace_back(r * std::cos(angle), kBreadth * r * std::sin(angle),
                              height_mm(share));
      }
    const auto at = [&](int k, int i) {
      return k == 0 ? first : first + 1 + kSides * k * (k - 1) / 2 + i % (kSides * k);
    };
    const auto add = [&](std::int32_t a, std::int32_t b, std::int32_t c) {
      if (faces_up)
        triangles.push_back({a, b, c});
      else
        triangles.push_back({a, c, b});
    };
    for (int k = 1; k <= kRings; ++k)
      for (int side = 0; side < kSides; ++side)
        for (int j = 0; j < k; ++j) {
          add(at(k - 1, side * (k - 1) + j), at(k, side * k + j), at(k, side * k + j + 1));
          if (j > 0)
            add(at(k - 1, side * (k - 1) + j - 1), at(k, side * k + j),
                at(k - 1, side * (k - 1) + j));
        }
    return first;
  };
  const auto top = [](double share) {
    return kRim_mm + (kTop_mm - kRim_mm) * (1 - share * share * share * share);
  };
  const std::int32_t inside = 1 + kSides * kRings * (kRings - 1) / 2;  // vertices before the rim
  constexpr int kAround = kSides * kRings;
  const std::int32_t upper = add_disc(true, top) + inside;
  const std::int32_t lower = add_disc(false, [](double) { return 0.0; }) + inside;
  std::vector<std::int32_t> layer{upper};
  for (int k = 1; k < kLayers; ++k) {
    layer.push_back(static_cast<std::int32_t>(vertices.size()));
    for (int i = 0; i < kAround; ++i) {
      const Vec3 above = vertices[static_cast<std::size_t>(upper + i)];
      vertices.emplace_back(above.x(), above.y(), kRim_mm * (kLayers - k) / kLayers);
    }
  }
  layer.push_back(lower);
  for (int k = 0; k < kLayers; ++k)
    for (int i = 0; i < kAround; ++i) {
      const auto at = [&](int which, int j) {
        return layer[static_cast<std::size_t>(which)] + j % kAround;
      };
      triangles.push_back({at(k, i), at(k + 1, i), at(k + 1, i + 1)});
      triangles.push_back({at(k, i), at(k + 1, i + 1), at(k, i + 1)});
    }

  return surface_of(vertices, triangles);
}

}  // namespace palpate::bodies
