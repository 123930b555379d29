#include <fmt/core.h>

#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "libfem/mesh/fill/fill_volume.hpp"
#include "libfem/mesh/grade/smooth_surface.hpp"
#include "libfem/mesh/read/read.hpp"
#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/repair/mend.hpp"
#include "libfem/mesh/repair/wall.hpp"
#include "libfem/mesh/surface/surface.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfem/probes/probes.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/core/units.hpp"
#include "tools/console.hpp"
#include "tools/stages/body/prepare.hpp"

namespace palpate::tools {
namespace {

// Base volume edge over the cube root of the volume: 30 mm in a liver. Grading refines it around
// the probe; what is far only has to give way.
constexpr double kMeshSizeRatio = 0.28;
// What grading takes, 200,000 corners; a press on them would take 150 GB.
constexpr double kMaxTets = 1e6;

void mend(const Scene& scene, bool surface_only, Body& body, const std::string& file) {
  MendOptions options;
  options.allow_open = surface_only;
  options.wrap_alpha_m = scene.body.wrap_m;
  Mended mended;
  try {
    mended = mend_surface(body.surface, options, file);
  } catch (const Error& e) {
    if (options.wrap_alpha_m || !e.remedy().ends_with("wrap it.")) throw;
    throw Error(e.where(), e.fact(),
                e.remedy() + " wrap = \"2 mm\" in [body] fills gaps narrower than that.");
  }
  for (const std::string& change : mended.changes) {
    say("  mended: {}", change);
    body.mended.push_back(change);
  }
  if (options.wrap_alpha_m && !mended.is_wrapped)
    warn(
        "[body]: wrap = \"{:.3g} mm\" is not done: the surface could be mended without, which "
        "leaves it where it is. Leave wrap out.",
        to_millimetres(*options.wrap_alpha_m));
  body.surface = std::move(mended.surface);
}

void filter(double noise_m, Body& body) {
  FilteredSurface filtered = filter_noise(body.surface, noise_m);
  body.surface = std::move(filtered.surface);
  body.mended.push_back(
      fmt::format("filtered noise of {:.3g} mm: vertices moved by {:.3g} mm (rms along the "
                  "normal), {:.3g} mm at most",
                  1e3 * noise_m, 1e3 * filtered.moved_m, 1e3 * filtered.max_moved_m));
  say("  mended: {}", body.mended.back());
}

void doubt_roughness(const Surface& surface) {
  const double rough_m = roughness_m(surface), edge_m = mean_edge_m(surface);
  // A hand and three livers have 0.8 to 2.6 %, an elephant 5; at 18 % of noise a surface cannot be
  // coarsened.
  if (rough_m > 0.08 * edge_m)
    warn(
        "[body]: vertices stand {0:.2g} mm (rms) off their neighbours, {1:.0f} % of an edge. Where "
        "that is noise, noise = \"{0:.2g} mm\" in [body] takes it off.",
        1e3 * rough_m, 100 * rough_m / edge_m);
}

void hollow_out(const Scene& scene, Body& body) {
  const BodySection& section = scene.body;
  Walled walled;
  if (section.wall_m) {
    walled = with_wall(body.surface, *section.wall_m);
    if (walled.lumens == 0)
      throw Error(body_place(scene),
                  fmt::format("a wall of {:.3g} mm leaves no lumen: the body is nowhere thicker "
                              "than two walls",
                              to_millimetres(*section.wall_m)),
                  "Give a thinner wall, or leave it out for a solid body.");
  } else {
    Body lumen;
    lumen.surface = read_surface(*section.cavity, section.length_unit_m);
    turn_into_frame_of_body(*section.surface, *section.cavity, lumen.surface);
    mend(scene, false, lumen, section.cavity->string());
    walled = with_lumen(body.surface, std::move(lumen.surface), section.cavity->string());
  }
  body.surface = std::move(walled.surface);
  body.mended.push_back(fmt::format(
      "hollowed out: {} of {:.3g} ml, inside a wall of {:.3g} mm (median){}",
      counted(walled.lumens, "lumen", "lumens"), 1e6 * walled.lumen_m3,
      to_millimetres(walled.thickness_m),
      walled.solid_share < 0.005 ? ""
                                 : fmt::format("; under {} of the surface the body is solid",
                                               percent(walled.solid_share, 0))));
  say("  {}", body.mended.back());
}

}  // namespace

void read_meshes(const Scene& scene, bool surface_only, Body& body) {
  if (scene.body.tetmesh) {
    if (scene.body.noise_m)
      throw Error(body_place(scene), "noise is filtered from a surface, and the body is a tetmesh",
                  "Leave noise out, or give the surface.");
    TetReadNotes notes;
    body.volume = read_tet_mesh(*scene.body.tetmesh, scene.body.length_unit_m, &notes);
    if (!notes.duplicate_tets.empty())
      body.mended.push_back("dropped tetrahedra that the file has twice: " + notes.duplicate_tets);
    if (notes.flipped_tets)
      body.mended.push_back(fmt::format("turned {} tets inside out", notes.flipped_tets));
    if (notes.dropped_nodes)
      body.mended.push_back(fmt::format("dropped {} unused nodes", notes.dropped_nodes));
    for (const std::string& change : body.mended) say("  mended: {}", change);
    body.surface = compact(body.volume.nodes, fem::boundary_triangles(body.volume.tets));
  } else {
    body.surface = read_surface(*scene.body.surface, scene.body.length_unit_m);
    const std::string file = scene.body.surface->string();
    mend(scene, surface_only, body, file);
    if (scene.body.noise_m) {
      filter(*scene.body.noise_m, body);
      mend(scene, surface_only, body, file + ", filtered");
    } else {
      doubt_roughness(body.surface);
    }
    if ((scene.body.wall_m || scene.body.cavity) && !surface_only) hollow_out(scene, body);
  }
  if (scene.body.pressure_Pa > 0 && !surface_only && surface_facts(body.surface).cavities == 0)
    throw Error(body_place(scene), "pressure needs a lumen, and the body is solid",
                "Hollow it out with wall or cavity, or leave pressure out.");
}

namespace {

// The base's surface may be a quarter of the contact's radius, and of the distance to where the
// tool touches, off each vertex of the fine one. On a hand (ball of 3.1 mm, edges of 17 mm, webs)
// presses are then at most 1.6 % off those on edges of 6 mm (p95 1.0); 0.2 and 0.35 do the same,
// 0.5 has a p95 of 7.0, and without a limit it is 5.9. No limit where the contact is not known.
SimulationSurfaceOptions near_region(const Scene& scene, const Body& body) {
  std::vector<Eigen::Index> faces;
  for (Eigen::Index f = 0; f < body.surface.triangles.rows() && !body.in_region.empty(); ++f)
    if (body.in_region[body.surface.triangles(f, 0)] ||
        body.in_region[body.surface.triangles(f, 1)] ||
        body.in_region[body.surface.triangles(f, 2)])
      faces.push_back(f);
  if (faces.empty() || !scene.probe.rigid) return {};
  const Surface touched{body.surface.vertices, body.surface.triangles(faces, Eigen::all)};
  const double contact_m = scene.probe.rigid->contact_radius_m(scene.experiments.each.depth_m);
  SimulationSurfaceOptions out;
  out.from_region_m = distances_m(body.surface, touched);
  out.allowed_m = 0.25 * (contact_m + out.from_region_m.array());
  return out;
}

}  // namespace

double base_edge_m(const Scene& scene, double volume_m3) {
  return scene.body.mesh_size_m.value_or(kMeshSizeRatio * std::cbrt(volume_m3));
}

void fill_with_tets(const Scene& scene, Body& body) {
  const double volume = volume_m3(body.surface);
  const double edge = base_edge_m(scene, volume);
  const double expected = expected_tets(volume, area_m2(body.surface), edge);
  if (expected > kMaxTets)
    throw Error(body_place(scene),
                fmt::format("an edge of {:.3g} mm asks for some {:.2g} tets, more than {:.0g}",
                            to_millimetres(edge), expected, kMaxTets),
                fmt::format("Make mesh_size larger, or leave it out ({:.3g} mm): a press refines "
                            "the mesh where it is needed.",
                            to_millimetres(kMeshSizeRatio * std::cbrt(volume))));
  const SimulationSurface coarse = simulation_surface(body.surface, edge, near_region(scene, body));
  if (!coarse.refused.empty())
    say("  simulation surface: {}{}", coarse.refused,
        coarse.target_edge_m > 0 ? "" : "; the fine surface itself is taken");
  body.volume = fill_volume(coarse.surface, edge);
  const TetQuality quality = quality_of(body.volume);
  if (quality.slivers > 0)
    say("  TetGen left {} of {} tets", counted(quality.slivers, "sliver", "slivers"),
        body.volume.tets.rows());
  say("  volume: {} tets, {} nodes, edge about {:.3g} mm, smallest dihedral angle {:.0f} degrees; "
      "surface within {:.2g} mm, volume {:+.2f} %",
      body.volume.tets.rows(), body.volume.nodes.rows(), to_millimetres(edge),
      quality.min_dihedral_deg, to_millimetres(coarse.deviation_m),
      100 * (quality.volume_m3 / volume - 1));
  if (coarse.excess > 1.1)
    say("  simulation surface: up to {:.2g} times as far from the surface as is sought near the "
        "region",
        coarse.excess);
}

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
