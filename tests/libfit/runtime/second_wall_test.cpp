// A ball in a groove: a contact has one place on the surface, so it feels one of two flanks. Two
// assets of the same body, each with a flank of its own, and a contact for each feel both
// (docs/method.md, section 18).

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

using Mat3 = Eigen::Matrix3d;

constexpr double kSlope = std::numbers::pi / 6;  // of a flank
constexpr double kRadius_m = 0.004;
const double kTouch_m =
    kRadius_m / std::cos(kSlope);  // height of the centre where both are touched

enum class Flank { left, right, both };

// A groove along y, its bottom at x = z = 0. What is not measured does not answer.
Loaded groove(Flank which) {
  Model model = plate_model(0.03, 30, uniform(400, 300, 0.3));
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v) {
    Vec3 x = model.surface.vertices.row(v);
    x[2] = std::tan(kSlope) * std::abs(x[0]);
    model.surface.vertices.row(v) = x;
    const double side = which == Flank::left    ? -1
                        : which == Flank::right ? 1
                        : std::abs(x[0]) < 1e-6 ? 0
                                                : (x[0] > 0 ? 1 : -1);
    model.inward_normal.row(v) << side * std::sin(kSlope), 0, -(side == 0 ? 1 : std::cos(kSlope));
  }
  make_rings(model, 1, 0, even);
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v) {
    const double x = model.surface.vertices(v, 0);
    if (which == Flank::both || (which == Flank::left ? x < -1e-6 : x > 1e-6)) continue;
    model.is_covered[static_cast<std::size_t>(v)] = 0;
    for (Controls& control : model.curves.control) control.row(v).setZero();
  }
  ExportOptions options;
  options.has_mean_elsewhere = false;
  return load(model, options);
}

Vec3 force_of(const Output& out) { return Vec3::Map(out.force_on_tool_N); }

TEST(second_wall, two_contacts_of_a_flank_each_bear_what_a_groove_has) {
  const Loaded left = groove(Flank::left), right = groove(Flank::right), both = groove(Flank::both);
  Contact of_left, of_right, alone;
  Output a, b, one;
  for (int k = 0; k <= 100; ++k) {
    const Vec3 centre(0, 0.0003, kTouch_m + 0.0005 - 5e-5 * k);
    for (const auto& [body, contact, out] :
         {std::tuple{&left, &of_left, &a}, {&right, &of_right, &b}, {&both, &alone, &one}})
      ASSERT_EQ(touch_ball(body->asset, *contact, centre.data(), kRadius_m, *out), Status::ok);
  }
  // Friction holds each contact where it began; along a flank the ball goes by d tan, within it.
  const double sunk_m = 100 * 5e-5 - 0.0005, d = sunk_m * std::cos(kSlope);
  const Vec3 sum = force_of(a) + force_of(b);
  const double normal_N = 12 * d + 4500 * d * d;
  EXPECT_NEAR(sum[0], 0, 1e-9 * sum[2]);
  EXPECT_GT(sum[2], 2 * normal_N * std::cos(kSlope));
  EXPECT_LT(sum[2], 2 * normal_N * (std::cos(kSlope) + 0.5 * std::sin(kSlope)));
  EXPECT_NEAR(force_of(one)[2] / sum[2], 0.5, 0.02);
}

}  // namespace
}  // namespace palpate::test
