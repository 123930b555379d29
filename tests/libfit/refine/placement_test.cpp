// Where the next test points go: what interpolation is expected to get wrong, and the picks.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "libfit/refine/next_points.hpp"
#include "libfit/refine/points_on_surface.hpp"
#include "tests/libfit/refine/blending.hpp"

namespace palpate::testing_refine {
namespace {

std::vector<double> expected(const Surface& coarse, const Surface& fine, const Field& field) {
  const FittedCurves curves = curves_at(coarse, field);
  RefineReport refined;
  const Model model = refine(curves, fine, all(fine), coarse.triangles, {}, &refined);
  return expected_errors(curves, model, refined, 1e-9);
}

TEST(ExpectedError, of_a_linear_field_is_nothing) {
  const Surface fine = plate(24, 24, 0.1, 0.1), coarse = plate(6, 6, 0.1, 0.1);
  for (const double error :
       expected(coarse, fine, [](const Vec3& p) { return 2 + 10 * p.x() - 7 * p.y(); }))
    EXPECT_LT(error, 1e-6);  // control values are floats
}

TEST(ExpectedError, bounds_what_a_parabola_loses_and_is_near_it) {
  const Surface fine = plate(24, 24, 0.1, 0.1), coarse = plate(6, 6, 0.1, 0.1);
  const Field parabola = [](const Vec3& p) {
    return 1 + 30 * p.x() * p.x() + 20 * p.y() * p.y() + 10 * p.x() * p.y();
  };
  const std::vector<double> errors = expected(coarse, fine, parabola);
  const Model model = refine(curves_at(coarse, parabola), fine, all(fine), coarse.triangles);
  double actual_sum = 0, expected_sum = 0;
  for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v) {
    const Vec3 at = fine.vertices.row(v);
    const double value = parabola(at);
    const double actual = std::abs(model.curves.control[0](v, 1) - value) / value;
    EXPECT_GE(errors[static_cast<std::size_t>(v)], 0.9 * actual - 1e-6) << "vertex " << v;
    actual_sum += actual;
    expected_sum += errors[static_cast<std::size_t>(v)];
  }
  EXPECT_LT(expected_sum, 2 * actual_sum);
}

TEST(NextPoints, go_where_error_is_expected_and_spread_by_themselves) {
  const Surface fine = plate(40, 40, 0.1, 0.1), coarse = plate(4, 4, 0.1, 0.1);
  const Vec3 middle(0.06, 0.04, 0);
  const Field bump = [&](const Vec3& p) {
    return 1 + 3 * std::exp(-(p - middle).squaredNorm() / (2 * 0.015 * 0.015));
  };
  const FittedCurves curves = curves_at(coarse, bump);
  RefineReport refined;
  const Model model = refine(curves, fine, all(fine), coarse.triangles, {}, &refined);
  const auto seeds =
      place_on_surface(curves.position, curves.normal, fine, -model.inward_normal, -1, 1);
  const auto picked =
      next_points(fine, all(fine), seeds, expected_errors(curves, model, refined, 1e-9),
                  {.count = 8, .gap_share = 0.25, .gap_error = 0.01});
  ASSERT_EQ(picked.size(), 8u);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_LT((fine.vertices.row(picked[i]).transpose() - middle).norm(), 0.04) << "pick " << i;
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_GT((fine.vertices.row(picked[i]) - fine.vertices.row(picked[j])).norm(), 0.005);
}

TEST(ExpectedError, of_a_poor_point_draws_no_picks) {
  const Surface fine = plate(24, 24, 0.1, 0.1), coarse = plate(6, 6, 0.1, 0.1);
  constexpr std::size_t kPoor = 3 * 7 + 3;
  const auto most = [&](FitStatus status) {
    FittedCurves curves = curves_at(coarse, [](const Vec3& p) { return 2 + 10 * p.x(); });
    curves.curves.control[0](kPoor, 1) *= 16;
    curves.status[kPoor] = status;
    RefineReport refined;
    const Model model = refine(curves, fine, all(fine), coarse.triangles, {}, &refined);
    const auto errors = expected_errors(curves, model, refined, 1e-9);
    return *std::max_element(errors.begin(), errors.end());
  };
  EXPECT_GT(most(FitStatus::good), 0.5) << "else this test tells nothing";
  EXPECT_LT(most(FitStatus::poor), 1e-6);
}

TEST(NextPoints, run_out_when_every_vertex_is_a_point) {
  const Surface fine = plate(2, 2, 0.1, 0.1);
  std::vector<EdgePathSeeds> seeds;
  for (std::int32_t v = 0; v < 7; ++v) seeds.push_back({{v, 0.0}});
  const auto picked =
      next_points(fine, all(fine), seeds, std::vector<double>(9, 0.0), {.count = 5});
  EXPECT_EQ(std::set<std::int32_t>(picked.begin(), picked.end()), (std::set<std::int32_t>{7, 8}));
}

double p95_error(const Model& model, const Field& field) {
  std::vector<double> errors;
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v) {
    const double value = field(model.surface.vertices.row(v));
    errors.push_back(std::abs(model.curves.control[0](v, 1) - value) / value);
  }
  std::sort(errors.begin(), errors.end());
  return errors[static_cast<std::size_t>(0.95 * static_cast<double>(errors.size()))];
}

