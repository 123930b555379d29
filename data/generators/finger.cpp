#include <array>
#include <cmath>
#include <vector>

#include "data/generators/bodies.hpp"

namespace palpate::bodies {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::array<double, 3> kPlace_mm{-10, 1, 10}, kRadius_mm{6, 5, 4};
constexpr int kRows = 18, kAround = 14, kFine = 4000;

// A place of the profile where the hull of the balls has a normal at that angle from own -x: on the
// ball that reaches farthest that way (their support function).
Eigen::Vector2d profile_mm(double angle) {
  std::size_t farthest = 0;
  double most = -1e9;
  for (std::size_t i = 0; i < kPlace_mm.size(); ++i) {
    const double reach = -kPlace_mm[i] * std::cos(angle) + kRadius_mm[i];
    if (reach > most) most = reach, farthest = i;
  }
  return {kPlace_mm[farthest] - kRadius_mm[farthest] * std::cos(angle),
          kRadius_mm[farthest] * std::sin(angle)};
}

// Rows evenly along the profile; between balls it is straight.
std::vector<Eigen::Vector2d> rows_mm() {
  std::vector<Eigen::Vector2d> fine;
  std::vector<double> way_mm{0};
  for (int i = 0; i <= kFine; ++i) {
    fine.push_back(profile_mm(kPi * i / kFine));
    if (i > 0)
      way_mm.push_back(way_mm.back() + (fine[fine.size() - 1] - fine[fine.size() - 2]).norm());
  }
  std::vector<Eigen::Vector2d> out;
  std::size_t at = 1;
  for (int row = 0; row <= kRows; ++row) {
    const double wanted_mm = way_mm.back() * row / kRows;
    while (at + 1 < way_mm.size() && way_mm[at] < wanted_mm) ++at;
    const double step_mm = way_mm[at] - way_mm[at - 1],
                 share = step_mm > 0 ? (wanted_mm - way_mm[at - 1]) / step_mm : 0;
    out.push_back(fine[at - 1] + share * (fine[at] - fine[at - 1]));
  }
  return out;
}

}  // namespace

Surface finger_mm() {
  const std::vector<Eigen::Vector2d> rows = rows_mm();
  std::vector<Vec3> vertices{{rows.front().x(), 0, 0}};
  for (int row = 1; row < kRows; ++row)
    for (int i = 0; i < kAround; ++i) {
      const double turn = 2 * kPi * (i + 0.5 * (row % 2)) / kAround;
      const Eigen::Vector2d& at = rows[static_cast<std::size_t>(row)];
      vertices.push_back({at.x(), at.y() * std::cos(turn), at.y() * std::sin(turn)});
    }
  vertices.push_back({rows.back().x(), 0, 0});
  std::vector<std::array<std::int32_t, 3>> triangles;
  const auto at = [](int row, int i) { return 1 + (row - 1) * kAround + i % kAround; };
  for (int i = 0; i < kAround; ++i) {
    triangles.push_back({0, at(1, i + 1), at(1, i)});
    triangles.push_back(
        {static_cast<std::int32_t>(vertices.size()) - 1, at(kRows - 1, i), at(kRows - 1, i + 1)});
  }
  for (int row = 1; row + 1 < kRows; ++row)
    for (int i = 0; i < kAround; ++i) {
      const int shifted = row % 2;
      triangles.push_back({at(row, i), at(row, i + 1), at(row + 1, i + shifted)});
      triangles.push_back({at(row, i + 1 - shifted), at(row + 1, i + 1), at(row + 1, i)});
    }
  Surface out;
  out.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v)
    out.vertices.row(static_cast<Eigen::Index>(v)) = vertices[v];
  out.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    out.triangles.row(static_cast<Eigen::Index>(t)) << triangles[t][0], triangles[t][1],
        triangles[t][2];
  return out;
}

}  // namespace palpate::bodies
