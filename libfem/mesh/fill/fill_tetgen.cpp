#include "libfem/mesh/fill/fill_steps.hpp"

#define TETLIBRARY  // the interface that throws instead of leaving the process
#include <tetgen.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <new>
#include <stdexcept>

#include "libfem/mesh/tets.hpp"
#include "libfem/mesh/topology.hpp"

namespace palpate {
namespace {

/// TetGen's input. It owns plain arrays that tetgenio's destructor deletes, so all are new[]-ed.
void set_input(tetgenio& in, const Surface& closed, const Points& cavities) {
  in.firstnumber = 0;
  in.numberofpoints = static_cast<int>(closed.vertices.rows());
  in.pointlist = new REAL[closed.vertices.size()];
  std::copy_n(closed.vertices.data(), closed.vertices.size(), in.pointlist);

  in.numberoffacets = static_cast<int>(closed.triangles.rows());
  in.facetlist = new tetgenio::facet[in.numberoffacets];
  for (Eigen::Index f = 0; f < closed.triangles.rows(); ++f) {
    tetgenio::facet& facet = in.facetlist[f];
    tetgenio::init(&facet);
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    tetgenio::polygon& polygon = facet.polygonlist[0];
    tetgenio::init(&polygon);
    polygon.numberofvertices = 3;
    polygon.vertexlist = new int[3];
    for (int k = 0; k < 3; ++k) polygon.vertexlist[k] = closed.triangles(f, k);
  }
  if (cavities.rows() == 0) return;
  in.numberofholes = static_cast<int>(cavities.rows());
  in.holelist = new REAL[cavities.size()];
  std::copy_n(cavities.data(), cavities.size(), in.holelist);
}

/// p: fill a surface; Q: quiet; Y: leave the boundary alone; q: quality; a: volume; O9/7: optimise
/// with all means; S: how many points it may add.
std::array<char, 128> switches_of(const TetGenSettings& settings) {
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(), "pQYq%.3f/%.1fa%.15fO9/7S%d", settings.radius_edge_ratio,
                settings.min_dihedral_deg, settings.max_volume_m3, settings.max_added_points);
  return text;
}

/// Nodes and tets, each turned positive; nodes that no tet uses are left out.
TetMesh to_tet_mesh(const tetgenio& out) {
  TetMesh mesh;
  mesh.tets = Eigen::Map<const Tets>(out.tetrahedronlist, out.numberoftetrahedra, 4);
  const auto used = renumber({mesh.tets.data(), std::size_t(mesh.tets.size())}, out.numberofpoints,
                             Numbering::by_use);
  mesh.nodes = Eigen::Map<const Points>(out.pointlist, out.numberofpoints, 3)(used, Eigen::all);
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
    if (tet_volume_m3(corners_of(mesh, t)) < 0) std::swap(mesh.tets(t, 0), mesh.tets(t, 1));
  return mesh;
}

}  // namespace

TetMesh fill_with_tetgen(const Surface& closed, const Points& cavities,
                         const TetGenSettings& settings) {
  tetgenio in, out;
  set_input(in, closed, cavities);
  auto switches = switches_of(settings);
  try {
    tetrahedralize(switches.data(), &in, &out);
  } catch (const int code) {
    if (code == 1) throw std::bad_alloc();  // TetGen is out of memory
    throw;
  }
  if (out.numberofpoints - in.numberofpoints >= settings.max_added_points)
    throw std::runtime_error("wanted more than " + std::to_string(settings.max_added_points) +
                             " points inside");
  return to_tet_mesh(out);
}

std::string tetgen_failure(int code) {
  switch (code) {
    case 2:
      return "met an error of its own";
    case 3:
      return "found that the surface crosses itself";
    case 4:
      return "found a feature too small for its tolerance";
    case 5:
      return "found two facets too close to each other";
    case 10:
      return "refused the input";
    default:
      return "failed with code " + std::to_string(code);
  }
}

}  // namespace palpate
