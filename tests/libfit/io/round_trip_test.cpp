#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "tests/libfit/io/examples.hpp"
#include "tests/libfit/io/scratch.hpp"

namespace palpate::testing_io {
namespace {

class RoundTrip : public ScratchTest {};

const Attributes kAttributes{{"inputs_hash", "00ff00ff00ff00ff"}, {"statement", R"({"a": 1})"}};

void expect_same(const CurveSet& a, const CurveSet& b) {
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(a.basis[k].degree, b.basis[k].degree);
    EXPECT_EQ(a.basis[k].knots_m, b.basis[k].knots_m);
    EXPECT_TRUE(same_bits(a.control[k], b.control[k])) << kCurveNames[k];
  }
}

void expect_same(const std::optional<ProbeSpec>& a, const std::optional<ProbeSpec>& b) {
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->shape, b->shape);
  EXPECT_EQ(a->values, b->values);
  EXPECT_TRUE(same_bits(a->mesh.vertices, b->mesh.vertices));
  EXPECT_TRUE(same_bits(a->mesh.triangles, b->mesh.triangles));
  EXPECT_EQ(a->orientation, b->orientation);
  EXPECT_EQ(a->friction, b->friction);
}

TEST_F(RoundTrip, samples_come_back_bit_for_bit) {
  const Samples a = example_samples();
  write_samples(at("s.h5"), a, kAttributes);
  const Samples b = read_samples(at("s.h5"));
  const auto same = [&](const char* name, auto column, auto&&...) {
    if constexpr (requires { (a.*column).rows(); }) {
      EXPECT_TRUE(same_bits(a.*column, b.*column)) << name;
    } else {
      EXPECT_TRUE(a.*column == b.*column) << name;
    }
  };
  each_point_column(same);
  each_row_column(same);
  EXPECT_TRUE(b.step_check.empty()) << "nobody checked";
  expect_same(a.probe, b.probe);
  EXPECT_EQ(a.poisson, b.poisson);
  EXPECT_EQ(read_attributes(at("s.h5")).at("inputs_hash"), "00ff00ff00ff00ff");
}

TEST_F(RoundTrip, what_checks_of_rows_found_comes_back_and_needs_one_entry_a_row) {
  Samples a = example_samples();
  for (std::size_t row = 0; row < a.status.size(); ++row)
    a.step_check.push_back(static_cast<StepCheck>(row % kStepCheckNames.size()));
  write_samples(at("s.h5"), a, {});
  EXPECT_EQ(read_samples(at("s.h5")).step_check, a.step_check);
  a.step_check.pop_back();
  EXPECT_THROW(write_samples(at("s.h5"), a, {}), Error);
}

// Points 0 and 2 are touched at once, in the last two rows; times are of the first experiment.
TEST_F(RoundTrip, rows_of_two_tools_and_in_time_come_back) {
  Samples a = example_samples();
  a.experiment = {0, 0, 0, 1, 2, 2};
  a.kind = {ExperimentKind::cycle, ExperimentKind::cycle, ExperimentKind::cycle,
            ExperimentKind::tool,  ExperimentKind::pair,  ExperimentKind::pair};
  a.point = {0, 0, 0, 2, 0, 2};
  a.step = {0, 1, 2, 0, 0, 0};
  a.tool = {0, 0, 0, 0, 0, 1};
  a.time_s.setConstant(6, std::numeric_limits<double>::quiet_NaN());
  a.time_s.head(3) << 0, 0.25, 0.5;
  write_samples(at("s.h5"), a, {});
  const Samples b = read_samples(at("s.h5"));
  EXPECT_EQ(b.tool, a.tool);
  EXPECT_EQ(b.kind, a.kind);
  EXPECT_EQ(b.time_s.head(3), a.time_s.head(3));
  EXPECT_TRUE(b.time_s.tail(3).array().isNaN().all());
  a.tool = {0, 0, 0, 0, 0, 2};
  EXPECT_THROW(write_samples(at("s.h5"), a, {}), Error);
  a.tool = {0, 0, 0, 0, 0, 1};
  a.time_s[2] = 0.2;
  EXPECT_THROW(write_samples(at("s.h5"), a, {}), Error);
}

