#include "libfem/probes/probes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "libfem/probes/mesh_field.hpp"
#include "libfem/probes/shapes.hpp"
#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

template <class Shape>
constexpr ShapeRow shape_row(std::string_view name, std::string_view summary, bool is_axisymmetric,
                             bool takes_mesh = false) {
  return {name,
          summary,
          Shape::kParameters,
          is_axisymmetric,
          takes_mesh,
          Shape::complete,
          Shape::signed_distance,
          Shape::bounding_ball,
          Shape::contact_radius_m,
          Shape::mesh_length_m,
          Shape::contact_reach_m,
          Shape::tip_radius_m,
          Shape::half_width_m,
          Shape::contact_line_m,
          Shape::edge_ring_m};
}

// One row per shape; add a shape by its file and a row.
constexpr std::array<ShapeRow, 5> kShapes{{
    shape_row<SphereShape>("sphere", "a ball of the given radius", true),
    shape_row<FlatShape>("flat", "a flat-ended rod with a rounded edge", true),
    shape_row<CapsuleShape>("capsule", "a rod with two round ends, pressed with one or lying",
                            false),
    shape_row<ConeShape>("cone", "a cone with a rounded tip", true),
    shape_row<MeshShape>("mesh", "a closed triangle mesh from a file", false, true),
}};

/// Element size under the edge of a rod that leans, over that along the drags of one that does not.
constexpr double kTiltedEdge = 0.5;

const ProbeParameter* find_parameter(const ShapeRow& row, std::string_view key) {
  for (const ProbeParameter& parameter : row.parameters)
    if (parameter.key == key) return &parameter;
  return nullptr;
}

std::string example_of(const ProbeParameter& parameter) {
  return std::string(parameter.key) + " = \"" + std::string(parameter.example) + "\"";
}

void check_values(const ProbeParameter& parameter, const std::vector<double>& values,
                  const std::string& where) {
  const std::string key(parameter.key);
  if (values.size() != 1)
    throw Error(where, key + " must hold one number, not " + std::to_string(values.size()),
                "Write " + example_of(parameter) + ".");
  if (const double value = values[0]; !(std::isfinite(value) && value > 0))
    throw Error(where,
                key + " must be positive, not " + std::to_string(value) + " " +
                    (parameter.dimension == Dimension::angle ? "rad" : "m"),
                "Give it with its unit, for example " + example_of(parameter) + ".");
}

/// Puts the values of the shape's keys in their order, NaN where a key is left out.
void read_numbers(const ShapeRow& row, const ProbeSpec& spec, const std::string& where,
                  ProbeGeometry& probe) {
  for (const auto& [key, values] : spec.values)
    if (!find_parameter(row, key)) refuse_probe_key(row, key, where);
  std::size_t next = 0;
  for (const ProbeParameter& parameter : row.parameters) {
    const auto found = spec.values.find(parameter.key);
    if (found != spec.values.end())
      check_values(parameter, found->second, where);
    else if (parameter.is_required)
      throw Error(where,
                  "shape \"" + std::string(row.name) + "\" needs " + std::string(parameter.key) +
                      ", " + std::string(parameter.summary),
                  "Add " + example_of(parameter) + ".");
    probe.number[next++] =
        found == spec.values.end() ? std::numeric_limits<double>::quiet_NaN() : found->second[0];
  }
}

void read_orientation(const ShapeRow& row, const ProbeSpec& spec, const std::string& where,
                      ProbeGeometry& probe) {
  if (row.is_axisymmetric && spec.orientation) refuse_probe_key(row, "orientation", where);
  if (spec.orientation && !(spec.orientation->allFinite() && spec.orientation->norm() > 0))
    throw Error(where, "orientation is no direction", "Write three numbers that are not all 0.");
  probe.turn =
      turn_inward(spec.orientation.value_or((row.takes_mesh ? -1.0 : 1.0) * Vec3::UnitZ()));
}

