// What a millisecond can buy: force error against time of a tick, method by method.

#include "tools/bench/rivals/rivals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "libfit/core/error.hpp"
#include "libfit/core/join_samples.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/experiments/draw.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/bench/bench.hpp"
#include "tools/bench/figure.hpp"
#include "tools/bench/machine.hpp"
#include "tools/bench/rivals/felt.hpp"
#include "tools/bench/rivals/measure.hpp"
#include "tools/console.hpp"
#include "tools/scene/settings.hpp"
#include "tools/stages/body/simulation_setup.hpp"

namespace palpate::tools {
namespace {

constexpr std::string_view kFigures = "figures";  // the part that draws what was measured
constexpr std::string_view kFelt = "felt";  // the part that prepares what a page can answer alike
// Rows of the table that a page can.
constexpr std::string_view kFeltRows[] = {"proxy", "proxy-curves", "separable", "green"};
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
constexpr double kBudget_s = 3, kQuickBudget_s = 1;

// CPU of one point by the simulator, as the run's samples were made.
double point_cpu_s(const RivalBody& body, bool is_dragged) {
  const fem::Simulator simulator(make_setup(body.scene, body.body));
  const TestPoints& points = body.body.test_points;
  const double began_s = cpu_seconds();
  const Vec3 position = points.position.row(0), normal = points.normal.row(0);
  if (is_dragged)
    simulator.press_and_drag(position, normal, body.scene.experiments.each);
  else
    simulator.press_quickly(position, normal, body.scene.experiments.each);
  return cpu_seconds() - began_s;
}

std::filesystem::path file_of(const std::filesystem::path& run, const char* name) {
  if (std::filesystem::exists(run / name)) return run / name;
  throw Error("bench rivals", fmt::format("there is no {} in \"{}\"", name, run.string()),
              "Make it with `palpate run SCENE -o DIR` and give --run DIR.");
}

RivalBody read_run(const std::filesystem::path& run) {
  RivalBody body;
  body.body = read_body(file_of(run, "body.h5"));
  body.scene = scene_of(body.body, run / "body.h5");
  body.samples = of_kinds(read_samples(file_of(run, "samples.h5")),
                          {ExperimentKind::press, ExperimentKind::drag});
  body.paths = of_kinds(read_samples(file_of(run, "reference.h5")), {ExperimentKind::path});
  body.asset = read_asset_file(file_of(run, "asset.palp"));
  body.depth_m = body.scene.experiments.each.depth_m;
  body.radius_m = ball_radius_m(body.body.probe);
  if (!(body.radius_m > 0))
    throw Error("bench rivals", "the probe is no ball, which rivals need", "Give another run.");
  if (body.paths.time_s.size() > 0 || body.paths.rows() == 0)
    throw Error("bench rivals", "the run has no held-out paths in slow motion",
                "Give the run of a body that does not relax.");
  return body;
}

// p95 of what the reference says its own rows are off by.
double own_error(const Samples& paths) {
  std::vector<ForceError> rows;
  for (Eigen::Index row = 0; row < paths.rows(); ++row)
    if (paths.status[static_cast<std::size_t>(row)] == RowStatus::good &&
        std::isfinite(paths.force_error[row]))
      rows.push_back({paths.force_error[row], paths.force.row(row).norm()});
  return stated_quantile(stated_errors(rows), 0.95);
}

// Refuses a name that no rival has; empty: all of them, and the figures.
void check_part(const std::string& part) {
  std::string names = fmt::format("{}, {}", kFigures, kFelt);
  for (const RivalRow& row : kRivals) {
    if (part.empty() || row.name == part) return;
    names += ", " + std::string(row.name);
  }
  throw Error("bench rivals", "there is no rival called " + part, "Use one of: " + names + ".");
}

// The last part of its folder's name.
std::string name_of_run(const std::filesystem::path& run) {
  const std::filesystem::path whole = std::filesystem::absolute(run).lexically_normal();
  return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
}

struct RivalLine {
  Rival rival;
  Performance performance;
};

std::vector<std::string_view> header() {
  std::vector<std::string_view> names{"rival",
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
                                      "energy_created_rel"};
  names.insert(names.end(), kPathKindNames.begin(), kPathKindNames.begin() + kUprightKinds);
  return names;
}

void write_csv(const std::filesystem::path& path, const std::vector<RivalLine>& lines) {
  CsvWriter csv(path, header());
  const auto put = [&](double number) {
    std::isfinite(number) ? csv.number(number) : csv.text("");
  };
  for (const auto& [rival, did] : lines) {
    csv.text(rival.name).text(rival.settings).number(rival.size).number(1e6 * rival.step_m);
    csv.integer(static_cast<long long>(did.paths));
    csv.integer(static_cast<long long>(did.statement.rows_above_floor));
    for (const double number : {did.statement.all.force.median_rel, did.statement.all.force.p95_rel,
                                did.statement.within_jnd, did.tick_median_us, did.tick_p999_us})
      put(number);
    csv.integer(static_cast<long long>(rival.bytes));
    for (const double number : {rival.preparation_cpu_s, did.jump_N, did.created_share})
      put(number);
    for (const validation::StatedError& kind : did.by_path) put(kind.force.median_rel);
    csv.end_row();
  }
  csv.commit();
}

nlohmann::ordered_json number_or_null(double number) {
  return std::isfinite(number) ? nlohmann::ordered_json(number) : nlohmann::ordered_json();
}

nlohmann::ordered_json json_of(const RivalLine& line) {
  const auto& [rival, did] = line;
  nlohmann::ordered_json by_path;
  for (const validation::StatedError& kind : did.by_path)
    by_path[kind.name] = {{"rows", kind.rows},
                          {"median_rel", number_or_null(kind.force.median_rel)},
                          {"p95_rel", number_or_null(kind.force.p95_rel)}};
  return {{"rival", rival.name},
          {"settings", rival.settings},
          {"size", rival.size},
          {"step_m", rival.step_m},
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
          {"energy_created_rel", number_or_null(did.created_share)}};
}

// A series of each name, its x by the key.
std::vector<FigureSeries> series_of(const nlohmann::json& rivals, const char* x) {
  std::vector<FigureSeries> out;
  const auto number = [](const nlohmann::json& value) {
    return value.is_number() ? value.get<double>() : validation::kNoNumber;
  };
  for (const nlohmann::json& rival : rivals) {
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

// Of a JSON that was written, now or earlier.
void write_figures(const std::filesystem::path& folder, const std::string& stem,
                   const std::string& body) {
  const nlohmann::json rivals =
      nlohmann::json::parse(read_whole_file(folder / (stem + ".json"))).at("rivals");
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
  for (const bool is_dark : {false, true}) {
    const std::string end = is_dark ? "_dark.svg" : ".svg";
    write_file_atomically(folder / (stem + "_tick" + end), draw(by_tick, is_dark));
    write_file_atomically(folder / (stem + "_preparation" + end), draw(by_preparation, is_dark));
  }
}

std::vector<Rival> felt_rivals(const RivalBody& body) {
  std::vector<Rival> out;
  for (const RivalRow& row : kRivals) {
    if (std::ranges::find(kFeltRows, row.name) == std::end(kFeltRows)) continue;
    std::vector<Rival> sizes = row.prepare(body);
    out.insert(out.end(), sizes.begin(), sizes.begin() + 1);  // the smallest
  }
  return out;
}

}  // namespace

void bench_rivals(const BenchRequest& request) {
  if (request.part != kFigures && request.part != kFelt) check_part(request.part);
  if (request.run.empty())
    throw Error("bench rivals", "there is no run to compare on",
                "Make one with `palpate run SCENE -o DIR` and give --run DIR.");
  const std::string name = name_of_run(request.run), stem = "rivals_" + name;
  if (request.part == kFigures) return write_figures(request.folder, stem, name);
  RivalBody body = read_run(request.run);
  body.packages = request.packages;
  if (request.part == kFelt) return write_felt(request.run, felt_rivals(body), body);
  body.dragged_cpu_s = point_cpu_s(body, true);
  body.pressed_cpu_s =
      body.samples.point_scale.size() > 0 ? point_cpu_s(body, false) : body.dragged_cpu_s;
  const double own_p95 = own_error(body.paths);
  say("{} paths, {} rows, whose own error is {:.2g} % (p95); a test point takes {:.2g} s of CPU "
      "with drags, {:.2g} s pressed alone",
      body.paths.points(), body.paths.rows(), 100 * own_p95, body.dragged_cpu_s,
      body.pressed_cpu_s);
  std::vector<RivalLine> lines;
  nlohmann::ordered_json rivals = nlohmann::ordered_json::array(),
                         left_out = nlohmann::ordered_json::array();
  for (const RivalRow& row : kRivals) {
    if (!request.part.empty() && row.name != request.part) continue;
    const std::vector<Rival> sizes = row.prepare(body);
    if (sizes.empty()) {
      say("left out: {} ({})", row.name, row.summary);
      left_out.push_back(std::string(row.name));
    }
    for (const Rival& rival : sizes) {
      lines.push_back({rival, measure(rival, body, request.is_quick ? kQuickBudget_s : kBudget_s)});
      const Performance& did = lines.back().performance;
      say("{:<22} {:>6.0f}  {:>6} median, {:>6} p95, tick {:.3g} us, p99.9 {:.3g}; {} bytes, "
          "{:.3g} s; {:.2g} mN per 10 um; loop {:+.2g} %; {} paths: {}",
          rival.name, rival.size, stated_percent(did.statement.all.force.median_rel),
          stated_percent(did.statement.all.force.p95_rel), did.tick_median_us, did.tick_p999_us,
          rival.bytes, rival.preparation_cpu_s, 1e3 * did.jump_N, 100 * did.created_share,
          did.paths, rival.settings);
      rivals.push_back(json_of(lines.back()));
    }
  }
  write_csv(request.folder / (stem + ".csv"), lines);
  write_file_atomically(request.folder / (stem + ".json"),
                        nlohmann::ordered_json{{"machine", machine()},
                                               {"reference_p95_rel", own_p95},
                                               {"rivals", rivals},
                                               {"left_out", left_out}}
                                .dump(1) +
                            "\n");
  write_figures(request.folder, stem, name);
}

}  // namespace palpate::tools
