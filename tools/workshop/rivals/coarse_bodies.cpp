// Coarse bodies: meshes from a few nodes for the whole body to fine ones where the ball goes, and
// the two of (g) on them.

#include <fmt/format.h>

#include <memory>
#include <optional>

#include "libfem/mesh/grade/grade_mesh.hpp"
#include "libfem/mesh/topology.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/workshop/bench/machine.hpp"
#include "tools/workshop/rivals/corotational.hpp"
#include "tools/workshop/rivals/green.hpp"
#include "tools/workshop/rivals/total_lagrangian.hpp"

namespace palpate::tools {
namespace {

constexpr double kCoarserBase = 2;                     // edge of the coarsest mesh, in base edges
constexpr double kGradedSizes[] = {4, 2.5, 1.5, 1.0};  // in the window, in radii of the ball
constexpr double kFinerThanEven = 3;   // graded sizes that are, in radii of the ball
constexpr double kPenalty_E_m = 20e3;  // pressure by overlap, in moduli: 20 E/mm, 1 % of bias
constexpr double kCarriedRadii = 3;    // how far around the window points touch, in radii
constexpr int kManyNodes = 1000;       // from here on a tick takes larger steps
constexpr double kLargeStep_m = 0.5e-3;
constexpr int kExplicitRest = 150;  // ticks; the block needs about 50

// Linear tets of the corners of a mesh, with the constants of small strain in each.
CoarseBody coarse_body(const fem::SimulationSetup& setup, Points nodes, Tets tets,
                       std::vector<char> is_held) {
  CoarseBody out{std::move(nodes), std::move(tets), std::move(is_held), {}, {}, {}};
  out.young_Pa.resize(out.tets.rows());
  out.poisson.resize(out.tets.rows());
  for (Eigen::Index t = 0; t < out.tets.rows(); ++t) {
    Vec3 centroid = Vec3::Zero();
    for (int k = 0; k < 4; ++k) centroid += 0.25 * out.nodes.row(out.tets(t, k)).transpose();
    const int region = setup.region_at ? setup.region_at(centroid) : 0;
    const fem::Material material =
        fem::make_material(setup.materials[static_cast<std::size_t>(region)], "[material]");
    const fem::SmallStrain strain = material.law->small_strain(material.constants);
    out.young_Pa[t] = strain.young_Pa();
    out.poisson[t] = strain.poisson();
  }
  return out;
}

CoarseBody whole_body(const fem::SimulationSetup& setup, const TetMesh& mesh) {
  std::vector<char> is_boundary(static_cast<std::size_t>(mesh.nodes.rows()), 0), is_held;
  const Triangles faces = fem::boundary_triangles(mesh.tets);
  for (const std::int32_t node : faces.reshaped()) is_boundary[static_cast<std::size_t>(node)] = 1;
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n)
    is_held.push_back(setup.held_at(mesh.nodes.row(n), is_boundary[static_cast<std::size_t>(n)]));
  return coarse_body(setup, mesh.nodes, mesh.tets, is_held);
}

CoarseBody graded_body(const fem::SimulationSetup& setup, const Points& window, double size_m,
                       double reach_m) {
  const fem::QuadraticMesh mesh = window_mesh(setup, window, size_m, reach_m);
  const Tets corners = mesh.tets.leftCols<4>();
  const Eigen::Index count = corners.maxCoeff() + 1;
  return coarse_body(setup, mesh.nodes.topRows(count), corners,
                     {mesh.is_held.begin(), mesh.is_held.begin() + count});
}

// The points that the body carries beneath the window.
CoarseBody carrying(CoarseBody coarse, const RivalBody& body) {
  coarse.carried =
      carried_points(coarse.nodes, coarse.tets, body.body.surface,
                     window_cover(body.body, body.radius_m), kCarriedRadii * body.radius_m);
  return coarse;
}

BallContact ball_on(const RivalBody& body, const CoarseBody& coarse) {
  return {.radius_m = body.radius_m,
          .friction = body.body.probe->friction,
          .penalty_Pa_m = kPenalty_E_m * coarse.young_Pa.minCoeff()};
}

Rival corotational_of(const RivalBody& body, CoarseBody coarse, const std::string& mesh) {
  const Eigen::Index nodes = coarse.nodes.rows();
  const bool is_large = nodes > kManyNodes;
  CorotationalSettings settings{.ball = ball_on(body, coarse)};
  settings.newton = is_large ? 4 : 1;
  const auto solved =
      std::make_shared<CorotationalBody>(carrying(std::move(coarse), body), settings);
  Rival rival = solved_rival(solved, body.radius_m);
  rival.name = "corotational FEM";
  rival.size = static_cast<double>(nodes);
  if (is_large) rival.step_m = kLargeStep_m;
  rival.settings = fmt::format(
      "{} nodes, {}; linear tets that carry the fine surface, no inertia, {} Newton steps a tick, "
      "at most {} CG iterations to "
      "{:.0e}, penalty 20 E/mm, friction {}",
      nodes, mesh, settings.newton, settings.solver, settings.tolerance, settings.ball.friction);
  return rival;
}

Rival explicit_of(const RivalBody& body, CoarseBody coarse, const std::string& mesh) {
  const Eigen::Index nodes = coarse.nodes.rows();
  ExplicitSettings settings{.ball = ball_on(body, coarse)};
  const auto stepped = std::make_shared<ExplicitBody>(carrying(std::move(coarse), body), settings);
  Rival rival = solved_rival(stepped, body.radius_m);
  rival.name = "total-Lagrangian explicit";
  rival.size = static_cast<double>(nodes);
  rival.rest_ticks = kExplicitRest;
  rival.settings = fmt::format(
      "{} nodes, {}; linear tets that carry the fine surface, neo-Hookean, {} steps of {:.2g} us "
      "in "
      "a tick of 1 ms ({} of the longest stable one), {} kg/m3, damping {}/s, penalty 20 E/mm, "
      "friction {}, at most {} ticks of rest",
      nodes, mesh, stepped->steps(), 1e6 * settings.tick_s / stepped->steps(),
      settings.step_of_stable, settings.density_kg_m3, settings.damping_Hz, settings.ball.friction,
      rival.rest_ticks);
  return rival;
}

template <class Make>
std::vector<Rival> on_each_mesh(const RivalBody& body, const Make& make, bool with_even) {
  std::vector<Rival> out;
  for (CoarseMesh& mesh : coarse_meshes(body, with_even)) {
    const double began_s = cpu_seconds();
    Rival rival = make(body, std::move(mesh.body), mesh.words);
    rival.preparation_cpu_s = mesh.cpu_s + cpu_seconds() - began_s;
    out.push_back(with_fitted_modulus(std::move(rival), body));
  }
  return out;
}

}  // namespace

