// What `prepare` makes of a region and of what the tool can reach there.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "libfit/io/files/files.hpp"
#include "tests/libfit/refine/surfaces.hpp"
#include "tests/support/surfaces.hpp"
#include "tests/support/voxels.hpp"
#include "tests/tools/command_line.hpp"
#include "tools/scene/canonical.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;
using palpate::testing_support::voxel_surface;

using palpate::testing_support::off_of;

// frame: as 3D Slicer states it in a comment.
std::string off_in_frame(const Surface& surface, const std::string& frame) {
  return replaced(off_of(surface, 1e3), "OFF\n", "OFF\n# SPACE=" + frame + "\n");
}

// A body held below, a ball of 5 mm that presses 3 mm deep.
class Region : public testing::Test {
 protected:
  Outcome prepare(const Surface& surface, const std::string& experiments) {
    folder.write("body.off", frame.empty() ? off_of(surface, 1e3) : off_in_frame(surface, frame));
    folder.write("scene.toml",
                 "[body]\nsurface = \"body.off\"\nlength_unit = \"mm\"\n"
                 "fixed = [ { below = { axis = \"z\", at = \"0.5 mm\" } } ]\n"
                 "[material]\nyoung = \"10 kPa\"\n[probe]\nradius = \"5 mm\"\n"
                 "[experiments]\ndepth = \"3 mm\"\ndrag_depths = []\n" +
                     experiments);
    return palpate(folder, "prepare scene.toml -o body.h5");
  }
  Body body() const { return read_body(folder / "body.h5"); }
  Folder folder;
  std::string frame;
};

// The surface as OBJ in mm, with the faces of which all corners lie at z = 0 in the group "bottom".
std::string painted_obj_of(const Surface& surface) {
  std::string text;
  for (const auto& p : surface.vertices.rowwise())
    text += "v " + std::to_string(1e3 * p[0]) + " " + std::to_string(1e3 * p[1]) + " " +
            std::to_string(1e3 * p[2]) + "\n";
  for (const auto& t : surface.triangles.rowwise()) {
    double top = 0;
    for (int k = 0; k < 3; ++k) top = std::max(top, surface.vertices(t[k], 2));
    text += top < 1e-6 ? "g bottom\nf" : "g rest\nf";
    for (const int corner : t) text += " " + std::to_string(corner + 1);
    text += "\n";
  }
  return text;
}

// The body is filled from a coarser surface than the painted one.
TEST_F(Region, what_is_painted_on_the_mesh_is_held_and_left_out_as_that_part_of_space) {
  const Surface block = voxel_surface({20, 20, 12}, 2e-3, [](const Vec3&) { return true; });
  folder.write("body.obj", painted_obj_of(block));
  const auto prepared = [&](const std::string& fixed) {
    folder.write("painted.toml",
                 "[body]\nsurface = \"body.obj\"\nlength_unit = \"mm\"\nfixed = [ " + fixed +
                     " ]\n[material]\nyoung = \"10 kPa\"\n[probe]\nradius = \"5 "
                     "mm\"\n[experiments]\ndepth = \"3 mm\"\ndrag_depths = []\n"
                     "test_points = 8\n");
    const Outcome made = palpate(folder, "prepare painted.toml -o body.h5");
    EXPECT_EQ(made.status, 0) << made.err;
    return body();
  };
  const Body painted = prepared("{ group = \"bottom\" }"),
             below = prepared("{ below = { axis = \"z\", at = \"0.01 mm\" } }");
  EXPECT_EQ(painted.is_held, below.is_held);
  EXPECT_GT(std::count(painted.is_held.begin(), painted.is_held.end(), 1), 4);
  EXPECT_EQ(painted.in_region, below.in_region);
  EXPECT_EQ(painted.test_points.position, below.test_points.position);
}

