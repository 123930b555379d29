// A contact in series with the sway of the body (docs/method-body.md, section 21).

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

#include <random>

#include "libfit/core/error.hpp"
#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

using runtime::Compliance;
using runtime::Vec3d;

Mat3 draw_symmetric(std::mt19937& random, double least, double most) {
  std::uniform_real_distribution<double> unit(-1, 1), eigenvalue(least, most);
  Mat3 m;
  for (double& x : m.reshaped()) x = unit(random);
  const Mat3 q = m.householderQr().householderQ();
  return q * Vec3(eigenvalue(random), eigenvalue(random), eigenvalue(random)).asDiagonal() *
         q.transpose();
}
Compliance compliance(const Mat3& m) {
  return {{m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)}};
}
Vec3 eigen(const Vec3d& v) { return {v.x, v.y, v.z}; }

// A body of rings that sways by C everywhere.
Model swaying(Model model, double friction, double radius_m, const Mat3& C,
              const std::function<double(const Vec3&)>& scale) {
  make_rings(model, friction, radius_m, scale);
  set_sway(model, [&](const Vec3&) { return numbers_of(C); });
  return model;
}

TEST(sway, of_a_linear_law_is_the_series_of_both) {
  constexpr unsigned kSeed = 3;
  std::mt19937 random(kSeed);
  for (int trial = 0; trial < 200; ++trial) {
    const Mat3 K = draw_symmetric(random, 0, 300), C = draw_symmetric(random, 0, 0.05);
    const Vec3 x = Vec3::Random() * 1e-2;
    runtime::ComplianceMatrix compliance;
    compliance.count = 1;
    double stiffness[9] = {};
    for (int i = 0; i < 9; ++i) compliance.block[0][0][i] = C(i / 3, i % 3);
    runtime::SeriesForces found;
    found.compliance = &compliance;
    found.rest[0] = {x[0], x[1], x[2]};
    found.force[0] = {0, 0, 0};
    found.stiffness[0] = stiffness;
    int answers = 0;
    runtime::SeriesMatrix matrix;
    const bool is_root = settle(found, matrix, found.rest, [&](int, const Vec3d& y) {
      ++answers;
      const Vec3 r = K * eigen(y);
      return Vec3d{r[0], r[1], r[2]};
    });
    const Vec3 exact = (Mat3::Identity() + K * C).partialPivLu().solve(K * x);
    EXPECT_TRUE(is_root) << "seed " << kSeed << " trial " << trial;
    EXPECT_LT((eigen(found.force[0] + found.correction_N[0]) - exact).norm(), 1e-8 * exact.norm())
        << "seed " << kSeed << " trial " << trial;
    EXPECT_LE(answers, runtime::kMaxSettleSteps + 2);
  }
}

TEST(sway, a_compliance_that_is_negative_somewhere_is_refused) {
  constexpr unsigned kSeed = 5;
  std::mt19937 random(kSeed);
  for (int trial = 0; trial < 100; ++trial) {
    const Mat3 good = draw_symmetric(random, 1e-4, 0.05);
    EXPECT_TRUE(runtime::is_positive_semidefinite(compliance(good).c));
    const Eigen::SelfAdjointEigenSolver<Mat3> axes(good);
    const Vec3 axis = axes.eigenvectors().col(trial % 3);
    const Mat3 bad = good - (axes.eigenvalues()[trial % 3] + 1e-3) * axis * axis.transpose();
    EXPECT_FALSE(runtime::is_positive_semidefinite(compliance(bad).c));
  }
  const Model model = swaying(plate_model(0.08, 4, uniform(400, 300, 0.3)), 1, 0,
                              Vec3(0.01, 0.01, -0.01).asDiagonal(), even);
  EXPECT_THROW(load(model), Error);
}

