#pragma once

// Inputs to begin from: what the engine meets when nobody is hostile.

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "libfit/io/atomic_file.hpp"

namespace palpate::fuzz {

using Bytes = std::vector<unsigned char>;

/// A golden asset, as a file.
inline Bytes asset_seed(const std::string& golden_folder) {
  const std::string file = read_whole_file(golden_folder + "/version_1.palp");
  return {file.begin(), file.end()};
}

/// A program of fuzz_ticks.cpp that presses, circles and lifts; `kind` varies the place and the
/// tool.
inline Bytes ticks_seed(int kind) {
  Bytes out;
  const auto put16 = [&](double x_m) {
    const auto value = static_cast<std::int16_t>(std::lround(x_m / 2e-6));
    out.push_back(static_cast<unsigned char>(value & 255));
    out.push_back(static_cast<unsigned char>((value >> 8) & 255));
  };
  for (int byte : {kind, 3, kind, kind / 2}) out.push_back(static_cast<unsigned char>(byte));
  for (int i = 0; i < 200; ++i) {
    const double t = 0.05 * i, r = 0.034 - 0.006 * std::sin(0.3 * t + kind), a = 0.4 * t + kind;
    out.push_back(4);
    put16(r * std::cos(a) * 0.8);
    put16(r * std::sin(a) * 0.8);
    put16(r * 0.6);
  }
  return out;
}

}  // namespace palpate::fuzz
