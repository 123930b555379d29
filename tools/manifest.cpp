#include "tools/manifest.hpp"

#include <fmt/format.h>
#include <fnmatch.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "libfit/io/atomic_file.hpp"
#include "libfit/io/importers/importers.hpp"
#include "libfit/recordings/contact.hpp"
#include "tools/scene_table.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;
using recordings::BatchItem;
using recordings::Drift;
using recordings::Tip;

constexpr double kMostMebibytes = 1 << 20;

// A recording's entry on its way: what [defaults] said, then what the entry says.
struct Entry {
  BatchItem item;
  std::string file;
  std::optional<std::vector<double>> position;  // in units.position
  std::vector<std::string> position_text;       // or quantities
  std::optional<bool> is_force_on_tool;
};

[[noreturn]] void fail(const SceneTable& table, std::string_view key, const std::string& what,
                       const std::string& remedy) {
  throw Error(table.where(key), what, remedy);
}

// A column's name, or its number in a file without header.
std::string column(SceneTable& table, std::string_view key, const toml::node& node) {
  if (node.is_string()) return node.as_string()->get();
  if (node.is_integer() && node.as_integer()->get() > 0)
    return fmt::format("#{}", node.as_integer()->get());
  fail(table, key, fmt::format("{} of columns is no column", key),
       "Give a name of the header in quotes, or a number counted from 1.");
}

void read_column(SceneTable& table, std::string_view key, std::string& target) {
  if (const toml::node* node = table.node(key)) target = column(table, key, *node);
}

// counts: how many names are right.
void read_columns_of(SceneTable& table, std::string_view key, std::vector<std::string>& target,
                     bool may_be_one) {
  const toml::node* node = table.node(key);
  if (!node) return;
  target.clear();
  if (const toml::array* list = node->as_array())
    for (const toml::node& name : *list) target.push_back(column(table, key, name));
  else
    target.push_back(column(table, key, *node));
  if (target.size() != 3 && !(may_be_one && target.size() == 1))
    fail(table, key, fmt::format("{} of columns has {} names", key, target.size()),
         may_be_one ? "Give one name, or three: [\"x\", \"y\", \"z\"]."
                    : "Give three: [\"x\", \"y\", \"z\"].");
}

void read_columns(SceneTable table, importers::ColumnNames& names) {
  read_column(table, "time", names.time), read_column(table, "force_time", names.force_time);
  read_column(table, "depth", names.depth);
  read_column(table, "retract_depth", names.retract_depth),
      read_column(table, "retract_force", names.retract_force);
  read_columns_of(table, "position", names.position, true),
      read_columns_of(table, "force", names.force, true);
  read_columns_of(table, "contact", names.contact, false),
      read_columns_of(table, "normal", names.normal, false);
  read_columns_of(table, "desired", names.desired, false),
      read_columns_of(table, "torque", names.torque, true);
  table.finish();
}

void read_unit(SceneTable& table, std::string_view key, Dimension dimension, std::string& target) {
  target = table.text(key, target);
  if (!target.empty() &&
      !unit_factor(importers::split_unit(fmt::format("({})", target)).second, dimension))
    fail(table, key,
         fmt::format("{} of units is \"{}\", which is no unit of {}", key, target,
                     dimension_name(dimension)),
         "Known: " + known_units(dimension) + ".");
}

void read_units(SceneTable table, importers::UnitNames& units) {
  read_unit(table, "time", Dimension::time, units.time);
  read_unit(table, "position", Dimension::length, units.position);
  read_unit(table, "force", Dimension::force, units.force);
  read_unit(table, "torque", Dimension::torque, units.torque);
  table.finish();
}

std::vector<double> numbers(SceneTable& table, std::string_view key, std::size_t count) {
  std::vector<double> out;
  const toml::node* node = table.node(key);
  const toml::array* list = node ? node->as_array() : nullptr;
  for (std::size_t i = 0; list && i < list->size(); ++i)
    if (const auto number = list->get(i)->value<double>();
        number && list->get(i)->is_number() && std::isfinite(*number))
      out.push_back(*number);
  if (out.size() != count || (list && list->size() != count))
    fail(table, key, fmt::format("{} of {} is not a list of {} numbers", key, table.name(), count),
         "Write [1.0, 2.0, ...].");
  return out;
}

