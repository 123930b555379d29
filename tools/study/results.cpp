#include <limits>
#include <nlohmann/json.hpp>

#include "libfit/io/csv/csv.hpp"
#include "libfit/io/hdf5/hdf5.hpp"
#include "tools/study/study_folder.hpp"

namespace palpate::tools {

using Json = nlohmann::ordered_json;

void StudyFolder::write_results() const {
  static constexpr std::string_view kNumbers[] = {
      "points",        "rows",    "items_failed", "median_rel",
      "p95_rel",       "max_rel", "within_jnd",   "reference_p95_rel",
      "stiffness_N_m", "cpu_s",   "memory_MB"};
  static constexpr std::string_view kUnits[] = {"1", "1", "1",   "1", "1", "1",
                                                "1", "1", "N/m", "s", "MB"};
  std::vector<std::string> texts{"case", "state", "solved_from"};
  texts.insert(texts.end(), study_.inputs.begin(), study_.inputs.end());
  std::vector<std::string_view> header(texts.begin(), texts.end());
  header.push_back("force_factor");
  header.insert(header.end(), std::begin(kNumbers), std::end(kNumbers));
  header.push_back("failure");
  CsvWriter csv(path_ / "results.csv", header);
  std::vector<std::vector<std::string>> words(texts.size() + 1);
  std::vector<std::vector<double>> numbers(std::size(kNumbers) + 1);
  for (int i = 0; i < static_cast<int>(cases().size()); ++i) {
    const StudyCase& one = cases()[i];
    const CaseState now = state(i);
    std::vector<std::string> row{one.name,
                                 std::string(kCaseStateNames[static_cast<std::size_t>(now)]),
                                 study_.cases[one.source].name};
    row.insert(row.end(), one.inputs.begin(), one.inputs.end());
    for (std::size_t c = 0; c < row.size(); ++c) words[c].push_back(row[c]);
    for (const std::string& word : row) csv.text(word);
    csv.number(one.factor);
    numbers.back().push_back(one.factor);
    const Json result = now == CaseState::done
                            ? Json::parse(read_whole_file(case_folder(i) / "result.json"))
                            : Json();
    for (std::size_t c = 0; c < std::size(kNumbers); ++c) {
      const bool is_known = result.is_object() && result.contains(kNumbers[c]) &&
                            result.at(std::string(kNumbers[c])).is_number();
      const double value = is_known ? result.at(std::string(kNumbers[c])).get<double>()
                                    : std::numeric_limits<double>::quiet_NaN();
      numbers[c].push_back(value);
      if (is_known)
        csv.number(value);
      else
        csv.text("");
    }
    words.back().push_back(failure(i));
    csv.text(words.back().back());
    csv.end_row();
  }
  csv.commit();
  h5::Writer file(path_ / "results.h5", "palpate-study", {{"study", study_.path.string()}});
  for (std::size_t c = 0; c < texts.size(); ++c) file.strings("cases/" + texts[c], words[c]);
  file.strings("cases/failure", words.back());
  for (std::size_t c = 0; c < std::size(kNumbers); ++c)
    file.numbers("cases/" + std::string(kNumbers[c]), kUnits[c], numbers[c].data(),
                 {numbers[c].size(), 0});
  file.numbers("cases/force_factor", "1", numbers.back().data(), {numbers.back().size(), 0});
  file.commit();
}

}  // namespace palpate::tools
