#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "libfem/elements/elastic_body.hpp"
#include "tests/libfem/fields.hpp"
#include "tests/libfem/solve/block.hpp"

// A small block that remembers, moved step by step: for the tests of time and of softening.

namespace palpate::fem {

constexpr double kSize_m = 0.02;
constexpr double kForever = std::numeric_limits<double>::infinity();

inline QuadraticMesh small_block() {
  const TetMesh base = structured_block(Vec3::Constant(kSize_m), {1, 1, 1});
  return ungraded(base, std::vector<char>(static_cast<std::size_t>(base.nodes.rows()), 0));
}

/// A body whose displacement is prescribed.
class RememberingBody {
 public:
  RememberingBody(const QuadraticMesh& mesh, const MaterialParameters& material)
      : mesh_(mesh), body_(mesh, {make_material(material, "test")}, nullptr) {}

  void begin(double dt_s) {
    step_ = std::make_shared<const MaterialStep>(body_.step_from(memory_, dt_s));
    body_.set_step(step_);
  }
  void end(const Points& u) {
    memory_ = std::make_shared<const MaterialHistory>(body_.remembered(u, *step_));
  }
  void go(const Points& u, double dt_s) {
    begin(dt_s);
    end(u);
  }
  Points force(const Points& u) const {
    Points out = Points::Zero(u.rows(), 3);
    body_.add_force(u, out);
    return out;
  }
  /// First Piola-Kirchhoff stress of a homogeneous state, from the forces on the boundary.
  Mat3 stress(const Mat3& F) const {
    return force(affine(mesh_.nodes, F)).transpose() * mesh_.nodes / std::pow(kSize_m, 3);
  }
  const ElasticBody& body() const { return body_; }

 private:
  const QuadraticMesh& mesh_;
  ElasticBody body_;
  std::shared_ptr<const MaterialHistory> memory_;
  std::shared_ptr<const MaterialStep> step_;
};

template <class Difference>
double min_error(const Difference& error_at) {
  double least = kForever;
  for (const double h : {1e-4, 1e-5, 1e-6, 1e-7}) least = std::min(least, error_at(h));
  return least;
}

/// Force and stiffness at u are derivatives of the energy, along d; tolerances are relative.
inline void expect_derivatives(const RememberingBody& moving, const Points& u, const Points& d,
                               double force_tolerance, double stiffness_tolerance) {
  const ElasticBody& body = moving.body();
  Points force = Points::Zero(u.rows(), 3);
  SymmetricBlockMatrix K = body.pattern();
  const double energy = body.add_stiffness(u, 1.0, force, K);
  ASSERT_TRUE(std::isfinite(energy));
  EXPECT_EQ(energy, body.energy(u));
  EXPECT_EQ((force - moving.force(u)).norm(), 0);
  const double work = force.cwiseProduct(d).sum();
  EXPECT_LE(min_error([&](double h) {
              return std::abs((body.energy(u + h * d) - body.energy(u - h * d)) / (2 * h) - work);
            }),
            force_tolerance * force.norm() * d.norm());
  Eigen::VectorXd exact;
  K.multiply(Eigen::Map<const Eigen::VectorXd>(d.data(), d.size()), exact);
  EXPECT_LE(
      min_error([&](double h) {
        const Points change = (moving.force(u + h * d) - moving.force(u - h * d)) / (2 * h);
        return (Eigen::Map<const Eigen::VectorXd>(change.data(), change.size()) - exact).norm();
      }),
      stiffness_tolerance * exact.norm());
}

}  // namespace palpate::fem