TEST_F(RoundTrip, rows_of_other_probes_come_back_with_them) {
  Samples a = example_samples();
  a.experiment = {0, 0, 0, 1, 2, 2};
  a.point = {0, 0, 0, 2, 0, 0};
  a.step = {0, 1, 2, 0, 0, 1};
  a.kind = {ExperimentKind::press, ExperimentKind::press, ExperimentKind::press,
            ExperimentKind::press, ExperimentKind::other, ExperimentKind::other};
  a.probe_number = {0, 0, 0, 0, 2, 2};
  a.other_probes = {sphere_spec(0.004, 0.2), sphere_spec(0.012, 0.2)};
  a.other_probes[0].shape = "cone";
  a.other_probes[0].values = {{"half_angle", {1.0}}, {"tip_radius", {0.001}}};
  write_samples(at("s.h5"), a, {});
  const Samples b = read_samples(at("s.h5"));
  EXPECT_EQ(b.probe_number, a.probe_number);
  ASSERT_EQ(b.other_probes.size(), 2U);
  EXPECT_EQ(b.other_probes[0].shape, "cone");
  EXPECT_EQ(b.other_probes[0].values, a.other_probes[0].values);
  EXPECT_EQ(ball_radius_m(b.other_probes[1]), 0.012);
  for (const std::vector<std::int32_t>& wrong : {std::vector<std::int32_t>{0, 0, 0, 0, 3, 3},
                                                 {0, 0, 0, 0, 1, 2},
                                                 {0, 0, 0, 1, 2, 2},
                                                 {0, 0, 0, 0, 0, 0}}) {
    a.probe_number = wrong;
    EXPECT_THROW(write_samples(at("s.h5"), a, {}), Error);
  }
}

TEST_F(RoundTrip, samples_without_rows_or_gradient_come_back) {
  Samples a = example_samples();
  Samples empty;
  empty.point_position = a.point_position;
  empty.point_normal = a.point_normal;
  empty.point_name = a.point_name;
  write_samples(at("s.h5"), empty);
  const Samples b = read_samples(at("s.h5"));
  EXPECT_EQ(b.rows(), 0);
  EXPECT_EQ(b.points(), 3);
  EXPECT_EQ(b.point_normal_gradient.rows(), 0);
  write_samples(at("none.h5"), Samples{});
  const Samples none = read_samples(at("none.h5"));
  EXPECT_EQ(none.points(), 0);
  EXPECT_FALSE(none.probe) << "others may not know it";
  EXPECT_TRUE(std::isnan(none.poisson));
}

TEST_F(RoundTrip, body_comes_back_bit_for_bit) {
  const Body a = example_body();
  write_body(at("b.h5"), a, kAttributes);
  const Body b = read_body(at("b.h5"));
  EXPECT_TRUE(same_bits(a.surface.vertices, b.surface.vertices));
  EXPECT_TRUE(same_bits(a.surface.triangles, b.surface.triangles));
  EXPECT_EQ(a.in_region, b.in_region);
  EXPECT_EQ(a.is_reachable, b.is_reachable);
  EXPECT_TRUE(same_bits(a.test_points.position, b.test_points.position));
  EXPECT_TRUE(same_bits(a.test_points.normal, b.test_points.normal));
  EXPECT_EQ(a.test_points.name, b.test_points.name);
  EXPECT_TRUE(same_bits(a.test_points.triangles, b.test_points.triangles));
  EXPECT_TRUE(same_bits(a.volume.nodes, b.volume.nodes));
  EXPECT_TRUE(same_bits(a.volume.tets, b.volume.tets));
  EXPECT_TRUE(same_bits(a.volume.region, b.volume.region));
  EXPECT_EQ(a.is_held, b.is_held);
  EXPECT_EQ(a.mended, b.mended);
  expect_same(a.probe, b.probe);
  EXPECT_EQ(a.scene, b.scene);
  ASSERT_EQ(a.scene_meshes.size(), b.scene_meshes.size());
  for (std::size_t i = 0; i < a.scene_meshes.size(); ++i) {
    EXPECT_TRUE(same_bits(a.scene_meshes[i].vertices, b.scene_meshes[i].vertices));
    EXPECT_TRUE(same_bits(a.scene_meshes[i].triangles, b.scene_meshes[i].triangles));
    EXPECT_TRUE(same_bits(a.scene_meshes[i].tets, b.scene_meshes[i].tets));
    EXPECT_EQ(a.scene_meshes[i].is_painted, b.scene_meshes[i].is_painted);
  }
}

