// The statement of error as the object that others read.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/validation/statement.hpp"

namespace palpate::validation {
namespace {

using Json = nlohmann::ordered_json;

// Fields and parts of an object, written or read. Writing turns NaN into null by itself.
class FieldWriter {
 public:
  explicit FieldWriter(Json& json) : json_(json) {}
  template <class T>
  void operator()(const std::string& name, const T& value) const {
    json_[name] = value;
  }
  // fields(of): of an object in this one, which is empty where there is none.
  template <class Fields>
  void part(const char* name, bool is_there, const Fields& fields) const {
    Json& part = json_[name] = Json::object();
    if (is_there) fields(FieldWriter(part));
  }
  // The same, left out where there is none.
  template <class Fields>
  void part_if_any(const char* name, bool is_there, const Fields& fields) const {
    if (is_there) part(name, true, fields);
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
  template <class Fields>
  void part(const char* name, bool, const Fields& fields) const {
    if (const Json& part = json_.at(name); !part.empty()) fields(FieldReader(part));
  }
  template <class Fields>
  void part_if_any(const char* name, bool, const Fields& fields) const {
    if (json_.contains(name)) part(name, true, fields);
  }

 private:
  const Json& json_;
};

bool is_number(double value) { return value == value; }

// The fields of each part are listed once. E: ErrorFigures or const ErrorFigures, and so on.
template <class E>
auto error_fields(E& e, const std::string& unit) {
  return [&e, unit](const auto& f) {
    f("typical_" + unit, e.typical);
    f("median_" + unit, e.median);
    f("p95_" + unit, e.p95);
    f("max_" + unit, e.max);
    f("median_rel", e.median_rel);
    f("p95_rel", e.p95_rel);
    f("max_rel", e.max_rel);
  };
}
template <class E>
auto spread_fields(E& e, const std::string& unit, bool has_band = false) {
  return [&e, unit, has_band](const auto& f) {
    f("median" + unit, e.median);
    f("p95" + unit, e.p95);
    if (!has_band) return;
    f("p95" + unit + "_low", e.p95_low);
    f("p95" + unit + "_high", e.p95_high);
  };
}
template <class E>
auto shape_fields(E& e) {
  return [&e](const auto& f) {
    f("median_m", e.median_m);
    f("p95_m", e.p95_m);
    f("max_m", e.max_m);
    f("median_rel", e.median_rel);
    f("p95_rel", e.p95_rel);
    f("max_rel", e.max_rel);
  };
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
void force_fields(S& s, const F& f) {
  f.part("force_error", true, [&](const auto& of) {
    error_fields(s.all.force, "N")(of);
    of("within_jnd", s.within_jnd);
    of("p95_rel_low", s.p95_rel_low);
    of("p95_rel_high", s.p95_rel_high);
  });
}
TruthInterval& made(std::optional<TruthInterval>& interval) { return interval.emplace(); }
const TruthInterval& made(const std::optional<TruthInterval>& interval) { return *interval; }

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
  f.part("magnitude", true, spread_fields(s.all.magnitude, "_rel", true));
  f.part("direction_deg", true, spread_fields(s.all.direction_deg, "", true));
  f.part("slip_onset", true, [&](const auto& of) {
    of("paths", s.slip_onset.paths);
    spread_fields(s.slip_onset.place_m, "_m")(of);
    spread_fields(s.slip_onset.force_N, "_N")(of);
  });
  f.part("interval", s.interval.has_value(),
         [&](const auto& of) { interval_fields(made(s.interval), of); });
  f.part("torque_at_handle", is_number(s.all.handle.median), error_fields(s.all.handle, "Nm"));
  f.part("torque_error", is_number(s.all.torque.median), error_fields(s.all.torque, "Nm"));
  f.part("shape_error", s.shape.rows > 0, [&](const auto& of) {
    of.part("near", true, shape_fields(s.shape.near));
    of.part("all", true, shape_fields(s.shape.all));
    of("rows", s.shape.rows);
  });
}
template <class L, class F>
void line_fields(L& line, const F& f) {
  f("rows", line.rows);
  error_fields(line.force, "N")(f);
  f.part("magnitude", true, spread_fields(line.magnitude, "_rel"));
  f.part("direction_deg", true, spread_fields(line.direction_deg, ""));
  f("unnoticed", line.unnoticed);
  f.part_if_any("torque", is_number(line.torque.median), error_fields(line.torque, "Nm"));
  f.part_if_any("torque_at_handle", is_number(line.handle.median), error_fields(line.handle, "Nm"));
}

constexpr const char *kSimulated = "simulated", *kRecorded = "recorded";

Json json_of(const Statement& statement) {
  Json json;
  force_fields(statement, FieldWriter(json));
  json["verdict"] = verdict(statement);
  json["advice"] = advice(statement);
  json["words"] = in_words(statement);
  json["reference"] = statement.is_recorded ? kRecorded : kSimulated;
  statement_fields(statement, FieldWriter(json));
  json["sections"] = Json::array();
  for (const StatementSection& section : statement.sections) {
    json["sections"].push_back({{"name", section.name}, {"title", section.title}});
    Json& lines = json[section.name] = Json::object();
    for (const StatedError& line : section.lines) {
      line_fields(line, FieldWriter(lines[line.name]));
      if (is_number(line.tick_ns)) lines[line.name]["tick_ns"] = line.tick_ns;
    }
  }
  return json;
}

}  // namespace

std::string to_asset_json(const Statement& statement) {
  Json json = json_of(statement);
  for (const char* name : {"tick_ns", "asset_bytes", "advice", "words"}) json.erase(name);
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
    force_fields(s, FieldReader(json));
    s.is_recorded = json.at("reference") == kRecorded;
    statement_fields(s, FieldReader(json));
    for (const Json& section : json.at("sections")) {
      s.sections.push_back({section.at("name"), section.at("title"), {}});
      for (const auto& [name, json_line] : json.at(s.sections.back().name).items()) {
        StatedError& line = s.sections.back().lines.emplace_back(StatedError{name});
        line_fields(line, FieldReader(json_line));
        if (json_line.contains("tick_ns")) line.tick_ns = json_line["tick_ns"];
      }
    }
  } catch (const nlohmann::json::exception& e) {
    throw Error(where, e.what(), "Make it again with palpate run.");
  }
  return s;
}

}  // namespace palpate::validation
