#include "libfit/assets/asset_bytes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "libfit/core/error.hpp"
#include "libfit/core/linear_algebra.hpp"
#include "libfit/runtime/asset/format.hpp"

namespace palpate {
namespace {

constexpr double kMinFacing = 0.02;  // cosine of a corner's normal to its triangle's; engine: 0.01

std::string at(const char* what, Eigen::Index i) { return what + (' ' + std::to_string(i)); }

void check_counts(const Model& model) {
  check_sizes(model);
  if (std::none_of(model.is_covered.begin(), model.is_covered.end(), [](char c) { return c != 0; }))
    throw Error("model", "no vertex is covered by test points", "Refine onto the right body.");
}

void check_vertices(const Model& model) {
  const double extent = extent_m(model.surface.vertices).norm();
  if (!model.surface.vertices.allFinite() || !(extent > 0) || extent > 1e3)
    throw Error("model surface",
                "vertices are not finite, all in one place, or farther than 1 km apart",
                "Check the unit the surface was read with.");
  for (Eigen::Index v = 0; v < model.inward_normal.rows(); ++v) {
    if (!model.is_covered[v]) continue;
    const double length = model.inward_normal.row(v).norm();
    if (!(std::abs(length - 1) < 1e-6))
      throw Error("model " + at("vertex", v), "its inward normal is not a unit vector",
                  "Make the model again with `palpate refine`.");
  }
}

void check_triangles(const Model& model) {
  const auto& triangles = model.surface.triangles;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const auto corner = triangles.row(t);
    if (corner.minCoeff() < 0 || corner.maxCoeff() >= model.surface.vertices.rows())
      throw Error("model " + at("triangle", t), "it names a vertex that does not exist",
                  "Make the body again with `palpate prepare`.");
    if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0])
      throw Error("model " + at("triangle", t), "it names a vertex twice",
                  "Make the body again with `palpate prepare`.");
  }
}

void check_controls(const Model& model) {
  const auto parts = parts_of(model.curves.family);
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v) {
      if (!model.is_covered[v]) continue;
      if (runtime::is_good_part(parts[i], model.curves.control[i].row(v).data(),
                                size_of(parts[i], model.curves.basis[i]), false))
        continue;
      throw Error("model " + at("vertex", v),
                  std::string("its ") + parts[i].name +
                      (parts[i].rises ? " curve does not start at 0 and increase"
                                      : " does not start at 0 or is out of bounds"),
                  "Fit the curves again with `palpate fit`.");
    }
}

void round_vertices(const Model& model, bool has_mean, AssetSurface& out) {
  const Points& x = model.surface.vertices;
  out.diagonal_m = extent_m(x).norm();
  out.origin = (0.5 * (x.colwise().minCoeff() + x.colwise().maxCoeff())).transpose();
  const Points outward = vertex_normals(model.surface);
  for (Eigen::Index v = 0; v < x.rows(); ++v) {
    const bool is_covered = model.is_covered[v] != 0;
    const Vec3 inward = is_covered ? Vec3(model.inward_normal.row(v)) : Vec3(-outward.row(v));
    for (int k = 0; k < 3; ++k) {
      out.vertex.push_back(float(x(v, k) - out.origin[k]));
      out.normal.push_back(float(inward[k]));
    }
    out.covered.push_back(is_covered ? runtime::kMeasured : has_mean ? runtime::kMean : 0);
    out.report.mean_vertices += out.covered.back() == runtime::kMean;
  }
}

void fade_borders(AssetSurface& surface) {
  for (std::size_t edge = 0; edge < surface.neighbour.size(); ++edge) {
    if (surface.neighbour[edge] >= 0) continue;
    for (std::size_t corner : {edge, edge / 3 * 3 + (edge + 1) % 3}) {
      std::uint8_t& covered = surface.covered[surface.triangle[corner]];
      surface.report.faded_vertices += covered == runtime::kMeasured;
      surface.report.mean_vertices -= covered == runtime::kMean;
      covered = 0;
    }
  }
}

// The mean of every part over the covered vertices (M12e); zero for one with directions, which
// belong to their place, but for the sway, which is rigid.
std::vector<Eigen::RowVectorXd> mean_controls(const Model& model) {
  std::vector<Eigen::RowVectorXd> mean;
  for (const Controls& control : model.curves.control)
    mean.push_back(Eigen::RowVectorXd::Zero(control.cols()));
  double covered = 0;
  for (std::size_t v = 0; v < model.is_covered.size(); ++v) {
    if (!model.is_covered[v]) continue;
    ++covered;
    for (std::size_t part = 0; part < mean.size(); ++part)
      mean[part] += model.curves.control[part].row(v);
  }
  for (std::size_t i = 0; i < mean.size(); ++i) {
    const runtime::Part& part = parts_of(model.curves.family)[i];
    mean[i] *= part.width == 1 || part.known == runtime::Known::sway ? 1 / covered : 0;
  }
  return mean;
}

