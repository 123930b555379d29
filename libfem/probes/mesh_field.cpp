#include "libfem/probes/mesh_field.hpp"

#include <Eigen/Geometry>
#include <limits>

#include "libfem/mesh/repair/facts.hpp"
#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

constexpr int kPadding = 5;  // grid nodes around the mesh's box

/// Values and derivatives of the four cubic B-splines that reach a place t in [0, 1) of its cell.
struct CubicWeights {
  double value[4], first[4], second[4];

  CubicWeights(double t, double spacing) {
    const double s = 1 - t;
    value[0] = s * s * s / 6;
    value[1] = (3 * t * t * t - 6 * t * t + 4) / 6;
    value[2] = (3 * s * s * s - 6 * s * s + 4) / 6;
    value[3] = t * t * t / 6;
    const double by = 1 / spacing, by_square = by * by;
    first[0] = -s * s / 2 * by;
    first[1] = (3 * t * t - 4 * t) / 2 * by;
    first[2] = -(3 * s * s - 4 * s) / 2 * by;
    first[3] = t * t / 2 * by;
    second[0] = s * by_square;
    second[1] = (3 * t - 2) * by_square;
    second[2] = (3 * s - 2) * by_square;
    second[3] = t * by_square;
  }
};

/// Refuses a mesh that has no inside.
void check_probe_mesh(const Surface& surface, const std::string& where) {
  const bool is_any = surface.triangles.rows() > 0;
  const double extent = is_any ? extent_m(surface.vertices).maxCoeff() : 0;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto [a, b, c] = corners_of(surface, f);
    if (!((b - a).cross(c - a).norm() > 1e-14 * extent * extent))
      throw Error(
          where, "triangle " + std::to_string(f + 1) + " of the probe's mesh has no area",
          "Remove triangles without area, for example with a mesh editor's \"merge vertices\".");
  }
  if (const auto why = why_not_closed(surface))
    throw Error(where, "the probe's mesh has no inside: " + *why,
                "Close it, unite its parts and turn its triangles outward in a mesh editor.");
}

}  // namespace

MeshField::MeshField(Surface surface, double smoothing_m, const std::string& where)
    : surface_(std::move(surface)) {
  check_probe_mesh(surface_, where);
  extent_ = palpate::extent_m(surface_.vertices).maxCoeff();
  spacing_ = std::isnan(smoothing_m) ? (1.0 / 64) * extent_ : smoothing_m;
  if (!(spacing_ >= (1.0 / 160) * extent_ && spacing_ <= (1.0 / 8) * extent_))  // of the extent
    throw Error(
        where,
        "smoothing of " + std::to_string(1e3 * spacing_) + " mm does not fit a mesh of " +
            std::to_string(1e3 * extent_) + " mm",
        "Give smoothing from 1/160 to 1/8 of the mesh's largest extent, or leave it out for 1/64.");
  boxes_ = triangle_boxes(surface_);
  average_normals();
  sample();
}

void MeshField::average_normals() {
  const Eigen::Index faces = surface_.triangles.rows();
  face_normal_.resize(faces, 3);
  for (std::int32_t f = 0; f < faces; ++f)
    face_normal_.row(f) =
        (corner(f, 1) - corner(f, 0)).cross(corner(f, 2) - corner(f, 0)).normalized();
  vertex_normal_ = vertex_normals(surface_);
  edge_normal_.resize(3 * faces, 3);
  for_each_edge(sorted_sides(surface_.triangles), [&](auto begin, auto end) {
    const Vec3 sum = face_normal_.row(begin->face) + face_normal_.row((begin + 1)->face);
    for (auto side = begin; side < end; ++side)
      edge_normal_.row(3 * side->face + side->corner) = sum;
  });
}

SignedDistance MeshField::nearest(const Vec3& x, double within_m) const {
  const SurfacePoint hit = closest_point(surface_, boxes_, x, within_m).value_or(SurfacePoint{});
  SignedDistance out;
  out.distance_m = hit.distance_m;
  if (hit.triangle < 0) return out;  // not a number
  const std::int32_t triangle = hit.triangle;
  const Vec3& weights = hit.weight;
  int zeros = 0, zero = 0, nonzero = 0;
  for (int k = 0; k < 3; ++k)
    if (weights[k] == 0) {
      ++zeros;
      zero = k;
    } else
      nonzero = k;
  const Vec3 normal = zeros == 0 ? Vec3(face_normal_.row(triangle))
                      : zeros == 1
                          ? Vec3(edge_normal_.row(3 * triangle + (zero + 1) % 3))
                          : Vec3(vertex_normal_.row(surface_.triangles(triangle, nonzero)));
  const Vec3 away = x - hit.position;
  const double size = hit.distance_m;
  out.distance_m = away.dot(normal) < 0 ? -size : size;
  out.gradient = size > 1e-12 * extent_ ? Vec3(away / out.distance_m) : Vec3(normal.normalized());
  if (zeros == 0 || !(size > 1e-12 * extent_)) return out;
  out.hessian = Mat3::Identity() - out.gradient * out.gradient.transpose();
  if (zeros == 1) {
    const Vec3 edge =
        (corner(triangle, (zero + 2) % 3) - corner(triangle, (zero + 1) % 3)).normalized();
    out.hessian -= edge * edge.transpose();
  }
  out.hessian /= out.distance_m;
  return out;
}

