#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace palpate::tools {

/// What a benchmark may be told.
struct BenchRequest {
  std::filesystem::path folder;  ///< where its tables and pictures go; made when missing
  int jobs = 0;
  std::string part = {};               ///< of a benchmark that has parts; empty: all of them
  std::filesystem::path samples = {};  ///< of a benchmark that fits some
  bool is_quick = false;  ///< a shorter version for tests: the same code, smaller sizes
};

/// A row of the table of benchmarks in main.cpp. run: writes its files and says what it found.
/// Throws Error when a file cannot be written.
struct Benchmark {
  std::string_view name, summary;
  void (*run)(const BenchRequest& request);
};

void bench_tick(const BenchRequest& request);
void bench_clicks(const BenchRequest& request);
void bench_fem(const BenchRequest& request);
void bench_peers(const BenchRequest& request);
void bench_refine(const BenchRequest& request);
void bench_fit(const BenchRequest& request);
void bench_curves(const BenchRequest& request);
void bench_laws(const BenchRequest& request);

}  // namespace palpate::tools
