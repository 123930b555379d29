// Torques of a recording.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <sstream>

#include "libfit/recordings/placing/assemble.hpp"
#include "tests/libfit/io/scratch.hpp"

namespace palpate::recordings {
namespace {

class TorqueTest : public testing_io::ScratchTest {
 protected:
  // A press along -z of 1 kN/m, whose force acts 2 mm beside the tip: torque (0, 2 mm, 0) x f.
  BatchItem item(const std::string& name, const std::string& torque_header) {
    std::ostringstream text;
    text << "t,x,y,z,fx,fy,fz," << torque_header << '\n';
    for (int i = 0; i < 200; ++i) {
      const double depth_mm = std::max(0.0, 0.02 * i - 1), force = -depth_mm;
      text << 0.01 * i << ",0,0," << 1 - 0.02 * i << ",0,0," << force + 0.05 << ','
           << 2 * force + 0.3 << ",0,0\n";
    }
    testing_io::write_quickly(at(name), text.str());
    BatchItem out;
    out.file = at(name);
    out.shown = name;
    out.point = "p";
    out.position_m = Vec3::Zero();
    out.normal = Vec3(0, 0, -1);
    out.read.columns.time = "t";
    out.read.columns.position = {"x", "y", "z"};
    out.read.columns.force = {"fx", "fy", "fz"};
    out.read.columns.torque = {"tx", "ty", "tz"};
    out.read.units = {"s", "mm", "N", "Nmm"};
    return out;
  }
  static double off(const Samples& samples, const Vec3& arm_m) {
    double most = 0;
    for (Eigen::Index i = 0; i < samples.rows(); ++i) {
      const Vec3 force = samples.force.row(i), torque = samples.torque.row(i);
      most = std::max(most, (torque - arm_m.cross(force)).norm());
    }
    return most;
  }
};

TEST_F(TorqueTest, torque_columns_become_the_samples_torque_without_their_bias) {
  const auto results = run_batch({item("a.csv", "tx,ty,tz")}, {}, {});
  ASSERT_TRUE(results[0].refused.empty()) << results[0].refused[0].failure.fact();
  const std::vector<BatchItem> items{item("a.csv", "tx,ty,tz")};
  const Assembled one = assemble(items, results, {});
  ASSERT_GT(one.samples.rows(), 20);
  EXPECT_LT(one.samples.torque.col(0).minCoeff(), -4e-3);
  EXPECT_LT(off(one.samples, Vec3(0, 2e-3, 0)), 1e-12);
}

TEST_F(TorqueTest, repeats_are_pooled_and_turned_with_the_rig) {
  std::vector<BatchItem> items{item("a.csv", "tx,ty,tz"), item("b.csv", "tx,ty,tz")};
  BatchOptions options;
  options.motion =
      RigidMotion{Eigen::AngleAxisd(0.5, Vec3::UnitZ()).toRotationMatrix(), Vec3::Zero()};
  const Assembled both = assemble(items, run_batch(items, options, {}), options);
  EXPECT_EQ(both.failed(), 0u);
  EXPECT_EQ(both.samples.recordings.experiment, (std::vector<std::int32_t>{0, 0}));
  EXPECT_LT(off(both.samples, options.motion->rotation * Vec3(0, 2e-3, 0)), 1e-12);
}

TEST_F(TorqueTest, a_sensor_on_the_tool_reports_the_other_sign) {
  std::vector<BatchItem> items{item("a.csv", "tx,ty,tz")};
  items[0].read.columns.force = {"-fx", "-fy", "-fz"};  // so that the force pushes as before
  items[0].read.is_force_on_tool = true;
  const Assembled out = assemble(items, run_batch(items, {}, {}), {});
  ASSERT_EQ(out.failed(), 0u);
  EXPECT_LT(off(out.samples, Vec3(0, -2e-3, 0)), 1e-12);
}

TEST_F(TorqueTest, a_wrong_unit_is_named) {
  std::vector<BatchItem> items{item("a.csv", "tx [mm],ty,tz")};
  items[0].read.units.torque = "";
  const auto results = run_batch(items, {}, {});
  ASSERT_FALSE(results[0].refused.empty());
  EXPECT_NE(results[0].refused[0].failure.fact().find("which is no unit of torque"),
            std::string::npos)
      << results[0].refused[0].failure.fact();
  EXPECT_NE(results[0].refused[0].failure.remedy().find("units.torque"), std::string::npos);
}

}  // namespace
}  // namespace palpate::recordings
