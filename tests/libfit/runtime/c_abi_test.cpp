// The C face: every error, poses of tool and body, torque, damper, tangent in the world's frame.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <set>

#include "tests/libfit/runtime/c_face.hpp"

extern "C" int palpate_c_walk(const void* bytes, uint64_t size, double* force_z_N);

namespace palpate::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

AssetBytes sphere_bytes() {
  return make_asset_bytes(sphere_model(0.03, 20, uniform(400, 300, 0.3)),
                          {.meta_json = "{\"a\":1}"});
}

struct Player {
  AssetBytes bytes = sphere_bytes();
  palpate_asset asset;
  palpate_contact contact;
  palpate_output out;

  explicit Player(const palpate_tool& tool) {
    EXPECT_EQ(palpate_open(&asset, bytes.data(), bytes.size()), PALPATE_OK);
    EXPECT_EQ(palpate_start(&contact, &tool), PALPATE_OK);
  }
  palpate_status tick(const palpate_input& in) {
    return palpate_tick(&asset, &contact, 1, &in, &out);
  }
  palpate_status tick(const Vec3& x) { return tick(palpate_input_at(x[0], x[1], x[2], 0.001)); }
};

TEST(c_abi, a_c_program_feels_the_force_of_the_curve) {
  const AssetBytes bytes = make_asset_bytes(plate_model(0.1, 20, uniform(400, 300, 0.3)), {});
  double force_z_N = 0;
  ASSERT_EQ(palpate_c_walk(bytes.data(), bytes.size(), &force_z_N), PALPATE_OK);
  EXPECT_NEAR(force_z_N, 400 * 0.003, 1e-5);
}

TEST(c_abi, tools_and_bodies_that_move_together_feel_what_they_feel_at_rest) {
  palpate_tool tool = palpate_ball(0.004);
  tool.centre_m[0][0] = 0.01, tool.centre_m[0][1] = -0.02, tool.centre_m[0][2] = 0.003;
  Player moving(tool);
  Player resting(palpate_ball(0.004));
  for (int i = 0; i < 3000; ++i) {
    const double t = i * 1e-3, r = 0.0335 + 0.001 * std::sin(5 * t);
    const Vec3 centre(r * std::sin(t) * 0.8, r * 0.6 * std::sin(t), r * std::cos(t));
    Eigen::Isometry3d body = Eigen::Isometry3d::Identity(), held = Eigen::Isometry3d::Identity();
    body.rotate(Eigen::AngleAxisd(2 * t, Vec3(1, 2, -1).normalized()));
    body.pretranslate(Vec3(std::sin(t), 0.5 * t, -0.2));
    held.rotate(body.rotation() * Eigen::AngleAxisd(0.7, Vec3(0, 1, 1).normalized()));
    const Vec3 offset = Vec3::Map(tool.centre_m[0]);
    held.pretranslate(body * centre - held.rotation() * offset);  // so that the ball is at centre
    palpate_input in = palpate_input_at(0, 0, 0, 0.001);
    in.tool = pose_of(held);
    in.body = pose_of(body);
    in.wants_tangent = 1;
    ASSERT_EQ(moving.tick(in), PALPATE_OK);
    palpate_input there = palpate_input_at(centre[0], centre[1], centre[2], 0.001);
    there.wants_tangent = 1;
    ASSERT_EQ(resting.tick(there), PALPATE_OK);
    const Vec3 f = Vec3::Map(resting.out.force_on_tool_N);
    const Vec3 turned = body.rotation() * f, moved_f = Vec3::Map(moving.out.force_on_tool_N);
    ASSERT_LT((moved_f - turned).norm(), 1e-9) << i;
    if (resting.out.state == PALPATE_AIR) continue;
    const Vec3 moved_c = Vec3::Map(moving.out.contact_m);
    ASSERT_LT((moved_c - body * Vec3(Vec3::Map(resting.out.contact_m))).norm(), 1e-11) << i;
    // The same line of action: torques about the centre agree once turned and moved.
    const Vec3 about_centre = Vec3::Map(resting.out.torque_on_tool_Nm);
    const Vec3 torque = Vec3::Map(moving.out.torque_on_tool_Nm);
    const Vec3 arm = body * centre - held.translation();
    ASSERT_LT((torque - body.rotation() * about_centre - arm.cross(moved_f)).norm(), 1e-10) << i;
    const Mat3 k =
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(resting.out.stiffness_N_m);
    const Mat3 world =
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(moving.out.stiffness_N_m);
    ASSERT_LT((world - body.rotation() * k * body.rotation().transpose()).norm(), 1e-4 * k.norm());
  }
  EXPECT_GT(resting.out.dissipated_J, 0);
}

