#include <fmt/core.h>

#include <chrono>
#include <cmath>
#include <random>

#include "libfit/fit/fit_curves.hpp"
#include "libfit/fit/spline/monotone_least_squares.hpp"
#include "libfit/io/csv/csv.hpp"
#include "tools/console.hpp"
#include "tools/workshop/bench/bench.hpp"
#include "tools/workshop/bench/machine.hpp"

namespace palpate::tools {
namespace {

constexpr double kDepth = 0.01, kFriction = 0.35;
constexpr int kPieces = 4;

// A press of `steps` rows and drags at two depths of `steps` rows each, F = k d (1 + 40 d), a
// hundredth of noise; k differs from point to point.
Samples bench_samples(int points, int steps) {
  const int rows = 3 * steps;
  Samples s;
  s.point_position.resize(points, 3);
  s.point_normal.resize(points, 3);
  s.deflection = Points::Zero(Eigen::Index{points} * rows, 3);
  s.force = Points::Zero(Eigen::Index{points} * rows, 3);
  s.torque = s.force;
  s.force_error = Eigen::VectorXd::Constant(s.force.rows(), 0.02);
  s.status.assign(static_cast<std::size_t>(s.force.rows()), RowStatus::good);
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.02);
  Eigen::Index at = 0;
  for (int p = 0; p < points; ++p) {
    s.point_position.row(p) << 1e-3 * p, 0, 0;
    s.point_normal.row(p) << 0, 0, 1;
    s.point_name.push_back(std::to_string(p));
    const double k = 250 + 50 * std::sin(0.1 * p);
    for (int e = 0; e < 3; ++e)
      for (int i = 0; i < steps; ++i, ++at) {
        const double share = (i + 1.0) / steps;
        const double depth = e == 0 ? kDepth * share : kDepth * (e == 1 ? 0.5 : 1.0);
        const double lateral = e == 0 ? 0 : 0.012 * share;
        const double push = k * depth * (1 + 40 * depth);
        s.deflection.row(at) << lateral, 0, depth;
        s.force.row(at) << std::min(0.7 * k * lateral, kFriction * push) + noise(random),
            noise(random), push + noise(random);
        s.point.push_back(p);
        s.experiment.push_back(3 * p + e);
        s.step.push_back(i);
        s.kind.push_back(e == 0 ? ExperimentKind::press : ExperimentKind::drag);
      }
  }
  return s;
}

FitOptions bench_options(int jobs) {
  FitOptions options{.family = CurveFamily::separable};
  options.pieces = {kPieces, kPieces, kPieces};
  for (auto& knots : options.knots_m)
    for (int i = 0; i <= kPieces; ++i) knots.push_back(kDepth * i / kPieces);
  options.jobs = jobs;
  return options;
}

// What a fit cannot do without: one bounded linear least squares per curve, rows of stick and slip
// told apart beforehand, nothing replayed, no outliers, no errors of the curves.
double plain_fit(const Samples& samples, int points, int steps) {
  const FitOptions options = bench_options(1);
  const CurveBasis basis{3, options.knots_m[0]};
  const Eigen::VectorXd lower = Eigen::VectorXd::Zero(basis.size() - 1);
  const fit::WeakPrior weak_prior = fit::smoothness_prior(basis);
  double sum = 0;
  for (int p = 0; p < points; ++p)
    for (int curve = 0; curve < kCurveKinds; ++curve) {
      std::vector<fit::CurveRow> rows;
      for (int i = 0; i < 3 * steps; ++i) {
        const Eigen::Index at = Eigen::Index{p} * 3 * steps + i;
        const double x = samples.deflection(at, 0), z = samples.deflection(at, 2);
        const bool is_drag = i >= steps, slips = x > 0.5 * kFriction * z * (1 + 40 * z) / 0.35;
        if (curve == 0) rows.push_back({z, samples.force(at, 2), 1, 0});
        if (curve == 1 && is_drag && !slips) rows.push_back({x, samples.force(at, 0), 1, 0});
        if (curve == 2 && is_drag && slips) rows.push_back({z, samples.force(at, 0), 1, 0});
      }
      sum += fit::fit_increments(basis, rows, lower, weak_prior, fit::FitLoss::squared).sum();
    }
  return sum;
}

volatile double kept;  // so that nothing is optimized away

struct FitTime {
  int curves = 0, rows = 0;  // rows of a point
  std::string what;
  double seconds = 0, cpu_seconds = 0, peak_MiB = 0;
};

template <class Act>
void measure(const std::string& what, int points, int rows, std::vector<FitTime>& lines, Act act) {
  forget_peak();
  const double cpu = cpu_seconds();
  const auto begin = std::chrono::steady_clock::now();
  act();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  lines.push_back(
      {kCurveKinds * points, rows, what, seconds.count(), cpu_seconds() - cpu, peak_MiB()});
  const FitTime& line = lines.back();
  say("{:8} curves, {:4} rows a point, {:22} {:8.0f} curves/s, {:8.0f} per CPU second, {:6.0f} MiB",
      line.curves, rows, what, line.curves / line.seconds, line.curves / line.cpu_seconds,
      line.peak_MiB);
}

void measure_all(int points, int steps, int jobs, std::vector<FitTime>& lines) {
  const Samples samples = bench_samples(points, steps);
  measure("bounded least squares", points, 3 * steps, lines,
          [&] { kept = plain_fit(samples, points, steps); });
  FittedCurves fitted;
  measure("fit", points, 3 * steps, lines,
          [&] { fitted = fit_curves(samples, bench_options(jobs)); });
  FitOptions warm = bench_options(jobs);
  warm.warm_start = &fitted;
  measure("fit on the same bases", points, 3 * steps, lines, [&] { fit_curves(samples, warm); });
}

void write_table(const std::filesystem::path& path, const std::vector<FitTime>& lines) {
  static constexpr std::string_view kHeader[] = {"curves",   "rows_per_point", "what",
                                                 "seconds",  "cpu_seconds",    "curves_per_s",
                                                 "peak_MiB", "machine"};
  const std::string processor = machine();
  CsvWriter csv(path, kHeader);
  for (const FitTime& line : lines)
    csv.integer(line.curves)
        .integer(line.rows)
        .text(line.what)
        .number(line.seconds)
        .number(line.cpu_seconds)
        .number(line.curves / line.seconds)
        .number(line.peak_MiB)
        .text(processor)
        .end_row();
  csv.commit();
}

}  // namespace

void bench_fit(const BenchRequest& request) {
  std::vector<FitTime> lines;
  for (const int steps : {4, 48, 192})
    measure_all(request.is_quick ? 10 : 100, steps, request.jobs, lines);
  for (const int points : {10, 100, 1000, 3334}) {
    if (request.is_quick && points > 100) break;
    measure_all(points, 12, request.jobs, lines);
  }
  if (!request.is_quick)
    for (const int steps : {4, 12}) measure_all(33334, steps, request.jobs, lines);
  write_table(request.folder / "fit.csv", lines);
  say("wrote {}", (request.folder / "fit.csv").string());
}

}  // namespace palpate::tools
