#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "libfem/mesh/read/read.hpp"
#include "libfem/mesh/repair/mend.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/units.hpp"
#include "tools/setup/check.hpp"
#include "tools/stages/body/plausibility.hpp"

namespace palpate::tools {
namespace {

// A thyroid has 5 cm, a muscle of the thigh 50.
constexpr double kSmallOrgan_m = 0.04, kLargeOrgan_m = 0.6;

// The power of ten, as a unit, that makes a length of a file an organ's.
std::string likely_power(double extent) {
  const double power_m = std::pow(10, std::round(std::log10(0.15 / extent)));
  for (const char* name : {"m", "dm", "cm", "mm", "um"})
    if (std::abs(*unit_factor(name, Dimension::length) / power_m - 1) < 1e-6) return name;
  return fmt::format("{:.3g} mm", 1e3 * power_m);
}

// Largest extent of each border of a surface, of those that hang together over their vertices.
double widest_border_m(const Surface& surface) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> sides;  // triangles of an edge
  for (const auto& t : surface.triangles.rowwise())
    for (int k = 0; k < 3; ++k) ++sides[std::minmax(t[k], t[(k + 1) % 3])];
  std::vector<std::int32_t> next;  // border edges as a surface of flat triangles, for its patches
  std::vector<char> is_border(surface.vertices.rows(), 0);
  Surface lines{surface.vertices, {}};
  for (const auto& [edge, triangles] : sides)
    if (triangles == 1) next.insert(next.end(), {edge.first, edge.second, edge.second});
  lines.triangles.resize(next.size() / 3, 3);
  for (std::size_t i = 0; i < next.size(); ++i) {
    lines.triangles(static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3)) = next[i];
    is_border[next[i]] = 1;
  }
  double widest_m = 0;
  for (const auto& border : patches_of(lines, is_border))
    widest_m =
        std::max(widest_m, extent_m(Points(surface.vertices(border, Eigen::all))).maxCoeff());
  return widest_m;
}

}  // namespace

std::optional<std::string> doubt_of_size(const Vec3& extent, double unit_m) {
  const double size_m = unit_m * extent.maxCoeff();
  if (size_m >= kSmallOrgan_m && size_m <= kLargeOrgan_m) return std::nullopt;
  const std::string unit = likely_power(extent.maxCoeff());
  const auto named = unit_factor(unit, Dimension::length);
  const double other_m = named ? *named : *parse_quantity(unit, Dimension::length);
  return fmt::format(
      "it measures {}, {} than most organs. If that is not so, give its unit: --unit \"{}\" makes "
      "it {}",
      size_in_words(unit_m * extent, 0), size_m < kSmallOrgan_m ? "smaller" : "larger", unit,
      size_in_words(other_m * extent, 0));
}

std::optional<std::string> doubt_of_lid(const Surface& in_file,
                                        const std::vector<std::string>& changes) {
  if (std::ranges::none_of(changes, [](const std::string& c) { return c.starts_with("filled "); }))
    return std::nullopt;
  MendOptions open;
  open.allow_open = true;
  Surface welded;
  try {
    welded = mend_surface(in_file, open, "").surface;
  } catch (const Error&) {
    return std::nullopt;  // a soup, whose borders are none
  }
  const double size_m = extent_m(in_file.vertices).maxCoeff(), lid_m = widest_border_m(welded);
  if (lid_m < 0.5 * size_m) return std::nullopt;
  return fmt::format(
      "[body]: the surface is open, and closed by a lid {:.3g} mm wide on a body of {:.3g} mm. "
      "Does "
      "the organ end there, or is a part of it missing? Where it is missing, close the surface in "
      "a "
      "mesh editor",
      1e3 * lid_m, 1e3 * size_m);
}

std::vector<std::string> doubts_of_body(const Scene& scene,
                                        const std::vector<std::string>& changes) {
  std::vector<std::string> doubts;
  if (!scene.body.surface) return doubts;
  const auto is_wrapped = [](const std::string& c) { return c.find("wrapped") != c.npos; };
  if (scene.body.wrap_m && std::ranges::none_of(changes, is_wrapped))
    doubts.push_back("[body]: wrap changes nothing, for the surface can be mended without");
  if (changes.empty()) return doubts;
  if (const auto lid =
          doubt_of_lid(read_surface(*scene.body.surface, scene.body.length_unit_m), changes))
    doubts.push_back(*lid);
  return doubts;
}

}  // namespace palpate::tools
