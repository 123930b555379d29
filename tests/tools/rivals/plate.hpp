#pragma once

#include <gtest/gtest.h>

#include <filesystem>

#include "libfit/assets/exporters.hpp"
#include "tests/libfit/runtime/models.hpp"
#include "tools/workshop/rivals/rivals.hpp"

namespace palpate::tools::testing_rivals {

inline constexpr double kStiffness_N_m = 400, kCone = 0.25;

/// A plate whose presses are a spring's and whose drags end on a cone.
inline Samples plate_samples() {
  Samples samples;
  samples.point_position = Points::Zero(2, 3);
  samples.point_position.row(1) << 0.01, 0, 0;
  samples.point_normal = -Vec3::UnitZ().transpose().replicate(2, 1);
  samples.point_name = {"a", "b"};
  const auto add = [&](int point, int experiment, ExperimentKind kind, int step, const Vec3& at,
                       const Vec3& force) {
    const Eigen::Index row = samples.rows();
    samples.deflection.conservativeResize(row + 1, 3);
    samples.force.conservativeResize(row + 1, 3);
    samples.deflection.row(row) = at.transpose();
    samples.force.row(row) = force.transpose();
    samples.point.push_back(point);
    samples.experiment.push_back(experiment);
    samples.kind.push_back(kind);
    samples.step.push_back(step);
    samples.status.push_back(RowStatus::good);
  };
  for (int point = 0; point < 2; ++point) {
    for (int step = 1; step <= 4; ++step)
      add(point, 2 * point, ExperimentKind::press, step, {0, 0, -1e-3 * step},
          {0, 0, -1e-3 * step * kStiffness_N_m});
    add(point, 2 * point + 1, ExperimentKind::drag, 0, {5e-3, 0, -4e-3},
        {kCone * 4e-3 * kStiffness_N_m, 0, -4e-3 * kStiffness_N_m});
  }
  samples.force_error = Eigen::VectorXd::Zero(samples.rows());
  samples.torque = Points::Zero(samples.rows(), 3);
  return samples;
}

/// Rivals that are made of these samples, and an asset of such a plate.
class Proxies : public testing::Test {
 protected:
  Proxies() {
    const std::filesystem::path path =
        std::filesystem::path(testing::TempDir()) / "rivals_plate.palp";
    export_palp(test::plate_model(0.1, 20, test::uniform(400, 300, 0.3)), path, {});
    body_.asset = read_asset_file(path);
    body_.samples = plate_samples();
  }

  RivalBody body_;
};

/// Presses 2 mm deep from outside, beside the first test point, then slides.
inline Vec3 press_and_slide(const Rival& rival, double slide_m) {
  rival.start(-Vec3::UnitZ());
  Vec3 force = Vec3::Zero();
  for (int k = 0; k <= 40; ++k) force = rival.force({1e-4, 1.3e-4, 1e-4 * (20 - k)});
  for (int k = 1; k <= 100; ++k) force = rival.force({1e-4 + slide_m * k / 100, 1.3e-4, -2e-3});
  return force;
}

}  // namespace palpate::tools::testing_rivals
