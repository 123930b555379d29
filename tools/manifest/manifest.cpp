#include "tools/manifest/manifest.hpp"

#include <fmt/core.h>
#include <fnmatch.h>

#include <Eigen/LU>
#include <algorithm>
#include <utility>

#include "libfit/io/atomic_file.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kHeldOutEvery = 5;

void read_registration(SceneTable table, Manifest& manifest) {
  manifest.options.fits_to_surface = table.boolean("icp", false);
  if (table.has("transform")) {
    const auto m = table.numbers("transform", 16, -kAnyNumber, kAnyNumber);
    recordings::RigidMotion motion;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) motion.rotation(r, c) = m[4 * r + c];
      motion.translation_m[r] = m[4 * r + 3];
    }
    const bool is_rigid =
        (motion.rotation * motion.rotation.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff() <
            1e-4 &&
        motion.rotation.determinant() > 0;
    if (!is_rigid || m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
      fail(table, "transform", "transform is no rigid motion",
           "Give 16 numbers row by row: rotation, and translation in m in the last column; the "
           "last row is 0, 0, 0, 1.");
    manifest.options.motion = motion;
  }
  auto landmarks = table.tables("landmarks", "landmarks of [registration]");
  manifest.rig_landmarks_m.resize(landmarks.size(), 3);
  manifest.body_landmarks_m = manifest.rig_landmarks_m;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    manifest.rig_landmarks_m.row(i) = landmarks[i].point("rig");
    manifest.body_landmarks_m.row(i) = landmarks[i].point("body");
    landmarks[i].finish();
  }
  if (manifest.options.motion && !landmarks.empty())
    fail(table, "landmarks", "registration has both a transform and landmarks", "Leave one out.");
  table.finish();
  if (manifest.options.fits_to_surface && !manifest.surface)
    fail(table, "icp", "icp needs a surface", "Say `surface` and `length_unit`.");
}

void read_hold_out(SceneTable table, HoldOut& hold_out) {
  const toml::node* node = table.node("hold_out");
  if (node != nullptr && node->is_array())
    for (const toml::node& name : *node->as_array()) {
      const auto text = name.value<std::string>();
      if (!text)
        fail(table, "hold_out", "hold_out lists what is no name", "Write [\"p003\", \"rim_*\"].");
      hold_out.names.push_back(*text);
    }
  else if (node != nullptr)
    hold_out.every = static_cast<int>(table.integer("hold_out", kHeldOutEvery, 0, 100000));
  if (hold_out.every == 1)
    fail(table, "hold_out", "hold_out = 1 leaves nothing to fit",
         "Hold out every 5th point, or 0 for none.");
  table.finish();
}

// The tip of a recording in the words of a scene's probe.
ProbeSpec probe_of(const recordings::UsedTip& used, double friction) {
  ProbeSpec probe = sphere_spec(used.radius_m, friction);
  if (used.tip == recordings::Tip::flat) probe.shape = "flat";
  if (used.tip == recordings::Tip::sphere || used.tip == recordings::Tip::flat) return probe;
  probe.shape = "cone";
  probe.values = {{"tip_radius", {used.radius_m}}};
  if (used.half_angle_rad > 0) probe.values["half_angle"] = {used.half_angle_rad};
  return probe;
}

// Checks what an entry must say by the time all of it is known, and turns its position into m.
void complete(const SceneTable& table, ManifestEntry& entry) {
  recordings::BatchItem& item = entry.item;
  if (entry.file.empty())
    throw Error(table.where_table(), "[[recording]] has no file", "Add file = \"...\".");
  const auto& c = item.read.columns;
  const bool is_robot = item.read.format == "robot-palpation";
  if (is_robot || c.has_signal()) {  // else the file says itself what its columns are
    if (!item.read.is_force_on_tool)
      throw Error(
          table.where_table(), "force_on is missing: whose force the sensor reports",
          "Add force_on = \"tool\" (what the sensor feels) or \"body\" (what the body feels).");
    if (!is_robot && (c.force.empty() || (c.depth.empty() && c.position.empty())))
      throw Error(
          table.where("columns"),
          c.force.empty() ? "columns names no force" : "columns names neither depth nor position",
          "Add columns = { time = \"t\", position = [\"x\", \"y\", \"z\"], force = [\"fx\", "
          "\"fy\", \"fz\"] }, or depth = \"d\" for a 1-axis rig.");
    if (!is_robot && !c.depth.empty() && !c.position.empty())
      throw Error(table.where("columns"), "columns names both depth and position",
                  "Leave one out.");
    if (c.position.size() == 1 && item.read.format == "csv")
      throw Error(table.where("columns"), "position of columns has one name",
                  "Give three, or call it depth.");
  }
  if (entry.position) {
    const std::string& unit = item.read.units.position;
    const auto factor =
        unit_factor(importers::split_unit(fmt::format("({})", unit)).second, Dimension::length);
    if (!factor)
      throw Error(
          table.where("position"), "position has no unit",
          "Say units = { position = \"mm\" }, or write [\"12 mm\", \"3.5 mm\", \"40 mm\"].");
    item.position_m =
        *factor * Vec3((*entry.position)[0], (*entry.position)[1], (*entry.position)[2]);
  }
}

