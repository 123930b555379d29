#include <fmt/core.h>

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

#include "tools/console.hpp"
#include "tools/workshop/bench/fem.hpp"

namespace palpate::tools {
namespace {

constexpr double kDepth_m = 0.01;  // of every press of these parts: the ball's radius

std::string percent(double share) { return fmt::format("{:+.2f}", 100 * share); }
std::string seconds(double s) { return fmt::format("{:.2f}", s); }

fem::Experiments point_experiments(double radius_m, double depth_m) {
  fem::Experiments out = press_of(depth_m, 10);
  out.drag_depths_m = {0.3 * depth_m, 0.6 * depth_m, 0.9 * depth_m};
  out.drag_distance_m = 0.8 * radius_m;
  out.drag_directions = 2;
  out.drag_steps = 6;
  return out;
}

struct SolverChoice {
  std::string_view name;
  void (*apply)(fem::SolverOptions& options);
};
constexpr SolverChoice kChoices[] = {
    // The textbook's solver: a factor for every iteration.
    {"plain: a factor per iteration",
     [](fem::SolverOptions& o) {
       o.equilibrium.patience = 1;
       o.equilibrium.stale = 0;
       o.equilibrium.mixing = 0;
       o.equilibrium.max_astray = o.equilibrium.max_newton;
     }},
    {"shipped: stale factor, mixing", [](fem::SolverOptions&) {}},
    {"no mixing", [](fem::SolverOptions& o) { o.equilibrium.mixing = 0; }},
    {"no Uzawa update", [](fem::SolverOptions& o) { o.uzawa_update = false; }},
};

void add_choices(const std::string& experiment, FemCase what, const fem::Experiments& experiments,
                 std::size_t choices, double poisson, BenchTable& table) {
  what.setup.options.coarse_ratio = 0;
  FemRun plain;
  for (std::size_t c = 0; c < choices; ++c) {
    FemCase here = what;
    kChoices[c].apply(here.setup.options);
    const FemRun run = run_case(here, experiments);
    if (c == 0) plain = run;
    const auto bad = run.rows.rows() - std::ranges::count(run.rows.status, RowStatus::good);
    const fem::SolverCounts& n = run.rows.cost.solver;
    say("  {}, {}, {}: {:.2f} s", experiment, poisson, kChoices[c].name, run.cpu_s);
    table.rows.push_back({experiment, fmt::format("{}", poisson), std::string(kChoices[c].name),
                          fmt::format("{}", run.rows.cost.nodes), seconds(run.cpu_s),
                          fmt::format("{:.2f}", plain.cpu_s / run.cpu_s),
                          fmt::format("{:.3f}", 100 * greatest_difference(run.rows, plain.rows)),
                          fmt::format("{}", n.newton), fmt::format("{}", n.model),
                          fmt::format("{}", n.factorizations), fmt::format("{}", bad)});
  }
}

}  // namespace

BenchTable fem_solver(const BenchRequest& request) {
  BenchTable table{{"experiment", "poisson", "solver", "nodes", "CPU_s", "plain/this",
                    "force_differs_percent", "newton", "model", "factors", "bad_rows"},
                   {}};
  for (const double poisson : {0.45, 0.49, 0.499}) {
    if (request.is_quick && poisson > 0.45) break;
    add_choices("press", fem_block(poisson), press_of(kDepth_m, 10),
                poisson > 0.45 || request.is_quick ? 2 : std::size(kChoices), poisson, table);
  }
  if (request.is_quick) return table;
  fem::Experiments drag = press_of(0.006, 4);
  drag.drag_depths_m = {0.006};
  drag.drag_distance_m = 0.008;
  drag.drag_directions = 1;
  drag.drag_steps = 4;
  add_choices("drag", fem_block(0.45, 0.3), drag, 2, 0.45, table);
  return table;
}

BenchTable fem_uniform(const BenchRequest& request) {
  BenchTable table{{"mesh", "nodes", "rows", "CPU_s", "uniform/this", "force_N", "factors"}, {}};
  const double size_m = request.is_quick ? 0.01 : 0.004;
  const auto cells = [&](double edge) { return static_cast<int>(std::lround(edge / size_m)); };
  FemCase uniform = fem_block(0.45, 0, {cells(0.1), cells(0.1), cells(0.04)}),
          graded = fem_block(0.45);
  const double depth_m = 0.002;
  const fem::Probe probe = fem::make_probe(graded.setup.probe, "bench");
  for (FemCase* what : {&uniform, &graded}) {
    what->setup.options.coarse_ratio = 0;
    what->setup.options.shallowest = 1;
    what->setup.options.element_size = size_m / probe.mesh_length_m(depth_m);
  }
  uniform.setup.options.element_size = 1e3;  // nothing is bisected
  double uniform_s = 0;
  for (const FemCase* what : {&uniform, &graded}) {
    const FemRun run = run_case(*what, press_of(depth_m, 2));
    if (what == &uniform) uniform_s = run.cpu_s;
    table.rows.push_back({what == &uniform ? "uniform" : "graded",
                          fmt::format("{}", run.rows.cost.nodes),
                          fmt::format("{}", run.rows.rows()), seconds(run.cpu_s),
                          fmt::format("{:.1f}", uniform_s / run.cpu_s),
                          fmt::format("{:.5f}", run.rows.force.row(run.rows.rows() - 1).norm()),
                          fmt::format("{}", run.rows.cost.solver.factorizations)});
  }
  return table;
}

BenchTable fem_accuracy(const BenchRequest& request) {
  constexpr double kReferenceError = 0.003;
  BenchTable table{{"size", "coarse", "poisson", "nodes", "coarse_nodes", "CPU_s", "worst_percent",
                    "mean_percent", "worst_bound_percent", "rows_bounded"},
                   {}};
  struct PressCase {
    double size, coarse;
  };
  std::vector<PressCase> choices{{0.6, 1.6}};
  if (!request.is_quick) {
    choices.push_back({0.8, 1.25});  // too coarse to be bounded
    choices.push_back({0.5, 1.6});
    for (const double size : {1.0, 0.8, 0.6}) choices.push_back({size, 0});
  }
  for (const double poisson : {0.45, 0.49})
    for (const PressCase& choice : choices) {
      FemCase what = fem_cylinder(poisson);
      what.setup.options.element_size = what.setup.options.growth = choice.size;
      what.setup.options.coarse_ratio = choice.coarse;
      const FemRun run = run_case(what, press_of(kDepth_m, 10));
      const std::vector<double> exact_N = fem_cylinder_force_N(poisson);
      const CaseError error = force_error(run.rows, exact_N);
      double bound = 0;
      std::size_t bounded = 0;
      for (Eigen::Index i = 0; i < run.rows.rows(); ++i) {
        const double force_N = run.rows.force.row(i).norm(),
                     stated = run.rows.force_error[i] / force_N;
        bound = std::max(bound, stated);
        bounded += std::abs(force_N / exact_N[i] - 1) <= stated + kReferenceError;
      }
      table.rows.push_back(
          {fmt::format("{}", choice.size), fmt::format("{}", choice.coarse),
           fmt::format("{}", poisson), fmt::format("{}", run.rows.cost.nodes),
           fmt::format("{}", run.rows.cost.coarse_nodes), seconds(run.cpu_s), percent(error.worst),
           fmt::format("{:.2f}", 100 * error.mean),
           choice.coarse > 0 ? fmt::format("{:.2f}", 100 * bound) : "-",
           choice.coarse > 0 ? fmt::format("{} of {}", bounded, run.rows.rows()) : "-"});
    }
  return table;
}

BenchTable fem_bodies(const BenchRequest& request) {
  BenchTable table{{"body", "poisson", "experiments", "depth_mm", "rows", "bad_rows", "nodes",
                    "coarse_nodes", "CPU_s", "median_bound_percent"},
                   {}};
  const auto add = [&](const std::string& body, double poisson, const std::string& kind,
                       const FemCase& what, const fem::Experiments& experiments) {
    const FemRun run = run_case(what, experiments);
    std::vector<double> bounds;
    for (Eigen::Index row = 0; row < run.rows.rows(); ++row)
      if (run.rows.status[row] == RowStatus::good)
        bounds.push_back(run.rows.force_error[row] / run.rows.force.row(row).norm());
    std::sort(bounds.begin(), bounds.end());
    std::vector<std::string> line{
        body,
        fmt::format("{}", poisson),
        kind,
        fmt::format("{:.1f}", 1e3 * experiments.depth_m),
        fmt::format("{}", run.rows.rows()),
        fmt::format("{}", run.rows.rows() - bounds.size()),
        fmt::format("{}", run.rows.cost.nodes),
        fmt::format("{}", run.rows.cost.coarse_nodes),
        seconds(run.cpu_s),
        bounds.empty() ? "-" : fmt::format("{:.2f}", 100 * bounds[bounds.size() / 2])};
    table.rows.push_back(line);
    say("  {} {} {}: {:.2f} s", body, poisson, kind, run.cpu_s);
  };
  for (const double poisson : {0.45, 0.49}) {
    for (const double depth_m : {0.5 * kDepth_m, kDepth_m})
      add("block", poisson, "press", fem_block(poisson), press_of(depth_m, 10));
    add("cylinder", poisson, "press", fem_cylinder(poisson), press_of(kDepth_m, 10));
    if (request.is_quick) return table;
  }
  const FemCase liver = fem_liver();
  add("liver", 0.45, "press", liver, press_of(0.007, 7));
  fem::Experiments scene = press_of(0.007, 7);
  scene.drag_depths_m = {0.003, 0.006};
  scene.drag_distance_m = 0.005;
  scene.drag_directions = 1;
  scene.drag_steps = 7;
  add("liver", 0.45, "its scene's point", liver, scene);
  add("block", 0.45, "press, 3 x 2 drags", fem_block(0.45, 0.3), point_experiments(0.01, 0.008));
  return table;
}

BenchTable fem_ripple(const BenchRequest& request) {
  // Local parabolas through 15 rows of F / d^(3/2), which for a ball is nearly constant.
  FemCase what = fem_block(0.45);
  what.setup.options.coarse_ratio = 0;
  const int steps = 50, first = 10;
  const FemRun run = run_case(what, press_of(0.005, request.is_quick ? 25 : steps));
  const fem::PointRows& rows = run.rows;
  std::vector<double> scaled;
  for (Eigen::Index row = 0; row < rows.rows(); ++row)
    scaled.push_back(rows.force.row(row).norm() / std::pow(rows.deflection.row(row).norm(), 1.5));
  double squares = 0, worst = 0;
  int count = 0;
  constexpr int kHalf = 7;
  for (std::size_t i = first; i < scaled.size(); ++i) {
    const auto begin = static_cast<std::size_t>(std::clamp<long>(
        static_cast<long>(i) - kHalf, first - 1, static_cast<long>(scaled.size()) - 2 * kHalf - 1));
    Eigen::Matrix<double, 2 * kHalf + 1, 3> A;
    Eigen::Matrix<double, 2 * kHalf + 1, 1> b;
    for (int k = 0; k <= 2 * kHalf; ++k) {
      const double t = static_cast<double>(begin) + k - static_cast<double>(i);
      A.row(k) << 1, t, t * t;
      b[k] = scaled[begin + static_cast<std::size_t>(k)];
    }
    const double smooth = (A.transpose() * A).inverse().row(0) * (A.transpose() * b);
    const double ripple = scaled[i] / smooth - 1;
    squares += ripple * ripple, ++count;
    worst = std::max(worst, std::abs(ripple));
  }
  return {{"body", "poisson", "rows", "nodes", "rms_percent", "max_percent", "CPU_s"},
          {{"block", "0.45", fmt::format("{}", count), fmt::format("{}", run.rows.cost.nodes),
            fmt::format("{:.3f}", 100 * std::sqrt(squares / count)),
            fmt::format("{:.3f}", 100 * worst), seconds(run.cpu_s)}}};
}

}  // namespace palpate::tools
