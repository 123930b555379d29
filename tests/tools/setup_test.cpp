// What `new` proposes of meshes that are coarse, of another unit, or open: `check` takes it.

#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "libfem/mesh/grade/smooth_surface.hpp"
#include "libfit/core/perception.hpp"
#include "tests/support/surfaces.hpp"
#include "tests/tools/block_scene.hpp"
#include "tools/scene/scene.hpp"
#include "tools/setup/check.hpp"
#include "tools/setup/propose.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;
using palpate::testing_support::coarse_block;
using palpate::testing_support::off_of;

TEST(Windows, are_thick_by_their_area_and_not_along_one_ray) {
  // A block with a pit of 24 mm in the middle of its top, where one ray would see 6 mm.
  Surface block =
      fem::divided_near(coarse_block(0.08, 0.08, 0.03), Vec3(0.04, 0.04, 0.03), 1, 0.004);
  for (auto p : block.vertices.rowwise())
    if (p[2] > 0.0299 && (p.head<2>().array() - 0.04).matrix().norm() < 0.003) p[2] -= 0.024;
  const Window window = windows_of(block, "-z").front();
  EXPECT_NEAR(window.centre[2], 0.006, 0.002) << "the ray through the middle ends in the pit";
  Window above = window;
  above.centre[2] = 0.03;
  EXPECT_NEAR(thickness_under_m(above, block), 0.03, 1e-3);
}

TEST(Windows, are_pressed_with_balls_that_are_felt_where_the_body_is_thick_enough) {
  const Surface block =
      fem::divided_near(coarse_block(0.08, 0.08, 0.03), Vec3(0.04, 0.04, 0.03), 0.03, 0.003);
  const Window window = windows_of(block, "-z").front();
  const double stiff_m = ball_for(window, block, 100e3, 0.49)->radius_m;
  EXPECT_NEAR(stiff_m, 0.03 / 8, 1e-4);
  const ProposedBall soft = *ball_for(window, block, 5.4e3, 0.49);
  EXPECT_GT(soft.radius_m, stiff_m);
  EXPECT_GT(soft.force_N * std::pow(3.0 / 7, 1.5), 0.95 * perception().force_floor_N)
      << "rounded to two digits";
  const ProposedBall softest = *ball_for(window, block, 200, 0.49);
  EXPECT_LE(softest.radius_m, 0.03 / 4);
  EXPECT_LT(softest.force_N, perception().force_floor_N) << "and `new` says so";
}

TEST(Doubts, are_of_organs_that_are_too_large_or_too_small_and_name_a_unit) {
  EXPECT_FALSE(doubt_of_size({194, 154, 156}, 1e-3));
  EXPECT_NE(doubt_of_size({0.94, 0.7, 0.3}, 1)->find("--unit \"dm\" makes it 94 x 70 x 30 mm"),
            std::string::npos)
      << *doubt_of_size({0.94, 0.7, 0.3}, 1);
  EXPECT_NE(doubt_of_size({2000, 900, 900}, 1e-3)->find("--unit \"0.1 mm\""), std::string::npos);
  EXPECT_NE(doubt_of_size({30, 28, 25}, 1e-3)->find("--unit \"cm\""), std::string::npos);
}

// The block of block_scene.hpp without its top (held side first), as an open tray.
std::string open_off(const std::string& closed, int cells) {
  std::istringstream in(closed);
  std::string off;
  int vertices = 0, faces = 0, zero = 0;
  in >> off >> vertices >> faces >> zero;
  std::string line, text;
  std::getline(in, line);
  for (int v = 0; v < vertices; ++v) std::getline(in, line), text += line + "\n";
  for (int f = 0; f < faces; ++f)
    if (std::getline(in, line); f >= 2 * cells * cells) text += line + "\n";
  return "OFF\n" + std::to_string(vertices) + " " + std::to_string(faces - 2 * cells * cells) +
         " 0\n" + text;
}

TEST(Check, doubts_a_lid_as_wide_as_the_body_and_a_wrap_that_does_nothing) {
  const BlockFolder folder;
  folder.write("block.off", open_off(block_off(8), 8));
  const Outcome open = palpate(folder, "check --no-trial --json scene.toml");
  EXPECT_EQ(open.status, 0) << open.err;
  EXPECT_TRUE(holds(open.err, "closed by a lid 80 mm wide on a body of 80 mm"));
  EXPECT_EQ(nlohmann::json::parse(open.out).at("warnings").size(), 1u) << open.out;

  folder.write("block.off", block_off(8));
  folder.write("scene.toml", replaced(kScene, "mesh_size", "wrap = \"2 mm\"\nmesh_size"));
  const Outcome needless = palpate(folder, "check --no-trial scene.toml");
  EXPECT_EQ(needless.status, 0) << needless.err;
  EXPECT_TRUE(holds(needless.err, "wrap changes nothing"));
  EXPECT_FALSE(holds(needless.err, "a lid"));

  folder.write("scene.toml", replaced(kScene, "mesh_size", "noise = \"0.2 mm\"\nmesh_size"));
  const Outcome smooth = palpate(folder, "check --no-trial scene.toml");
  EXPECT_TRUE(holds(smooth.err, "filtered noise of 0.2 mm"));
}

