#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "libfit/recordings/batch/batch.hpp"

// Presses of a sphere on an elastic half-space as a rig would record them, and fourteen ways in
// which a recording goes wrong. Everything follows from the number of the recording and a seed.
namespace palpate::testing_recordings {

struct BadWay {
  const char* name;
  const char* reason;  ///< piece of the reason that must be given
};
inline constexpr std::array<BadWay, 14> kBadWays{{
    {"missing column", "column `fz` is missing"},
    {"double column", "column `fz` comes twice"},
    {"repeated time", "the time stamp repeats"},
    {"not a number", "`nan` is not a number"},
    {"empty file", "is empty"},
    {"one sample", "has 1 sample"},
    {"no contact", "no contact"},
    {"reversed sign", "is reversed"},
    {"wrong unit", "is a unit wrong?"},
    {"saturated", "is saturated"},
    {"binary garbage", "is binary data"},
    {"not UTF-8", "is not UTF-8"},
    {"missing file", "no such file"},
    {"another point", "recording of another point"},
}};

struct Truth {
  double young_Pa = 0, contact_m = 0, depth_m = 4e-3;
  Vec3 position_m = Vec3::Zero();
  int bad = -1;  ///< index of kBadWays, or -1
};

constexpr double kRadius_m = 5e-3;

/// Every 20th recording is bad, in turn in every way.
inline Truth truth_of(int number, unsigned seed) {
  std::mt19937 random(seed + 7919u * static_cast<unsigned>(number));
  std::uniform_real_distribution<double> unit(0, 1);
  Truth truth;
  truth.young_Pa = 5e3 + 15e3 * unit(random);
  truth.position_m = Vec3(0.01 * (number % 100), 0.01 * (number / 100), 0.02 + 1e-3 * unit(random));
  if (number % 20 == 7) truth.bad = (number / 20) % static_cast<int>(kBadWays.size());
  return truth;
}

/// Force of a Hertz contact at a depth.
inline double hertz_N(double young_Pa, double depth_m) {
  return depth_m > 0 ? 4.0 / 3 * young_Pa / 0.75 * std::sqrt(kRadius_m) * std::pow(depth_m, 1.5)
                     : 0;
}

/// Writes recording `number` and says what is in it. In: 2 mm above, down at 5 mm/s, up again, 200
/// Hz; sensor on the tool, in N, with 20 mN bias and noise; position in mm.
inline Truth write_recording(const std::filesystem::path& file, int number, unsigned seed,
                             double noise_N = 2e-3) {
  const Truth truth = truth_of(number, seed);
  const std::string bad = truth.bad < 0 ? "" : kBadWays[static_cast<std::size_t>(truth.bad)].name;
  if (bad == "missing file") return truth;
  std::mt19937 random(seed ^ (104729u * static_cast<unsigned>(number + 1)));
  std::normal_distribution<double> noise(0, noise_N);
  std::string text = bad == "missing column"  ? "t,x,y,z,fx,fy\n"
                     : bad == "double column" ? "t,x,y,z,fx,fy,fz,fz\n"
                                              : "t,x,y,z,fx,fy,fz\n";
  if (bad == "empty file") text.clear();
  char line[160];
  const int in_rows = 240, rows = bad == "empty file" ? 0 : bad == "one sample" ? 1 : 2 * in_rows;
  const double limit_N = 0.05 * hertz_N(truth.young_Pa, truth.depth_m);
  for (int i = 0; i < rows; ++i) {
    const double t = 0.005 * i, below_m = 5e-3 * 0.005 * (i < in_rows ? i : 2 * in_rows - i) - 2e-3;
    double push_N =
        bad == "no contact" ? 0 : hertz_N(truth.young_Pa, below_m * (truth.depth_m / 4e-3));
    if (bad == "saturated") push_N = std::min(push_N, limit_N);
    double fz_N = push_N + 0.02 +
                  (bad == "saturated" && push_N >= limit_N ? 0 : noise(random));  // on the tool: up
    if (bad == "reversed sign") fz_N = -fz_N;
    if (bad == "wrong unit") fz_N *= 1000;
    const double off_mm = bad == "another point" ? 20 : 0;
    const Vec3 tip_mm = 1e3 * (truth.position_m - Vec3(0, 0, below_m)) + Vec3(off_mm, 0, 0);
    const double written_t = bad == "repeated time" && i == 100 ? 0.005 * 99 : t;
    const int fields =
        std::snprintf(line, sizeof line, "%.4f,%.5f,%.5f,%.5f,%.5f,%.5f,%.6f\n", written_t,
                      tip_mm.x(), tip_mm.y(), tip_mm.z(), noise(random), noise(random), fz_N);
    std::string row(line, static_cast<std::size_t>(fields));
    if (bad == "missing column") row = row.substr(0, row.rfind(',')) + "\n";
    if (bad == "not a number" && i == 150) row = row.substr(0, row.rfind(',')) + ",nan\n";
    if (bad == "not UTF-8" && i == 20) row = "# \xb5m\n" + row;
    text += row;
  }
  if (bad == "binary garbage")
    for (char& c : text) c = static_cast<char>(random());
  std::ofstream(file, std::ios::binary) << text;
  return truth;
}

inline recordings::BatchItem item_of(const std::filesystem::path& folder, int number,
                                     unsigned seed) {
  recordings::BatchItem item;
  char name[32];
  std::snprintf(name, sizeof name, "r%05d.csv", number);
  item.shown = name;
  item.file = folder / name;
  item.position_m = truth_of(number, seed).position_m;
  item.normal = Vec3(0, 0, -1);
  item.read.columns.time = "t";
  item.read.columns.position = {"x", "y", "z"};
  item.read.columns.force = {"fx", "fy", "fz"};
  item.read.units = {"s", "mm", "N"};
  item.read.is_force_on_tool = true;
  item.signal.radius_m = kRadius_m;
  return item;
}

}  // namespace palpate::testing_recordings
