// The engine's ticks under Google Benchmark: cmake -DPALPATE_BENCHMARKS=ON, then bench_tick_google.
// Rows are what/kind/nodes/cache; counters are percentiles of single ticks [ns].
// `palpate bench tick` measures the same with its floors and writes docs/bench/tick.csv.

#include <benchmark/benchmark.h>

#include <map>
#include <memory>

#include "tools/bench/finger_proxy.hpp"
#include "tools/bench/tick_timing.hpp"

namespace palpate::tools {
namespace {

struct GoogleSize {
  int around, along, pieces;
};
constexpr GoogleSize kSizes[] = {
    {25, 9, 12}, {75, 32, 12}, {150, 66, 12}, {480, 208, 12}, {1500, 666, 4}};
constexpr int kWarmTicks = 50000, kColdTicks = 200;

// One body at a time: the largest takes hundreds of megabytes.
const BenchAsset& body_of(int size) {
  static std::map<int, std::unique_ptr<BenchAsset>> bodies;
  if (bodies.count(size) == 0) {
    bodies.clear();
    const GoogleSize& s = kSizes[size];
    bodies[size] =
        std::make_unique<BenchAsset>(make_bench_asset(bench_cylinder(s.around, s.along, s.pieces)));
  }
  return *bodies[size];
}

template <class Tick>
void measure(benchmark::State& state, const TickKind& kind, bool is_cold, Tick tick) {
  static CacheFlush flush;
  const double overhead_ns = clock_ns();
  std::vector<double> all;
  for ([[maybe_unused]] auto each : state) {
    const auto ns = time_ticks(kind, is_cold ? kColdTicks : kWarmTicks, is_cold ? &flush : nullptr,
                               overhead_ns, tick);
    state.SetIterationTime(1e-9 * spread_of(ns).median_ns);
    all.insert(all.end(), ns.begin(), ns.end());
  }
  const Spread spread = spread_of(all);
  state.counters["p50_ns"] = spread.median_ns;
  state.counters["p99_ns"] = spread.p99_ns;
  state.counters["p99.9_ns"] = spread.p999_ns;
  state.counters["worst_ns"] = spread.worst_ns;
}

void engine(benchmark::State& state, int size, const TickKind& kind, bool is_cold) {
  const runtime::Asset& asset = body_of(size).asset;
  runtime::Contact contact;
  runtime::Output out;
  const Vec3 outside = kind.tip(0) * 1.2;
  runtime::touch(asset, contact, outside.data(), out);
  measure(state, kind, is_cold, [&](const Vec3& tip) {
    runtime::touch(asset, contact, tip.data(), out);
    benchmark::DoNotOptimize(out);
  });
}

void proxy(benchmark::State& state, int size, const TickKind& kind, bool is_cold) {
  FingerProxy finger(body_of(size).asset, 400, 0.3);
  const Vec3 outside = kind.tip(0) * 1.2;
  finger.tick(outside.data());
  measure(state, kind, is_cold,
          [&](const Vec3& tip) { benchmark::DoNotOptimize(finger.tick(tip.data())); });
}

void add_rows(const char* what, void (*run)(benchmark::State&, int, const TickKind&, bool)) {
  for (int size = 0; size < static_cast<int>(std::size(kSizes)); ++size)
    for (const TickKind& kind : kTicksOfKind)
      for (const bool is_cold : {false, true}) {
        const int nodes = kSizes[size].around * (kSizes[size].along + 1);
        const std::string name = std::string(what) + '/' + std::string(kind.name) + '/' +
                                 std::to_string(nodes) + (is_cold ? "/cold" : "/warm");
        benchmark::RegisterBenchmark(
            name.c_str(), [=](benchmark::State& state) { run(state, size, kind, is_cold); })
            ->UseManualTime()
            ->Iterations(1)
            ->Unit(benchmark::kNanosecond);
      }
}

}  // namespace
}  // namespace palpate::tools

int main(int argc, char** argv) {
  using namespace palpate::tools;
  benchmark::Initialize(&argc, argv);
  add_rows("engine", engine);
  add_rows("finger_proxy", proxy);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
