#include <algorithm>
#include <cmath>
#include <ctime>

#include "data/generators/structured_block.hpp"
#include "libfem/mesh/topology.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/workshop/bench/fem.hpp"

namespace palpate::tools {
namespace {

constexpr double kYoung_Pa = 10e3, kRadius_m = 0.01;
constexpr double kCylinderRadius_m = 0.06, kCylinderHeight_m = 0.04;

std::vector<char> held_below(const Points& nodes, double z_m) {
  std::vector<char> is_held;
  for (Eigen::Index n = 0; n < nodes.rows(); ++n) is_held.push_back(nodes(n, 2) < z_m);
  return is_held;
}

}  // namespace

FemCase fem_block(double poisson, double friction, std::array<int, 3> cells) {
  FemCase out;
  out.setup.volume = fem::structured_block(Vec3(0.1, 0.1, 0.04), cells);
  out.setup.is_held = held_below(out.setup.volume.nodes, 1e-6);
  out.setup.surface = {out.setup.volume.nodes, fem::boundary_triangles(out.setup.volume.tets)};
  out.setup.materials = {{"neo-hookean", {kYoung_Pa, poisson}}};
  out.setup.probe = sphere_spec(kRadius_m, friction);
  out.place = Vec3(0.0511, 0.0487, 0.04);
  out.normal = -Vec3::UnitZ();
  return out;
}

FemCase fem_cylinder(double poisson, double friction) {
  FemCase out;
  out.setup.volume = fem::structured_cylinder(kCylinderRadius_m, kCylinderHeight_m, 6, 3);
  out.setup.is_held = held_below(out.setup.volume.nodes, -0.9999 * kCylinderHeight_m);
  const TetMesh finer = fem::structured_cylinder(kCylinderRadius_m, kCylinderHeight_m, 36, 3);
  out.setup.surface = {finer.nodes, fem::boundary_triangles(finer.tets)};
  out.setup.materials = {{"neo-hookean", {kYoung_Pa, poisson}}};
  out.setup.probe = sphere_spec(kRadius_m, friction);
  out.place = Vec3::Zero();
  out.normal = -Vec3::UnitZ();
  return out;
}

std::vector<double> fem_cylinder_force_N(double poisson) {
  if (poisson == 0.45)
    return {0.056213, 0.162001, 0.300782, 0.465666, 0.652051,
            0.855974, 1.074112, 1.303358, 1.540461, 1.782624};
  if (poisson == 0.49)
    return {0.058636, 0.168528, 0.312130, 0.482380, 0.674115,
            0.883201, 1.106157, 1.339524, 1.579860, 1.824296};
  return {};
}

FemCase fem_liver() {
  const Scene scene = read_scene("data/scenes/liver.toml");
  const Body body = prepare_body(scene, false);
  FemCase out{make_setup(scene, body), body.test_points.position.row(0),
              body.test_points.normal.row(0)};
  return out;
}

fem::Experiments press_of(double depth_m, int steps) {
  fem::Experiments out;
  out.depth_m = depth_m;
  out.press_steps = steps;
  return out;
}

double thread_cpu_s() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

FemRun run_case(const FemCase& what, const fem::Experiments& experiments) {
  FemRun out;
  const fem::Simulator simulator(what.setup);
  const double start = thread_cpu_s();
  out.rows = simulator.press_and_drag(what.place, what.normal, experiments);
  out.cpu_s = thread_cpu_s() - start;
  return out;
}

double greatest_difference(const fem::PointRows& a, const fem::PointRows& b) {
  double out = 0;
  for (Eigen::Index i = 0; i < std::min(a.rows(), b.rows()); ++i)
    if (a.status[i] == RowStatus::good && b.status[i] == RowStatus::good)
      out = std::max(out, (a.force.row(i) - b.force.row(i)).norm() / b.force.row(i).norm());
  return out;
}

CaseError force_error(const fem::PointRows& rows, const std::vector<double>& force_N) {
  CaseError out;
  for (Eigen::Index i = 0; i < std::min(std::ssize(force_N), rows.rows()); ++i) {
    const double error = rows.force.row(i).norm() / force_N[i] - 1;
    if (std::abs(error) > std::abs(out.worst)) out.worst = error;
    out.mean += std::abs(error) / static_cast<double>(force_N.size());
  }
  return out;
}

}  // namespace palpate::tools
