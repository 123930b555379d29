// What the base mesh hides (M13d), and what is done about it.

#include "libfem/solve/experiments/simulator_state.hpp"

#include <gtest/gtest.h>

#include "libfem/solve/experiments/simulate.hpp"
#include "tests/libfem/solve/block.hpp"

namespace palpate::fem {
namespace {

const std::vector<Material>& soft() {
  static const std::vector<Material> kSoft{
      make_material({"neo-hookean", {kYoung_Pa, kPoisson}}, "test")};
  return kSoft;
}

constexpr double kRadius_m = 0.001;

/// A patch on top of a base held below, whose elements there are 0.4 of the patch.
PatchResponse press_on(const TetMesh& base, const Vec3& top, double radius_m) {
  GradeOptions grade;
  grade.path = {{top, top, 0.4 * radius_m, radius_m}};
  QuadraticMesh mesh =
      grade_mesh(base, held_below(base.nodes, 1e-6),
                 SmoothSurface({base.nodes, boundary_triangles(base.tets)}), grade);
  mesh.nodes.rowwise() -= top.transpose();
  return press_patch(mesh, static_cast<std::size_t>(base.tets.rows()), soft(), {}, -Vec3::UnitZ(),
                     radius_m);
}

/// On a thick block.
const PatchResponse& pressed_block() {
  static const PatchResponse kPressed =
      press_on(structured_block({0.1, 0.1, 0.06}, {4, 4, 3}), {0.0511, 0.0487, 0.06}, kRadius_m);
  return kPressed;
}

// Under Hertz's pressure on a half-space the surface sinks by (1 - nu^2)/E pi p0/(4 a) (2 a^2 -
// r^2) (Johnson 1985, 3.41); weighted by the pressure, 0.6 (1 - nu^2) / (E a) for a unit force.
TEST(PressPatch, compliance_of_a_small_patch_on_a_thick_block_is_that_of_hertzs_pressure) {
  const double exact = 0.6 * (1 - kPoisson * kPoisson) / (kYoung_Pa * kRadius_m);
  EXPECT_NEAR(pressed_block().compliance_m_N(2, 2) / exact, 1, 0.03);
}

// A unit load stores half its compliance, nearly all of it as distortion where the volume hardly
// changes. Displacements of corners alone tell it within a quarter.
TEST(PressPatch, distortion_is_the_energy_of_the_load) {
  const PatchResponse& out = pressed_block();
  double sum = 0;
  for (const double of_tet : out.distortion_J_N2) {
    EXPECT_GE(of_tet, 0);
    sum += of_tet;
  }
  EXPECT_NEAR(sum / (out.compliance_m_N(2, 2) / 2), 1, 0.25);
}

// A column of 20 x 20 x 100 mm, held below, under a patch on its top: a beam of Timoshenko's.
PatchResponse press_column(double radius_m) {
  return press_on(structured_block({0.02, 0.02, 0.1}, {4, 4, 20}), {0.0101, 0.0099, 0.1}, radius_m);
}

TEST(Sway, of_a_column_is_that_of_a_beam) {
  const Mat3 sway = press_column(0.0015).sway_m_N;
  const double side = 0.02, length = 0.1, shear_Pa = kYoung_Pa / (2 * (1 + kPoisson));
  const double bending = std::pow(length, 3) / (3 * kYoung_Pa * std::pow(side, 4) / 12) +
                         length / (5.0 / 6 * shear_Pa * side * side);
  EXPECT_NEAR(sway(0, 0) / bending, 1, 0.06);  // the ring is 2 mm below the end
  EXPECT_NEAR(sway(1, 1) / bending, 1, 0.06);
  EXPECT_NEAR(sway(2, 2) / (length / (kYoung_Pa * side * side)), 1, 0.08);
  EXPECT_LT(std::abs(sway(0, 1)), 0.01 * bending);
  EXPECT_TRUE(sway.isApprox(sway.transpose(), 1e-12));
}

TEST(Sway, is_not_told_where_the_surface_around_the_contact_ends) {
  EXPECT_TRUE(press_column(0.006).sway_m_N.isZero(0));
}

TEST(PressPatch, nothing_comes_of_a_patch_that_meets_no_face) {
  const TetMesh base = structured_block({0.1, 0.1, 0.06}, {2, 2, 2});
  const QuadraticMesh mesh = ungraded(base, held_below(base.nodes, 1e-6));
  const PatchResponse out = press_patch(mesh, static_cast<std::size_t>(base.tets.rows()), soft(),
                                        {}, -Vec3::UnitX(), 0.001);
  EXPECT_TRUE(out.compliance_m_N.isZero(0));
  EXPECT_TRUE(out.distortion_J_N2.empty());
}

constexpr double kCoarseRatio = 1.6, kMaxBaseError = 0.01;

BaseRefinement refine_at_rest(const PressPatch& press) {
  return refine_base(press, kCoarseRatio, Vec3::UnitZ(), kMaxBaseError);
}

TEST(RefineBase, halves_the_few_tets_that_hold_nine_tenths_of_the_distortion) {
  const PatchResponse whole{Mat3::Identity(), {0.01, 6, 0.02, 3.5, 0.5}};
  std::vector<char> asked;
  const auto press = [&](double, const std::vector<char>& halved) {
    if (halved.empty()) return whole;
    asked = halved;
    return PatchResponse{0.97 * Mat3::Identity(), {}};
  };
  const BaseRefinement out = refine_at_rest(press);
  EXPECT_EQ(asked, (std::vector<char>{0, 1, 0, 1, 0}));
  EXPECT_EQ(out.halved, asked);
  EXPECT_NEAR(out.error, 0.03 / 3, 1e-15);
}

TEST(RefineBase, leaves_whole_what_halving_hardly_changes_and_owns_up_to_it) {
  const auto press = [&](double, const std::vector<char>& halved) {
    return PatchResponse{(halved.empty() ? 1.0 : 1.002) * Mat3::Identity(), {1, 2}};
  };
  const BaseRefinement out = refine_at_rest(press);
  EXPECT_TRUE(out.halved.empty());
  EXPECT_NEAR(out.error, 4.0 / 3 * 0.002, 1e-15);
}

TEST(RefineBase, a_force_that_turns_has_changed) {
  const auto press = [&](double, const std::vector<char>& halved) {
    Mat3 compliance_m_N = Mat3::Identity();
    if (halved.empty()) compliance_m_N(0, 2) = 0.01;
    return PatchResponse{compliance_m_N, {1, 2}};
  };
  EXPECT_NEAR(refine_at_rest(press).error, 0.01 / 3, 1e-15);
}

// A finger bends aside under a ball that slides, and not under one that sticks.
TEST(RefineBase, a_patch_that_is_free_to_go_aside_counts_too) {
  const auto press = [](double, const std::vector<char>& halved) {
    Mat3 stiffness_N_m = Mat3::Identity();
    stiffness_N_m(0, 2) = stiffness_N_m(2, 0) = 0.5;
    stiffness_N_m(0, 0) = halved.empty() ? 0.49 : 0.5;  // sticking, along z it is the same
    return PatchResponse{stiffness_N_m.inverse(), {1, 2}};
  };
  const double whole = 1 - 0.25 / 0.49, finer = 1 - 0.25 / 0.5;
  const BaseRefinement out = refine_at_rest(press);
  EXPECT_FALSE(out.halved.empty());
  EXPECT_NEAR(out.error, (1 - whole / finer) / 3, 1e-12);
}

// A coarse grid is too stiff by more where tets are whole; that is the grid's error, not the
// base's.
TEST(RefineBase, what_the_grids_hide_is_not_taken_for_the_base_mesh) {
  for (const double base : {0.003, 0.009}) {
    int asked = 0;
    const auto press = [&](double coarsening, const std::vector<char>& halved) {
      ++asked;
      const double stiffness = halved.empty() ? 1 + base + 0.003 * coarsening * coarsening : 1.0;
      return PatchResponse{Mat3::Identity() / stiffness, {1, 2}};
    };
    const BaseRefinement out = refine_at_rest(press);
    EXPECT_EQ(asked, 4);
    EXPECT_EQ(out.halved.empty(), base < 0.0075) << base;
    EXPECT_NEAR(out.error, (out.halved.empty() ? 4 * base : base) / 3, 1e-12);
  }
}

/// A plate of 60 x 40 x 6 mm clamped along one edge, pressed by a ball of 5 mm near the other.
SimulationSetup plate(std::array<int, 3> cells) {
  SimulationSetup setup;
  setup.volume = structured_block(Vec3(0.06, 0.04, 0.006), cells);
  for (Eigen::Index n = 0; n < setup.volume.nodes.rows(); ++n)
    setup.is_held.push_back(setup.volume.nodes(n, 0) < 0.0131);
  setup.held_at = [](const Vec3& x, bool) { return x.x() < 0.0131; };
  setup.surface = {setup.volume.nodes, boundary_triangles(setup.volume.tets)};
  setup.materials = {{"neo-hookean", {kYoung_Pa, kPoisson}}};
  setup.probe = sphere_spec(0.005);
  return setup;
}

Samples press_plate(SimulationSetup setup, double depth_m = 0.002) {
  Experiments experiments;
  experiments.depth_m = depth_m;
  experiments.press_steps = 2;
  return simulate(Simulator(std::move(setup)), experiments_at(one_point({0.0447, 0.0183, 0.006})),
                  experiments, {.jobs = 1});
}

// Both grids of a row share the base mesh: without (M13d) a plate whose clamp ends within its
// elements is softer or stiffer by several times what the grids alone tell.
TEST(BaseRefinement, rows_of_a_thin_plate_are_within_the_error_that_they_state) {
  SimulationSetup unquestioned = plate({6, 4, 1});
  unquestioned.options.max_base_error = 0;
  unquestioned.held_at = {};
  const Samples refined = press_plate(plate({6, 4, 1})), before = press_plate(unquestioned),
                finer = press_plate(plate({12, 8, 2}));
  ASSERT_EQ(refined.rows(), finer.rows());
  for (Eigen::Index i = 0; i < finer.rows(); ++i) {
    ASSERT_EQ(refined.status[i], RowStatus::good);
    const double off_N = (refined.force.row(i) - finer.force.row(i)).norm();
    EXPECT_LT(off_N, refined.force_error[i] + finer.force_error[i]) << "row " << i;
    EXPECT_GT((before.force.row(i) - finer.force.row(i)).norm(), 2 * before.force_error[i])
        << "row " << i;
  }
}

// Fibres of 4 k1 beside a matrix of E carry tension alone, so the plate bends as a beam of
// Engesser's reduced modulus, 4 E1 E2 / (sqrt E1 + sqrt E2)^2; at rest its tangent has E alone, 2.4
// times less.
TEST(Sway, of_a_plate_of_fibres_is_that_of_its_reduced_modulus) {
  const double fibres_Pa = 4 * kYoung_Pa;
  SimulationSetup fibrous = plate({12, 8, 2});
  fibrous.materials = {
      {"holzapfel-gasser-ogden",
       {kYoung_Pa / (2 * (1 + kPoisson)), fibres_Pa / 4, 1, 1, 0, 0, 0, kPoisson}}};
  const double matrix = press_plate(plate({12, 8, 2}), 0.001).point_sway(0, 2),
               both = press_plate(std::move(fibrous), 0.001).point_sway(0, 2);
  const double sum = std::sqrt(kYoung_Pa) + std::sqrt(kYoung_Pa + fibres_Pa);
  EXPECT_NEAR(matrix / both, 4 * (kYoung_Pa + fibres_Pa) / (sum * sum), 0.25);
}

}  // namespace
}  // namespace palpate::fem
