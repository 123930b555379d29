#include "libfit/scan/walk.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "libfit/core/error.hpp"
#include "libfit/experiments/follow.hpp"

namespace palpate::scan {
double Recording::lambda() const { return std::exp(std::clamp(number[kLambda], -3.0, 3.0)) / 1.5; }

Relaxation Recording::relaxation() const {
  Relaxation out;
  if (!(number[kShare] > 0)) return out;
  // The time is within 5 ms and 2 s, which readings and presses can show.
  out.share = Eigen::VectorXd::Constant(1, std::min(number[kShare], 10.0));
  out.time_s = Eigen::VectorXd::Constant(1, 0.1 * std::exp(std::clamp(number[kTime], -3.0, 3.0)));
  return out;
}

Mat3 Recording::turn() const {
  const Vec3 by = number.segment<3>(kTurn);
  const double angle = by.norm();
  return angle > 0 ? Eigen::AngleAxisd(angle, by / angle).toRotationMatrix() : Mat3::Identity();
}

Vec3 Recording::offset_N(double time_s) const {
  return number.segment<3>(kBias) + time_s / 60 * number.segment<3>(kDrift);
}

Controls vertex_curvature(const Surface& surface, const Points& inward_normal, double depth_m) {
  const Eigen::Index vertices = surface.vertices.rows();
  // Sums of du dcᵀ and of dc dcᵀ over the edges at a vertex, both tangential.
  std::vector<Mat3> slope(vertices, Mat3::Zero()), square(vertices, Mat3::Zero());
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < 3; ++l) {
        const int v = surface.triangles(t, k), w = surface.triangles(t, l);
        const Vec3 u = inward_normal.row(v);
        const Mat3 tangential = Mat3::Identity() - u * u.transpose();
        const Vec3 dc =
                       tangential * (surface.vertices.row(w) - surface.vertices.row(v)).transpose(),
                   du = tangential * (inward_normal.row(w) - inward_normal.row(v)).transpose();
        slope[v] += du * dc.transpose();
        square[v] += dc * dc.transpose();
      }
  Controls out(vertices, 6);
  for (Eigen::Index v = 0; v < vertices; ++v) {
    const Vec3 u = inward_normal.row(v);
    const Mat3 gradient = slope[v] * (square[v] + square[v].trace() * u * u.transpose()).inverse();
    out.row(v) = numbers_of(-0.5 * (gradient + gradient.transpose()));
    runtime::offset_curvature(out.row(v).data(), -runtime::kCurvatureDepth * depth_m);
  }
  return out;
}

CurveSet curves_of(const Nodes& nodes, const ScanParameters& p, const CurveBasis& basis,
                   const Nodes::NodeMesh& mesh, const Points& inward_normal) {
  CurveSet curves(CurveFamily::rings);
  curves.basis[0] = basis;
  curves.relaxation = p.recording.relaxation();
  const Eigen::Index vertices = mesh.surface.vertices.rows();
  for (std::size_t part = 0; part < curves.control.size(); ++part) {
    const runtime::Part& of = parts_of(curves.family)[part];
    curves.control[part] =
        Controls::Zero(vertices, Eigen::Index{of.width} * size_of(of, curves.basis[part]));
  }
  for (Eigen::Index v = 0; v < vertices; ++v) {
    const Nodes::CellPlace& at = mesh.vertex[v];
    for (int k = 0; k < 4 && at.cell >= 0; ++k) {
      const int node = nodes.cell(at.cell).corner[k];
      double sum = 0;
      for (Eigen::Index j = 0; j < p.increment_N.cols(); ++j)
        curves.control[0](v, j + 1) += at.corner[k] * (sum += p.increment_N(node, j));
      curves.control[runtime::kFriction](v, 0) += at.corner[k] * p.friction[node];
      curves.control[runtime::kFrictionSlope](v, 0) += at.corner[k] * p.friction_slope_1_m[node];
    }
  }
  curves.control[runtime::kLambda].setConstant(p.recording.lambda());
  curves.control[runtime::kCurvature] =
      vertex_curvature(mesh.surface, inward_normal, basis.knots_m.back());
  for (Controls& control : curves.control) control = rounded_to_float(control);
  return curves;
}

Passes::Passes(const Samples& s) : position_m(s.rows(), 3), force_N(s.force), time_s(s.time_s) {
  for (Eigen::Index row = 0; row < s.rows(); ++row) {
    if (row == 0 || s.experiment[row] != s.experiment[row - 1]) first.push_back(row);
    position_m.row(row) = s.point_position.row(s.point[row]) + s.deflection.row(row);
    is_scan.push_back(s.kind[row] == ExperimentKind::scan);
  }
  first.push_back(s.rows());
}

