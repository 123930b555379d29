#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "libfem/elements/elastic_body.hpp"
#include "tests/libfem/fields.hpp"
#include "tests/libfem/matrix_entries.hpp"

namespace palpate::fem {

inline int free_nodes(const ElasticBody& body) { return 1 + std::ranges::max(body.free_index()); }

inline Eigen::VectorXd free_entries(const ElasticBody& body, const Points& field) {
  Eigen::VectorXd out(3 * free_nodes(body));
  for (Eigen::Index n = 0; n < field.rows(); ++n)
    if (const auto i = body.free_index()[n]; i >= 0) out.segment<3>(3 * i) = field.row(n);
  return out;
}

inline void add_to_free(const ElasticBody& body, const Eigen::VectorXd& by, Points& field) {
  for (Eigen::Index n = 0; n < field.rows(); ++n)
    if (const auto i = body.free_index()[n]; i >= 0)
      field.row(n) += by.segment<3>(3 * i).transpose();
}

/// Least error of a central difference over several steps: which step is best depends on the state.
template <class Difference>
double min_error(const Difference& error_at) {
  double least = std::numeric_limits<double>::infinity();
  for (const double h : {1e-4, 1e-5, 1e-6, 1e-7}) least = std::min(least, error_at(h));
  return least;
}

/// Force and stiffness at u are derivatives of the energy, along d and along d where nodes are
/// free; tolerances are relative.
inline void expect_derivatives(const ElasticBody& body, const Points& u, const Points& d,
                               double force_tolerance, double stiffness_tolerance) {
  const Points none = Points::Zero(u.rows(), 3);
  Points force = none, force_only = none;
  SymmetricBlockMatrix K = body.pattern();
  const double energy = body.add_stiffness(u, 1.0, force, K);
  ASSERT_TRUE(std::isfinite(energy)) << "least J " << body.min_J();
  EXPECT_EQ(energy, body.add_force(u, force_only));
  EXPECT_EQ((force - force_only).norm(), 0);
  EXPECT_EQ(energy, body.energy(u));
  const double work = force.cwiseProduct(d).sum();
  EXPECT_LE(min_error([&](double h) {
              return std::abs((body.energy(u + h * d) - body.energy(u - h * d)) / (2 * h) - work);
            }),
            force_tolerance * force.norm() * d.norm());
  Points of_free = none;
  add_to_free(body, free_entries(body, d), of_free);
  const Eigen::VectorXd exact = dense(K) * free_entries(body, d);
  EXPECT_LE(min_error([&](double h) {
              Points ahead = none, behind = none;
              body.add_force(u + h * of_free, ahead);
              body.add_force(u - h * of_free, behind);
              return (free_entries(body, ahead - behind) / (2 * h) - exact).norm();
            }),
            stiffness_tolerance * exact.norm());
}

}  // namespace palpate::fem