TEST_F(RoundTrip, body_without_volume_and_test_points_comes_back) {
  Body a;
  a.surface = example_body().surface;
  a.in_region.assign(5, 1);
  a.is_reachable.assign(5, 1);
  write_body(at("b.h5"), a);
  const Body b = read_body(at("b.h5"));
  EXPECT_EQ(b.volume.tets.rows(), 0);
  EXPECT_EQ(b.test_points.position.rows(), 0);
  EXPECT_TRUE(b.mended.empty());
  EXPECT_FALSE(b.probe);
  EXPECT_TRUE(b.scene.empty());
}

TEST_F(RoundTrip, every_family_comes_back_part_by_part) {
  for (const CurveFamilyName& row : kCurveFamilyNames) {
    FittedCurves a = example_curves();
    a.curves = example_of_family(a.curves, row.family);
    const auto parts = parts_of(row.family);
    a.deviation.resize(parts.size());
    for (std::size_t part = 0; part < parts.size(); ++part)
      if (has_deviation(parts[part]))
        a.deviation[part] = Controls::Constant(3, a.curves.control[part].cols(), 1e-3);
    write_curves(at("c.h5"), a);
    const FittedCurves b = read_curves(at("c.h5"));
    EXPECT_EQ(b.curves.family, row.family) << row.name;
    for (std::size_t part = 0; part < parts_of(row.family).size(); ++part) {
      EXPECT_EQ(a.curves.basis[part].knots_m, b.curves.basis[part].knots_m) << row.name << part;
      EXPECT_EQ(a.curves.control[part], b.curves.control[part]) << row.name << part;
      EXPECT_TRUE(same_bits(a.deviation[part], b.deviation[part])) << row.name << part;
    }
  }
}

TEST_F(RoundTrip, curves_come_back_bit_for_bit) {
  const FittedCurves a = example_curves();
  write_curves(at("c.h5"), a, kAttributes);
  const FittedCurves b = read_curves(at("c.h5"));
  EXPECT_TRUE(same_bits(a.position, b.position));
  EXPECT_TRUE(same_bits(a.normal, b.normal));
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.message, b.message);
  EXPECT_TRUE(same_bits(a.rms_residual_N, b.rms_residual_N));
  EXPECT_TRUE(same_bits(a.max_residual_N, b.max_residual_N));
  EXPECT_TRUE(same_bits(a.depth_range_m, b.depth_range_m));
  expect_same(a.curves, b.curves);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind)
    EXPECT_TRUE(same_bits(a.covariance[kind], b.covariance[kind]));
  EXPECT_EQ(a.recordings.experiment, b.recordings.experiment);
  EXPECT_EQ(a.recordings.point, b.recordings.point);
  EXPECT_TRUE(same_bits(a.recordings.contact_m, b.recordings.contact_m));
  EXPECT_TRUE(same_bits(a.recordings.drift_deviation_N, b.recordings.drift_deviation_N));
  expect_same(a.probe, b.probe);
}

TEST_F(RoundTrip, curves_without_errors_and_with_impossible_ones) {
  FittedCurves a = example_curves();
  a.recordings = {};
  for (auto& covariance : a.covariance) covariance.resize(0, 0);
  write_curves(at("old.h5"), a);
  const FittedCurves b = read_curves(at("old.h5"));
  EXPECT_EQ(b.covariance[0].size(), 0);
  EXPECT_TRUE(b.recordings.experiment.empty());
  a = example_curves();
  a.covariance[1](2, 0) = -1e-9;
  EXPECT_EQ(error_of([&] { write_curves(at("d.h5"), a); }),
            "d.h5:curves/lateral/covariance: row 2 has a negative variance");
  a = example_curves();
  a.recordings.point[1] = 3;
  EXPECT_NE(error_of([&] { write_curves(at("d.h5"), a); }).find("experiments/point"),
            std::string::npos);
}