// The same body without the sway, its tool at x - C f, answers with f.
TEST(sway, leaves_the_law_the_rest_of_the_way) {
  const Mat3 C{{0.02, 0.003, 0}, {0.003, 0.01, 0}, {0, 0, 0.004}};
  const Loaded soft = load(swaying(plate_model(0.08, 16, uniform(400, 300, 0.3)), 1, 0, C, even));
  const Loaded firm =
      load(swaying(plate_model(0.08, 16, uniform(400, 300, 0.3)), 1, 0, Mat3::Zero(), even));
  const Mat3 stored = C.cast<float>().cast<double>();
  Contact with, without;
  Output out, rest;
  int slid = 0, stuck = 0;
  for (int k = 0; k <= 4000; ++k) {
    const double t = k / 4000.0;
    const double way = std::max(t - 0.1, 0.0);  // straight to the same first touch
    const Vec3 x(0.012 * way * std::cos(9 * t), 0.008 * std::sin(5 * t) * way,
                 1e-4 - 0.006 * std::min(2 * t, 1.0));
    ASSERT_EQ(touch(soft.asset, with, x.data(), out), Status::ok);
    const Vec3 force = -Vec3::Map(out.force_on_tool_N);
    const Vec3 y = x - stored * force;
    ASSERT_EQ(touch(firm.asset, without, y.data(), rest), Status::ok);
    ASSERT_LT((Vec3::Map(out.force_on_tool_N) - Vec3::Map(rest.force_on_tool_N)).norm(),
              1e-6 * (0.01 + force.norm()))
        << "tick " << k;
    ASSERT_NEAR(out.stored_J, rest.stored_J + 0.5 * force.dot(stored * force),
                1e-7 * (1e-6 + out.stored_J));
    EXPECT_EQ(out.flags & PALPATE_FLAG_UNFINISHED, 0U) << "tick " << k;
    slid += out.state == ContactState::slip;
    stuck += out.state == ContactState::stick;
  }
  EXPECT_GT(slid, 300);
  EXPECT_GT(stuck, 300);
}

TEST(sway, tangent_is_the_slope_of_the_force) {
  constexpr unsigned kSeed = 11;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> unit(-1, 1);
  const Loaded body = load(swaying(plate_model(0.08, 16, uniform(400, 300, 0.3)), 1, 0,
                                   draw_symmetric(random, 0.001, 0.02), even));
  Contact contact;
  Output out;
  Vec3 x(0, 0, 1e-3);
  touch(body.asset, contact, x.data(), out);
  int compared = 0, off = 0;
  for (int k = 0; k < 400; ++k) {
    const Vec3 aim(3e-3 * unit(random), 3e-3 * unit(random), -4e-3 + 2e-3 * unit(random));
    x += std::min(1.0, 3e-4 / (aim - x).norm()) * (aim - x);
    const Contact start = contact;
    double tangent[9];
    touch(body.asset, contact, x.data(), out, tangent);
    if (out.state == ContactState::air || start.triangle < 0) continue;
    double scale = 1;
    for (const double entry : tangent) scale = std::max(scale, std::abs(entry));
    for (int j = 0; j < 3; ++j) {
      constexpr double kStep_m = 1e-7;
      Vec3 side[2];
      ContactState state[2];
      for (int s = 0; s < 2; ++s) {
        Contact again = start;
        Output there;
        const Vec3 at = x + (s == 0 ? kStep_m : -kStep_m) * Vec3::Unit(j);
        touch(body.asset, again, at.data(), there);
        side[s] = -Vec3::Map(there.force_on_tool_N), state[s] = there.state;
      }
      if (state[0] != out.state || state[1] != out.state) continue;
      const Vec3 slope = (side[0] - side[1]) / (2 * kStep_m);
      for (int i = 0; i < 3; ++i) {
        off += !(std::abs(tangent[3 * i + j] - slope[i]) < 1e-3 * scale);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 1000);
  EXPECT_LT(off, 0.02 * compared) << "a ring that begins to slip within a difference bends it";
}

}  // namespace
}  // namespace palpate::test
