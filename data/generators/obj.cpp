#include <fmt/core.h>

#include <cmath>
#include <iterator>

#include "data/generators/bodies.hpp"

namespace palpate::bodies {

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
