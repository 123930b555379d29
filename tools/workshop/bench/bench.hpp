#pragma once

#include <filesystem>
#include <string>

#include "tools/command.hpp"

namespace palpate::tools {

/// What a benchmark may be told.
struct BenchRequest {
  std::filesystem::path folder = {};  ///< where its tables and pictures go
  int jobs = 0;
  std::string part = {};                ///< of a benchmark that has parts; empty: all of them
  std::filesystem::path samples = {};   ///< of a benchmark that fits some
  std::filesystem::path run = {};       ///< folder of a run, of a benchmark that compares with one
  std::filesystem::path packages = {};  ///< folder of node_modules, of rivals
  bool is_quick = false;  ///< a shorter version for tests: the same code, smaller sizes
};

// The benchmarks, rows of main.cpp: each writes its files and says what it found. They throw Error
// when a file cannot be written.

void bench_tick(const BenchRequest& request);
void bench_clicks(const BenchRequest& request);
void bench_fem(const BenchRequest& request);
void bench_peers(const BenchRequest& request);
void bench_fit(const BenchRequest& request);
void bench_rivals(const BenchRequest& request);
void bench_laws(const BenchRequest& request);

extern const CommandRow kPredictCommand;

}  // namespace palpate::tools
