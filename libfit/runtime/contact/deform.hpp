// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Displacement of the surface under tools, for a thread that draws: reads copies of contacts and
// the asset's shape response. No heap, no lock, no exception.

#include "../asset/shape.hpp"
#include "../base/room.hpp"
#include "contact.hpp"

namespace palpate::runtime {

constexpr int kShapeFunctions = kShapePressed + kShapeDragged;

/// Position of a tool relative to its contact point, as the shape response reads it.
struct DentState {
  Vec3d point;      ///< contact point, relative to the asset's origin
  Vec3d normal;     ///< inward unit
  double normal_m;  ///< deflection along it
  Vec3d carried_m;  ///< what friction has carried of it: the rings' mean deflection
  Vec3d lateral_m;  ///< and across it
  Vec3d force_N;    ///< the law's, on the body
  Vec3d centre;     ///< of the ball, if there is one
  double radius_m;  ///< of that ball; 0: none
};

/// The four cubic B-splines that are not zero on an interval, at t in [0, 1] of it.
inline void cubic_weights(double t, double w[4]) noexcept {
  const double r = 1 - t, t2 = t * t, t3 = t2 * t;
  w[0] = r * r * r * (1.0 / 6);
  w[1] = (3 * t3 - 6 * t2 + 4) * (1.0 / 6);
  w[2] = (-3 * t3 + 3 * t2 + 3 * t + 1) * (1.0 / 6);
  w[3] = t3 * (1.0 / 6);
}

/// A vertex relative to a contact point: direction and distance along the surface (M30).
struct ShapePlace {
  Vec3d out;      ///< t / (r + a): from the contact point along its tangent plane, < 1
  double facing;  ///< 1 where the surface faces as it does at the contact point, 0 on a far side
  int first;      ///< spline interval; beyond the last one nothing is near
  double w[4];    ///< of the splines there
};

/// Returns true if a vertex at X with inward normal N is near the contact point; fills where it is.
inline bool find_place(const DentState& state, double radius_m, int intervals, const Vec3d& X,
                       const Vec3d& N, ShapePlace& place) noexcept {
  const Vec3d offset = X - state.point - (state.lateral_m - state.carried_m * kShapeCarried);
  const double r = std::sqrt(dot(offset, offset));
  const double y = r / (r + radius_m);
  if (!(y < kShapeEnd)) return false;
  const double cosine = 2 * dot(N, state.normal) + 0.5;
  const double f = cosine > 0 ? (cosine < 1 ? cosine : 1) : 0;
  place.facing = f * f * (3 - 2 * f);
  if (!(place.facing > 0)) return false;
  const double at = y * (intervals / kShapeEnd);
  place.first = static_cast<int>(at);
  if (place.first >= intervals) place.first = intervals - 1;
  cubic_weights(at - place.first, place.w);
  place.out = tangential(offset, state.normal) * (1 / (r + radius_m));
  return true;
}

/// The contact radius that lengths are measured in, at a depth > 0.
inline double shape_radius_m(const ShapeView& shape, double depth_m) noexcept {
  const double x = depth_m / shape.depth_m;
  return shape.radius_m * (shape.radius_power == 0   ? 1
                           : shape.radius_power == 1 ? std::sqrt(x)
                                                     : x);
}

/// The mean deflection of the rings that touch, by their stiffness; of other families the whole
/// deflection across u.
inline Vec3d carried_m(const AssetView& asset, const Contact& contact, const Vec3d& normal,
                       double normal_m, const Vec3d& lateral_m) noexcept {
  if (asset.curves.family != int(Family::rings)) return lateral_m;
  Corners corners;
  corners.take(asset, contact.triangle);
  MeshSpot<double> spot{{}, normal, 1, {}, {}, asset.control_offset};
  for (int k = 0; k < 3; ++k) {
    spot.n[k] = contact.weight[k];
    spot.corner[k] = &corners[k];
  }
  const auto bed = bed_at<double>(asset.curves, spot);
  const auto anchors = Rings::load<double>(contact.memory);
  Vec3d sum{0, 0, 0};
  double stiffness_N_m = 0;
  for (int i = 0; i < kRings; ++i) {
    if (!(normal_m > (i == 0 ? 0 : asset.curves.rings.threshold_m[i]))) break;
    stiffness_N_m += bed.stiffness_N_m[i];
    sum = sum + (lateral_m - anchors.at(i)) * bed.stiffness_N_m[i];
  }
  return stiffness_N_m > 0 ? sum * (1 / stiffness_N_m) : lateral_m;
}

/// Finds the state of a copied contact; false in the air. A tip stands for the ball that the curves
/// were measured with.
inline bool shape_state(const AssetView& asset, const Contact& contact, double tool_radius_m,
                        DentState& out) noexcept {
  if (contact.triangle < 0) return false;
  const int t = contact.triangle;
  out.point = {0, 0, 0};
  for (int k = 0; k < 3; ++k)
    out.point = out.point + asset.vertex_at(asset.corner(t, k)) * contact.weight[k];
  out.normal = blended_normal(asset, t, contact.weight);
  const Vec3d tip = make_vec3<double>(contact.tip_m) - make_vec3<double>(contact.arm.pole_m);
  out.force_N = contact.series.force();
  const Vec3d deflection = tip - make_vec3<double>(contact.series.aside_m) - out.point +
                           out.normal * contact.arm.reach_m + make_vec3<double>(contact.arm.skew_m);
  out.normal_m = dot(deflection, out.normal);
  out.lateral_m = tangential(deflection, out.normal);
  out.carried_m = carried_m(asset, contact, out.normal, out.normal_m, out.lateral_m);
  out.radius_m = tool_radius_m > 0 ? tool_radius_m : asset.probe_radius_m;
  out.centre = contact.arm.reach_m > 0 ? tip : tip - out.normal * out.radius_m;
  return out.normal_m > 0;
}

/// A shape response at one state, ready to be evaluated at any vertex.
class Deformation {
 public:
  Deformation(const AssetView& asset, const Contact& contact, const DentState& state) noexcept
      : asset_(asset), state_(state) {
    const ShapeView& shape = asset.shape;
    const CurveViews& curves = asset.curves;
    // The surface moves as under the asset's own ball with a contact as wide.
    const double depth_m = curves.indenter == nullptr
                               ? state.normal_m
                               : own_depth(*curves.indenter, curves.view[kNormal], state.normal_m);
    radius_m_ = shape_radius_m(shape, depth_m);
    const double x = depth_m / shape.depth_m;
    double known = 0;
    for (int k = 0; k < 3; ++k) {
      const int blend = 3 * asset.record[asset.corner(contact.triangle, k)];
      for (int j = 0; j < 3; ++j) {
        const double weight = contact.weight[k] * double(shape.blend_weight[blend + j]);
        if (!(weight > 0)) continue;
        known += weight;
        add_point(shape.point + std::ptrdiff_t{shape.blend_point[blend + j]} *
                                    shape_numbers(shape.intervals, shape.modes),
                  weight, x);
      }
    }
    const float* drag = shape.drag;
    for (int i = 0; i < kShapeDragged; ++i)
      for (int j = 0; j < shape.intervals; ++j)
        near_[j][kShapePressed + i] = known * double(*drag++);
  }

