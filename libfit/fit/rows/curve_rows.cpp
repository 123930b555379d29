#include "libfit/fit/rows/rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libfit/runtime/law/response.hpp"

namespace palpate::fit {
namespace {

constexpr double kContactDepth = 1e-9;  // of the deepest row
constexpr double kRounding = 1e-6;      // of the depth, of a place that is written down

// Lateral force of the point's presses at a depth, linear between their rows: a body that moves
// sideways pushes so before any drag begins.
Vec3 pressed_sideways(const PointData& point, double depth) {
  double below = 0, above = std::numeric_limits<double>::infinity();
  Vec3 at_below = Vec3::Zero(), at_above = Vec3::Zero();
  for (const PointExperiment& e : point.experiments) {
    if (e.is_replayed) continue;
    for (std::size_t i = 0; i < e.row.size(); ++i) {
      const double here = depth_of(point, e.deflection[i]);
      const Vec3 lateral = lateral_of(point, e.force[i]);
      if (here >= below && here <= depth) below = here, at_below = lateral;
      if (here < above && here > depth) above = here, at_above = lateral;
    }
  }
  if (std::isinf(above)) return at_below;
  return at_below + (depth - below) / (above - below) * (at_above - at_below);
}

// The rms noise of an encoder in the places of a drag, by their distances from its line.
// None of a drag that goes straight to rounding, and none of paths, which may wander.
double jitter_of(const PointData& point, const PointExperiment& e) {
  if (e.kind != ExperimentKind::drag) return 0;
  std::vector<Vec3> place;
  Vec3 farthest = Vec3::Zero();
  for (std::size_t i = 0; i < e.row.size(); ++i) {
    place.push_back(lateral_of(point, e.tool_deflection(i)));
    if (place.back().norm() > farthest.norm()) farthest = place.back();
  }
  if (!(farthest.norm() > kRounding * point.depth)) return 0;
  const Vec3 along = farthest.normalized();
  double squares = 0;
  for (const Vec3& at : place) squares += (at - at.dot(along) * along).squaredNorm();
  const double rms = std::sqrt(squares / static_cast<double>(place.size()));
  return rms > kRounding * point.depth ? rms : 0;
}

// The outward stroke: of a drag its rows until the lateral deflection first shrinks by more than
// noise, of a press on a body that sways until the depth does. force: what the drag adds to that of
// a press as deep.
struct Stroke {
  std::vector<std::size_t> row;
  std::vector<double> dr, force;  // lateral
};

Stroke outward_stroke(const PointData& point, const PointExperiment& e) {
  Stroke stroke;
  const double jitter = 3 * jitter_of(point, e);  // a motion above it is not noise of the place
  double reached = 0;
  for (std::size_t i = 0; i < e.row.size(); ++i) {
    const Vec3 lateral = lateral_of(point, e.deflection[i]);
    const double dr = lateral.norm() > jitter ? lateral.norm() : 0;
    const double outward = e.is_drag ? dr : depth_of(point, e.deflection[i]);
    if (reached > kRounding * point.depth && outward < reached * (1 - 1e-6) - jitter) break;
    reached = std::max(reached, outward);
    if (!(depth_of(point, e.deflection[i]) > kContactDepth)) continue;
    stroke.row.push_back(i);
    stroke.dr.push_back(dr);
    const Vec3 added = e.force[i] - pressed_sideways(point, depth_of(point, e.deflection[i]));
    stroke.force.push_back(dr > 0 ? added.dot(lateral) / dr : 0.0);
  }
  return stroke;
}

// Index into the stroke where gross slip begins; its size when there is none. A drag slips when its
// last third rises less than a quarter of its first rows' stiffness; its plateau begins where 0.95
// of the largest force is reached. Only start values depend on it.
std::size_t plateau_begin(const Stroke& stroke) {
  std::vector<std::size_t> moved;
  for (std::size_t k = 0; k < stroke.row.size(); ++k)
    if (stroke.dr[k] > 1e-6 * stroke.dr.back()) moved.push_back(k);
  const std::size_t n = moved.size();
  if (n < 2) return stroke.row.size();

  std::vector<double> secants;
  for (std::size_t k = 0; k < std::max<std::size_t>(1, n / 3); ++k)
    secants.push_back(stroke.force[moved[k]] / stroke.dr[moved[k]]);
  const std::size_t from = n - std::max<std::size_t>(2, n / 3);
  double mean_dr = 0, mean_force = 0, cross = 0, square = 0;
  const auto count = static_cast<double>(n - from);
  for (std::size_t k = from; k < n; ++k) {
    mean_dr += stroke.dr[moved[k]] / count;
    mean_force += stroke.force[moved[k]] / count;
  }
  for (std::size_t k = from; k < n; ++k) {
    cross += (stroke.dr[moved[k]] - mean_dr) * (stroke.force[moved[k]] - mean_force);
    square += std::pow(stroke.dr[moved[k]] - mean_dr, 2);
  }
  if (!(square > 0) || cross / square > 0.25 * median(secants)) return stroke.row.size();

  const double plateau = 0.95 * lower_quantile(stroke.force, 0.9);
  for (const std::size_t k : moved)
    if (stroke.force[k] >= plateau) return k;
  return stroke.row.size();
}

void add_stick_row(const PointData& point, const PointExperiment& e, std::size_t i, double dr,
                   double force, CurveRows& out) {
  const double normal_force = e.force[i].dot(point.inward);
  const bool is_aside = dr > kRounding * point.depth;
  // On a body that sways a press moves sideways against the surface around it.
  const bool is_pressed = !is_aside || !e.is_drag;
  out.curve[0].push_back(
      {depth_of(point, e.deflection[i]), normal_force, e.weight[i], 0, 0, is_pressed});
  if (normal_force > 0.1)  // lighter rows have no clear friction
    out.largest_friction =
        std::max(out.largest_friction, lateral_of(point, e.force[i]).norm() / normal_force);
  if (is_aside)
    out.curve[1].push_back({dr, force, e.weight[i], 0, depth_of(point, e.deflection[i])});
}

// The contact point has followed by `slid`: the row in the frame it has there.
void add_slip_row(const PointData& point, const PointExperiment& e, std::size_t i, double slid,
                  CurveRows& out) {
  const Vec3 shadow = lateral_of(point, e.deflection[i]).normalized() * slid;
  const Vec3 turn = point.normal_gradient * shadow;
  const Vec3 normal = (point.inward + turn).normalized();
  const Vec3 contact = shadow - 0.5 * shadow.dot(turn) * point.inward;
  const double depth = (e.deflection[i] - contact).dot(normal);
  const double normal_force = e.force[i].dot(normal);
  if (!(depth > kContactDepth)) return;
  out.curve[0].push_back({depth, normal_force, e.weight[i], 0});
  out.curve[2].push_back({depth, (e.force[i] - normal_force * normal).norm(), e.weight[i], 0});
}

void add_drag(const PointData& point, const PointExperiment& e, CurveRows& out) {
  const Stroke stroke = outward_stroke(point, e);
  if (stroke.row.empty() || !(stroke.dr.back() > kRounding * point.depth)) {
    for (std::size_t k = 0; k < stroke.row.size(); ++k)
      add_stick_row(point, e, stroke.row[k], 0, 0, out);
    return;
  }
  const std::size_t slip = e.is_drag ? plateau_begin(stroke) : stroke.row.size();
  out.drags += e.is_drag;
  out.slipping_drags += e.is_drag && slip < stroke.row.size();
  const double hold = stroke.dr[std::min(slip, stroke.row.size() - 1)];
  out.lateral_reach = std::max(out.lateral_reach, hold);
  for (std::size_t k = 0; k < stroke.row.size(); ++k) {
    if (k < slip)
      add_stick_row(point, e, stroke.row[k], stroke.dr[k], stroke.force[k], out);
    else
      add_slip_row(point, e, stroke.row[k], stroke.dr[k] - hold, out);
  }
}

}  // namespace

CurveRows curve_rows(const PointData& point) {
  CurveRows out;
  for (const PointExperiment& e : point.experiments) {
    if (e.is_replayed) {
      add_drag(point, e, out);
      continue;
    }
    for (std::size_t i = 0; i < e.row.size(); ++i)
      if (depth_of(point, e.deflection[i]) > kContactDepth) add_stick_row(point, e, i, 0, 0, out);
  }
  return out;
}

int group_by_abscissa(std::vector<CurveRow>& rows, double range, double share) {
  std::stable_sort(rows.begin(), rows.end(),
                   [](const CurveRow& a, const CurveRow& b) { return a.x < b.x; });
  int group = -1;
  double start = 0;
  for (CurveRow& row : rows) {
    if (group < 0 || row.x - start > share * range) start = row.x, ++group;
    row.group = group;
  }
  return group + 1;
}

}  // namespace palpate::fit