// The foremost point of a convex shape along `direction`, in its own axes: the nearest to a place
// far out; twice, as the first sees the shape under an angle of its width over the distance.
std::optional<Vec3> foremost(const Probe& probe, const Vec3& axis, const Vec3& direction) {
  constexpr double kNear = 1e2;  // of the tool's width
  const double width = std::max(probe.half_width_m, probe.length_m);
  Vec3 nearest = Vec3::Zero();
  for (int look = 0; look < 2; ++look) {
    const Vec3 far = nearest + 1e6 * width * direction;
    const SignedDistance at = probe.shape->signed_distance(probe.geometry, axis, far);
    nearest = far - at.distance_m * at.gradient;
    if (!(nearest.norm() < kNear * width)) return std::nullopt;
  }
  return nearest;
}

constexpr double kSteepest_rad = 84 * std::numbers::pi / 180;
constexpr double kRound = 1e-6;  // of a slope: how alike it is all around
constexpr int kPlaces = 1200;    // along a profile, before most are left out

struct ProfilePlace {
  double r_m, angle_rad;  // of the surface, 0 where it is flat
};

// The surface's slope at r from the axis, `around` it; nothing where there is none below.
std::optional<double> angle_at(const Probe& probe, double r_m, double around_rad) {
  const Vec3 axis = Vec3::UnitZ(), out(std::cos(around_rad), std::sin(around_rad), 0);
  double height_m = 0;  // above the reference point
  for (int step = 0; step < 100; ++step) {
    const SignedDistance at = probe.distance(axis, r_m * out - height_m * axis);
    const double along = at.gradient.dot(axis);
    if (!(along > std::cos(kSteepest_rad) / 2)) return std::nullopt;
    const double step_m = at.distance_m / along;  // distance falls as the place rises into the tool
    if (std::abs(at.distance_m) <= 1e-13 * probe.length_m)
      return std::atan2(at.gradient.dot(out), along);
    height_m += step_m;
  }
  return std::nullopt;
}

std::vector<ProfilePlace> profile_of(const Probe& probe) {
  // Shapes that widen without end are followed to 60 radii of the tip.
  const double tip_m = probe.shape->tip_radius_m(probe.geometry),
               width_m = std::min(probe.shape->half_width_m(probe.geometry), 60.0 * tip_m);
  std::vector<ProfilePlace> places{{0, 0}};
  for (int i = 1; i < kPlaces; ++i) {
    // Half of them where tips are, half over the whole width.
    const double share = double(i) / kPlaces;
    const double r_m = width_m * (width_m > 2 * tip_m ? share * share : share);
    const auto angle = angle_at(probe, r_m, 0.3);
    if (!angle || *angle > kSteepest_rad) break;
    for (const double around : {1.7, 3.9, 5.2}) {
      const auto other = angle_at(probe, r_m, around);
      if (!other || std::abs(*other - *angle) > kRound) return {};
    }
    if (*angle < places.back().angle_rad - kRound) return {};
    places.push_back({r_m, std::max(*angle, places.back().angle_rad)});
  }
  return places;
}

// Leaves out places between which slopes are linear to a tolerance (Ramer, Douglas, Peucker).
void keep_turns(const std::vector<ProfilePlace>& places, std::size_t from, std::size_t to,
                double tolerance, std::vector<char>& is_kept) {
  double most = 0;
  std::size_t at = from;
  for (std::size_t i = from + 1; i < to; ++i) {
    const double share = (places[i].r_m - places[from].r_m) / (places[to].r_m - places[from].r_m);
    const double line =
        (1 - share) * std::tan(places[from].angle_rad) + share * std::tan(places[to].angle_rad);
    // Slopes below 0.03 need be right to no share of themselves.
    const double residual =
        std::abs(std::atan(line) - places[i].angle_rad) / (0.03 + places[i].angle_rad);
    if (residual > most) most = residual, at = i;
  }
  if (!(most > tolerance)) return;
  is_kept[at] = 1;
  keep_turns(places, from, at, tolerance, is_kept);
  keep_turns(places, at, to, tolerance, is_kept);
}

}  // namespace

