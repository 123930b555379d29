#include <gtest/gtest.h>

#include <Eigen/LU>
#include <fstream>
#include <map>
#include <sstream>

#include "libfem/materials/materials.hpp"
#include "tests/libfem/materials/examples.hpp"

namespace palpate::fem {
namespace {

// points.csv: W, P, Cauchy stress and the tangent's action on kDirection at points; cases MAT/*
// from 40-digit differences of W by independent code, cases own/* from make_points.py.
// uniaxial.csv: traction-free uniaxial states of the same independent code.

using examples::Mat3Rows;
using examples::Vec9;
constexpr double kDirection[9] = {0.3, -0.7, 0.2, 0.5, 0.1, -0.4, 0.6, -0.2, 0.8};

std::vector<double> numbers(const std::string& text) {
  std::istringstream words(text);
  std::vector<double> out;
  for (std::string word; words >> word;) out.push_back(std::stod(word));
  return out;
}

std::vector<std::vector<std::string>> rows_of(const std::string& name) {
  std::ifstream file(PALPATE_SOURCE_DIR "/tests/libfem/materials/" + name);
  EXPECT_TRUE(file.is_open()) << name;
  std::vector<std::vector<std::string>> rows;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

Material material_of(const std::vector<std::string>& row) {
  return make_material({row[1], numbers(row[2])}, row[0]);
}

Mat3 matrix(const std::string& cell) { return Eigen::Map<const Mat3Rows>(numbers(cell).data()); }

TEST(ReferenceValues, energy_stress_and_tangent_match_those_of_independent_differences) {
  const Vec9 H = Eigen::Map<const Vec9>(kDirection);
  const auto rows = rows_of("points.csv");
  std::map<std::string, int> states;
  for (const auto& row : rows) {
    SCOPED_TRACE(row[0]);
    ++states[row[1]];
    const Material material = material_of(row);
    const Mat3 F = matrix(row[3]), P_expected = matrix(row[5]);
    const double W = numbers(row[4])[0];
    const Mat3 P = material.law->evaluate(material.constants, F).P;
    // Modulus 1 and bulk modulus 10: the rounding of F itself shows at rest and near it.
    const double rest = row[0].find("identity") == std::string::npos ? 0 : 1e-15;
    EXPECT_NEAR(material.law->evaluate(material.constants, F).W, W, 1e-13 * W + rest);
    EXPECT_LE((P - P_expected).norm(), 1e-13 * P_expected.norm() + rest);
    EXPECT_LE((P * F.transpose() / F.determinant() - matrix(row[6])).norm(),
              1e-13 * P_expected.norm() + rest);
    const Vec9 A_H = Eigen::Map<const Vec9>(numbers(row[7]).data());
    EXPECT_LE((material.law->evaluate(material.constants, F).A * H - A_H).norm(),
              1e-12 * A_H.norm());
  }
  for (const LawRow& law : material_laws()) EXPECT_GE(states[std::string(law.name)], 8) << law.name;
}

TEST(ReferenceValues, uniaxial_states_between_free_sides_match) {
  const auto rows = rows_of("uniaxial.csv");
  ASSERT_EQ(rows.size(), 32u);
  for (const auto& row : rows) {
    SCOPED_TRACE(row[0]);
    const Material material = material_of(row);
    const double stretch = std::stod(row[3]), lateral = std::stod(row[4]);
    const auto F_of = [&](double across) {
      return Mat3(Vec3(stretch, across, across).asDiagonal());
    };
    // Newton's method on the stress of the sides, from 1 % off.
    double across = 1.01 * lateral;
    for (int i = 0; i < 20; ++i) {
      const Mat9 A = material.law->evaluate(material.constants, F_of(across)).A;
      across -=
          material.law->evaluate(material.constants, F_of(across)).P(1, 1) / (A(4, 4) + A(4, 8));
    }
    EXPECT_NEAR(across, lateral, 1e-8 * lateral);
    const Mat3 F = F_of(across), P = material.law->evaluate(material.constants, F).P;
    EXPECT_NEAR(P(0, 0), std::stod(row[5]), 1e-8 * std::abs(P(0, 0)));
    EXPECT_NEAR(P(0, 0) * stretch / F.determinant(), std::stod(row[6]), 1e-8 * std::abs(P(0, 0)));
    EXPECT_NEAR(F.determinant(), std::stod(row[7]), 1e-8);
  }
}

}  // namespace
}  // namespace palpate::fem