TEST(c_abi, a_tip_feels_no_torque_about_itself_and_a_ball_that_of_its_lever) {
  Player tip(palpate_tip()), ball(palpate_ball(0.005));
  for (int i = 0; i <= 100; ++i) {
    tip.tick(Vec3(2e-5 * i, 0.0003, 0.0305 - 4e-5 * i));
    ball.tick(Vec3(2e-5 * i, 0.0003, 0.0355 - 4e-5 * i));
  }
  const Vec3 tip_torque = Vec3::Map(tip.out.torque_on_tool_Nm);
  EXPECT_LT(tip_torque.norm(), 1e-15);
  const Vec3 f = Vec3::Map(ball.out.force_on_tool_N), u = Vec3::Map(ball.out.normal);
  const Vec3 torque = Vec3::Map(ball.out.torque_on_tool_Nm);
  EXPECT_GT(torque.norm(), 1e-4);
  EXPECT_NEAR(torque.norm(), 0.005 * (f - u * u.dot(f)).norm(), 0.1 * torque.norm());
}

TEST(c_abi, a_damper_takes_energy_and_never_gives_or_pulls) {
  palpate_tool damped = palpate_tip();
  damped.damping_Ns_m = 5;
  damped.damper_depth_m = 0.001;
  Player with(damped), without(palpate_tip());
  double before_J = 0, work_J = 0, undamped_J = 0;
  Vec3 before_m(0, 0, 0.0305);
  with.tick(before_m);
  without.tick(before_m);
  for (int i = 1; i <= 4000; ++i) {
    const Vec3 x(0, 0, 0.029 + 0.0015 * std::cos(0.02 * i));
    ASSERT_EQ(with.tick(x), PALPATE_OK);
    ASSERT_EQ(without.tick(x), PALPATE_OK);
    ASSERT_GE(with.out.damped_J, before_J) << i;
    before_J = with.out.damped_J;
    const Vec3 on_body = -Vec3::Map(with.out.force_on_tool_N);
    const Vec3 elastic = -Vec3::Map(without.out.force_on_tool_N);
    work_J += on_body.dot(x - before_m);
    undamped_J += elastic.dot(x - before_m);
    ASSERT_LE(on_body[2], 1e-12) << i << ": the damper pulls";
    before_m = x;
  }
  EXPECT_GT(before_J, 1e-4);
  EXPECT_NEAR(work_J - undamped_J, before_J, 1e-9);
  palpate_input timeless = palpate_input_at(0, 0, 0.029, 0.001);
  timeless.dt_s = 0;
  EXPECT_EQ(with.tick(timeless), PALPATE_TIME_STEP_WRONG);
  expect_silence(with.out, "no time step");
  EXPECT_EQ(without.tick(timeless), PALPATE_OK);
}

TEST(c_abi, a_lateral_damper_takes_energy_across_the_normal) {
  palpate_tool damped = palpate_tip();
  damped.lateral_damping_Ns_m = 5;
  damped.damper_depth_m = 0.001;
  Player with(damped), without(palpate_tip());
  const Vec3 start(0, 0.0003, 0.0305);
  Vec3 before = start;
  with.tick(start), without.tick(start);
  double work_J = 0;
  for (int i = 1; i <= 400; ++i) {
    const Vec3 x(i < 100 ? 0 : 2e-4 * std::sin(0.05 * (i - 100)), 0.0003,
                 0.0305 - 2e-5 * std::min(i, 100));
    with.tick(x), without.tick(x);
    const Vec3 added = Vec3::Map(without.out.force_on_tool_N) - Vec3::Map(with.out.force_on_tool_N);
    const double step_J = added.dot(x - before);
    ASSERT_GE(step_J, -1e-15) << i;
    work_J += step_J;
    before = x;
  }
  EXPECT_GT(with.out.damped_J, 1e-6);
  EXPECT_NEAR(work_J, with.out.damped_J, 1e-9 * work_J);
}

