// The statement of error as the object that others read.

#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "libfit/core/error.hpp"
#include "libfit/io/content_hash.hpp"
#include "libfit/validation/statement.hpp"

namespace palpate::validation {
namespace {

using Json = nlohmann::ordered_json;

// Writing turns NaN into null by itself.
template <class Owner>
using Numbers = std::pair<std::string_view, double Owner::*>;

// Sizes of figures in N or N m, with the unit behind their name.
constexpr Numbers<ErrorFigures> kSizes[] = {{"typical", &ErrorFigures::typical},
                                            {"median", &ErrorFigures::median},
                                            {"p95", &ErrorFigures::p95},
                                            {"max", &ErrorFigures::max}};
constexpr Numbers<ErrorFigures> kShares[] = {{"median_rel", &ErrorFigures::median_rel},
                                             {"p95_rel", &ErrorFigures::p95_rel},
                                             {"max_rel", &ErrorFigures::max_rel}};
constexpr Numbers<ShapeErrorFigures> kShapeFigures[] = {
    {"median_m", &ShapeErrorFigures::median_m}, {"p95_m", &ShapeErrorFigures::p95_m},
    {"max_m", &ShapeErrorFigures::max_m},       {"median_rel", &ShapeErrorFigures::median_rel},
    {"p95_rel", &ShapeErrorFigures::p95_rel},   {"max_rel", &ShapeErrorFigures::max_rel}};
constexpr std::pair<std::string_view, ShapeErrorFigures ShapeError::*> kShapeParts[] = {
    {"near", &ShapeError::near}, {"all", &ShapeError::all}};
constexpr std::pair<std::string_view, std::size_t Statement::*> kCounts[] = {
    {"probes", &Statement::probes},
    {"rows_above_floor", &Statement::rows_above_floor},
    {"reference_failures", &Statement::reference_failures},
    {"beyond", &Statement::beyond},
    {"asset_bytes", &Statement::asset_bytes}};
constexpr Numbers<Statement> kNumbers[] = {{"floor_N", &Statement::floor_N},
                                           {"reference_p95_rel", &Statement::reference_p95_rel},
                                           {"within_reference", &Statement::within_reference}};

constexpr const char *kSimulated = "simulated", *kRecorded = "recorded";

// A number, or null: no number.
double number_in(const Json& json, std::string_view name) {
  const Json& value = json.at(std::string(name));
  return value.is_null() ? kNoNumber : value.get<double>();
}

std::string with_unit(std::string_view name, std::string_view unit) {
  return std::string(name) + "_" + std::string(unit);
}

void put(Json& json, const ErrorFigures& figures, std::string_view unit) {
  for (const auto& [name, member] : kSizes) json[with_unit(name, unit)] = figures.*member;
  for (const auto& [name, member] : kShares) json[std::string(name)] = figures.*member;
}

ErrorFigures figures_of(const Json& json, std::string_view unit) {
  ErrorFigures figures;
  for (const auto& [name, member] : kSizes)
    figures.*member = number_in(json, with_unit(name, unit));
  for (const auto& [name, member] : kShares) figures.*member = number_in(json, name);
  return figures;
}

bool is_any(const ErrorFigures& figures) { return figures.median == figures.median; }

Json json_of(const StatedError& line) {
  Json json = {{"rows", line.rows}};
  put(json, line.force, "N");
  if (is_any(line.torque)) put(json["torque"], line.torque, "Nm");
  if (line.tick_ns == line.tick_ns) json["tick_ns"] = line.tick_ns;
  return json;
}

StatedError line_of(const std::string& name, const Json& json) {
  StatedError line{name, json.at("rows").get<std::size_t>(), figures_of(json, "N")};
  if (json.contains("torque")) line.torque = figures_of(json["torque"], "Nm");
  if (json.contains("tick_ns")) line.tick_ns = number_in(json, "tick_ns");
  return line;
}

Json json_of(const ShapeError& shape) {
  Json json = Json::object();
  if (shape.rows == 0) return json;
  for (const auto& [part, figures] : kShapeParts)
    for (const auto& [name, member] : kShapeFigures)
      json[std::string(part)][std::string(name)] = shape.*figures.*member;
  json["penetration_m"] = shape.penetration_m;
  json["rows"] = shape.rows;
  return json;
}

ShapeError shape_of(const Json& json) {
  ShapeError shape;
  if (json.empty()) return shape;
  for (const auto& [part, figures] : kShapeParts)
    for (const auto& [name, member] : kShapeFigures)
      shape.*figures.*member = number_in(json.at(std::string(part)), name);
  shape.penetration_m = json.at("penetration_m");
  shape.rows = json.at("rows");
  return shape;
}

Json json_of(const Statement& statement) {
  Json json;
  put(json["force_error"], statement.all.force, "N");
  json["force_error"]["within_jnd"] = statement.within_jnd;
  json["force_error"]["p95_rel_low"] = statement.p95_rel_low;
  json["force_error"]["p95_rel_high"] = statement.p95_rel_high;
  json["verdict"] = verdict(statement);
  json["advice"] = advice(statement);
  json["reference"] = statement.is_recorded ? kRecorded : kSimulated;
  json["rows"] = statement.all.rows;
  for (const auto& [name, member] : kCounts) json[std::string(name)] = statement.*member;
  for (const auto& [name, member] : kNumbers) json[std::string(name)] = statement.*member;
  json["tick_ns"] = statement.all.tick_ns;
  json["torque_error"] = Json::object();
  if (is_any(statement.all.torque)) put(json["torque_error"], statement.all.torque, "Nm");
  json["shape_error"] = json_of(statement.shape);
  json["sections"] = Json::array();
  for (const StatementSection& section : statement.sections) {
    json["sections"].push_back({{"name", section.name}, {"title", section.title}});
    Json& lines = json[section.name] = Json::object();
    for (const StatedError& line : section.lines) lines[line.name] = json_of(line);
  }
  return json;
}

}  // namespace

std::string to_asset_json(const Statement& statement) {
  Json json = json_of(statement);
  for (const char* name : {"tick_ns", "asset_bytes", "advice"}) json.erase(name);
  for (const StatementSection& section : statement.sections)
    for (Json& line : json[section.name]) line.erase("tick_ns");
  return json.dump();
}

std::string to_json(const Statement& statement) { return json_of(statement).dump(); }

std::string to_json(const Statement& statement, const std::string& inputs) {
  Json json = json_of(statement);
  json[kInputsAttribute] = inputs;
  return json.dump(2) + "\n";
}

Statement parse_statement(const std::string& text, const std::string& where) {
  Statement s;
  try {
    const Json json = Json::parse(text);
    s.all.force = figures_of(json.at("force_error"), "N");
    s.within_jnd = number_in(json.at("force_error"), "within_jnd");
    s.p95_rel_low = number_in(json.at("force_error"), "p95_rel_low");
    s.p95_rel_high = number_in(json.at("force_error"), "p95_rel_high");
    s.is_recorded = json.at("reference") == kRecorded;
    s.all.rows = json.at("rows");
    for (const auto& [name, member] : kCounts) s.*member = json.at(std::string(name));
    for (const auto& [name, member] : kNumbers) s.*member = number_in(json, name);
    s.all.tick_ns = number_in(json, "tick_ns");
    if (!json.at("torque_error").empty()) s.all.torque = figures_of(json["torque_error"], "Nm");
    s.shape = shape_of(json.at("shape_error"));
    for (const Json& section : json.at("sections")) {
      s.sections.push_back({section.at("name"), section.at("title"), {}});
      for (const auto& [name, line] : json.at(s.sections.back().name).items())
        s.sections.back().lines.push_back(line_of(name, line));
    }
  } catch (const nlohmann::json::exception& e) {
    throw Error(where, e.what(), "Make it again with palpate run.");
  }
  return s;
}

}  // namespace palpate::validation
