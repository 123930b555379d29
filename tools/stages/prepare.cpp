#include "tools/stages/prepare.hpp"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "libfem/mesh/boundary.hpp"
#include "libfem/mesh/fill/fill_volume.hpp"
#include "libfem/mesh/read/read.hpp"
#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/repair/mend.hpp"
#include "libfem/mesh/surface/filter_noise.hpp"
#include "libfem/mesh/surface/simulation_surface.hpp"
#include "libfem/probes/probes.hpp"
#include "libfem/solve/experiments/loaded_shape.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/units.hpp"
#include "libfit/io/csv/tables.hpp"
#include "tools/console.hpp"
#include "tools/scene/settings.hpp"
#include "tools/stages/pairs.hpp"
#include "tools/stages/plausibility.hpp"
#include "tools/stages/reach.hpp"
#include "tools/stages/simulate.hpp"
#include "tools/stages/tilt.hpp"

namespace palpate::tools {
namespace {

// Base volume edge over the cube root of the volume: 30 mm in a liver. Grading refines it around
// the probe and bends its boundary back onto the fine surface, which is why chords may lose this
// much volume; what is far only has to give way.
constexpr double kMeshSizeRatio = 0.28;
constexpr double kChordVolumeLoss = 0.08;

// Over the mean edge. A hand and three livers have 0.8 to 2.6 %, an elephant 5; at 18 % of
// noise a surface cannot be coarsened.
constexpr double kRough = 0.08;

// The boundary of a volume mesh with the vertices it uses.
Surface boundary_surface(const TetMesh& volume) {
  const Triangles faces = fem::boundary_triangles(volume.tets);
  std::vector<std::int32_t> number(static_cast<std::size_t>(volume.nodes.rows()), -1);
  Surface surface;
  surface.triangles.resize(faces.rows(), 3);
  std::vector<std::int32_t> used;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      auto& index = number[static_cast<std::size_t>(faces(f, k))];
      if (index < 0) {
        index = static_cast<std::int32_t>(used.size());
        used.push_back(faces(f, k));
      }
      surface.triangles(f, k) = index;
    }
  surface.vertices.resize(static_cast<Eigen::Index>(used.size()), 3);
  for (std::size_t v = 0; v < used.size(); ++v)
    surface.vertices.row(static_cast<Eigen::Index>(v)) = volume.nodes.row(used[v]);
  return surface;
}

std::string body_place(const Scene& scene) { return scene.path.string() + ": [body]"; }

void mend(const Scene& scene, bool surface_only, Body& body, const std::string& file) {
  MendOptions options;
  options.allow_open = surface_only;
  options.wrap = scene.body.wrap_m.has_value();
  options.wrap_alpha_m = scene.body.wrap_m.value_or(0);
  Mended mended;
  try {
    mended = mend_surface(body.surface, options, file);
  } catch (const Error& e) {
    if (options.wrap || !e.remedy().ends_with("wrap it.")) throw;
    throw Error(e.where(), e.fact(),
                e.remedy() + " wrap = \"2 mm\" in [body] fills gaps narrower than that.");
  }
  for (const std::string& change : mended.changes) {
    say("  mended: {}", change);
    body.mended.push_back(change);
  }
  body.surface = std::move(mended.surface);
}

void filter(double noise_m, Body& body) {
  FilteredSurface filtered = filter_noise(body.surface, noise_m);
  body.surface = std::move(filtered.surface);
  body.mended.push_back(fmt::format(
      "filtered noise of {:.3g} mm: vertices moved by {:.3g} mm (rms along the normal), "
      "{:.3g} mm at most",
      1e3 * noise_m, 1e3 * filtered.moved_m, 1e3 * filtered.max_moved_m));
  say("  mended: {}", body.mended.back());
}

void doubt_roughness(const Surface& surface) {
  const double rough_m = roughness_m(surface), edge_m = mean_edge_m(surface);
  if (rough_m > kRough * edge_m)
    warn(
        "[body]: vertices stand {0:.2g} mm (rms) off their neighbours, {1:.0f} % of an edge. Where "
        "that is noise, noise = \"{0:.2g} mm\" in [body] takes it off.",
        1e3 * rough_m, 100 * rough_m / edge_m);
}

void read_meshes(const Scene& scene, bool surface_only, Body& body) {
  if (scene.body.tetmesh) {
    if (scene.body.noise_m)
      throw Error(body_place(scene), "noise is filtered from a surface, and the body is a tetmesh",
                  "Leave noise out, or give the surface.");
    TetReadNotes notes;
    body.volume = read_tet_mesh(*scene.body.tetmesh, scene.body.length_unit_m, &notes);
    if (notes.flipped_tets)
      body.mended.push_back(fmt::format("turned {} tets inside out", notes.flipped_tets));
    if (notes.dropped_nodes)
      body.mended.push_back(fmt::format("dropped {} unused nodes", notes.dropped_nodes));
    for (const std::string& change : body.mended) say("  mended: {}", change);
    body.surface = boundary_surface(body.volume);
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
  }
}

void fill(const Scene& scene, Body& body) {
  const double volume = volume_m3(body.surface);
  const double edge = scene.body.mesh_size_m.value_or(kMeshSizeRatio * std::cbrt(volume));
  const SimulationSurface coarse =
      simulation_surface(body.surface, edge, {.volume_tolerance = kChordVolumeLoss});
  if (!coarse.refused.empty()) say("  simulation surface: {}", coarse.refused);
  FillOptions options;
  options.target_edge_m = edge;
  FillReport report;
  body.volume = fill_volume(coarse.surface, options, &report);
  for (const std::string& note : report.notes) say("  {}", note);
  say("  volume: {} tets, {} nodes, edge about {:.3g} mm, smallest dihedral angle {:.0f} degrees "
      "({}); surface within {:.2g} mm, volume {:+.2f} %",
      body.volume.tets.rows(), body.volume.nodes.rows(), to_millimetres(edge),
      report.min_dihedral_deg, kMeshers[static_cast<std::size_t>(report.mesher)].name,
      to_millimetres(coarse.deviation_m),
      100 * (report.volume_ratio * volume_m3(coarse.surface) / volume - 1));
}

// Whether what a body rests on keeps it from moving as a rigid one: its stiffness against the six
// rigid motions, rotations about the middle, over half the body's size.
bool holds_rigidly(const fem::SimulationSetup& setup, const TetMesh& volume) {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  constexpr double kLeast = 1e-6;  // of the stiffest motion
  const Points& nodes = volume.nodes;
  const Vec3 middle = nodes.colwise().mean();
  const double half_m = extent_m(nodes).norm() / 2;
  Matrix6 stiffness = Matrix6::Zero();
  const Triangles boundary = fem::boundary_triangles(volume.tets);
  for (const auto& face : boundary.rowwise()) {
    const Vec3 a = nodes.row(face[0]), b = nodes.row(face[1]), c = nodes.row(face[2]);
    const Vec3 centre = (a + b + c) / 3, area = (b - a).cross(c - a) / 2,
               x = (centre - middle) / half_m;
    const fem::BedStiffness bed = setup.bed_at(centre);
    const Vec3 n = area.normalized();
    Eigen::Matrix<double, 3, 6> motion;
    motion.leftCols<3>().setIdentity();
    motion.rightCols<3>() << 0, x.z(), -x.y(), -x.z(), 0, x.x(), x.y(), -x.x(), 0;
    stiffness += area.norm() * motion.transpose() *
                 ((bed.along_N_m3 - bed.across_N_m3) * n * n.transpose() +
                  bed.across_N_m3 * Mat3::Identity()) *
                 motion;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(stiffness);
  return eigen.eigenvalues()[0] > kLeast * eigen.eigenvalues()[5];
}

// Nodes inside the scene's fixed regions; refuses bodies that could move rigidly or not at all.
void hold(const Scene& scene, Body& body) {
  const bool rests = !scene.beds.empty() || !scene.body.symmetric.empty();
  if (scene.body.fixed.empty() && !rests)
    throw Error(body_place(scene), "nothing is fixed, so the body could move as a rigid one",
                "Add fixed = [ { below = { axis = \"z\", at = \"2 mm\" } } ] or another region.");
  const Points& nodes = body.volume.nodes;
  std::vector<char> is_on_boundary(static_cast<std::size_t>(nodes.rows()), 0);
  const Triangles boundary = fem::boundary_triangles(body.volume.tets);
  for (const std::int32_t n : boundary.reshaped()) is_on_boundary[static_cast<std::size_t>(n)] = 1;
  body.is_held.assign(static_cast<std::size_t>(nodes.rows()), 0);
  for (Eigen::Index n = 0; n < nodes.rows(); ++n)
    body.is_held[static_cast<std::size_t>(n)] = any_contains(
        scene.body.fixed, nodes.row(n), is_on_boundary[static_cast<std::size_t>(n)] != 0);
  const auto held = std::count(body.is_held.begin(), body.is_held.end(), 1);
  const Vec3 low = nodes.colwise().minCoeff(), high = nodes.colwise().maxCoeff();
  const std::string extent = fmt::format(
      "The body spans x {:.1f} to {:.1f}, y {:.1f} to {:.1f}, z {:.1f} to {:.1f} mm.", 1e3 * low[0],
      1e3 * high[0], 1e3 * low[1], 1e3 * high[1], 1e3 * low[2], 1e3 * high[2]);
  if (held < 3 && rests) {
    if (!holds_rigidly(make_setup(scene, body), body.volume))
      throw Error(scene.path.string() + ": [[bed]]",
                  "the body could still move as a rigid one on what it rests on",
                  "Hold a part of it with fixed, give a bed that does not slide, or beds on sides "
                  "that face other ways. " +
                      extent);
  } else if (held < 3)
    throw Error(
        body_place(scene),
        fmt::format("fixed holds {} of {} nodes, so the body could move as a rigid one", held,
                    nodes.rows()),
        "Make the fixed regions larger, or a smaller mesh_size so that nodes fall into them. " +
            extent);
  if (held == nodes.rows())
    throw Error(body_place(scene), "fixed holds the whole body",
                "Make the fixed regions smaller. " + extent);
  say("  held: {} of {} nodes", held, nodes.rows());
}

void choose_points(const Scene& scene, bool surface_only, Body& body) {
  const ExperimentsSection& experiments = scene.experiments;
  const auto reachable = std::count(body.is_reachable.begin(), body.is_reachable.end(), 1);
  if (experiments.points_file) {
    body.test_points = place_points(read_point_table(*experiments.points_file), body.surface,
                                    experiments.points_file->string());
    if (!surface_only) leave_out_of_reach(scene, body);
  } else {
    body.test_points =
        spread_test_points(body, experiments.test_points.value_or(static_cast<int>(reachable)));
  }
  say("  test points: {} on {} reachable vertices of {}", body.test_points.position.rows(),
      reachable, body.surface.vertices.rows());
}

}  // namespace

std::string size_in_words(const Vec3& extent_m, double volume_m3) {
  const double largest = extent_m.maxCoeff();
  const auto [scale, unit, cubic, cubic_unit] =
      largest >= 10 ? std::tuple{1.0, "m", 1.0, "m3"}
      : largest >= 1e-3
          ? std::tuple{1e3, "mm", volume_m3 < 1e-4 ? 1e6 : 1e3, volume_m3 < 1e-4 ? "ml" : "l"}
          : std::tuple{1e6, "um", 1e18, "um3"};
  const Vec3 e = scale * extent_m;
  std::string words = fmt::format("{:.3g} x {:.3g} x {:.3g} {}", e[0], e[1], e[2], unit);
  if (volume_m3 > 0) words += fmt::format(", {:.3g} {}", cubic * volume_m3, cubic_unit);
  return words;
}

namespace {

// A remedy for a surface that cannot be wrapped, as a body can.
std::string without_wrap(std::string remedy) {
  constexpr std::string_view kOffer = ", or wrap it.";
  if (remedy.ends_with(kOffer)) remedy.replace(remedy.size() - kOffer.size(), kOffer.size(), ".");
  return remedy;
}

// Reads what a region is made of from the file that has it.
void read_region_file(Region& region, const BodySection& body) {
  const double length_unit_m = body.length_unit_m;
  if (auto* marked = std::get_if<Marked>(&region))
    marked->part = std::make_shared<const PaintedPart>(
        read_marked_part(body.tetmesh ? *body.tetmesh : *body.surface, length_unit_m,
                         body.tetmesh.has_value(), marked->mark));
  auto* solid = std::get_if<Solid>(&region);
  if (solid == nullptr) return;
  const std::string file = solid->file.string();
  Mended mended;
  try {
    mended = mend_surface(read_surface(solid->file, length_unit_m), {}, file);
  } catch (const Error& e) {
    throw Error(e.where(), e.fact(), without_wrap(e.remedy()));
  }
  for (const std::string& change : mended.changes) say("  mended: {}: {}", file, change);
  solid->boundary = std::make_shared<const Enclosed>(std::move(mended.surface));
}

}  // namespace

Scene open_scene(const std::filesystem::path& path) {
  Scene scene = read_scene(path);
  for (Region& region : scene.body.fixed) read_region_file(region, scene.body);
  for (Region& region : scene.body.symmetric) read_region_file(region, scene.body);
  for (InclusionSection& inclusion : scene.inclusions) {
    read_region_file(inclusion.region, scene.body);
    if (const auto* marked = std::get_if<Marked>(&inclusion.region);
        marked != nullptr && marked->part->is_on_faces())
      throw Error(scene.path.string() + ": [[inclusion]]",
                  fmt::format("\"{}\" marks faces, which fill nothing", marked->mark.name),
                  "Mark tetrahedra of a tetmesh, or give a closed surface with inside.");
  }
  for (BedSection& bed : scene.beds) read_region_file(bed.region, scene.body);
  if (scene.experiments.region)
    if (auto* part = std::get_if<Region>(&scene.experiments.region->part))
      read_region_file(*part, scene.body);
  ProbeSection& probe = scene.probe;
  if (probe.mesh) probe.spec.mesh = read_surface(*probe.mesh, probe.mesh_unit_m);
  return scene;
}

namespace {

// Bends a body that is given at rest; of one that is given under its weight, sees to it that it
// has a shape at rest.
void bend(const Scene& scene, Body& body) {
  check_choices(scene);
  try {
    const fem::SimulationSetup setup = make_setup(scene, body);
    if (!setup.regions_at_rest) {
      const fem::LoadedShape bent = fem::unbend_base(setup);
      say("  gravity: bends the body by up to {:.3g} mm; the shape at rest bends into the given "
          "one "
          "to {:.2g} mm",
          1e3 * bent.largest_m(), 1e3 * bent.residual_m);
      return;
    }
    const fem::LoadedShape bent = fem::bend_base(setup);
    body.volume.nodes += bent.sag();
    body.surface.vertices += Eigen::Map<const Eigen::Matrix<float, -1, 3, Eigen::RowMajor>>(
                                 bent.surface.data(), body.surface.vertices.rows(), 3)
                                 .cast<double>();
    say("  gravity: bends the body by up to {:.3g} mm", 1e3 * bent.largest_m());
  } catch (const Error& e) {
    throw Error(scene.path.string() + ": " + e.where(), e.fact(), e.remedy());
  }
}

Body make_body(const Scene& scene, bool surface_only) {
  Body body;
  body.probe = scene.probe.spec;
  body.settings = settings_of(scene);
  read_meshes(scene, surface_only, body);
  const bool is_open = surface_only && !surface_facts(body.surface).is_closed;
  say("  surface: {}, {} vertices, {} triangles",
      size_in_words(extent_m(body.surface.vertices), is_open ? 0 : volume_m3(body.surface)),
      body.surface.vertices.rows(), body.surface.triangles.rows());
  if (!surface_only) {
    if (body.volume.tets.rows() == 0) fill(scene, body);
    hold(scene, body);
  }
  const Points named = body.surface.vertices;
  if (scene.gravity && !surface_only) bend(scene, body);
  find_reachable(scene, surface_only, named, body);
  choose_points(scene, surface_only, body);
  return body;
}

}  // namespace

Body prepare_body(const Scene& scene, bool surface_only) {
  const auto body = std::make_shared<Body>();
  run_abandonably([body, scene, surface_only] { *body = make_body(scene, surface_only); },
                  "prepare: nothing was written");
  return std::move(*body);
}

void check_choices(const Scene& scene) {
  const std::string file = scene.path.string();
  if (!scene.material)
    throw Error(file, "the scene has no [material]",
                "Add [material] with law and its parameters, such as young and poisson.");
  fem::make_probe(scene.probe.spec, file + ": [probe]");
  check_tilts(scene);
  check_pairs(scene);
}

void check_experiments(const Scene& scene, const Body& body) {
  const fem::SimulationSetup setup = make_setup(scene, body);
  const std::string file = scene.path.string();
  const auto in_scene = [&](const Error& e) {
    return Error(file + ": " + e.where(), e.fact(), e.remedy());
  };
  try {
    fem::check_setup(setup);
  } catch (const Error& e) {
    throw in_scene(e);
  }
  say_plausibility(scene, body);
  const double thinnest_m = extent_m(body.surface.vertices).minCoeff();
  if (scene.experiments.each.depth_m >= thinnest_m)
    throw Error(file + ": [experiments] depth",
                fmt::format("the depth of {:.4g} mm is more than the body is thick ({:.4g} mm)",
                            1e3 * scene.experiments.each.depth_m, 1e3 * thinnest_m),
                "Press less deep, or check the unit of depth and length_unit.");
  // A depth beyond the thickness is an error of the scene when it is so at most points; a few
  // points on a thin rim bend out of the way, and their rows tell how far that went.
  std::optional<Error> first;
  Eigen::Index refused = 0;
  const Eigen::Index points = body.test_points.position.rows();
  for (Eigen::Index p = 0; p < points; ++p) {
    try {
      fem::check_experiments(setup, experiments_of(scene), body.test_points.position.row(p),
                             body.test_points.normal.row(p));
    } catch (const Error& e) {
      ++refused;
      if (!first) first = in_scene(e);
    }
  }
  if (2 * refused > points) throw *first;
  if (refused) say("  {} of {} test points are on parts thinner than the depth", refused, points);
}

}  // namespace palpate::tools