  /// Displacement [m] of a vertex (M31, M32); push_out() brings it out of the ball.
  Vec3d at(int v) const noexcept {
    const ShapeView& shape = asset_.shape;
    const Vec3d X = asset_.vertex_at(v);
    Vec3d moved{0, 0, 0};
    const float* mode = shape.mode + std::ptrdiff_t{v} * (3 * shape.modes);
    for (int k = 0; k < shape.modes; ++k, mode += 3) {
      moved.x += mode_[k] * double(mode[0]);
      moved.y += mode_[k] * double(mode[1]);
      moved.z += mode_[k] * double(mode[2]);
    }
    ShapePlace place;
    if (find_place(state_, radius_m_, shape.intervals, X, asset_.normal_at(v), place)) {
      double f[kShapeFunctions];
      for (int i = 0; i < kShapeFunctions; ++i) {
        f[i] = 0;
        for (int j = 0; j < 4; ++j) f[i] += place.w[j] * near_[place.first + j][i];
      }
      const Vec3d& q = state_.carried_m;
      const double along = dot(q, place.out);
      const Vec3d near =
          state_.normal * (f[0] + f[4] * along) + place.out * (f[1] + f[3] * along) + q * f[2];
      moved = moved + near * place.facing;
    }
    return moved;
  }
  /// A vertex that rests at X does not end in the ball.
  void push_out(const Vec3d& X, Vec3d& moved) const noexcept {
    const Vec3d away = X + moved - state_.centre;
    const double squared = dot(away, away), R = state_.radius_m;
    if (!(R > 0 && squared < R * R)) return;
    const double length = std::sqrt(squared);
    moved = length > 0 ? moved + away * (R / length - 1) : moved + state_.normal * R;
  }

