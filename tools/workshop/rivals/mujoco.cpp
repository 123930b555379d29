// (f): in Node, where its package is.

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "libfit/core/error.hpp"
#include "tools/workshop/bench/machine.hpp"
#include "tools/workshop/rivals/coarse_body.hpp"
#include "tools/workshop/rivals/mujoco.hpp"
#include "tools/workshop/rivals/node_process.hpp"

namespace palpate::tools {

extern const char* const kMujocoScript;  // mujoco.mjs

namespace {

constexpr double kStep_m = 0.5e-3;
constexpr int kRest = 150;         // ticks; the block needs about 40
constexpr double kOutside_m = 10;  // where the ball is before a path

Vec3 read_answer(const std::string& answer, double& microseconds) {
  Vec3 force;
  if (std::sscanf(answer.c_str(), "%lf %lf %lf %lf", &force[0], &force[1], &force[2],
                  &microseconds) != 4)
    throw Error("bench rivals", "Node has ended without an answer", "See what it printed.");
  return force;
}

}  // namespace

bool has_mujoco(const std::filesystem::path& packages) {
  return !packages.empty() &&
         std::filesystem::exists(packages / "node_modules/@mujoco/mujoco/package.json");
}

MujocoBody::MujocoBody(const CoarseBody& body, const MujocoSettings& settings,
                       const std::filesystem::path& packages) {
  std::vector<double> points(body.nodes.data(), body.nodes.data() + body.nodes.size());
  std::vector<int> elements(body.tets.data(), body.tets.data() + body.tets.size()), held;
  for (std::size_t n = 0; n < body.is_held.size(); ++n)
    if (body.is_held[n]) held.push_back(static_cast<int>(n));
  double volume_m3 = 0;
  for (Eigen::Index t = 0; t < body.tets.rows(); ++t)
    volume_m3 += edges_of(body.nodes, body.tets, t).determinant() / 6;
  const nlohmann::json model{{"step_s", settings.step_s},
                             {"solver", settings.solver},
                             {"iterations", 50},
                             {"tolerance", 1e-6},
                             {"outside", fmt::format("{0} {0} {0}", kOutside_m)},
                             {"radius_m", settings.ball.radius_m},
                             {"friction", settings.ball.friction},
                             {"solref", fmt::format("{} 1", 2 * settings.step_s)},
                             {"solimp", "0.99 0.999 0.0001"},
                             {"skin_m", 1e-5},
                             {"mass_kg", settings.density_kg_m3 * volume_m3},
                             {"points", points},
                             {"elements", elements},
                             {"young_Pa", body.young_Pa.mean()},
                             {"poisson", body.poisson.mean()},
                             {"damping_s", settings.damping_s},
                             {"held", held}};
  node_ = std::make_unique<NodeProcess>(kMujocoScript, packages);
  double bytes = 0;
  read_answer(node_->ask(model.dump()), bytes);
  bytes_ = static_cast<std::size_t>(bytes);
}

void MujocoBody::start() {
  double none = 0;
  read_answer(node_->ask(fmt::format("start {0} {0} {0}", kOutside_m)), none);
}

Vec3 MujocoBody::force(const Vec3& centre_m) {
  double microseconds = 0;
  const Vec3 force = read_answer(
      node_->ask(fmt::format("{:.9g} {:.9g} {:.9g}", centre_m[0], centre_m[1], centre_m[2])),
      microseconds);
  cpu_s_ += 1e-6 * microseconds;
  return force;
}

std::vector<Rival> prepare_mujoco(const RivalBody& body) {
  std::vector<Rival> out;
  if (!has_mujoco(body.packages)) return out;
  for (CoarseMesh& mesh : coarse_meshes(body, false)) {
    const double began_s = cpu_seconds();
    MujocoSettings settings;
    settings.ball = {.radius_m = body.radius_m, .friction = body.body.probe->friction};
    const auto stepped = std::make_shared<MujocoBody>(mesh.body, settings, body.packages);
    Rival rival = solved_rival(stepped, body.radius_m);
    rival.preparation_cpu_s = mesh.cpu_s + cpu_seconds() - began_s;
    rival.name = "MuJoCo flex";
    rival.size = static_cast<double>(mesh.body.nodes.rows());
    rival.step_m = kStep_m;
    rival.rest_ticks = kRest;
    rival.own_cpu_s = [stepped] { return stepped->cpu_s(); };
    rival.settings = fmt::format(
        "npm's @mujoco/mujoco in Node; {} nodes, {}; flexcomp, integrator discrete, steps of {} "
        "ms, {}, {} kg/m3, damping {} s, solref {} 1, friction {}, at most {} ticks of rest",
        mesh.body.nodes.rows(), mesh.words, 1e3 * settings.step_s, settings.solver,
        settings.density_kg_m3, settings.damping_s, 2 * settings.step_s, settings.ball.friction,
        rival.rest_ticks);
    out.push_back(with_fitted_modulus(std::move(rival), body));
  }
  return out;
}

}  // namespace palpate::tools
