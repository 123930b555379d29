#include "libfit/validation/statement.hpp"

#include <fmt/core.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "libfit/core/error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/content_hash.hpp"

namespace palpate::validation {
namespace {

// Of the error that is stated: a reference whose own error is above this share is told.
constexpr double kTold = 0.5;

struct NumberField {
  std::string_view name;
  double Statement::*member;
};
struct CountField {
  std::string_view name;
  std::size_t Statement::*member;
};

constexpr NumberField kErrorFields[] = {
    {"median_N", &Statement::median_N},     {"p95_N", &Statement::p95_N},
    {"max_N", &Statement::max_N},           {"median_rel", &Statement::median_rel},
    {"p95_rel", &Statement::p95_rel},       {"max_rel", &Statement::max_rel},
    {"within_jnd", &Statement::within_jnd},
};
constexpr CountField kCountFields[] = {
    {"probes", &Statement::probes},
    {"rows", &Statement::rows},
    {"rows_above_floor", &Statement::rows_above_floor},
    {"reference_failures", &Statement::reference_failures},
    {"asset_bytes", &Statement::asset_bytes},
};
constexpr NumberField kNumberFields[] = {
    {"reference_p95_rel", &Statement::reference_p95_rel},
    {"within_reference", &Statement::within_reference},
    {"tick_ns", &Statement::tick_ns},
};

struct NamedField {
  std::string_view name;
  double NamedError::*member;
};
struct ListField {
  std::string_view name;
  std::vector<NamedError> Statement::*member;
};
constexpr NamedField kNamedFields[] = {
    {"median_N", &NamedError::median_N},
    {"p95_N", &NamedError::p95_N},
    {"median_rel", &NamedError::median_rel},
    {"p95_rel", &NamedError::p95_rel},
};
constexpr ListField kListFields[] = {
    {"by_path", &Statement::by_path},
    {"causes", &Statement::causes},
    {"baselines", &Statement::baselines},
};

nlohmann::ordered_json json_of(const std::vector<NamedError>& errors) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const NamedError& error : errors)
    for (const auto& [name, member] : kNamedFields)
      json[error.name][std::string(name)] = error.*member;
  return json;
}

struct TorqueField {
  std::string_view name;
  double NamedTorque::*member;
};
constexpr TorqueField kTorqueFields[] = {
    {"typical_Nm", &NamedTorque::typical_Nm}, {"median_Nm", &NamedTorque::median_Nm},
    {"p95_Nm", &NamedTorque::p95_Nm},         {"max_Nm", &NamedTorque::max_Nm},
    {"median_rel", &NamedTorque::median_rel}, {"p95_rel", &NamedTorque::p95_rel},
    {"max_rel", &NamedTorque::max_rel},
};

nlohmann::ordered_json json_of(const std::vector<NamedTorque>& errors) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const NamedTorque& error : errors)
    for (const auto& [name, member] : kTorqueFields)
      json[error.name][std::string(name)] = error.*member;
  return json;
}

std::vector<NamedTorque> torques(const nlohmann::ordered_json& json) {
  std::vector<NamedTorque> errors;
  for (const auto& [name, figures] : json.items()) {
    errors.push_back({name});
    for (const auto& [field, member] : kTorqueFields)
      errors.back().*member = figures.at(std::string(field));
  }
  return errors;
}

std::vector<NamedError> named_errors(const nlohmann::ordered_json& json) {
  std::vector<NamedError> errors;
  for (const auto& [name, figures] : json.items()) {
    errors.push_back({name});
    for (const auto& [field, member] : kNamedFields)
      errors.back().*member = figures.at(std::string(field));
  }
  return errors;
}

struct ShapeField {
  std::string_view name;
  double ShapeErrorFigures::*member;
};
constexpr ShapeField kShapeFields[] = {
    {"median_m", &ShapeErrorFigures::median_m}, {"p95_m", &ShapeErrorFigures::p95_m},
    {"max_m", &ShapeErrorFigures::max_m},       {"median_rel", &ShapeErrorFigures::median_rel},
    {"p95_rel", &ShapeErrorFigures::p95_rel},   {"max_rel", &ShapeErrorFigures::max_rel},
};
struct ShapePartField {
  std::string_view name;
  ShapeErrorFigures ShapeError::*member;
};
constexpr ShapePartField kShapeParts[] = {{"near", &ShapeError::near}, {"all", &ShapeError::all}};

nlohmann::ordered_json json_of(const ShapeError& shape) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  if (shape.rows == 0) return json;
  for (const auto& [part, figures] : kShapeParts)
    for (const auto& [name, member] : kShapeFields)
      json[std::string(part)][std::string(name)] = shape.*figures.*member;
  json["penetration_m"] = shape.penetration_m;
  json["rows"] = shape.rows;
  return json;
}

ShapeError shape_of(const nlohmann::ordered_json& json) {
  ShapeError shape;
  if (json.empty()) return shape;
  for (const auto& [part, figures] : kShapeParts)
    for (const auto& [name, member] : kShapeFields)
      shape.*figures.*member = json.at(std::string(part)).at(std::string(name));
  shape.penetration_m = json.at("penetration_m");
  shape.rows = json.at("rows");
  return shape;
}

