#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "libfem/elements/elastic_body.hpp"
#include "tests/libfem/elements/derivatives.hpp"
#include "tests/libfem/materials/examples.hpp"
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

/// Pulled to a length, the sides free: the deformation gradient, by secants.
inline Mat3 pulled_to(const RememberingBody& moving, double stretch) {
  const auto F_at = [&](double side) { return Mat3(Vec3(stretch, side, side).asDiagonal()); };
  double a = 1 / std::sqrt(stretch), b = a + 1e-4, fa = moving.stress(F_at(a))(1, 1);
  for (int i = 0; i < 50 && a != b; ++i) {
    const double fb = moving.stress(F_at(b))(1, 1);
    const double next = fb == fa ? b : b - fb * (b - a) / (fb - fa);
    a = b;
    fa = fb;
    b = next;
  }
  return F_at(b);
}

/// A step of dt_s to u, after one of before_s to `before`, has the same bits on each.
inline void expect_same_bits_on_every_instruction_set(const MaterialParameters& material,
                                                      const Points& u, const Points& before,
                                                      double before_s, double dt_s) {
  const QuadraticMesh mesh = small_block();
  std::vector<Points> forces;
  for (const InstructionSet set : examples::instruction_sets()) {
    ElasticBody body(mesh, {make_material(material, "test")}, nullptr);
    body.use(set);
    const auto history = std::make_shared<const MaterialHistory>(
        body.remembered(before, body.step_from(nullptr, before_s)));
    body.set_step(std::make_shared<const MaterialStep>(body.step_from(history, dt_s)));
    SymmetricBlockMatrix K = body.pattern();
    body.add_stiffness(u, 0.5, forces.emplace_back(Points::Zero(u.rows(), 3)), K);
    forces.push_back(Eigen::Map<const Points>(K.values().data(), K.values().size() / 3, 3));
  }
  for (std::size_t i = 2; i < forces.size(); ++i) EXPECT_TRUE(forces[i] == forces[i % 2]) << i;
}

}  // namespace palpate::fem
