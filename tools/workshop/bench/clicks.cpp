#include "tools/workshop/bench/clicks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libfit/core/statistics.hpp"
#include "libfit/io/csv/csv.hpp"
#include "tests/support/bodies.hpp"
#include "tools/console.hpp"
#include "tools/workshop/bench/bench.hpp"

namespace palpate::tools {
namespace {

constexpr double kSpeed_m_s = 0.05, kRate_Hz = 1000, kForce_N = 0.9;
constexpr int kTicks = 1024;  // about 50 mm

// Where the tip is: on a helix, as deep as the force needs, coming down within the first 200 ticks.
Vec3 tip_at(int tick, double slope, double start_angle) {
  const double way = std::max(tick, 0) * kSpeed_m_s / kRate_Hz;
  const double angle = start_angle + std::cos(slope) * way / kCylinderRadius_m;
  const double z = 0.025 + std::sin(slope) * way;
  const double k = cylinder_stiffness_N_m({std::cos(angle), std::sin(angle), z});
  const double depth =
      std::sqrt(kForce_N * 0.01 / k) * std::min(1.0, 1 + tick / 200.0) - (tick < -199 ? 1e-3 : 0);
  const double r = kCylinderRadius_m - depth;
  return {r * std::cos(angle), r * std::sin(angle), z};
}

// RMS between `from` and half the rate, of a Hann-windowed signal (the window's power taken out).
double band_rms(const std::vector<double>& signal, double from_Hz) {
  const std::size_t n = signal.size();
  double mean = 0, power = 0;
  for (double x : signal) mean += x / static_cast<double>(n);
  const auto first =
      static_cast<std::size_t>(std::ceil(from_Hz / kRate_Hz * static_cast<double>(n)));
  for (std::size_t f = first; f < n / 2; ++f) {
    double re = 0, im = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double turn = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
      const double windowed = (signal[i] - mean) * 0.5 * (1 - std::cos(turn));
      re += windowed * std::cos(turn * static_cast<double>(f));
      im += windowed * std::sin(turn * static_cast<double>(f));
    }
    power += 2 * (re * re + im * im) / (static_cast<double>(n * n) * 0.375);
  }
  return std::sqrt(power);
}

bool is_ridge(const runtime::AssetView& asset, int from, int to) {
  if (from < 0 || to < 0) return false;
  const auto a = runtime::normalized(asset.area_vector(from)),
             b = runtime::normalized(asset.area_vector(to));
  return dot(a, b) < 1 - 1e-6;
}

ClickResult measure(const runtime::AssetView& asset, const ClickCase& what, int tracks) {
  ClickResult out;
  out.name = what.name;
  std::vector<double> jumps, ridges, ordinary;
  double squares = 0;
  for (int track = 0; track < tracks; ++track) {
    const double slope = 0.5 * std::numbers::pi * (track + 0.5) / tracks,
                 start = 0.31 + 2.4 * track;
    AblatedTip tip(asset, what.ablation);
    std::vector<double> force;
    runtime::Vec3d before{0, 0, 0};
    int triangle = -1;
    for (int tick = -201; tick < kTicks; ++tick) {
      const Vec3 x = tip_at(tick, slope, start);
      const runtime::Vec3d f = tip.tick(x.data()), change = f - before;
      const double size_N = std::sqrt(dot(change, change));
      const bool crosses = tick > 0 && tip.triangle() != triangle;
      if (tick > 0) (crosses ? jumps : ordinary).push_back(size_N);
      if (crosses && is_ridge(asset, triangle, tip.triangle())) ridges.push_back(size_N);
      if (tick >= 0) force.push_back(std::sqrt(dot(f, f)));
      triangle = tip.triangle();
      before = f;
    }
    const double rms = band_rms(force, 100);
    squares += rms * rms / tracks;
  }
  out.crossings = static_cast<int>(jumps.size());
  out.median_jump_N = quantile(jumps, 0.5);
  for (double jump : jumps) out.mean_jump_N += jump / static_cast<double>(jumps.size());
  out.median_ridge_N = quantile(ridges, 0.5);
  out.p95_jump_N = quantile(jumps, 0.95);
  out.max_jump_N = quantile(jumps, 1);
  out.ordinary_N = quantile(ordinary, 0.5);
  out.band_rms_N = std::sqrt(squares);
  return out;
}

void write_table(const std::filesystem::path& path, const std::vector<ClickResult>& results) {
  static constexpr std::string_view kHeader[] = {
      "case",       "crossings",  "median_jump_N",   "mean_jump_N", "median_ridge_jump_N",
      "p95_jump_N", "max_jump_N", "ordinary_tick_N", "band_rms_N",  "click_index"};
  CsvWriter csv(path, kHeader);
  for (const ClickResult& r : results)
    csv.text(r.name)
        .integer(r.crossings)
        .number(r.median_jump_N)
        .number(r.mean_jump_N)
        .number(r.median_ridge_N)
        .number(r.p95_jump_N)
        .number(r.max_jump_N)
        .number(r.ordinary_N)
        .number(r.band_rms_N)
        .number(r.click_index)
        .end_row();
  csv.commit();
}

}  // namespace

std::vector<ClickResult> measure_clicks(int tracks) {
  std::vector<ClickResult> results;
  for (const ClickCase& what : kClickCases) {
    const BenchAsset body = make_bench_asset(bench_cylinder(25, 10, 12, what.scatter));
    results.push_back(measure(body.asset, what, tracks));
    results.back().click_index = results.back().band_rms_N / results.front().band_rms_N;
  }
  return results;
}

void bench_clicks(const BenchRequest& request) {
  const auto results = measure_clicks(request.is_quick ? 4 : 24);
  write_table(request.folder / "clicks.csv", results);
  for (const ClickResult& r : results)
    say("{:30} {:4} crossings, median jump {:6.1f} mN, mean {:6.1f}, at ridges {:6.1f}, p95 "
        "{:6.1f}, max "
        "{:6.1f}, ordinary tick {:5.1f} mN, click index {:.1f}",
        r.name, r.crossings, 1e3 * r.median_jump_N, 1e3 * r.mean_jump_N, 1e3 * r.median_ridge_N,
        1e3 * r.p95_jump_N, 1e3 * r.max_jump_N, 1e3 * r.ordinary_N, r.click_index);
  say("wrote {}", (request.folder / "clicks.csv").string());
}

}  // namespace palpate::tools
