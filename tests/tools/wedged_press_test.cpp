// Presses that wedge are listed and not fitted, and a round of placement is not judged by points
// that the fit calls poor.

#include <gtest/gtest.h>

#include <cmath>

#include "libfit/io/files/files.hpp"
#include "tests/libfit/refine/blending.hpp"
#include "tests/tools/command_line.hpp"
#include "tools/stages/samples/placement.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;
using namespace testing_refine;

// A block of 60 x 60 mm, 20 mm high, with a step of 10 mm across it whose bank stands at 73
// degrees.
std::string step_off() {
  constexpr double kProfile_mm[6][2] = {{0, 0}, {60, 0}, {60, 30}, {33, 30}, {30, 20}, {0, 20}};
  std::string text = "OFF\n12 20 0\n";
  for (const int y_mm : {0, 60})
    for (const auto& [x_mm, z_mm] : kProfile_mm)
      text += std::to_string(x_mm) + " " + std::to_string(y_mm) + " " + std::to_string(z_mm) + "\n";
  text += "3 0 1 4\n3 0 4 5\n3 1 2 3\n3 1 3 4\n3 6 10 7\n3 6 11 10\n3 7 9 8\n3 7 10 9\n";
  for (int i = 0; i < 6; ++i) {
    const std::string a = std::to_string(i), b = std::to_string((i + 1) % 6),
                      c = std::to_string((i + 1) % 6 + 6), d = std::to_string(i + 6);
    text += "3 " + a + " " + d + " " + c + "\n3 " + a + " " + c + " " + b + "\n";
  }
  return text;
}

constexpr const char* kStepScene = R"([body]
surface = "step.off"
length_unit = "mm"
mesh_size = "15 mm"
fixed = [ { below = { axis = "z", at = "1 mm" } } ]
[material]
young = "10 kPa"
poisson = 0.3
[probe]
radius = "8 mm"
friction = 0.2
[experiments]
test_points = 4
region = { above = { axis = "z", at = "10 mm" } }
depth = "2 mm"
press_steps = 3
drag_depths = []
)";

TEST(WedgedPress, is_listed_kept_and_not_fitted) {
  const Folder folder;
  folder.write("step.off", step_off());
  folder.write("scene.toml", kStepScene);
  folder.write("p.csv",
               "x_m,y_m,z_m,nx,ny,nz\n0.0252,0.028,0.02,0,0,-1\n0.013,0.031,0.02,0,0,-1\n");
  const Outcome done = palpate(folder, "simulate scene.toml --points p.csv -o samples.h5");
  EXPECT_EQ(done.status, 3) << done.err;
  const std::size_t at = done.err.find("not good: p0001 at (25.2, 28.0, 20.0) mm, press from ");
  ASSERT_NE(at, std::string::npos) << done.err;
  EXPECT_NE(done.err.find("on: wedged: its force stands ", at), std::string::npos) << done.err;
  EXPECT_NE(done.err.find(" degrees off the press (", at), std::string::npos) << done.err;
  EXPECT_FALSE(holds(done.err, "not good: p0002"));

  const Samples read = read_samples(folder / "samples.h5");
  Eigen::Index wedged = 0;
  for (Eigen::Index row = 0; row < read.rows(); ++row)
    if (read.status[row] == RowStatus::wedged) {
      EXPECT_GT(read.force.row(row).norm(), 0) << "row " << row;
      ++wedged;
    }
  EXPECT_GT(wedged, 0);
  const Outcome fit = palpate(folder, "fit samples.h5 -o curves.h5 --pieces 1");
  EXPECT_TRUE(holds(fit.err, "(" + std::to_string(wedged) + " not good"));
}

// Presses at new points, of forces that are `factor` times what the field says at the first one.
Samples presses_at(const FittedCurves& known, const Surface& fine,
                   const std::vector<std::int32_t>& vertices, const Field& field, double factor) {
  constexpr int kSteps = 3;
  const auto count = static_cast<Eigen::Index>(vertices.size());
  Samples out;
  out.point_position.resize(known.position.rows() + count, 3);
  out.point_position << known.position, fine.vertices(vertices, Eigen::all);
  out.point_normal = Points::Zero(out.point_position.rows(), 3);
  out.point_normal.col(2).setConstant(-1);
  out.deflection = out.force = Points::Zero(kSteps * count, 3);
  out.force_error = Eigen::VectorXd::Zero(kSteps * count);
  for (Eigen::Index row = 0; row < kSteps * count; ++row) {
    const Eigen::Index i = row / kSteps;
    const double depth_m = 0.01 * static_cast<double>(row % kSteps + 1) / kSteps;
    const double stiffness_N = field(fine.vertices.row(vertices[i]));
    out.point.push_back(static_cast<std::int32_t>(known.position.rows() + i));
    out.experiment.push_back(out.point.back());
    out.kind.push_back(ExperimentKind::press);
    out.step.push_back(static_cast<std::int32_t>(row % kSteps));
    out.status.push_back(RowStatus::good);
    out.deflection(row, 2) = -depth_m;
    out.force(row, 2) = -stiffness_N * depth_m / 0.01 * (i == 0 ? factor : 1);
  }
  return out;
}

TEST(PlacementRound, that_confirms_a_round_within_the_tolerance_adds_twelve_at_most) {
  for (const bool is_quick : {false, true}) {
    EXPECT_EQ(round_size(12, is_quick, false), is_quick ? 6 : 4);
    EXPECT_EQ(round_size(90, is_quick, false), is_quick ? 45 : 22);
    EXPECT_EQ(round_size(90, is_quick, true), 12);
    EXPECT_EQ(round_size(12, is_quick, true), is_quick ? 6 : 4);
    EXPECT_EQ(round_size(1000, is_quick, false), 64);
  }
}

TEST(PlacementRound, is_not_judged_by_points_whose_fit_is_poor) {
  const Surface fine = plate(24, 24, 0.1, 0.1), coarse = plate(6, 6, 0.1, 0.1);
  const Field field = [](const Vec3& p) { return 2 + 10 * p.x() - 7 * p.y(); };
  const FittedCurves known = curves_at(coarse, field);
  const Model model = refine(known, fine, all(fine), coarse.triangles);
  const std::vector<std::int32_t> vertices{57, 133, 201, 346};
  const Samples samples = presses_at(known, fine, vertices, field, 1.0 / 3);
  std::vector<FitStatus> fits(samples.points(), FitStatus::good);
  const PlacementRound misled = judge_round(samples, model, vertices, fits);
  EXPECT_NEAR(misled.p95_rel, 2, 1e-4) << "else this test tells nothing";
  EXPECT_EQ(misled.rows, 12);

  fits[known.position.rows()] = FitStatus::poor;
  const PlacementRound round = judge_round(samples, model, vertices, fits);
  EXPECT_LT(round.p95_rel, 1e-4);
  EXPECT_LT(round.max_rel, 1e-4);
  EXPECT_EQ(round.poor, 1);
  EXPECT_EQ(round.rows, 9);
  EXPECT_EQ(round.points, 49);
  EXPECT_EQ(round.new_points, 4);

  std::fill(fits.begin(), fits.end(), FitStatus::poor);
  EXPECT_EQ(judge_round(samples, model, vertices, fits).rows, 0) << "which ends no placement";
}

}  // namespace
}  // namespace palpate::tools
