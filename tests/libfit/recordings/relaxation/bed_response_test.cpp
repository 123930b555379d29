
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/libfit/recordings/relaxation/relaxing_presses.hpp"

namespace palpate::recordings {
namespace {

using namespace testing_relaxation;

// A path at equal intervals.
std::pair<Eigen::VectorXd, Eigen::VectorXd> sampled(const Way& way, double interval_s) {
  const auto rows = static_cast<Eigen::Index>(way.time_s.back() / interval_s) + 1;
  Eigen::VectorXd time_s(rows), depth_m(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    time_s[i] = interval_s * static_cast<double>(i);
    depth_m[i] = way.depth_at(time_s[i]);
  }
  return {time_s, depth_m};
}

TEST(BedResponse, is_lee_and_radoks_integral_while_the_contact_grows) {
  const Relaxation r = prony({0.7, 0.4, 2}, {0.02, 0.5, 7});
  const double speed = 2e-3, in_s = 1.5;
  Way way;
  way.go(0, 0), way.go(speed * in_s, in_s), way.go(speed * in_s, 4);
  const auto [time_s, depth_m] = sampled(way, 0.05);
  const Eigen::VectorXd rings = Eigen::Vector3d(0, 0.7e-3, 2.1e-3);
  const Eigen::MatrixXd forces = ring_forces(time_s, depth_m, r, rings);
  for (Eigen::Index i = 0; i < time_s.size(); ++i)
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double t = time_s[i], from = rings[k] / speed, to = std::min(t, in_s);
      double expected = 0;  // of psi(t - s) speed ds from `from` to `to`
      if (t > from) {
        expected = speed * (to - from);
        for (Eigen::Index b = 0; b < 3; ++b)
          expected += speed * r.share[b] * r.time_s[b] *
                      (std::exp(-(t - to) / r.time_s[b]) - std::exp(-(t - from) / r.time_s[b]));
      }
      EXPECT_NEAR(forces(i, k), expected, 1e-14) << "at " << t << " s, ring " << k;
    }
}

TEST(BedResponse, equals_small_steps_where_rings_let_go_and_come_back) {
  const Relaxation r = prony({0.7, 0.4}, {0.1, 1.5});
  Way way;  // in, held, quickly half out, in again, out, a second touch before it forgets
  way.go(-1e-3, 0), way.go(3e-3, 1), way.go(3e-3, 1), way.go(1e-3, 0.05), way.go(2e-3, 0.4);
  way.go(-1e-3, 0.1), way.go(2.5e-3, 0.5);
  const auto [time_s, depth_m] = sampled(way, 0.05);
  const std::vector<double> reference = forces({r, 1}, way, 0.05, 400);
  // The same rings as there.
  constexpr int kRings = 150;
  Eigen::VectorXd ring(kRings), stiffness(kRings);
  const auto begin = [&](int i) { return 3e-3 * i * i / kRings / kRings; };
  const auto slope = [&](int i) {
    return (std::pow(begin(i + 1) / 1e-3, 1.5) - std::pow(begin(i) / 1e-3, 1.5)) /
           (begin(i + 1) - begin(i));
  };
  for (int i = 0; i < kRings; ++i)
    ring[i] = begin(i), stiffness[i] = slope(i) - (i > 0 ? slope(i - 1) : 0);
  const Eigen::MatrixXd each = ring_forces(time_s, depth_m, r, ring);
  EXPECT_GE(each.minCoeff(), 0);
  const Eigen::VectorXd sum = each * stiffness;
  const double most_N = sum.maxCoeff();
  for (Eigen::Index i = 0; i < sum.size(); ++i)
    EXPECT_NEAR(sum[i], reference[static_cast<std::size_t>(i)], 2e-3 * most_N) << time_s[i] << " s";
}

TEST(BedResponse, places_on_a_straight_way_change_nothing) {
  const Relaxation r = prony({3, 0.4, 0.2}, {0.05, 0.3, 4});
  std::mt19937 random(5);
  std::uniform_real_distribution<double> depth(-1e-3, 3e-3), duration(0.01, 2);
  Way way;
  way.go(-1e-3, 0);
  for (int i = 0; i < 40; ++i) way.go(depth(random), duration(random));
  const auto n = static_cast<Eigen::Index>(way.time_s.size());
  Eigen::VectorXd time_s(n), depth_m(n), fine_s(4 * n - 3), fine_m(4 * n - 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    time_s[i] = way.time_s[static_cast<std::size_t>(i)];
    depth_m[i] = way.depth_m[static_cast<std::size_t>(i)];
  }
  for (Eigen::Index i = 0; i < fine_s.size(); ++i) {
    const double share = static_cast<double>(i % 4) / 4;
    const Eigen::Index a = i / 4, b = std::min(a + 1, n - 1);
    fine_s[i] = (1 - share) * time_s[a] + share * time_s[b];
    fine_m[i] = (1 - share) * depth_m[a] + share * depth_m[b];
  }
  const Eigen::VectorXd rings = Eigen::VectorXd::LinSpaced(9, 0, 2.5e-3);
  const Eigen::MatrixXd coarse = ring_forces(time_s, depth_m, r, rings),
                        fine = ring_forces(fine_s, fine_m, r, rings);
  for (Eigen::Index i = 0; i < n; ++i)
    EXPECT_LT((coarse.row(i) - fine.row(4 * i)).cwiseAbs().maxCoeff(), 1e-12) << "place " << i;
}

}  // namespace
}  // namespace palpate::recordings
