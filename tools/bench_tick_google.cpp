// The engine's ticks under Google Benchmark: cmake -DPALPATE_BENCHMARKS=ON, then bench_tick_google.
// `palpate bench tick` has the percentiles, cold caches and baselines.

#include <benchmark/benchmark.h>

#include <string>

#include "tools/finger_proxy.hpp"
#include "tools/tick_work.hpp"

namespace palpate::tools {
namespace {

void engine(benchmark::State& state, const BenchAsset& body, const TickKind& kind) {
  runtime::Contact contact;
  runtime::Output out;
  const Vec3 outside = kind.tip(0) * 1.2;
  runtime::touch(body.asset, contact, outside.data(), out);
  long tick = 0;
  for ([[maybe_unused]] auto each : state) {
    const Vec3 tip = kind.tip(tick++);
    runtime::touch(body.asset, contact, tip.data(), out);
    benchmark::DoNotOptimize(out);
  }
}

void proxy(benchmark::State& state, const BenchAsset& body, const TickKind& kind) {
  FingerProxy finger(body.asset, 400, 0.3);
  const Vec3 outside = kind.tip(0) * 1.2;
  finger.tick(outside.data());
  long tick = 0;
  for ([[maybe_unused]] auto each : state) {
    const Vec3 tip = kind.tip(tick++);
    benchmark::DoNotOptimize(finger.tick(tip.data()));
  }
}

}  // namespace
}  // namespace palpate::tools

int main(int argc, char** argv) {
  using namespace palpate::tools;
  benchmark::Initialize(&argc, argv);
  const BenchAsset body = make_bench_asset(bench_cylinder(150, 66));
  for (const TickKind& kind : kTicksOfKind) {
    const std::string name(kind.name);
    benchmark::RegisterBenchmark(("engine/" + name).c_str(),
                                 [&](benchmark::State& state) { engine(state, body, kind); });
    benchmark::RegisterBenchmark(("finger_proxy/" + name).c_str(),
                                 [&](benchmark::State& state) { proxy(state, body, kind); });
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