void read_position(SceneTable& table, Entry& entry) {
  const toml::node* node = table.node("position");
  if (!node) return;
  const toml::array* list = node->as_array();
  if (list && list->size() == 3 && list->get(0)->is_string()) {
    const Vec3 position = table.point("position");
    entry.item.position_m = position, entry.position.reset();
  } else {
    entry.position = numbers(table, "position", 3), entry.item.position_m.reset();
  }
}

void read_normal(SceneTable& table, BatchItem& item) {
  if (!table.has("normal")) return;
  const auto n = numbers(table, "normal", 3);
  const Vec3 normal(n[0], n[1], n[2]);
  if (!(normal.norm() > 1e-12))
    fail(table, "normal", "normal has no direction",
         "Give the direction into the body, such as [0, 0, -1].");
  item.normal = normal.normalized();
}

char separator_named(const std::string& name) {
  return name == "tab"         ? '\t'
         : name == "blank"     ? ' '
         : name == "comma"     ? ','
         : name == "semicolon" ? ';'
                               : 0;
}

void read_text_keys(SceneTable& table, importers::ReadSettings& read) {
  std::vector<std::string_view> formats{"auto"};
  for (const auto& row : importers::importers()) formats.push_back(row.name);
  read.format = table.choice("format", read.format, formats);
  if (table.has("separator"))
    read.separator =
        separator_named(table.choice("separator", "", {"comma", "semicolon", "tab", "blank"}));
  if (table.has("decimal")) read.decimal = table.choice("decimal", "", {".", ","})[0];
  read.encoding = table.choice("encoding", read.encoding, {"utf-8", "latin-1"});
  read.comment = table.text("comment", read.comment);
  read.is_normal_outward = table.choice("normals", read.is_normal_outward ? "outward" : "inward",
                                        {"inward", "outward"}) == "outward";
  read.most_bytes =
      static_cast<std::uintmax_t>(table.number(
          "largest_file", static_cast<double>(read.most_bytes >> 20), 1, kMostMebibytes))
      << 20;
  if (table.has("cantilever")) {
    SceneTable c = table.table("cantilever", "cantilever");
    importers::Cantilever cantilever;
    cantilever.stiffness_N_m = c.number("stiffness", 0, 1e-6, 1e6);
    cantilever.sensitivity_m = c.quantity("sensitivity", Dimension::length, 0, 0, 1);
    cantilever.stiffness_deviation = c.number("stiffness_deviation", 0, 0, 1);
    cantilever.sensitivity_deviation = c.number("sensitivity_deviation", 0, 0, 1);
    c.finish();
    read.cantilever = cantilever;
  }
}

void read_signal_keys(SceneTable& table, recordings::SignalSettings& s) {
  const auto kind = table.choice("kind",
                                 s.kind == ExperimentKind::press  ? "press"
                                 : s.kind == ExperimentKind::drag ? "drag"
                                                                  : "path",
                                 {"press", "drag", "path"});
  s.kind = kind == "press"  ? ExperimentKind::press
           : kind == "drag" ? ExperimentKind::drag
                            : ExperimentKind::path;
  std::vector<std::string_view> estimators;
  for (const auto& row : recordings::contact_estimators()) estimators.push_back(row.name);
  s.contact = table.choice("contact", s.contact, estimators);
  s.contact_range = table.number("contact_range", s.contact_range, 0, 1);
  const auto drift = table.choice("drift",
                                  s.drift == Drift::none   ? "none"
                                  : s.drift == Drift::bias ? "bias"
                                                           : "line",
                                  {"none", "bias", "line"});
  s.drift = drift == "none" ? Drift::none : drift == "bias" ? Drift::bias : Drift::line;
  s.smooth_s = table.quantity("smooth", Dimension::time, s.smooth_s, 0, 1e3);
  s.force_delay_s = table.quantity("force_delay", Dimension::time, s.force_delay_s, -1e3, 1e3);
  s.compliance_m_N = table.number("compliance", s.compliance_m_N, 0, 1e3);
  if (table.has("force_limit"))
    s.force_limit_N = table.quantity("force_limit", Dimension::force, 0, 0, 1e9);
  const auto use = table.choice("use",
                                s.use == recordings::Use::approach  ? "approach"
                                : s.use == recordings::Use::retract ? "retract"
                                                                    : "mean",
                                {"approach", "retract", "mean"});
  s.use = use == "approach"  ? recordings::Use::approach
          : use == "retract" ? recordings::Use::retract
                             : recordings::Use::mean;
  s.rows = static_cast<int>(table.integer("rows", s.rows, 3, 100000));
  s.poisson = table.number("poisson", s.poisson, 0, 0.5);
  if (table.has("plausible")) {
    const auto range = table.quantities("plausible", Dimension::pressure, 0, 1e15);
    if (range.size() != 2 || !(range[0] < range[1]))
      fail(table, "plausible", "plausible is not a range of two moduli",
           "Write [\"10 Pa\", \"5 MPa\"].");
    s.least_young_Pa = range[0], s.most_young_Pa = range[1], s.is_range_given = true;
  }
  if (table.has("probe")) {
    SceneTable probe = table.table("probe", "probe");
    const auto shape = probe.choice("shape",
                                    s.tip == Tip::sphere ? "sphere"
                                    : s.tip == Tip::flat ? "flat"
                                                         : "cone",
                                    {"sphere", "flat", "cone"});
    s.tip = shape == "sphere" ? Tip::sphere : shape == "flat" ? Tip::flat : Tip::cone;
    s.radius_m = probe.quantity("radius", Dimension::length, s.radius_m, 0, 10);
    probe.finish();
  }
}

