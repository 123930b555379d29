// What is refused or doubted of a scene that reads well and makes no sense.

#include <gtest/gtest.h>

#include "data/generators/structured_block.hpp"
#include "libfit/core/error.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/surfaces.hpp"
#include "tests/tools/block_scene.hpp"
#include "tools/stages/body/prepare.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

// The block of block_scene.hpp, 80 x 80 x 30 mm, as a surface.
Body block_body(double scale = 1) {
  Body body;
  body.surface = palpate::testing_support::coarse_block(scale * 0.08, scale * 0.08, scale * 0.03);
  return body;
}

Scene scene_with(const std::string& from, const std::string& to, const std::string& more = "") {
  return parse_scene(replaced(kScene, from, to) + more, "scene.toml");
}

const std::string kBall = R"([[inclusion]]
sphere = { center = ["40 mm", "40 mm", "%s mm"], radius = "5 mm" }
material = { young = "60 kPa", poisson = 0.45 }
)";

Scene with_ball_at(const std::string& height) {
  return scene_with("", "", replaced(kBall, "%s", height));
}

TEST(plausibility, a_scene_that_makes_sense_passes_without_a_word) {
  EXPECT_TRUE(implausible(scene_with("", ""), block_body()).empty());
}

// (M13f), lambda = mu of a Poisson's ratio of a quarter.
TEST(simulation_setup, a_bed_is_springs_of_its_thickness_and_slides_where_it_says_so) {
  const std::string bed =
      "[[bed]]\nbelow = { axis = \"z\", at = \"1 mm\" }\nthickness = \"10 mm\"\n"
      "material = { young = \"5 kPa\", poisson = 0.25 }\n";
  for (const bool slides : {false, true}) {
    const fem::SimulationSetup setup =
        make_setup(scene_with("", "", bed + (slides ? "slides = true\n" : "")), block_body());
    EXPECT_NEAR(setup.loads.bed_at(Vec3::Zero()).along_N_m3, 3 * 2000 / 0.01, 1e-6);
    EXPECT_NEAR(setup.loads.bed_at(Vec3::Zero()).across_N_m3, slides ? 0 : 2000 / 0.01, 1e-6);
    EXPECT_EQ(setup.loads.bed_at(Vec3(0, 0, 0.02)).along_N_m3, 0);
  }
}

// The block has 80 x 80 x 30 mm.
TEST(read_meshes, hollow_a_body_out_as_the_scene_says) {
  const BlockFolder folder;
  const auto read = [&](const std::string& keys) {
    Body body;
    const Scene scene =
        parse_scene(replaced(kScene, "fixed", keys + "\nfixed"), folder.path() / "scene.toml");
    read_meshes(scene, false, body);
    return body;
  };
  const Body body = read("wall = \"5 mm\"\npressure = \"1 kPa\"");
  const double lumen_m3 = 0.07 * 0.07 * 0.02;
  EXPECT_NEAR((0.08 * 0.08 * 0.03 - volume_m3(body.surface)) / lumen_m3, 1, 0.06);
  EXPECT_TRUE(holds(body.mended.back(), "hollowed out: 1 lumen of"));
  EXPECT_TRUE(holds(palpate::testing_support::error_of([&] { read("wall = \"20 mm\""); }),
                    "leaves no lumen"));
  EXPECT_TRUE(holds(palpate::testing_support::error_of([&] { read("pressure = \"1 kPa\""); }),
                    "pressure needs a lumen"));
}

struct Slip {
  const char* name;
  std::string from, to, expected;
  double scale = 1;
};
void PrintTo(const Slip& slip, std::ostream* out) { *out << slip.name; }

class Slips : public testing::TestWithParam<Slip> {};

