#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "libfit/recordings/batch/batch.hpp"
#include "tests/support/shared_data.hpp"

// The recordings of the shared cases: six force curves under eight models of noise, t_s, pos_mm,
// force_N; 1 mm free, 8 mm in contact, and back.
namespace palpate::testing_recordings {

inline const std::filesystem::path kCases = testing_support::shared_data("cases/curves");
inline constexpr std::array<const char*, 6> kCaseTruths{"T1_cubic", "T3_toe_linear", "T5_hertz",
                                                        "T6_soft",  "T8_paper_eq6",  "T9_snap"};
inline constexpr std::array<const char*, 8> kCaseNoises{
    "N0", "N1_gauss", "N2_drift", "N3_outlier", "N4_quant", "N5_offset", "N6_hyst", "N7_all"};

inline std::filesystem::path case_file(const std::string& truth, const std::string& noise) {
  return kCases / (truth + "__" + noise + ".csv");
}

inline std::vector<std::vector<double>> case_rows(const std::string& truth,
                                                  const std::string& noise) {
  return testing_support::number_rows(case_file(truth, noise));
}

/// True contact in the travel of the recording: the clean one touches at 0, and begins elsewhere.
inline double case_contact_m(const std::string& truth, const std::string& noise) {
  return 1e-3 * (case_rows(truth, noise)[0][1] - case_rows(truth, "N0")[0][1]);
}

inline recordings::BatchItem case_item(const std::string& truth, const std::string& noise) {
  recordings::BatchItem item;
  item.file = case_file(truth, noise);
  item.shown = item.file.filename().string();
  item.position_m = Vec3::Zero();
  item.normal = Vec3(0, 0, -1);
  item.read.columns.time = "t_s";
  item.read.columns.depth = "pos_mm";
  item.read.columns.force = {"force_N"};
  item.read.units = {"s", "mm", "N"};
  item.read.is_force_on_tool = false;
  return item;
}

/// The exact curve pressed from 1 mm above, contact at travel 0, with white noise of a share of
/// its largest force.
inline importers::RawRecording noisy_press(const std::string& truth, double share, unsigned seed) {
  const auto exact = case_rows(truth, "TRUTH");
  double full_N = 0;
  for (const auto& row : exact) full_N = std::max(full_N, row[1]);
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, share * full_N);
  importers::RawRecording raw;
  for (std::size_t i = 0; i <= 200; ++i) {
    const double d_mm = -1 + 0.045 * static_cast<double>(i);
    const double at = std::max(0.0, d_mm) / 0.02;  // rows are 0.02 mm apart
    const std::size_t k = std::min(static_cast<std::size_t>(at), exact.size() - 2);
    const double t = at - static_cast<double>(k);
    raw.time_s.push_back(0.01 * static_cast<double>(i));
    raw.line.push_back(i + 2);
    raw.travel_m.push_back(1e-3 * d_mm);
    raw.push_N.push_back((1 - t) * exact[k][1] + t * exact[k + 1][1] + noise(random));
  }
  return raw;
}

}  // namespace palpate::testing_recordings
