#include "libfit/recordings/placing/assemble.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "libfit/core/text.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/csv/csv.hpp"

namespace palpate::recordings {
namespace {

using Json = nlohmann::ordered_json;

constexpr auto kHeader = std::to_array<std::string_view>(
    {"file", "line", "recording", "point", "status", "grade", "reason", "remedy", "experiment",
     "contact_m", "contact_deviation_m", "speed_m_s", "noise_N", "hysteresis", "young_Pa",
     "surface_distance_m", "format", "taken", "hash"});

// A value of a row as text; an empty field where it has none: readers refuse NaN.
void put(CsvWriter& csv, const Json& row, std::string_view name) {
  const auto at = row.find(std::string(name));
  if (at == row.end() || at->is_null())
    csv.text("");
  else if (at->is_array())
    csv.text(listed(at->get<std::vector<std::string>>(), "; "));
  else if (at->is_string())
    csv.text(at->get<std::string>());
  else if (at->is_number_float())
    csv.number(at->get<double>());
  else
    csv.integer(at->get<std::int64_t>());
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

// Line of a failure's place, null when it names none.
Json line_of(const Error& failure) {
  const std::string line = failure.where().substr(failure.where().rfind(':') + 1);
  const bool is_number = line.size() < failure.where().size() && !line.empty() &&
                         line.size() < 16 &&
                         line.find_first_not_of("0123456789") == std::string::npos;
  return is_number ? Json(std::stoll(line)) : Json(nullptr);
}

Json as_json(const PlacedRecording& o) {
  Json row;
  row["file"] = o.item->shown;
  if (!o.name.empty()) row["recording"] = o.name;
  row["point"] = o.point;
  row["status"] = o.failure ? "refused" : "imported";
  if (o.failure) {
    row["where"] = o.failure->where();
    row["line"] = line_of(*o.failure);
    row["reason"] = o.failure->fact();
    row["remedy"] = o.failure->remedy();
    return row;
  }
  const Conditioned* r = o.recording;
  row["experiment"] = o.experiment;
  row["grade"] = kRecordingGradeNames[static_cast<int>(r->grade)];
  row["reason"] = listed(r->reasons, "; ");
  const FoundContact& contact = r->contact;
  row["contact_m"] = number(contact.travel_m);
  row["contact_deviation_m"] = number(contact.deviation_m);
  row["estimator"] = contact.estimator;
  row["speed_m_s"] = number(r->speed_m_s);
  row["noise_N"] = number(r->noise_N);
  row["hysteresis"] = number(r->hysteresis);
  row["young_Pa"] = number(r->young_Pa);
  row["surface_distance_m"] = number(o.surface_distance_m);
  row["format"] = r->source.format;
  row["taken"] = r->source.taken;
  row["hash"] = o.result->hash;
  return row;
}

Json as_json(const RelaxationFit& fit) {
  Json json;
  json["told_s"] = {fit.shortest_s, fit.longest_s};
  json["held_out_error"] = fit.held_out;
  json["curve"] = fit.curve == SlowCurve::powers ? "powers" : "free";
  json["rms_N"] = fit.rms_N;
  json["branches"] = Json::array();
  for (Eigen::Index k = 0; k < fit.relaxation.branches(); ++k) {
    Json branch;
    branch["share"] = fit.relaxation.share[k];
    branch["share_band"] = {number(fit.share_low[k]), number(fit.share_high[k])};
    branch["time_s"] = fit.relaxation.time_s[k];
    branch["time_band_s"] = {number(fit.time_low_s[k]), number(fit.time_high_s[k])};
    branch["is_slower_than_recordings"] = fit.is_slower[k] != 0;
    json["branches"].push_back(branch);
  }
  return json;
}

Json as_json(const BodyRelaxation& found) {
  Json json = as_json(found.fit);
  json["is_applied"] = found.is_applied;
  json["doubts"] = found.doubts;
  json["points"] = Json::array();
  for (const BodyRelaxation::PointSeries& point : found.points) {
    Json of = as_json(point.fit);
    of["name"] = point.name;
    json["points"].push_back(of);
  }
  json["recordings"] = Json::array();
  for (const BodyRelaxation::Used& used : found.recordings)
    json["recordings"].push_back({{"file", used.file}, {"point", used.point}});
  return json;
}

Json totals(const Assembled& a) {
  std::array<std::size_t, 3> grades{};
  for (const std::int8_t grade : a.samples.recordings.grade) ++grades[grade];
  Json json;
  json["files"] = a.files;
  json["imported"] = a.samples.recordings.size();
  json["failed"] = a.failed();
  for (std::size_t g = 0; g < 3; ++g)
    json["grades"][std::string(kRecordingGradeNames[g])] = grades[g];
  json["points"] = a.samples.points();
  json["rows"] = a.samples.rows();
  if (a.registration)
    json["registration"] = {{"rms_m", a.registration->rms_m},
                            {"largest_m", a.registration->largest_m},
                            {"iterations", a.registration->iterations}};
  if (a.relaxation) json["relaxation"] = as_json(*a.relaxation);
  json["notes"] = a.notes;
  json["failures"] = Json::array();
  for (const PlacedRecording& o : a.outcomes)
    if (o.failure) json["failures"].push_back(as_json(o));
  return json;
}

// Appends what is known of a recording.
void append(const PlacedRecording& placed, RecordingColumns& out) {
  const Conditioned* r = placed.recording;
  const FoundContact contact = r ? r->contact : FoundContact{kNan, kNan, ""};
  out.experiment.push_back(placed.experiment), out.file.push_back(shown(placed));
  out.contact_m.push_back(contact.travel_m);
  out.contact_deviation_m.push_back(contact.deviation_m);
  out.estimator.push_back(contact.estimator);
  out.noise_N.push_back(r ? r->noise_N : kNan);
  if (const auto& failure = placed.failure) {
    const std::string& what = failure->fact();
    out.grade.push_back(kRefusedGrade);
    out.reasons.push_back(what + (what.ends_with('?') ? " " : ". ") + failure->remedy());
  } else {
    out.grade.push_back(static_cast<std::int8_t>(r->grade));
    out.reasons.push_back(listed(r->reasons, "; "));
  }
}

std::string dumped(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::string summary_json(const Assembled& assembled) { return dumped(totals(assembled), 2); }

void write_summary(const std::filesystem::path& csv_path, const std::filesystem::path& json_path,
                   const Assembled& assembled) {
  CsvWriter csv(csv_path, kHeader);
  Json json = totals(assembled);
  json.erase("failures");
  json["recordings"] = Json::array();
  for (const PlacedRecording& o : assembled.outcomes) {
    Json row = json["recordings"].emplace_back(as_json(o));
    row["hash"] = o.result->hash;
    for (const std::string_view name : kHeader) put(csv, row, name);
    csv.end_row();
  }
  csv.commit();
  write_file_atomically(json_path, dumped(json, 1) + "\n");
}

RecordedSignals signals_of(const Assembled& assembled) {
  RecordedSignals out;
  for (const PlacedRecording& placed : assembled.outcomes) {
    append(placed, out);
    out.point.push_back(placed.point);
    const SignalTrace& trace = placed.recording ? placed.recording->trace : placed.refused->trace;
    out.bias_N.push_back(trace.bias_N), out.drift_N_m.push_back(trace.drift_N_m);
    out.readings.push_back(static_cast<std::int32_t>(trace.readings()));
    const auto add = [](const auto& own, auto& all) {
      all.insert(all.end(), own.begin(), own.end());
    };
    add(trace.time_s, out.time_s), add(trace.travel_m, out.travel_m);
    add(trace.push_N, out.push_N), add(trace.phase, out.phase), add(trace.is_used, out.is_used);
  }
  return out;
}

MeasuredRecordings provenance(const std::vector<PlacedRecording>& outcomes) {
  MeasuredRecordings out;
  for (const PlacedRecording& placed : outcomes) {
    if (placed.experiment < 0) continue;
    append(placed, out);
    const Conditioned& r = *placed.recording;
    out.hash.push_back(placed.result->hash);
    out.speed_m_s.push_back(r.speed_m_s);
    out.hysteresis.push_back(r.hysteresis), out.young_Pa.push_back(r.young_Pa);
  }
  return out;
}

}  // namespace palpate::recordings
