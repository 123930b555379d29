#pragma once

#include <algorithm>
#include <limits>
#include <random>

#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/core/geometry.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/runtime/asset/shape.hpp"

// Small content of every file kind, with the awkward values that must survive: denormals, the
// largest double, a negative zero, names in UTF-8, empty names, NaN where it is allowed.
namespace palpate::testing_io {

inline Points awkward_points(Eigen::Index rows, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Points points(rows, 3);
  for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = normal(random) / 3;
  if (rows > 0) points.row(0) << 5e-324, -0.0, 1.0 / 3.0;
  if (rows > 1) points.row(1) << std::numeric_limits<double>::max(), 0.1, -1e-310;
  return points;
}

inline Points unit_vectors(Eigen::Index rows, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Points points(rows, 3);
  for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = normal(random);
  points.rowwise().normalize();
  return points;
}

/// A mesh with everything a probe may say; make_probe would refuse it, files must not.
inline ProbeSpec example_probe() {
  ProbeSpec probe;
  probe.shape = "m\u00e4sh";
  probe.values = {{"half_angle", {0.1}}, {"semi_axes", {1.0 / 3, 5e-324, 7}}};
  probe.mesh.vertices = awkward_points(4, 21);
  probe.mesh.triangles.resize(1, 3);
  probe.mesh.triangles << 3, 0, 2;
  probe.orientation = Vec3(-0.0, 1.0 / 3, 1e300);
  probe.friction = 0.8;
  return probe;
}

inline Samples example_samples() {
  Samples s;
  s.probe = example_probe();
  s.poisson = 0.45;
  s.point_position = awkward_points(3, 1);
  s.point_normal = unit_vectors(3, 2);
  s.point_name = {"p001", "", "Pr\u00fcfpunkt, \"3\""};
  s.point_normal_gradient = Eigen::Matrix<double, 3, 9>::Constant(-1.0 / 0.03);
  s.point = {0, 0, 0, 2, 2, 1};
  s.experiment = {0, 0, 0, 7, 7, 3};
  s.kind = {ExperimentKind::press, ExperimentKind::press, ExperimentKind::press,
            ExperimentKind::drag,  ExperimentKind::drag,  ExperimentKind::path};
  s.step = {0, 1, 2, 0, 1, 0};
  s.deflection = awkward_points(6, 3);
  s.force = awkward_points(6, 4);
  s.torque = awkward_points(6, 5);
  s.force_error = Eigen::VectorXd::LinSpaced(6, 0, 0.1);
  s.force_error[2] = std::numeric_limits<double>::quiet_NaN();
  s.status = {RowStatus::good,     RowStatus::wedged,     RowStatus::inverted,
              RowStatus::rejected, RowStatus::no_contact, RowStatus::not_reached};
  s.force.row(5).setConstant(std::numeric_limits<double>::quiet_NaN());
  s.torque.row(5).setConstant(std::numeric_limits<double>::quiet_NaN());
  return s;
}

inline Body example_body() {
  Body body;
  body.surface.vertices = awkward_points(5, 6);
  body.surface.triangles.resize(2, 3);
  body.surface.triangles << 0, 1, 2, 4, 3, 2;
  body.in_region = {1, 0, 1, 1, 1};
  body.is_reachable = {1, 0, 1, 1, 0};
  body.test_points.position = awkward_points(3, 7);
  body.test_points.normal = unit_vectors(3, 8);
  body.test_points.name = {"a", "b", "c"};
  body.test_points.triangles.resize(1, 3);
  body.test_points.triangles << 2, 0, 1;
  body.volume.nodes = awkward_points(4, 9);
  body.volume.tets.resize(1, 4);
  body.volume.tets << 0, 1, 2, 3;
  body.volume.region = Eigen::VectorXi::Constant(1, 2);
  body.is_held = {0, 0, 1, 1};
  body.mended = {"3 duplicate vertices were joined", ""};
  body.probe = example_probe();
  body.scene = "[material]\nlaw = 'lever \u03bc'\n";
  body.scene_meshes = {{body.surface.vertices, body.surface.triangles, {}, {}},
                       {body.volume.nodes, {}, body.volume.tets, {1}}};
  return body;
}

/// Monotone control values that float32 holds exactly, from a seed.
inline CurveSet example_curve_set(Eigen::Index points, unsigned seed) {
  CurveSet curves;
  curves.basis = {CurveBasis{3, {0, 0.001, 0.01 / 3, 0.01}}, CurveBasis{2, {0, 0.005}},
                  CurveBasis{1, {0, 0.004, 0.01}}};
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> increment(0, 1);
  for (std::size_t k = 0; k < 3; ++k) {
    Controls& control = curves.control[k];
    control = Controls::Zero(points, curves.basis[k].size());
    for (Eigen::Index i = 0; i < points; ++i)
      for (Eigen::Index j = 1; j < control.cols(); ++j)
        control(i, j) = static_cast<float>(control(i, j - 1)) + increment(random);
    control = control.cast<float>().cast<double>();
  }
  return curves;
}

/// The same three curves in a family, the numbers of its other parts admissible and unlike.
inline CurveSet example_of_family(const CurveSet& curves, CurveFamily family) {
  CurveSet out(family);
  const auto parts = parts_of(family);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i < curves_of(family)) {
      out.basis[i] = curves.basis[i], out.control[i] = curves.control[i];
      continue;
    }
    out.control[i] =
        Controls::Zero(curves.points(), parts[i].width * size_of(parts[i], out.basis[i]));
    const Eigen::Index first = parts[i].starts_at_zero ? parts[i].width : 0;
    for (Eigen::Index j = first; j < out.control[i].cols(); ++j)
      out.control[i].col(j).setConstant(
          rounded_to_float(std::clamp(1e-3 * double(j), parts[i].min, parts[i].max)));
    if (parts[i].known == runtime::Known::sway)  // nowhere negative
      out.control[i].rowwise() =
          rounded_to_float(Controls{{0.03, 0.02, 0.01, 0.001, 0.002, 0.003}}).row(0);
  }
  return out;
}

