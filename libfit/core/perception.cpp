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

bool is_within_threshold(double error_N, double force_N, bool is_in_motion) {
  const Perception& known = perception();
  const double share = is_in_motion ? known.force_in_motion : known.force_at_rest;
  return error_N <= std::max(known.force_floor_N, share * force_N);
}

}  // namespace palpate
