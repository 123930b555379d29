// The filter against surfaces whose truth is known: what is left of the noise, what it costs.

#include "libfem/mesh/surface/surface.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/libfem/mesh/surface/surfaces.hpp"

namespace palpate {
namespace {

using testing::cube;
using testing::sphere;
using testing::subdivided;

Surface with_noise(Surface surface, double noise_m, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> off(0, noise_m);
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
    for (int k = 0; k < 3; ++k) surface.vertices(v, k) += off(random);
  return surface;
}

double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

std::vector<double> off_sphere(const Surface& surface, double radius_m) {
  std::vector<double> off;
  for (const auto& v : surface.vertices.rowwise()) off.push_back(v.norm() - radius_m);
  return off;
}

// Of a cube [0, side]^3; outside, the distance of the nearest place.
std::vector<double> off_cube(const Surface& surface, double side_m) {
  std::vector<double> off;
  for (const auto& v : surface.vertices.rowwise()) {
    const Eigen::Array3d beyond = (v.transpose().array() - side_m / 2).abs() - side_m / 2;
    off.push_back(beyond.maxCoeff() > 0 ? beyond.max(0).matrix().norm() : beyond.maxCoeff());
  }
  return off;
}

TEST(filter_noise, leaves_less_than_half_of_it_on_a_ball_and_keeps_the_volume) {
  const Surface ball = sphere(0.05, 4);  // edges of 5 mm
  for (const double noise_m : {0.0003, 0.001})
    for (const unsigned seed : {1u, 2u}) {
      const FilteredSurface out = filter_noise(with_noise(ball, noise_m, seed), noise_m);
      EXPECT_LT(rms(off_sphere(out.surface, 0.05)), 0.5 * noise_m) << noise_m << " seed " << seed;
      EXPECT_NEAR(out.moved_m, noise_m, 1e-9);
      EXPECT_NEAR(volume_m3(out.surface) / volume_m3(ball), 1, 0.003);
    }
}

TEST(filter_noise, keeps_the_edges_of_a_cube) {
  Surface block = cube(0.04);
  for (int level = 0; level < 4; ++level) block = subdivided(block);  // edges of 2.5 mm
  for (const unsigned seed : {3u, 4u}) {
    const FilteredSurface out = filter_noise(with_noise(block, 0.0003, seed), 0.0003);
    std::vector<double> at_edges;
    const std::vector<double> off = off_cube(out.surface, 0.04);
    for (Eigen::Index v = 0; v < block.vertices.rows(); ++v) {
      const auto borders =
          ((block.vertices.row(v).array() < 1e-9) || (block.vertices.row(v).array() > 0.04 - 1e-9))
              .count();
      if (borders > 1) at_edges.push_back(off[static_cast<std::size_t>(v)]);
    }
    EXPECT_LT(rms(off), 0.00015) << "seed " << seed;
    EXPECT_LT(rms(at_edges), 0.0003) << "seed " << seed;  // as far as the noise itself
    EXPECT_GT(volume_m3(out.surface), 0.993 * volume_m3(block));
  }
}

TEST(filter_noise, moves_a_clean_surface_by_no_more_than_it_was_told) {
  const Surface ball = sphere(0.05, 4);
  const FilteredSurface out = filter_noise(ball, 0.0001);
  EXPECT_LE(out.moved_m, 0.0001 + 1e-12);
}

TEST(roughness, tells_the_noise_of_a_ball_and_almost_none_where_there_is_none) {
  const Surface ball = sphere(0.05, 4);
  EXPECT_LT(roughness_m(ball), 0.00005);
  for (const double noise_m : {0.0003, 0.001})
    EXPECT_NEAR(roughness_m(with_noise(ball, noise_m, 5)) / noise_m, 1, 0.15) << noise_m;
}

// A clean box was told that it is noisy: half of its vertices lie at edges.
TEST(roughness, is_measured_within_smooth_patches) {
  Surface box = cube(0.04);
  for (int level = 0; level < 2; ++level) box = subdivided(box);
  EXPECT_LT(roughness_m(box), 1e-9);
  box = subdivided(box);
  const double edge_m = 0.005;
  EXPECT_NEAR(roughness_m(with_noise(box, 0.1 * edge_m, 6)) / (0.1 * edge_m), 1, 0.3);
}

}  // namespace
}  // namespace palpate
