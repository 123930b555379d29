#pragma once

#include <Eigen/Geometry>
#include <array>

#include "libfit/core/geometry.hpp"

namespace palpate::fem {

inline constexpr int kFaceNodes = 6;
inline constexpr int kFacePoints = 6;
inline constexpr int kFaceBlocks = kFaceNodes * (kFaceNodes + 1) / 2;  ///< node pairs a >= b

/// A quadrature point of the reference triangle with the six-node shape functions there and their
/// derivatives by the area coordinates r, s of corners 1 and 2.
struct FacePoint {
  double weight;
  std::array<double, kFaceNodes> shape, shape_r, shape_s;
};

constexpr FacePoint face_point(double weight, double r, double s) {
  const double t = 1 - r - s;
  return {weight,
          {t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t},
          {1 - 4 * t, 4 * r - 1, 0, 4 * (t - r), 4 * s, -4 * s},
          {1 - 4 * t, 0, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)}};
}

/// Places of a face's nodes [m]: three corners, then the middles of its edges.
using FaceNodes = std::array<Vec3, kFaceNodes>;

template <class Face>
FaceNodes nodes_of_face(const Points& nodes, const Face& face) {
  FaceNodes x;
  for (int a = 0; a < kFaceNodes; ++a) x[a] = nodes.row(face[a]);
  return x;
}

inline Vec3 place_at(const FacePoint& point, const FaceNodes& nodes) {
  Vec3 x = Vec3::Zero();
  for (int a = 0; a < kFaceNodes; ++a) x += point.shape[a] * nodes[a];
  return x;
}

/// Outward normal, as long as the area per dr ds.
inline Vec3 area_normal_at(const FacePoint& point, const FaceNodes& nodes) {
  Vec3 by_r = Vec3::Zero(), by_s = Vec3::Zero();
  for (int a = 0; a < kFaceNodes; ++a) {
    by_r += point.shape_r[a] * nodes[a];
    by_s += point.shape_s[a] * nodes[a];
  }
  return by_r.cross(by_s);
}

/// Six points, exact to degree 4, weights summing to the reference area 1/2 (Dunavant 1985,
/// doi:10.1002/nme.1620210612).
inline constexpr std::array<FacePoint, kFacePoints> kFaceRule{
    face_point(0.054975871827660934, 0.0915762135097707435, 0.0915762135097707435),
    face_point(0.054975871827660934, 0.816847572980458513, 0.0915762135097707435),
    face_point(0.054975871827660934, 0.0915762135097707435, 0.816847572980458513),
    face_point(0.111690794839005733, 0.445948490915964886, 0.445948490915964886),
    face_point(0.111690794839005733, 0.108103018168070228, 0.445948490915964886),
    face_point(0.111690794839005733, 0.445948490915964886, 0.108103018168070228)};

}  // namespace palpate::fem
