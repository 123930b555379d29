#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "palpate.h"
#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {

inline palpate_pose pose_of(const Eigen::Isometry3d& frame) {
  const Eigen::Quaterniond q(frame.rotation());
  const Vec3 p = frame.translation();
  return {{p[0], p[1], p[2]}, {q.w(), q.x(), q.y(), q.z()}};
}

inline void expect_silence(const palpate_output& out, const char* what) {
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(out.force_on_tool_N[k], 0) << what;
    EXPECT_EQ(out.torque_on_tool_Nm[k], 0) << what;
  }
  for (double entry : out.stiffness_N_m) EXPECT_EQ(entry, 0) << what;
  EXPECT_EQ(out.triangle, -1) << what;
  EXPECT_EQ(out.state, PALPATE_AIR) << what;
}

}  // namespace palpate::test
