#include <gtest/gtest.h>

#include "tests/libfit/fit/synthetic.hpp"

namespace palpate::test {
namespace {

// Truths whose three curves are in the model class: [N] over [m].
struct Truth {
  std::vector<CurveBasis> basis{CurveBasis{3, {0, 0.004, 0.01}}, CurveBasis{3, {0, 0.003, 0.006}},
                                CurveBasis{3, {0, 0.01}}};
  std::vector<Eigen::VectorXd> control = std::vector<Eigen::VectorXd>(kCurveKinds);
};

// Increments between half and one and a half of a straight line's; friction 0.3 to 0.5.
Truth random_truth(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(0.5, 1.5);
  Truth truth;
  const std::array<double, kCurveKinds> stiffness_N_m{300, 250, 120};
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    Eigen::VectorXd increments = stiffness_N_m[kind] * fit::greville_steps(truth.basis[kind]);
    for (double& a : increments) a *= draw(random);
    truth.control[kind] = fit::controls_of(increments);
  }
  return truth;
}

// Records what the engine's template says for a drag or press.
void record(Recorder& rig, int point, const Mat3& gradient, const Truth& truth, ExperimentKind kind,
            const std::vector<Vec3>& rows) {
  const fit::Bases bases(truth.basis);
  std::vector<runtime::Vec3d> force(rows.size());
  runtime::replay_drag<double>(bases.views, fit::pointers_to<double>(truth.control),
                               fit::quadric_of(rig.inward(point), gradient), rows.front().data(),
                               static_cast<int>(rows.size()), force.data());
  std::vector<Vec3> recorded;
  for (const auto& f : force) recorded.emplace_back(f.x, f.y, f.z);
  rig.add(point, kind, rows, recorded);
}

Mat3 bend(const Vec3& u, const Vec3& t, double along_1_m, double across_1_m) {
  const Vec3 s = u.cross(t);
  return along_1_m * t * t.transpose() + across_1_m * s * s.transpose();
}

// A press and drags in two directions at three depths.
int record_point(Recorder& rig, const Truth& truth, const Vec3& inward, double along_1_m,
                 double across_1_m) {
  const int p = rig.add_point(inward);
  const Vec3 u = rig.inward(p);
  const Mat3 gradient = bend(u, rig.tangent(p, 0.4), along_1_m, across_1_m);
  for (int k = 0; k < 9; ++k) rig.samples.point_normal_gradient(p, k) = gradient(k / 3, k % 3);
  record(rig, p, gradient, truth, ExperimentKind::press, drag_rows(Vec3::Zero(), u, 0, 0.01, 20));
  for (const double depth_m : {0.003, 0.006, 0.01})
    for (const double angle : {0.3, 2.0})
      record(rig, p, gradient, truth, ExperimentKind::drag,
             drag_rows(u, rig.tangent(p, angle), depth_m, 0.008, 32));
  return p;
}

FitOptions with_knots(const Truth& truth) {
  FitOptions options = kSeparable;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind)
    options.knots_m[kind] = truth.basis[kind].knots_m;
  return options;
}

void expect_recovered(const FittedCurves& fitted, Eigen::Index p, const Truth& truth,
                      const std::string& where) {
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    const Eigen::VectorXd found = fitted.curves.control[kind].row(p);
    // A lateral curve is only seen up to where the deepest drag slips; compare as curves there.
    const Curve curve = fitted_curve(fitted, p, static_cast<CurveKind>(kind));
    double reach = truth.basis[kind].knots_m.back();
    const fit::Bases bases(truth.basis);
    const auto exact = [&](double x) {
      return runtime::curve_value(bases.views.view[kind], truth.control[kind].data(), x);
    };
    if (kind == 1)
      while (reach > 1e-4 && exact(reach) > runtime::curve_value(bases.views.view[2],
                                                                 truth.control[2].data(), 0.01))
        reach -= 1e-5;
    double worst = 0;
    for (int i = 1; i <= 100; ++i)
      worst = std::max(worst, std::abs(curve(reach * i / 100) - exact(reach * i / 100)));
    EXPECT_LT(worst, 1e-5 * exact(reach))
        << where << " " << kCurveNames[kind] << "\nfound " << found.transpose() << "\ntruth "
        << truth.control[kind].transpose();
  }
  EXPECT_EQ(fitted.status[static_cast<std::size_t>(p)], FitStatus::good)
      << where << fitted.message[static_cast<std::size_t>(p)];
}

