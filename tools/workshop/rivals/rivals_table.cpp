#include "tools/workshop/rivals/rivals_table.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "libfit/core/error.hpp"
#include "libfit/core/join_samples.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/experiments/draw.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/workshop/bench/figure.hpp"
#include "tools/workshop/bench/machine.hpp"
#include "tools/workshop/rivals/rivals.hpp"

namespace palpate::tools {
namespace {

using nlohmann::ordered_json;

// Of ten steps on the block, refined and corrected: recorded, as FEBio is in no registry.
constexpr double kFebioCpu_s = 69, kFebioError[] = {0.01, 0.017};
constexpr CsvColumnRule kPeerColumns[] = {{"calculix_error_percent", true, true},
                                          {"calculix_CPU_s", true, true},
                                          {"ours_error_percent", true, true},
                                          {"ours_CPU_s", true, true}};
struct PeerSeries {
  const char *name, *error, *cpu;
};
constexpr PeerSeries kPeerSeries[] = {
    {"one press: CalculiX 2.20", "calculix_error_percent", "calculix_CPU_s"},
    {"one press: our simulator", "ours_error_percent", "ours_CPU_s"},
};
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
  ordered_json by_path;
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
        put(rival.at("by_path").at(kPathKindNames[kind]).at("median_rel"));
      csv.end_row();
    }
  csv.commit();
}

// A series of each name, its x by the key.
std::vector<FigureSeries> series_of(const ordered_json& rivals, const char* x) {
  std::vector<FigureSeries> out;
  const auto number = [](const ordered_json& value) {
    return value.is_number() ? value.get<double>() : validation::kNoNumber;
  };
  for (const ordered_json& rival : rivals) {
    const std::string name = rival.at("rival");
    if (out.empty() || out.back().name != name)
      out.push_back({.name = name, .x = {}, .median = {}, .p95 = {}, .is_ours = name == "Palpate"});
    out.back().x.push_back(number(rival.at(x)));
    out.back().median.push_back(number(rival.at("median_rel")));
    out.back().p95.push_back(number(rival.at("p95_rel")));
  }
  return out;
}

// One press by solvers that others use for references: CalculiX as `palpate bench peers` measured
// it here, FEBio as it was recorded on the same block.
std::vector<FigureSeries> single_presses(const std::filesystem::path& folder) {
  std::vector<FigureSeries> out;
  const std::filesystem::path peers = folder / "fem_peers.csv";
  if (std::filesystem::exists(peers)) {
    const CsvTable table = read_csv(peers, kPeerColumns);
    for (const auto& [name, error, cpu] : kPeerSeries) {
      FigureSeries one{.name = name, .x = {}, .median = {}, .p95 = {}};
      std::vector<double> errors;
      for (const std::string& percent : table.text(error))
        if (percent != "-") errors.push_back(std::abs(std::atof(percent.c_str())) / 100);
      if (errors.empty()) continue;
      one.x = {std::atof(table.text(cpu).front().c_str())};
      one.median = {quantile(errors, 0.5)};
      one.p95 = {quantile(errors, 0.95)};
      out.push_back(std::move(one));
    }
  }
  out.push_back({.name = "one press: FEBio 4.11",
                 .x = {kFebioCpu_s},
                 .median = {kFebioError[0]},
                 .p95 = {kFebioError[1]}});
  return out;
}

void write_figures(const std::filesystem::path& folder, const std::string& body,
                   const ordered_json& rivals) {
  const FigureLine jnd{kForceJnd, "JND 7 %"};
  const LogFigure by_tick{.title = "Force error against time of a tick: " + body,
                          .x_label = "median time of a tick in contact [us]",
                          .y_label = "force error: median, thin line to p95",
                          .series = series_of(rivals, "tick_median_us"),
                          .upright = {{1000, "1 kHz"}},
                          .level = {jnd}};
  std::vector<FigureSeries> prepared = series_of(rivals, "preparation_cpu_s");
  for (FigureSeries& press : single_presses(folder)) prepared.push_back(std::move(press));
  const LogFigure by_preparation{.title = "Force error against preparation: " + body,
                                 .x_label = "CPU of preparation [s]",
                                 .y_label = "force error: median, thin line to p95",
                                 .series = std::move(prepared),
                                 .upright = {},
                                 .level = {jnd}};
  const std::filesystem::path stem = folder / ("rivals_" + body);
  for (const bool is_dark : {false, true}) {
    const std::string end = is_dark ? "_dark.svg" : ".svg";
    write_file_atomically(stem.string() + "_tick" + end, draw(by_tick, is_dark));
    write_file_atomically(stem.string() + "_preparation" + end, draw(by_preparation, is_dark));
  }
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
      if (row.at("part") == rival.name) out.push_back(row);
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
  draw_rivals(folder_, body_);
}

void RivalsTable::keep_other_parts(const ordered_json& before) {
  const ordered_json measured = table_["cpu_s"];
  for (const char* rows : {"rivals", "left_out"})
    for (const ordered_json& row : before.at(rows))
      if (!measured.contains(row.at("part").get<std::string>())) table_[rows].push_back(row);
  table_["cpu_s"] = before.at("cpu_s");
  table_["cpu_s"].update(measured);
}

void draw_rivals(const std::filesystem::path& folder, const std::string& body) {
  const ordered_json tables = read_tables(folder);
  if (!tables.contains(body))
    throw Error("bench rivals", "\"" + (folder / kTable).string() + "\" has no " + body,
                "Measure it first.");
  write_figures(folder, body, tables.at(body).at("rivals"));
}

}  // namespace palpate::tools