// The tool meets the smooth surface in the simulator, and the engine slides on the triangles.
TEST_F(Region, triangles_of_a_round_body_are_divided_until_they_are_near_the_smooth_surface) {
  constexpr double kRadius_m = 0.03;
  const Vec3 middle(0, 0, 0.5 * kRadius_m);
  Surface ball = testing_refine::icosphere(2, kRadius_m);
  ball.vertices.rowwise() += middle.transpose();
  const Outcome made =
      prepare(ball,
              "test_points = 8\nregion = { sphere = { center = [\"0 mm\", \"0 mm\", "
              "\"45 mm\"], radius = \"15 mm\" } }\n");
  ASSERT_EQ(made.status, 0) << made.err;
  const auto farthest_m = [&](const Surface& surface) {
    double most = 0;
    for (const auto& t : surface.triangles.rowwise())
      for (int k = 0; k < 3; ++k) {
        const Vec3 a = surface.vertices.row(t[k]), b = surface.vertices.row(t[(k + 1) % 3]);
        if (std::min(a[2], b[2]) > 1.3 * kRadius_m)
          most = std::max(most, kRadius_m - ((a + b) / 2 - middle).norm());
      }
    return most;
  };
  EXPECT_GT(farthest_m(ball), 0.3e-3);
  EXPECT_LT(farthest_m(body().surface), 0.07e-3) << "1 % of 3 mm, and as much of the smooth one";
}

// 40 x 40 x 24 mm with a groove along y, 4 mm wide and 6 mm deep.
Surface grooved() {
  return voxel_surface({20, 20, 12}, 2e-3, [](const Vec3& x) {
    return std::abs(x.x() - 0.02) > 2e-3 || x.z() < 0.018;
  });
}

TEST_F(Region, test_points_leave_out_a_groove_that_the_ball_bridges_and_curves_go_across_it) {
  const Outcome made = prepare(grooved(), "test_points = 12\n");
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_TRUE(holds(made.err, "out of reach: "));
  const Body grooved_body = body();
  for (const auto& at : grooved_body.test_points.position.rowwise())
    EXPECT_FALSE(std::abs(at.x() - 0.02) < 2.5e-3 && at.z() > 0.0179 &&
                 std::abs(at.y() - 0.02) < 0.0199)
        << at;
  int gap = 0;
  for (std::size_t v = 0; v < grooved_body.in_region.size(); ++v) {
    EXPECT_LE(grooved_body.is_reachable[v], grooved_body.in_region[v]);
    gap += grooved_body.in_region[v] && !grooved_body.is_reachable[v];
  }
  EXPECT_GT(gap, 100);
  EXPECT_EQ(grooved_body.test_points.position.rows(), 12);
}

TEST_F(Region, given_points_that_the_tool_cannot_touch_are_left_out_and_listed) {
  folder.write("points.csv", "x_m,y_m,z_m\n0.01,0.02,0.024\n0.02,0.02,0.018\n0.03,0.02,0.024\n");
  const Outcome made = prepare(grooved(), "test_points = \"points.csv\"\n");
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_TRUE(holds(made.err, "left out: p0002 at (20.0, 20.0, 18.0) mm"));
  EXPECT_EQ(body().test_points.name, (std::vector<std::string>{"p0001", "p0003"}));
  folder.write("points.csv", "x_m,y_m,z_m\n0.02,0.02,0.018\n");
  const Outcome none = prepare(grooved(), "test_points = \"points.csv\"\n");
  EXPECT_EQ(none.status, 1);
  EXPECT_TRUE(holds(none.err, "the tool can touch at none"));
}

// A plate of 60 x 60 x 4 mm on a pillar, so that it has a back.
Surface slab() {
  return voxel_surface({30, 30, 12}, 2e-3, [](const Vec3& x) {
    return x.z() > 0.02 || (std::abs(x.x() - 0.03) < 0.01 && std::abs(x.y() - 0.03) < 0.01);
  });
}

// Lowest and highest z of the region, and how far it goes from a place [m].
struct Extent {
  double low = 1, high = -1, farthest = 0;
};
Extent extent_of(const Body& body, const Vec3& from) {
  Extent extent;
  for (Eigen::Index v = 0; v < body.surface.vertices.rows(); ++v) {
    if (!body.in_region[static_cast<std::size_t>(v)]) continue;
    const Vec3 at = body.surface.vertices.row(v);
    extent.low = std::min(extent.low, at.z());
    extent.high = std::max(extent.high, at.z());
    extent.farthest = std::max(extent.farthest, (at - from).norm());
  }
  return extent;
}