TEST(New, divides_a_window_of_twelve_triangles_and_check_takes_it) {
  const Folder folder;
  folder.write("block.off", off_of(coarse_block(80, 80, 30)));
  const Outcome made = palpate(folder, "new --json block.off -o s.toml </dev/null");
  ASSERT_EQ(made.status, 0) << made.err;
  const auto reply = nlohmann::json::parse(made.out);
  EXPECT_EQ(reply.at("divided"), (folder / "s.divided.off").string());
  EXPECT_TRUE(holds(content_of(folder / "s.toml"), "surface = \"s.divided.off\""));
  const Outcome checked = palpate(folder, "check --no-trial s.toml");
  EXPECT_EQ(checked.status, 0) << checked.err;
  const Outcome again =
      palpate(folder, "new block.off -o t.toml --tissue tendon-achilles-across </dev/null");
  EXPECT_EQ(again.status, 0) << again.err;
  // Its scene gone, the same mesh may be proposed anew; what was changed by hand stays.
  const auto anew = [&] {
    fs::remove(folder / "s.toml");
    return palpate(folder, "new block.off -o s.toml </dev/null");
  };
  const Outcome same = anew();
  EXPECT_EQ(same.status, 0) << same.err;
  std::ofstream(folder / "s.divided.off", std::ios::app) << "# mine\n";
  const std::string mine = content_of(folder / "s.divided.off");
  EXPECT_EQ(anew().status, 1);
  EXPECT_EQ(content_of(folder / "s.divided.off"), mine);
}

// A modelling program's cube, one vertex off by the last digit: dividing its sides leaves lengths
// of 1e-39 m and less where 0 is meant, which the reader took for misread bytes and blamed on the
// file.
TEST(New, writes_no_length_that_its_reader_refuses) {
  const Folder folder;
  folder.write("block.obj",
               "v 50 -50 -50\nv 50 -50 50\nv -50 -50 50\nv -50 -50 -50\nv 50 50 -49.9999\n"
               "v 49.9999 50 50.0001\nv -50 50 50\nv -50 50 -50\n"
               "f 2 4 1\nf 8 6 5\nf 5 2 1\nf 6 3 2\nf 3 8 4\nf 1 8 5\nf 2 3 4\nf 8 7 6\n"
               "f 5 6 2\nf 6 7 3\nf 3 7 8\nf 1 4 8\n");
  for (const std::string unit : {"mm", "m"})
    for (const std::string side : {"-x", "+x", "-y", "+y", "-z", "+z"}) {
      const Outcome made = palpate(folder, "new block.obj -o " + unit + side + ".toml --unit " +
                                               unit + " --held=" + side + " </dev/null");
      EXPECT_EQ(made.status, 0) << unit << side << made.err;
      EXPECT_TRUE(holds(made.err, "100 x 100 x 100 " + unit));
    }
}

// A block and one in it, both outward or the inner one inward, as OFF in mm.
std::string nested_off(bool is_cavity) {
  using palpate::testing_support::inside_out, palpate::testing_support::together;
  Surface inner = coarse_block(30, 30, 30);
  inner.vertices.array() += 25;
  return off_of(together(coarse_block(80, 80, 80), is_cavity ? inside_out(inner) : inner));
}

TEST(New, says_of_a_shell_inside_whether_it_is_a_cavity_and_that_none_floats) {
  const Folder folder;
  for (const bool is_cavity : {false, true}) {
    folder.write("nested.off", nested_off(is_cavity));
    const Outcome made =
        palpate(folder, std::string("new nested.off -o ") + (is_cavity ? "c" : "s") +
                            ".toml --unit mm </dev/null");
    EXPECT_EQ(made.status, 0) << made.err;
    EXPECT_TRUE(holds(made.err, is_cavity ? "it has 1 cavity" : "the body is solid there"));
    EXPECT_TRUE(holds(made.err, is_cavity ? ", 0.485 l" : ", 0.512 l"));
    EXPECT_FALSE(holds(made.err, "float away"));
  }
}

