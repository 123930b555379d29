#pragma once

// Files of a press with a closed form, and manifests of them.

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/tools/command_line.hpp"

namespace palpate::tools::testing_support {

inline constexpr double kDepth_mm = 3, kFree_mm = 2;
inline constexpr unsigned kSeed = 65;

/// Force in N of a ball of 5 mm on an incompressible half-space.
inline double hertz_N(double depth_mm, double young_kPa) {
  return 4.0 / 3 * young_kPa * 1e3 / 0.75 * std::sqrt(5e-3) *
         std::pow(std::max(0.0, depth_mm) * 1e-3, 1.5);
}

/// A press and its way back as rows of time in s, depth in mm and force in N with 2 mN of noise.
inline std::vector<std::array<double, 3>> press(double young_kPa = 10) {
  std::mt19937 random(kSeed);
  std::normal_distribution<double> noise_N(0, 2e-3);
  std::vector<std::array<double, 3>> rows;
  for (int i = 0; i <= 500; ++i) {
    const double depth_mm = (kDepth_mm + kFree_mm) * (1 - std::abs(i - 250) / 250.0);
    rows.push_back({0.01 * i, depth_mm, hertz_N(depth_mm - kFree_mm, young_kPa) + noise_N(random)});
  }
  return rows;
}

inline std::string manifest(const std::string& file, const std::string& defaults,
                            const std::string& entry = "") {
  return fmt::format(R"([defaults]
force_on = "body"
probe = {{ shape = "sphere", radius = "5 mm" }}
{}
[[recording]]
file = "{}"
{}
)",
                     defaults, file, entry);
}

inline constexpr const char* kPlaced =
    "position = [\"0 mm\", \"0 mm\", \"0 mm\"]\nnormal = [0, 0, -1]\n";

inline std::string table(const std::string& header, const std::string& row_format,
                         double depth_factor = 1, double force_factor = 1) {
  std::string text = header + "\n";
  for (const auto& [t, d, f] : press())
    text += fmt::format(fmt::runtime(row_format), t, depth_factor * d, force_factor * f) + "\n";
  return text;
}

}  // namespace palpate::tools::testing_support