 private:
  void add_point(const float* number, double weight, double x) noexcept {
    const ShapeView& shape = asset_.shape;
    double power[kShapeDepths];
    for (int p = 0; p < kShapeDepths; ++p)
      power[p] = p == 0 ? weight * state_.normal_m : power[p - 1] * x;
    for (int i = 0; i < kShapePressed; ++i)
      for (int p = 0; p < kShapeDepths; ++p)
        for (int j = 0; j < shape.intervals; ++j) near_[j][i] += power[p] * double(*number++);
    const double force_N[3] = {state_.force_N.x, state_.force_N.y, state_.force_N.z};
    for (const double f : force_N)
      for (int k = 0; k < shape.modes; ++k) mode_[k] += weight * f * double(*number++);
  }

  const AssetView& asset_;
  DentState state_;
  double radius_m_;
  double near_[kMaxShapeIntervals + 3][kShapeFunctions] = {};  ///< the last three stay 0
  double mode_[kMaxShapeModes] = {};
};

/// A copied contact, the radius of its ball (0: a tip), and its own asset (null: the shared
/// one).
struct Dent {
  const Contact* contact;
  double radius_m;
  const AssetView* asset = nullptr;
};
constexpr int kMaxDents = 8;

/// Displacements [m] of vertices first to first + count - 1 (which exist) under copied contacts, up
/// to kMaxDents of one tick, in the body's frame, three numbers each; zero in the air and with any
/// status but ok. Dents are added; each contact's is measured from the body as the others have
/// moved it. No vertex is left in the last of the balls.
PALPATE_ONCE Status deform(const AssetView& asset, const Dent* dent, int dents, int first,
                           int count, float* displacement_m) noexcept
#if PALPATE_HAS_BODIES
{
  for (std::ptrdiff_t i = 0; i < 3 * std::ptrdiff_t{count}; ++i) displacement_m[i] = 0;
  if (asset.shape.points == 0) return Status::no_shape;
  Room<Deformation, kMaxDents> room;
  int touching = 0;
  for (int i = 0; i < dents && touching < kMaxDents; ++i) {
    const Contact& contact = *dent[i].contact;
    if (contact.triangle < 0) continue;
    const AssetView& own = dent[i].asset != nullptr ? *dent[i].asset : asset;
    if (contact.asset_checksum != own.checksum || contact.triangle >= asset.triangles)
      return Status::contact_foreign;
    DentState state;
    if (shape_state(own, contact, dent[i].radius_m, state))
      room.make(touching++, own, contact, state);
  }
  for (int v = first; touching > 0 && v < first + count; ++v, displacement_m += 3) {
    Vec3d moved{0, 0, 0};
    for (int i = 0; i < touching; ++i) moved = i == 0 ? room[i].at(v) : moved + room[i].at(v);
    for (int i = 0; i < touching; ++i) room[i].push_out(asset.vertex_at(v), moved);
    displacement_m[0] = static_cast<float>(moved.x);
    displacement_m[1] = static_cast<float>(moved.y);
    displacement_m[2] = static_cast<float>(moved.z);
  }
  return Status::ok;
}
#else
    ;
#endif

/// The same of one.
inline Status deform(const AssetView& asset, const Contact& contact, double radius_m, int first,
                     int count, float* displacement_m) noexcept {
  const Dent one{&contact, radius_m};
  return deform(asset, &one, 1, first, count, displacement_m);
}

}  // namespace palpate::runtime