// A block of 80 x 80 x 30 mm as Gmsh writes it (MSH 2.2), six tetrahedra to a cube of 5 mm:
// physical groups "Fixed" below, "gel", and "lump" in its middle.
std::string block_msh() {
  constexpr int kX = 16, kZ = 6;
  const auto node = [&](int i, int j, int k) { return 1 + i + (kX + 1) * (j + (kX + 1) * k); };
  std::string nodes, elements;
  int count = 0;
  const auto add = [&](int type, int group, std::initializer_list<int> corners) {
    elements += fmt::format("{} {} 2 {} 1 {}\n", ++count, type, group, fmt::join(corners, " "));
  };
  for (int k = 0; k <= kZ; ++k)
    for (int j = 0; j <= kX; ++j)
      for (int i = 0; i <= kX; ++i)
        nodes += fmt::format("{} {} {} {}\n", node(i, j, k), 5 * i, 5 * j, 5 * k);
  constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (int k = 0; k < kZ; ++k)
    for (int j = 0; j < kX; ++j)
      for (int i = 0; i < kX; ++i) {
        const bool is_lump = k == 1 && i / 2 == 4 && j / 2 == 4;
        for (const auto& order : kOrders) {  // from corner to corner, an axis after another
          int at[3] = {i, j, k}, corner[4] = {node(i, j, k)};
          for (int step = 0; step < 3; ++step) {
            ++at[order[step]];
            corner[step + 1] = node(at[0], at[1], at[2]);
          }
          add(4, is_lump ? 3 : 2, {corner[0], corner[1], corner[2], corner[3]});
        }
        if (k > 0) continue;
        add(2, 1, {node(i, j, 0), node(i + 1, j + 1, 0), node(i + 1, j, 0)});
        add(2, 1, {node(i, j, 0), node(i, j + 1, 0), node(i + 1, j + 1, 0)});
      }
  return fmt::format(
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n2 1 \"Fixed\"\n3 2 \"gel\"\n3 3 "
      "\"lump\"\n$EndPhysicalNames\n$Nodes\n{}\n{}$EndNodes\n$Elements\n{}\n{}$EndElements\n",
      (kX + 1) * (kX + 1) * (kZ + 1), nodes, count, elements);
}

TEST(New, takes_the_physical_groups_of_gmsh) {
  const Folder folder;
  folder.write("block.msh", block_msh());
  const Outcome made = palpate(folder, "new block.msh -o s.toml </dev/null");
  ASSERT_EQ(made.status, 0) << made.err;
  std::string text = content_of(folder / "s.toml");
  for (const char* line :
       {"tetmesh = \"block.msh\"", "fixed = [ { group = \"Fixed\" } ]",
        "# The mesh marks \"gel\" (9192 tetrahedra), \"Fixed\" (512 faces), \"lump\" (24 "
        "tetrahedra).",
        "# [[inclusion]]\n# group = \"lump\"\n# material = { young = \"20 kPa\" }\n"})
    EXPECT_TRUE(holds(text, line)) << text;
  EXPECT_FALSE(holds(text, "group = \"gel\""));
  for (std::size_t at; (at = text.find("# [[inc")) != std::string::npos ||
                       (at = text.find("# group =")) != std::string::npos ||
                       (at = text.find("# material =")) != std::string::npos;)
    text.erase(at, 2);
  folder.write("lump.toml", text);
  const Outcome checked = palpate(folder, "check --no-trial lump.toml");
  EXPECT_EQ(checked.status, 0) << checked.err;
  const Outcome wrapped = palpate(folder, "new block.msh --wrap -o w.toml </dev/null");
  EXPECT_EQ(wrapped.status, 1);
  EXPECT_TRUE(holds(wrapped.err, "--wrap: is of a surface"));
}

TEST(New, doubts_the_unit_and_proposes_nothing_that_check_refuses) {
  const Folder folder;
  folder.write("block.off", block_off(8));
  const Outcome large = palpate(folder, "new block.off -o m.toml --unit m </dev/null");
  EXPECT_EQ(large.status, 0) << large.err;
  EXPECT_TRUE(holds(large.err, "larger than most organs"));
  EXPECT_TRUE(holds(large.err, "--unit \"mm\" makes it 80 x 80 x 30 mm"));
  // Which check fills for minutes.
  folder.write("sheet.off", off_of(coarse_block(200, 200, 0.01)));
  const Outcome sheet = palpate(folder, "new sheet.off -o sheet.toml --unit mm </dev/null");
  EXPECT_EQ(sheet.status, 1);
  EXPECT_TRUE(holds(sheet.err, "no side of it has a window that a ball can press: it is a sheet"));
  EXPECT_TRUE(holds(sheet.err, "\n  Give a closed surface"));
  EXPECT_FALSE(fs::exists(folder / "sheet.toml") || fs::exists(folder / "sheet.divided.off"));
}

}  // namespace
}  // namespace palpate::tools
