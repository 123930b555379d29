#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/scan/gauss_newton.hpp"
#include "libfit/scan/scan.hpp"

namespace palpate::scan {
namespace {

// Passes left out decide whether a candidate is free, and how smooth neighbours are.
class UnknownsChoice {
 public:
  UnknownsChoice(ScanIdentification& fit, const Progress& progress)
      : fit_(fit), progress_(progress), half_(fit.passes.rows(), 0), other_(half_) {
    for (std::size_t pass = 0; pass < fit.passes.count(); ++pass)
      for (Eigen::Index row = fit.passes.first[pass]; row < fit.passes.first[pass + 1]; ++row)
        (pass / 2 % 2 == 0 ? half_ : other_)[row] = 1;  // to and fro in each
  }

  // Numbers of the sensor are free from the start: heights found without its bias stay 3.5 mm
  // off, and no delay is found then (a phantom's raster, docs/measured-data.md).
  void start(const Mask& mask) {
    for (const SharedUnknown& of : kSharedUnknowns)
      if (!of.needs_replay) set_free(of, 1);
    fit_.fit(mask, 12);
  }

  void run(ScanFit& out) {
    const std::size_t parts = std::size(kSharedUnknowns) + 4;
    progress_.report(0, parts, "surface and curves");
    start(half_);
    best_ = fit_.loss_of(other_);
    std::size_t done = 0;
    for (const SharedUnknown& candidate : kSharedUnknowns) {
      progress_.report(++done, parts, candidate.name);
      const bool is_tried = candidate.needs_replay;
      const double gain =
          keep_if_better(5, is_tried ? 0.01 : -0.01, [&] { set_free(candidate, is_tried); });
      gains.push_back(is_tried ? gain : gain / (gain - 1));
    }
    for (const double factor : {0.2, 5.0}) {
      progress_.report(++done, parts, "smoothness");
      keep_if_better(4, 0.01, [&] { fit_.smoothness *= factor; });
    }
    out.fitted = fit_.errors(half_), out.left_out = fit_.errors(other_);
    progress_.report(++done, parts, "all passes");
    find_all(out);
    progress_.report(parts, parts);
  }

  std::vector<double> gains;  ///< of the loss of passes left out, by each candidate

 private:
  // Numbers below their standard errors are left out, and the others found again.
  void find_all(ScanFit& out) {
    const Mask all(half_.size(), 1);
    fit_.fit(all, 8);
    const Eigen::VectorXd deviation = fit_.deviations(fit_.walk(all));
    for (const SharedUnknown& of : kSharedUnknowns) {
      const auto size = [&](const Eigen::VectorXd& of_all) {
        return of_all.segment(of.first, of.count == 3 ? 3 : 1).norm();
      };
      if (size(fit_.parameters.recording.number) >= size(deviation)) continue;
      set_free(of, 0);
      out.notes.push_back(fmt::format("{} is below its standard error: left out", of.name));
    }
    if (!out.notes.empty()) fit_.fit(all, 8);
  }

  void set_free(const SharedUnknown& candidate, char is_free) {
    for (int k = 0; k < candidate.count; ++k) {
      fit_.is_free[fit_.unknowns.shared(candidate.first + k)] = is_free;
      fit_.parameters.recording.number[candidate.first + k] = 0;
    }
    if (is_free) fit_.parameters.recording.number[candidate.first] = candidate.start;
  }

  template <class Change>
  double keep_if_better(int most_steps, double least_gain, const Change& change) {
    const ScanParameters parameters = fit_.parameters;
    const Mask is_free = fit_.is_free;
    const double smoothness = fit_.smoothness;
    change();
    fit_.fit(half_, most_steps);
    const double now = fit_.loss_of(other_), gain = 1 - now / best_;
    if (gain > least_gain)  // 1 % of the loss, so that no chance of a pass decides
      best_ = now;
    else
      fit_.parameters = parameters, fit_.is_free = is_free, fit_.smoothness = smoothness;
    return gain;
  }

