// Bodies of cubes of 1 mm with grooves, holes and cavities, and a ball of radius 5 mm.

#include "libfem/probes/reach.hpp"

#include <gtest/gtest.h>

#include <random>

#include "probe_cases.hpp"
#include "tests/support/voxels.hpp"

namespace palpate::fem {
namespace {

using testing_support::voxel_surface;

constexpr double kMm = 1e-3, kTolerance_m = 0.3e-3;

Probe ball_of(double radius_m) { return make_probe(sphere_spec(radius_m), "[probe]"); }

// 40 x 40 x 30 mm, with what is left out.
Surface block_without(const std::function<bool(const Vec3&)>& is_left_out) {
  return voxel_surface({40, 40, 30}, kMm, [&](const Vec3& x) { return !is_left_out(x); });
}

Surface grooved(double width_m, double depth_m) {
  return block_without([=](const Vec3& x) {
    return std::abs(x.x() - 0.02) < width_m / 2 && x.z() > 0.03 - depth_m;
  });
}

// Which vertices the tool reaches, asked by place.
class Reached {
 public:
  Reached(const Surface& surface, const Probe& probe)
      : surface_(surface), reach_(surface, probe, kTolerance_m) {
    is_reached_ =
        reach_.vertices(std::vector<char>(static_cast<std::size_t>(surface.vertices.rows()), 1),
                        vertex_normals(surface), &overlap_m_);
  }
  bool at(double x_mm, double y_mm, double z_mm) const {
    return is_reached_[index(x_mm, y_mm, z_mm)] != 0;
  }
  double overlap_mm(double x_mm, double y_mm, double z_mm) const {
    return overlap_m_[index(x_mm, y_mm, z_mm)] / kMm;
  }

 private:
  std::size_t index(double x_mm, double y_mm, double z_mm) const {
    Eigen::Index nearest = 0;
    const double off = (surface_.vertices.rowwise() - kMm * Eigen::RowVector3d(x_mm, y_mm, z_mm))
                           .rowwise()
                           .norm()
                           .minCoeff(&nearest);
    EXPECT_LT(off, 1e-9) << x_mm << ' ' << y_mm << ' ' << z_mm;
    return static_cast<std::size_t>(nearest);
  }

