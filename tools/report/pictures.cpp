#include "tools/report/pictures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::tools {
namespace {

constexpr std::size_t kShown = 1000;  // recordings: 3.6 MB of a page, with a model 4.7 MB

// Indices of what is shown, in its order.
std::vector<std::size_t> chosen(const std::vector<RecordingPicture>& pictures) {
  std::vector<std::size_t> shown;
  for (int grade = kRefusedGrade; grade >= 0; --grade) {
    std::vector<std::size_t> of_grade;
    for (std::size_t i = 0; i < pictures.size(); ++i)
      if (pictures[i].signal.grade == grade) of_grade.push_back(i);
    const std::size_t room = std::min(of_grade.size(), kShown - shown.size());
    for (std::size_t k = 0; k < room; ++k) shown.push_back(of_grade[k * of_grade.size() / room]);
  }
  return shown;
}

}  // namespace

Json pictures_json(const std::vector<RecordingPicture>& pictures) {
  Json json{
      {"grade_names", kRecordingGradeNames}, {"phase_names", kPhaseNames}, {"all", {0, 0, 0, 0}}};
  for (const RecordingPicture& p : pictures) {
    Json& count = json["all"][static_cast<std::size_t>(p.signal.grade)];
    count = count.get<std::size_t>() + 1;
  }
  for (const char* key :
       {"file", "point", "reasons", "estimator", "grade", "experiment", "readings", "model"})
    json[key] = Json::array();
  std::vector<float> contact, deviation, noise, bias, drift, time, travel, push, fitted, young,
      young_deviation, position;
  std::vector<std::uint8_t> phase, is_used;
  bool has_model = false;
  const auto append = [](std::vector<float>& all, const std::vector<float>& own) {
    all.insert(all.end(), own.begin(), own.end());
  };
  const auto put = [](std::vector<float>& all, double value) {
    all.push_back(static_cast<float>(value));
  };
  for (const std::size_t i : chosen(pictures)) {
    const RecordingPicture& p = pictures[i];
    const SignalTrace& t = p.signal.trace;
    has_model |= !p.fitted_N.empty() || p.position_m;
    json["file"].push_back(p.signal.file), json["point"].push_back(p.signal.point);
    json["reasons"].push_back(p.signal.reasons);
    json["estimator"].push_back(p.signal.estimator);
    json["grade"].push_back(p.signal.grade), json["experiment"].push_back(p.signal.experiment);
    json["readings"].push_back(t.readings()), json["model"].push_back(p.model);
    put(contact, p.signal.contact_m), put(deviation, p.signal.contact_deviation_m);
    put(noise, p.signal.noise_N), put(bias, t.bias_N), put(drift, t.drift_N_m);
    append(time, t.time_s), append(travel, t.travel_m), append(push, t.push_N);
    phase.insert(phase.end(), t.phase.begin(), t.phase.end());
    is_used.insert(is_used.end(), t.is_used.begin(), t.is_used.end());
    append(fitted, p.fitted_N);
    fitted.resize(push.size(), std::numeric_limits<float>::quiet_NaN());
    put(young, p.young_Pa), put(young_deviation, p.young_deviation_Pa);
    for (int k = 0; k < 3; ++k) put(position, p.position_m ? (*p.position_m)[k] : std::nan(""));
  }
  json["contact_m"] = packed(contact), json["contact_deviation_m"] = packed(deviation);
  json["noise_N"] = packed(noise), json["bias_N"] = packed(bias);
  json["drift_N_m"] = packed(drift), json["time_s"] = packed(time);
  json["travel_m"] = packed(travel), json["push_N"] = packed(push);
  json["phase"] = packed(phase), json["is_used"] = packed(is_used);
  if (has_model) {
    json["fitted_N"] = packed(fitted), json["young_Pa"] = packed(young);
    json["young_deviation_Pa"] = packed(young_deviation), json["position_m"] = packed(position);
  }
  return json;
}

}  // namespace palpate::tools
