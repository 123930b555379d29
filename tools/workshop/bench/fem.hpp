#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "libfem/solve/experiments/simulator.hpp"
#include "tools/workshop/bench/bench.hpp"

namespace palpate::tools {

/// A table of text: every row as long as the header.
struct BenchTable {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};

/// Prints it aligned on stdout and writes `fem_<name>.csv`.
void show_table(const BenchTable& table, std::string_view name, const BenchRequest& request);

// The parts of `bench fem` (kParts), each in less than two minutes of one core.
BenchTable fem_solver(const BenchRequest& request);
BenchTable fem_uniform(const BenchRequest& request);
BenchTable fem_accuracy(const BenchRequest& request);
BenchTable fem_bodies(const BenchRequest& request);
BenchTable fem_ripple(const BenchRequest& request);
BenchTable fem_threads(const BenchRequest& request);
BenchTable fem_speed(const BenchRequest& request);
BenchTable fem_rates(const BenchRequest& request);

/// A body, where it is pressed, and what with.
struct FemCase {
  fem::SimulationSetup setup;
  Vec3 place, normal;
};

/// 100 x 100 x 40 mm of 10 kPa held at its bottom; a ball of 10 mm over the middle of the top, off
/// every node. cells: bricks of the base mesh along x, y and z.
FemCase fem_block(double poisson, double friction = 0, std::array<int, 3> cells = {5, 5, 2});

/// Case AXI: a cylinder R 60, H 40 mm of 10 kPa held at its bottom, the ball of 10 mm on its axis.
FemCase fem_cylinder(double poisson, double friction = 0);
/// Its force at 1, 2 .. 10 mm [N] by an independent solution (axisymmetric Q2/P-1, good to 0.3 %);
/// empty for a Poisson's ratio that was not computed.
std::vector<double> fem_cylinder_force_N(double poisson);

/// The liver phantom of data/scenes/liver.toml below the working folder, with its own probe,
/// pressed at its first test point. Throws Error when the scene is not there.
FemCase fem_liver();

fem::Experiments press_of(double depth_m, int steps);

/// CPU time of the calling thread [s].
double thread_cpu_s();

/// What a run took and gave.
struct FemRun {
  fem::PointRows rows;
  double cpu_s = 0;
};
FemRun run_case(const FemCase& what, const fem::Experiments& experiments);

/// Largest difference of the forces of two runs over the force, over rows good in both.
double greatest_difference(const fem::PointRows& a, const fem::PointRows& b);
/// The same against given forces, and the mean of its absolute.
struct CaseError {
  double worst = 0, mean = 0;
};
CaseError force_error(const fem::PointRows& rows, const std::vector<double>& force_N);

}  // namespace palpate::tools
