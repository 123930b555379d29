// What a second of the simulator buys: mesh share and tolerance against force error.

#include <fmt/core.h>

#include <algorithm>

#include "tools/workshop/bench/fem.hpp"

namespace palpate::tools {
namespace {

constexpr double kPoisson = 0.45, kDepth_m = 0.01;
constexpr double kSizes[] = {1.4, 1.0, 0.8, 0.6, 0.45};  // of an element, of the contact radius
constexpr double kResiduals[] = {0.3, 0.1, 1e-2, 1e-3, 1e-4};
constexpr double kCoarseRatio = 1.6;

struct SpeedSeries {
  std::string_view name;
  double coarse_ratio;
};
constexpr SpeedSeries kBySize[] = {
    {"mesh share, two meshes", kCoarseRatio},
    {"mesh share, one mesh", 0},
};

void add(std::string_view name, const fem::SolverOptions& options, BenchTable& table) {
  FemCase what = fem_cylinder(kPoisson);
  what.setup.options = options;
  const FemRun run = run_case(what, press_of(kDepth_m, 10));
  const CaseError error = force_error(run.rows, fem_cylinder_force_N(kPoisson));
  table.rows.push_back(
      {std::string(name), fmt::format("{}", options.element_size),
       fmt::format("{}", options.coarse_ratio), fmt::format("{}", options.equilibrium.residual),
       fmt::format("{}", run.rows.cost.nodes), fmt::format("{:.3f}", run.cpu_s),
       fmt::format("{:.3f}", 100 * error.mean), fmt::format("{:+.3f}", 100 * error.worst)});
}

}  // namespace

BenchTable fem_speed(const BenchRequest& request) {
  BenchTable table{
      {"series", "size", "coarse", "residual", "nodes", "CPU_s", "mean_percent", "worst_percent"},
      {}};
  const fem::SolverOptions shipped = fem_cylinder(kPoisson).setup.options;
  for (const SpeedSeries& each : kBySize)
    for (const double size : kSizes) {
      if (request.is_quick && size < 1) continue;
      fem::SolverOptions options = shipped;
      options.element_size = size;
      options.coarse_ratio = each.coarse_ratio;
      options.growth = std::min(size, 1 / std::max(1.0, each.coarse_ratio));
      add(each.name, options, table);
    }
  for (const double residual : kResiduals) {
    if (request.is_quick && residual < 0.1) continue;
    fem::SolverOptions options = shipped;
    options.equilibrium.residual = residual;
    add("residual, two meshes", options, table);
  }
  return table;
}

}  // namespace palpate::tools
