#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "libfem/probes/probes.hpp"
#include "libfit/core/experiments.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/validation/causes.hpp"
#include "libfit/validation/replay.hpp"
#include "tools/stages/samples/experiment_table.hpp"
#include "tools/stages/validate.hpp"

namespace palpate::tools {
namespace {

using namespace validation;
using Lines = std::vector<StatedError>;

// Floors of rows of another tool: of the force, that of the body.
ErrorFloors floors_of(const StatedAsset& of, const Comparison& compared) {
  ErrorFloors floors = validation::floors_of(compared);
  floors.force_N = of.floors.force_N;
  return floors;
}

// The paths' rows in groups. group: of a row of reference.paths.
Lines grouped(const StatedAsset& of, std::span<const std::string_view> names,
              const std::function<std::size_t(Eigen::Index row)>& group) {
  return errors_by(compare(of.reference.paths, of.engine, of.levers), of.floors, names, group);
}

// By the kind of path of rows.
std::function<std::size_t(Eigen::Index)> kinds_of(const Samples& rows) {
  return [&](Eigen::Index row) { return static_cast<std::size_t>(rows.path_of(row)); };
}

// The scene's probe is another than that of the asset.
bool is_other_tool(const StatedAsset& of) { return &of.met != &of.asset; }

Lines by_path(const StatedAsset& of) {
  return grouped(of, kPathKindNames, kinds_of(of.reference.paths));
}

// By the speed of the first row, which a path keeps to its end.
Lines by_speed(const StatedAsset& of) {
  if (!relaxes(of.scene)) return {};
  const std::vector<double>& speeds = of.scene.validate.speeds_m_s;
  std::vector<std::string> words;
  for (const double speed : speeds) words.push_back(fmt::format("{:g} mm/s", 1e3 * speed));
  const std::vector<std::string_view> names(words.begin(), words.end());
  const Samples& rows = of.reference.paths;
  std::vector<std::size_t> group(rows.rows(), speeds.size());
  for (Eigen::Index row = 0; row < rows.rows(); ++row) {
    if (row > 0 && rows.experiment[row] == rows.experiment[row - 1]) {
      group[row] = group[row - 1];
    } else if (const double time_s = rows.time_of(row); time_s > 0) {
      const double speed = rows.deflection.row(row).norm() / time_s;
      const auto off = [&](double other) { return std::abs(other - speed); };
      group[row] = std::ranges::min_element(speeds, {}, off) - speeds.begin();
    }
  }
  return grouped(of, names, [&](Eigen::Index row) { return group[row]; });
}

// Deeper than a path has been before, or within what it has softened already.
Lines by_cycle(const StatedAsset& of) {
  static constexpr std::string_view kNames[] = {"primary_loading", "unload_and_reload"};
  if (!softens(of.scene)) return {};
  const Samples& rows = of.reference.paths;
  std::vector<std::size_t> group(rows.rows());
  double deepest_m = 0;
  for (Eigen::Index row = 0; row < rows.rows(); ++row) {
    if (row == 0 || rows.point[row] != rows.point[row - 1]) deepest_m = 0;
    const std::int32_t point = rows.point[row];
    const double m = rows.deflection.row(row).dot(rows.point_normal.row(point));
    group[row] = m > deepest_m ? 0 : 1;
    deepest_m = std::max(deepest_m, m);
  }
  return grouped(of, kNames, [&](Eigen::Index row) { return group[row]; });
}

Lines by_cause(const StatedAsset& of) {
  if (!of.scene.validate.causes || is_other_tool(of)) return {};
  return error_causes(of.asset, of.reference, of.engine, of.depth_m, of.request.jobs);
}

// Another tool's rows by what the asset's own ball would feel, and by that times sqrt(R / R_0), as
// of two balls on a half-space (Hertz 1882); end_m: 0 of a tool that is no ball.
Lines as_own_ball(const StatedAsset& of, const Samples& rows, const ProbeSpec& tool, double end_m,
                  const ErrorFloors& floors) {
  Replayed own = follow(of.asset, rows, of.depth_m);
  Lines lines{stated_error("as_the_assets_ball", compare(rows, own), floors)};
  if (tool.shape != "sphere" || !(end_m > 0)) return lines;
  own.force_N *= std::sqrt(end_m / of.asset.probe_radius_m);
  lines.push_back(stated_error("times_root_of_radius", compare(rows, own), floors));
  return lines;
}

Lines by_baseline(const StatedAsset& of) {
  if (is_other_tool(of))
    return as_own_ball(of, of.reference.paths, of.scene.probe.spec, of.levers->radius_m, of.floors);
  return baseline_errors(of.asset, of.reference, of.depth_m);
}

// Experiments of a kind, answered as the engine plays them, which is timed, and without the
// coupling of their contacts.
Lines of_kind(const StatedAsset& of, ExperimentKind kind, double radius_m) {
  const Samples rows = of_kinds(of.reference.all, {kind});
  Lines lines;
  if (rows.rows() == 0) return lines;
  const PlayedAs as = played_as(of.scene, Purpose::hold_out, rows);
  for (const bool is_coupled : {true, false}) {
    const runtime::AssetView view = is_coupled ? of.asset : coupled_by(of.asset, {});
    const Replayed answered = follow(view, rows, of.depth_m, as);
    const Comparison compared = compare(rows, answered, Levers{radius_m, of.levers->handle_m});
    lines.push_back(
        stated_error(is_coupled ? "felt" : "each_by_itself", compared, floors_of(of, compared)));
  }
  lines[0].tick_ns = time_ticks_ns(of.asset, rows, of.depth_m, as);
  return lines;
}

// Slides where the force of a press changes most, with the floor of all paths.
Lines of_changes(const StatedAsset& of) {
  const Samples rows = paths_of(of.reference.all, true);
  if (rows.rows() == 0) return {};
  const Replayed answer = follow(of.met, rows, of.depth_m);
  const Comparison compared = compare(rows, answer, of.levers);
  Lines lines = errors_by(compared, of.floors, kPathKindNames, kinds_of(rows));
  lines.insert(lines.begin(), stated_error("all", compared, of.floors));
  return lines;
}

Lines of_pairs(const StatedAsset& of) {
  return of_kind(of, ExperimentKind::pair, of.levers->radius_m);
}

Lines of_tool(const StatedAsset& of) { return of_kind(of, ExperimentKind::tool, 0); }

// Each tool beside the probe: all of its paths, those of each kind, and what the asset's own ball
// would feel in its place.
std::vector<StatementSection> of_stated_tools(const StatedAsset& of) {
  std::vector<StatementSection> sections;
  const Samples& all = of.reference.all;
  const auto& tools = other_tools(of.scene, Purpose::hold_out);
  for (std::size_t i = 0; i < tools.size(); ++i) {
    const Samples rows = rows_where(
        all, [&](Eigen::Index row) { return all.probe_of(row) == static_cast<int>(i + 1); });
    if (rows.rows() == 0) continue;
    const PlayedAs as = played_as(of.scene, Purpose::hold_out, rows);
    const Replayed answer = follow(of.asset, rows, of.depth_m, as);
    const double radius_m = fem::round_end_m(*tools[i].probe.rigid);
    const Comparison compared = compare(rows, answer, Levers{radius_m, of.levers->handle_m});
    const ErrorFloors floors = floors_of(of, compared);
    Lines lines{stated_error("all", compared, floors)};
    lines[0].tick_ns = time_ticks_ns(of.asset, rows, of.depth_m, as);
    if (!tools[i].has_balls()) {
      const Lines kinds = errors_by(compared, floors, kPathKindNames, kinds_of(rows));
      lines.insert(lines.end(), kinds.begin(), kinds.end());
      const Lines own = as_own_ball(of, rows, tools[i].probe.spec, radius_m, floors);
      lines.insert(lines.end(), own.begin(), own.end());
    }
    sections.push_back({"tool:" + tools[i].name, "by tool: " + tools[i].name, std::move(lines)});
  }
  return sections;
}

// Recordings have no torque where the rig has no sensor of it: forces alone are compared. Nothing
// where no row was answered.
void add_recorded(Lines& lines, const char* name, const StatedAsset& of, const Samples& rows,
                  const Replayed& answer) {
  const Comparison compared = compare(rows, answer);
  if (!compared.rows.empty()) lines.push_back(stated_error(name, compared, of.floors));
}

Lines by_kind(const StatedAsset& of) {
  const Samples& rows = of.reference.paths;
  const Lines lines =
      errors_by(compare(rows, of.engine), of.floors, kExperimentKindNames,
                [&](Eigen::Index row) { return static_cast<std::size_t>(rows.kind[row]); });
  return lines.size() > 1 ? lines : Lines();
}

// Scans: rows of a tool that sinks or rises, and of a contact that slides or sticks.
Lines by_motion(const StatedAsset& of) {
  static constexpr std::string_view kNames[] = {"pressing", "lifting", "sliding", "sticking"};
  const Samples& rows = of.reference.paths;
  const auto group = [&](bool by_slip) {
    return grouped(of, kNames, [&, by_slip](Eigen::Index row) -> std::size_t {
      if (rows.kind[row] != ExperimentKind::scan) return std::size(kNames);
      if (by_slip) return of.engine.is_sliding[row] ? 2 : 3;
      if (row == 0 || rows.experiment[row - 1] != rows.experiment[row]) return std::size(kNames);
      const Vec3 step = rows.deflection.row(row) - rows.deflection.row(row - 1);
      return step.dot(rows.point_normal.row(rows.point[row])) > 0 ? 0 : 1;
    });
  };
  Lines lines = group(false);
  std::ranges::move(group(true), std::back_inserter(lines));
  return lines;
}

// Scans: rows of contacts that the first recording covered, and beyond its edge or depth.
Lines by_reach(const StatedAsset& of) {
  static constexpr std::string_view kNames[] = {"within", "deeper", "beyond_edge"};
  const Samples& rows = of.reference.paths;
  const Lines lines = grouped(of, kNames, [&](Eigen::Index row) -> std::size_t {
    if (rows.kind[row] != ExperimentKind::scan) return std::size(kNames);
    return of.engine.flags[row] & PALPATE_FLAG_OUTSIDE        ? 2
           : of.engine.flags[row] & PALPATE_FLAG_EXTRAPOLATED ? 1
                                                              : 0;
  });
  return lines.size() > 1 ? lines : Lines();
}

constexpr int kNeighbours = 8;  // of inverse distance

// The recorded presses of points near a place, in place of the asset.
Lines by_recorded_baseline(const StatedAsset& of) {
  Lines lines;
  const auto add = [&](const char* name, const Replayed& answer) {
    add_recorded(lines, name, of, of.reference.paths, answer);
  };
  const Samples &fitted = of.recorded->fitted, &asked = of.reference.paths;
  add("nearest_point", neighbouring_presses(fitted, asked, 1));
  add("inverse_distance", neighbouring_presses(fitted, asked, kNeighbours));
  add("nearest_rows", neighbouring_rows(fitted, asked, kNeighbours));
  add("one_response",
      follow(SubstitutedAsset::with_mean_response(of.asset).view(), asked, of.depth_m));
  return lines;
}

// Rows of fitted points that neighbours surround, each point left out in turn.
Lines of_left_out(const StatedAsset& of) {
  Lines lines;
  if (of.recorded->left_out == nullptr) return lines;
  const Samples& fitted = of.recorded->fitted;
  const Replayed interpolated =
      left_out_presses(*of.request.curves, *of.recorded->left_out, fitted);
  const auto add = [&](const char* name, Replayed answer) {
    for (std::size_t row = 0; row < answer.is_answered.size(); ++row)
      answer.is_answered[row] &= interpolated.is_answered[row];
    add_recorded(lines, name, of, fitted, answer);
  };
  add("interpolated", interpolated);
  add("nearest_point", neighbouring_presses(fitted, fitted, 1));
  add("inverse_distance", neighbouring_presses(fitted, fitted, kNeighbours));
  return lines;
}

Lines followed(const char* name, const StatedAsset& of, const Samples& rows) {
  Lines lines;
  add_recorded(lines, name, of, rows, follow(of.asset, rows, of.depth_m));
  return lines;
}
// Recordings that the asset was made of.
Lines of_fitted(const StatedAsset& of) { return followed("fitted", of, of.recorded->fitted); }
Lines of_places(const StatedAsset& of) { return followed("as_placed", of, of.recorded->as_placed); }
Lines of_beyond(const StatedAsset& of) { return followed("outside", of, of.recorded->beyond); }

struct SectionRow {
  const char *name, *title;
  Lines (*lines)(const StatedAsset&);
  bool is_of_recordings = false;  // else of a simulated reference
};
constexpr SectionRow kSections[] = {
    {"by_path", "by path", by_path},
    {"where_it_changes", "where the body changes", of_changes},
    {"by_speed", "by speed", by_speed},
    {"by_cycle", "by cycle", by_cycle},
    {"causes", "by cause", by_cause},
    {"baselines", "baselines", by_baseline},
    {"two_tools", "two tools on the body", of_pairs},
    {"tool", "the tool, as balls", of_tool},
    {"by_kind", "by kind", by_kind, true},
    {"by_motion", "by motion", by_motion, true},
    {"by_reach", "by reach of what it was fitted to", by_reach, true},
    {"baselines", "baselines", by_recorded_baseline, true},
    {"left_out", "points left out", of_left_out, true},
    {"fitted", "what it was fitted to", of_fitted, true},
    {"as_placed", "where the tool was", of_places, true},
    {"outside", "beyond fitted points", of_beyond, true},
};

}  // namespace

std::vector<StatementSection> statement_sections(const StatedAsset& of) {
  std::vector<StatementSection> sections;
  for (const SectionRow& row : kSections)
    if (row.is_of_recordings == (of.recorded != nullptr))
      sections.push_back({row.name, row.title, row.lines(of)});
  if (of.recorded != nullptr) return sections;
  for (StatementSection& section : of_stated_tools(of)) sections.push_back(std::move(section));
  return sections;
}

void write_compared_rows(const std::filesystem::path& path, const StatedAsset& of) {
  std::vector<std::string_view> header{
      "point", "path",  "step",  "x_m",   "y_m",  "z_m",    "dx_m",    "dy_m",  "dz_m",
      "fx_N",  "fy_N",  "fz_N",  "ex_N",  "ey_N", "ez_N",   "error_N", "tx_Nm", "ty_Nm",
      "tz_Nm", "ux_Nm", "uy_Nm", "uz_Nm", "tool", "lean_1", "lean_2"};
  const Samples& paths = of.reference.paths;
  const bool is_timed =
      of.recorded != nullptr && paths.time_s.size() > 0 && paths.time_s.allFinite();
  if (is_timed) header.push_back("t_s");
  CsvWriter csv(path, header);
  const auto numbers = [&](const auto& row) {
    for (int k = 0; k < row.size(); ++k) csv.number(row[k]);
  };
  const auto write = [&](const Samples& rows, const Replayed& engine, const auto& path_name) {
    for (Eigen::Index row = 0; row < rows.rows(); ++row) {
      if (rows.status[row] != RowStatus::good) continue;
      const auto point = static_cast<std::size_t>(rows.point[row]);
      csv.text(rows.point_name[point]).text(path_name(row)).integer(rows.step[row]);
      numbers(rows.point_position.row(rows.point[row]));
      numbers(rows.deflection.row(row));
      numbers(rows.force.row(row));
      numbers(engine.force_N.row(row));
      csv.number((engine.force_N.row(row) - rows.force.row(row)).norm());
      numbers(rows.torque.row(row));
      numbers(engine.torque_Nm.row(row));
      csv.integer(rows.tool_of(row));
      numbers(rows.lean_at(row));
      if (is_timed) csv.number(rows.time_s[row]);
      csv.end_row();
    }
  };
  write(paths, of.engine, [&](Eigen::Index row) {
    return of.recorded != nullptr ? name_of(paths.kind[row]) : name_of(paths.path_of(row));
  });
  if (of.recorded != nullptr) return csv.commit();
  const Samples changes = paths_of(of.reference.all, true);
  write(changes, follow(of.met, changes, of.depth_m),
        [&](Eigen::Index row) { return name_of(changes.path_of(row)); });
  for (const ExperimentKind kind :
       {ExperimentKind::pair, ExperimentKind::tool, ExperimentKind::other}) {
    const Samples rows = of_kinds(of.reference.all, {kind});
    write(rows, follow(of.asset, rows, of.depth_m, played_as(of.scene, Purpose::hold_out, rows)),
          [&](Eigen::Index) { return name_of(kind); });
  }
  csv.commit();
}

}  // namespace palpate::tools