std::span<const ShapeRow> probe_shapes() { return kShapes; }

const ShapeRow& find_shape(std::string_view name, const std::string& where) {
  std::string names;
  for (const ShapeRow& row : kShapes) {
    if (row.name == name) return row;
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  }
  throw Error(where, "unknown probe shape \"" + std::string(name) + "\"",
              "Use one of: " + names + ".");
}

std::vector<std::string_view> probe_keys(const ShapeRow& row) {
  std::vector<std::string_view> keys;
  for (const ProbeParameter& parameter : row.parameters) keys.push_back(parameter.key);
  if (row.takes_mesh) keys.insert(keys.end(), {"mesh", "length_unit"});
  if (!row.is_axisymmetric) keys.push_back("orientation");
  return keys;
}

void refuse_probe_key(const ShapeRow& row, std::string_view key, const std::string& where) {
  std::string takers, own;
  for (const ShapeRow& other : kShapes)
    for (const std::string_view known : probe_keys(other))
      if (known == key) takers += (takers.empty() ? "" : ", ") + std::string(other.name);
  for (const std::string_view known : probe_keys(row))
    own += (own.empty() ? "" : ", ") + std::string(known);
  throw Error(where, "shape \"" + std::string(row.name) + "\" has no " + std::string(key),
              (takers.empty() ? "" : std::string(key) + " belongs to shape " + takers + ". ") +
                  "A " + std::string(row.name) + " takes " + own + ".");
}

ContactLine Probe::contact_line_m(const Vec3& axis, double depth_m) const {
  const ContactLine own = shape->contact_line_m(geometry, depth_m);
  const Mat3 frame = probe_frame(axis);
  return {frame * own.from, frame * own.to};
}

Probe make_probe(const ProbeSpec& spec, const std::string& where) {
  const ShapeRow& row = find_shape(spec.shape, where);
  if (!(std::isfinite(spec.friction) && spec.friction >= 0))
    throw Error(where, "friction must be zero or positive, not " + std::to_string(spec.friction),
                "Give the Coulomb coefficient of the interface, 0 for none.");
  Probe probe;
  probe.shape = &row;
  probe.friction = spec.friction;
  read_numbers(row, spec, where, probe.geometry);
  read_orientation(row, spec, where, probe.geometry);
  if (row.takes_mesh)
    probe.geometry.mesh = std::make_shared<MeshField>(spec.mesh, probe.geometry.number[0], where);
  const std::string refusal = row.complete(probe.geometry);
  if (!refusal.empty()) throw Error(where, refusal, "Correct the numbers of the probe.");
  probe.ball = row.bounding_ball(probe.geometry);
  return pressed_to(std::move(probe), 0);
}

// A rod touches with its edge first, whose pressure is as narrow as a contact with it is.
double Probe::mesh_length_m(double depth_m) const {
  const double upright = shape->mesh_length_m(geometry, depth_m);
  return leans && shape->edge_ring_m(geometry) > 0 ? kTiltedEdge * upright : upright;
}

// From the point of first touch across the tool to where it is that deep.
double Probe::contact_reach_m(double depth_m) const {
  const double upright = shape->contact_reach_m(geometry, depth_m);
  if (!leans || !(shape->edge_ring_m(geometry) > 0)) return upright;
  const double sine = (turn - Mat3::Identity()).norm() / std::sqrt(2.0);  // 2 sin(tilt / 2)
  return std::min(2 * upright, upright * kTiltedEdge + depth_m / std::max(sine, 1e-9));
}

