#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace palpate::testing_support {

inline constexpr int kWayRows = 400;  // of the way in, and of the way back

/// Tip travel and force of row i of 2 kWayRows: a Hertz press of a 5 mm ball on 2 kPa after 1 mm of
/// free travel, and the way back.
inline double press_travel_m(int i) {
  return (i < kWayRows ? i : 2 * kWayRows - 1 - i) * (2e-3 / kWayRows);
}
inline double press_force_N(int i) {
  const double depth_m = std::max(0.0, press_travel_m(i) - 1e-3);
  return 16.0 / 9.0 * 2000 * std::sqrt(5e-3) * depth_m * std::sqrt(depth_m);
}

/// A MATLAB file of version 5: time `t_s` and matrix `M` of depth in mm and force in N (on the
/// body).
inline std::string matlab_file() {
  std::string bytes = "MATLAB 5.0 MAT-file, made by a test";
  bytes.resize(124, ' ');
  bytes += std::string("\x00\x01", 2) + "IM";
  const auto add = [](std::string& to, std::uint32_t kind, const void* data, std::size_t size) {
    const std::uint32_t tag[] = {kind, static_cast<std::uint32_t>(size)};
    to.append(reinterpret_cast<const char*>(tag), sizeof tag);
    to.append(static_cast<const char*>(data), size);
    to.resize((to.size() + 7) / 8 * 8, '\0');
  };
  const auto add_matrix = [&](const std::string& name, std::int32_t columns,
                              const std::vector<double>& values) {
    const std::uint32_t flags[] = {6, 0};
    const std::int32_t sizes[] = {static_cast<std::int32_t>(values.size()) / columns, columns};
    std::string body;
    add(body, 6, flags, sizeof flags), add(body, 5, sizes, sizeof sizes);
    add(body, 1, name.data(), name.size());
    add(body, 9, values.data(), values.size() * sizeof(double));
    add(bytes, 14, body.data(), body.size());
  };
  std::vector<double> time, matrix;
  for (int i = 0; i < 2 * kWayRows; ++i) time.push_back(0.0025 * i);
  for (int i = 0; i < 2 * kWayRows; ++i) matrix.push_back(1e3 * press_travel_m(i));
  for (int i = 0; i < 2 * kWayRows; ++i) matrix.push_back(press_force_N(i));
  add_matrix("t_s", 1, time), add_matrix("M", 2, matrix);
  return bytes;
}

}  // namespace palpate::testing_support
