#include <fmt/core.h>

#include <array>
#include <map>

#include "libfem/mesh/grade/smooth_surface.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/units.hpp"
#include "tools/stages/body/prepare.hpp"

namespace palpate::tools {

TestPoints place_points(const PointTable& points, const Surface& surface,
                        const std::string& where) {
  const fem::SmoothSurface smooth(surface);
  const double farthest_m = 0.05 * extent_m(surface.vertices).norm();
  TestPoints placed;
  placed.position.resize(points.position.rows(), 3);
  placed.normal.resize(points.position.rows(), 3);
  for (Eigen::Index i = 0; i < points.position.rows(); ++i) {
    const Vec3 given = points.position.row(i);
    const fem::SurfaceHit hit = smooth.closest(given);
    if (!(hit.distance_m <= farthest_m)) {
      const auto unit = misread_unit(Points(given.transpose()), surface);
      throw Error(
          fmt::format("{}: point {}", where, i + 1),
          fmt::format("({}, {}, {}) m lies {:.3g} m off the surface", given[0], given[1], given[2],
                      hit.distance_m),
          fmt::format(
              "{}Give points within {:.3g} m of it, in metres and in the frame of the scaled mesh.",
              unit ? fmt::format("In {} it would lie at the body. ", *unit) : "", farthest_m));
    }
    placed.position.row(i) = hit.on_facet;
    placed.normal.row(i) = points.normal.rows() ? Vec3(points.normal.row(i)) : Vec3(-hit.normal);
    // At a corner of a block, faces stand 55 degrees off its diagonal.
    if (placed.normal.row(i).dot(-hit.normal) < -0.5)
      throw Error(fmt::format("{}: point {}", where, i + 1),
                  fmt::format("its normal ({:.3g}, {:.3g}, {:.3g}) points out of the body, so a "
                              "press along it touches nothing",
                              points.normal(i, 0), points.normal(i, 1), points.normal(i, 2)),
                  "Normals point into the body: reverse their signs, or leave the columns out.");
    placed.name.push_back(fmt::format("p{:04}", i + 1));
  }
  return placed;
}

void refuse_same_place(const Points& position, const std::string& where) {
  std::map<std::array<double, 3>, Eigen::Index> seen;
  for (Eigen::Index i = 0; i < position.rows(); ++i) {
    const auto [other, is_new] =
        seen.try_emplace({position(i, 0), position(i, 1), position(i, 2)}, i);
    if (!is_new)
      throw Error(fmt::format("{}: point {}", where, i + 1),
                  fmt::format("is at the place of point {}", other->second + 1),
                  "Leave one of them out.");
  }
}

PlacedPaths place_paths(const std::vector<PathInTable>& paths, const Surface& surface,
                        const std::string& where) {
  const double size_m = extent_m(surface.vertices).norm();
  PointTable table;
  table.position.resize(paths.size(), 3);
  PlacedPaths placed;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    table.position.row(i) = paths[i].point;
    placed.paths.push_back({static_cast<int>(i), paths[i].deflection});
    const double most_m = paths[i].deflection.rowwise().norm().maxCoeff();
    if (most_m > size_m)
      throw Error(fmt::format("{}: path {}", where, paths[i].name),
                  fmt::format("goes {:.3g} m from its point, and the body measures {:.3g} m",
                              most_m, size_m),
                  "Give dx_m,dy_m,dz_m in metres, from the point on.");
  }
  placed.points = place_points(table, surface, where);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const Vec3 inward = placed.points.normal.row(i).array() + 0.0;
    if (!((paths[i].deflection * inward).maxCoeff() > 0))
      throw Error(fmt::format("{}: path {}", where, paths[i].name), "never goes into the body",
                  fmt::format("Inward is ({:.2g}, {:.2g}, {:.2g}) there.", inward[0], inward[1],
                              inward[2]));
    placed.points.name[i] = paths[i].name;
  }
  return placed;
}

}  // namespace palpate::tools
