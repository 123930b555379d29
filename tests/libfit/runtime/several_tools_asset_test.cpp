// How tools feel each other, in an asset and through the C interface.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "libfit/core/error.hpp"
#include "libfit/runtime/palpate.h"
#include "tests/libfit/runtime/hands.hpp"

namespace palpate::test {
namespace {

using namespace testing_hands;

TEST(SeveralTools, an_asset_says_how_they_feel_each_other) {
  Model model = rings_body(false, 1);
  const AssetBytes plain = make_asset_bytes(model, {});
  model.curves.coupling = coupling_of(0.004, 0.002);
  const AssetBytes bytes = make_asset_bytes(model, {});
  EXPECT_EQ(bytes.size(), plain.size() + sizeof(runtime::CouplingBlock));
  Status status;
  const auto asset = Asset::open(bytes.data(), bytes.size(), &status);
  ASSERT_EQ(status, Status::ok);
  ASSERT_NE(asset.coupling, nullptr);
  EXPECT_EQ(0, std::memcmp(asset.coupling, &model.curves.coupling, sizeof(CouplingView)));
  EXPECT_EQ(Asset::open(plain.data(), plain.size(), &status).coupling, nullptr);
  // Softer than the contacts themselves the joint energy need not be convex: they bear a share.
  model.curves.coupling = coupling_of(0.012);
  const AssetBytes strong = make_asset_bytes(model, {});
  const auto soft = Asset::open(strong.data(), strong.size(), &status);
  ASSERT_EQ(status, Status::ok);
  const double middle[3] = {1.0 / 3, 1.0 / 3, 1.0 / 3};
  int shared = 0;
  for (int t = 0; t < soft.triangles; ++t) {
    const runtime::ContactStiffness k = runtime::stiffness_at_end(soft, t, middle);
    const double share = runtime::coupling_share(soft, *soft.coupling, t, middle);
    const double borne =
        share * share * runtime::coupling_excess(*soft.coupling, k.along_N_m, k.across_N_m);
    EXPECT_LE(borne, 1 + 1e-12);
    EXPECT_TRUE(share == 1 || std::abs(borne - 1) < 1e-12) << borne;
    shared += share < 1;
    EXPECT_EQ(runtime::coupling_share(asset, *asset.coupling, t, middle), 1);
  }
  EXPECT_GT(shared, 0);
  model.curves.coupling = coupling_of(-0.001);
  EXPECT_THROW(make_asset_bytes(model, {}), Error);
}

TEST(SeveralTools, in_c_are_the_same) {
  Model model = rings_body(false, 1);
  model.curves.coupling = coupling_of(0.004, 0.002);
  const AssetBytes bytes = make_asset_bytes(model, {});
  palpate_asset asset;
  ASSERT_EQ(palpate_open(&asset, bytes.data(), bytes.size()), PALPATE_OK);
  palpate_info info;
  palpate_describe(&asset, &info);
  EXPECT_EQ(info.couples, 1);
  const palpate_tool ball = palpate_ball(kBallRadius_m);
  std::vector<palpate_contact> contacts(9);
  palpate_start(&contacts[0], &ball);
  palpate_input in[9];
  palpate_output out[9];
  EXPECT_EQ(palpate_tick(&asset, contacts.data(), 2, in, out), PALPATE_NOT_STARTED);
  palpate_start(&contacts[1], &ball);
  Hands hands(model, model.curves.coupling, 2);
  for (int k = 0; k < 200; ++k) {
    const double z = kBallRadius_m + 5e-4 - 2e-5 * k;
    in[0] = palpate_input_at(-0.006 + 2.5e-5 * k, 0, z, 0.001);
    in[1] = palpate_input_at(0.006, 1e-5 * k, z, 0.001);
    ASSERT_EQ(palpate_tick(&asset, contacts.data(), 2, in, out), PALPATE_OK);
    hands.tick({{-0.006 + 2.5e-5 * k, 0, z}, {0.006, 1e-5 * k, z}});
    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_EQ(0, std::memcmp(out[i].force_on_tool_N, hands.tool[i].out.force_on_tool_N, 24));
  }
  EXPECT_GT(out[0].force_on_tool_N[2], 0.05);
  in[1].tool.orientation[0] = 0;
  EXPECT_EQ(palpate_tick(&asset, contacts.data(), 2, in, out), PALPATE_POSE_WRONG);
  EXPECT_EQ(out[0].status, PALPATE_OK);
  EXPECT_EQ(out[1].force_on_tool_N[2], 0);
  std::vector<palpate_output> nine(9, out[0]);
  EXPECT_EQ(palpate_tick(&asset, contacts.data(), 9, in, nine.data()), PALPATE_COUNT_WRONG);
  for (const palpate_output& stale : nine) expect_silence(stale, "count");
  EXPECT_EQ(palpate_tick(&asset, contacts.data(), 0, in, out), PALPATE_COUNT_WRONG);
  palpate_tool five = ball;
  five.balls = 5;
  for (double& radius_m : five.radius_m) radius_m = kBallRadius_m;
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(palpate_start(&contacts[i], &five), PALPATE_OK);
  EXPECT_EQ(palpate_tick(&asset, contacts.data(), 2, in, out), PALPATE_COUNT_WRONG);
  EXPECT_NE(std::string(palpate_sentence(PALPATE_COUNT_WRONG)), "Unknown status.");
}

}  // namespace
}  // namespace palpate::test