TEST(c_abi, a_tool_of_many_newtons_is_capped_and_brought_up_slowly_and_says_so) {
  palpate_tool careful = palpate_tip();
  careful.max_force_N = 0.3;
  careful.ramp_s = 0.05;
  Player with(careful), without(palpate_tip());
  unsigned seen = 0;
  for (int i = 0; i <= 100; ++i) {
    const Vec3 x(0, 0.0003, 0.0305 - 4e-5 * i);
    with.tick(x), without.tick(x);
    const double whole = Vec3::Map(without.out.force_on_tool_N).norm(),
                 found = Vec3::Map(with.out.force_on_tool_N).norm();
    EXPECT_NEAR(found, std::min(0.3, whole * std::min(1.0, (i + 1) / 50.0)), 1e-9) << i;
    seen |= with.out.flags;
  }
  EXPECT_TRUE(seen & PALPATE_FLAG_RAMP);
  EXPECT_TRUE(with.out.flags & PALPATE_FLAG_CAPPED);
  EXPECT_EQ(with.out.stored_J, without.out.stored_J);
}

TEST(c_abi, touch_and_release_are_told_once_with_the_speed_and_where_the_force_acts) {
  Player player(palpate_tip());
  int touched = 0, released = 0;
  for (int i = 0; i <= 200; ++i) {
    player.tick(Vec3(0, 0.0003, 0.0305 - 4e-5 * (i < 100 ? i : 200 - i)));
    if (player.out.events & PALPATE_TOUCHED) {
      ++touched;
      EXPECT_NEAR(player.out.approach_m_s, 0.04, 1e-3);
    }
    released += (player.out.events & PALPATE_RELEASED) != 0;
    if (player.out.state == PALPATE_AIR) continue;
    const Vec3 c = Vec3::Map(player.out.contact_m), at = Vec3::Map(player.out.acts_at_m);
    EXPECT_LT((at - c - Vec3(Vec3::Map(player.out.deflection_m))).norm(), 1e-15);
  }
  EXPECT_EQ(touched, 1);
  EXPECT_EQ(released, 1);
}

TEST(c_abi, an_asset_says_what_it_can_do_and_shows_its_mesh_until_it_is_closed) {
  Player player(palpate_tip());
  palpate_info info;
  ASSERT_EQ(palpate_describe(&player.asset, &info), PALPATE_OK);
  EXPECT_STREQ(info.law, "separable");
  EXPECT_NEAR(info.range_m, 0.01, 1e-12);
  EXPECT_NE(info.checksum, 0U);
  EXPECT_EQ(info.has_guard, 1);
  palpate_mesh mesh;
  ASSERT_EQ(palpate_read_mesh(&player.asset, &mesh), PALPATE_OK);
  ASSERT_EQ(mesh.vertices, info.vertices);
  for (int v = 0; v < mesh.vertices; ++v) {
    Vec3 x = Vec3::Map(mesh.origin_m);
    for (int k = 0; k < 3; ++k) x[k] += double(mesh.vertex_m[3 * v + k]);
    EXPECT_NEAR(x.norm(), 0.03, 1e-8);
  }
  palpate_close(&player.asset);
  EXPECT_EQ(palpate_read_mesh(&player.asset, &mesh), PALPATE_ASSET_NOT_OPEN);
  EXPECT_EQ(player.tick(Vec3(0, 0, 0.03)), PALPATE_ASSET_NOT_OPEN);
}

TEST(c_abi, bytes_from_anywhere_open_once_copied_to_a_multiple_of_64) {
  Player player(palpate_tip());
  const auto size = static_cast<std::uint64_t>(player.bytes.size());
  std::vector<unsigned char> room(player.bytes.size() + 64);
  for (std::size_t skip = 0; skip <= 1; ++skip) {
    void* at = palpate_copy_aligned(room.data() + skip, size + 63, player.bytes.data(), size);
    ASSERT_NE(at, nullptr);
    palpate_asset asset;
    EXPECT_EQ(palpate_open(&asset, at, size), PALPATE_OK);
  }
  EXPECT_EQ(palpate_copy_aligned(room.data(), size - 1, player.bytes.data(), size), nullptr);
  EXPECT_EQ(palpate_copy_aligned(nullptr, size, player.bytes.data(), size), nullptr);
}

