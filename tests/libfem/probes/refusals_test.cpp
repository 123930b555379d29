#include <gtest/gtest.h>

#include <algorithm>

#include "probe_cases.hpp"
#include "tests/support/error_of.hpp"

namespace palpate::fem {
namespace {

std::string message_of(const ProbeSpec& spec) {
  return testing_support::error_of([&] { make_probe(spec, "[probe]"); });
}

// All shapes, or those that take a key.
std::string shapes_with(std::string_view key) {
  std::string names;
  for (const ShapeRow& row : probe_shapes())
    if (key.empty() || std::ranges::count(probe_keys(row), key) > 0)
      names += (names.empty() ? "" : ", ") + std::string(row.name);
  return names;
}

std::string message_of(const Surface& surface, double smoothing_m = 0) {
  ProbeSpec spec;
  spec.shape = "mesh";
  spec.mesh = surface;
  if (smoothing_m > 0) spec.values["smoothing"] = {smoothing_m};
  return message_of(spec);
}

TEST(ProbeRefusals, name_the_number_and_the_known_shapes) {
  EXPECT_EQ(message_of(spec_of("spear", {})),
            "[probe]: unknown probe shape \"spear\"\n  Use one of: " + shapes_with("") + ".");
  EXPECT_EQ(message_of(sphere_spec(0)),
            "[probe]: radius must be positive, not 0.000000 m\n"
            "  Give it with its unit, for example radius = \"5 mm\".");
  EXPECT_EQ(message_of(sphere_spec(0.01, -0.1)),
            "[probe]: friction must be zero or positive, not -0.100000\n"
            "  Give the Coulomb coefficient of the interface, 0 for none.");
  EXPECT_EQ(message_of(sphere_spec(0.01)), "accepted");
  EXPECT_EQ(message_of(spec_of("sphere", {})), "accepted");  // 5 mm
}

TEST(ProbeRefusals, a_missing_key_is_shown_as_it_is_written) {
  EXPECT_EQ(message_of(spec_of("flat", {})),
            "[probe]: shape \"flat\" needs radius, of the rod\n  Add radius = \"5 mm\".");
  EXPECT_EQ(message_of(spec_of("flat", {{"radius", {0.1, 0.2}}})),
            "[probe]: radius must hold one number, not 2\n  Write radius = \"5 mm\".");
  EXPECT_EQ(message_of(spec_of("cone", {{"tip_radius", {0.001}}})),
            "[probe]: shape \"cone\" needs half_angle, between the axis and the flank\n"
            "  Add half_angle = \"30 deg\".");
}

TEST(ProbeRefusals, numbers_that_make_no_solid_are_explained) {
  const std::string correct = "\n  Correct the numbers of the probe.";
  EXPECT_EQ(message_of(spec_of("flat", {{"radius", {0.01}}, {"edge_radius", {0.02}}})),
            "[probe]: edge_radius must be from 0.02 to 1 times radius" + correct);
  EXPECT_EQ(message_of(spec_of("flat", {{"radius", {0.01}}, {"edge_radius", {0.0001}}})),
            "[probe]: edge_radius must be from 0.02 to 1 times radius" + correct);
  EXPECT_EQ(message_of(spec_of("capsule", {{"radius", {0.01}}, {"length", {0.019}}})),
            "[probe]: length must be at least two radii: it is measured from end to end" + correct);
  EXPECT_EQ(message_of(spec_of("cone", {{"half_angle", {1.5707}}, {"tip_radius", {0.001}}})),
            "[probe]: half_angle must be from 1 to 89 degrees" + correct);
  ProbeSpec spec = spec_of("capsule", {{"radius", {0.01}}, {"length", {0.04}}});
  spec.orientation = Vec3::Zero();
  EXPECT_EQ(message_of(spec),
            "[probe]: orientation is no direction\n  Write three numbers that are not all 0.");
}

TEST(ProbeRefusals, a_mesh_without_an_inside_is_refused_by_its_fault) {
  const Surface box = box_mesh(Vec3(0.004, 0.006, 0.01));
  EXPECT_EQ(message_of(box), "accepted");
  const auto fault = [](const Surface& surface) {
    const std::string text = message_of(surface);
    const std::string head = "[probe]: the probe's mesh has no inside: ";
    EXPECT_TRUE(text.starts_with(head)) << text;
    return text.substr(head.size(), text.find('\n') - head.size());
  };
  EXPECT_EQ(fault(Surface{}), "it has no triangle");
  Surface open = box;
  open.triangles.conservativeResize(11, 3);
  EXPECT_EQ(fault(open), "3 edges lie on a border");
  Surface turned = box;
  std::swap(turned.triangles(3, 0), turned.triangles(3, 1));
  EXPECT_EQ(fault(turned), "3 edges join triangles that face opposite ways");
  Surface inside_out = box;
  inside_out.triangles.col(0).swap(inside_out.triangles.col(1));
  EXPECT_EQ(fault(inside_out), "it points inward: its volume is not positive");
  Surface flat = box;
  flat.vertices.col(2).setZero();
  EXPECT_NE(message_of(flat).find("of the probe's mesh has no area"), std::string::npos);
  Surface wall = box;  // a sheet across the box, along existing edges
  wall.triangles.conservativeResize(14, 3);
  wall.triangles.row(12) << 0, 3, 7;
  wall.triangles.row(13) << 0, 7, 4;
  EXPECT_NE(fault(wall), "");
}

TEST(ProbeRefusals, a_mesh_whose_parts_share_an_edge_or_a_point_is_not_manifold) {
  const Surface box = box_mesh(Vec3(0.004, 0.006, 0.01));
  const auto twin = [&](const std::map<int, int>& shared) {
    Surface both = box;
    both.vertices.conservativeResize(16, 3);
    both.vertices.bottomRows(8) = box.vertices.rowwise() + Eigen::RowVector3d(0.008, 0.012, 0.02);
    both.triangles.conservativeResize(24, 3);
    for (int f = 0; f < 12; ++f)
      for (int k = 0; k < 3; ++k) {
        const int v = box.triangles(f, k);
        both.triangles(12 + f, k) = shared.count(v) ? shared.at(v) : 8 + v;
      }
    return both;
  };
  const auto holds = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(holds(message_of(twin({{0, 7}})), ": 1 vertex joins two sheets"));
  EXPECT_TRUE(holds(message_of(twin({{0, 7}, {1, 6}})), ": 1 edge has over two triangles"));
}

TEST(ProbeRefusals, smoothing_must_fit_the_mesh) {
  const Surface box = box_mesh(Vec3(0.004, 0.006, 0.01));
  EXPECT_EQ(
      message_of(box, 0.00001),
      "[probe]: smoothing of 0.010000 mm does not fit a mesh of 20.000000 mm\n"
      "  Give smoothing from 1/160 to 1/8 of the mesh's largest extent, or leave it out for 1/64.");
  EXPECT_EQ(message_of(box_mesh(Vec3(0.0001, 0.0001, 0.01)), 0.002),
            "[probe]: the mesh's tip is thinner than smoothing; give a smaller smoothing\n"
            "  Correct the numbers of the probe.");
}

}  // namespace
}  // namespace palpate::fem
