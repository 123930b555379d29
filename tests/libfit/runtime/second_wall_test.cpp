// A ball in a groove: a contact has one place on the surface, so it feels one of two flanks. Two
// assets of the same body, each with a flank of its own, and a contact for each feel both
// (docs/method.md, section 18).

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

constexpr double kSlope = std::numbers::pi / 6;  // of a flank
constexpr double kRadius_m = 0.004;
const double kTouch_m =
    kRadius_m / std::cos(kSlope);  // height of the centre where both are touched

enum class Flank { left, right, both };

// What is not measured does not answer.
Loaded groove(Flank which) {
  Model model = groove_model(0.03, 30, kSlope);
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v)
    if (which != Flank::both && std::abs(model.surface.vertices(v, 0)) < 1e-6)
      model.inward_normal.row(v) << (which == Flank::left ? -1 : 1) * std::sin(kSlope), 0,
          -std::cos(kSlope);
  make_rings(model, 1, 0, even);
  uncover(model, [&](const Vec3& x) {
    return which == Flank::left ? x[0] > 1e-6 : which == Flank::right && x[0] < -1e-6;
  });
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
