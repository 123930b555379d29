#pragma once

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/geometry.hpp"
#include "libfit/core/probe.hpp"
#include "libfit/core/tilt.hpp"
#include "libfit/core/units.hpp"

namespace palpate::fem {

class MeshField;

/// Signed distance to a probe's surface and its derivatives at one place.
/// distance_m > 0 outside; gradient is the probe's outward unit normal there; hessian [1/m] is the
/// curvature of the distance field, which contact stiffness needs. On the medial axis, where the
/// nearest point of the surface is not unique, it is one of the normals or zero.
struct SignedDistance {
  double distance_m = 0;
  Vec3 gradient = Vec3::Zero();
  Mat3 hessian = Mat3::Zero();
};

/// A key of [probe] that a shape reads: a number. Left out, a key that is
/// not required is filled in by the shape.
struct ProbeParameter {
  std::string_view key, summary, example;
  Dimension dimension = Dimension::length;
  bool is_required = true;
};

/// A shape with its numbers: `number` in the order of its parameter rows. For shapes with axes of
/// their own: turn takes own axes to the probe's frame (probe_frame), and `touch` is the
/// reference point in own axes.
struct ProbeGeometry {
  std::array<double, 4> number{};
  Mat3 turn = Mat3::Identity();
  Vec3 touch = Vec3::Zero();
  std::shared_ptr<const MeshField> mesh;
};

/// A ball about reference point + along_axis_m * u that holds the whole probe; radius +inf for
/// shapes with a shaft that has no end.
struct BoundingBall {
  double along_axis_m = 0;
  double radius_m = std::numeric_limits<double>::infinity();
};

/// Ends of a line across the axis, from the reference point.
struct ContactLine {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();
};

/// A rigid tool shape. It is placed by its reference point x (the point that touches first on a
/// flat surface) and the unit axis u that points into the body.
/// complete: fills numbers left out (NaN) and whatever else evaluation needs; says why the numbers
/// cannot be used, empty when they can. signed_distance: at `offset` from the reference point [m];
/// exact (a mesh: smoothed, see mesh_field.hpp), without allocation, C1 away from the medial axis.
/// contact_radius_m: expected smaller half-width of the contact with a flat soft body at a depth;
/// mesh_length_m: what element sizes are measured in, that half-width or less where pressure peaks
/// at an edge; contact_reach_m: how far from the reference point or the line of contact they count,
/// the larger half-width or more. tip_radius_m: smallest radius of curvature where it touches
/// first, no more than the half width; of a flat its own radius. half_width_m: across the axis,
/// +inf when it widens without end.
struct ShapeRow {
  std::string_view name, summary;
  std::span<const ProbeParameter> parameters;
  bool is_axisymmetric;  ///< about u, whatever its numbers; else it takes an orientation
  bool takes_mesh;
  std::string (*complete)(ProbeGeometry&);
  SignedDistance (*signed_distance)(const ProbeGeometry&, const Vec3& axis, const Vec3& offset);
  BoundingBall (*bounding_ball)(const ProbeGeometry&);
  double (*contact_radius_m)(const ProbeGeometry&, double depth_m);
  double (*mesh_length_m)(const ProbeGeometry&, double depth_m);
  double (*contact_reach_m)(const ProbeGeometry&, double depth_m);
  double (*tip_radius_m)(const ProbeGeometry&);
  double (*half_width_m)(const ProbeGeometry&);
  /// The line that it touches along at a depth, probe's frame; 0: about its reference point alone.
  ContactLine (*contact_line_m)(const ProbeGeometry&, double depth_m);
  /// Radius of the ring about the axis where pressure peaks from the first touch on; 0: none.
  double (*edge_ring_m)(const ProbeGeometry&);
};

/// Every shape there is.
std::span<const ShapeRow> probe_shapes();

/// The shape's row. Throws Error at `where` naming the known shapes.
const ShapeRow& find_shape(std::string_view name, const std::string& where);

/// Keys of [probe] that a shape takes, besides shape and friction.
std::vector<std::string_view> probe_keys(const ShapeRow& row);

/// Throws the Error at `where` for a key that the shape does not take, naming the shapes that do.
[[noreturn]] void refuse_probe_key(const ShapeRow& row, std::string_view key,
                                   const std::string& where);

/// A probe ready for evaluation. length_m is the radius of the ball that presses alike (see
/// pressed_to): contact stiffness, tolerated penetration and the length of steps are measured in
/// it. half_width_m: across the axis; length_m for shapes that widen without end.
struct Probe {
  const ShapeRow* shape = nullptr;
  ProbeGeometry geometry;
  BoundingBall ball;
  double length_m = 0;
  double half_width_m = 0;
  double friction = 0;
  /// For a tool that leans and is round about its axis (tilted()): its turn in the body's axes, and
  /// the reference point from the point that touches a flat surface first when it is upright.
  Mat3 turn = Mat3::Identity();
  Vec3 touch = Vec3::Zero();
  bool leans = false;

