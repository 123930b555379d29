// Contact models against exact solutions, and their fits to noisy presses.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "libfit/recordings/indentation/fit_model.hpp"
#include "tests/support/shared_data.hpp"

namespace palpate::recordings {
namespace {

// A press that the model of this name speaks of.
Indentation press_of(std::string_view name) {
  Indentation p{Tip::sphere, 5e-6, 0.6, 0, 0.5};
  if (name.starts_with("layer")) p.thickness_m = 8e-6;
  if (name == "punch") p.tip = Tip::flat;
  if (name == "cone") p.tip = Tip::cone;
  if (name == "pyramid") p.tip = Tip::pyramid;
  if (name == "pyramid-3") p.tip = Tip::pyramid_3;
  return p;
}

double half_space_factor(const Indentation& p) { return 1 / (1 - p.poisson * p.poisson); }

TEST(indentation_models, slopes_are_derivatives_of_areas) {
  for (const IndentationModel& model : indentation_models()) {
    if (!model.law) continue;
    const ModelLaw law = model.law(press_of(model.name));
    for (const double d : {0.02e-6, 0.3e-6, 1e-6, 2.5e-6}) {
      const double h = 1e-4 * d;
      const double difference = (law(d + h).area_m2 - law(d - h).area_m2) / (2 * h);
      EXPECT_NEAR(law(d).slope_m, difference, 2e-5 * difference) << model.name << ' ' << d;
    }
    EXPECT_EQ(law(0).area_m2, 0) << model.name;
  }
}

nlohmann::json cases() {
  std::ifstream file(testing_support::shared_data("cases/cases.json"));
  nlohmann::json all = nlohmann::json::parse(file);
  return all.is_object() && all.contains("cases") ? all.at("cases") : all;
}

TEST(indentation_models, the_sphere_is_sneddons) {
  PALPATE_NEEDS_DATA("cases/cases.json");
  int found = 0;
  for (const auto& c : cases()) {
    if (!c.at("id").get<std::string>().starts_with("HALFSPACE/sphere")) continue;
    const auto& in = c.at("inputs");
    const Indentation p{Tip::sphere, in.at("R"), 0, 0, in.at("nu")};
    const double E = in.at("E"), d = in.at("depth");
    const double factor = E * half_space_factor(p);
    const double exact = c.at("expected").at("F_sneddon_exact_sphere");
    const double hertz = c.at("expected").at("F_hertz");
    EXPECT_NEAR(factor * indentation_model_named("sphere")->law(p)(d).area_m2, exact, 1e-9 * exact);
    EXPECT_NEAR(factor * indentation_model_named("hertz")->law(p)(d).area_m2, hertz, 1e-9 * hertz);
    ++found;
  }
  EXPECT_GE(found, 10);
}

TEST(indentation_models, the_layer_is_the_exact_one_of_the_cases) {
  PALPATE_NEEDS_DATA("cases/cases.json");
  int found = 0;
  double largest = 0;
  for (const auto& c : cases()) {
    if (!c.at("id").get<std::string>().starts_with("SPH/linear")) continue;
    const auto& in = c.at("inputs");
    const Indentation p{Tip::sphere, in.at("R"), 0, in.at("h"), in.at("nu")};
    const double E = in.at("E"), d = in.at("depth");
    const double exact = c.at("expected").at("F_sphere_layer");
    const double off =
        E * half_space_factor(p) * indentation_model_named("layer")->law(p)(d).area_m2 / exact - 1;
    largest = std::max(largest, std::abs(off));
    ++found;
  }
  EXPECT_GE(found, 30);
  EXPECT_LT(largest, 2e-5);
}

// A ball so large that it is a paraboloid.
TEST(indentation_models, polynomials_of_layers_hold_to_one_percent_as_far_as_they_say) {
  for (const std::string_view name : {"layer-garcia", "layer-dimitriadis"}) {
    const Indentation p{Tip::sphere, 1, 0, 1e-3, 0.5};
    const auto* model = indentation_model_named(name);
    const ModelLaw law = model->law(p), exact = indentation_model_named("layer")->law(p);
    const double most = model->valid_to_m(p);
    for (const double share : {0.1, 0.5, 1.})
      EXPECT_NEAR(law(share * most).area_m2 / exact(share * most).area_m2, 1, 0.01) << name;
    EXPECT_GT(std::abs(law(4 * most).area_m2 / exact(4 * most).area_m2 - 1), 0.01) << name;
  }
}

// F of a model with E = 2 kPa to 2.5 um of depth after 4 um of free travel, noise of 1 %.
struct Recorded {
  Eigen::VectorXd travel_m, push_N;
};
constexpr double kYoung_Pa = 2000, kContact_m = 4e-6, kBaseline_N = 3e-10;
Recorded record(const ModelLaw& law, const Indentation& p, double noise_share, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> unit(0, 1);
  Recorded out{Eigen::VectorXd::LinSpaced(500, 0, 6.5e-6), Eigen::VectorXd(500)};
  const double factor = kYoung_Pa * half_space_factor(p);
  const double full_N = factor * law(2.5e-6).area_m2;
  for (Eigen::Index i = 0; i < 500; ++i)
    out.push_N[i] = kBaseline_N + noise_share * full_N * unit(random) +
                    factor * law(std::max(0., out.travel_m[i] - kContact_m)).area_m2;
  return out;
}

class EveryModel : public testing::TestWithParam<IndentationModel> {};
INSTANTIATE_TEST_SUITE_P(Models, EveryModel,
                         testing::ValuesIn(indentation_models().begin(),
                                           std::prev(indentation_models().end())),
                         [](const auto& row) {
                           return testing_support::file_as_name(std::string(row.param.name));
                         });

TEST_P(EveryModel, has_its_modulus_within_95_percent_in_90_of_100_noisy_presses) {
  const IndentationModel& model = GetParam();
  const Indentation p = press_of(model.name);
  const ModelLaw law = model.law(p);
  int young = 0, contact = 0, all = 0;
  double spread = 0, stated = 0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const Recorded r = record(law, p, 0.01, seed);
    const auto fits = fit_models(r.travel_m, r.push_N, p, {std::string(model.name)}, {});
    if (fits.empty()) continue;
    const ModelFit& fit = fits[0];
    ++all;
    young += std::abs(fit.young_Pa - kYoung_Pa) < 1.96 * fit.young_deviation_Pa;
    contact += std::abs(fit.contact_m - kContact_m) < 1.96 * fit.contact_deviation_m;
    spread += std::pow(fit.young_Pa / kYoung_Pa - 1, 2);
    stated += std::pow(fit.young_deviation_Pa / kYoung_Pa, 2);
  }
  EXPECT_EQ(all, 100);
  EXPECT_GE(young, 90);
  EXPECT_GE(contact, 90);
  EXPECT_LT(std::sqrt(stated), 1.5 * std::sqrt(spread));
  RecordProperty("young", young), RecordProperty("contact", contact);
  std::printf("  %s: E %d, contact %d of 100; error %.2f %%, stated %.2f %%\n",
              std::string(model.name).c_str(), young, contact, std::sqrt(100 * spread),
              std::sqrt(100 * stated));
}

TEST_P(EveryModel, is_exact_without_noise) {
  const IndentationModel& model = GetParam();
  const Indentation p = press_of(model.name);
  const Recorded r = record(model.law(p), p, 0, 1);
  const auto fits = fit_models(r.travel_m, r.push_N, p, {std::string(model.name)}, {});
  ASSERT_EQ(fits.size(), 1u);
  EXPECT_NEAR(fits[0].young_Pa, kYoung_Pa, 1e-4 * kYoung_Pa);
  EXPECT_NEAR(fits[0].contact_m, kContact_m, 1e-10);
  EXPECT_NEAR(fits[0].baseline_N, kBaseline_N, 1e-4 * fits[0].force_N);
  EXPECT_NEAR(model_push_N(fits[0], p, Eigen::VectorXd::Constant(1, 6e-6))[0],
              kBaseline_N + kYoung_Pa * half_space_factor(p) * model.law(p)(2e-6).area_m2,
              1e-4 * fits[0].force_N);
}

TEST(fit_models, evidence_finds_the_layer_and_the_half_space) {
  Indentation p = press_of("layer");
  for (const std::string_view name : {"layer", "sphere"}) {
    const Recorded r = record(indentation_model_named(name)->law(p), p, 1e-3, 5);
    const auto fits = fit_models(r.travel_m, r.push_N, p, {}, {});
    const auto best = best_model(fits);
    ASSERT_TRUE(best);
    EXPECT_EQ(fits[*best].model->name, name);
    EXPECT_EQ(fits.size(), 6u);  // the others are listed
    EXPECT_NEAR(fits[*best].young_Pa, kYoung_Pa, 0.02 * kYoung_Pa);
  }
}

// The paraboloid was taken for a ball in 4 of 50 presses to half its radius, and no band held that.
TEST(fit_models, the_band_of_a_modulus_holds_the_choice_of_the_model) {
  Indentation p = press_of("sphere");
  const ModelLaw law = indentation_model_named("sphere")->law(p);
  constexpr int kSeeds = 100;
  for (const double slowness : {0., 0.6}) {  // of noise from one reading to the next
    int within = 0, spheres = 0;
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
      Recorded r = record(law, p, 0, seed);
      std::mt19937 random(seed);
      std::normal_distribution<double> unit(0, 0.02 * r.push_N.maxCoeff());
      double slow_N = 0;
      for (double& push_N : r.push_N) {
        slow_N = slowness * slow_N + unit(random) * std::sqrt(1 - slowness * slowness);
        push_N += slow_N;
      }
      const auto fits = fit_models(r.travel_m, r.push_N, p, {}, {});
      const auto best = best_model(fits);
      ASSERT_TRUE(best) << "seed " << seed;
      spheres += fits[*best].model->name == "sphere";
      within +=
          std::abs(fits[*best].young_Pa - kYoung_Pa) < 1.96 * chosen_deviation_Pa(fits, *best);
    }
    EXPECT_EQ(spheres, kSeeds);
    EXPECT_GE(within, 93) << "of 100, noise that goes on by " << slowness;
    RecordProperty("within", within);
  }
}