Probe tilted(const Probe& upright, const Vec3& axis, const Lean& lean, const std::string& where) {
  if (!(lean.norm() > 0)) return upright;
  Probe out = upright;
  out.turn = tilt_turn(axis, lean);
  if (!upright.shape->is_axisymmetric) {  // its own axes turn; its row knows the rest
    const Mat3 frame = probe_frame(axis);
    out.geometry.turn = frame.transpose() * out.turn * frame * out.geometry.turn;
    out.turn.setIdentity();
    const std::string refusal = out.shape->complete(out.geometry);
    if (!refusal.empty()) throw Error(where, refusal, "Tilt the tool less.");
    out.ball = out.shape->bounding_ball(out.geometry);
    return pressed_to(std::move(out), 0);
  }
  const std::optional<Vec3> point = foremost(upright, axis, out.turn.transpose() * axis);
  if (!point)
    throw Error(where,
                "a " + std::string(upright.shape->name) +
                    " that leans so far touches with "
                    "its side first",
                "Tilt the tool less.");
  out.leans = true;
  out.touch = out.turn * *point;
  return out;
}

Stance stance(const Probe& probe, const Vec3& axis) {
  if (!probe.shape->is_axisymmetric)
    return {probe_frame(axis) * probe.geometry.turn, probe.geometry.touch};
  Mat3 upright = tilt_frame(axis);
  upright.col(2) = -axis;
  const Mat3 axes = probe.turn * upright;
  return {axes, axes.transpose() * probe.touch};
}

double round_end_m(const Probe& probe) {
  const std::string_view shape = probe.shape->name;
  const std::array<double, 4>& number = probe.geometry.number;
  if (shape == "sphere") return SphereShape::radius_m(probe.geometry);
  if (shape == "cone") return ConeShape::tip_radius_m(probe.geometry);
  if (shape == "flat" && number[0] == number[1]) return number[0];
  const bool is_upright = std::abs(std::abs(CapsuleShape::inward(probe.geometry).z()) - 1) < 1e-9;
  return shape == "capsule" && is_upright ? number[0] : 0;
}

Probe pressed_to(Probe probe, double depth_m) {
  const double tip = probe.shape->tip_radius_m(probe.geometry);
  const double half_width = probe.shape->half_width_m(probe.geometry);
  const double a = depth_m > 0 ? probe.contact_radius_m(depth_m) : 0;
  probe.length_m = std::clamp(depth_m > 0 ? a * a / depth_m : tip, tip, std::max(tip, half_width));
  probe.half_width_m = std::isfinite(half_width) ? half_width : probe.length_m;
  return probe;
}

std::optional<Indenter> round_end(const Probe& probe) {
  Indenter out;
  if (probe.shape->name == std::string_view("sphere")) {
    out.round_end_m = probe.shape->tip_radius_m(probe.geometry);
    return out;
  }
  if (probe.leans) return std::nullopt;
  const std::vector<ProfilePlace> places = profile_of(probe);
  if (places.size() < 8) return std::nullopt;
  std::vector<char> is_kept;
  for (double tolerance = 3e-4;; tolerance *= 1.5) {
    is_kept.assign(places.size(), 0);
    is_kept.front() = is_kept.back() = 1;
    keep_turns(places, 0, places.size() - 1, tolerance, is_kept);
    if (std::ranges::count(is_kept, 1) <= runtime::kMaxProfilePoints) break;
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!is_kept[i]) continue;
    out.r_m[out.points] = places[i].r_m;
    out.slope[out.points++] = std::tan(places[i].angle_rad);
  }
  const double first = std::tan(places[1].angle_rad);
  out.round_end_m = first > kRound ? places[1].r_m / std::sin(places[1].angle_rad) : 0;
  return out;
}

std::optional<Indenter> round_end(const std::optional<ProbeSpec>& probe) {
  if (!probe || probe->shape == "point") return std::nullopt;
  return round_end(make_probe(*probe, "the probe of the data"));
}

}  // namespace palpate::fem