// The keys of [defaults] and of [[recording]] alike.
void read_keys(SceneTable& table, Entry& entry) {
  entry.file = table.text("file", entry.file);
  entry.item.point = table.text("point", entry.item.point);
  read_columns(table.table("columns", "columns"), entry.item.read.columns);
  read_units(table.table("units", "units"), entry.item.read.units);
  if (table.has("force_on"))
    entry.is_force_on_tool = table.choice("force_on", "", {"tool", "body"}) == "tool";
  read_position(table, entry), read_normal(table, entry.item);
  read_text_keys(table, entry.item.read), read_signal_keys(table, entry.item.signal);
  table.finish();
}

bool is_table_format(const importers::ReadSettings& read) {
  const auto& c = read.columns;
  return read.format == "csv" || read.format == "hdf5" || read.format == "robot-palpation" ||
         (read.format == "auto" && (!c.depth.empty() || !c.position.empty() || !c.force.empty()));
}

// What an entry must say by the time all of it is known.
void complete(const SceneTable& table, Entry& entry) {
  BatchItem& item = entry.item;
  if (entry.file.empty())
    throw Error(table.where_table(), "[[recording]] has no file", "Add file = \"...\".");
  const auto& c = item.read.columns;
  if (is_table_format(item.read)) {
    if (!entry.is_force_on_tool)
      throw Error(
          table.where_table(), "force_on is missing: whose force the sensor reports",
          "Add force_on = \"tool\" (what the sensor feels) or \"body\" (what the body feels).");
    item.read.is_force_on_tool = *entry.is_force_on_tool;
    if (item.read.format != "robot-palpation" &&
        (c.force.empty() || (c.depth.empty() && c.position.empty())))
      throw Error(
          table.where("columns"),
          c.force.empty() ? "columns names no force" : "columns names neither depth nor position",
          "Add columns = { time = \"t\", position = [\"x\", \"y\", \"z\"], force = [\"fx\", "
          "\"fy\", \"fz\"] }, or depth = \"d\" for a 1-axis rig.");
    if (!c.depth.empty() && !c.position.empty() && item.read.format != "robot-palpation")
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

// The files of an entry: itself, or those that its pattern in the last component matches, sorted.
// A summary that an import left there is none of them.
std::vector<std::string> files_of(const SceneTable& table, const std::string& file,
                                  const fs::path& folder) {
  if (file.find_first_of("*?") == std::string::npos) return {file};
  const fs::path parent = fs::path(file).parent_path();
  const std::string pattern = fs::path(file).filename().string();
  std::vector<std::string> files;
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(folder / parent, failure))
    if (fnmatch(pattern.c_str(), entry.path().filename().c_str(), FNM_PERIOD) == 0 &&
        !entry.path().filename().string().ends_with(".import.csv"))
      files.push_back((parent / entry.path().filename()).string());
  if (files.empty())
    throw Error(table.where("file"), "no file matches \"" + file + "\"",
                "Correct the pattern; names start at the manifest's folder.");
  std::sort(files.begin(), files.end());
  return files;
}

void read_registration(SceneTable table, Manifest& manifest) {
  manifest.fits_to_surface = table.boolean("icp", false);
  if (table.has("transform")) {
    const auto m = numbers(table, "transform", 16);
    recordings::RigidMotion motion;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) motion.rotation(r, c) = m[static_cast<std::size_t>(4 * r + c)];
      motion.translation_m[r] = m[static_cast<std::size_t>(4 * r + 3)];
    }
    const bool is_rigid =
        (motion.rotation * motion.rotation.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff() <
            1e-4 &&
        motion.rotation.determinant() > 0;
    if (!is_rigid || m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
      fail(table, "transform", "transform is no rigid motion",
           "Give 16 numbers row by row: rotation, and translation in m in the last column; the "
           "last row is 0, 0, 0, 1.");
    manifest.motion = motion;
  }
  auto landmarks = table.tables("landmarks", "landmarks of [registration]");
  manifest.rig_landmarks_m.resize(static_cast<Eigen::Index>(landmarks.size()), 3),
      manifest.body_landmarks_m = manifest.rig_landmarks_m;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    manifest.rig_landmarks_m.row(static_cast<Eigen::Index>(i)) = landmarks[i].point("rig");
    manifest.body_landmarks_m.row(static_cast<Eigen::Index>(i)) = landmarks[i].point("body");
    landmarks[i].finish();
  }
  if (manifest.motion && !landmarks.empty())
    fail(table, "landmarks", "registration has both a transform and landmarks", "Leave one out.");
  table.finish();
  if (manifest.fits_to_surface && !manifest.surface)
    fail(table, "icp", "icp needs a surface", "Say `surface` and `length_unit`.");
}

