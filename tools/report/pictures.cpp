#include "tools/report/pictures.hpp"

#include <algorithm>

namespace palpate::tools {
namespace {

constexpr std::size_t kShown = 1000;  // recordings: 2.5 MB of a page

// Indices of what is shown, in its order.
std::vector<std::size_t> chosen(const std::vector<RecordedSignal>& signals) {
  std::vector<std::size_t> shown;
  for (int grade = kRefusedGrade; grade >= 0; --grade) {
    std::vector<std::size_t> of_grade;
    for (std::size_t i = 0; i < signals.size(); ++i)
      if (signals[i].grade == grade) of_grade.push_back(i);
    const std::size_t room = std::min(of_grade.size(), kShown - shown.size());
    for (std::size_t k = 0; k < room; ++k) shown.push_back(of_grade[k * of_grade.size() / room]);
  }
  return shown;
}

}  // namespace

Json pictures_json(const std::vector<RecordedSignal>& signals) {
  Json json{{"grade_names", kRecordingGradeNames}, {"all", {0, 0, 0, 0}}};
  for (const RecordedSignal& signal : signals) {
    Json& count = json["all"][static_cast<std::size_t>(signal.grade)];
    count = count.get<std::size_t>() + 1;
  }
  for (const char* key :
       {"file", "point", "reasons", "estimator", "grade", "experiment", "readings"})
    json[key] = Json::array();
  std::vector<float> contact, deviation, noise, bias, drift, travel, push;
  std::vector<std::uint8_t> is_used;
  const auto append = [](auto& all, const auto& own) {
    all.insert(all.end(), own.begin(), own.end());
  };
  const auto put = [](std::vector<float>& all, double value) {
    all.push_back(static_cast<float>(value));
  };
  for (const std::size_t i : chosen(signals)) {
    const RecordedSignal& signal = signals[i];
    const SignalTrace& t = signal.trace;
    json["file"].push_back(signal.file), json["point"].push_back(signal.point);
    json["reasons"].push_back(signal.reasons), json["estimator"].push_back(signal.estimator);
    json["grade"].push_back(signal.grade), json["experiment"].push_back(signal.experiment);
    json["readings"].push_back(t.readings());
    put(contact, signal.contact_m), put(deviation, signal.contact_deviation_m);
    put(noise, signal.noise_N), put(bias, t.bias_N), put(drift, t.drift_N_m);
    append(travel, t.travel_m), append(push, t.push_N), append(is_used, t.is_used);
  }
  json["contact_m"] = packed(contact), json["contact_deviation_m"] = packed(deviation);
  json["noise_N"] = packed(noise), json["bias_N"] = packed(bias);
  json["drift_N_m"] = packed(drift), json["travel_m"] = packed(travel);
  json["push_N"] = packed(push), json["is_used"] = packed(is_used);
  return json;
}

}  // namespace palpate::tools
