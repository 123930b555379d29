#include <fmt/core.h>

#include <cmath>
#include <iterator>

#include "data/generators/bodies.hpp"

namespace palpate::bodies {

Surface surface_of(const std::vector<Vec3>& vertices,
                   const std::vector<std::array<std::int32_t, 3>>& triangles) {
  Surface out;
  out.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v)
    out.vertices.row(static_cast<Eigen::Index>(v)) = vertices[v];
  out.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    out.triangles.row(static_cast<Eigen::Index>(t)) << triangles[t][0], triangles[t][1],
        triangles[t][2];
  return out;
}

Surface rounded(Surface body_mm) {
  // + 0.0 turns -0 into 0, which the text must not distinguish.
  body_mm.vertices =
      body_mm.vertices.unaryExpr([](double x_mm) { return std::round(x_mm * 1e4) / 1e4 + 0.0; });
  return body_mm;
}

std::string obj_text(const std::string& comment, const Surface& body_mm) {
  std::string text = fmt::format("# {}\n", comment);
  for (const auto& row : body_mm.vertices.rowwise())
    fmt::format_to(std::back_inserter(text), "v {:.4f} {:.4f} {:.4f}\n", row[0], row[1], row[2]);
  for (const auto& row : body_mm.triangles.rowwise())
    fmt::format_to(std::back_inserter(text), "f {} {} {}\n", row[0] + 1, row[1] + 1, row[2] + 1);
  return text;
}

}  // namespace palpate::bodies