Vec3 Passes::offset_N(Eigen::Index row, const Recording& recording) const {
  return is_scan[row] ? recording.offset_N(time_s[row]) : Vec3::Zero();
}

Vec3 Passes::force_on_body(Eigen::Index row, const Recording& recording) const {
  return recording.turn().transpose() * (force_N.row(row).transpose() - offset_N(row, recording));
}

Vec3 Passes::tip(std::size_t pass, Eigen::Index row, const Recording& recording) const {
  Vec3 position = position_m.row(row);
  if (const double t = time_s[row] - recording.delay_s(); std::isfinite(t)) {
    Eigen::Index i = std::clamp(row, first[pass], first[pass + 1] - 2);
    while (i > first[pass] && time_s[i] > t) --i;
    while (i + 2 < first[pass + 1] && time_s[i + 1] < t) ++i;
    const double share = (t - time_s[i]) / (time_s[i + 1] - time_s[i]);
    position = position_m.row(i) + share * (position_m.row(i + 1) - position_m.row(i));
  }
  const double compliance_m_N = recording.compliance_m_N();
  return compliance_m_N > 0 ? Vec3(position - compliance_m_N * force_on_body(row, recording))
                            : position;
}

Points readings(const Points& force_N, const Passes& passes, const Recording& recording) {
  Points out = force_N * recording.turn().transpose();
  for (Eigen::Index row = 0; row < out.rows(); ++row)
    out.row(row) += passes.offset_N(row, recording).transpose();
  return out;
}

PlayedBody::PlayedBody(const Nodes& nodes, const ScanParameters& parameters,
                       const CurveBasis& basis, int parts)
    : nodes_(nodes),
      height_m_(parameters.height_m),
      recording_(parameters.recording),
      mesh_(nodes.mesh(parameters.height_m, parts)) {
  model_.surface = mesh_.surface;
  model_.inward_normal = -vertex_normals(mesh_.surface);
  model_.curves = curves_of(nodes, parameters, basis, mesh_, model_.inward_normal);
  model_.is_covered.assign(mesh_.vertex.size(), 1);
  bytes_.emplace(make_asset_bytes(model_, {}));
  runtime::Status status;
  asset_ = runtime::Asset::open_without_replay(bytes_->data(), bytes_->size(), &status);
  if (!asset_.is_open())
    throw Error("scan", runtime::sentence(status), "Please report this with the recording.");
}

Walked PlayedBody::walk(const Passes& passes, const std::vector<char>& is_wanted, bool wants_states,
                        int jobs) const {
  Walked out{Points::Zero(passes.rows(), 3),
             {},
             std::vector<char>(passes.rows(), 0),
             std::vector<RowState>(wants_states ? passes.rows() : 0)};
  const double depth_m = model_.curves.basis[0].knots_m.back();
  const auto walk_one = [&](std::size_t pass) {
    const Eigen::Index first = passes.first[pass], rows = passes.first[pass + 1] - first;
    if (!is_wanted[first]) return;
    Samples one;
    const Nodes::Foot foot = nodes_.foot(passes.tip(pass, first, recording_), height_m_);
    one.point_position = foot.position.transpose();
    one.point_normal = foot.normal.transpose();
    one.point.assign(rows, 0), one.experiment.assign(rows, 0);
    one.kind.assign(rows, ExperimentKind::scan);
    one.deflection.resize(rows, 3), one.force = Points::Zero(rows, 3);
    one.time_s.resize(rows);
    for (Eigen::Index i = 0; i < rows; ++i) {
      one.step.push_back(static_cast<std::int32_t>(i));
      one.deflection.row(i) = (passes.tip(pass, first + i, recording_) - foot.position).transpose();
      one.time_s[i] = passes.time_s[first + i];
    }
    const Replayed answer =
        follow(asset_, one, depth_m, {}, [&](Eigen::Index row, const auto& tool) {
          if (!wants_states) return;
          RowState& state = out.state[first + row];
          state.place = tool.contact[0];
          state.memory =
              runtime::Rings::load<double>(tool.contact[0].memory, asset_.curves.relaxation);
        });
    out.force_N.middleRows(first, rows) = answer.force_N;
    std::copy(answer.is_sliding.begin(), answer.is_sliding.end(), out.is_sliding.begin() + first);
  };
  tbb::task_arena arena(jobs > 0 ? jobs : tbb::this_task_arena::max_concurrency());
  arena.execute([&] { tbb::parallel_for(std::size_t{0}, passes.count(), walk_one); });
  out.reading_N = readings(out.force_N, passes, recording_);
  return out;
}

}  // namespace palpate::scan
