#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "libfem/probes/probes.hpp"
#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

constexpr unsigned kSeed = 771;
constexpr double kRadius_m = 0.008;

Vec3 random_unit(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vec3(normal(random), normal(random), normal(random)).normalized();
}

class ShapeSuite : public testing::TestWithParam<const ShapeRow*> {
 protected:
  const ShapeRow& shape = *GetParam();

  /// Calls visit(axis, offset) at seeded places from deep inside to far off.
  template <class Visit>
  void at_seeded_places(const Visit& visit) const {
    std::mt19937 random(kSeed);
    for (const double away : {0.3, 0.9, 1.0, 1.1, 3.0})
      for (int i = 0; i < 10; ++i) {
        const Vec3 axis = random_unit(random);
        const Vec3 centre = shape.centre_along_axis * kRadius_m * axis;
        const Vec3 offset = centre + away * kRadius_m * random_unit(random);
        SCOPED_TRACE(testing::Message() << "seed " << kSeed << " axis " << axis.transpose()
                                        << " offset " << offset.transpose());
        visit(axis, offset);
      }
  }
};

TEST_P(ShapeSuite, the_reference_point_is_on_the_surface_and_its_normal_points_along_the_axis) {
  const Vec3 axis = Vec3(1, 2, -2) / 3;
  const SignedDistance at = shape.signed_distance(kRadius_m, axis, Vec3::Zero());
  EXPECT_NEAR(at.distance_m, 0, 1e-15);
  EXPECT_LE((at.gradient - axis).norm(), 1e-14);
}

TEST_P(ShapeSuite, gradient_is_the_derivative_of_distance_and_has_unit_length) {
  at_seeded_places([&](const Vec3& axis, const Vec3& offset) {
    const SignedDistance at = shape.signed_distance(kRadius_m, axis, offset);
    EXPECT_NEAR(at.gradient.norm(), 1, 1e-14);
    const double h = 1e-5 * kRadius_m;
    for (int c = 0; c < 3; ++c) {
      const Vec3 d = h * Vec3::Unit(c);
      const double difference = (shape.signed_distance(kRadius_m, axis, offset + d).distance_m -
                                 shape.signed_distance(kRadius_m, axis, offset - d).distance_m) /
                                (2 * h);
      EXPECT_NEAR(difference, at.gradient[c], 1e-8);
    }
  });
}

TEST_P(ShapeSuite, hessian_is_the_derivative_of_gradient_and_symmetric) {
  at_seeded_places([&](const Vec3& axis, const Vec3& offset) {
    const SignedDistance at = shape.signed_distance(kRadius_m, axis, offset);
    EXPECT_LE((at.hessian - at.hessian.transpose()).norm(), 1e-12 / kRadius_m);
    const double h = 1e-5 * kRadius_m;
    for (int c = 0; c < 3; ++c) {
      const Vec3 d = h * Vec3::Unit(c);
      const Vec3 difference = (shape.signed_distance(kRadius_m, axis, offset + d).gradient -
                               shape.signed_distance(kRadius_m, axis, offset - d).gradient) /
                              (2 * h);
      EXPECT_LE((difference - at.hessian.col(c)).norm(), 1e-7 / kRadius_m);
    }
  });
}

std::vector<const ShapeRow*> all_shapes() {
  std::vector<const ShapeRow*> rows;
  for (const ShapeRow& row : probe_shapes()) rows.push_back(&row);
  return rows;
}

INSTANTIATE_TEST_SUITE_P(Shapes, ShapeSuite, testing::ValuesIn(all_shapes()),
                         [](const auto& row) { return std::string(row.param->name); });

TEST(Sphere, distance_is_that_of_a_ball_whose_lowest_point_is_the_reference_point) {
  const ShapeRow& sphere = find_shape("sphere", "test");
  const Vec3 axis = -Vec3::UnitZ();  // pressing down: the centre is R above
  EXPECT_NEAR(sphere.signed_distance(2, axis, Vec3(0, 0, -3)).distance_m, 3, 1e-15);
  EXPECT_NEAR(sphere.signed_distance(2, axis, Vec3(0, 0, 1)).distance_m, -1, 1e-15);
  EXPECT_NEAR(sphere.signed_distance(2, axis, Vec3(3, 0, 2)).distance_m, 1, 1e-15);
}

TEST(Sphere, its_centre_has_no_direction_but_finite_numbers) {
  const ShapeRow& sphere = find_shape("sphere", "test");
  const SignedDistance at = sphere.signed_distance(2, Vec3::UnitX(), Vec3(-2, 0, 0));
  EXPECT_EQ(at.distance_m, -2);
  EXPECT_EQ(at.gradient.norm(), 0);
  EXPECT_EQ(at.hessian.norm(), 0);
}

std::string message_of(const char* shape, double radius_m, double friction) {
  try {
    make_probe(shape, radius_m, friction, "[probe]");
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ProbeRefusals, name_the_number_and_the_known_shapes) {
  EXPECT_EQ(message_of("spear", 0.01, 0.3),
            "[probe]: unknown probe shape \"spear\"\n  Use one of: sphere.");
  EXPECT_EQ(message_of("sphere", 0, 0.3),
            "[probe]: radius must be positive, not 0.000000 m\n"
            "  Give the probe's radius with its unit, for example radius = \"5 mm\".");
  EXPECT_EQ(message_of("sphere", 0.01, -0.1),
            "[probe]: friction must be zero or positive, not -0.100000\n"
            "  Give the Coulomb coefficient of the interface, 0 for none.");
  EXPECT_EQ(message_of("sphere", 0.01, 0), "accepted");
}

}  // namespace
}  // namespace palpate::fem
