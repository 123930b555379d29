#include "tools/workshop/rivals/rivals_table.hpp"

#include <cmath>
#include <iterator>
#include <span>

#include "libfit/core/error.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/experiments/draw.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/workshop/bench/machine.hpp"
#include "tools/workshop/rivals/rivals.hpp"

namespace palpate::tools {
namespace {

using nlohmann::ordered_json;

// Columns of the CSV: the body, keys of its rows, then the median of each kind of path.
constexpr std::string_view kColumns[] = {"body",
                                         "rival",
                                         "settings",
                                         "size",
                                         "step_um",
                                         "paths",
                                         "rows",
                                         "median_rel",
                                         "p95_rel",
                                         "within_jnd",
                                         "tick_median_us",
                                         "tick_p999_us",
                                         "bytes",
                                         "preparation_cpu_s",
                                         "jump_per_10um_N",
                                         "energy_created_rel",
                                         "rested_share"};

ordered_json number_or_null(double number) {
  return std::isfinite(number) ? ordered_json(number) : ordered_json();
}

ordered_json row_of(std::string_view part, const Rival& rival, const Performance& did) {
  ordered_json by_path = ordered_json::object();
  for (const validation::StatedError& kind : did.by_path)
    by_path[kind.name] = {{"rows", kind.rows},
                          {"median_rel", number_or_null(kind.force.median_rel)},
                          {"p95_rel", number_or_null(kind.force.p95_rel)}};
  return {{"part", part},
          {"rival", rival.name},
          {"settings", rival.settings},
          {"size", rival.size},
          {"step_um", std::round(1e6 * rival.step_m)},
          {"paths", did.paths},
          {"rows", did.statement.rows_above_floor},
          {"median_rel", number_or_null(did.statement.all.force.median_rel)},
          {"p95_rel", number_or_null(did.statement.all.force.p95_rel)},
          {"within_jnd", number_or_null(did.statement.within_jnd)},
          {"by_path", by_path},
          {"tick_median_us", did.tick_median_us},
          {"tick_p999_us", did.tick_p999_us},
          {"bytes", rival.bytes},
          {"preparation_cpu_s", rival.preparation_cpu_s},
          {"jump_per_10um_N", number_or_null(did.jump_N)},
          {"energy_created_rel", number_or_null(did.created_share)},
          {"rested_share", number_or_null(double(did.rest.rested) / did.rest.rows)}};
}

void write_csv(const std::filesystem::path& path, const ordered_json& tables) {
  std::vector<std::string_view> header(std::begin(kColumns), std::end(kColumns));
  header.insert(header.end(), kPathKindNames.begin(), kPathKindNames.begin() + kUprightKinds);
  CsvWriter csv(path, header);
  const auto put = [&](const ordered_json& value) {
    if (value.is_string())
      csv.text(value.get<std::string>());
    else if (value.is_number_integer())
      csv.integer(value.get<long long>());
    else if (value.is_number())
      csv.number(value.get<double>());
    else
      csv.text("");
  };
  for (const auto& [body, table] : tables.items())
    for (const ordered_json& rival : table.at("rivals")) {
      csv.text(body);
      for (const std::string_view key : std::span(kColumns).subspan(1)) put(rival.at(key));
      for (std::size_t kind = 0; kind < kUprightKinds; ++kind)
        put(rival.at("by_path")
                .value(std::string(kPathKindNames[kind]), ordered_json{{"median_rel", nullptr}})
                .at("median_rel"));
      csv.end_row();
    }
  csv.commit();
}

constexpr const char* kTable = "rivals.json";

// Of each body by its name; empty where none was written.
ordered_json read_tables(const std::filesystem::path& folder) {
  if (!std::filesystem::exists(folder / kTable)) return ordered_json::object();
  return ordered_json::parse(read_whole_file(folder / kTable));
}

ordered_json in_order(const ordered_json& rows) {
  ordered_json out = ordered_json::array();
  for (const RivalRow& rival : kRivals)
    for (const ordered_json& row : rows)
      if (row.at("part").get_ref<const std::string&>() == rival.name) out.push_back(row);
  return out;
}

}  // namespace

RivalsTable::RivalsTable(std::filesystem::path folder, std::string body, std::string asset,
                         bool is_whole)
    : folder_(std::move(folder)), body_(std::move(body)), is_whole_(is_whole) {
  const ordered_json tables = read_tables(folder_);
  if (!is_whole && tables.contains(body_) && tables.at(body_).at("asset") != asset)
    throw Error("bench rivals",
                "\"" + (folder_ / kTable).string() + "\" has another asset of " + body_,
                "Measure all parts first, or give another folder by -o.");
  table_ = {{"asset", asset},
            {"machine", machine()},
            {"reference_p95_rel", {}},
            {"cpu_s", ordered_json::object()},
            {"rivals", ordered_json::array()},
            {"left_out", ordered_json::array()}};
}

void RivalsTable::end(std::string_view part, double cpu_s) {
  table_["cpu_s"][std::string(part)] = cpu_s;
}

void RivalsTable::add(std::string_view part, const Rival& rival, const Performance& did) {
  table_["rivals"].push_back(row_of(part, rival, did));
}

void RivalsTable::leave_out(std::string_view part, const std::string& name,
                            const std::string& why) {
  table_["left_out"].push_back({{"part", part}, {"rival", name}, {"why", why}});
}

void RivalsTable::write(double own_p95) {
  ordered_json tables = read_tables(folder_);
  if (!is_whole_ && tables.contains(body_)) keep_other_parts(tables.at(body_));
  table_["reference_p95_rel"] = number_or_null(own_p95);
  for (const char* rows : {"rivals", "left_out"}) table_[rows] = in_order(table_[rows]);
  tables[body_] = table_;
  write_csv(folder_ / "rivals.csv", tables);
  write_file_atomically(folder_ / kTable, tables.dump(1) + "\n");
}

void RivalsTable::keep_other_parts(const ordered_json& before) {
  const ordered_json measured = table_["cpu_s"];
  for (const char* rows : {"rivals", "left_out"})
    for (const ordered_json& row : before.at(rows))
      if (!measured.contains(row.at("part").get<std::string>())) table_[rows].push_back(row);
  table_["cpu_s"] = before.at("cpu_s");
  table_["cpu_s"].update(measured);
}

}  // namespace palpate::tools
