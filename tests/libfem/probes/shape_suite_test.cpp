#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <set>

#include "allocations.hpp"
#include "libfem/probes/shapes.hpp"
#include "probe_cases.hpp"

namespace palpate::fem {
namespace {

constexpr unsigned kSeed = 771;

class ShapeSuite : public testing::TestWithParam<ProbeCase> {
 protected:
  const ProbeCase& given = GetParam();
  const Probe& probe = made(given);
  const bool is_smoothed = probe.shape->takes_mesh;

  /// A mesh's field is costly: made once.
  static const Probe& made(const ProbeCase& given) {
    static std::map<std::string, Probe> probes;
    const auto found = probes.find(given.name);
    return found != probes.end()
               ? found->second
               : probes.emplace(given.name, make_probe(given.spec, "[probe]")).first->second;
  }

  SignedDistance at(const Vec3& offset) const { return probe.distance(Vec3::UnitZ(), offset); }

  /// Calls visit(offset) at seeded places beside the surface: beyond it up to three lengths, behind
  /// it up to a third of its least radius, so never on the medial axis.
  template <class Visit>
  void beside_surface(int places, const Visit& visit) const {
    std::mt19937 random(kSeed);
    for (int i = 0; i < places; ++i) {
      const Vec3 on = given.surface(random);
      const Vec3 normal = at(on).gradient.normalized();
      for (const double away : {-0.3 * given.thin_m, -1e-3 * given.thin_m, 0.0, 1e-3 * given.thin_m,
                                0.5 * given.thin_m, 3 * probe.half_width_m}) {
        const Vec3 offset = on + away * normal;
        SCOPED_TRACE(testing::Message() << "seed " << kSeed << " place " << i << " offset "
                                        << offset.transpose() << " away " << away);
        visit(offset);
      }
    }
  }
};

TEST_P(ShapeSuite, the_reference_point_is_on_the_surface_and_its_normal_points_along_the_axis) {
  std::mt19937 random(kSeed);
  for (int i = 0; i < 20; ++i) {
    const Vec3 axis = i == 0 ? Vec3(Vec3::UnitX()) : random_unit(random);
    const SignedDistance here = probe.distance(axis, Vec3::Zero());
    EXPECT_NEAR(here.distance_m, 0, 1e-14);
    EXPECT_LE((here.gradient - axis).norm(), is_smoothed ? 1e-3 : 1e-10)
        << "axis " << axis.transpose();
  }
}

TEST_P(ShapeSuite, no_part_of_the_surface_touches_before_the_reference_point) {
  std::mt19937 random(kSeed);
  for (int i = 0; i < 2000; ++i)
    EXPECT_LE(given.surface(random).z(), 1e-14 + (is_smoothed ? 1e-3 * given.thin_m : 0));
}

TEST_P(ShapeSuite, sampled_surface_points_have_no_distance) {
  std::mt19937 random(kSeed);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 on = given.surface(random);
    EXPECT_NEAR(at(on).distance_m, 0, is_smoothed ? 4e-3 * given.thin_m : 1e-14)
        << "seed " << kSeed << " at " << on.transpose();
  }
}

TEST_P(ShapeSuite, distance_is_that_to_the_nearest_of_many_surface_points) {
  std::mt19937 random(kSeed);
  std::vector<Vec3> points(40000);
  for (Vec3& point : points) point = given.surface(random);
  std::uniform_real_distribution<double> spread(-1, 1);
  double loosest = 0;
  for (int i = 0; i < 60; ++i) {
    // Inside and outside alike, no higher than shafts without end have been sampled.
    const double w = probe.half_width_m;
    const Vec3 offset(1.5 * w * spread(random), 1.5 * w * spread(random),
                      w * (1.5 * spread(random) - 1));
    double nearest = 1e300;
    for (const Vec3& point : points) nearest = std::min(nearest, (point - offset).norm());
    const double distance = std::abs(at(offset).distance_m);
    EXPECT_LE(distance, nearest * (1 + 1e-12) + (is_smoothed ? 4e-3 * given.thin_m : 1e-15))
        << offset.transpose();
    EXPECT_GE(distance, nearest - given.spacing_m)
        << "seed " << kSeed << " offset " << offset.transpose();
    loosest = std::max(loosest, nearest - distance);
  }
  RecordProperty("loosest_mm", std::to_string(1e3 * loosest));
}

TEST_P(ShapeSuite, is_negative_behind_the_surface_and_positive_before_it) {
  std::mt19937 random(kSeed);
  for (int i = 0; i < 500; ++i) {
    const Vec3 on = given.surface(random);
    const Vec3 step = 0.2 * given.thin_m * at(on).gradient.normalized();
    EXPECT_NEAR(at(on + step).distance_m, 0.2 * given.thin_m, 0.01 * given.thin_m);
    EXPECT_NEAR(at(on - step).distance_m, -0.2 * given.thin_m, 0.01 * given.thin_m);
  }
  EXPECT_LT(at(Vec3(0, 0, -0.5 * given.thin_m)).distance_m, 0);
  EXPECT_GT(at(Vec3(0, 0, 1e3 * probe.length_m)).distance_m, 0);
}

TEST_P(ShapeSuite, gradient_is_the_derivative_of_distance_and_has_unit_length) {
  beside_surface(100, [&](const Vec3& offset) {
    const SignedDistance here = at(offset);
    EXPECT_NEAR(here.gradient.norm(), 1, is_smoothed ? 0.03 : 1e-12);
    const double h = 1e-5 * given.thin_m;
    for (int c = 0; c < 3; ++c) {
      const Vec3 d = h * Vec3::Unit(c);
      const double difference = (at(offset + d).distance_m - at(offset - d).distance_m) / (2 * h);
      EXPECT_NEAR(difference, here.gradient[c], 1e-5);
    }
  });
}

TEST_P(ShapeSuite, hessian_is_symmetric_and_the_derivative_of_gradient_on_open_pieces) {
  int on_pieces = 0, on_joints = 0;
  beside_surface(100, [&](const Vec3& offset) {
    const SignedDistance here = at(offset);
    EXPECT_LE((here.hessian - here.hessian.transpose()).norm(), 1e-9 / given.thin_m);
    const double h = 1e-5 * given.thin_m;
    for (int c = 0; c < 3; ++c) {
      const Vec3 d = h * Vec3::Unit(c);
      const SignedDistance up = at(offset + d), down = at(offset - d);
      // Where it jumps, the difference straddles a joint of two pieces; joints_test.cpp looks
      // there.
      if ((up.hessian - down.hessian).norm() > 0.01 * up.hessian.norm() + 1e-3 / given.thin_m) {
        ++on_joints;
        continue;
      }
      ++on_pieces;
      const Vec3 difference = (up.gradient - down.gradient) / (2 * h);
      EXPECT_LE((difference - here.hessian.col(c)).norm(), 2e-5 / given.thin_m) << here.hessian;
    }
  });
  EXPECT_GT(on_pieces, 30 * (on_joints + 1)) << on_joints << " on joints";
}

TEST_P(ShapeSuite, turning_axis_and_offset_turns_the_derivatives_along) {
  std::mt19937 random(kSeed);
  for (int i = 0; i < 50; ++i) {
    const Mat3 any =
        Eigen::Quaterniond(Eigen::AngleAxisd(0.1 + i, random_unit(random))).toRotationMatrix();
    const Mat3 turn = probe.shape->is_axisymmetric ? any : probe_frame(any.col(2));
    const Vec3 offset = given.surface(random) + 0.2 * given.thin_m * random_unit(random);
    const SignedDistance before = at(offset), after = probe.distance(turn.col(2), turn * offset);
    EXPECT_NEAR(before.distance_m, after.distance_m, 1e-13);
    EXPECT_LE((turn * before.gradient - after.gradient).norm(), 1e-9)
        << "seed " << kSeed << " place " << i;
    EXPECT_LE((turn * before.hessian * turn.transpose() - after.hessian).norm(),
              1e-6 / given.thin_m);
    if (is_smoothed && i == 1) break;  // each costs a field
  }
}

TEST_P(ShapeSuite, the_cheap_bound_is_below_the_distance_and_its_ball_holds_the_shape) {
  std::mt19937 random(kSeed);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 on = given.surface(random), off = on + 3 * probe.half_width_m * random_unit(random);
    EXPECT_LE(probe.min_distance_m(Vec3::UnitZ(), on), 1e-15);
    EXPECT_LE(probe.min_distance_m(Vec3::UnitZ(), off), at(off).distance_m + 1e-15);
  }
}

