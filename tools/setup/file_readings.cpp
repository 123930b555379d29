#include "tools/setup/propose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>

#include "libfit/core/error.hpp"
#include "libfit/core/linear_algebra.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;
using namespace recordings;

constexpr std::string_view kLatin = "latin-1";

bool is_robot(const std::vector<std::string>& header) {
  const auto has = [&](std::string_view stem) {
    return std::ranges::any_of(
        header, [&](const std::string& name) { return name.find(stem) != std::string::npos; });
  };
  return has("contact_x") && has("normal_x") && has("force_x") && has("current_x");
}

// Unit of a quantity without one, by its name; empty: none that is known.
std::string unit_guess(const std::string& name, const char* length, const char* force) {
  if (const auto meaning = importers::meaning_named(name))
    return *meaning == importers::Meaning::time     ? "s"
           : *meaning == importers::Meaning::force  ? force
           : *meaning == importers::Meaning::torque ? ""
                                                    : length;
  std::string small = name;
  for (char& c : small) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (small == "t" || small.starts_with("time")) return "s";
  if (small.starts_with("f") || small.find("force") != std::string::npos ||
      small.starts_with("load") || small.starts_with("push"))
    return force;
  return small.starts_with("t") || small.starts_with("m") ? "" : length;
}

// The lines of the manifest that name columns.
std::string columns_line(const importers::ColumnNames& c) {
  std::string text;
  const auto put = [&](const char* key, const std::vector<std::string>& names) {
    if (names.empty() || names.front().empty()) return;
    std::string list;
    for (const std::string& name : names) list += (list.empty() ? "\"" : ", \"") + name + "\"";
    text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", key,
                        names.size() == 1 ? list : "[" + list + "]");
  };
  put("time", {c.time}), put("depth", {c.depth}), put("position", c.position);
  put("force", c.force), put("torque", c.torque);
  return "columns = { " + text + " }";
}

bool is_whole(const importers::ColumnNames& c) {
  return !c.force.empty() && (!c.depth.empty() || !c.position.empty());
}

constexpr std::array kUnits{std::pair{"mm", "N"}, std::pair{"m", "N"}, std::pair{"mm", "mN"},
                            std::pair{"um", "mN"}, std::pair{"um", "uN"}};

FileReading with_units(FileReading reading, const char* length, const char* force) {
  reading.read.units.time = "s";
  reading.read.units.position = length;
  reading.read.units.force = force;
  reading.lines.push_back(
      fmt::format("units = {{ time = \"s\", position = \"{}\", force = \"{}\" }}", length, force));
  reading.guesses.push_back(fmt::format("units {} and {}, which no header says", length, force));
  return reading;
}

// Columns by names that say quantity and unit, else by those that say the quantity alone.
std::vector<FileReading> readings_by_columns(const std::vector<std::string>& header) {
  std::vector<FileReading> out;
  if (const auto named = importers::columns_named(header);
      named.problem.empty() && is_whole(named.columns)) {
    FileReading reading;
    reading.read.columns = named.columns;
    reading.lines.push_back(columns_line(named.columns));
    return {std::move(reading)};
  }
  for (const auto& [length, force] : kUnits) {
    std::map<std::string, std::string> as_written;
    std::vector<std::string> with_unit;
    for (const std::string& name : header) {
      const std::string unit = unit_guess(name, length, force);
      with_unit.push_back(unit.empty() ? name : fmt::format("{} ({})", name, unit));
      as_written[with_unit.back()] = name;
    }
    importers::ColumnNames columns = importers::columns_named(with_unit).columns;
    if (!is_whole(columns)) return out;
    for (std::string* name : {&columns.time, &columns.depth})
      if (!name->empty()) *name = as_written[*name];
    for (auto* names : {&columns.position, &columns.force, &columns.torque})
      for (std::string& name : *names) name = as_written[name];
    FileReading reading;
    reading.read.columns = columns;
    reading.lines.push_back(columns_line(columns));
    out.push_back(with_units(std::move(reading), length, force));
  }
  return out;
}

std::vector<FileReading> readings_of_robot(const std::vector<std::string>& header) {
  std::vector<FileReading> out;
  FileReading reading;
  reading.read.format = "robot-palpation";
  reading.lines.push_back("format = \"robot-palpation\"");
  const bool says_units = std::ranges::none_of(
      header, [](const std::string& name) { return name == "contact_x" || name == "force_x"; });
  if (says_units) return {reading};
  for (const auto& [length, force] : kUnits) out.push_back(with_units(reading, length, force));
  return out;
}

// UTF-8 unless a byte is none; binary files throw when they are read.
std::string_view encoding_of(const fs::path& path, const std::string& text) {
  try {
    importers::TextFile(path, text, "utf-8");
    return "utf-8";
  } catch (const Error&) {
    return kLatin;
  }
}

}  // namespace