  ScanIdentification& fit_;
  const Progress& progress_;
  Mask half_, other_;
  double best_ = 0;
};

void say_numbers(const ScanIdentification& fit, const std::vector<double>& gains, ScanFit& out) {
  const auto& number = out.recording.number;
  for (std::size_t i = 0; i < std::size(kSharedUnknowns); ++i) {
    const SharedUnknown& of = kSharedUnknowns[i];
    const int k = of.first;
    std::string value = fmt::format("no {}", of.name);
    if (fit.is_free[fit.unknowns.shared(k)]) {
      const double unit = of.is_logarithm ? of.unit * std::exp(number[k]) : of.unit;
      value = fmt::format("{} {:.3g}", of.name, of.is_logarithm ? unit : unit * number[k]);
      for (int j = 1; of.count == 3 && j < 3; ++j)
        value += fmt::format(", {:.3g}", unit * number[k + j]);
      value +=
          fmt::format(" +- {:.2g} {}",
                      unit * out.deviation.segment(k, of.count == 3 ? 3 : 1).maxCoeff(), of.symbol);
    }
    out.notes.push_back(fmt::format("{}: the loss of passes left out {} by {:.1f} % with it", value,
                                    gains[i] > 0 ? "falls" : "rises", 100 * std::abs(gains[i])));
  }
}

void say_coverage(const ScanIdentification& fit, const Walked& walked, const Mask& has_rows,
                  ScanFit& out) {
  const Passes& passes = fit.passes;
  std::vector<double> depth_m, speed_m_s, force_N, correction_N;
  double sliding = 0, gap_s = 0;
  for (std::size_t pass = 0; pass < passes.count(); ++pass)
    for (Eigen::Index row = passes.first[pass]; row < passes.first[pass + 1]; ++row) {
      const Vec3 recorded_N = passes.force_N.row(row), tip = passes.position_m.row(row);
      depth_m.push_back(fit.nodes.foot(tip, fit.parameters.height_m).depth_m);
      sliding += walked.is_sliding[row];
      force_N.push_back(recorded_N.norm());
      correction_N.push_back((passes.force_on_body(row, out.recording) - recorded_N).norm());
      if (row == passes.first[pass]) continue;
      const double step_s = passes.time_s[row] - passes.time_s[row - 1];
      if (!(step_s > 0)) continue;
      speed_m_s.push_back((passes.position_m.row(row) - passes.position_m.row(row - 1)).norm() /
                          step_s);
      gap_s = std::max(gap_s, step_s);
    }
  if (stated_quantile(depth_m, 0.02) > 0)
    out.notes.emplace_back(
        "the tool hardly lifts off, and a turned frame and a tilted surface answer alike: the turn "
        "may be off by 5 degrees, more than its error says");
  out.notes.push_back(fmt::format(
      "bias, turn and drift move the forces by {} (median)",
      stated_percent(stated_quantile(correction_N, 0.5) / stated_quantile(force_N, 0.5))));
  const auto squares = std::ranges::count(has_rows, 1);
  out.notes.push_back(fmt::format(
      "{} passes, {} rows over {:.3g} cm2; {:.2g} to {:.2g} mm deep, {:.2g} to {:.2g} mm/s (p5, "
      "p95); {:.0f} % of the rows slide; the longest gap is {:.2g} s",
      passes.count(), passes.rows(), 1e4 * double(squares) * std::pow(fit.nodes.spacing_m(), 2),
      1e3 * stated_quantile(depth_m, 0.05), 1e3 * stated_quantile(depth_m, 0.95),
      1e3 * stated_quantile(speed_m_s, 0.05), 1e3 * stated_quantile(speed_m_s, 0.95),
      100 * sliding / double(passes.rows()), gap_s));
}

// Cells in which a tip was: the margin's numbers are a guess of the prior.
Mask cells_with_rows(const ScanIdentification& fit) {
  Mask has_rows(fit.nodes.cells(), 0);
  for (std::size_t pass = 0; pass < fit.passes.count(); ++pass)
    for (Eigen::Index row = fit.passes.first[pass]; row < fit.passes.first[pass + 1]; ++row) {
      const Vec3 tip = fit.passes.tip(pass, row, fit.parameters.recording);
      const int cell = fit.nodes.foot(tip, fit.parameters.height_m).place.cell;
      if (cell >= 0) has_rows[cell] = 1;
    }
  return has_rows;
}

Mask vertices_of(const Mask& has_rows, const Nodes::NodeMesh& mesh) {
  Mask out(mesh.vertex.size(), 0);
  for (Eigen::Index t = 0; t < mesh.surface.triangles.rows(); ++t)
    for (int k = 0; k < 3 && has_rows[mesh.triangle_cell[t]]; ++k)
      out[mesh.surface.triangles(t, k)] = 1;
  return out;
}

// Vertices of the body's mesh in cells with rows, near the heights and facing as they do.
Nodes::NodeMesh places_on(const ScanIdentification& fit, const Surface& surface,
                          const Mask& has_rows, Mask& is_covered) {
  Nodes::NodeMesh out{surface, std::vector<Nodes::CellPlace>(surface.vertices.rows()), {}};
  const Points inward = -vertex_normals(surface);
  is_covered.assign(out.vertex.size(), 0);
  for (std::size_t v = 0; v < out.vertex.size(); ++v) {
    const Nodes::Foot foot = fit.nodes.foot(surface.vertices.row(v), fit.parameters.height_m);
    if (foot.place.cell < 0 || !has_rows[foot.place.cell] || !(inward.row(v) * foot.normal > 0.5) ||
        std::abs(foot.depth_m) > fit.nodes.spacing_m())
      continue;
    out.vertex[v] = foot.place, is_covered[v] = 1;
  }
  if (std::ranges::count(is_covered, 1) == 0)
    throw Error("scan", "no vertex of the surface lies under its rows",
                "Say where the scan was ([registration]), or give a finer mesh.");
  return out;
}

Vec3 normal_at(const Surface& surface, const Points& inward_normal, const SurfacePoint& at) {
  Vec3 inward = Vec3::Zero();
  for (int k = 0; k < 3; ++k)
    inward += at.weight[k] * inward_normal.row(surface.triangles(at.triangle, k)).transpose();
  return inward.normalized();
}

}  // namespace

Points points_on_surface(const Samples& scans, int jobs, const Progress& progress) {
  ScanIdentification fit(scans, jobs, progress, nullptr);
  UnknownsChoice(fit, progress).start(Mask(fit.passes.rows(), 1));
  const Nodes::NodeMesh mesh = fit.nodes.mesh(fit.parameters.height_m, 1);
  const Mask is_covered = vertices_of(cells_with_rows(fit), mesh);
  std::vector<Eigen::Index> covered;
  for (std::size_t v = 0; v < is_covered.size(); ++v)
    if (is_covered[v]) covered.push_back(static_cast<Eigen::Index>(v));
  return mesh.surface.vertices(covered, Eigen::all);
}

ScanFit identify(const Samples& scans, int jobs, const Progress& progress, const Surface* known) {
  ScanFit out;
  ScanIdentification fit(scans, jobs, progress, known);
  UnknownsChoice choice(fit, progress);
  choice.run(out);
  if (progress.stopped()) return {};
  // Six scans of a robot have turns of 0.03 to 0.16 rad, which half the bound would let pass, too;
  // one with forces from joint torques has 0.70, which twice would.
  const double turn_rad = Eigen::AngleAxisd(fit.parameters.recording.turn()).angle();
  if (turn_rad > 0.5)
    throw Error("scan",
                fmt::format("the forces fit the motion only in a frame turned by {:.0f} degrees",
                            turn_rad * 180 / std::numbers::pi),
                "Give them along the axes of the positions, and check whose they are (force_on).");
  const PlayedBody body = fit.body();
  const Walked walked = fit.walk(Mask(fit.passes.rows(), 1));
  out.notes.push_back(fmt::format(
      "nodes {:.2g} mm apart, curves to {:.3g} mm, smoothness {:g}; passes left out of half of it "
      "are off by {} (median), {} (p95), that half by {}, {}",
      1e3 * fit.nodes.spacing_m(), 1e3 * fit.unknowns.depth_m, fit.smoothness,
      stated_percent(out.left_out.median), stated_percent(out.left_out.p95),
      stated_percent(out.fitted.median), stated_percent(out.fitted.p95)));
  out.recording = fit.parameters.recording, out.deviation = fit.deviations(walked);
  say_numbers(fit, choice.gains, out);
  const Mask has_rows = cells_with_rows(fit);
  say_coverage(fit, walked, has_rows, out);
  FittedCurves& curves = out.curves;
  if (known != nullptr) {
    const auto mesh = places_on(fit, *known, has_rows, out.is_covered);
    out.surface = *known, curves.normal = -vertex_normals(*known);
    curves.curves = curves_of(fit.nodes, fit.parameters, fit.basis, mesh, curves.normal);
  } else {
    out.surface = body.mesh().surface;
    curves.normal = body.model().inward_normal, curves.curves = body.model().curves;
    out.is_covered = vertices_of(has_rows, body.mesh());
  }
  const Eigen::Index vertices = out.surface.vertices.rows();
  curves.position = out.surface.vertices;
  curves.status.assign(vertices, FitStatus::good), curves.message.assign(vertices, "");
  for (Eigen::Index v = 0; v < vertices; ++v) curves.name.push_back(fmt::format("v{}", v + 1));
  curves.rms_residual_N = curves.max_residual_N = Eigen::VectorXd::Constant(vertices, kNan);
  curves.depth_range_m = Eigen::VectorXd::Constant(vertices, fit.unknowns.depth_m);
  return out;
}

Samples corrected(const Samples& scans, const Surface& surface, const Recording& recording) {
  Samples out = scans;
  const Passes passes(scans);
  const BoxTree boxes = triangle_boxes(surface);
  const Points inward = -vertex_normals(surface);
  for (std::size_t pass = 0; pass < passes.count(); ++pass) {
    const Eigen::Index first = passes.first[pass];
    const auto foot = closest_point(surface, boxes, passes.tip(pass, first, recording));
    out.point_position.row(scans.point[first]) = foot->position.transpose();
    out.point_normal.row(scans.point[first]) = normal_at(surface, inward, *foot).transpose();
    for (Eigen::Index row = first; row < passes.first[pass + 1]; ++row) {
      out.deflection.row(row) = (passes.tip(pass, row, recording) - foot->position).transpose();
      out.force.row(row) = passes.force_on_body(row, recording).transpose();
    }
  }
  out.relaxation = recording.relaxation();
  return out;
}

Recording later_recording(const Samples& scans, const Surface& surface, const Recording& earlier,
                          double clearance_m, Eigen::Index* rows_in_air) {
  Recording out = earlier;
  out.number.segment<3>(kDrift).setZero();
  const Passes passes(scans);
  const BoxTree boxes = triangle_boxes(surface);
  const Points inward = -vertex_normals(surface);
  Vec3 sum = Vec3::Zero();
  *rows_in_air = 0;
  for (Eigen::Index row = 0; row < passes.rows(); ++row) {
    const Vec3 tip = passes.position_m.row(row);
    const auto foot = closest_point(surface, boxes, tip);
    if ((foot->position - tip).dot(normal_at(surface, inward, *foot)) < clearance_m) continue;
    sum += passes.force_N.row(row).transpose(), ++*rows_in_air;
  }
  if (*rows_in_air >= 10) out.number.segment<3>(kBias) = sum / double(*rows_in_air);
  return out;
}

}  // namespace palpate::scan
