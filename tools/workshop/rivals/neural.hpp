#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "tools/workshop/rivals/rival.hpp"

namespace palpate::tools {

/// A network of two hidden layers of tanh from inputs to outputs.
class SmallNetwork {
 public:
  SmallNetwork(int inputs, int hidden, int outputs, std::uint64_t seed);

  Eigen::VectorXd operator()(const Eigen::VectorXd& input) const;
  /// Mean over the columns of weight |output - target|^2, and its gradient over the numbers.
  double loss(const Eigen::MatrixXd& input, const Eigen::MatrixXd& target,
              const Eigen::VectorXd& weight, std::vector<Eigen::MatrixXd>& gradient) const;
  /// Adam over all rows at once (Kingma and Ba 2015, arXiv:1412.6980), its rate falling by half a
  /// cosine from `rate` to a hundredth of it. Returns the last loss.
  double train(const Eigen::MatrixXd& input, const Eigen::MatrixXd& target,
               const Eigen::VectorXd& weight, int epochs, double rate);
  std::size_t numbers() const;
  /// Weights and biases by turns, layer by layer.
  std::vector<Eigen::MatrixXd>& parameters() { return parameter_; }

 private:
  std::vector<Eigen::MatrixXd> parameter_;
};

std::vector<Rival> prepare_neural(const RivalBody& body);

}  // namespace palpate::tools
