#include "libfem/calibrate/identify.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/libfem/calibrate/region_holds.hpp"

namespace palpate::fem {
namespace {

constexpr double kPoissonRatio = 0.4999;

// Nominal stresses [Pa] of an incompressible body pulled to `longest` along one axis, then along
// two: 2 (l - l^-2) (W1 + W2/l) and 2 (l - l^-5) (W1 + W2 l^2) with the derivatives of W by the
// invariants, and Ogden's sum of powers. Source: Treloar, The Physics of Rubber Elasticity, 5
// and 11.
Eigen::VectorXd pulled(const MaterialParameters& material, double longest) {
  const std::vector<double>& c = material.values;
  Eigen::VectorXd out(40);
  for (Eigen::Index i = 0; i < out.size(); ++i) {
    const bool is_one = i < 20;
    const double l = 1.02 + (longest - 1.02) * static_cast<double>(i % 20) / 19,
                 side = is_one ? 1 / std::sqrt(l) : 1 / (l * l);
    if (material.law == "ogden") {
      out[i] = c[0] * (std::pow(l, c[1]) - std::pow(side, c[1])) / l;
      continue;
    }
    const double x = (is_one ? l * l + 2 * side * side : 2 * l * l + side * side) - 3;
    double by_first = c[0] / 6, by_second = 0;
    if (material.law == "mooney-rivlin") by_first = c[0], by_second = c[1];
    if (material.law == "yeoh") by_first = c[0] + 2 * c[1] * x + 3 * c[2] * x * x;
    if (material.law == "fung") by_first = c[0] / 2 * std::exp(c[1] * x);
    out[i] = 2 * (l - side * side / l) * (by_first + by_second * (is_one ? side * side : l * l));
  }
  return out;
}

Observations observe(const Eigen::VectorXd& truth, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, noise * truth.lpNorm<Eigen::Infinity>());
  Observations out;
  out.value = truth.unaryExpr([&](double v) { return v + normal(random); });
  out.deviation = Eigen::VectorXd::Constant(truth.size(), std::max(normal.stddev(), 1e-9));
  out.group.assign(static_cast<std::size_t>(truth.size()), 0);
  return out;
}

Identification find(const MaterialParameters& start, const Observations& observed, double longest,
                    IdentifyOptions options = {}) {
  if (options.free.empty()) options.free = identifiable(start);
  return identify(
      start, observed,
      [&](const std::vector<MaterialParameters>& materials) {
        std::vector<Eigen::VectorXd> out;
        for (const MaterialParameters& material : materials)
          out.push_back(pulled(material, longest));
        return out;
      },
      options);
}

// From a start that is wrong a thousand times over.
TEST(Identify, finds_the_parameters_of_exact_tests_of_every_law) {
  const double none = NAN;
  for (const auto& [truth, start] : std::vector<std::pair<MaterialParameters, MaterialParameters>>{
           {{"neo-hookean", {5e3, kPoissonRatio}}, {"neo-hookean", {1, kPoissonRatio}}},
           {{"mooney-rivlin", {2e3, 400, kPoissonRatio, none}},
            {"mooney-rivlin", {1, 1, kPoissonRatio, none}}},
           {{"yeoh", {2e3, -60, 20, kPoissonRatio, none}},
            {"yeoh", {1, 0, 0, kPoissonRatio, none}}},
           {{"ogden", {1e3, 3, none, none, none, none, kPoissonRatio, none}},
            {"ogden", {1, 1, none, none, none, none, kPoissonRatio, none}}},
           {{"fung", {1e3, 0.4, kPoissonRatio, none}}, {"fung", {1, 1, kPoissonRatio, none}}}}) {
    SCOPED_TRACE(truth.law);
    const Identification found = find(start, observe(pulled(truth, 2), 0, 1), 2);
    EXPECT_TRUE(found.is_converged);
    for (const std::size_t i : found.free)
      EXPECT_NEAR(found.material.values[i], truth.values[i], 1e-3 * std::abs(truth.values[i]));
  }
}

TEST(Identify, holds_the_truth_in_its_region_in_95_of_100_noisy_trials) {
  const double none = NAN;
  for (const MaterialParameters& truth :
       {MaterialParameters{"mooney-rivlin", {2e3, 400, kPoissonRatio, none}},
        MaterialParameters{"yeoh", {2e3, 300, 100, kPoissonRatio, none}},
        MaterialParameters{"fung", {1e3, 0.6, kPoissonRatio, none}}}) {
    const Eigen::VectorXd exact = pulled(truth, 1.6);
    for (const bool is_stated : {true, false}) {
      int held = 0;
      for (unsigned seed = 1; seed <= 100; ++seed) {
        Observations observed = observe(exact, 0.02, seed);
        if (!is_stated) observed.deviation.setConstant(NAN);
        const Identification found = find(truth, observed, 1.6);
        Eigen::VectorXd values(std::ssize(found.free));
        for (Eigen::Index k = 0; k < values.size(); ++k)
          values[k] = truth.values[found.free[static_cast<std::size_t>(k)]];
        held += region_holds(found, values);
      }
      RecordProperty(truth.law + (is_stated ? "_stated" : "_unstated"), held);
      EXPECT_GE(held, 90) << truth.law << (is_stated ? "" : ", deviations not stated");
      EXPECT_LE(held, 99) << truth.law << ": a region that always holds says nothing";
    }
  }
}

// Of a sheet whose width is held the stress is 2 (c10 + c01) (l - l^-3).
TEST(Identify, says_that_parameters_are_not_told_apart_which_only_add) {
  const Eigen::ArrayXd l = Eigen::ArrayXd::LinSpaced(20, 1.02, 1.4);
  const auto sheet = [&](const MaterialParameters& m) {
    return Eigen::VectorXd(2 * (m.values[0] + m.values[1]) * (l - l.pow(-3)));
  };
  const MaterialParameters truth{"mooney-rivlin", {2e3, 400, kPoissonRatio, NAN}};
  const Identification found = identify(truth, observe(sheet(truth), 0.02, 3),
                                        [&](const std::vector<MaterialParameters>& materials) {
                                          std::vector<Eigen::VectorXd> out;
                                          for (const MaterialParameters& m : materials)
                                            out.push_back(sheet(m));
                                          return out;
                                        },
                                        {.free = {0, 1}});
  EXPECT_FALSE(found.are_told_apart);
  EXPECT_LT(found.correlation(0, 1), -0.99);
}

// A law too poor for the rows: neighbours err together, and that widens the region.
TEST(Identify, widens_the_region_where_the_law_does_not_follow_the_rows) {
  const Eigen::VectorXd exact = pulled({"yeoh", {2e3, 300, 100, kPoissonRatio, NAN}}, 2.5);
  const Identification found =
      find({"neo-hookean", {1e3, kPoissonRatio}}, observe(exact, 1e-3, 1), 2.5);
  EXPECT_GT(found.misfit, 10);
  EXPECT_GT(found.rows_each, 3);
  EXPECT_GT(found.deviation(0), 0.05 * found.material.values[0]);
}

TEST(Identify, keeps_what_is_not_free_and_an_error_that_all_rows_share_in_the_deviation) {
  const MaterialParameters truth{"mooney-rivlin", {2e3, 400, kPoissonRatio, NAN}};
  const Observations observed = observe(pulled(truth, 1.5), 0.01, 5);
  const Identification found = find(truth, observed, 1.5, {.free = {0}});
  EXPECT_EQ(found.material.values[1], 400);
  const Identification shared = find(truth, observed, 1.5, {.free = {0, 1}, .common_error = 0.03});
  // Moduli share it: the error of a common factor is at least its own.
  for (const Eigen::Index k : {0, 1})
    EXPECT_GT(shared.deviation(k), 0.03 * shared.material.values[static_cast<std::size_t>(k)]);
}

constexpr double kModulus_Pa = 5e3;

Eigen::VectorXd press_depth_m() { return Eigen::VectorXd::LinSpaced(20, 2e-4, 4e-3); }

Eigen::VectorXd press_N(double modulus_Pa, double shift_m) {
  return 0.1 * modulus_Pa * (press_depth_m().array() + shift_m).max(0.0).pow(1.5);
}

// Of contacts: what they are off by, and the deviation that is said of them.
struct ContactErrors {
  double mean_m = 0, scatter_m = 0, stated_m = 0;
};

// Three presses with a noise of 1 %.
Observations three_presses(unsigned seed, const ContactErrors& contact) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const Eigen::VectorXd shared_N =
      contact.stated_m * 0.15 * kModulus_Pa * press_depth_m().cwiseSqrt();
  Observations out;
  for (int press = 0; press < 3; ++press) {
    const Eigen::VectorXd force_N =
        press_N(kModulus_Pa, contact.mean_m + contact.scatter_m * normal(random));
    const double noise_N = 0.01 * force_N.maxCoeff();
    const Eigen::Index before = out.value.size(), n = force_N.size();
    for (Eigen::VectorXd* column : {&out.value, &out.deviation, &out.shared})
      column->conservativeResize(before + n);
    out.value.tail(n) = force_N.unaryExpr([&](double f) { return f + noise_N * normal(random); });
    out.deviation.tail(n).setConstant(noise_N);
    out.shared.tail(n) = shared_N;
    out.group.insert(out.group.end(), static_cast<std::size_t>(n), press);
  }
  return out;
}

