// Meshes of (g): from a few nodes for the whole body to fine ones where the ball goes.

#include <fmt/format.h>

#include <memory>
#include <optional>

#include "libfem/mesh/boundary.hpp"
#include "libfem/mesh/grade/grade_mesh.hpp"
#include "tools/bench/machine.hpp"
#include "tools/bench/rivals/corotational.hpp"
#include "tools/bench/rivals/green.hpp"
#include "tools/stages/body/body_meshes.hpp"
#include "tools/stages/body/simulation_setup.hpp"

namespace palpate::tools {
namespace {

constexpr double kCoarserBase = 2;                  // edge of the coarsest mesh, in base edges
constexpr double kGradedSizes[] = {2.5, 1.5, 1.0};  // in the window, in radii of the ball
constexpr double kPenalty_E_m = 20e3;  // pressure by overlap, in moduli: 20 E/mm, 1 % of bias
constexpr double kCarriedRadii = 3;    // how far around the window points touch, in radii
constexpr int kManyNodes = 1000;       // from here on a tick takes larger steps
constexpr double kLargeStep_m = 0.5e-3;

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

Rival rival_of(const RivalBody& body, CoarseBody coarse, const std::string& mesh) {
  const Eigen::Index nodes = coarse.nodes.rows();
  coarse.carried =
      carried_points(coarse.nodes, coarse.tets, body.body.surface,
                     window_cover(body.body, body.radius_m), kCarriedRadii * body.radius_m);
  const bool is_large = nodes > kManyNodes;
  CorotationalSettings settings{.radius_m = body.radius_m,
                                .friction = body.body.probe->friction,
                                .penalty_Pa_m = kPenalty_E_m * coarse.young_Pa.minCoeff()};
  settings.newton = is_large ? 4 : 1;
  const auto solved = std::make_shared<CorotationalBody>(std::move(coarse), settings);
  Rival rival;
  rival.name = "corotational FEM";
  rival.size = static_cast<double>(nodes);
  rival.bytes = solved->bytes();
  if (is_large) rival.step_m = kLargeStep_m;
  rival.settings = fmt::format(
      "{} nodes, {}; linear tets that carry the fine surface, no inertia, {} Newton steps a tick, "
      "at most {} CG iterations to "
      "{:.0e}, penalty 20 E/mm, friction {}",
      nodes, mesh, settings.newton, settings.solver, settings.tolerance, settings.friction);
  const auto inward = std::make_shared<Vec3>(Vec3::Zero());
  rival.start = [solved, inward](const Vec3& u) {
    solved->start();
    *inward = u;
  };
  rival.force = [solved, inward, radius_m = body.radius_m](const Vec3& point) {
    return solved->force(point - radius_m * *inward);
  };
  return rival;
}

}  // namespace

std::vector<Rival> prepare_corotational(const RivalBody& body) {
  const fem::SimulationSetup setup = make_setup(body.scene, body.body);
  std::vector<Rival> out;
  const auto add = [&](const auto& make, const std::string& mesh) {
    const double began_s = cpu_seconds();
    Rival rival = rival_of(body, make(), mesh);
    rival.preparation_cpu_s = cpu_seconds() - began_s;
    out.push_back(with_fitted_modulus(std::move(rival), body));
  };
  add(
      [&] {
        Scene scene = body.scene;
        Body coarser = body.body;
        scene.body.mesh_size_m =
            kCoarserBase * base_edge_m(body.scene, volume_m3(body.body.surface));
        fill_with_tets(scene, coarser);
        return whole_body(setup, coarser.volume);
      },
      "even");
  add([&] { return whole_body(setup, setup.volume); }, "even");
  for (const double size : kGradedSizes) {
    const double size_m = size * body.radius_m;
    add(
        [&] {
          return graded_body(setup, window_cover(body.body, size_m), size_m,
                             size_m + body.radius_m);
        },
        fmt::format("{:.0f} mm in the window", 1e3 * size_m));
  }
  return out;
}

}  // namespace palpate::tools
