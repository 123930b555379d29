#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "libfem/mesh/read/read.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/core/text.hpp"
#include "libfit/recordings/batch/batch.hpp"
#include "libfit/recordings/formats/importers.hpp"
#include "tools/setup/propose.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;
using namespace recordings;

constexpr std::uintmax_t kMaxBytes = std::uintmax_t{256} << 20;
constexpr std::size_t kMinOffsets = 5;

// True if most of the presses went sideways as a drag does.
bool goes_sideways(const ItemResult& result) {
  std::size_t sideways = 0;
  for (const Conditioned& r : result.recordings) {
    if (r.is_axial || !r.inward || r.deflection_m.rows() == 0) continue;
    const Eigen::VectorXd depth = r.deflection_m * *r.inward;
    const Points aside = r.deflection_m - depth * r.inward->transpose();
    // A press that went so far aside, of its depth, is a drag.
    sideways += aside.rowwise().norm().maxCoeff() > 1.0 / 3 * depth.maxCoeff();
  }
  return 2 * sideways > result.recordings.size();
}

// Files that are read alike: of one folder, ending and header.
using FilesAlike = std::vector<fs::path>;

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
        name.find(".import.") != std::string::npos || fs::file_size(path) > kMaxBytes)
      continue;
    std::string head = importers::unpacked(path, importers::read_bytes(path, kMaxBytes), kMaxBytes)
                           .substr(0, 4096);
    std::string key = path.parent_path().string() + "\n" + ending + "\n";
    for (const std::string& column : header_of(path, head.substr(0, head.rfind('\n'))))
      if (!importers::parse_number(column, '.')) key += column + "\n";
    out[key].push_back(path);
  }
  return out;
}

// "run3/*.csv" where that is all of the files with this ending in their folder; else empty.
std::string pattern_of(const FilesAlike& group) {
  const fs::path& first = group.front();
  std::size_t alike = 0;
  for (const auto& entry : fs::directory_iterator(first.parent_path()))
    alike += entry.is_regular_file() && entry.path().extension() == first.extension() &&
             !entry.path().filename().string().starts_with(".");
  if (alike != group.size() || alike == 1) return {};
  return (first.parent_path() / ("*" + first.extension().string())).string();
}

constexpr const char* kHead =
    "# Proposed by `palpate new --recordings`. Correct it, then: palpate check, palpate run -o "
    "out.\n"
    "# Every key: docs/formats/manifest.md\n\n";

// How far from a surface the tool was when it touched, if it was so far off everywhere: then
// positions are of a ball's centre. Nothing where contacts lie on the surface, or here and there.
std::optional<double> offset_m(const std::vector<Conditioned>& recordings, const Surface& surface) {
  std::vector<const Conditioned*> placed;
  for (const Conditioned& r : recordings)
    if (!r.is_axial && r.contact_m && r.inward) placed.push_back(&r);
  if (placed.size() < kMinOffsets) return std::nullopt;
  Points contacts(static_cast<Eigen::Index>(placed.size()), 3);
  for (std::size_t i = 0; i < placed.size(); ++i) contacts.row(i) = *placed[i]->contact_m;
  const auto places = project(contacts, surface);
  std::vector<double> off_m, scatter_m;
  for (std::size_t i = 0; i < placed.size(); ++i)
    if (places[i])
      off_m.push_back((places[i]->position_m - *placed[i]->contact_m).dot(places[i]->inward));
  if (off_m.size() < kMinOffsets) return std::nullopt;
  const double middle_m = upper_median(off_m);
  for (const double m : off_m) scatter_m.push_back(std::abs(m - middle_m));
  // By more than four median deviations, and as large as the balls that robots press.
  const bool is_off =
      middle_m > 4 * upper_median(scatter_m) && middle_m > 0.3e-3 && middle_m < 30e-3;
  return is_off ? std::optional(middle_m) : std::nullopt;
}

// Adds whether positions of a rig with three axes are of a ball's centre, as far as it can be
// known.
void add_positions(const TriedReading& tried, const Surface* surface, const std::string& shown,
                   std::vector<std::string>& lines, ProposedManifest& out) {
  std::optional<double> found_m;
  if (!tried.result.recordings.front().is_axial) {
    if (surface != nullptr) found_m = offset_m(tried.result.recordings, *surface);
    lines.emplace_back("positions = \"center\"");
    if (!found_m)
      lines.back() =
          "# positions = \"center\"  # where they are of the ball's centre, and not of "
          "where it touches";
  }
  if (found_m)
    out.warnings.push_back(fmt::format(
        "{}: tools touched {:.2g} mm off the surface, everywhere: positions are taken for those of "
        "a ball's centre, and that for its radius: make sure",
        shown, 1e3 * *found_m));
  lines.push_back(
      found_m
          ? fmt::format("probe = {{ shape = \"sphere\", radius = \"{:.2g} mm\" }}", 1e3 * *found_m)
          : "# probe = { shape = \"sphere\", radius = \"5 mm\" }  # no file says it; moduli "
            "and contacts need it");
}

// An entry of the manifest, and its lines.
struct ProposedEntry {
  std::string file;
  std::vector<std::string> lines;
};

