#include "libfit/fit/neighbours/graph_quadratic.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

namespace palpate::test {
namespace {

using fit::bounded_minimum;
using fit::gradient;
using fit::GraphQuadratic;

Eigen::MatrixXd random_covariance(Eigen::Index n, std::mt19937& random, double deviation) {
  std::normal_distribution<double> normal(0, 1);
  Eigen::MatrixXd root(n, n);
  for (Eigen::Index i = 0; i < root.size(); ++i) root(i) = normal(random);
  return deviation * deviation *
         (root * root.transpose() / static_cast<double>(n) +
          0.01 * Eigen::MatrixXd::Identity(n, n));
}

// Estimates of which many are at or below the bound, on a ring with chords.
GraphQuadratic random_field(Eigen::Index points, Eigen::Index n, unsigned seed, double deviation) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  Controls estimate(points, n);
  for (Eigen::Index i = 0; i < estimate.size(); ++i)
    estimate.data()[i] = std::max(0.0, 0.2 + 0.5 * normal(random));
  std::vector<Eigen::MatrixXd> covariance;
  std::vector<fit::PointEdge> edges;
  for (Eigen::Index p = 0; p < points; ++p) {
    covariance.push_back(random_covariance(n, random, deviation));
    const auto at = static_cast<std::int32_t>(p), end = static_cast<std::int32_t>(points);
    if (at + 1 < end) edges.push_back({at, at + 1, 1});
    if (at + 5 < end) edges.push_back({at, at + 5, 0.3});
  }
  return fit::make_quadratic(estimate, covariance, edges);
}

double energy(const GraphQuadratic& q, double strength, const Controls& u) {
  double sum = 0;
  for (Eigen::Index p = 0; p < u.rows(); ++p) {
    const Eigen::VectorXd off = u.row(p) - q.centre.row(p);
    sum += 0.5 * off.dot(q.precision[static_cast<std::size_t>(p)] * off);
  }
  for (const fit::PointEdge& e : q.edges)
    sum += 0.5 * strength * e.weight * (u.row(e.first) - u.row(e.second)).squaredNorm();
  return sum;
}

// Without structure, for comparison: columns point by point.
Eigen::MatrixXd dense_hessian(const GraphQuadratic& q, double strength) {
  const Eigen::Index n = q.centre.cols(), size = q.centre.size();
  Eigen::MatrixXd H(size, size);
  Controls unit = Controls::Zero(q.centre.rows(), n);
  const Controls zero = gradient(q, strength, unit);
  for (Eigen::Index i = 0; i < size; ++i) {
    unit.data()[i] = 1;
    const Controls column = gradient(q, strength, unit) - zero;
    H.col(i) = Eigen::Map<const Eigen::VectorXd>(column.data(), size);
    unit.data()[i] = 0;
  }
  return H;
}

TEST(graph_quadratic, gradient_is_the_derivative_of_the_energy) {
  const GraphQuadratic q = random_field(9, 3, 4, 0.3);
  std::mt19937 random(11);
  std::normal_distribution<double> normal(0, 1);
  Controls u(9, 3);
  for (Eigen::Index i = 0; i < u.size(); ++i) u.data()[i] = normal(random);
  const Controls slope = gradient(q, 2.5, u);
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    const double h = 1e-4, at = u.data()[i];
    u.data()[i] = at + h;
    const double above = energy(q, 2.5, u);
    u.data()[i] = at - h;
    const double below = energy(q, 2.5, u);
    u.data()[i] = at;
    EXPECT_NEAR(slope.data()[i], (above - below) / (2 * h), 1e-6 * slope.norm());
  }
}

TEST(graph_quadratic, minimum_meets_the_karush_kuhn_tucker_conditions) {
  for (unsigned seed = 1; seed <= 20; ++seed)
    for (const double strength : {1e-2, 1.0, 1e2, 1e5}) {
      const GraphQuadratic q = random_field(30, 4, seed, 0.5);
      const double size = gradient(q, strength, q.centre).norm();
      const Controls u = bounded_minimum(q, strength, q.centre, 1e-10);
      const Controls slope = gradient(q, strength, u);
      int bound = 0;
      for (Eigen::Index i = 0; i < u.size(); ++i) {
        ASSERT_GE(u.data()[i], 0) << "seed " << seed;
        bound += u.data()[i] == 0;
        const double up = slope.data()[i], down = u.data()[i] > 0 ? -up : 0;
        ASSERT_GE(std::min(up, down), -1e-9 * size) << "seed " << seed;
      }
      EXPECT_GT(bound + (strength > 1), 0) << "the seeds are meant to reach bounds";
    }
}

TEST(graph_quadratic, minimum_does_not_depend_on_where_the_search_starts) {
  const GraphQuadratic q = random_field(40, 3, 7, 0.5);
  const Controls a = bounded_minimum(q, 30, q.centre, 1e-12);
  const Controls b = bounded_minimum(q, 30, Controls::Constant(40, 3, 5.0), 1e-12);
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(graph_quadratic, covariance_is_the_diagonal_of_the_whole_inverse) {
  const GraphQuadratic q = random_field(25, 3, 3, 0.4);
  for (const double strength : {0.1, 10.0, 1e4}) {
    const auto blocks = fit::posterior_covariance(q, strength);
    const Eigen::MatrixXd whole = dense_hessian(q, strength).inverse();
    for (Eigen::Index p = 0; p < 25; ++p) {
      const Eigen::MatrixXd expected = whole.block(3 * p, 3 * p, 3, 3);
      EXPECT_LT((blocks[static_cast<std::size_t>(p)] - expected).norm(), 1e-9 * expected.norm());
      // Never wider than what the point knows by itself.
      const Eigen::MatrixXd own = q.precision[static_cast<std::size_t>(p)].inverse();
      EXPECT_GT((own - expected).selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(),
                -1e-9 * own.norm());
    }
  }
}

TEST(graph_quadratic, neighbours_that_differ_for_sure_are_let_go) {
  Controls estimate(3, 2);
  estimate << 1, 1, 1.02, 0.99, 3, 3;
  const std::vector<Eigen::MatrixXd> covariance(3, 0.0025 * Eigen::MatrixXd::Identity(2, 2));
  const GraphQuadratic q = fit::make_quadratic(estimate, covariance, {{0, 1, 1}, {1, 2, 1}});
  EXPECT_EQ(q.edges[0].weight, 1);
  EXPECT_LT(q.edges[1].weight, 0.01);
}

}  // namespace
}  // namespace palpate::test
