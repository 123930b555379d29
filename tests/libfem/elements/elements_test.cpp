#include "libfem/elements/elements.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

constexpr unsigned kSeed = 4711;
const Material kMaterial = make_material({"neo-hookean", {1e4, 0.4999}}, "test");

TEST(Elements, four_points_make_tet10_its_own_projection_on_linears) {
  const std::vector<CellPoint> points = cell_points(shape_of(ElementKind::tet10));
  const Eigen::Vector4d weight(0.1, 0.3, 0.2, 0.4);
  const Eigen::MatrixXd mode = orthonormal_modes(4, points, weight);
  const auto one = Eigen::Matrix4d::Identity();
  EXPECT_LE((mode * weight.asDiagonal() * mode.transpose() - one).norm(), 1e-12);
  EXPECT_LE((mode.transpose() * mode * weight.asDiagonal() - one).norm(), 1e-12);
}

TEST(Elements, rules_integrate_polynomials_to_their_degree) {
  const std::pair<ElementShape, int> rules[] = {{{4, 1, 0}, 1}, {{10, 4, 0}, 2}, {{10, 14, 4}, 5}};
  const auto factorial = [](int n) { return std::tgamma(n + 1.0); };
  for (const auto& [shape, degree] : rules)
    for (int a = 0; a <= degree; ++a)
      for (int b = 0; a + b <= degree; ++b) {
        const int c = degree - a - b;
        double sum = 0;
        for (const CellPoint& point : cell_points(shape))
          sum += point.weight * std::pow(point.barycentric[0], a) *
                 std::pow(point.barycentric[1], b) * std::pow(point.barycentric[3], c);
        const double exact = 6 * factorial(a) * factorial(b) * factorial(c) / factorial(degree + 3);
        EXPECT_NEAR(sum / exact, 1, 1e-12) << shape.points << " points, " << a << b << c;
      }
}

TEST(Elements, eight_tets_fill_a_tet_whichever_diagonal_is_shortest) {
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::array<int, 10> used{};
  for (int trial = 0; trial < 30; ++trial) {
    Eigen::Matrix<double, 10, 3> nodes;
    for (int i = 0; i < 12; ++i) nodes(i / 3, i % 3) = uniform(random);
    Mat3 edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = nodes.row(k + 1) - nodes.row(0);
    if (edges.determinant() < 0) nodes.row(0).swap(nodes.row(1));
    constexpr int kEdges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
    for (int e = 0; e < 6; ++e)
      nodes.row(4 + e) = (nodes.row(kEdges[e][0]) + nodes.row(kEdges[e][1])) / 2;
    const double volume = std::abs(edges.determinant()) / 6;
    const auto pieces = eight_tets(nodes);
    ++used[pieces[4][0]];
    for (const auto& piece : pieces) {
      for (int k = 0; k < 3; ++k) edges.col(k) = nodes.row(piece[k + 1]) - nodes.row(piece[0]);
      EXPECT_NEAR(edges.determinant() / 6 / volume, 0.125, 1e-9)
          << "seed " << kSeed << " trial " << trial;
    }
  }
  EXPECT_TRUE(used[4] > 0 && used[5] > 0 && used[6] > 0);
}

TEST(Elements, blend_leaves_the_bulk_modulus_of_equal_lame_constants_at_each_point) {
  for (const double poisson : {-0.5, 0.0, 0.25, 0.3, 0.45, 0.4999}) {
    const Material material = make_material({"neo-hookean", {1e4, poisson}}, "");
    const SmallStrain hooke = material.law->small_strain(material.constants);
    const double a = averaged_share(ElementKind::tet10_blend, material);
    EXPECT_NEAR(hooke.lambda_Pa * (1 - a), std::min(hooke.lambda_Pa, hooke.mu_Pa), 1e-9 * 1e4);
    EXPECT_TRUE(a >= 0 && a < 1) << poisson;
    EXPECT_EQ(averaged_share(ElementKind::tet10_p0, material), 1);
    EXPECT_EQ(element_for(ElementKind::automatic, material), ElementKind::tet10_blend);
  }
}

TEST(Elements, a_law_that_does_not_split_falls_back_to_plain_ten_node_elements) {
  LawRow law = *kMaterial.law;
  law.splits_volume = false;
  const Material whole{&law, kMaterial.constants};
  for (const ElementRow& row : kElements)
    EXPECT_EQ(element_for(row.kind, whole),
              row.kind == ElementKind::tet4 ? ElementKind::tet4 : ElementKind::tet10);
}

TEST(Elements, unknown_names_are_refused_with_the_known_ones) {
  try {
    find_element("hex8", "[body]");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("hex8"), std::string::npos);
    EXPECT_NE(error.remedy().find("auto, tet10, tet10-blend"), std::string::npos);
  }
}

}  // namespace
}  // namespace palpate::fem