TEST(drag, recovers_all_three_curves_on_flat_and_curved_surfaces) {
  for (unsigned seed = 11; seed <= 16; ++seed) {
    const Truth truth = random_truth(seed);
    Recorder rig;  // sphere of 50 mm, hollow of 80 mm, saddle, plane
    record_point(rig, truth, Vec3(0.2, -1, 0.3), -20, -20);
    record_point(rig, truth, Vec3(0.9, 0.1, 0.3), 12.5, 12.5);
    record_point(rig, truth, Vec3(0, 0.1, -1), -20, 12.5);
    record_point(rig, truth, Vec3(0.2, -1, 0.7), 0, 0);
    const FittedCurves fitted = fit_curves(rig.samples, with_knots(truth));
    for (Eigen::Index p = 0; p < 4; ++p)
      expect_recovered(fitted, p, truth,
                       "seed " + std::to_string(seed) + " point " + std::to_string(p));
  }
}

TEST(drag, a_press_off_the_normal_and_a_path_are_replayed_too) {
  const Truth truth = random_truth(5);
  Recorder rig;
  const int p = rig.add_point(Vec3::UnitZ());
  const Vec3 u = rig.inward(p), t = rig.tangent(p, 1);
  record(rig, p, Mat3::Zero(), truth, ExperimentKind::press,
         drag_rows(Vec3::Zero(), u + 0.15 * t, 0, 0.01, 30));
  std::vector<Vec3> way;  // in, out, round and back, with slip
  for (int i = 0; i <= 120; ++i) {
    const double a = 0.05 * i;
    way.push_back((0.004 + 0.006 * std::pow(std::sin(a), 2)) * u + 0.006 * std::sin(0.7 * a) * t +
                  0.003 * std::sin(a) * u.cross(t));
  }
  record(rig, p, Mat3::Zero(), truth, ExperimentKind::path, way);
  for (const double depth_m : {0.003, 0.01})
    record(rig, p, Mat3::Zero(), truth, ExperimentKind::drag, drag_rows(u, t, depth_m, 0.008, 16));
  const FittedCurves fitted = fit_curves(rig.samples, with_knots(truth));
  expect_recovered(fitted, 0, truth, "seed 5");
}

// A robot's drag: pressed in, then pulled, with an encoder's noise on every axis. The way out of a
// drag once ended at the first row that noise put behind the one before.
TEST(drag, an_encoders_noise_leaves_the_curves) {
  const Curve normal = [](double d) { return 300 * d + 2e4 * d * d; },
              lateral = [](double r) { return 250 * r; },
              limit = [](double d) { return 0.4 * (300 * d + 2e4 * d * d); };
  for (const double jitter_m : {1e-7, 1e-6, 1e-5, 1e-4})
    for (unsigned seed = 1; seed <= 5; ++seed) {
      Recorder rig;
      const int p = rig.add_point(Vec3(0.1, -0.2, 1));
      const Vec3 u = rig.inward(p);
      rig.press(p, normal, 0.006, 24);
      for (const double depth_m : {0.003, 0.006})
        for (const double angle : {0.3, 2.0}) {
          std::vector<Vec3> deflection, force;
          for (int i = 1; i <= 20; ++i) {
            deflection.push_back(depth_m * i / 20 * u);
            force.push_back(normal(depth_m * i / 20) * u);
          }
          for (int i = 1; i <= 60; ++i) {
            const double r = 0.009 * i / 60;
            deflection.push_back(depth_m * u + r * rig.tangent(p, angle));
            force.push_back(normal(depth_m) * u +
                            std::min(lateral(r), limit(depth_m)) * rig.tangent(p, angle));
          }
          rig.add(p, ExperimentKind::drag, deflection, force);
        }
      std::mt19937 random(seed);
      std::normal_distribution<double> noise(0, jitter_m);
      for (Eigen::Index i = 0; i < rig.samples.rows(); ++i)
        for (int k = 0; k < 3; ++k) rig.samples.deflection(i, k) += noise(random);
      const FittedCurves fitted = fit_curves(rig.samples, kSeparable);
      const double allowed = 0.01 + 30 * jitter_m / 0.006;
      EXPECT_LT(relative_rmse(fitted_curve(fitted, 0, CurveKind::normal), normal, 0.006), allowed)
          << "jitter " << jitter_m << " m, seed " << seed << ": " << fitted.message[0];
      EXPECT_LT(relative_rmse(fitted_curve(fitted, 0, CurveKind::limit), limit, 0.006),
                allowed + 0.05)
          << "jitter " << jitter_m << " m, seed " << seed;
      EXPECT_LT(relative_rmse(fitted_curve(fitted, 0, CurveKind::lateral), lateral, 0.004),
                allowed + 0.05)
          << "jitter " << jitter_m << " m, seed " << seed;
    }
}

}  // namespace
}  // namespace palpate::test
