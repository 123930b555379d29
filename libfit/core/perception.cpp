#include "libfit/core/perception.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <cassert>
#include <numbers>
#include <string_view>

#include "libfit/core/geometry.hpp"
#include "libfit/core/units.hpp"

namespace palpate {

extern const char* const kPerceptionToml;  // generated from data/perception.toml

namespace {

std::vector<Threshold> read_thresholds() {
  const toml::table parsed =
      toml::parse(std::string_view(kPerceptionToml), std::string_view("data/perception.toml"));
  std::vector<Threshold> rows;
  for (const toml::node& node : *parsed["threshold"].as_array()) {
    const toml::table& row = *node.as_table();
    const auto text = [&](const char* key) { return row[key].value_or(std::string()); };
    const auto quantity = [&](const char* key, Dimension dimension) {
      return parse_quantity(text(key), dimension).value_or(kNan);
    };
    rows.push_back({text("name"), row["share"].value_or(kNan), quantity("least", Dimension::force),
                    quantity("angle", Dimension::angle) * 180 / std::numbers::pi, text("condition"),
                    text("source"), text("doi")});
  }
  return rows;
}

const Threshold& row_of(std::string_view name) {
  const auto found = std::ranges::find(thresholds(), name, &Threshold::name);
  assert(found != thresholds().end());
  return *found;
}

}  // namespace

const std::vector<Threshold>& thresholds() {
  static const std::vector<Threshold> rows = read_thresholds();
  return rows;
}

const Perception& perception() {
  static const Perception numbers{row_of("force").share, row_of("force-in-motion").share,
                                  row_of("force").least_N, row_of("direction").angle_deg,
                                  row_of("torque").share};
  return numbers;
}

bool is_within_threshold(double error_N, double force_N, bool is_in_motion) {
  const Perception& known = perception();
  const double share = is_in_motion ? known.force_in_motion : known.force_at_rest;
  return error_N <= std::max(known.force_floor_N, share * force_N);
}

}  // namespace palpate
