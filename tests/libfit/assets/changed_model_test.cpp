#include "libfit/assets/changed_model.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "libfit/core/error.hpp"
#include "tests/libfit/runtime/hands.hpp"

namespace palpate::test {
namespace {

// A body that sways, couples, relaxes and softens, with a shown surface.
Model body_of_everything(unsigned seed) {
  Model model = testing_hands::swaying_body(true, 0.4, 5);
  model.probe = sphere_spec(testing_hands::kBallRadius_m, 0.4);
  model.curves.relaxation.share = Eigen::Vector2d(0.4, 0.2);
  model.curves.relaxation.time_s = Eigen::Vector2d(0.02, 0.3);
  model.curves.damage = {1.4, 0.05, 0.1, 0.006};
  model.curves.coupling = testing_hands::coupling_of(2e-4, 5e-5);
  make_shaped(model, 6, 3, seed);
  return model;
}

TEST(changed_model, forces_and_nothing_else_go_with_the_stiffness) {
  constexpr double kFactor = 1.7;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Model model = body_of_everything(seed);
    const Loaded before = load(model);
    change_model(model, {.stiffness = kFactor});
    const Loaded after = load(model);
    std::mt19937 random(seed);
    const Vec3 inward = -drawn_vector(random, 1).normalized(),
               along = inward.cross(drawn_vector(random, 1)).normalized();
    Tool soft(before.asset, testing_hands::kBallRadius_m, 1e-3),
        stiff(after.asset, testing_hands::kBallRadius_m, 1e-3);
    double largest_N = 0;
    for (int tick = 0; tick <= 300; ++tick) {  // presses 4 mm, slides 4 mm, comes out
      const double depth_m = 2e-5 * std::min({tick, 200, 320 - tick}) * 1.2 - 1e-3,
                   aside_m = 4e-5 * std::clamp(tick - 150, 0, 100);
      const Vec3 place =
          -inward * (0.03 + testing_hands::kBallRadius_m - depth_m) + along * aside_m;
      const Vec3 force_N = soft.tick(place), scaled_N = stiff.tick(place);
      largest_N = std::max(largest_N, force_N.norm());
      ASSERT_LE((scaled_N - kFactor * force_N).norm(), 2e-5 * largest_N)
          << "seed " << seed << ", tick " << tick;
      ASSERT_EQ(soft.out.state, stiff.out.state) << "seed " << seed << ", tick " << tick;
    }
    EXPECT_GT(largest_N, 0.05) << seed;
    stiff.tick(-inward * (0.03 + testing_hands::kBallRadius_m - 0.003));
    soft.tick(-inward * (0.03 + testing_hands::kBallRadius_m - 0.003));
    std::vector<float> of_soft(3 * before.asset.vertices), of_stiff(of_soft);
    for (auto [tool, moved] : {std::pair{&soft, &of_soft}, {&stiff, &of_stiff}})
      ASSERT_EQ(runtime::deform(tool->asset, tool->contact, tool->radius_m, 0, tool->asset.vertices,
                                moved->data()),
                Status::ok);
    for (std::size_t i = 0; i < of_soft.size(); ++i)
      ASSERT_NEAR(of_soft[i], of_stiff[i], 1e-7) << "seed " << seed;
  }
}

TEST(changed_model, a_slide_is_held_by_the_new_friction) {
  Model model = testing_hands::rings_body(false, 0.4);
  model.probe = sphere_spec(testing_hands::kBallRadius_m, 0.4);
  const auto sliding_N = [](const Model& of) {
    const Loaded loaded = load(of);
    Tool tool(loaded.asset, testing_hands::kBallRadius_m);
    const Vec3 above(0, 0, 0.005), deep(0, 0, 0.001);
    tool.go(above, deep, 2e-5);
    return tool.go(deep, deep + Vec3(0.012, 0, 0), 2e-5);
  };
  const Vec3 before = sliding_N(model);
  change_model(model, {.friction = 0.1});
  const Vec3 after = sliding_N(model);
  EXPECT_NEAR(after.x() / before.x(), 0.25, 1e-6);
  EXPECT_NEAR(after.z() / before.z(), 1, 1e-6);
  EXPECT_EQ(model.probe->friction, 0.1);
}

TEST(changed_model, a_recorded_press_is_met_within_what_its_noise_allows) {
  int inside = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, 0.02);
    Eigen::VectorXd answered(30), recorded(30);
    for (int i = 0; i < 30; ++i) {
      answered[i] = std::pow(i / 30.0, 1.5);
      recorded[i] = 1.3 * answered[i] + noise(random);
    }
    const StiffnessFit fit = fit_stiffness(answered, recorded);
    inside += std::abs(fit.factor - 1.3) < 2 * fit.deviation;
    EXPECT_LT(fit.misfit, 0.05) << seed;
  }
  EXPECT_GE(inside, 180);  // of 200, where Student's t with 29 degrees leaves out 11 on average
}

TEST(changed_model, changes_that_a_model_cannot_take_are_refused) {
  const auto refusal = [](Model model, const ModelChanges& changes) {
    try {
      change_model(model, changes);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  Model separable = sphere_model(0.03, 8, uniform(400, 300, 0.3));
  EXPECT_TRUE(refusal(separable, {.friction = 0.1}).starts_with("--friction: curves of the sep"));
  Model unknown = testing_hands::rings_body(false, 0.4);
  EXPECT_TRUE(refusal(unknown, {.friction = 0.1}).starts_with("--friction: the model was made"));
  EXPECT_TRUE(refusal(unknown, {.stiffness = 1e30}).starts_with("--scale-stiffness: \"normal\""));
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(3), some = Eigen::VectorXd::Ones(3);
  EXPECT_THROW(fit_stiffness(none, some), Error);
  EXPECT_THROW(fit_stiffness(some, -some), Error);
}

}  // namespace
}  // namespace palpate::test
