// Why refinement blends three points and not the natural neighbours (docs/method.md, section 7).

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/libfit/refine/blending.hpp"
#include "tests/libfit/refine/natural_neighbours.hpp"

namespace palpate::testing_refine {
namespace {

constexpr double kSide_m = 0.1;

// A grid whose inner points are moved at random, so that triangles are as they come.
std::vector<Eigen::Vector2d> shaken_grid(int cells, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.3, 0.3);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i <= cells; ++i)
    for (int j = 0; j <= cells; ++j) {
      const bool is_inner = i > 0 && j > 0 && i < cells && j < cells;
      points.emplace_back(kSide_m / cells * (i + (is_inner ? shift(random) : 0)),
                          kSide_m / cells * (j + (is_inner ? shift(random) : 0)));
    }
  return points;
}

struct Errors {
  double area_rms = 0, natural_rms = 0, area_p95 = 0, natural_p95 = 0;
};

// Relative errors of both at the inner vertices of a fine plate.
Errors compare(int cells, unsigned seed, const Field& field) {
  const auto points = shaken_grid(cells, seed);
  Surface coarse;
  coarse.vertices.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    coarse.vertices.row(static_cast<Eigen::Index>(i)) << points[i].x(), points[i].y(), 0;
  const Surface fine = plate(40, 40, kSide_m, kSide_m);
  FittedCurves curves = curves_at({coarse.vertices, Triangles(0, 3)}, field);
  curves.normal = Points::Zero(coarse.vertices.rows(), 3);
  curves.normal.col(2).setConstant(-1);
  const Model model = refine(curves, fine, all(fine), kNone);
  std::vector<double> area_errors, natural_errors;
  const double margin = kSide_m / cells;
  for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v) {
    const Eigen::Vector2d at = fine.vertices.row(v).head<2>();
    if ((at.array() < margin).any() || (at.array() > kSide_m - margin).any()) continue;
    const double value = field(fine.vertices.row(v));
    const std::vector<double> weights = natural_weights(points, at, 4 * margin);
    double natural = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
      natural += weights[i] * field(Vec3(points[i].x(), points[i].y(), 0));
    area_errors.push_back(std::abs(model.curves.control[0](v, 1) / value - 1));
    natural_errors.push_back(std::abs(natural / value - 1));
  }
  const auto rms = [](const std::vector<double>& errors) {
    double sum = 0;
    for (const double e : errors) sum += e * e;
    return std::sqrt(sum / static_cast<double>(errors.size()));
  };
  const auto p95 = [](std::vector<double> errors) {
    std::sort(errors.begin(), errors.end());
    return errors[errors.size() * 95 / 100];
  };
  return {rms(area_errors), rms(natural_errors), p95(area_errors), p95(natural_errors)};
}

TEST(NaturalNeighbours, are_a_partition_of_unity_and_exact_for_linear_fields) {
  const auto points = shaken_grid(8, 3);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> within(0.02, 0.08);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d at(within(random), within(random));
    const std::vector<double> weights = natural_weights(points, at, 0.05);
    Eigen::Vector2d blended = Eigen::Vector2d::Zero();
    double sum = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      EXPECT_GE(weights[k], 0);
      sum += weights[k];
      blended += weights[k] * points[k];
    }
    EXPECT_NEAR(sum, 1, 1e-12) << "seed 4";
    EXPECT_LT((blended - at).norm(), 1e-9 * kSide_m) << "seed 4";
  }
}

// Both err by second differences; six neighbours average them no better than three corners.
TEST(NaturalNeighbours, do_not_earn_their_weights) {
  const Field lump = [](const Vec3& p) {
    return 1 + 3 * std::exp(-(p - Vec3(0.055, 0.045, 0)).squaredNorm() / (2 * 0.012 * 0.012));
  };
  double area = 0, natural = 0, area_p95 = 0, natural_p95 = 0;
  for (unsigned seed = 1; seed <= 2; ++seed)
    for (const Field& field : {kSmooth, lump}) {
      const Errors e = compare(10, seed, field);
      area += e.area_rms;
      natural += e.natural_rms;
      area_p95 += e.area_p95;
      natural_p95 += e.natural_p95;
    }
  EXPECT_GT(natural, 0.8 * area);
  EXPECT_LT(natural, 1.25 * area);
  RecordProperty("rms_natural_over_area", std::to_string(natural / area));
  RecordProperty("p95_natural_over_area", std::to_string(natural_p95 / area_p95));
}

}  // namespace
}  // namespace palpate::testing_refine