std::vector<std::string> header_of(const fs::path& path, const std::string& bytes) {
  try {
    const std::string text = importers::is_utf16(bytes) ? importers::utf8_of(path, bytes) : bytes;
    const importers::TextFile file(path, text, encoding_of(path, text));
    for (std::size_t i = 0; i < file.lines(); ++i) {
      const std::string_view line = importers::unquoted(file.line(i));
      if (line.empty() || line.starts_with("#")) continue;
      std::vector<std::string> names;
      for (const auto field : importers::split(line, importers::guess_separator(line)))
        names.emplace_back(field);
      return names;
    }
  } catch (const Error&) {  // binary
  }
  return {};
}

std::vector<FileReading> readings_of(const fs::path& path, const std::string& bytes) {
  std::vector<FileReading> out{FileReading{}};
  const std::vector<std::string> header = header_of(path, bytes);
  const bool is_of_robot = is_robot(header),
             is_latin = !importers::is_utf16(bytes) && encoding_of(path, bytes) == kLatin;
  for (const FileReading& reading :
       is_of_robot ? readings_of_robot(header) : readings_by_columns(header))
    for (const bool is_on_tool : {true, false})
      for (const bool is_outward : {false, true}) {
        if (is_outward && !is_of_robot) continue;
        FileReading signs = reading;
        signs.read.is_force_on_tool = is_on_tool;
        signs.read.is_normal_outward = is_outward;
        if (is_latin) {
          signs.read.encoding = kLatin;
          signs.lines.push_back(fmt::format("encoding = \"{}\"", kLatin));
        }
        signs.lines.push_back(fmt::format("force_on = \"{}\"", is_on_tool ? "tool" : "body"));
        if (is_of_robot)
          signs.lines.push_back(fmt::format("normals = \"{}\"", is_outward ? "outward" : "inward"));
        out.push_back(signs);
        if (is_of_robot || signs.read.columns.position.size() != 3) continue;
        signs.kind = ExperimentKind::scan;
        signs.lines.emplace_back("kind = \"scan\"");
        out.push_back(std::move(signs));
      }
  return out;
}

namespace {

// True if the tool slides over an area: in contact it goes aside more than a tenth as far as in and
// out, and farther than `least` diagonals of its region. The deviation of places across the path is
// 0.035 to 0.17 of the diagonal in nine scans, 0.001 or less in drags along a line and presses; one
// scan is lost with 0.04, none gained with 0.01. They go aside by 1.2 to 137 diagonals.
bool is_scan(const ItemResult& result, double least) {
  double most_N = 0, aside_m = 0, inward_m = 0;
  for (const Conditioned& pass : result.recordings)
    most_N = std::max(most_N, pass.force_N.rowwise().norm().maxCoeff());
  Eigen::AlignedBox3d region;
  Mat3 squares = Mat3::Zero();
  Vec3 sum = Vec3::Zero();
  double rows = 0;
  for (const Conditioned& pass : result.recordings) {
    const auto touches = [&](Eigen::Index row) {
      return pass.force_N.row(row).norm() > 0.02 * most_N;
    };
    for (Eigen::Index row = 1; row < pass.force_N.rows(); ++row) {
      if (!touches(row - 1) || !touches(row)) continue;
      const Vec3 step = pass.deflection_m.row(row) - pass.deflection_m.row(row - 1);
      const double inward = step.dot(*pass.inward);
      inward_m += std::abs(inward);
      aside_m += (step - inward * *pass.inward).norm();
      const Vec3 place = Vec3(pass.deflection_m.row(row)) + *pass.contact_m,
                 flat = place - place.dot(*pass.inward) * *pass.inward;
      region.extend(place);
      squares += flat * flat.transpose(), sum += flat, ++rows;
    }
  }
  if (rows == 0) return false;
  const Mat3 spread = squares / rows - sum * sum.transpose() / (rows * rows);
  const double size_m = region.diagonal().norm(), across_m2 = symmetric_eigen(spread).values[1];
  return aside_m > 0.1 * inward_m && aside_m > least * size_m &&
         across_m2 > std::pow(0.02 * size_m, 2);
}

}  // namespace

TriedReading best_reading(const fs::path& path, std::vector<FileReading> readings) {
  std::vector<BatchItem> items;
  for (const FileReading& reading : readings) {
    BatchItem item;
    item.file = path, item.shown = path.filename().string();
    item.read = reading.read;
    item.signal.kind = reading.kind;
    items.push_back(std::move(item));
  }
  std::vector<ItemResult> results = run_batch(items, {}, {});
  std::size_t places = 0;  // of presses: several are no scan whose path is short
  for (std::size_t i = 0; i < items.size(); ++i)
    if (items[i].signal.kind != ExperimentKind::scan)
      places = std::max(places, results[i].recordings.size());
  for (std::size_t i = 0; i < items.size(); ++i)
    if (items[i].signal.kind == ExperimentKind::scan && !is_scan(results[i], places > 1 ? 4 : 1))
      results[i].recordings.clear();
  const auto best = std::ranges::max_element(results, [](const ItemResult& a, const ItemResult& b) {
    return a.recordings.size() < b.recordings.size();
  });
  auto at = static_cast<std::size_t>(best - results.begin());
  if (results[at].recordings.empty() && readings.size() > 1)
    at = 1;  // says more than an unknown format
  return {std::move(readings[at]), std::move(results[at])};
}

}  // namespace palpate::tools
