#include "libfit/validation/statement.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "libfit/core/error.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/io/content_hash.hpp"

namespace palpate::validation {
namespace {

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
    {"floor_N", &Statement::floor_N},
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

// A number, or null: no number. Writing turns NaN into null by itself.
double figure(const nlohmann::ordered_json& json, std::string_view name) {
  const nlohmann::ordered_json& value = json.at(std::string(name));
  return value.is_null() ? kNoNumber : value.get<double>();
}

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
      errors.back().*member = figure(figures, field);
  }
  return errors;
}

std::vector<NamedError> named_errors(const nlohmann::ordered_json& json) {
  std::vector<NamedError> errors;
  for (const auto& [name, figures] : json.items()) {
    errors.push_back({name});
    for (const auto& [field, member] : kNamedFields) errors.back().*member = figure(figures, field);
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
      shape.*figures.*member = figure(json.at(std::string(part)), name);
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
    error.max_N = figure(json.at(error.name), "max_N");
    error.max_rel = figure(json.at(error.name), "max_rel");
  }
  return errors;
}

nlohmann::ordered_json json_of(const Statement& statement) {
  nlohmann::ordered_json json;
  for (const auto& [name, member] : kErrorFields)
    json["force_error"][std::string(name)] = statement.*member;
  json["verdict"] = verdict(statement);
  json["advice"] = advice(statement);
  for (const auto& [name, member] : kCountFields) json[std::string(name)] = statement.*member;
  for (const auto& [name, member] : kNumberFields) json[std::string(name)] = statement.*member;
  for (const auto& [name, member] : kListFields)
    json[std::string(name)] = json_of(statement.*member);
  json["torque_error"] = json_of(statement.torque);
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

}  // namespace

NamedError named_error(std::string name, const std::vector<ComparedRow>& rows, double floor_N) {
  const Statement s = summarize(rows, floor_N);
  return {std::move(name), s.median_N, s.p95_N, s.median_rel, s.p95_rel, s.max_N, s.max_rel};
}

std::string to_asset_json(const Statement& statement) {
  nlohmann::ordered_json json = json_of(statement);
  json.erase("tick_ns");
  json.erase("asset_bytes");
  json.erase("advice");
  json.erase("torque_error");
  json.erase("two_tools");
  json.erase("two_tools_tick_ns");
  json.erase("tool");
  return json.dump();
}

Statement summarize(const std::vector<ComparedRow>& rows) {
  double largest_N = 0;
  for (const ComparedRow& row : rows) largest_N = std::max(largest_N, row.reference_N.norm());
  return summarize(rows, relative_floor_N(largest_N));
}

Statement summarize(const std::vector<ComparedRow>& rows, double floor_N) {
  Statement statement;
  statement.rows = rows.size();
  statement.floor_N = floor_N;
  std::vector<double> error_N, error_rel, reference_rel;
  std::size_t within = 0, within_reference = 0;
  double felt_N = 0;  // most that a hand met, of either
  for (const ComparedRow& row : rows) {
    const double error = (row.engine_N - row.reference_N).norm(), force = row.reference_N.norm();
    error_N.push_back(error);
    felt_N = std::max({felt_N, force, row.engine_N.norm()});
    if (is_within_jnd(error, force)) ++within;
    if (force <= floor_N) continue;
    error_rel.push_back(relative_error(error, force, floor_N));
    if (!std::isfinite(row.reference_error_N)) continue;
    reference_rel.push_back(relative_error(row.reference_error_N, force, floor_N));
    if (error <= row.reference_error_N) ++within_reference;
  }
  const auto share = [](std::size_t of, std::size_t all) {
    return all == 0 ? kNoNumber : static_cast<double>(of) / static_cast<double>(all);
  };
  statement.rows_above_floor = error_rel.size();
  statement.median_N = stated_quantile(error_N, 0.5);
  statement.p95_N = stated_quantile(error_N, 0.95);
  statement.max_N = stated_quantile(error_N, 1);
  statement.median_rel = stated_quantile(error_rel, 0.5);
  statement.p95_rel = stated_quantile(error_rel, 0.95);
  statement.max_rel = stated_quantile(error_rel, 1);
  statement.reference_p95_rel = stated_quantile(reference_rel, 0.95);
  statement.within_reference = share(within_reference, reference_rel.size());
  if (felt_N > kForceFloor_N) statement.within_jnd = share(within, rows.size());
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
      s.*member = figure(json.at("force_error"), name);
    for (const auto& [name, member] : kCountFields) s.*member = json.at(std::string(name));
    for (const auto& [name, member] : kNumberFields) s.*member = figure(json, name);
    for (const auto& [name, member] : kListFields)
      s.*member = named_errors(json.at(std::string(name)));
    if (json.contains("torque_error")) s.torque = torques(json["torque_error"]);
    if (json.contains("two_tools")) {
      s.two_tools = errors_with_largest(json["two_tools"]);
      s.two_tools_tick_ns = figure(json, "two_tools_tick_ns");
    }
    if (json.contains("tool")) {
      s.tool = errors_with_largest(json["tool"].at("force_error"));
      s.tool_torque = torques(json["tool"].at("torque_error"));
      s.tool_tick_ns = figure(json["tool"], "tick_ns");
    }
    if (json.contains("shape_error")) s.shape = shape_of(json["shape_error"]);
  } catch (const nlohmann::json::exception& e) {
    throw Error(where, e.what(), "Make it again with palpate run.");
  }
  return s;
}

}  // namespace palpate::validation