TEST_P(ShapeSuite, awkward_places_give_finite_numbers) {
  for (const double height : {0.0, 1e-12, 0.3, 1.0, 2.0, 5.0})
    for (const double away : {0.0, 1e-300, 1e-12, 1.0}) {
      const SignedDistance here = at(Vec3(away * given.thin_m, 0, -height * probe.half_width_m));
      EXPECT_TRUE(std::isfinite(here.distance_m) && here.gradient.allFinite() &&
                  here.hessian.allFinite())
          << "height " << height << " away " << away;
      EXPECT_LE(here.gradient.norm(), 1 + 1e-2);
    }
}

TEST_P(ShapeSuite, evaluation_allocates_nothing) {
  std::mt19937 random(kSeed);
  std::vector<Vec3> offsets(2000);
  for (Vec3& offset : offsets)
    offset = given.surface(random) + 0.1 * given.thin_m * random_unit(random);
  const std::size_t before = allocations;
  double sum = 0;
  for (const Vec3& offset : offsets) sum += at(offset).hessian(0, 0);
  EXPECT_EQ(allocations, before) << sum;
}

INSTANTIATE_TEST_SUITE_P(Shapes, ShapeSuite, testing::ValuesIn(probe_cases()),
                         [](const auto& row) { return row.param.name; });

TEST(ShapeTable, every_row_has_a_case_in_the_shared_suite) {
  std::set<std::string> tested;
  for (const ProbeCase& given : probe_cases()) tested.insert(given.spec.shape);
  for (const ShapeRow& row : probe_shapes())
    EXPECT_TRUE(tested.count(std::string(row.name))) << row.name;
}

}  // namespace
}  // namespace palpate::fem
