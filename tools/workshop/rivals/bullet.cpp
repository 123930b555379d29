#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "tools/workshop/bench/machine.hpp"
#include "tools/workshop/rivals/rival.hpp"

#if PALPATE_BULLET

#include "tools/workshop/rivals/bullet_body.hpp"

namespace palpate::tools {
namespace {

constexpr double kStep_m = 0.5e-3;
constexpr double kDensity_kg_m3 = 3000, kStable = 50;  // found on the block, meshes of 5 to 20 mm
constexpr int kRest = 150;                             // on the block it needs about 60

// Below it steps blow up, at any damping that was tried: its first guess of a step is explicit.
double stable_density_kg_m3(const CoarseBody& body, double step_s) {
  double shortest_m = 1;
  for (const auto& tet : body.tets.rowwise())
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < a; ++b)
        shortest_m = std::min(shortest_m, (body.nodes.row(tet[a]) - body.nodes.row(tet[b])).norm());
  const double step_per_edge = step_s / shortest_m;
  return std::max(kDensity_kg_m3,
                  kStable * body.young_Pa.maxCoeff() * step_per_edge * step_per_edge);
}

}  // namespace

std::vector<Rival> prepare_bullet(const RivalBody& body) {
  std::vector<Rival> out;
  for (CoarseMesh& mesh : coarse_meshes(body, false)) {
    const double began_s = cpu_seconds();
    const Eigen::Index nodes = mesh.body.nodes.rows();
    BulletSettings settings;
    settings.density_kg_m3 = stable_density_kg_m3(mesh.body, settings.step_s);
    settings.ball = {.radius_m = body.radius_m, .friction = body.body.probe->friction};
    const auto stepped = std::make_shared<BulletBody>(std::move(mesh.body), settings);
    Rival rival = solved_rival(stepped, body.radius_m);
    rival.preparation_cpu_s = mesh.cpu_s + cpu_seconds() - began_s;
    rival.name = "Bullet deformable";
    rival.size = static_cast<double>(nodes);
    rival.step_m = kStep_m;
    rival.is_force_at_rest = true;
    rival.rest_ticks = kRest;
    rival.settings = fmt::format(
        "Bullet 3.24, double; {} nodes, {}; neo-Hookean, implicit steps of {} ms with {} Newton "
        "iterations, {:.0f} kg/m3, damping {} s, contacts of nodes and faces, friction {}, at "
        "most {} ticks of rest",
        nodes, mesh.words, 1e3 * settings.step_s, settings.newton, settings.density_kg_m3,
        settings.damping_s, settings.ball.friction, rival.rest_ticks);
    out.push_back(with_fitted_modulus(std::move(rival), body));
  }
  return out;
}

}  // namespace palpate::tools

#else

namespace palpate::tools {

std::vector<Rival> prepare_bullet(const RivalBody&) { return {}; }

}  // namespace palpate::tools

#endif