INSTANTIATE_TEST_SUITE_P(
    Each, Slips,
    testing::Values(
        Slip{"modulus_without_unit", "young = \"10 kPa\"", "young = 10", "was \"10 kPa\" meant"},
        Slip{"modulus_of_steel", "\"10 kPa\"", "\"10 GPa\"", "Was \"10 kPa\" meant"},
        Slip{"modulus_in_MPa_for_kPa", "\"10 kPa\"", "\"10 MPa\"",
             "10 MPa, and no soft tissue is that stiff"},
        Slip{"probe_of_a_micrometre", "\"8 mm\"", "\"1 um\"", "Is its unit right"},
        Slip{"material_that_grows_thinner", "poisson = 0.45", "poisson = -0.9", "no tissue does"},
        Slip{"press_through_the_body", "depth = \"4 mm\"", "depth = \"29 mm\"",
             "smallest extent is 30 mm"},
        Slip{"noise_that_is_the_body", "length_unit = \"mm\"",
             "length_unit = \"mm\"\nnoise = \"50 mm\"", "takes its shape away"},
        Slip{"friction_of_five", "friction = 0.3", "friction = 5", "more than any tool"},
        Slip{"body_of_80_metres", "", "", "Is length_unit right", 1000},
        Slip{"body_of_18_micrometres", "", "", "Is length_unit right", 2.2e-4}),
    [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(Slips, is_doubted_with_the_likely_cause) {
  const auto warnings =
      implausible(scene_with(GetParam().from, GetParam().to), block_body(GetParam().scale));
  ASSERT_FALSE(warnings.empty());
  EXPECT_TRUE(holds(warnings[0], GetParam().expected));
}

// A block, and a copy moved by (x, y, z) and scaled about the origin before.
Body with_second_block(const Vec3& offset_m, double scale, bool is_cavity = false) {
  Body body = block_body();
  Surface second = body.surface;
  second.vertices = (scale * second.vertices).rowwise() + offset_m.transpose();
  if (is_cavity) second = palpate::testing_support::inside_out(second);
  body.surface = palpate::testing_support::together(body.surface, second);
  return body;
}

// A file of two blocks, one 200 mm away, was one body without a word.
TEST(plausibility, separate_parts_are_named_with_their_sizes_and_distance_and_cavities_are_not) {
  const auto doubts = doubts_of_shape(scene_with("", ""), with_second_block({0.2, 0, 0}, 0.5));
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_TRUE(holds(doubts[0],
                    "2 separate parts: 80 x 80 x 30 mm, 40 x 40 x 15 mm at a distance of "
                    "120 mm"));
  EXPECT_TRUE(doubts_of_shape(scene_with("", ""), with_second_block({0.02, 0.02, 0.01}, 0.4, true))
                  .empty());
}

// Gmsh without Coherence meshes each volume with nodes of its own: forces were those of two halves.
TEST(plausibility, a_tetmesh_that_is_cut_where_nodes_coincide_is_doubted_with_their_number) {
  Scene scene = scene_with("", "");
  scene.body.tetmesh = "cut.msh";
  Body body = block_body();
  body.volume.nodes = body.surface.vertices;
  EXPECT_TRUE(doubts_of_shape(scene, body).empty());
  body.volume.nodes.conservativeResize(12, 3);
  body.volume.nodes.bottomRows(4) = body.surface.vertices.bottomRows(4);
  const auto doubts = doubts_of_shape(scene, body);
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_TRUE(holds(doubts[0], "4 nodes of the tetmesh coincide"));
  EXPECT_TRUE(holds(doubts[0], "Coherence"));
}

TEST(plausibility, a_size_is_in_metres_from_one_metre_on) {
  EXPECT_EQ(size_in_words({0.94, 0.08, 0.03}, 0), "940 x 80 x 30 mm");
  EXPECT_EQ(size_in_words({0.9996, 0.7, 0.3}, 0), "1 x 0.7 x 0.3 m");
  EXPECT_EQ(size_in_words({2, 0.9, 0.9}, 1.62), "2 x 0.9 x 0.9 m, 1.62 m3");
}

TEST(plausibility, a_base_mesh_far_finer_than_its_edge_needs_is_doubted_with_the_remedy) {
  Body body = block_body();
  body.volume.tets = Tets::Zero(1000, 4);
  EXPECT_TRUE(implausible(scene_with("", ""), body).empty());
  body.volume.tets = Tets::Zero(183855, 4);
  const auto warnings = implausible(scene_with("", ""), body);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(holds(warnings[0], "183855 tets"));
  EXPECT_TRUE(holds(warnings[0], "13 GB of memory"));
}

TEST(plausibility, an_inclusion_is_measured) {
  const auto places = place_inclusions(with_ball_at("20"), block_body());
  ASSERT_EQ(places.size(), 1u);
  EXPECT_NEAR(places[0].volume_m3, 4.18879e-9 * 125, 0.02 * 5.236e-7);
  EXPECT_EQ(places[0].inside, 1);
  EXPECT_NEAR(places[0].depth_m, 0.005, 1e-9);
}

TEST(plausibility, the_share_of_an_inclusion_outside_the_body_is_measured) {
  const auto places = place_inclusions(with_ball_at("30"), block_body());
  EXPECT_NEAR(places[0].inside, 0.5, 0.02);
  EXPECT_EQ(places[0].depth_m, 0);
}

std::string layer(const std::string& thickness, const std::string& young) {
  return "[[layer]]\nthickness = \"" + thickness + " mm\"\nmaterial = { young = \"" + young +
         " kPa\", poisson = 0.45 }\n";
}

// The modulus at a place of a body.
double young_at(const fem::SimulationSetup& setup, const Vec3& place) {
  return setup.materials[setup.region_at ? setup.region_at(place) : 0].values[0];
}

TEST(layers, follow_one_another_below_the_outer_surface_and_end_at_no_cavity) {
  const Scene scene = scene_with("", "", layer("2", "100") + layer("3", "2"));
  const Body body = with_second_block({0.02, 0.02, 0.01}, 0.4, true);
  const fem::SimulationSetup setup = make_setup(scene, body);
  EXPECT_EQ(young_at(setup, {0.04, 0.04, 0.0281}), 100e3);
  EXPECT_EQ(young_at(setup, {0.0019, 0.04, 0.015}), 100e3);
  EXPECT_EQ(young_at(setup, {0.04, 0.04, 0.0279}), 2e3);
  EXPECT_EQ(young_at(setup, {0.04, 0.04, 0.0251}), 2e3);
  EXPECT_EQ(young_at(setup, {0.04, 0.04, 0.0249}), 10e3);
  EXPECT_EQ(young_at(setup, {0.03, 0.03, 0.0221}), 10e3) << "beside the cavity";
  const auto places = place_inclusions(scene, block_body());  // the deepest first
  const double fat_m3 = 0.08 * 0.08 * 0.03 - 0.07 * 0.07 * 0.02;
  EXPECT_NEAR(places[0].volume_m3, fat_m3, 0.1 * fat_m3);  // by samples 3 mm apart
}

TEST(layers, of_the_body_s_own_material_are_no_regions_and_two_of_one_material_are_their_sum) {
  EXPECT_FALSE(make_setup(scene_with("", "", layer("2", "10")), block_body()).region_at);
  const auto two =
                 make_setup(scene_with("", "", layer("2", "60") + layer("3", "60")), block_body()),
             one = make_setup(scene_with("", "", layer("5", "60")), block_body());
  ASSERT_EQ(two.materials.size(), 2u);
  for (int k = 0; k < 1000; ++k) {
    const Vec3 place(0.04, 0.04, 3e-5 * k);
    ASSERT_EQ(two.region_at(place), one.region_at(place)) << place.z();
  }
}

TEST(layers, without_thickness_or_constants_are_errors) {
  for (const std::string& text :
       {layer("0", "60"), layer("-2", "60"), std::string("[[layer]]\nmaterial = { young = 1 }\n"),
        std::string("[[layer]]\nthickness = 0.1\n"),
        std::string("[[layer]]\nthickness = 0.1\ngroup = \"a\"\n"
                    "material = { young = 1 }\n")})
    EXPECT_THROW(scene_with("", "", text), Error) << text;
}

TEST(plausibility, an_inclusion_beside_the_body_is_an_error) {
  EXPECT_THROW(place_inclusions(with_ball_at("50"), block_body()), Error);
}

// Tets of 10 x 10 x 5 mm bricks in the block, those marked whose middle has its z in a range.
Scene with_marked_layer(double low_m, double high_m) {
  TetMesh volume = fem::structured_block({0.08, 0.08, 0.03}, {8, 8, 6});
  std::vector<char> is_marked;
  for (const auto& tet : volume.tets.rowwise()) {
    Vec3 middle = Vec3::Zero();
    for (const std::int32_t n : tet) middle += volume.nodes.row(n) / 4;
    const bool is_in = middle.z() > low_m && middle.z() < high_m &&
                       std::abs(middle.x() - 0.04) < 0.02 && std::abs(middle.y() - 0.04) < 0.02;
    is_marked.push_back(is_in);
  }
  Scene scene = with_ball_at("20");
  scene.inclusions[0].region =
      Marked{{}, std::make_shared<const PaintedPart>(std::move(volume), std::move(is_marked))};
  return scene;
}

// Every group was said to reach the surface.
TEST(plausibility, an_inclusion_that_a_mesh_marks_is_measured_as_a_shape_is) {
  const auto inside = place_inclusions(with_marked_layer(0.01, 0.02), block_body());
  EXPECT_NEAR(inside[0].volume_m3, 1.6e-5, 1e-9);
  EXPECT_NEAR(inside[0].depth_m, 0.01, 1e-9);
  const auto top = place_inclusions(with_marked_layer(0.02, 0.03), block_body());
  EXPECT_NEAR(top[0].volume_m3, 1.6e-5, 1e-9);
  EXPECT_EQ(top[0].depth_m, 0);
}

}  // namespace
}  // namespace palpate::tools
