#pragma once

#include <fmt/format.h>

#include "libfem/materials/materials.hpp"
#include "tools/scene/fields.hpp"
#include "tools/scene/settings.hpp"

namespace palpate::tools {

/// Puts each member of the sections it visits under its path; with a stage, that stage's alone.
class SettingsWriter {
 public:
  explicit SettingsWriter(std::optional<Stage> only = {}) : only_(only) {}

  template <class Section>
  void section(const std::string& prefix, const Section& section) {
    prefix_ = prefix;
    visit(section, *this);
  }
  template <class Kind>
  void operator()(Stage stage, std::string_view key, double value, const Kind&) {
    put(stage, std::string(key),
        std::is_same_v<Kind, Number>     ? kPlain
        : std::is_same_v<Kind, Duration> ? "s"
        : std::is_same_v<Kind, Tilt>     ? "rad"
        : std::is_same_v<Kind, Density>  ? "kg/m^3"
                                         : "m",
        {value});
  }
  void operator()(Stage stage, std::string_view key, const std::vector<double>& value, Speed) {
    put(stage, std::string(key), "m/s", value);
  }
  void operator()(Stage stage, std::string_view key, const std::vector<double>& value, Length) {
    put(stage, std::string(key), "m", value);
  }
  template <class Kind>
  void operator()(Stage stage, std::string_view key, int value, const Kind&) {
    put(stage, std::string(key), kPlain, {static_cast<double>(value)});
  }
  void operator()(Stage stage, std::string_view key, bool value, Any) {
    put(stage, std::string(key), kPlain, {value ? 1.0 : 0.0});
  }
  void operator()(Stage stage, std::string_view key, const std::string& value, const Choice&) {
    put(stage, std::string(key), "", {}, value);
  }
  template <class Kind>
  void operator()(Stage stage, std::string_view key, const std::filesystem::path& value,
                  const Kind&) {
    put(stage, std::string(key), "", {}, value.filename().string());
  }
  template <class Kind>
  void operator()(Stage, std::string_view, const PlacementSection& value, const Kind&) {
    visit(value, *this);
  }
  template <class Value, class Kind>
  void operator()(Stage stage, std::string_view key, const std::optional<Value>& value,
                  const Kind& kind) {
    if (value) (*this)(stage, key, *value, kind);
  }
  void operator()(Stage stage, std::string_view key, const Vec3& value, Acceleration) {
    put(stage, std::string(key), "m/s^2", numbers_of(value));
  }
  void operator()(Stage stage, std::string_view key, const Vec3& value, Any) {
    put(stage, std::string(key), kPlain, numbers_of(value));
  }
  void operator()(Stage stage, std::string_view key, const Region& region, Any) {
    const std::string path = key.empty() ? "" : std::string(key) + "/";
    if (const auto* half = std::get_if<HalfSpace>(&region)) {
      const std::string side = path + (half->is_below ? "below/" : "above/");
      put(stage, side + "axis", kPlain, {static_cast<double>(half->axis)});
      put(stage, side + "at", "m", {half->at_m});
    } else if (const auto* box = std::get_if<Box>(&region)) {
      put(stage, path + "box/low", "m", numbers_of(box->low_m));
      put(stage, path + "box/high", "m", numbers_of(box->high_m));
    } else if (const auto* ball = std::get_if<Ball>(&region)) {
      put(stage, path + "sphere/center", "m", numbers_of(ball->center_m));
      put(stage, path + "sphere/radius", "m", {ball->radius_m});
    } else if (const auto* solid = std::get_if<Solid>(&region)) {
      if (solid->boundary) (*this)(stage, path + "inside", solid->boundary->surface, Any{});
    } else if (const auto& marked = std::get<Marked>(region); marked.part) {
      put_part(stage, path + "marked", *marked.part);
    }
  }
  void operator()(Stage stage, std::string_view key, const SurfaceRegion& value, Any) {
    const std::string path(key);
    if (value.part) (*this)(stage, key, *value.part, Any{});
    if (value.facing.empty()) return;
    put(stage, path + "/facing", "", {}, value.facing);
    put(stage, path + "/within", "rad", {value.within_rad});
  }
  void operator()(Stage stage, std::string_view key, const std::vector<Region>& value, Any) {
    for (std::size_t i = 0; i < value.size(); ++i)
      (*this)(stage, fmt::format("{}/{}", key, i), value[i], Any{});
  }
  void operator()(Stage stage, std::string_view key, const fem::MaterialParameters& value, Any) {
    const std::string path(key);
    put(stage, path + "/law", "", {}, value.law);
    auto next = value.values.begin();
    for (const fem::ParameterRow& row : fem::find_law(value.law, "law").parameters) {
      put(stage, path + "/" + std::string(row.name), unit_of(row), {next, next + row.count});
      next += row.count;
    }
    if (value.softening.is_any()) {
      put(stage, path + "/softening/r", kPlain, {value.softening.r});
      put(stage, path + "/softening/m", "Pa", {value.softening.scale_Pa});
      put(stage, path + "/softening/beta", kPlain, {value.softening.beta});
    }
    const Relaxation& relaxation = value.relaxation;
    if (relaxation.branches() == 0) return;
    put(stage, path + "/relaxation/share", kPlain,
        {relaxation.share.begin(), relaxation.share.end()});
    put(stage, path + "/relaxation/time", "s",
        {relaxation.time_s.begin(), relaxation.time_s.end()});
  }
  void operator()(Stage stage, std::string_view,
                  const std::map<std::string, std::vector<double>, std::less<>>& values, Any) {
    for (const auto& [key, numbers] : values)
      put(stage, key, probe_dimension(key) == Dimension::angle ? "rad" : "m", numbers);
  }
  void operator()(Stage stage, std::string_view key, const Surface& mesh, Any) {
    const std::string path(key);
    put(stage, path + "/vertices", "m",
        {mesh.vertices.data(), mesh.vertices.data() + mesh.vertices.size()});
    put(stage, path + "/triangles", kPlain,
        {mesh.triangles.data(), mesh.triangles.data() + mesh.triangles.size()});
  }

  void operator()(Stage stage, std::string_view key, const Points& value, Any) {
    put(stage, std::string(key), "m", {value.data(), value.data() + value.size()});
  }

  const Settings& settings() const { return settings_; }

 private:
  static constexpr const char* kPlain = "1";
  static std::string_view unit_of(const fem::ParameterRow& row) {
    return row.unit.empty() ? kPlain : row.unit;
  }
  static std::vector<double> numbers_of(const Vec3& v) { return {v[0], v[1], v[2]}; }

  void put(Stage stage, const std::string& key, std::string_view unit, std::vector<double> numbers,
           const std::string& text = "") {
    if (!only_ || *only_ == stage)
      settings_[prefix_ + key] = {std::string(unit), std::move(numbers), text};
  }

  void put_part(Stage stage, const std::string& path, const PaintedPart& part) {
    const std::vector<char>& flags = part.is_painted();
    put(stage, path + "/is_painted", kPlain, {flags.begin(), flags.end()});
    if (part.is_on_faces()) return (*this)(stage, path, part.surface(), Any{});
    const TetMesh& volume = part.volume();
    put(stage, path + "/vertices", "m",
        {volume.nodes.data(), volume.nodes.data() + volume.nodes.size()});
    put(stage, path + "/tets", kPlain,
        {volume.tets.data(), volume.tets.data() + volume.tets.size()});
  }

  std::optional<Stage> only_;
  std::string prefix_;
  Settings settings_;
};

}  // namespace palpate::tools
