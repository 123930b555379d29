#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "libfem/materials/element_kernel.hpp"
#include "libfem/materials/materials.hpp"

namespace palpate::fem::examples {

// A material of every law, for the suites that walk the table, and the states they are tried at.

/// A tensor row by row.
using Mat3Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Vec9 = Eigen::Matrix<double, 9, 1>;

inline constexpr unsigned kSeed = 20240607;
inline constexpr double kLeftOut = std::numeric_limits<double>::quiet_NaN();

/// is_kinked_at_rest: the tangent jumps at E = 0. max_J_without_geometric: up to where the law says
/// that its tangent without the geometric part is semidefinite; 0 where it does not. min_stretch:
/// of uniaxial tests, from which on a push grows as the stretch falls.
struct Example {
  std::string name;
  MaterialParameters parameters;
  bool is_kinked_at_rest = false;
  double max_J_without_geometric = 1e9;
  double min_stretch = 0.3;
};
inline void PrintTo(const Example& example, std::ostream* out) { *out << example.name; }

inline const std::vector<Example>& all() {
  static const std::vector<Example> kExamples{
      {"neo_hookean", {"neo-hookean", {10e3, 0.45}}, false, 2.7},
      {"neo_hookean_nearly_incompressible", {"neo-hookean", {10e3, 0.4999}}, false, 2.7},
      {"neo_hookean_isochoric", {"neo-hookean-isochoric", {10e3, 0.45}}},
      {"mooney_rivlin", {"mooney-rivlin", {1.2e3, 0.5e3}}, false, 0},
      {"yeoh", {"yeoh", {1.7e3, -0.1e3, 0.04e3, 0.48}}},
      {"ogden_1", {"ogden", {800, 8}}},
      {"ogden_2", {"ogden", {3e3, 2.5, -200, -3, kLeftOut, kLeftOut, 0.48}}},
      {"ogden_3", {"ogden", {6.3e3, 1.3, 12, 5, -100, -2, 0.45, 1e5}}},
      {"fung", {"fung", {3e3, 1.5}}, false, 1e9, 0.45},
      {"fibres", {"holzapfel-gasser-ogden", {3e3, 5e3, 0.1, 1, 2, -2}}, true},
      {"dispersed_fibres", {"holzapfel-gasser-ogden", {3e3, 5e3, 0.1, 1, 2, -2, 0.2, 0.48}}, true},
  };
  return kExamples;
}

/// Of this machine.
inline std::vector<InstructionSet> instruction_sets() {
  std::vector<InstructionSet> sets{InstructionSet::portable, InstructionSet::avx2,
                                   InstructionSet::avx512};
  std::erase_if(sets, [](InstructionSet set) { return !has_instruction_set(set); });
  return sets;
}

inline Mat3 random_matrix(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  Mat3 M;
  for (int i = 0; i < 9; ++i) M(i / 3, i % 3) = uniform(random);
  return M;
}

inline Mat3 random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
  return q.normalized().toRotationMatrix();
}

/// Seeded random states about rest and the awkward ones: rest first, near rest, J near 0.2, big
/// shear, big rotation, stretches that agree or nearly do.
inline std::vector<Mat3> states() {
  std::mt19937 random(kSeed);
  std::vector<Mat3> out{Mat3::Identity()};
  while (out.size() < 12) {
    const Mat3 F = Mat3::Identity() + random_matrix(random, 0.5);
    if (F.determinant() > 0.15) out.push_back(F);
  }
  Mat3 F = Vec3(0.2, 1, 1).asDiagonal();
  out.push_back(F);
  out.push_back(random_rotation(random) * F);
  F = std::cbrt(0.2) * Mat3::Identity();
  out.push_back(F);
  F.setIdentity();
  F(0, 1) = 4;
  out.push_back(F);
  F(2, 0) = -3;
  out.push_back(F * Vec3(0.6, 0.7, 0.6).asDiagonal());
  F = Vec3(3, 2, 1.5).asDiagonal();
  out.push_back(random_rotation(random) * F);
  for (const double apart : {0.0, 1e-15, 1e-12, 1e-8, 1e-5}) {
    const Mat3 Q = random_rotation(random), R = random_rotation(random);
    out.push_back(Q * Vec3(1.3, 1.3 + apart, 0.7).asDiagonal() * R);
    out.push_back(Q * Vec3(0.8, 1.4, 0.8 + apart).asDiagonal() * R);
    out.push_back(Q * Vec3(1.1, 1.1 + apart, 1.1 - 2 * apart).asDiagonal() * R);
  }
  out.push_back(Mat3::Identity() + random_matrix(random, 1e-4));
  out.push_back(Mat3::Identity() + random_matrix(random, 1e-8));
  return out;
}

}  // namespace palpate::fem::examples
