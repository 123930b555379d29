#include "tools/report/figures.hpp"

#include <fmt/core.h>

#include <map>

#include "libfit/io/atomic_file.hpp"
#include "tools/report/figure_parts.hpp"

namespace palpate::tools {
namespace {

std::string plain(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

void scatter(Svg& svg, const Json& contents, double floor_N, double share) {
  const Json& held = contents["held_out"];
  const Rows reference = rows(held["force_N"]), engine = rows(held["engine_N"]);
  const auto path = held["path"].get<std::vector<std::string>>();
  std::vector<std::string> kinds;
  std::map<std::string, Numbers> force, error;
  const ForceUnit unit(reference.rowwise().norm().maxCoeff());
  double highest = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (!force.count(path[i])) kinds.push_back(path[i]);
    force[path[i]].push_back(reference.row(row).norm() * unit.factor);
    error[path[i]].push_back((engine.row(row) - reference.row(row)).norm() * unit.factor);
    highest = std::max(highest, error[path[i]].back());
  }
  const double reach = 1.04 * reference.rowwise().norm().maxCoeff() * unit.factor;
  const double floor = floor_N * unit.factor;
  const Numbers at{0, std::min(floor / share, reach), reach};
  Numbers limit;
  for (const double f : at) limit.push_back(std::max(floor, share * f));
  highest = 1.05 * std::max(highest, limit.back());
  Plot plot(svg, 42, 20, 232, 190,
            {fmt::format("force of the reference [{}]", unit.name), 0, reach},
            {fmt::format("error [{}]", unit.name), 0, highest}, "every held-out row");
  plot.band(at, Numbers(3, 0), limit, "fill=\"#e6e6e6\"");
  plot.line(at, limit, "stroke=\"black\" stroke-width=\"0.8\" stroke-dasharray=\"4 2\"");
  double x = 42, y = 228;
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    plot.marks(kinds[k], force[kinds[k]], error[kinds[k]], kMarkers[k % kMarkers.size()],
               marker_style(k));
    if (k == 3) x = 42, y += 12;
    svg.legend(x, y, kMarkers[k % kMarkers.size()], marker_style(k), plain(kinds[k]));
  }
  svg.legend(x, y, "M-6-3h12v6h-12z", "fill=\"#e6e6e6\" stroke=\"black\" stroke-width=\"0.4\"",
             "not felt");
}

// Null: no row is above the body's floor.
bool counts(const Json& figures) { return figures["p95_rel"].is_number(); }

void bars(Svg& svg, const Json& statement, double share) {
  std::vector<std::pair<std::string, const Json*>> lines;
  for (const Json& section : statement["sections"]) {
    const std::string group = section["name"];
    if (group == "baselines" || statement[group].empty()) continue;  // they are off by far more
    if (!lines.empty()) lines.emplace_back("", nullptr);
    for (const auto& [name, figures] : statement[group].items())
      lines.emplace_back(plain(name), &figures);
  }
  double highest = 1.15 * share;
  for (const auto& [name, figures] : lines)
    if (figures && counts(*figures))
      highest = std::max(highest, 1.05 * (*figures)["p95_rel"].get<double>());
  const double left = 330, top = 20, bottom = 190,
               step = (bottom - top) / static_cast<double>(std::max<std::size_t>(lines.size(), 1)),
               thick = std::min(0.76 * step, 12.0);
  const Plot plot(svg, left, top, 460, bottom, {"error [% of the force]", 0, 100 * highest},
                  {"", 0, 1, false}, "by path, by cause and by tool");
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!lines[i].second) continue;
    const double y = top + (static_cast<double>(i) + 0.5) * step;
    svg.text(left - 5, y + 2.8, lines[i].first, "end");
    if (!counts(*lines[i].second)) {
      svg.text(left + 3, y + 2.8, "no row counts", "start");
      continue;
    }
    const auto bar = [&](const char* key, double height, const char* style) {
      const double value = 100 * (*lines[i].second)[key].get<double>();
      svg.add(
          fmt::format("<rect class=\"{}\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" "
                      "height=\"{:.2f}\" {}/>",
                      key, left, y - height / 2, plot.x(value) - left, height, style));
    };
    bar("p95_rel", thick, "fill=\"#9ecae9\" stroke=\"#0072b2\" stroke-width=\"0.5\"");
    bar("median_rel", thick / 2, "fill=\"#0072b2\"");
  }
  svg.add(
      fmt::format("<path d=\"M{:.2f} {}V{}\" stroke=\"black\" stroke-width=\"0.8\" "
                  "stroke-dasharray=\"4 2\"/>",
                  plot.x(100 * share), top, bottom));
  double x = left - 70;
  svg.legend(x, 228, "M-6-2h12v4h-12z", "fill=\"#0072b2\"", "median");
  svg.legend(x, 228, "M-6-3h12v6h-12z", "fill=\"#9ecae9\" stroke=\"#0072b2\"", "95th percentile");
  x = left - 70;
  svg.legend(x, 240, "M-6 0h12", "stroke=\"black\" stroke-dasharray=\"4 2\"",
             fmt::format("just noticeable, {:.0f} %", 100 * share));
}