TEST_F(Region, a_sphere_leaves_out_the_back_of_a_plate_round_its_rim) {
  const Outcome made =
      prepare(slab(),
              "test_points = 9\nregion = { sphere = { center = [0.03, 0.012, 0.024], radius = "
              "\"20 mm\" } }\n");
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_TRUE(holds(made.err, "the patch nearest to its centre"));
  const Extent extent = extent_of(body(), {0.03, 0.012, 0.024});
  EXPECT_GT(extent.low, 0.0201) << "nothing of the underside, though the rim is in the sphere";
  EXPECT_NEAR(extent.farthest, 0.02, 2e-3) << "the face up to the sphere";
}

// 24 x 24 x 8 mm about the middle of the block's top, as numbers and as a file with a stray corner
// given twice.
TEST_F(Region, the_inside_of_a_closed_surface_is_the_box_that_it_encloses) {
  const Surface block = voxel_surface({20, 20, 12}, 2e-3, [](const Vec3&) { return true; });
  Surface box = voxel_surface({1, 1, 1}, 1, [](const Vec3&) { return true; });
  const Vec3 low(8.3e-3, 8.3e-3, 20.3e-3), high(32.3e-3, 32.3e-3, 28.3e-3);
  for (auto corner : box.vertices.rowwise())
    corner = low.transpose() + corner.cwiseProduct((high - low).transpose());
  box.vertices.conservativeResize(box.vertices.rows() + 1, 3);
  box.vertices.bottomRows<1>() = box.vertices.row(box.triangles(0, 0));
  box.triangles(0, 0) = static_cast<std::int32_t>(box.vertices.rows() - 1);
  folder.write("box.off", off_of(box, 1e3));
  const std::string numbers =
                        "box = [[\"8.3 mm\", \"8.3 mm\", \"20.3 mm\"], [\"32.3 mm\", "
                        "\"32.3 mm\", \"28.3 mm\"]]",
                    file = "inside = \"box.off\"";
  const auto scene = [](const std::string& part) {
    return "test_points = 12\nregion = { " + part + " }\n[[inclusion]]\n" + part +
           "\nmaterial = { young = \"40 kPa\" }\n";
  };
  ASSERT_EQ(prepare(block, scene(numbers)).status, 0);
  const Body by_numbers = body();
  const Outcome made = prepare(block, scene(file));
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_TRUE(holds(made.err, "box.off: "));
  const Body by_file = body();
  EXPECT_GT(std::count(by_file.in_region.begin(), by_file.in_region.end(), 1), 50);
  EXPECT_EQ(by_file.in_region, by_numbers.in_region);
  EXPECT_EQ(by_file.test_points.position, by_numbers.test_points.position);

  // Where the file's frame is the other one of RAS and LPS, it is turned into the body's.
  Surface turned = box;
  turned.vertices.leftCols<2>() *= -1;
  folder.write("box.off", off_in_frame(turned, "RAS"));
  frame = "LPS";
  const Outcome in_two = prepare(block, scene(file));
  ASSERT_EQ(in_two.status, 0) << in_two.err;
  EXPECT_TRUE(holds(in_two.err, "is in RAS, and turned"));
  EXPECT_EQ(body().in_region, by_numbers.in_region);
  folder.write("box.off", off_of(box, 1e3));
  const Outcome in_one = prepare(block, scene(file));
  EXPECT_TRUE(holds(in_one.err, "states no frame, and body.off states LPS"));
  folder.write("box.off", off_in_frame(box, "SPL"));
  EXPECT_EQ(prepare(block, scene(file)).status, 1);

  const tools::Region stored = scene_of(by_file, "body.h5").inclusions.at(0).region,
                      given = scene_of(by_numbers, "body.h5").inclusions.at(0).region;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> along(0, 0.04);
  for (int i = 0; i < 10000; ++i) {
    const Vec3 place(along(random), along(random), along(random));
    ASSERT_EQ(contains(stored, place), contains(given, place)) << place.transpose();
  }
}

}  // namespace
}  // namespace palpate::tools