Identification modulus_of(const Observations& observed) {
  return identify({"neo-hookean", {1e3, kPoissonRatio}}, observed,
                  [](const std::vector<MaterialParameters>& materials) {
                    std::vector<Eigen::VectorXd> out;
                    for (const MaterialParameters& m : materials)
                      out.push_back(press_N(m.values[0], 0).replicate(3, 1));
                    return out;
                  },
                  {.free = {0}});
}

// Contacts are found with errors of 0.1 mm: as one press stiffens, another softens. With the
// deviation told the modulus errs less, and its interval holds the truth.
TEST(Identify, an_error_that_an_experiment_shares_is_in_the_answer_and_in_its_interval) {
  int within = 0;
  double squares = 0, exact_squares = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const Observations observed = three_presses(seed, {.scatter_m = 1e-4, .stated_m = 1e-4});
    const Identification found = modulus_of(observed);
    EXPECT_EQ(found.shared_error.size(), 3u);
    Observations exact = observed;
    exact.shared.resize(0);
    const Identification as_exact = modulus_of(exact);
    within +=
        std::abs(found.material.values[0] - kModulus_Pa) < found.half_width * found.deviation(0);
    squares += std::pow(found.material.values[0] / kModulus_Pa - 1, 2);
    exact_squares += std::pow(as_exact.material.values[0] / kModulus_Pa - 1, 2);
  }
  EXPECT_GE(within, 35);
  EXPECT_LT(squares, 0.6 * exact_squares);
}

// An estimator of contacts that knows a half-space alone states a fifth of its error on a thin
// body. Contacts that move by more than is stated say so.
TEST(Identify, errors_that_experiments_share_are_widened_where_they_are_larger_than_stated) {
  int within = 0;
  double squares = 0, half_width_Pa = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const Identification found =
        modulus_of(three_presses(seed, {.mean_m = 2e-4, .scatter_m = 4e-5, .stated_m = 4e-5}));
    const double off_Pa = found.material.values[0] - kModulus_Pa,
                 band_Pa = found.half_width * found.deviation(0);
    within += std::abs(off_Pa) < band_Pa;
    squares += off_Pa * off_Pa;
    half_width_Pa += band_Pa;
    for (const double moved : found.shared_error) EXPECT_GT(moved, 2) << "seed " << seed;
  }
  EXPECT_LT(std::sqrt(squares / 40), 0.015 * kModulus_Pa);  // 0.026 as stated
  EXPECT_LT(half_width_Pa / 40, 0.03 * kModulus_Pa);        // 0.093 as stated
  EXPECT_GE(within, 34);
}

}  // namespace
}  // namespace palpate::fem
