// The network learns.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <vector>

#include "tests/tools/rivals/plate.hpp"
#include "tools/workshop/rivals/neural.hpp"

namespace palpate::tools {
namespace {

using namespace testing_rivals;

TEST(SmallNetworkOf, gradient_is_the_difference_of_its_loss) {
  SmallNetwork network(6, 5, 3, 7);
  std::srand(3);
  const Eigen::MatrixXd input = Eigen::MatrixXd::Random(6, 9),
                        target = Eigen::MatrixXd::Random(3, 9);
  const Eigen::VectorXd weight = Eigen::VectorXd::Random(9).array().abs();
  std::vector<Eigen::MatrixXd> gradient, unused;
  network.loss(input, target, weight, gradient);
  constexpr double kStep = 1e-6;
  for (std::size_t k = 0; k < gradient.size(); ++k)
    for (Eigen::Index i = 0; i < gradient[k].size(); i += 3) {
      double& number = network.parameters()[k].data()[i];
      const double at = number;
      number = at + kStep;
      const double up = network.loss(input, target, weight, unused);
      number = at - kStep;
      const double down = network.loss(input, target, weight, unused);
      number = at;
      EXPECT_NEAR(gradient[k].data()[i], (up - down) / (2 * kStep), 1e-7) << k << ' ' << i;
    }
}

TEST_F(Proxies, a_network_learns_the_spring_of_the_samples) {
  body_.depth_m = 4e-3;
  for (const Rival& rival : prepare_neural(body_)) {
    const Vec3 force = press_and_slide(rival, 0);
    EXPECT_NEAR(force.z(), -2e-3 * kStiffness_N_m, 0.05 * 2e-3 * kStiffness_N_m) << rival.settings;
  }
}

}  // namespace
}  // namespace palpate::tools
