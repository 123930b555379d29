#include "libfit/recordings/relaxation/fit_relaxation.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "tests/libfit/recordings/relaxation/relaxing_presses.hpp"

namespace palpate::recordings {
namespace {

using namespace testing_relaxation;

// Coefficients of a level, a slope and a decay, by least squares that knows nothing of drift.
TEST(SensorNoise, tells_how_far_a_fit_may_be_off_with_white_noise_and_with_drift) {
  const Eigen::Index n = 120;
  const Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(n, 0, 20),
                        one = Eigen::VectorXd::Ones(n);
  Eigen::MatrixXd slopes(n, 3);
  slopes << one, time_s, (-time_s.array() / 4).exp().matrix();
  const Eigen::MatrixXd inverse = (slopes.transpose() * slopes).inverse();
  for (const double drift : {0., 1., 4.}) {
    Eigen::Vector3d squares = Eigen::Vector3d::Zero(), wide = squares;
    constexpr int kSeeds = 150;
    for (unsigned seed = 0; seed < kSeeds; ++seed) {
      std::mt19937 random(seed);
      std::normal_distribution<double> normal(0, 1);
      const std::vector<double> slow = slow_noise(static_cast<std::size_t>(n), random);
      const Eigen::VectorXd noise = Eigen::VectorXd::NullaryExpr(n, [&](Eigen::Index i) {
        return normal(random) + drift * slow[static_cast<std::size_t>(i)];
      });
      const Eigen::Vector3d off = inverse * slopes.transpose() * noise;
      const Eigen::MatrixXd covariance =
          inverse * slopes.transpose() *
          sensor_covariance(time_s, one, one, noise - slopes * off, slopes) * slopes * inverse;
      squares += off.cwiseAbs2().cwiseQuotient(covariance.diagonal()) / kSeeds;
      wide += covariance.diagonal() / kSeeds;
    }
    for (int k = 0; k < 3; ++k) {
      EXPECT_GT(std::sqrt(squares[k]), 0.7) << "drift " << drift << ", coefficient " << k;
      EXPECT_LT(std::sqrt(squares[k]), 1.2) << "drift " << drift << ", coefficient " << k;
      if (drift == 0) {  // what may be drift and is not costs at most half of the width
        EXPECT_LT(std::sqrt(wide[k] / inverse(k, k)), 1.5) << "coefficient " << k;
      }
    }
  }
}

}  // namespace
}  // namespace palpate::recordings