TEST(NextPoints, keep_a_least_distance_however_wrong_a_corner_is) {
  const Surface fine = plate(40, 40, 0.1, 0.1);
  std::vector<double> errors(static_cast<std::size_t>(fine.vertices.rows()), 0.01);
  for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v)
    if (fine.vertices.row(v).norm() < 0.02) errors[static_cast<std::size_t>(v)] = 100;
  const auto near_corner = [&](double least_m) {
    const auto picked = next_points(fine, all(fine), {{{0, 0.0}}}, errors,
                                    {.count = 60, .gap_share = 0, .least_m = least_m});
    double nearest_m = 1;
    for (std::size_t i = 0; i < picked.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        nearest_m = std::min(nearest_m,
                             (fine.vertices.row(picked[i]) - fine.vertices.row(picked[j])).norm());
    EXPECT_GT(nearest_m, 0.7 * least_m);  // paths along edges are longer
    return std::ranges::count_if(
        picked, [&](std::int32_t v) { return fine.vertices.row(v).norm() < 0.02; });
  };
  EXPECT_GT(near_corner(0), 50);
  EXPECT_LT(near_corner(0.008), 20);
}

// A stiff lump under a plate, felt through a smooth bump of stiffness.
TEST(Placement, reaches_with_half_the_points_what_an_even_grid_does) {
  const Surface fine = plate(64, 64, 0.1, 0.1);
  const Field lump = [](const Vec3& p) {
    return 1 + 3 * std::exp(-(p - Vec3(0.063, 0.041, 0)).squaredNorm() / (2 * 0.01 * 0.01)) +
           2 * p.x();
  };
  const Surface even = plate(11, 11, 0.1, 0.1);  // 144 points
  const double even_error =
      p95_error(refine(curves_at(even, lump), fine, all(fine), even.triangles), lump);

  const Surface start = plate(3, 3, 0.1, 0.1);
  TestPoints points{start.vertices, -vertex_normals(start), {}, start.triangles};
  points.name.assign(16, "p");
  double error = 1;
  while (points.position.rows() < 72) {
    FittedCurves curves = curves_at({points.position, points.triangles}, lump);
    RefineReport refined;
    const Model model = refine(curves, fine, all(fine), points.triangles, {}, &refined);
    error = p95_error(model, lump);
    const auto seeds =
        place_on_surface(points.position, points.normal, fine, -model.inward_normal, -1, 1);
    for (const std::int32_t vertex : next_points(
             fine, all(fine), seeds, expected_errors(curves, model, refined, 1e-9), {.count = 4})) {
      Eigen::Index strongest = 0;
      model.blend_weight.row(vertex).maxCoeff(&strongest);
      insert_point(points, {fine.vertices.row(vertex), model.inward_normal.row(vertex), "q",
                            model.blend_point(vertex, strongest)});
    }
  }
  EXPECT_LE(points.position.rows(), 72);
  EXPECT_LT(error, even_error);
  RecordProperty("p95_even_144", std::to_string(even_error));
  RecordProperty("p95_adaptive", std::to_string(error));
}

}  // namespace
}  // namespace palpate::testing_refine
