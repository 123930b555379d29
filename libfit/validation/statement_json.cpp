// The statement of error as the object that others read.

#include <nlohmann/json.hpp>
#include <string>

#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/validation/statement.hpp"

namespace palpate::validation {
namespace {

using Json = nlohmann::ordered_json;

// A field of an object, written or read. Writing turns NaN into null by itself.
class FieldWriter {
 public:
  explicit FieldWriter(Json& json) : json_(json) {}
  template <class T>
  void operator()(const std::string& name, const T& value) const {
    json_[name] = value;
  }

 private:
  Json& json_;
};

class FieldReader {
 public:
  explicit FieldReader(const Json& json) : json_(json) {}
  void operator()(const std::string& name, double& value) const {
    const Json& found = json_.at(name);
    value = found.is_null() ? kNoNumber : found.get<double>();
  }
  void operator()(const std::string& name, std::size_t& value) const { value = json_.at(name); }

 private:
  const Json& json_;
};

// The fields of each part are listed once. E: ErrorFigures or const ErrorFigures, and so on.
template <class E, class F>
void error_fields(E& e, const std::string& unit, const F& f) {
  f("typical_" + unit, e.typical);
  f("median_" + unit, e.median);
  f("p95_" + unit, e.p95);
  f("max_" + unit, e.max);
  f("median_rel", e.median_rel);
  f("p95_rel", e.p95_rel);
  f("max_rel", e.max_rel);
}
template <class E, class F>
void spread_fields(E& e, const std::string& unit, const F& f) {
  f("median" + unit, e.median);
  f("p95" + unit, e.p95);
}
template <class E, class F>
void spread_band_fields(E& e, const std::string& unit, const F& f) {
  spread_fields(e, unit, f);
  f("p95" + unit + "_low", e.p95_low);
  f("p95" + unit + "_high", e.p95_high);
}
template <class E, class F>
void shape_fields(E& e, const F& f) {
  f("median_m", e.median_m);
  f("p95_m", e.p95_m);
  f("max_m", e.max_m);
  f("median_rel", e.median_rel);
  f("p95_rel", e.p95_rel);
  f("max_rel", e.max_rel);
}
template <class S, class F>
void onset_fields(S& s, const F& f) {
  f("paths", s.paths);
  spread_fields(s.place_m, "_m", f);
  spread_fields(s.force_N, "_N", f);
}
template <class I, class F>
void interval_fields(I& i, const F& f) {
  f("low_rel", i.low_rel);
  f("high_rel", i.high_rel);
  f("young", i.young);
  f("poisson", i.poisson);
  f("friction", i.friction);
  f("held", i.held);
  f("replay", i.replay);
}
template <class S, class F>
void band_fields(S& s, const F& f) {
  f("within_jnd", s.within_jnd);
  f("p95_rel_low", s.p95_rel_low);
  f("p95_rel_high", s.p95_rel_high);
}
template <class S, class F>
void statement_fields(S& s, const F& f) {
  f("rows", s.all.rows);
  f("probes", s.probes);
  f("rows_above_floor", s.rows_above_floor);
  f("reference_failures", s.reference_failures);
  f("beyond", s.beyond);
  f("asset_bytes", s.asset_bytes);
  f("floor_N", s.floor_N);
  f("reference_p95_rel", s.reference_p95_rel);
  f("within_reference", s.within_reference);
  f("held_share", s.held_share);
  f("unnoticed", s.all.unnoticed);
  f("handle_m", s.handle_m);
  f("tick_ns", s.all.tick_ns);
}

constexpr const char *kSimulated = "simulated", *kRecorded = "recorded";

Json json_of(const StatedError& line) {
  Json json = {{"rows", line.rows}};
  error_fields(line.force, "N", FieldWriter(json));
  spread_fields(line.magnitude, "_rel", FieldWriter(json["magnitude"]));
  spread_fields(line.direction_deg, "", FieldWriter(json["direction_deg"]));
  FieldWriter{json}("unnoticed", line.unnoticed);
  if (line.torque.median == line.torque.median)
    error_fields(line.torque, "Nm", FieldWriter(json["torque"]));
  if (line.handle.median == line.handle.median)
    error_fields(line.handle, "Nm", FieldWriter(json["torque_at_handle"]));
  if (line.tick_ns == line.tick_ns) json["tick_ns"] = line.tick_ns;
  return json;
}

StatedError line_of(const std::string& name, const Json& json) {
  StatedError line{name, json.at("rows").get<std::size_t>()};
  error_fields(line.force, "N", FieldReader(json));
  spread_fields(line.magnitude, "_rel", FieldReader(json.at("magnitude")));
  spread_fields(line.direction_deg, "", FieldReader(json.at("direction_deg")));
  FieldReader{json}("unnoticed", line.unnoticed);
  if (json.contains("torque")) error_fields(line.torque, "Nm", FieldReader(json["torque"]));
  if (json.contains("torque_at_handle"))
    error_fields(line.handle, "Nm", FieldReader(json["torque_at_handle"]));
  if (json.contains("tick_ns")) FieldReader{json}("tick_ns", line.tick_ns);
  return line;
}

Json json_of(const Statement& statement) {
  Json json;
  error_fields(statement.all.force, "N", FieldWriter(json["force_error"]));
  band_fields(statement, FieldWriter(json["force_error"]));
  json["verdict"] = verdict(statement);
  json["advice"] = advice(statement);
  json["reference"] = statement.is_recorded ? kRecorded : kSimulated;
  statement_fields(statement, FieldWriter(json));
  spread_band_fields(statement.all.magnitude, "_rel", FieldWriter(json["magnitude"]));
  spread_band_fields(statement.all.direction_deg, "", FieldWriter(json["direction_deg"]));
  onset_fields(statement.slip_onset, FieldWriter(json["slip_onset"]));
  Json& interval = json["interval"] = Json::object();
  if (statement.interval) interval_fields(*statement.interval, FieldWriter(interval));
  Json& handle = json["torque_at_handle"] = Json::object();
  if (statement.all.handle.median == statement.all.handle.median)
    error_fields(statement.all.handle, "Nm", FieldWriter(handle));
  Json& torque = json["torque_error"] = Json::object();
  if (statement.all.torque.median == statement.all.torque.median)
    error_fields(statement.all.torque, "Nm", FieldWriter(torque));
  Json& shape = json["shape_error"] = Json::object();
  if (statement.shape.rows > 0) {
    shape_fields(statement.shape.near, FieldWriter(shape["near"]));
    shape_fields(statement.shape.all, FieldWriter(shape["all"]));
    shape["penetration_m"] = statement.shape.penetration_m;
    shape["rows"] = statement.shape.rows;
  }
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
    error_fields(s.all.force, "N", FieldReader(json.at("force_error")));
    band_fields(s, FieldReader(json.at("force_error")));
    s.is_recorded = json.at("reference") == kRecorded;
    statement_fields(s, FieldReader(json));
    spread_band_fields(s.all.magnitude, "_rel", FieldReader(json.at("magnitude")));
    spread_band_fields(s.all.direction_deg, "", FieldReader(json.at("direction_deg")));
    onset_fields(s.slip_onset, FieldReader(json.at("slip_onset")));
    if (const Json& interval = json.at("interval"); !interval.empty())
      interval_fields(s.interval.emplace(), FieldReader(interval));
    if (const Json& handle = json.at("torque_at_handle"); !handle.empty())
      error_fields(s.all.handle, "Nm", FieldReader(handle));
    if (const Json& torque = json.at("torque_error"); !torque.empty())
      error_fields(s.all.torque, "Nm", FieldReader(torque));
    if (const Json& shape = json.at("shape_error"); !shape.empty()) {
      shape_fields(s.shape.near, FieldReader(shape.at("near")));
      shape_fields(s.shape.all, FieldReader(shape.at("all")));
      s.shape.penetration_m = shape.at("penetration_m");
      s.shape.rows = shape.at("rows");
    }
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
