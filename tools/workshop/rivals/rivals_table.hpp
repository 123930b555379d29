#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "tools/workshop/rivals/measure.hpp"

namespace palpate::tools {

/// The rows of one body in a folder's `rivals.json`, from which `rivals.csv` is made. Rows of other
/// bodies stay, and so do those of parts that are not measured again.
class RivalsTable {
 public:
  /// Empty where all parts will be measured. Throws Error when parts are to be replaced among those
  /// of another asset.
  RivalsTable(std::filesystem::path folder, std::string body, std::string asset, bool is_whole);

  void add(std::string_view part, const Rival& rival, const Performance& did);
  /// A rival that is not in the table, and why.
  void leave_out(std::string_view part, const std::string& name, const std::string& why);
  /// A part has all its rows: CPU of preparation, tuning and paths of all its sizes.
  void end(std::string_view part, double cpu_s);
  /// Writes JSON and CSV, parts in the order of `kRivals`. own_p95: of the reference.
  void write(double own_p95);

 private:
  void keep_other_parts(const nlohmann::ordered_json& before);

  std::filesystem::path folder_;
  std::string body_;
  bool is_whole_;
  nlohmann::ordered_json table_;
};

}  // namespace palpate::tools
