#include "libfem/solve/experiments/loaded_shape.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <utility>

#include "libfem/mesh/grade/grade_mesh.hpp"
#include "libfem/solve/experiments/surface_places.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"

namespace palpate::fem {
namespace {

constexpr double kTolerance = 1e-6;  // of the body's extent
constexpr double kCoarse = 1e6;      // m; a size that refines nothing

// The base mesh with quadratic nodes on the smooth surface, about `origin`.
QuadraticMesh quadratic_base(const SimulationSetup& setup, const Vec3& origin) {
  TetMesh base = setup.volume;
  base.nodes.rowwise() -= origin.transpose();
  Surface surface = setup.surface;
  surface.vertices.rowwise() -= origin.transpose();
  GradeOptions options;
  options.path = {{Vec3::Zero(), Vec3::Zero(), kCoarse}};
  if (setup.held_at && !setup.regions_at_rest)
    options.held_at = [&](const Vec3& x, bool is_on_boundary) {
      return setup.held_at(x + origin, is_on_boundary);
    };
  return grade_mesh(base, setup.is_held, SmoothSurface(surface), options);
}

std::vector<Material> materials_of(const SimulationSetup& setup) {
  std::vector<Material> out;
  for (const MaterialParameters& material : setup.materials)
    out.push_back(make_material(material, "[material]"));
  return out;
}

// Regions about `origin`.
WeightedBody weighted(const SimulationSetup& setup, const std::vector<Material>& materials,
                      const Vec3& origin) {
  WeightedBody body{materials, {}, {}, setup.weight, setup.regions_at_rest};
  if (setup.region_at)
    body.region_at = [&setup, origin](const Vec3& x) { return setup.region_at(x + origin); };
  if (setup.bed_at)
    body.bed_at = [&setup, origin](const Vec3& x) { return setup.bed_at(x + origin); };
  return body;
}

[[noreturn]] void fail(const LoadedSearch& search, const char* what) {
  throw Error("[gravity]",
              std::string("no ") + what + " was found beyond " + number(100 * search.share, 3) +
                  " % of the body's weight",
              "The body is too soft to carry itself as it is held: hold more of it, lay it on a "
              "[[bed]], or check young, density and acceleration.");
}

LoadedShape shape_of(const QuadraticMesh& mesh, const TetMesh& base, double residual_m) {
  const Eigen::Index corners = base.nodes.rows();
  LoadedShape out({mesh.loaded.topRows(corners), base.tets, base.region},
                  mesh.loaded.topRows(corners) - mesh.nodes.topRows(corners));
  out.residual_m = residual_m;
  return out;
}

}  // namespace

LoadedShape::LoadedShape(TetMesh loaded, Points sag)
    : loaded_(std::move(loaded)), sag_(std::move(sag)), boxes_(tet_boxes(loaded_)) {}

Vec3 LoadedShape::sag_at(const Vec3& place) const {
  const auto at = closest_in_volume(loaded_, boxes_, place, std::numeric_limits<double>::infinity(),
                                    [](const VolumePoint&) { return true; });
  Vec3 sag = Vec3::Zero();
  for (int k = 0; k < 4; ++k) sag += at->weight[k] * sag_.row(loaded_.tets(at->tet, k)).transpose();
  return sag;
}

Points LoadedShape::sag_of(const QuadraticMesh& mesh, const Vec3& origin) const {
  Points out = Points::Zero(mesh.nodes.rows(), 3);
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    const auto corner = loaded_.tets.row(mesh.base[static_cast<std::size_t>(t)]);
    const Vec3 a = loaded_.nodes.row(corner[0]);
    Mat3 edges, sags;
    for (int k = 0; k < 3; ++k) {
      edges.col(k) = loaded_.nodes.row(corner[k + 1]).transpose() - a;
      sags.col(k) = (sag_.row(corner[k + 1]) - sag_.row(corner[0])).transpose();
    }
    const Mat3 gradient = sags * edges.inverse();
    for (const std::int32_t n : mesh.tets.row(t))
      out.row(n) = sag_.row(corner[0]) +
                   (gradient * (mesh.nodes.row(n).transpose() + origin - a)).transpose();
  }
  for (Eigen::Index n = 0; n < out.rows(); ++n)
    if (mesh.is_held[static_cast<std::size_t>(n)]) out.row(n).setZero();
  return out;
}

LoadedShape unbend_base(const SimulationSetup& setup, const Vec3& origin) {
  const std::vector<Material> materials = materials_of(setup);
  QuadraticMesh mesh = quadratic_base(setup, origin);
  const LoadedSearch search =
      unbend(weighted(setup, materials, origin),
             kTolerance * extent_m(setup.volume.nodes).maxCoeff(), {}, mesh);
  if (!search.is_found()) fail(search, "shape at rest");
  return shape_of(mesh, setup.volume, search.residual_m);
}

LoadedShape bend_base(const SimulationSetup& setup) {
  const std::vector<Material> materials = materials_of(setup);
  QuadraticMesh mesh = quadratic_base(setup, Vec3::Zero());
  const SurfacePlaces places(mesh, setup.surface.vertices, vertex_normals(setup.surface));
  const LoadedSearch search = bend_under_weight(weighted(setup, materials, Vec3::Zero()), mesh);
  if (!search.is_found()) fail(search, "equilibrium");
  LoadedShape out = shape_of(mesh, setup.volume, 0);
  out.surface = places.displacement(mesh.displacement(),
                                    std::ldexp(extent_m(setup.surface.vertices).maxCoeff(), -30));
  return out;
}

}  // namespace palpate::fem
