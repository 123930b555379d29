// Shape responses found in rows that a known one made.

#include "libfit/shape/shape.hpp"

#include <gtest/gtest.h>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

constexpr int kPoints = 9;
constexpr double kDepth_m = 0.005;

/// Test points: three by three, well inside the plate.
Eigen::Index vertex_of(int point) { return (4 + point / 3 * 4) * 17 + 4 + point % 3 * 4; }

Model shaped_plate(int modes, unsigned seed) {
  Model model = plate_model(0.08, 16, uniform(400, 300, 0.3));
  std::vector<Eigen::Index> at;
  for (int p = 0; p < kPoints; ++p) at.push_back(vertex_of(p));
  make_shaped(model, at, modes, seed);
  return model;
}

/// Presses of eight rows at every point, a drag of four at every other one.
Samples experiments(const Model& model) {
  Samples samples;
  samples.point_position.resize(kPoints, 3);
  samples.point_normal.resize(kPoints, 3);
  std::vector<Vec3> deflection;
  const auto add = [&](int point, int experiment, ExperimentKind kind, int step, const Vec3& d) {
    samples.point.push_back(point);
    samples.experiment.push_back(experiment);
    samples.kind.push_back(kind);
    samples.step.push_back(step);
    samples.status.push_back(RowStatus::good);
    deflection.push_back(d);
  };
  for (int p = 0; p < kPoints; ++p) {
    samples.point_position.row(p) = model.surface.vertices.row(vertex_of(p));
    samples.point_normal.row(p) << 0, 0, -1;
    samples.point_name.push_back("p" + std::to_string(p));
    for (int k = 1; k <= 8; ++k)
      add(p, 2 * p, ExperimentKind::press, k - 1, {0, 0, -kDepth_m * k / 8});
    for (int k = 1; k <= 4 && p % 2 == 0; ++k)
      add(p, 2 * p + 1, ExperimentKind::drag, k - 1,
          {0.0004 * k * (p % 4 ? 1 : -1), 0.0002 * k, -0.004});
  }
  samples.deflection.resize(static_cast<Eigen::Index>(deflection.size()), 3);
  for (std::size_t i = 0; i < deflection.size(); ++i)
    samples.deflection.row(static_cast<Eigen::Index>(i)) = deflection[i].transpose();
  return samples;
}

/// Fills in what the asset shows, the ball left out.
void show(const Asset& asset, Samples& samples) {
  const auto contacts = contact_states(asset, samples, kDepth_m);
  samples.surface.setZero(samples.rows(), 3 * asset.vertices);
  for (std::size_t row = 0; row < contacts.size(); ++row) {
    runtime::DentState state;
    ASSERT_TRUE(contacts[row] && runtime::shape_state(asset, *contacts[row], 0, state)) << row;
    const runtime::Deformation deformation(asset, *contacts[row], state);
    for (int v = 0; v < asset.vertices; ++v) {
      const runtime::Vec3d u = deformation.at(v);
      samples.surface.row(static_cast<Eigen::Index>(row)).segment(3 * v, 3) << float(u.x),
          float(u.y), float(u.z);
    }
  }
}

ShapeOptions options_of(const ShapeResponse& shape) {
  return {shape.depth_m, shape.radius_m, shape.radius_power, 16};
}

/// What comes back of the model's own shape, from rows that the engine showed with it.
struct FoundAgain {
  ShapeResponse shape;
  ShapeError error;
  std::size_t rows;
};
FoundAgain find_again(Model model, int modes) {
  const Loaded truth = load(model);
  Samples samples = experiments(model);
  show(truth.asset, samples);
  ShapeOptions options = options_of(model.shape);
  options.modes = modes;
  model.shape = {};
  const Loaded plain = load(model);
  FoundAgain out;
  out.rows = samples.point.size();
  out.shape = identify_shape(plain.asset, samples, model.blend_point, model.blend_weight, options);
  const ShapedAsset shaped(plain.asset, out.shape, model.blend_point, model.blend_weight);
  out.error =
      shape_error(shaped.view(), samples, contact_states(plain.asset, samples, kDepth_m), false);
  return out;
}

TEST(identify_shape, finds_the_response_that_made_the_rows) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const FoundAgain found = find_again(shaped_plate(3, seed), 3);
    ASSERT_EQ(found.shape.modes, 3);
    EXPECT_EQ(found.error.rows, found.rows);
    EXPECT_LT(found.error.near.p95_rel, 0.03) << "seed " << seed;
    EXPECT_LT(found.error.all.p95_rel, 0.03) << "seed " << seed;
  }
}

TEST(identify_shape, a_body_that_only_dents_needs_no_modes_of_the_whole_body) {
  EXPECT_LT(find_again(shaped_plate(0, 4), 0).error.near.p95_rel, 0.02);
}

// Where the reference is what deform() shows, nothing is left, and what the ball pushes out counts.
TEST(shape_error, is_of_the_surface_that_a_scene_sees) {
  double unpushed_m = 0;
  for (const unsigned seed : {6U, 7U, 8U}) {
    Model model = shaped_plate(2, seed);
    model.probe = sphere_spec(0.012, 0.3);  // over several vertices
    const Loaded body = load(model);
    Samples samples = experiments(model);
    samples.surface.setZero(samples.rows(), 3 * body.asset.vertices);
    const auto contacts = contact_states(body.asset, samples, kDepth_m);
    for (std::size_t row = 0; row < contacts.size(); ++row)
      ASSERT_EQ(runtime::deform(body.asset, *contacts.at(row), 0, 0, body.asset.vertices,
                                samples.surface.row(static_cast<Eigen::Index>(row)).data()),
                runtime::Status::ok);
    EXPECT_LT(shape_error(body.asset, samples, contacts).all.max_m, 1e-9) << "seed " << seed;
    unpushed_m = std::max(unpushed_m, shape_error(body.asset, samples, contacts, false).all.max_m);
  }
  EXPECT_GT(unpushed_m, 1e-5) << "the ball pushes nothing out";
}

TEST(identify_shape, rows_that_are_not_good_tell_nothing) {
  Model model = shaped_plate(1, 5);
  const Loaded truth = load(model);
  Samples samples = experiments(model);
  show(truth.asset, samples);
  ShapeOptions options = options_of(model.shape);
  model.shape = {};
  const Loaded plain = load(model);
  const auto found = [&] {
    return identify_shape(plain.asset, samples, model.blend_point, model.blend_weight, options);
  };
  for (std::size_t row = 0; row < samples.point.size(); ++row)
    if (samples.point[row] == 3) samples.status[row] = RowStatus::not_converged;
  const ShapeResponse before = found();
  for (std::size_t row = 0; row < samples.point.size(); ++row)
    if (samples.point[row] == 3) samples.surface.row(static_cast<Eigen::Index>(row)).setConstant(1);
  const ShapeResponse after = found();
  EXPECT_EQ(before.point, after.point);
  EXPECT_EQ(before.mode, after.mode);
  for (RowStatus& status : samples.status) status = RowStatus::rejected;
  EXPECT_EQ(found().point.rows(), 0);
}

}  // namespace
}  // namespace palpate::test