TEST(fit_models, what_goes_with_depth_in_what_is_left_is_said) {
  const Indentation p = press_of("sphere");
  const ModelLaw ball = indentation_model_named("sphere")->law(p);
  Indentation on_layer = press_of("layer");
  on_layer.thickness_m = 15e-6;
  const ModelLaw layer = indentation_model_named("layer")->law(on_layer);
  int told = 0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const Recorded good = record(ball, p, 0.01, seed);
    told += fit_models(good.travel_m, good.push_N, p, {"sphere"}, {})[0].has_pattern;

    Recorded step = good, soft = good;
    const double most_N = good.push_N.maxCoeff();
    for (Eigen::Index i = 0; i < good.push_N.size(); ++i) {
      step.push_N[i] += good.travel_m[i] > 5.3e-6 ? 0.06 * most_N : 0;
      soft.push_N[i] = 0.8 * most_N * std::tanh(good.push_N[i] / (0.8 * most_N));
    }
    const Recorded stiff = record(layer, on_layer, 0.002, seed);
    for (const auto& [name, r] :
         {std::pair{"step", step}, {"soft saturation", soft}, {"stiff layer below", stiff}}) {
      const ModelFit fit = fit_models(r.travel_m, r.push_N, p, {"sphere"}, {})[0];
      EXPECT_FALSE(fit.remark.empty())
          << name << ", seed " << seed << ": E " << fit.young_Pa << " +- " << fit.young_deviation_Pa
          << ", misfit " << fit.misfit_N / fit.force_N;
    }
  }
  EXPECT_LE(told, 3) << "of 100 presses that the model describes";
}