  const Surface& surface_;
  ToolReach reach_;
  std::vector<char> is_reached_;
  std::vector<double> overlap_m_;
};

TEST(Reach, all_of_a_block_is_reached) {
  const Surface block = block_without([](const Vec3&) { return false; });
  const ToolReach reach(block, ball_of(5 * kMm), kTolerance_m);
  const std::vector<char> all(static_cast<std::size_t>(block.vertices.rows()), 1);
  std::vector<double> overlap_m;
  EXPECT_EQ(reach.vertices(all, vertex_normals(block), &overlap_m), all);
  EXPECT_LT(*std::max_element(overlap_m.begin(), overlap_m.end()), 1e-9);
}

TEST(Reach, a_groove_narrower_than_the_ball_is_reached_beside_it_alone) {
  const Surface body = grooved(6 * kMm, 8 * kMm);
  const Reached reached(body, ball_of(5 * kMm));
  EXPECT_TRUE(reached.at(5, 20, 30));
  EXPECT_TRUE(reached.at(16, 20, 30)) << "beside the rim";
  EXPECT_FALSE(reached.at(17, 20, 30)) << "the rim: off at 45 degrees it meets the other one";
  EXPECT_FALSE(reached.at(20, 20, 22)) << "the bottom";
  EXPECT_NEAR(reached.overlap_mm(20, 20, 22), 2, 0.08) << "the walls are 3 mm away";
  EXPECT_FALSE(reached.at(17, 20, 26)) << "a wall";
}

TEST(Reach, a_groove_wider_than_the_ball_is_reached_but_for_its_corners) {
  const Surface body = grooved(14 * kMm, 14 * kMm);
  const Reached reached(body, ball_of(5 * kMm));
  EXPECT_TRUE(reached.at(20, 20, 16)) << "the bottom";
  EXPECT_TRUE(reached.at(13, 20, 24)) << "a wall";
  EXPECT_FALSE(reached.at(13, 20, 16)) << "where bottom and wall meet";
  EXPECT_NEAR(reached.overlap_mm(13, 20, 16), 5 - 5 / std::sqrt(2.0), 0.08);
}

TEST(Reach, a_ball_that_would_lie_in_the_opposite_bank_of_a_slit_is_not_free) {
  const Surface body = grooved(2 * kMm, 20 * kMm);
  const Reached reached(body, ball_of(5 * kMm));
  EXPECT_FALSE(reached.at(19, 20, 20));
  EXPECT_NEAR(reached.overlap_mm(19, 20, 20), 5 + 3, 0.08);
  // A tenth of the tolerance wide, the slit cuts nothing off the ball: it lies inside as a whole.
  const Surface thin = [&] {
    Surface squeezed = body;
    for (auto x : squeezed.vertices.col(0)) x = x > 0.02 ? x - 1.97 * kMm : x;
    return squeezed;
  }();
  const ToolReach reach(thin, ball_of(5 * kMm), kTolerance_m);
  EXPECT_GT(reach.overlap_m(Vec3(0.019, 0.02, 0.02), -Vec3::UnitX()), 5 * kMm);
  EXPECT_FALSE(reach.is_free(Vec3(0.019, 0.02, 0.02), -Vec3::UnitX()));
}

TEST(Reach, a_hole_is_reached_where_the_ball_fits_in) {
  for (const double width_mm : {6.0, 14.0}) {
    const Surface body = block_without([=](const Vec3& x) {
      return std::abs(x.x() - 0.02) < width_mm * kMm / 2 &&
             std::abs(x.y() - 0.02) < width_mm * kMm / 2;
    });
    const Reached reached(body, ball_of(5 * kMm));
    EXPECT_EQ(reached.at(20 - width_mm / 2, 20, 15), width_mm > 10) << width_mm;
    EXPECT_TRUE(reached.at(5, 20, 30));
  }
}

// A chamber of 16 mm below the top, open to it by a mouth of the given width.
TEST(Reach, a_chamber_is_reached_through_a_mouth_as_wide_as_the_ball) {
  for (const double mouth_mm : {0.0, 6.0, 12.0}) {
    const Surface body = block_without([=](const Vec3& x) {
      const double away = std::max(std::abs(x.x() - 0.02), std::abs(x.y() - 0.02));
      return (away < 8 * kMm && x.z() > 6 * kMm && x.z() < 22 * kMm) ||
             (away < mouth_mm * kMm / 2 && x.z() > 6 * kMm);
    });
    const Reached reached(body, ball_of(5 * kMm));
    EXPECT_LT(reached.overlap_mm(20, 20, 6), 1e-9) << "the ball has room on the floor";
    EXPECT_EQ(reached.at(20, 20, 6), mouth_mm > 10) << mouth_mm;
    EXPECT_EQ(reached.at(12, 20, 14), mouth_mm > 10) << mouth_mm;
  }
}

TEST(Reach, a_flat_punch_needs_the_width_of_the_groove_up_to_its_mouth) {
  const Surface body = grooved(14 * kMm, 14 * kMm);
  for (const double radius_mm : {5.0, 9.0}) {
    const Probe punch = make_probe(spec_of("flat", {{"radius", {radius_mm * kMm}}}), "[probe]");
    const Reached reached(body, punch);
    EXPECT_TRUE(reached.at(5, 20, 30)) << radius_mm;
    EXPECT_EQ(reached.at(20, 20, 16), radius_mm < 7) << radius_mm;
    EXPECT_FALSE(reached.at(13, 20, 24)) << "its shaft would go through the other wall";
  }
}

TEST(Reach, every_shape_touches_the_middle_of_a_flat_face_freely) {
  Surface half_space = voxel_surface({4, 4, 4}, 0.5, [](const Vec3&) { return true; });
  for (const ProbeCase& probe : probe_cases()) {
    SCOPED_TRACE(probe.name);
    const ToolReach reach(half_space, make_probe(probe.spec, "[probe]"), kTolerance_m);
    EXPECT_LT(reach.overlap_m(Vec3(1, 1, 2), -Vec3::UnitZ()), kTolerance_m);
    const double sunk = reach.overlap_m(Vec3(1, 1, 2 - 2e-3), -Vec3::UnitZ());
    EXPECT_GT(sunk, kTolerance_m);
    EXPECT_LT(sunk, 2e-3 + kTolerance_m) << "no deeper than it stands in the face";
  }
}

TEST(Reach, overlap_of_a_ball_is_its_radius_less_the_distance_of_its_centre) {
  const Surface block = block_without([](const Vec3&) { return false; });
  const ToolReach reach(block, ball_of(5 * kMm), kTolerance_m);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0, 1);
  for (int i = 0; i < 300; ++i) {
    const Vec3 inward = random_unit(random);
    const Vec3 centre =
        Vec3(0.06 * share(random) - 0.01, 0.06 * share(random) - 0.01, 0.05 * share(random) - 0.01);
    const Vec3 half(0.02, 0.02, 0.015), out = (centre - half).cwiseAbs() - half;
    const double distance = out.maxCoeff() < 0 ? out.maxCoeff() : out.cwiseMax(0).norm();
    const double expected = std::max(5 * kMm - distance, 0.0);
    EXPECT_NEAR(reach.overlap_m(centre + 5 * kMm * inward, inward), expected, 0.26 * kTolerance_m)
        << "seed 7, pose " << i;
  }
}

}  // namespace
}  // namespace palpate::fem