toml::table parse_toml(const fs::path& path) {
  try {
    return toml::parse(read_whole_file(path), path.string());
  } catch (const toml::parse_error& error) {
    throw Error(fmt::format("{}:{}:{}", path.string(), error.source().begin.line,
                            error.source().begin.column),
                std::string(error.description()), "Correct the TOML there.");
  }
}

}  // namespace

Manifest read_manifest(const fs::path& path) {
  Manifest manifest;
  manifest.path = path;
  const toml::table document = parse_toml(path);
  SceneTable root(document, "the manifest", path.string());
  const fs::path folder = path.parent_path();
  if (root.has("surface")) {
    manifest.surface = folder / root.text("surface", "");
    const std::string unit = root.text("length_unit", "");
    const auto factor = unit_factor(unit, Dimension::length);
    const auto quantity = parse_quantity(unit, Dimension::length);
    if (!factor && !quantity)
      fail(root, "length_unit",
           unit.empty() ? "surface has no length_unit"
                        : "length_unit is \"" + unit + "\", which is no length unit",
           "Say length_unit = \"mm\", or whatever the surface's numbers are in.");
    manifest.length_unit_m = factor ? *factor : *quantity;
  } else {
    root.text("length_unit", "");
  }
  manifest.place_tolerance_m =
      root.quantity("place_tolerance", Dimension::length, manifest.place_tolerance_m, 0, 1e3);
  manifest.pools_repeats = root.choice("repeats", "pool", {"pool", "keep"}) == "pool";
  read_registration(root.table("registration", "[registration]"), manifest);
  Entry defaults;
  SceneTable defaults_table = root.table("defaults", "[defaults]");
  read_keys(defaults_table, defaults);
  for (SceneTable& table : root.tables("recording", "[[recording]]")) {
    Entry entry = defaults;
    entry.item.place = table.where_table();
    read_keys(table, entry);
    complete(table, entry);
    for (const std::string& file : files_of(table, entry.file, folder)) {
      BatchItem item = entry.item;
      item.shown = file, item.file = folder / file;
      manifest.items.push_back(std::move(item));
    }
  }
  root.finish();
  if (manifest.items.empty())
    throw Error(path.string(), "names no recording", "Add [[recording]] with file = \"...\".");
  return manifest;
}

}  // namespace palpate::tools
