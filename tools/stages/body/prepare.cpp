#include "tools/stages/body/prepare.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "libfem/materials/element_kernel.hpp"
#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfem/solve/factor/schur_factor.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/linear_algebra.hpp"
#include "libfit/io/csv/tables.hpp"
#include "tools/console.hpp"
#include "tools/scene/canonical.hpp"

namespace palpate::tools {
namespace {

// True if what a body rests on keeps it from moving as a rigid one: its stiffness against the six
// rigid motions, rotations about the middle, over half the body's size.
bool holds_rigidly(const fem::SimulationSetup& setup, const TetMesh& volume) {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  const Points& nodes = volume.nodes;
  const Vec3 middle = nodes.colwise().mean();
  const double half_m = extent_m(nodes).norm() / 2;
  Matrix6 stiffness = Matrix6::Zero();
  const Triangles boundary = fem::boundary_triangles(volume.tets);
  for (const auto& face : boundary.rowwise()) {
    const Vec3 a = nodes.row(face[0]), b = nodes.row(face[1]), c = nodes.row(face[2]);
    const Vec3 centre = (a + b + c) / 3, area = (b - a).cross(c - a) / 2,
               x = (centre - middle) / half_m;
    const fem::BedStiffness bed = setup.loads.bed_at(centre);
    const Vec3 n = area.normalized();
    Eigen::Matrix<double, 3, 6> motion;
    motion.leftCols<3>().setIdentity();
    motion.rightCols<3>() << 0, x.z(), -x.y(), -x.z(), 0, x.x(), x.y(), -x.x(), 0;
    stiffness += area.norm() * motion.transpose() *
                 ((bed.along_N_m3 - bed.across_N_m3) * n * n.transpose() +
                  bed.across_N_m3 * Mat3::Identity()) *
                 motion;
  }
  const Eigen::VectorXd spread = symmetric_eigen(Eigen::MatrixXd(stiffness)).values;
  return spread[0] > 1e-6 * spread[5];  // of the stiffest motion
}

// Nodes inside the scene's fixed regions; refuses bodies that could move rigidly or not at all.
void hold(const Scene& scene, Body& body) {
  if (scene.body.fixed.empty() && scene.beds.empty())
    throw Error(body_place(scene), "nothing is fixed, so the body could move as a rigid one",
                "Add fixed = [ { below = { axis = \"z\", at = \"2 mm\" } } ] or another region.");
  const Points& nodes = body.volume.nodes;
  std::vector<char> is_on_boundary(nodes.rows(), 0);
  const Triangles boundary = fem::boundary_triangles(body.volume.tets);
  for (const std::int32_t n : boundary.reshaped()) is_on_boundary[n] = 1;
  body.is_held.assign(nodes.rows(), 0);
  for (Eigen::Index n = 0; n < nodes.rows(); ++n)
    body.is_held[n] = any_contains(scene.body.fixed, nodes.row(n), is_on_boundary[n] != 0);
  const auto held = std::count(body.is_held.begin(), body.is_held.end(), 1);
  const std::string extent = fmt::format("The body spans {}.", span_in_words(nodes));
  if (held < 3 && !scene.beds.empty()) {
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
    const std::string where = experiments.points_file->string();
    const PointTable points = read_point_table(where);
    warn_of_unused(where, points.ignored);
    body.test_points = place_points(points, body.surface, where);
    refuse_same_place(body.test_points.position, where);
    if (!surface_only) leave_out_of_reach(scene, body);
  } else {
    body.test_points =
        spread_test_points(body, experiments.test_points.value_or(static_cast<int>(reachable)));
  }
  say("  test points: {} on {} reachable vertices of {}", body.test_points.position.rows(),
      reachable, body.surface.vertices.rows());
}

// given: how many vertices the surface had before it was divided, which keep their numbers.
void take_division(const Scene& scene, const Surface& asset, Eigen::Index given, Body& body) {
  const Points& own = body.surface.vertices;
  const bool is_own = asset.vertices.rows() == own.rows() && begin_alike(asset.vertices, own);
  if (is_own || asset.vertices.rows() < given || !begin_alike(asset.vertices, own.topRows(given)))
    return;
  say("  surface: divided as the asset's, {} vertices for {}", asset.vertices.rows(), own.rows());
  body.surface = asset;
  find_region(scene, body);
}

// Everything that is made of the body's mesh.
void set_up(const Scene& scene, bool surface_only, const Surface* asset, Body& body) {
  find_region(scene, body);
  const Eigen::Index given = body.surface.vertices.rows();
  if (!surface_only) {
    if (body.volume.tets.rows() == 0) fill_with_tets(scene, body);
    hold(scene, body);
    divide_region(scene, body);
  }
  if (asset != nullptr) take_division(scene, *asset, given, body);
  find_reachable(scene, surface_only, body);
  choose_points(scene, surface_only, body);
}

Body make_body(const Scene& scene, bool surface_only, const Surface* asset) {
  Body body;
  store_scene(scene, body);
  read_meshes(scene, surface_only, body);
  const bool is_open = surface_only && !surface_facts(body.surface).is_closed;
  say("  surface: {}, {} vertices, {} triangles",
      size_in_words(extent_m(body.surface.vertices), is_open ? 0 : volume_m3(body.surface)),
      body.surface.vertices.rows(), body.surface.triangles.rows());
  try {
    set_up(scene, surface_only, asset, body);
  } catch (const Error& e) {
    // A refusal often follows from the mesh: from its unit, or from a cut through it.
    std::string remedy = e.remedy();
    for (const std::string& doubt : doubts_of_shape(scene, body)) remedy += " " + doubt;
    throw Error(e.where(), e.fact(), remedy);
  }
  return body;
}

}  // namespace

Body prepare_body(const Scene& scene, bool surface_only, const Surface* asset) {
  const auto body = std::make_shared<Body>();
  const auto kept = asset ? std::make_shared<const Surface>(*asset) : nullptr;
  run_abandonably(
      [body, scene, surface_only, kept] { *body = make_body(scene, surface_only, kept.get()); },
      "prepare: nothing was written");
  return std::move(*body);
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
  const std::vector<Error> refused = refused_points(scene, setup, body.test_points);
  if (2 * std::ssize(refused) > body.test_points.position.rows()) throw in_scene(refused[0]);
  say_thin_parts(refused.size(), body.test_points);
}

std::vector<Error> refused_points(const Scene& scene, const fem::SimulationSetup& setup,
                                  const TestPoints& points) {
  std::vector<Error> refused;
  for (Eigen::Index p = 0; p < points.position.rows(); ++p) {
    try {
      fem::check_experiments(setup, experiments_of(scene), points.position.row(p),
                             points.normal.row(p));
    } catch (const Error& e) {
      refused.push_back(e);
    }
  }
  return refused;
}

void say_thin_parts(std::size_t refused, const TestPoints& points) {
  if (refused > 0)
    say("  {} of {} test points are on parts thinner than the depth", refused,
        points.position.rows());
}

std::vector<InclusionSection> parts_of_body(const Scene& scene, const Body& body) {
  std::vector<InclusionSection> parts = scene.inclusions;
  std::shared_ptr<const Enclosed> outer;
  for (InclusionSection& part : parts)
    if (auto* layer = std::get_if<Layer>(&part.region)) {
      if (!outer) outer = std::make_shared<const Enclosed>(outer_surface(body.surface));
      layer->outer = outer;
    }
  return parts;
}

fem::SimulationSetup make_setup(const Scene& scene, const Body& body) {
  static std::once_flag said;
  std::call_once(said, [] {
    if (!fem::has_instruction_set(fem::InstructionSet::avx2))
      warn(
          "this processor has no AVX2 with FMA: a simulation takes several times as long, and "
          "forces differ from those of other processors in their last digits");
  });
  fem::bound_factor_memory(1e9 * scene.experiments.memory_GB);
  fem::SimulationSetup setup;
  setup.volume = body.volume;
  setup.is_held = body.is_held;
  setup.held_at = [fixed = scene.body.fixed](const Vec3& place, bool is_on_boundary) {
    return any_contains(fixed, place, is_on_boundary);
  };
  setup.surface = body.surface;
  setup.materials.push_back(*scene.material);
  // Parts of one material have no border: they cost what the body costs without them.
  std::vector<std::string> texts{canonical(*scene.material)};
  std::vector<std::pair<Region, int>> parts;
  for (const InclusionSection& part : parts_of_body(scene, body)) {
    const auto known = std::ranges::find(texts, canonical(part.material));
    parts.emplace_back(part.region, known - texts.begin());
    if (known != texts.end()) continue;
    texts.push_back(canonical(part.material));
    setup.materials.push_back(part.material);
  }
  // The last part named counts where several overlap.
  if (texts.size() > 1)
    setup.region_at = [parts](const Vec3& place) {
      const auto last = std::find_if(parts.rbegin(), parts.rend(),
                                     [&](const auto& part) { return contains(part.first, place); });
      return last == parts.rend() ? 0 : last->second;
    };
  // The layer is thin against its breadth: confined along the normal, in shear across (M13f).
  std::vector<std::pair<Region, fem::BedStiffness>> beds;
  for (const BedSection& bed : scene.beds) {
    const fem::Material layer = fem::make_material(bed.material, "material of [[bed]]");
    const fem::SmallStrain moduli = layer.law->small_strain(layer.constants);
    beds.push_back({bed.region,
                    {(moduli.lambda_Pa + 2 * moduli.mu_Pa) / bed.thickness_m,
                     bed.slides ? 0 : moduli.mu_Pa / bed.thickness_m}});
  }
  if (!beds.empty())
    setup.loads.bed_at = [beds](const Vec3& place) {
      for (const auto& [region, stiffness] : beds)
        if (contains(region, place)) return stiffness;
      return fem::BedStiffness{};
    };
  setup.loads.lumen_pressure_Pa = scene.body.pressure_Pa;
  setup.probe = scene.probe.spec;
  setup.options.force_tolerance = scene.experiments.force_tolerance;
  return setup;
}

Eigen::Index middle_point(const Scene& scene, const Body& body) {
  const Points& places = body.test_points.position;
  const Vec3 middle = center_of(scene.experiments.region).value_or(places.colwise().mean());
  Eigen::Index point = 0;
  (places.rowwise() - middle.transpose()).rowwise().squaredNorm().minCoeff(&point);
  return point;
}

fem::Experiments experiments_of(const Scene& scene) {
  fem::Experiments experiments = scene.experiments.each;
  if (experiments.drag_directions == 0) experiments.drag_depths_m.clear();
  return experiments;
}

}  // namespace palpate::tools