inline FittedCurves example_curves() {
  FittedCurves f;
  f.probe = example_probe();
  f.position = awkward_points(3, 10);
  f.normal = unit_vectors(3, 11);
  f.name = {"p1", "p2", "p3"};
  f.curves = example_curve_set(3, 12);
  f.status = {FitStatus::good, FitStatus::failed, FitStatus::poor};
  f.message = {"", "no usable row", "residual 12 %"};
  f.rms_residual_N = Eigen::Vector3d(0.001, std::numeric_limits<double>::quiet_NaN(), 0.3);
  f.max_residual_N = Eigen::Vector3d(0.002, std::numeric_limits<double>::quiet_NaN(), 0.9);
  f.depth_range_m = Eigen::Vector3d(0.01, 0, 0.02);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    const Eigen::Index n = f.curves.basis[kind].size() - 1;
    f.covariance[kind] = Controls::Constant(3, n * (n + 1) / 2, 1e-4);
    f.covariance[kind].row(1).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  f.recordings.experiment = {4, 7}, f.recordings.point = {0, 2};
  f.recordings.contact_m = Eigen::Vector2d(1e-4, -3e-5);
  f.recordings.contact_deviation_m = Eigen::Vector2d(1e-5, 2e-5);
  for (auto* column : {&f.recordings.bias_N, &f.recordings.bias_deviation_N, &f.recordings.drift_N,
                       &f.recordings.drift_deviation_N})
    *column = Eigen::Vector2d(0.01, 0);
  return f;
}

inline Model example_model() {
  Model model;
  model.surface = example_body().surface;
  model.inward_normal = unit_vectors(5, 13);
  model.inward_normal.row(4).setZero();
  model.curves = example_curve_set(5, 14);
  model.is_covered = {1, 1, 1, 1, 0};
  model.blend_point.resize(5, 3);
  model.blend_point << 0, 1, 2, 0, 1, 2, 0, 1, 2, 2, 2, 2, 0, 0, 0;
  model.blend_weight.resize(5, 3);
  model.blend_weight << 1, 0, 0, 0.5, 0.25, 0.25, 0.3, 0.3, 0.4, 0, 1, 0, 0, 0, 0;
  for (auto& control : model.curves.control) control.row(4).setZero();
  model.probe = example_probe();
  return model;
}

/// A shape response of example_model's five vertices.
inline ShapeResponse example_shape() {
  ShapeResponse shape;
  shape.intervals = 4;
  shape.modes = 3;
  shape.radius_power = 2;
  shape.depth_m = 1.0 / 3;
  shape.radius_m = 5e-324;
  std::mt19937 random(31);
  std::uniform_real_distribution<float> draw(-2, 2);
  const auto fill = [&](auto& values) {
    for (Eigen::Index i = 0; i < values.size(); ++i)
      values.data()[i] = static_cast<double>(draw(random));
  };
  shape.point.resize(5, runtime::shape_numbers(4, 3));
  shape.drag.resize(runtime::shape_drag_numbers(4));
  shape.mode.resize(5, 9);
  fill(shape.point);
  fill(shape.drag);
  fill(shape.mode);
  return shape;
}

}  // namespace palpate::testing_io