// The files of an entry: itself, or those that its pattern in the last component matches, sorted. A
// summary that an import left there is none of them.
std::vector<std::string> files_of(const SceneTable& table, const std::string& file,
                                  const fs::path& folder) {
  if (file.find_first_of("*?") == std::string::npos) return {file};
  const fs::path parent = fs::path(file).parent_path();
  const std::string pattern = fs::path(file).filename().string();
  std::vector<std::string> files;
  std::error_code failure;
  const fs::path place = folder / parent;
  for (const auto& entry : fs::directory_iterator(place.empty() ? "." : place, failure))
    if (fnmatch(pattern.c_str(), entry.path().filename().c_str(), FNM_PERIOD) == 0 &&
        !entry.path().filename().string().ends_with(".import.csv"))
      files.push_back((parent / entry.path().filename()).string());
  if (files.empty())
    throw Error(table.where("file"), "no file matches \"" + file + "\"",
                "Correct the pattern; names start at the manifest's folder.");
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::vector<ProbeSpec> probes_of(const Manifest& manifest,
                                 const std::vector<recordings::UsedTip>& tips) {
  std::vector<ProbeSpec> out;
  for (const recordings::UsedTip& tip : tips) out.push_back(probe_of(tip, manifest.friction));
  if (!out.empty()) return out;
  ProbeSpec unknown;
  unknown.shape = "point";
  unknown.friction = manifest.friction;
  return {unknown};
}

bool is_manifest(const fs::path& path) {
  try {
    const toml::table document = parse_toml(read_whole_file(path), path.string(), "");
    return document.contains("recording") && !document.contains("body");
  } catch (const Error&) {
    return false;
  }
}

std::vector<char> held_out_points(const Manifest& manifest, const Samples& samples,
                                  bool by_default) {
  const auto points = static_cast<std::size_t>(samples.points());
  const HoldOut& wanted = manifest.hold_out;
  std::vector<char> is_held_out(points, 0);
  if (points == 0) return is_held_out;
  // Fewer than ten points are all needed.
  const bool is_default = by_default && points >= 10 && wanted.names.empty();
  const auto every =
      static_cast<std::size_t>(wanted.every.value_or(is_default ? kHeldOutEvery : 0));
  for (std::size_t block = 0; every > 0 && (block + 1) * every <= points; ++block)
    is_held_out[block * every + (2 * block + every / 2) % every] = 1;
  for (const std::string& name : wanted.names) {
    bool is_known = false;
    for (std::size_t p = 0; p < points; ++p)
      if (fnmatch(name.c_str(), samples.point_name[p].c_str(), 0) == 0) {
        is_held_out[p] = 1;
        is_known = true;
      }
    if (!is_known)
      throw Error(manifest.path.string(),
                  "hold_out names \"" + name + "\", and no point is so called",
                  "Points have the names that `point` says, or their files'.");
  }
  const auto held_out = std::ranges::count(is_held_out, 1);
  if (held_out > 0 && static_cast<std::size_t>(held_out) + 3 > points)
    throw Error(manifest.path.string(),
                fmt::format("hold_out leaves {} of {} points to fit",
                            points - static_cast<std::size_t>(held_out), points),
                "Hold out fewer, or none: hold_out = 0 in [validate].");
  return is_held_out;
}

void read_as_passes(Manifest& manifest) {
  for (recordings::BatchItem& item : manifest.items) item.signal.is_pass = true;
  manifest.options.relaxation = recordings::RelaxationUse::none;  // found with the curves
}

Manifest read_manifest(const fs::path& path, KeyLog* log) {
  Manifest manifest;
  manifest.path = path;
  const toml::table document =
      parse_toml(read_whole_file(path), path.string(), "Correct the TOML there.");
  SceneTable root(document, "the manifest", path.string(), log);
  const fs::path folder = path.parent_path();
  if (root.has("surface")) {
    manifest.surface = folder / root.text("surface", "");
    manifest.length_unit_m = root.length_unit();
  } else {
    root.text("length_unit", "");
  }
  double& tolerance_m = manifest.options.place_tolerance_m;
  tolerance_m = root.quantity("place_tolerance", Dimension::length, tolerance_m, 0, 1e3);
  const std::string relaxation = root.choice("relaxation", "auto", {"auto", "none", "apply"});
  manifest.options.relaxation = relaxation == "none"    ? recordings::RelaxationUse::none
                                : relaxation == "apply" ? recordings::RelaxationUse::always
                                                        : recordings::RelaxationUse::where_sure;
  read_registration(root.table("registration", "[registration]"), manifest);
  read_hold_out(root.table("validate", "[validate]"), manifest.hold_out);
  manifest.fit = read_fit(root.table("fit", "[fit]"), path);
  ManifestEntry defaults;
  std::optional<double> friction;
  SceneTable defaults_table = root.table("defaults", "[defaults]");
  read_keys(defaults_table, defaults);
  manifest.said_by_default = std::exchange(defaults.item.read.said, {});
  for (SceneTable& table : root.tables("recording", "[[recording]]")) {
    ManifestEntry entry = defaults;
    entry.item.place = table.where_table();
    read_keys(table, entry);
    complete(table, entry);
    if (entry.friction && friction.value_or(*entry.friction) != *entry.friction)
      fail(table, "probe", "probe has another friction than that of a recording before it",
           "Import the recordings of each probe into samples of their own.");
    if (entry.friction) manifest.friction = *(friction = entry.friction);
    const auto files = files_of(table, entry.file, folder);
    for (const std::string& file : files) {
      recordings::BatchItem item = files.size() == 1 ? std::move(entry.item) : entry.item;
      item.shown = file;
      item.file = folder / file;
      manifest.items.push_back(std::move(item));
    }
  }
  root.finish();
  if (manifest.items.empty())
    throw Error(path.string(), "names no recording", "Add [[recording]] with file = \"...\".");
  if (std::ranges::any_of(manifest.items, [](const recordings::BatchItem& item) {
        return item.signal.kind == ExperimentKind::scan;
      })) {
    if (root.has("relaxation"))
      fail(root, "relaxation", "relaxation does nothing for a scan",
           "Leave it out: relaxation is found with the curves.");
    read_as_passes(manifest);
  }
  return manifest;
}

}  // namespace palpate::tools