// The entries, and before them [defaults] with the lines that all of them have.
std::string text_of(std::vector<ProposedEntry> entries) {
  std::vector<std::string> common;
  if (entries.size() > 1) common = entries.front().lines;
  for (const ProposedEntry& entry : entries)
    std::erase_if(common, [&](const auto& l) { return std::ranges::count(entry.lines, l) == 0; });
  std::string text;
  if (!common.empty()) text += "\n[defaults]\n";
  for (const std::string& line : common) text += line + "\n";
  for (ProposedEntry& entry : entries) {
    text += fmt::format("\n[[recording]]\nfile = \"{}\"\n", entry.file);
    std::erase_if(entry.lines, [&](const auto& l) { return std::ranges::count(common, l) > 0; });
    for (const std::string& line : entry.lines) text += line + "\n";
  }
  return text;
}

// The first file of a group that makes recordings, and how; of those before it a warning each.
std::pair<fs::path, TriedReading> first_read(const FilesAlike& group, const fs::path& base,
                                             ProposedManifest& out) {
  std::vector<std::string> warnings;
  std::optional<TriedReading> tried;
  for (const fs::path& file : group) {
    TriedReading best = best_reading(
        file, readings_of(file, importers::unpacked(file, importers::read_bytes(file, kMaxBytes),
                                                    kMaxBytes)));
    if (!best.result.recordings.empty()) {
      out.warnings.insert(out.warnings.end(), warnings.begin(), warnings.end());
      return {file, std::move(best)};
    }
    if (!best.result.refused.empty())
      warnings.push_back(fmt::format("{}: {}; others alike are read",
                                     fs::proximate(file, base).string(),
                                     best.result.refused.front().failure.fact()));
    if (!tried) tried = std::move(best);
  }
  return {group.front(), std::move(*tried)};
}

// The entries of a group, and what is said of it. surface: of the body, where one lies beside.
void add_group(const FilesAlike& group, const fs::path& base, const Surface* surface,
               std::vector<ProposedEntry>& entries, ProposedManifest& out) {
  auto [first, best] = first_read(group, base, out);
  const std::string shown = fs::proximate(first, base).string();
  if (best.result.recordings.empty()) {
    const Error failure = best.result.refused.empty() ? Error{shown, "holds nothing", ""}
                                                      : best.result.refused.front().failure;
    out.warnings.push_back(
        fmt::format("{}{}: not used: {} {}", shown,
                    group.size() == 1 ? "" : fmt::format(" and {} alike", group.size() - 1),
                    failure.fact(), failure.remedy()));
    const auto columns = header_of(
        first, importers::unpacked(first, importers::read_bytes(first, kMaxBytes), kMaxBytes));
    out.unread.push_back(shown + ": " + failure.fact());
    if (first.extension() == ".csv") out.unread.back() += "; its columns: " + listed(columns);
    return;
  }
  if (best.reading.kind != ExperimentKind::scan && goes_sideways(best.result)) {
    best.reading.kind = ExperimentKind::drag;
    TriedReading drag = best_reading(first, {best.reading});
    if (!drag.result.recordings.empty()) {
      best = std::move(drag);
      best.reading.lines.push_back("kind = \"drag\"");
    }
  }
  const Conditioned& r = best.result.recordings.front();
  out.notes.push_back(fmt::format(
      "{}: {}, {}, {}{}", shown, r.source.format,
      counted(static_cast<std::int64_t>(group.size()), "file alike", "files alike"),
      counted(static_cast<std::int64_t>(best.result.recordings.size()), "recording in the first",
              "recordings in the first"),
      best.result.refused.empty() ? "" : fmt::format(", {} refused", best.result.refused.size())));
  for (const std::string& guess : best.reading.guesses)
    out.warnings.push_back(fmt::format("{}: {}: make sure", shown, guess));
  std::vector<std::string> lines = best.reading.lines;
  add_positions(best, surface, shown, lines, out);
  const bool has_place = r.contact_m && r.inward;
  if (!has_place) {
    lines.emplace_back(
        "# position = [\"0 mm\", \"0 mm\", \"0 mm\"]  # where on the body, and inward: "
        "no file says it");
    lines.emplace_back("# normal = [0, 0, -1]");
    out.warnings.push_back(fmt::format("{}: say position and normal of each recording", shown));
  }
  const std::string pattern = has_place ? pattern_of(group) : std::string();
  out.files += group.size();
  for (const fs::path& file : group) {
    const std::string& named = pattern.empty() ? file.string() : pattern;
    entries.push_back({fs::proximate(named, base).string(), lines});
    if (!pattern.empty()) break;
  }
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
  std::optional<Surface> surface;
  try {
    if (meshes.size() == 1) surface = read_surface(meshes.front(), 1e-3);  // as the manifest says
  } catch (const Error&) {  // `check` is going to say what is wrong with it
  }
  std::vector<ProposedEntry> entries;
  for (const auto& [key, group] : groups)
    add_group(group, base, surface ? &*surface : nullptr, entries, out);
  out.text += text_of(std::move(entries));
  if (out.files == 0)
    throw groups.empty()
        ? Error(given.string(), "holds no file that could be a recording",
                "Name the folder that the rig's files are in.")
        : Error(given.string(),
                "holds no file that a recording could be read from (" + listed(out.unread, "; ") +
                    ")",
                "Mend what the brackets name, or write a manifest that names the columns, as "
                "docs/measured-data.md has one.");
  out.text +=
      "\n# [validate]\n# hold_out = 5  # one of five points is kept from the fit, for the error "
      "statement\n";
  return out;
}

}  // namespace palpate::tools
