#include "tools/setup/propose_manifest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/recordings/batch/batch.hpp"
#include "libfit/recordings/formats/columns.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;
using namespace recordings;

constexpr std::uintmax_t kMaxBytes = std::uintmax_t{256} << 20;
constexpr double kSideways = 1.0 / 3;  // of the depth: a press that went so far aside is a drag

// The first line that is no comment, split; empty of files that are no text.
std::vector<std::string> header_of(const fs::path& path, const std::string& bytes) {
  try {
    const std::string text = importers::is_utf16(bytes) ? importers::utf8_of(path, bytes) : bytes;
    const importers::TextFile file(path, text, "latin-1");
    for (std::size_t i = 0; i < file.lines(); ++i) {
      const std::string_view line = importers::trimmed(file.line(i));
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

bool is_robot(const std::vector<std::string>& header) {
  const auto has = [&](std::string_view stem) {
    return std::ranges::any_of(
        header, [&](const std::string& name) { return name.find(stem) != std::string::npos; });
  };
  return has("contact_x") && has("normal_x") && has("force_x") && has("current_x") &&
         has("desired_x");
}

// A way to read a file, and the words of the manifest for it.
struct FileWay {
  importers::ReadSettings read;
  ExperimentKind kind = ExperimentKind::press;
  std::vector<std::string> lines;  // of the manifest
  std::vector<std::string> guesses;
};

// What a quantity without a unit is measured in, by its name; empty: none that is known.
std::string unit_guess(const std::string& name, const char* length, const char* force) {
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

FileWay with_units(FileWay way, const char* length, const char* force) {
  way.read.units.time = "s";
  way.read.units.position = length;
  way.read.units.force = force;
  way.lines.push_back(
      fmt::format("units = {{ time = \"s\", position = \"{}\", force = \"{}\" }}", length, force));
  way.guesses.push_back(fmt::format("units {} and {}, which no header says", length, force));
  return way;
}

// Columns by names that say quantity and unit, else by those that say the quantity alone.
std::vector<FileWay> ways_of_columns(const std::vector<std::string>& header) {
  std::vector<FileWay> out;
  if (const auto named = importers::columns_named(header);
      named.problem.empty() && is_whole(named.columns)) {
    FileWay way;
    way.read.columns = named.columns;
    way.lines.push_back(columns_line(named.columns));
    return {std::move(way)};
  }
  for (const auto& [length, force] : kUnits) {
    std::map<std::string, std::string> as_written;
    std::vector<std::string> told;
    for (const std::string& name : header) {
      const std::string unit = unit_guess(name, length, force);
      told.push_back(unit.empty() ? name : fmt::format("{} ({})", name, unit));
      as_written[told.back()] = name;
    }
    importers::ColumnNames columns = importers::columns_named(told).columns;
    if (!is_whole(columns)) return out;
    for (std::string* name : {&columns.time, &columns.depth})
      if (!name->empty()) *name = as_written[*name];
    for (auto* names : {&columns.position, &columns.force, &columns.torque})
      for (std::string& name : *names) name = as_written[name];
    FileWay way;
    way.read.columns = columns;
    way.lines.push_back(columns_line(columns));
    out.push_back(with_units(std::move(way), length, force));
  }
  return out;
}

std::vector<FileWay> ways_of_robot(const std::vector<std::string>& header) {
  std::vector<FileWay> out;
  FileWay way;
  way.read.format = "robot-palpation";
  way.lines.push_back("format = \"robot-palpation\"");
  const bool says_units = std::ranges::none_of(
      header, [](const std::string& name) { return name == "contact_x" || name == "force_x"; });
  if (says_units) return {way};
  for (const auto& [length, force] : kUnits) out.push_back(with_units(way, length, force));
  return out;
}

// Every way in which a file may be meant, the likeliest first.
std::vector<FileWay> ways_of(const fs::path& path, const std::string& bytes) {
  std::vector<FileWay> out{FileWay{}};
  const std::vector<std::string> header = header_of(path, bytes);
  const bool is_of_robot = is_robot(header);
  for (const FileWay& way : is_of_robot ? ways_of_robot(header) : ways_of_columns(header))
    for (const bool is_on_tool : {true, false})
      for (const bool is_outward : {false, true}) {
        if (is_outward && !is_of_robot) continue;
        FileWay signs = way;
        signs.read.is_force_on_tool = is_on_tool;
        signs.read.is_normal_outward = is_outward;
        signs.lines.push_back(fmt::format("force_on = \"{}\"", is_on_tool ? "tool" : "body"));
        if (is_of_robot)
          signs.lines.push_back(fmt::format("normals = \"{}\"", is_outward ? "outward" : "inward"));
        out.push_back(std::move(signs));
      }
  return out;
}

struct TriedWay {
  FileWay way;
  ItemResult result;
};

std::size_t read_ones(const ItemResult& result) { return result.recordings.size(); }

// The way that makes most recordings of a file; of equals the first.
TriedWay best_way(const fs::path& path, std::vector<FileWay> ways) {
  std::vector<BatchItem> items;
  for (const FileWay& way : ways) {
    BatchItem item;
    item.file = path, item.shown = path.filename().string();
    item.read = way.read;
    item.signal.kind = way.kind;
    items.push_back(std::move(item));
  }
  std::vector<ItemResult> results = run_batch(items, {}, {});
  const auto best = std::ranges::max_element(results, [](const ItemResult& a, const ItemResult& b) {
    return read_ones(a) < read_ones(b);
  });
  auto at = static_cast<std::size_t>(best - results.begin());
  if (read_ones(results[at]) == 0 && ways.size() > 1) at = 1;  // says more than an unknown format
  return {std::move(ways[at]), std::move(results[at])};
}

// Whether most of the presses went sideways as a drag does.
bool goes_sideways(const ItemResult& result) {
  std::size_t sideways = 0;
  for (const Conditioned& r : result.recordings) {
    if (r.is_axial || !r.inward || r.deflection_m.rows() == 0) continue;
    const Eigen::VectorXd depth = r.deflection_m * *r.inward;
    const Points aside = r.deflection_m - depth * r.inward->transpose();
    sideways += aside.rowwise().norm().maxCoeff() > kSideways * depth.maxCoeff();
  }
  return 2 * sideways > result.recordings.size();
}

// Files that are read alike: of one folder, ending and header.
struct FilesAlike {
  std::vector<fs::path> files;
};

std::map<std::string, FilesAlike> groups_in(const fs::path& folder, std::vector<fs::path>& meshes) {
  std::map<std::string, FilesAlike> out;
  std::vector<fs::path> all;
  std::error_code failure;
  for (fs::recursive_directory_iterator it(folder, failure), end; !failure && it != end;
       it.increment(failure))
    if (it->is_regular_file() && !it->path().filename().string().starts_with("."))
      all.push_back(it->path());
  if (failure)
    throw Error(folder.string(), "cannot be read: " + failure.message(),
                "Name the folder of the recordings.");
  std::ranges::sort(all);
  static constexpr std::string_view kMeshes[] = {".obj", ".stl", ".ply", ".off"};
  static constexpr std::string_view kOthers[] = {".toml", ".md",   ".pdf", ".png", ".jpg", ".palp",
                                                 ".html", ".json", ".py",  ".m",   ".vtu"};
  for (const fs::path& path : all) {
    const std::string ending = path.extension().string(), name = path.filename().string();
    if (std::ranges::count(kMeshes, ending) > 0) meshes.push_back(path);
    if (std::ranges::count(kMeshes, ending) + std::ranges::count(kOthers, ending) > 0 ||
        name.find(".import.") != std::string::npos || fs::file_size(path) > kMaxBytes ||
        fs::file_size(path) == 0)
      continue;
    std::string head = importers::read_bytes(path, kMaxBytes).substr(0, 4096);
    std::string key = path.parent_path().string() + "\n" + ending + "\n";
    for (const std::string& column : header_of(path, head.substr(0, head.rfind('\n'))))
      if (!importers::parse_number(column, '.')) key += column + "\n";
    out[key].files.push_back(path);
  }
  return out;
}

// "run3/*.csv" where that is all of the files with this ending in their folder; else empty.
std::string pattern_of(const FilesAlike& group) {
  const fs::path& first = group.files.front();
  std::size_t alike = 0;
  for (const auto& entry : fs::directory_iterator(first.parent_path()))
    alike += entry.is_regular_file() && entry.path().extension() == first.extension() &&
             !entry.path().filename().string().starts_with(".");
  if (alike != group.files.size() || alike == 1) return {};
  return (first.parent_path() / ("*" + first.extension().string())).string();
}

constexpr const char* kHead =
    "# Proposed by `palpate new --recordings`. Correct it, then: palpate check, palpate run -o "
    "out.\n"
    "# Every key: docs/formats/manifest.md\n\n";

// The entries of a group, and what is said of it.
void add_group(const FilesAlike& group, const fs::path& base, ProposedManifest& out) {
  const fs::path& first = group.files.front();
  const std::string shown = fs::proximate(first, base).string();
  TriedWay best = best_way(first, ways_of(first, importers::read_bytes(first, kMaxBytes)));
  if (read_ones(best.result) == 0) {
    const Failure failure = best.result.failure           ? *best.result.failure
                            : best.result.refused.empty() ? Failure{shown, "holds nothing", ""}
                                                          : best.result.refused.front().failure;
    out.warnings.push_back(fmt::format(
        "{}{}: not used: {} {}", shown,
        group.files.size() == 1 ? "" : fmt::format(" and {} alike", group.files.size() - 1),
        failure.what, failure.remedy));
    return;
  }
  if (goes_sideways(best.result)) {
    best.way.kind = ExperimentKind::drag;
    TriedWay drag = best_way(first, {best.way});
    if (read_ones(drag.result) > 0) {
      best = std::move(drag);
      best.way.lines.push_back("kind = \"drag\"");
    }
  }
  const Conditioned& r = best.result.recordings.front();
  out.notes.push_back(fmt::format(
      "{}: {}, {}, {}{}", shown, r.source.format,
      counted(static_cast<std::int64_t>(group.files.size()), "file alike", "files alike"),
      counted(static_cast<std::int64_t>(read_ones(best.result)), "recording in the first",
              "recordings in the first"),
      best.result.refused.empty() ? "" : fmt::format(", {} refused", best.result.refused.size())));
  for (const std::string& guess : best.way.guesses)
    out.warnings.push_back(fmt::format("{}: {}: make sure", shown, guess));
  std::string keys;
  for (const std::string& line : best.way.lines) keys += line + "\n";
  if (r.source.tip_radius_m > 0)
    keys += fmt::format("# its files say the probe: radius {:g} mm\n", 1e3 * r.source.tip_radius_m);
  else
    keys +=
        "# probe = { shape = \"sphere\", radius = \"5 mm\" }  # no file says it; moduli and "
        "contacts "
        "need it\n";
  const bool has_place = r.contact_m && r.inward;
  if (!has_place) {
    keys +=
        "# position = [0, 0, 0]  # where on the body, and inward: no file says it\n"
        "# normal = [0, 0, -1]\n";
    out.warnings.push_back(fmt::format("{}: say position and normal of each recording", shown));
  }
  const std::string pattern = has_place ? pattern_of(group) : std::string();
  out.files += group.files.size();
  if (!pattern.empty()) {
    out.text += fmt::format("\n[[recording]]\nfile = \"{}\"\n{}",
                            fs::proximate(pattern, base).string(), keys);
    return;
  }
  for (const fs::path& file : group.files)
    out.text +=
        fmt::format("\n[[recording]]\nfile = \"{}\"\n{}", fs::proximate(file, base).string(), keys);
}

}  // namespace

ProposedManifest propose_manifest(const fs::path& given, const fs::path& manifest) {
  const fs::path folder = fs::absolute(given).lexically_normal(),
                 base = fs::absolute(manifest).lexically_normal().parent_path();
  if (!fs::is_directory(folder))
    throw Error(given.string(), "is no folder", "Name the folder of the recordings.");
  std::vector<fs::path> meshes;
  const auto groups = groups_in(folder, meshes);
  ProposedManifest out;
  out.text = kHead;
  if (meshes.size() == 1)
    out.text += fmt::format(
        "surface = \"{}\"\nlength_unit = \"mm\"  # of the surface: make sure\n"
        "# [registration]\n# icp = true  # fit the recordings' frame to the surface by their "
        "contacts\n",
        fs::proximate(meshes.front(), base).string());
  for (const auto& [key, group] : groups) add_group(group, base, out);
  if (out.files == 0)
    throw Error(given.string(),
                groups.empty() ? "holds no file that could be a recording"
                               : "holds no file that a recording could be read from: " +
                                     listed(out.warnings, "; "),
                "Write a manifest that names the columns: docs/measured-data.md.");
  out.text +=
      "\n# [validate]\n# hold_out = 5  # one of five points is kept from the fit, for the error "
      "statement\n";
  return out;
}

}  // namespace palpate::tools