std::string error_svg(const Json& contents) {
  Svg svg(kWidth_pt, 250,
          "Error at held-out contact points of " + contents["name"].get<std::string>());
  const double share = contents["jnd"]["share"];
  scatter(svg, contents, contents["jnd"]["floor_N"], share);
  bars(svg, contents["statement"], share);
  return svg.str();
}

std::string placement_svg(const Json& contents) {
  const Json& placement = contents["placement"];
  const auto points = placement["points"].get<Numbers>();
  Numbers all[3];
  constexpr const char* kNames[] = {"median_rel", "p95_rel", "max_rel"};
  constexpr const char* kWords[] = {"median", "95th percentile", "largest"};
  double highest = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    for (const double share : placement[kNames[k]].get<Numbers>()) all[k].push_back(100 * share);
    highest = std::max(highest, most(all[k]));
  }
  Svg svg(241, 200,
          "Error of predictions at new test points over the points that predicted, of " +
              contents["name"].get<std::string>());
  Plot plot(svg, 42, 15, 231, 140, {"test points that predicted", 0, 1.04 * most(points)},
            {"error at new ones [% of the force]", 0, 1.05 * highest});
  const double jnd = 100 * contents["jnd"]["share"].get<double>();
  plot.line({0, 1.04 * most(points)}, {jnd, jnd},
            "stroke=\"black\" stroke-width=\"0.8\" stroke-dasharray=\"4 2\"");
  double x = 30, y = 180;
  for (std::size_t k = 0; k < 3; ++k) {
    plot.line(points, all[k], fmt::format("stroke=\"{}\"", kSeriesColours[k]));
    plot.marks(kNames[k], points, all[k], kMarkers[k], marker_style(k));
    svg.legend(x, y, kMarkers[k], marker_style(k), kWords[k]);
  }
  x = 30;
  svg.legend(x, y + 12, "M-6 0h12", "stroke=\"black\" stroke-dasharray=\"4 2\"",
             fmt::format("just noticeable, {:.0f} %", jnd));
  return svg.str();
}

}  // namespace

std::vector<std::string> write_figures(const Json& contents, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::vector<std::string> names;
  const auto write = [&](const char* name, const std::string& svg) {
    write_file_atomically(folder / name, svg);
    names.push_back(name);
  };
  const auto has = [&](const char* key) { return contents.contains(key); };
  const bool has_points = has("points") && !contents["points"]["name"].empty();
  if (has_points && has("rows")) write("curves.svg", curves_svg(contents));
  if (has("statement") && has("held_out") && !contents["held_out"]["path"].empty())
    write("error.svg", error_svg(contents));
  if (has_points && has("maps")) write("stiffness.svg", stiffness_svg(contents));
  if (has("placement")) write("placement.svg", placement_svg(contents));
  return names;
}

}  // namespace palpate::tools
