#pragma once

#include <array>

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
