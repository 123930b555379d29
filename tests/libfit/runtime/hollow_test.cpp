// A ball slides over a pit that is too narrow for it (docs/method.md, section 12).

#include <gtest/gtest.h>

#include <random>

#include "tests/libfit/runtime/capsule.hpp"

namespace palpate::test {
namespace {

/// A plate with a pit of Gaussian shape; curvatures as a ball's centre sees them.
Model pit_model(double depth_m, double width_m, double ball_m) {
  Model model = plate_model(0.08, 80, uniform(400, 300, 0.3));
  make_rings(model, 0.5, 0, even);
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v) {
    Vec3 x = model.surface.vertices.row(v);
    const double squared = x.squaredNorm() / (width_m * width_m);
    const double sunk_m = depth_m * std::exp(-0.5 * squared);
    const Vec3 outward = (Vec3(0, 0, 1) - sunk_m / (width_m * width_m) * x).normalized();
    const Vec3 away = x.norm() > 0 ? x.normalized() : Vec3::UnitX();
    const Vec3 radial = (away - away.dot(outward) * outward).normalized();
    const Vec3 around = outward.cross(radial);
    const auto seen = [&](double k) { return k / std::max(1 + ball_m * k, 0.25); };
    const double k = -sunk_m / (width_m * width_m);
    const Mat3 curvature = seen(k * (1 - squared)) * radial * radial.transpose() +
                           seen(k) * around * around.transpose();
    model.curves.control[runtime::kCurvature].row(v) = numbers_of(curvature);
    model.inward_normal.row(v) = -outward.transpose();
    model.surface.vertices(v, 2) -= sunk_m;
  }
  for (Controls& control : model.curves.control) control = rounded_to_float(control);
  model.probe = sphere_spec(ball_m, 0.5);
  return model;
}

// Its contact point stays at one flank: 78 N where a fresh ball has 0.12.
TEST(Hollow, that_is_too_narrow_for_a_ball_lets_go_of_it_without_a_step) {
  for (const double ball_m : {0.008, 0.016}) {
    const Model model = pit_model(0.006, 0.004, ball_m);
    const auto new_ball = [&] {
      Capsule ball(model, 1);
      ball.tool.shape.ball[0].radius_m = ball_m;
      return ball;
    };
    std::mt19937 random(3);
    std::uniform_real_distribution<double> share(-1, 1);
    for (int slide = 0; slide < 12; ++slide) {
      const Mat3 turn = Eigen::AngleAxisd(3 * share(random), Vec3::UnitZ()).toRotationMatrix();
      const Vec3 from = turn * Vec3(-0.015, 0.012 * share(random), ball_m - 0.003);
      const Vec3 path = turn * Vec3(1, 0.3 * share(random), 0);
      Capsule ball = new_ball();
      for (int i = 0; i <= 400; ++i)
        ball.tick(pose_at(from + Vec3(0, 0, 1e-5 * (400 - i)), Vec3::Zero()));
      for (int i = 1; i <= 1500; ++i) {
        const Vec3 at = from + path * 2e-5 * i, force = ball.force();
        ball.tick(pose_at(at, Vec3::Zero()));
        ASSERT_LT((ball.force() - force).norm(), 0.003) << slide << ", " << at.transpose();
        if (i % 300 != 0) continue;
        Capsule fresh = new_ball();
        for (int k = 0; k <= 400; ++k)
          fresh.tick(pose_at(at + Vec3(0, 0, 3e-5 * (400 - k)), Vec3::Zero()));
        ASSERT_LT(ball.force().norm(), 1.5 * fresh.force().norm() + 0.02)
            << slide << ", " << at.transpose();
      }
    }
  }
}

}  // namespace
}  // namespace palpate::test