nlohmann::ordered_json json_with_largest(const std::vector<NamedError>& errors) {
  nlohmann::ordered_json json = json_of(errors);
  for (const NamedError& error : errors) {
    json[error.name]["max_N"] = error.max_N;
    json[error.name]["max_rel"] = error.max_rel;
  }
  return json;
}

std::vector<NamedError> errors_with_largest(const nlohmann::ordered_json& json) {
  std::vector<NamedError> errors = named_errors(json);
  for (NamedError& error : errors) {
    error.max_N = json.at(error.name).at("max_N");
    error.max_rel = json.at(error.name).at("max_rel");
  }
  return errors;
}

nlohmann::ordered_json json_of(const Statement& statement) {
  nlohmann::ordered_json json;
  for (const auto& [name, member] : kErrorFields)
    json["force_error"][std::string(name)] = statement.*member;
  for (const auto& [name, member] : kCountFields) json[std::string(name)] = statement.*member;
  for (const auto& [name, member] : kNumberFields) json[std::string(name)] = statement.*member;
  for (const auto& [name, member] : kListFields)
    json[std::string(name)] = json_of(statement.*member);
  json["torque_error"] = json_of(statement.torque);
  json["turning"]["by_path"] = json_of(statement.turning);
  json["turning"]["torque_error"] = json_of(statement.turning_torque);
  json["turning"]["tick_ns"] = statement.turning_tick_ns;
  if (!statement.two_tools.empty()) {
    json["two_tools"] = json_with_largest(statement.two_tools);
    json["two_tools_tick_ns"] = statement.two_tools_tick_ns;
  }
  if (!statement.tool.empty()) {
    json["tool"] = {{"force_error", json_with_largest(statement.tool)},
                    {"torque_error", json_of(statement.tool_torque)},
                    {"tick_ns", statement.tool_tick_ns}};
  }
  json["shape_error"] = json_of(statement.shape);
  return json;
}

// A line of the table: what it is of, then its share of the force and newtons (of a torque and
// N mm), twice or thrice.
std::string line(std::string_view name, std::initializer_list<std::pair<double, double>> figures,
                 std::string_view unit = "N") {
  std::string text = fmt::format("  {:<21}", name);
  for (const auto& [share, number] : figures)
    text += fmt::format("{:>8} {:>{}.{}f} {}", percent(share), number, 8 - unit.size(),
                        unit.size() > 1 ? 2 : 4, unit);
  return text + "\n";
}

std::string lines(std::string_view title, const std::vector<NamedError>& errors) {
  std::string text;
  if (!errors.empty()) text = fmt::format("{}\n", title);
  for (const NamedError& e : errors)
    text += line(e.name, {{e.median_rel, e.median_N}, {e.p95_rel, e.p95_N}});
  return text;
}

std::string lines(std::string_view title, const std::vector<NamedTorque>& errors) {
  std::string text;
  if (!errors.empty())
    text = fmt::format("{:<23}{:>18}{:>18}{:>18}\n", title, "median", "p95", "max");
  for (const NamedTorque& e : errors)
    text += line(e.name,
                 {{e.median_rel, 1e3 * e.median_Nm},
                  {e.p95_rel, 1e3 * e.p95_Nm},
                  {e.max_rel, 1e3 * e.max_Nm}},
                 "Nmm");
  return text;
}

std::string lines_with_largest(std::string_view title, const std::vector<NamedError>& errors) {
  std::string text;
  if (!errors.empty())
    text = fmt::format("{:<23}{:>18}{:>18}{:>18}\n", title, "median", "p95", "max");
  for (const NamedError& e : errors)
    text += line(e.name, {{e.median_rel, e.median_N}, {e.p95_rel, e.p95_N}, {e.max_rel, e.max_N}});
  return text;
}

}  // namespace

NamedError named_error(std::string name, const std::vector<ComparedRow>& rows) {
  const Statement s = summarize(rows);
  return {std::move(name), s.median_N, s.p95_N, s.median_rel, s.p95_rel, s.max_N, s.max_rel};
}

std::string to_asset_json(const Statement& statement) {
  nlohmann::ordered_json json = json_of(statement);
  json.erase("tick_ns");
  json.erase("asset_bytes");
  json.erase("torque_error");
  json.erase("turning");
  json.erase("two_tools");
  json.erase("two_tools_tick_ns");
  json.erase("tool");
  return json.dump();
}