TEST(fit_models, a_model_that_cannot_describe_the_curve_says_so_and_the_exponent_says_why) {
  const Indentation p = press_of("cone");
  const Recorded r = record([](double d) { return ModelForce{std::pow(d, 4), 0}; }, p, 1e-3, 5);
  const auto fits = fit_models(r.travel_m, r.push_N, p, {}, {.contact_m = kContact_m});
  ASSERT_EQ(fits.size(), 2u);
  EXPECT_NE(fits[0].remark.find("does not describe the curve"), std::string::npos);
  EXPECT_NEAR(fits[1].exponent, 4, 0.05);
  EXPECT_TRUE(fits[1].remark.empty()) << fits[1].remark;
  EXPECT_EQ(*best_model(fits), 0u);
}

TEST(fit_models, a_small_press_after_long_travel_has_its_modulus) {
  const Indentation p = press_of("hertz");
  const ModelLaw law = indentation_model_named("hertz")->law(p);
  Recorded r{Eigen::VectorXd::LinSpaced(10000, 0, 50e-6), Eigen::VectorXd(10000)};
  for (const double depth_m : {0.2e-6, 1e-6, 20e-6}) {
    std::mt19937 random(3);
    std::normal_distribution<double> unit(0, 1);
    const double factor = kYoung_Pa * half_space_factor(p);
    for (Eigen::Index i = 0; i < 10000; ++i)
      r.push_N[i] = factor * law(std::max(0., r.travel_m[i] - 50e-6 + depth_m)).area_m2 +
                    5e-3 * factor * law(depth_m).area_m2 * unit(random);
    const auto fits = fit_models(r.travel_m, r.push_N, p, {"hertz"}, {.has_slope = true});
    ASSERT_EQ(fits.size(), 1u);
    EXPECT_NEAR(fits[0].young_Pa, kYoung_Pa, 3 * fits[0].young_deviation_Pa) << depth_m;
    EXPECT_LT(fits[0].young_deviation_Pa, 0.1 * kYoung_Pa) << depth_m;
  }
}

}  // namespace
}  // namespace palpate::recordings