TEST_F(RoundTrip, model_comes_back_bit_for_bit) {
  const Model a = example_model();
  write_model(at("m.h5"), a, kAttributes);
  const Model b = read_model(at("m.h5"));
  EXPECT_TRUE(same_bits(a.surface.vertices, b.surface.vertices));
  EXPECT_TRUE(same_bits(a.surface.triangles, b.surface.triangles));
  EXPECT_TRUE(same_bits(a.inward_normal, b.inward_normal));
  expect_same(a.curves, b.curves);
  EXPECT_EQ(a.is_covered, b.is_covered);
  EXPECT_TRUE(same_bits(a.blend_point, b.blend_point));
  EXPECT_TRUE(same_bits(a.blend_weight, b.blend_weight));
  expect_same(a.probe, b.probe);
}

TEST_F(RoundTrip, a_shape_response_comes_back_bit_for_bit_and_an_impossible_one_is_refused) {
  Model a = example_model();
  a.shape = example_shape();
  write_model(at("m.h5"), a);
  const ShapeResponse b = read_model(at("m.h5")).shape;
  EXPECT_EQ(a.shape.intervals, b.intervals);
  EXPECT_EQ(a.shape.modes, b.modes);
  EXPECT_EQ(a.shape.radius_power, b.radius_power);
  EXPECT_EQ(a.shape.depth_m, b.depth_m);
  EXPECT_EQ(a.shape.radius_m, b.radius_m);
  EXPECT_TRUE(same_bits(a.shape.point, b.point));
  EXPECT_TRUE(same_bits(a.shape.drag, b.drag));
  EXPECT_TRUE(same_bits(a.shape.mode, b.mode));
  const auto refusal = [&](auto change) {
    Model bad = a;
    change(bad.shape);
    return error_of([&] { write_model(at("bad.h5"), bad); });
  };
  using Shape = ShapeResponse;
  EXPECT_NE(refusal([](Shape& s) { s.point(1, 2) = 0.1; }).find("float32"), std::string::npos);
  EXPECT_NE(refusal([](Shape& s) { s.mode(1, 2) = 1e7; }).find("shape/mode"), std::string::npos);
  EXPECT_NE(refusal([](Shape& s) { s.drag[0] = std::nan(""); }).find("shape/drag"),
            std::string::npos);
  EXPECT_NE(refusal([](Shape& s) { s.modes = 2; }).find("other sizes"), std::string::npos);
  EXPECT_NE(refusal([](Shape& s) { s.intervals = 99; }).find("out of range"), std::string::npos);
  EXPECT_NE(refusal([](Shape& s) { s.depth_m = 0; }).find("not positive"), std::string::npos);
  EXPECT_NE(refusal([](Shape& s) {
              s.point.conservativeResize(2, Eigen::NoChange);
            }).find("fewer points"),
            std::string::npos);
}

TEST_F(RoundTrip, the_motion_of_a_surface_comes_back_with_the_samples_it_is_of) {
  Samples a = example_samples();
  a.surface.resize(a.rows(), 12);
  for (Eigen::Index i = 0; i < a.surface.size(); ++i)
    a.surface.data()[i] = static_cast<float>(i - 30) / (1 << 20);
  const std::filesystem::path path = surface_path(at("s.h5"));
  EXPECT_EQ(path.filename(), "s.surface.h5");
  write_surface_motion(path, a, kAttributes);
  Samples b = example_samples();
  read_surface_motion(path, b);
  EXPECT_TRUE(same_bits(a.surface, b.surface));
  EXPECT_EQ(read_attributes(path), kAttributes);
  b.step[1] = 9;  // other samples
  EXPECT_NE(error_of([&] { read_surface_motion(path, b); }).find("not those of the samples"),
            std::string::npos);
  a.surface(3, 4) = std::numeric_limits<float>::infinity();
  EXPECT_NE(error_of([&] { write_surface_motion(path, a); }).find("not finite"), std::string::npos);
  a.surface.resize(a.rows(), 11);
  EXPECT_NE(error_of([&] { write_surface_motion(path, a); }).find("three columns"),
            std::string::npos);
}

