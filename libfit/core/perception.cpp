#include "libfit/core/perception.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <numbers>
#include <string>

#include "libfit/core/units.hpp"

namespace palpate {

extern const char* const kPerceptionToml;  // generated from data/perception.toml

namespace {

Perception read_table() {
  const toml::table table =
      toml::parse(std::string_view(kPerceptionToml), std::string_view("data/perception.toml"));
  const auto share = [&](const char* name) { return table[name]["share"].value<double>().value(); };
  const auto quantity = [&](const char* name, const char* key, Dimension dimension) {
    return parse_quantity(table[name][key].value<std::string>().value(), dimension).value();
  };
  return {share("force"), share("force-in-motion"), quantity("force", "least", Dimension::force),
          quantity("direction", "angle", Dimension::angle) * 180 / std::numbers::pi,
          share("torque")};
}

}  // namespace

const Perception& perception() {
  static const Perception numbers = read_table();
  return numbers;
}

bool is_within_threshold(double error_N, double force_N) {
  return error_N <= std::max(perception().force_floor_N, perception().force_at_rest * force_N);
}

}  // namespace palpate