std::vector<CoarseMesh> coarse_meshes(const RivalBody& body, bool with_even) {
  const fem::SimulationSetup setup = make_setup(body.scene, body.body);
  std::vector<CoarseMesh> out;
  const auto add = [&](const auto& make, const std::string& words) {
    const double began_s = cpu_seconds();
    CoarseBody made = make();
    out.push_back({std::move(made), words, cpu_seconds() - began_s});
  };
  if (with_even) {
    add(
        [&] {
          Scene scene = body.scene;
          Body coarser = body.body;
          coarser.in_region.clear();  // as coarse at the window as elsewhere
          scene.body.mesh_size_m =
              kCoarserBase * base_edge_m(body.scene, volume_m3(body.body.surface));
          fill_with_tets(scene, coarser);
          return whole_body(setup, coarser.volume);
        },
        "even");
    add([&] { return whole_body(setup, setup.volume); }, "even");
  }
  for (const double size : kGradedSizes) {
    const double size_m = size * body.radius_m;
    if (with_even && size > kFinerThanEven) continue;
    add(
        [&] {
          return graded_body(setup, window_cover(body.body, size_m), size_m,
                             size_m + body.radius_m);
        },
        fmt::format("{:.0f} mm in the window", 1e3 * size_m));
  }
  return out;
}

std::vector<Rival> prepare_corotational(const RivalBody& body) {
  return on_each_mesh(body, corotational_of, true);
}

// Flat tets of the even meshes would set its step.
std::vector<Rival> prepare_explicit(const RivalBody& body) {
  return on_each_mesh(body, explicit_of, false);
}

}  // namespace palpate::tools
