// The keys of a scene in docs/formats/scene.md are those that the program reads, with their values
// and defaults. PALPATE_WRITE_DOCS=1 writes the tables anew.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <numbers>

#include "libfem/probes/probes.hpp"
#include "tests/support/generated_page.hpp"
#include "tools/scene/fields.hpp"

namespace palpate::tools {
namespace {

using testing_support::PageTable;

std::string code(std::string_view text) { return fmt::format("`{}`", text); }
std::string in_quotes(std::string_view text) { return fmt::format("`\"{}\"`", text); }

std::string_view name_of(Stage stage) {
  static constexpr std::string_view kNames[]{
      "prepare", "simulate", "surface motion", "placement", "fit", "validate", "none"};
  return kNames[static_cast<std::size_t>(stage)];
}

std::string may_be(const Length&) { return "length"; }
std::string may_be(const Speed&) { return "speeds"; }
std::string may_be(const Duration&) { return "time"; }
std::string may_be(const Pressure&) { return "pressure"; }
std::string may_be(const Tilt&) {
  return fmt::format("angle, to {:.0f} deg", kMostTilt_rad * 180 / std::numbers::pi);
}
std::string may_be(const Number& n) { return fmt::format("{:g} to {:g}", n.low, n.high); }
std::string may_be(const Whole& n) { return fmt::format("{} to {}", n.low, n.high); }
std::string may_be(const File&) { return "file"; }
std::string may_be(const MeshUnit&) { return "unit"; }
std::string may_be(const PointCount&) { return "number, word or file"; }
std::string may_be(const Choice& choice) {
  std::vector<std::string> names;
  for (const std::string_view name : choice.names) names.push_back(in_quotes(name));
  return fmt::format("{}", fmt::join(names, ", "));
}

// Lists the members of a section as rows: key, value, default, stage; the meaning is the page's.
class KeyLister {
 public:
  template <class Value, class Kind>
  void operator()(Stage stage, std::string_view key, const Value& value, const Kind& kind) {
    if constexpr (std::is_same_v<Kind, PointCount> && !std::is_same_v<Value, std::optional<int>>)
      return;  // what other words of test_points say
    else
      table_.rows.push_back({code(key), values_of(value, kind), default_of(value, kind),
                             std::string(name_of(stage)), std::nullopt});
  }
  const PageTable& table() const { return table_; }

 private:
  template <class Value, class Kind>
  static std::string values_of(const Value&, const Kind& kind) {
    if constexpr (!std::is_same_v<Kind, Any>)
      return (std::is_same_v<Value, std::vector<double>> && std::is_same_v<Kind, Length>)
                 ? "lengths"
                 : may_be(kind);
    else if constexpr (std::is_same_v<Value, bool>)
      return "`true`, `false`";
    else if constexpr (std::is_same_v<Value, std::vector<Region>>)
      return "regions";
    else if constexpr (std::is_same_v<Value, std::optional<Region>>)
      return "region";
    else
      static_assert(sizeof(Value) == 0, "say what it may be");
  }

  template <class Value, class Kind>
  static std::optional<std::string> default_of(const Value& value, const Kind&) {
    if constexpr (std::is_same_v<Kind, MeshUnit>)
      return "required";
    else if constexpr (std::is_same_v<Value, std::optional<int>>)
      return fmt::format("{}", *value);
    else if constexpr (requires { value.has_value(); })
      return value ? std::optional<std::string>() : "none";
    else if constexpr (std::is_same_v<Value, std::vector<Region>>)
      return "none";
    else if constexpr (std::is_same_v<Value, bool>)
      return code(value ? "true" : "false");
    else if constexpr (std::is_same_v<Value, std::string>)
      return in_quotes(value);
    else if constexpr (std::is_same_v<Kind, Speed>)
      return fmt::format("{:g} mm/s", fmt::join(in_thousandths(value), ", "));
    else if constexpr (std::is_same_v<Value, std::vector<double>>)
      return std::nullopt;  // filled in from other keys
    else if constexpr (std::is_same_v<Kind, Length>)
      return fmt::format("{:g} mm", 1e3 * value);
    else if constexpr (std::is_same_v<Kind, Pressure>)
      return fmt::format("{:g} Pa", value);
    else if constexpr (std::is_same_v<Kind, Duration>)
      return fmt::format("{:g} s", value);
    else
      return fmt::format("{}", value);
  }

  static std::vector<double> in_thousandths(std::vector<double> values) {
    for (double& value : values) value *= 1e3;
    return values;
  }

  PageTable table_{{"key", "value", "default", "stage", "meaning"}, {}};
};

template <class Section>
PageTable keys_of(const Section& section = {}) {
  KeyLister lister;
  visit(section, lister);
  return lister.table();
}

std::string key_text(const fem::ParameterRow& row) {
  std::string text = code(row.name);
  if (row.count > 1) text += fmt::format(" ({} numbers)", row.count);
  if (!row.unit.empty()) text += " (pressure)";
  if (!row.instead_of.empty()) return text;
  return text + (row.fallback == fem::kRequired ? std::string(", required")
                 : std::isnan(row.fallback)     ? std::string()
                                                : fmt::format(", {:g}", row.fallback));
}

PageTable laws() {
  PageTable table{{"law", "keys", "material"}, {}};
  for (const fem::LawRow& law : fem::material_laws()) {
    std::vector<std::string> keys;
    for (const fem::ParameterRow& row : law.parameters) keys.push_back(key_text(row));
    table.rows.push_back(
        {in_quotes(law.name), fmt::format("{}", fmt::join(keys, "; ")), std::string(law.summary)});
  }
  return table;
}

PageTable shapes() {
  PageTable table{{"shape", "keys", "probe"}, {}};
  for (const fem::ShapeRow& shape : fem::probe_shapes()) {
    std::vector<std::string> keys;
    if (shape.takes_mesh)
      keys = {"`mesh`: a file as `surface` of `[body]`, required", "`length_unit`, required"};
    for (const fem::ProbeParameter& row : shape.parameters)
      keys.push_back(fmt::format("{}: {}{}", code(fmt::format("{} = \"{}\"", row.key, row.example)),
                                 row.summary, row.is_required ? ", required" : ""));
    table.rows.push_back({in_quotes(shape.name), fmt::format("{}", fmt::join(keys, "; ")),
                          std::string(shape.summary)});
  }
  return table;
}

TEST(scene_page, lists_every_key_with_its_values_and_default) {
  testing_support::expect_tables("formats/scene.md",
                                 {{"laws", laws()},
                                  {"shapes", shapes()},
                                  {"[body]", keys_of<BodySection>()},
                                  {"[experiments]", keys_of<ExperimentsSection>()},
                                  {"placement", keys_of<PlacementSection>()},
                                  {"[fit]", keys_of<FitSection>()},
                                  {"[validate]", keys_of<ValidateSection>()}});
}

}  // namespace
}  // namespace palpate::tools