Statement summarize(const std::vector<ComparedRow>& rows) {
  Statement statement;
  statement.rows = rows.size();
  std::vector<double> error_N, error_rel, reference_rel;
  std::size_t within = 0, within_reference = 0;
  for (const ComparedRow& row : rows) {
    const double error = (row.engine_N - row.reference_N).norm(), force = row.reference_N.norm();
    error_N.push_back(error);
    if (is_within_jnd(error, force)) ++within;
    if (force <= kForceFloor_N) continue;
    error_rel.push_back(relative_error(error, force, kForceFloor_N));
    if (!std::isfinite(row.reference_error_N)) continue;
    reference_rel.push_back(relative_error(row.reference_error_N, force, kForceFloor_N));
    if (error <= row.reference_error_N) ++within_reference;
  }
  statement.rows_above_floor = error_rel.size();
  statement.median_N = quantile(error_N, 0.5);
  statement.p95_N = quantile(error_N, 0.95);
  statement.max_N = quantile(error_N, 1);
  statement.median_rel = quantile(error_rel, 0.5);
  statement.p95_rel = quantile(error_rel, 0.95);
  statement.max_rel = quantile(error_rel, 1);
  statement.reference_p95_rel = quantile(reference_rel, 0.95);
  statement.within_reference =
      reference_rel.empty()
          ? 0
          : static_cast<double>(within_reference) / static_cast<double>(reference_rel.size());
  statement.within_jnd =
      rows.empty() ? 0 : static_cast<double>(within) / static_cast<double>(rows.size());
  return statement;
}

std::string to_json(const Statement& statement) { return json_of(statement).dump(); }

std::string to_json(const Statement& statement, const std::string& inputs) {
  nlohmann::ordered_json json = json_of(statement);
  json[kInputsAttribute] = inputs;
  return json.dump(2) + "\n";
}

Statement parse_statement(const std::string& text, const std::string& where) {
  Statement s;
  try {
    const auto json = nlohmann::ordered_json::parse(text);
    for (const auto& [name, member] : kErrorFields)
      s.*member = json.at("force_error").at(std::string(name));
    for (const auto& [name, member] : kCountFields) s.*member = json.at(std::string(name));
    for (const auto& [name, member] : kNumberFields) s.*member = json.at(std::string(name));
    for (const auto& [name, member] : kListFields)
      s.*member = named_errors(json.at(std::string(name)));
    if (json.contains("torque_error")) s.torque = torques(json["torque_error"]);
    if (json.contains("turning")) {
      const auto& turning = json["turning"];
      s.turning = named_errors(turning.at("by_path"));
      s.turning_torque = torques(turning.at("torque_error"));
      s.turning_tick_ns = turning.at("tick_ns");
    }
    if (json.contains("two_tools")) {
      s.two_tools = errors_with_largest(json["two_tools"]);
      s.two_tools_tick_ns = json.at("two_tools_tick_ns");
    }
    if (json.contains("tool")) {
      s.tool = errors_with_largest(json["tool"].at("force_error"));
      s.tool_torque = torques(json["tool"].at("torque_error"));
      s.tool_tick_ns = json["tool"].at("tick_ns");
    }
    if (json.contains("shape_error")) s.shape = shape_of(json["shape_error"]);
  } catch (const nlohmann::json::exception& e) {
    throw Error(where, e.what(), "Make it again with palpate run.");
  }
  return s;
}

std::string in_words(const Statement& s) {
  std::string words =
      fmt::format("force error at {} held-out contact points, {} rows\n{:<23}{:>18}{:>18}{:>18}\n",
                  s.probes, s.rows, "", "median", "p95", "max");
  words += line("all", {{s.median_rel, s.median_N}, {s.p95_rel, s.p95_N}, {s.max_rel, s.max_N}});
  words += lines("by path", s.by_path) + lines("by cause", s.causes) +
           lines("of what is simpler", s.baselines);
  words += lines("torque error", s.torque) + lines("by a tool that turns", s.turning) +
           lines("torque error of it", s.turning_torque);
  if (s.turning_tick_ns > 0) words += fmt::format("a tick of it: {:.0f} ns\n", s.turning_tick_ns);
  words += lines_with_largest("two tools on the body", s.two_tools);
  if (s.two_tools_tick_ns > 0)
    words += fmt::format("a tick of both: {:.0f} ns\n", s.two_tools_tick_ns);
  words +=
      lines_with_largest("the tool, as balls", s.tool) + lines("torque error of it", s.tool_torque);
  if (s.tool_tick_ns > 0) words += fmt::format("a tick of it: {:.0f} ns\n", s.tool_tick_ns);
  words += fmt::format(
      "within the force just noticeable to a person, max(0.04 N, 7 %): {} of rows\n"
      "the reference's own estimated error: p95 {}; rows it could not solve: {}\n",
      percent(s.within_jnd, 0), percent(s.reference_p95_rel), s.reference_failures);
  if (s.reference_p95_rel > kTold * s.p95_rel)
    words += fmt::format(
        "this compares noise in part: at {} of rows the error is within the\n"
        "reference's own; force_tolerance of [validate] asks for a finer reference\n",
        percent(s.within_reference, 0));
  if (const ShapeErrorFigures& near = s.shape.near; s.shape.rows > 0)
    words += fmt::format(
        "the surface is shown within {:.2f} mm near the tool, {} of the depth (median;\n"
        "p95 {:.2f} mm, {}), and within {} over the whole body (p95)\n",
        1e3 * near.median_m, percent(near.median_rel), 1e3 * near.p95_m, percent(near.p95_rel),
        percent(s.shape.all.p95_rel));
  return words + fmt::format("{:.0f} ns per tick, {} bytes", s.tick_ns, s.asset_bytes);
}

}  // namespace palpate::validation