TEST(c_abi, a_program_with_the_header_of_another_engine_is_told_so) {
  EXPECT_EQ(palpate_header_fits(), PALPATE_OK);
  const std::array<std::uint32_t, 8> sizes = {
      sizeof(palpate_asset), sizeof(palpate_contact), sizeof(palpate_pose), sizeof(palpate_tool),
      sizeof(palpate_input), sizeof(palpate_output),  sizeof(palpate_info), sizeof(palpate_mesh)};
  EXPECT_EQ(palpate_sizes_fit(PALPATE_ABI, sizes.data()), PALPATE_OK);
  EXPECT_EQ(palpate_sizes_fit(PALPATE_ABI + 1, sizes.data()), PALPATE_HEADER_WRONG);
  EXPECT_EQ(palpate_sizes_fit(PALPATE_ABI, nullptr), PALPATE_NULL_ARGUMENT);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    auto other = sizes;
    other[i] += 8;
    EXPECT_EQ(palpate_sizes_fit(PALPATE_ABI, other.data()), PALPATE_HEADER_WRONG) << i;
  }
  palpate_tool newer = palpate_tip();  // of a header with one more number
  newer.reserved[0] = 1;
  palpate_contact contact;
  EXPECT_EQ(palpate_start(&contact, &newer), PALPATE_TOOL_WRONG);
}

TEST(c_abi, every_misuse_has_its_status_and_no_force) {
  Player player(palpate_tip());
  palpate_input in = palpate_input_at(0, 0, 0.031, 0.001);
  palpate_output& out = player.out;
  EXPECT_EQ(palpate_tick(nullptr, &player.contact, 1, &in, &out), PALPATE_NULL_ARGUMENT);
  expect_silence(out, "null asset");
  EXPECT_EQ(palpate_tick(&player.asset, nullptr, 1, &in, &out), PALPATE_NULL_ARGUMENT);
  EXPECT_EQ(palpate_tick(&player.asset, &player.contact, 1, nullptr, &out), PALPATE_NULL_ARGUMENT);
  EXPECT_EQ(palpate_tick(&player.asset, &player.contact, 1, &in, nullptr), PALPATE_NULL_ARGUMENT);
  palpate_asset closed{};
  EXPECT_EQ(palpate_tick(&closed, &player.contact, 1, &in, &out), PALPATE_ASSET_NOT_OPEN);
  palpate_contact raw{};
  EXPECT_EQ(palpate_tick(&player.asset, &raw, 1, &in, &out), PALPATE_NOT_STARTED);
  EXPECT_EQ(palpate_release(&raw), PALPATE_NOT_STARTED);
  EXPECT_EQ(palpate_release(nullptr), PALPATE_NULL_ARGUMENT);
  EXPECT_EQ(palpate_open(nullptr, player.bytes.data(), 64), PALPATE_NULL_ARGUMENT);
  EXPECT_EQ(palpate_open(&closed, player.bytes.data(), 64), PALPATE_BYTES_MISSING);
  EXPECT_EQ(palpate_open(&closed, player.bytes.data(), player.bytes.size() - 64),
            PALPATE_SIZE_WRONG);
  palpate_info info;
  EXPECT_EQ(palpate_describe(&closed, &info), PALPATE_ASSET_NOT_OPEN);
  EXPECT_EQ(palpate_describe(&player.asset, &info), PALPATE_OK);
  EXPECT_EQ(std::string(info.meta_json, info.meta_bytes), "{\"a\":1}");
  EXPECT_NEAR(info.box_max_m[2], 0.03, 1e-8);
  const auto tool = [](double palpate_tool::*field, double value) {
    palpate_tool made = palpate_tip();
    made.*field = value;
    return made;
  };
  palpate_tool off = palpate_tip();
  off.centre_m[0][0] = kNan;
  palpate_tool wide = palpate_ball(-1);
  for (const palpate_tool& bad :
       {off, wide, tool(&palpate_tool::damping_Ns_m, -1), tool(&palpate_tool::damping_Ns_m, 1),
        tool(&palpate_tool::lateral_damping_Ns_m, 2e4), tool(&palpate_tool::max_force_N, kNan),
        tool(&palpate_tool::ramp_s, -1)}) {
    EXPECT_EQ(palpate_start(&raw, &bad), PALPATE_TOOL_WRONG);
    EXPECT_EQ(palpate_tick(&player.asset, &raw, 1, &in, &out), PALPATE_NOT_STARTED);
  }
}

TEST(c_abi, bad_poses_are_refused_with_zero_force_and_contact_begins_anew) {
  Player player(palpate_tip());
  const auto press = [&] {
    for (int i = 0; i <= 30; ++i) player.tick(Vec3(0, 0.0003, 0.031 - 1e-4 * i));
    ASSERT_EQ(player.out.state, PALPATE_STICK);
  };
  for (int field = 0; field < 14; ++field)
    for (double bad : {kNan, 1e300 * 1e10, 3.0}) {
      if (bad == 3.0 && (field % 7) < 3) continue;  // a position may be 3
      press();
      palpate_input in = palpate_input_at(0, 0.0003, 0.028, 0.001);
      palpate_pose& pose = field < 7 ? in.tool : in.body;
      double* number =
          field % 7 < 3 ? &pose.position_m[field % 7] : &pose.orientation[field % 7 - 3];
      *number = bad;
      EXPECT_EQ(player.tick(in), PALPATE_POSE_WRONG) << field << ' ' << bad;
      expect_silence(player.out, "bad pose");
      player.tick(Vec3(0, 0.0003, 0.028));
      expect_silence(player.out, "inside after a bad pose");
      player.tick(Vec3(0, 0.0003, 0.031));
    }
}

