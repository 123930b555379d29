// Thin bodies, bodies held at a side, and thick ones: forces on the default base mesh against one
// 2.5 times as fine, row by row with the errors that both state (M13d). None of these bodies chose
// a constant but the spindle, the palm, the fingers and the hand beside its webs, whose base has to
// be close to the surface near the tool. Places of the last four are drawn among those that their
// scenes touch.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

#include "libfem/mesh/read/read.hpp"
#include "libfem/solve/experiments/simulate.hpp"
#include "libfit/core/statistics.hpp"
#include "tests/support/shared_data.hpp"
#include "tests/validation/record.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/samples/experiment_table.hpp"

namespace palpate::tools {
namespace {

constexpr double kFiner = 2.5;

/// surface: a file, shipped or shared, whose unit is `scale_mm`, or empty for an ellipsoid of these
/// semi-axes.
/// places_mm: near the surface.
struct BodyCase {
  const char* name;
  const char* surface;
  double scale_mm;
  Vec3 semi_axes_mm;
  const char* fixed;
  double radius_mm, depth_mm;
  std::vector<Vec3> places_mm;
};

const BodyCase kBodies[] = {
    {"spindle held at its ends",
     "",
     1,
     {70, 22, 7},
     "{ below = { axis = \"x\", at = \"-56 mm\" } }, { above = { axis = \"x\", at = \"56 mm\" } }",
     5,
     3,
     {{0, 0, 7}, {20, 5, 6.4}, {-38, 0, 5.9}, {35, -8, 5.5}}},
    {"ellipsoid held below",
     "",
     1,
     {60, 45, 35},
     "{ below = { axis = \"z\", at = \"-28 mm\" } }",
     6,
     5,
     {{0, 0, 35}, {25, 10, 31}, {-40, 0, 26}, {0, -35, 22}}},
    {"fingers held at their roots",
     "data/surfaces/odedstein_hand_closed.obj",
     200,
     {},
     "{ below = { axis = \"y\", at = \"120 mm\" } }",
     5,
     3,
     {{-24.9, 136.3, 3.3}, {1.1, 137.3, 2.5}, {24, 136.3, 6.7}, {4.1, 154, 4.3}}},
    {"palm held at its back",
     "data/surfaces/odedstein_hand_closed.obj",
     200,
     {},
     "{ above = { axis = \"z\", at = \"27 mm\" } }",
     5,
     4,
     {{-9.2, 66.4, -6.2}, {-3, 41.1, -10.1}, {10.7, 86.8, 2.3}, {-20.4, 56.2, -5.6}}},
    {"hand, beside its webs",
     "data/surfaces/odedstein_hand_closed.obj",
     200,
     {},
     "{ above = { axis = \"z\", at = \"22.8 mm\" } }",
     3.1,
     3.1,
     {{22.8, 96.8, 12.6}, {7.1, 89.8, 1.5}, {-19.1, 117.5, 4.3}, {-4.9, 120.5, 3.6}}},
    {"liver held 11 cm below",
     "data/surfaces/sofa_liver.vtk",
     1,
     {},
     "{ below = { axis = \"z\", at = \"85 mm\" } }",
     8,
     5,
     {{57.8, 100.7, 180.6}, {69.4, 102, 191.6}, {62.4, 95.2, 180.1}, {100.7, 125.1, 198.9}}},
    {"breast held at the chest wall",
     "data/bodies/breast.obj",
     1,
     {},
     "{ below = { axis = \"z\", at = \"-19.5 mm\" } }",
     8,
     8,
     {{10.7, 25.1, 26.9}, {41.5, 18.7, 18.1}, {6.5, -9.5, 37.1}, {19.7, 21.9, 26.4}}},
    {"clot on a table",
     "data/bodies/clot.obj",
     1,
     {},
     "{ below = { axis = \"z\", at = \"0.1 mm\" } }",
     6,
     5,
     {{-3, -4.4, 16}, {10, 9.5, 15.4}, {6, -8.8, 15.7}, {11.6, -2.6, 15.7}}},
    {"cylinder held at its ends",
     "data/bodies/cylinder.obj",
     1,
     {},
     "{ below = { axis = \"z\", at = \"3 mm\" } }, { above = { axis = \"z\", at = \"97 mm\" } }",
     5,
     6,
     {{0, 30, 63.6}, {-23, 19.3, 45.5}, {10.3, 28.2, 72.7}, {29.9, -2.6, 31.8}}},
    {"elephant held behind",
     "data/surfaces/cgal_elephant-with-holes.off",
     1000,
     {},
     "{ above = { axis = \"x\", at = \"185.9 mm\" } }",
     10,
     10,
     {{-192.7, -70, 138}, {-248, -143.8, -71.2}, {-191.1, -40, 118.8}, {-218.1, -83.6, 106.2}}},
};

std::filesystem::path file_of(const BodyCase& of) {
  const std::filesystem::path shipped = std::filesystem::path(PALPATE_SOURCE_DIR) / of.surface;
  return std::filesystem::exists(shipped) ? shipped : testing_support::shared_data(of.surface);
}

/// Rings of 96 vertices about the x axis.
Surface ellipsoid(const Vec3& semi_axes_m) {
  constexpr int kRings = 64, kSides = 96;
  Surface out;
  out.vertices.resize(2 + (kRings - 1) * kSides, 3);
  out.triangles.resize(2 * (kRings - 1) * kSides, 3);
  out.vertices.row(0) = Eigen::RowVector3d(-semi_axes_m.x(), 0, 0);
  out.vertices.row(1) = Eigen::RowVector3d(semi_axes_m.x(), 0, 0);
  const auto at = [](int ring, int side) { return 2 + (ring - 1) * kSides + side % kSides; };
  Eigen::Index t = 0;
  const auto add = [&](int a, int b, int c) { out.triangles.row(t++) << a, b, c; };
  for (int r = 1; r < kRings; ++r)
    for (int s = 0; s < kSides; ++s) {
      const double u = std::numbers::pi * r / kRings, v = 2 * std::numbers::pi * s / kSides;
      out.vertices.row(at(r, s)) = semi_axes_m.cwiseProduct(
          Vec3(-std::cos(u), std::sin(u) * std::cos(v), std::sin(u) * std::sin(v)));
      if (r == 1) add(0, at(1, s + 1), at(1, s));
      if (r == kRings - 1) add(1, at(r, s), at(r, s + 1));
      if (r == kRings - 1) continue;
      add(at(r, s), at(r, s + 1), at(r + 1, s));
      add(at(r, s + 1), at(r + 1, s + 1), at(r + 1, s));
    }
  return out;
}

std::filesystem::path write_obj(const Surface& surface, const std::filesystem::path& path) {
  std::ofstream out(path);
  out.precision(9);
  for (const auto& v : surface.vertices.rowwise()) out << "v " << v << '\n';
  for (const auto& f : surface.triangles.rowwise()) out << "f " << f.array() + 1 << '\n';
  return path;
}

/// is_close: the base to the surface, near the tool.
Samples pressed(const BodyCase& of, const std::filesystem::path& surface, double mesh_size_mm,
                double& edge_mm, double force_tolerance = 0, bool is_close = true) {
  const std::filesystem::path path = surface.parent_path() / "scene.toml";
  std::ofstream(path) << "[body]\nsurface = \"" << surface.string() << "\"\nlength_unit = \"m\"\n"
                      << (mesh_size_mm > 0
                              ? "mesh_size = \"" + std::to_string(mesh_size_mm) + " mm\"\n"
                              : std::string())
                      << "fixed = [ " << of.fixed << " ]\n[material]\nyoung = \"10 kPa\"\n"
                      << "poisson = 0.45\n[probe]\nradius = \"" << of.radius_mm
                      << " mm\"\n[experiments]\ntest_points = 4\ndepth = \"" << of.depth_mm
                      << " mm\"\npress_steps = 4\nforce_tolerance = " << force_tolerance << '\n';
  const Scene scene = open_scene(path);
  Body body = prepare_body(scene, false);
  if (!is_close) {
    body.in_region.clear();
    fill_with_tets(scene, body);
    body.is_held.clear();
    for (const auto& x : body.volume.nodes.rowwise())
      body.is_held.push_back(any_contains(scene.body.fixed, x.transpose(), false));
  }
  edge_mm = 0.28 * std::cbrt(volume_m3(body.surface)) * 1e3;
  PointTable places;
  places.position.resize(static_cast<Eigen::Index>(of.places_mm.size()), 3);
  for (std::size_t i = 0; i < of.places_mm.size(); ++i)
    places.position.row(static_cast<Eigen::Index>(i)) = 1e-3 * of.places_mm[i];
  fem::Experiments experiments = experiments_of(scene);
  experiments.drag_depths_m.clear();
  return fem::simulate(make_simulator(scene, body),
                       experiments_at(place_points(places, body.surface, "places")), experiments);
}

TEST(BaseMesh, rows_are_within_the_errors_that_they_state_on_bodies_that_chose_no_constant) {
  int rows = 0, within = 0, within_own = 0;
  for (const BodyCase& of : kBodies) {
    const bool has_file = *of.surface != 0;
    if (has_file && !std::filesystem::exists(file_of(of))) {
      std::printf("%s: needs shared data: %s\n", of.name, of.surface);
      continue;
    }
    const std::filesystem::path folder =
        std::filesystem::path(testing::TempDir()) / "palpate_base_mesh";
    std::filesystem::create_directories(folder);
    const std::filesystem::path surface =
        write_obj(has_file ? read_surface(file_of(of), 1e-3 * of.scale_mm)
                           : ellipsoid(1e-3 * of.semi_axes_mm),
                  folder / "surface.obj");
    double edge_mm = 0, finer_edge_mm = 0;
    const double begin_s = validation::cpu_seconds();
    const Samples coarse = pressed(of, surface, 0, edge_mm);
    const double cost_s = validation::cpu_seconds() - begin_s;
    const Samples fine = pressed(of, surface, edge_mm / kFiner, finer_edge_mm);
    ASSERT_EQ(coarse.rows(), fine.rows());
    std::vector<double> off, stated;
    int good = 0, own = 0;
    for (Eigen::Index i = 0; i < fine.rows(); ++i) {
      const auto row = static_cast<std::size_t>(i);
      if (coarse.status[row] != RowStatus::good || fine.status[row] != RowStatus::good) continue;
      const double off_N = (coarse.force.row(i) - fine.force.row(i)).norm();
      good += off_N <= coarse.force_error[i] + fine.force_error[i];
      own += off_N <= coarse.force_error[i];
      off.push_back(off_N / fine.force.row(i).norm());
      stated.push_back(coarse.force_error[i] / fine.force.row(i).norm());
    }
    ASSERT_FALSE(off.empty()) << of.name;
    rows += static_cast<int>(off.size());
    within += good;
    within_own += own;
    std::printf(
        "%-28s %2d of %2zu rows within both, %2d within their own, off by %4.1f %% (median) %4.1f "
        "(most), stated %.1f "
        "(median), %.0f CPU s\n",
        of.name, good, off.size(), own, 100 * quantile(off, 0.5),
        100 * *std::max_element(off.begin(), off.end()), 100 * quantile(stated, 0.5), cost_s);
    validation::record_case(std::string("base mesh: ") + of.name, 0, quantile(off, 0.5), "",
                            quantile(off, 0.5), cost_s);
  }
  std::printf("%d of %d rows within both, %d within their own\n", within, rows, within_own);
  EXPECT_GE(within, 0.95 * rows) << within << " of " << rows;
}

TEST(BaseMesh, a_finer_mesh_with_a_bump_under_the_tool_is_not_taken) {
  BodyCase of = *std::ranges::find(kBodies, std::string_view("hand, beside its webs"),
                                   [](const BodyCase& each) { return each.name; });
  if (!std::filesystem::exists(testing_support::shared_data(of.surface)))
    GTEST_SKIP() << "needs shared data: " << of.surface;
  of.places_mm.resize(1);
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "palpate_bump";
  std::filesystem::create_directories(folder);
  const std::filesystem::path surface =
      write_obj(read_surface(testing_support::shared_data(of.surface), 1e-3 * of.scale_mm),
                folder / "surface.obj");
  double edge_mm = 0;
  const Samples asked = pressed(of, surface, 0, edge_mm, 0.005, false);
  const Samples fine = pressed(of, surface, 7, edge_mm);
  for (Eigen::Index i = 0; i < fine.rows(); ++i)
    EXPECT_LT((asked.force.row(i) - fine.force.row(i)).norm(), 0.15 * fine.force.row(i).norm())
        << i;  // with bumps of a millimetre it was 19 to 60 %
}

}  // namespace
}  // namespace palpate::tools