// Which vertices share a row of controls.
void make_records(AssetSurface& out) {
  std::int32_t shared[runtime::kMean + 1] = {-1, -1, -1};  // by what covers a vertex
  for (std::size_t v = 0; v < out.covered.size(); ++v) {
    std::int32_t& row = shared[out.covered[v]];
    if (row < 0 || out.covered[v] == runtime::kMeasured) {
      row = out.recorded.size();
      out.recorded.push_back(v);
    }
    out.record.push_back(row);
  }
}

void round_controls(const Model& model, AssetSurface& out) {
  const std::vector<Eigen::RowVectorXd> mean = mean_controls(model);
  for (std::int32_t v : out.recorded)
    for (std::size_t part = 0; part < mean.size(); ++part)
      for (Eigen::Index j = 0; j < mean[part].size(); ++j) {
        const std::uint8_t covered = out.covered[v];
        const double value = covered == runtime::kMeasured ? model.curves.control[part](v, j)
                             : covered == runtime::kMean   ? mean[part][j]
                                                           : 0;
        out.control.push_back(float(value));
      }
}

// Depth [m] up to which slides over a triangle of corners x with inward unit normals u are
// well-conditioned (METHOD 4), 0.8 / |du/dc| by a bound, most_m at most; 0 where it has no area or
// a normal does not face it.
double depth_bound_m(const Vec3 x[3], const Vec3 u[3], double most_m) {
  const Vec3 area = (x[1] - x[0]).cross(x[2] - x[0]);
  const double longest =
      std::max({(x[1] - x[0]).norm(), (x[2] - x[1]).norm(), (x[0] - x[2]).norm()});
  if (!(area.norm() > 1e-6 * longest * longest)) return 0;  // floats hold no better a plane
  Mat3 gradient = Mat3::Zero();
  const Vec3 mean = (u[0] + u[1] + u[2]).normalized();
  double least = 1;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(-u[k].dot(area) > kMinFacing * area.norm())) return 0;
    gradient += u[k] * area.cross(x[(k + 2) % 3] - x[(k + 1) % 3]).transpose() / area.squaredNorm();
    least = std::min(least, u[k].dot(mean));
  }
  if (!(least > kMinFacing)) return 0;
  const Mat3 square = gradient.transpose() * gradient;
  const double norm = std::sqrt(std::max(0.0, symmetric_eigen(square).values[2]));
  return std::min(most_m, 0.8 * least / std::max(norm, 1e-12));
}

void bound_depths(AssetSurface& surface) {
  for (std::size_t t = 0; 3 * t < surface.triangle.size(); ++t) {
    std::uint8_t answering = 0;
    Vec3 x[3], u[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t v = surface.triangle[3 * t + k];
      answering |= surface.covered[v];
      x[k] = vector_at(surface.vertex, v);
      u[k] = vector_at(surface.normal, v);
    }
    const double depth = answering != 0 ? depth_bound_m(x, u, surface.diagonal_m) : 0;
    surface.max_depth_m.push_back(float(depth));
    surface.report.folded_triangles += answering != 0 && !(depth > 0);
    if (depth > 0 && (answering & runtime::kMeasured) != 0) surface.measured_triangles.push_back(t);
  }
}

}  // namespace

std::vector<std::int32_t> triangle_neighbours(const Triangles& triangles) {
  const auto key = [](std::int32_t from, std::int32_t to) {
    return static_cast<std::uint64_t>(from) << 32 | static_cast<std::uint32_t>(to);
  };
  std::unordered_map<std::uint64_t, std::int32_t> half_edge;
  half_edge.reserve(triangles.size());
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t from = triangles(t, k), to = triangles(t, (k + 1) % 3);
      if (!half_edge.emplace(key(from, to), t).second)
        throw Error(
            "model edge " + std::to_string(from) + "-" + std::to_string(to),
            "two triangles run along it the same way: not manifold, or not all outward",
            "Make the body again with `palpate prepare`, which mends or names such places.");
    }
  std::vector<std::int32_t> neighbour;
  neighbour.reserve(triangles.size());
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto found = half_edge.find(key(triangles(t, (k + 1) % 3), triangles(t, k)));
      neighbour.push_back(found == half_edge.end() ? -1 : found->second);
    }
  return neighbour;
}

AssetSurface make_asset_surface(const Model& model, const ExportOptions& options) {
  check_counts(model);
  check_vertices(model);
  check_triangles(model);
  check_controls(model);
  AssetSurface surface;
  round_vertices(model, options.has_mean_elsewhere, surface);
  const auto& triangles = model.surface.triangles;
  surface.triangle.assign(triangles.data(), triangles.data() + triangles.size());
  surface.neighbour = triangle_neighbours(triangles);
  if (options.fades_borders) fade_borders(surface);
  make_records(surface);
  round_controls(model, surface);
  bound_depths(surface);
  if (surface.measured_triangles.empty())
    throw Error("model",
                "no measured triangle can be touched: all are uncovered, without area or folded",
                "Check the coverage and the normals of the model.");
  return surface;
}

}  // namespace palpate