  SignedDistance distance(const Vec3& axis, const Vec3& offset) const {
    if (!leans) return shape->signed_distance(geometry, axis, offset);
    SignedDistance out =
        shape->signed_distance(geometry, axis, turn.transpose() * (offset + touch));
    out.gradient = turn * out.gradient;
    out.hessian = turn * out.hessian * turn.transpose();
    return out;
  }
  /// A lower bound of the signed distance that costs little.
  double min_distance_m(const Vec3& axis, const Vec3& offset) const {
    if (!leans && ball.radius_m < std::numeric_limits<double>::infinity())
      return (offset - ball.along_axis_m * axis).norm() - ball.radius_m;
    return distance(axis, offset).distance_m;
  }
  /// Expected smaller half-width of the contact at a depth, on a linear elastic half-space without
  /// friction (Sneddon 1965, doi:10.1016/0020-7225(65)90019-4).
  double contact_radius_m(double depth_m) const {
    return shape->contact_radius_m(geometry, depth_m);
  }
  /// The length in which element sizes are measured: the contact radius of round shapes.
  double mesh_length_m(double depth_m) const;
  /// The line along which it touches a flat surface at a depth, in the body's axes.
  ContactLine contact_line_m(const Vec3& axis, double depth_m) const;
  /// Radius of the edge about the axis at which pressure is all but singular; 0 for shapes without.
  double edge_ring_m() const { return leans ? 0 : shape->edge_ring_m(geometry); }
  /// Distance from there to which the mesh has to be that fine: the contact radius of round shapes.
  double contact_reach_m(double depth_m) const;
};

/// Looks the shape up and checks its numbers; length_m is the tip's radius. Throws Error at
/// `where` when the shape or a key is unknown, a key is missing or a value cannot be used, the
/// friction is negative, or a mesh is open, not manifold, inside out or without volume.
Probe make_probe(const ProbeSpec& spec, const std::string& where);

/// The same tool as it leans at a place whose inward unit normal is `axis` (M58c). Its reference
/// point is the point that then touches a flat surface first; torques are about it. `axis` stays
/// what it is presses along. Throws Error at `where` where no point of the tool does: the flank of
/// a cone, the shaft of a rod.
Probe tilted(const Probe& upright, const Vec3& axis, const Lean& lean, const std::string& where);

/// Pose of a tool, upright or leaning (tilted()), at a place whose inward unit normal is `axis`.
/// One that is round about its axis has the tip of the upright tool at its origin and its shaft
/// along own z.
Stance stance(const Probe& probe, const Vec3& axis);

/// Radius of the ball that a tool which is round about its axis ends with [m]; 0 where it ends with
/// none, or is not round (a lying capsule, a mesh, a rod that is not rounded fully).
double round_end_m(const Probe& probe);

/// Profile of a tool's end along its press, for whatever plays it (docs/method-tools.md, section
/// 30): of any shape, by its signed distance. Nothing of a tool that is not round about the press
/// (a lying capsule, a mesh that is not) or not convex there. What is steeper than 84 degrees
/// counts as a wall.
std::optional<Indenter> round_end(const Probe& probe);
/// The same of what travels with data; nothing of no probe and of a point.
std::optional<Indenter> round_end(const std::optional<ProbeSpec>& probe);

/// The same probe for presses down to depth_m: length_m becomes a(d)^2 / d with the contact radius
/// a (R for a ball), at least the tip's radius and at most the half width. A ball keeps R and a
/// flat punch has its own radius at every depth; a cone that dips far deeper than its rounded tip
/// presses with its flank, and stiffness for the tip alone would only make it hard to solve.
Probe pressed_to(Probe probe, double depth_m);

}  // namespace palpate::fem
