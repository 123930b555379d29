// The C face of a tool that turns.

#include "tests/libfit/runtime/c_face.hpp"

namespace palpate::test {
namespace {

// A ball that leans and rolls beside a ball that does not: the same force where no lean matters,
// and torque about the pose's position, on a body that stands anywhere.
TEST(c_abi, a_tool_that_turns_has_force_and_torque_in_the_world) {
  Model model = plate_model(0.08, 16, uniform(400, 300, 0.3));
  make_rings(model, 1, 0, [](const Vec3&) { return 1; });
  model.probe = sphere_spec(0.004, 0.3);
  LeanCurves leans;
  leans.sine = {0.5};
  for (const double stiffness : {1.0, 1.5, 0.8, 0.8})
    leans.node.push_back({stiffness * model.curves.control[0],
                          model.curves.control[runtime::kSide2],
                          model.curves.control[runtime::kSide3]});
  const AssetBytes bytes = make_asset_bytes(model, {.leans = leans});
  palpate_asset asset;
  ASSERT_EQ(palpate_open(&asset, bytes.data(), bytes.size()), PALPATE_OK);
  palpate_info info;
  palpate_describe(&asset, &info);
  EXPECT_EQ(info.tilts, 1);
  palpate_tool tool = palpate_ball(0.004);
  tool.offset_m[2] = -0.05;  // the pose is the handle's
  palpate_turning here, there;
  ASSERT_EQ(palpate_turning_start(&here, &tool), PALPATE_OK);
  ASSERT_EQ(palpate_turning_start(&there, &tool), PALPATE_OK);
  Eigen::Isometry3d body = Eigen::Isometry3d::Identity();
  body.rotate(Eigen::AngleAxisd(1.1, Vec3(1, -2, 0.5).normalized()));
  body.pretranslate(Vec3(0.3, -0.2, 0.1));
  palpate_output out, moved;
  for (int i = 0; i <= 400; ++i) {
    Eigen::Isometry3d end = Eigen::Isometry3d::Identity();
    end.rotate(Eigen::AngleAxisd(0.3 + 0.001 * i, Vec3(0.2, 1, 0.1).normalized()));
    end.pretranslate(Vec3(0.001 + 2e-6 * i, 0.002, 0.0045 - 6e-6 * i));
    const Eigen::Isometry3d handle = end * Eigen::Translation3d(0, 0, 0.05);
    palpate_input in = palpate_input_at(0, 0, 0);
    in.tool = pose_of(handle);
    ASSERT_EQ(palpate_turning_tick(&asset, &here, &in, &out), PALPATE_OK);
    in.tool = pose_of(body * handle);
    in.body = pose_of(body);
    ASSERT_EQ(palpate_turning_tick(&asset, &there, &in, &moved), PALPATE_OK);
    const Vec3 force = Vec3::Map(out.force_on_tool_N), torque = Vec3::Map(out.torque_on_tool_Nm);
    EXPECT_LT((body.linear() * force - Vec3::Map(moved.force_on_tool_N)).norm(), 1e-9);
    EXPECT_LT((body.linear() * torque - Vec3::Map(moved.torque_on_tool_Nm)).norm(), 1e-9);
    EXPECT_NEAR(out.stored_J, moved.stored_J, 1e-12);
    if (i < 400) continue;
    EXPECT_GT(force.z(), 0.03);
    const Vec3 lever = end.translation() - handle.translation();
    EXPECT_GT((torque - lever.cross(force)).norm(), 1e-6);  // the lean's and friction's
  }
  const palpate_turning saved = here;
  palpate_input in = palpate_input_at(0, 0, 0);
  in.tool.orientation[0] = 0.5;
  EXPECT_EQ(palpate_turning_tick(&asset, &here, &in, &out), PALPATE_POSE_WRONG);
  expect_silence(out, "pose");
  here = saved;
  EXPECT_EQ(palpate_turning_release(&here), PALPATE_OK);
  EXPECT_EQ(palpate_turning_tick(&asset, nullptr, &in, &out), PALPATE_NULL_ARGUMENT);
  palpate_turning raw{};
  EXPECT_EQ(palpate_turning_tick(&asset, &raw, &in, &out), PALPATE_NOT_STARTED);
  EXPECT_EQ(palpate_turning_release(&raw), PALPATE_NOT_STARTED);
  palpate_tool other = palpate_ball(0.005);
  ASSERT_EQ(palpate_turning_start(&here, &other), PALPATE_OK);
  in = palpate_input_at(0, 0, 0.1);
  EXPECT_EQ(palpate_turning_tick(&asset, &here, &in, &out), PALPATE_TOOL_WRONG);
  expect_silence(out, "another ball");
  other.damping_Ns_m = 1;
  other.damper_depth_m = 0.001;
  EXPECT_EQ(palpate_turning_start(&here, &other), PALPATE_TOOL_WRONG);
  const palpate_tool tip = palpate_tip();
  EXPECT_EQ(palpate_turning_start(&here, &tip), PALPATE_TOOL_WRONG);
}

}  // namespace
}  // namespace palpate::test