TEST(c_abi, every_status_has_its_sentence) {
  std::set<std::string> seen;
  for (palpate_status status = 0; status <= PALPATE_REPLAY_DIFFERS; ++status) {
    if (status > PALPATE_VERTICES_WRONG && status < PALPATE_BYTES_MISSING) continue;
    const std::string text = palpate_sentence(status);
    EXPECT_NE(text, "Unknown status.") << status;
    EXPECT_TRUE(seen.insert(text).second) << status << ": " << text;
  }
  EXPECT_STREQ(palpate_sentence(-7), "Unknown status.");
  EXPECT_STREQ(palpate_sentence(16), "Unknown status.");
}

TEST(c_abi, a_copied_contact_moves_the_surface_and_every_misuse_has_its_status) {
  Player plain(palpate_tip());
  Model model = sphere_model(0.03, 20, uniform(400, 300, 0.3));
  make_shaped(model, 6, 2, 3);
  const AssetBytes bytes = make_asset_bytes(model, {});
  palpate_asset asset;
  ASSERT_EQ(palpate_open(&asset, bytes.data(), bytes.size()), PALPATE_OK);
  palpate_info info;
  palpate_describe(&plain.asset, &info);
  EXPECT_EQ(info.has_shape, 0);
  palpate_describe(&asset, &info);
  EXPECT_EQ(info.has_shape, 1);
  palpate_contact contact;
  const palpate_tool tip = palpate_tip();
  palpate_start(&contact, &tip);
  palpate_output out;
  for (int i = 0; i <= 30; ++i) {
    const palpate_input in = palpate_input_at(0, 0.0003, 0.031 - 1e-4 * i, 0.001);
    palpate_tick(&asset, &contact, 1, &in, &out);
  }
  const palpate_contact copied = contact;
  std::vector<float> moved(3 * static_cast<std::size_t>(info.vertices), 1);
  const auto are_zero = [&] {
    return std::all_of(moved.begin(), moved.end(), [](float x) { return x == 0; });
  };
  float* const to = moved.data();
  EXPECT_EQ(palpate_deform(&asset, &copied, 1, 0, info.vertices, to), PALPATE_OK);
  EXPECT_EQ(std::memcmp(&copied, &contact, sizeof copied), 0);
  const float deepest = *std::min_element(moved.begin(), moved.end());
  EXPECT_LT(deepest, -0.0008);
  EXPECT_GT(deepest, -0.003);
  EXPECT_EQ(palpate_deform(&asset, &copied, 1, 0, info.vertices, nullptr), PALPATE_NULL_ARGUMENT);
  for (const auto& [first, count] :
       {std::pair{-1, 2}, {0, -1}, {0, info.vertices + 1}, {info.vertices, 1}, {1, 1 << 30}}) {
    moved.assign(moved.size(), 1);
    EXPECT_EQ(palpate_deform(&asset, &copied, 1, first, count, to), PALPATE_VERTICES_WRONG)
        << first;
    EXPECT_EQ(moved[0], 1);
  }
  EXPECT_EQ(palpate_deform(nullptr, &copied, 1, 0, info.vertices, to), PALPATE_NULL_ARGUMENT);
  EXPECT_TRUE(are_zero());
  EXPECT_EQ(palpate_deform(&asset, &copied, 0, 0, info.vertices, to), PALPATE_COUNT_WRONG);
  const palpate_contact raw{};
  EXPECT_EQ(palpate_deform(&asset, &raw, 1, 0, info.vertices, to), PALPATE_NOT_STARTED);
  EXPECT_EQ(palpate_deform(&plain.asset, &copied, 1, 0, info.vertices, to), PALPATE_NO_SHAPE);
  EXPECT_TRUE(are_zero());
  palpate_close(&asset);
  EXPECT_EQ(palpate_deform(&asset, &copied, 1, 0, info.vertices, to), PALPATE_ASSET_NOT_OPEN);
}

}  // namespace
}  // namespace palpate::test