void MeshField::sample() {
  const Vec3 low = surface_.vertices.colwise().minCoeff(),
             high = surface_.vertices.colwise().maxCoeff();
  for (int i = 0; i < 3; ++i) {
    const double cells = std::ceil((high[i] - low[i]) / spacing_);
    count_[i] = static_cast<int>(cells) + 1 + 2 * kPadding;
    origin_[i] = (low[i] + high[i] - cells * spacing_) / 2 - kPadding * spacing_;
  }
  std::vector<double> value(static_cast<std::size_t>(count_[0]) * count_[1] * count_[2]);
  for (int k = 0; k < count_[2]; ++k)
    for (int j = 0; j < count_[1]; ++j) {
      double within = std::numeric_limits<double>::infinity();
      for (int i = 0; i < count_[0]; ++i) {
        const double distance = nearest(origin_ + spacing_ * Vec3(i, j, k), within).distance_m;
        value[place(i, j, k)] = distance;
        within = 1.001 * (std::abs(distance) + spacing_);  // the next node is a spacing away
      }
    }
  // Along each axis in turn, c_i = (-f_{i-1} + 8 f_i - f_{i+1}) / 6.
  const std::array<std::size_t, 3> stride{1, static_cast<std::size_t>(count_[0]),
                                          static_cast<std::size_t>(count_[0]) * count_[1]};
  coefficient_ = value;
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t n = 0; n < value.size(); ++n) {
      const int at = static_cast<int>(n / stride[axis]) % count_[axis];
      if (at == 0 || at + 1 == count_[axis]) continue;
      coefficient_[n] = (8 * value[n] - value[n - stride[axis]] - value[n + stride[axis]]) / 6;
    }
    value = coefficient_;
  }
}

SignedDistance MeshField::smooth(const Vec3& x) const {
  const Vec3 cell = (x - origin_) / spacing_;
  int first[3];
  for (int i = 0; i < 3; ++i) {
    // The outermost coefficients are not sharpened: they are kept out of what is evaluated.
    if (!(cell[i] >= 2 && cell[i] < count_[i] - 3)) return exact(x);
    first[i] = static_cast<int>(cell[i]) - 1;
  }
  const CubicWeights wx(cell[0] - first[0] - 1, spacing_), wy(cell[1] - first[1] - 1, spacing_),
      wz(cell[2] - first[2] - 1, spacing_);
  SignedDistance out;
  for (int k = 0; k < 4; ++k) {
    double f = 0, fx = 0, fy = 0, fxx = 0, fxy = 0, fyy = 0;
    for (int j = 0; j < 4; ++j) {
      const double* row = &coefficient_[place(first[0], first[1] + j, first[2] + k)];
      double g = 0, gx = 0, gxx = 0;
      for (int i = 0; i < 4; ++i) {
        g += wx.value[i] * row[i];
        gx += wx.first[i] * row[i];
        gxx += wx.second[i] * row[i];
      }
      f += wy.value[j] * g;
      fx += wy.value[j] * gx;
      fxx += wy.value[j] * gxx;
      fy += wy.first[j] * g;
      fxy += wy.first[j] * gx;
      fyy += wy.second[j] * g;
    }
    out.distance_m += wz.value[k] * f;
    out.gradient += Vec3(wz.value[k] * fx, wz.value[k] * fy, wz.first[k] * f);
    out.hessian(0, 0) += wz.value[k] * fxx;
    out.hessian(0, 1) += wz.value[k] * fxy;
    out.hessian(1, 1) += wz.value[k] * fyy;
    out.hessian(0, 2) += wz.first[k] * fx;
    out.hessian(1, 2) += wz.first[k] * fy;
    out.hessian(2, 2) += wz.second[k] * f;
  }
  out.hessian(1, 0) = out.hessian(0, 1);
  out.hessian(2, 0) = out.hessian(0, 2);
  out.hessian(2, 1) = out.hessian(1, 2);
  return out;
}

MeshField::CrossSection MeshField::section(const Vec3& tip, const Vec3& inward,
                                           double depth_m) const {
  CrossSection out;
  std::vector<Vec3> border;
  for (std::int32_t f = 0; f < surface_.triangles.rows(); ++f) {
    double behind[3];
    for (int k = 0; k < 3; ++k) behind[k] = (tip - corner(f, k)).dot(inward) - depth_m;
    Vec3 end[2];  // where the triangle's border goes from below the plane to above, and back
    int found = 0;
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      if ((behind[k] < 0) == (behind[next] < 0)) continue;
      const double share = behind[k] / (behind[k] - behind[next]);
      end[behind[k] < 0 ? 0 : 1] = corner(f, k) + share * (corner(f, next) - corner(f, k)) - tip;
      ++found;
    }
    if (found != 2) continue;
    out.area_m2 += inward.dot(end[0].cross(end[1])) / 2;
    for (const Vec3& point : end) border.push_back(point - point.dot(inward) * inward);
  }
  out.area_m2 = std::abs(out.area_m2);
  if (border.empty()) return out;
  const Vec3 farthest = *std::max_element(
      border.begin(), border.end(),
      [](const Vec3& a, const Vec3& b) { return a.squaredNorm() < b.squaredNorm(); });
  const Vec3 along = farthest.normalized();
  double low = 0, high = 0;
  for (const Vec3& point : border) {
    low = std::min(low, point.dot(along));
    high = std::max(high, point.dot(along));
    out.width_m = std::max(out.width_m, (point - point.dot(along) * along).norm());
  }
  // A section four times as long as half its width has a line.
  if (high - low > 4 * out.width_m) {
    out.from = std::min(0.0, low + out.width_m) * along;
    out.to = std::max(0.0, high - out.width_m) * along;
  }
  for (const Vec3& point : border)  // of a section that is no stadium
    out.width_m = std::max(
        out.width_m,
        (point - out.from - nearest_on_segment(point, out.from, out.to) * (out.to - out.from))
            .norm());
  return out;
}

}  // namespace palpate::fem