TEST_F(RoundTrip, columns_longer_than_a_chunk_come_back) {
  Samples s;
  const Eigen::Index rows = 50000;  // 1.2 MB a column: six chunks
  s.point_position = Points::Zero(1, 3);
  s.point_normal = unit_vectors(1, 1);
  s.point_name = {"p"};
  const auto n = static_cast<std::size_t>(rows);
  s.point.assign(n, 0);
  s.experiment.assign(n, 0);
  s.kind.assign(n, ExperimentKind::path);
  for (std::size_t i = 0; i < n; ++i) s.step.push_back(static_cast<std::int32_t>(i));
  s.deflection = awkward_points(rows, 20);
  s.force = s.torque = s.deflection;
  s.force_error = Eigen::VectorXd::Zero(rows);
  s.status.assign(n, RowStatus::good);
  write_samples(at("s.h5"), s);
  const Samples b = read_samples(at("s.h5"));
  EXPECT_TRUE(same_bits(s.force, b.force));
  EXPECT_EQ(s.step, b.step);
  write_samples(at("t.h5"), s);
  EXPECT_EQ(read_whole_file(at("s.h5")), read_whole_file(at("t.h5")));
}

TEST_F(RoundTrip, same_content_makes_the_same_bytes) {
  for (const char* name : {"1.h5", "2.h5"}) {
    write_samples(at(std::string("s") + name), example_samples(), kAttributes);
    write_body(at(std::string("b") + name), example_body(), kAttributes);
    write_curves(at(std::string("c") + name), example_curves(), kAttributes);
    write_model(at(std::string("m") + name), example_model(), kAttributes);
    if (name[0] == '1') ::usleep(1100000);  // a stored time of day would show
  }
  for (const char* kind : {"s", "b", "c", "m"})
    EXPECT_EQ(read_whole_file(at(std::string(kind) + "1.h5")),
              read_whole_file(at(std::string(kind) + "2.h5")))
        << kind;
}

TEST_F(RoundTrip, long_statements_fit_in_an_attribute) {
  const std::string statement(300000, 'x');  // HDF5's compact attributes end at 64 kB
  write_curves(at("c.h5"), example_curves(), {{"statement", statement}, {"empty", ""}});
  EXPECT_EQ(read_attributes(at("c.h5")), (Attributes{{"statement", statement}, {"empty", ""}}));
}

TEST_F(RoundTrip, own_attribute_names_cannot_be_taken) {
  EXPECT_EQ(error_of([&] {
              write_curves(at("c.h5"), example_curves(), {{"family", "x"}});
            }),
            "c.h5: attribute `family` is the file's own");
}

TEST_F(RoundTrip, describe_lists_schema_shapes_and_units) {
  write_samples(at("s.h5"), example_samples(), kAttributes);
  EXPECT_EQ(schema_of(at("s.h5")), "palpate-samples");
  const FileDescription d = describe(at("s.h5"));
  EXPECT_EQ(d.version, 1);
  EXPECT_EQ(d.attributes, kAttributes);
  ASSERT_EQ(d.data_sets.size(), 21u);
  EXPECT_EQ(d.data_sets[1].name, "points/name");
  EXPECT_EQ(d.data_sets[1].type, "text");
  const auto& force = d.data_sets[14];
  EXPECT_EQ(force.name, "rows/force");
  EXPECT_EQ(force.type, "float64");
  EXPECT_EQ(h5::to_string(force.shape), "6 x 3");
  EXPECT_EQ(force.unit, "N");
  write_model(at("m.h5"), example_model());
  EXPECT_EQ(schema_of(at("m.h5")), "palpate-model");
  EXPECT_EQ(describe(at("m.h5")).attributes.at("family"), "separable");
}

}  // namespace
}  // namespace palpate::testing_io
