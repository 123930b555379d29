#pragma once

#include <fmt/format.h>

#include "libfem/materials/materials.hpp"
#include "libfit/core/error.hpp"
#include "tools/scene/fields.hpp"
#include "tools/scene/settings.hpp"

namespace palpate::tools {

/// Takes the members of a section from where SettingsWriter put them.
class SettingsReader {
 public:
  SettingsReader(const Settings& settings, const std::string& where)
      : settings_(settings), where_(where) {}

  template <class Section>
  Section section(const std::string& prefix) {
    Section section;
    prefix_ = prefix;
    visit(section, *this);
    return section;
  }
  template <class Kind>
  void operator()(Stage, std::string_view key, double& value, const Kind&) {
    value = number(key);
  }
  void operator()(Stage, std::string_view key, std::vector<double>& value, Length) {
    value = get(key).numbers;
  }
  template <class Kind>
  void operator()(Stage, std::string_view key, int& value, const Kind&) {
    value = static_cast<int>(number(key));
  }
  void operator()(Stage, std::string_view key, bool& value, Any) { value = number(key) != 0; }
  template <class Kind>
  void operator()(Stage, std::string_view key, std::string& value, const Kind&) {
    value = get(key).text;
  }
  template <class Kind>
  void operator()(Stage, std::string_view key, std::filesystem::path& value, const Kind&) {
    value = get(key).text;
  }
  void operator()(Stage, std::string_view key, Vec3& value, Acceleration) { value = point(key); }
  void operator()(Stage, std::string_view key, Vec3& value, Any) { value = point(key); }
  void operator()(Stage, std::string_view key, Points& value, Any) {
    const std::vector<double>& numbers = get(key).numbers;
    if (numbers.size() % 3) fail(key, "is not three numbers a row");
    value =
        Eigen::Map<const Points>(numbers.data(), static_cast<Eigen::Index>(numbers.size() / 3), 3);
  }
  void operator()(Stage, std::string_view key, Surface& mesh, Any) {
    if (const std::string path(key); !get(path + "/triangles").numbers.empty())
      mesh = surface(path);
  }
  // Lengths and angles of a shape, one by one under their own names.
  void operator()(Stage, std::string_view,
                  std::map<std::string, std::vector<double>, std::less<>>& values, Any) {
    values.clear();
    for (auto next = settings_.lower_bound(prefix_);
         next != settings_.end() && next->first.starts_with(prefix_); ++next)
      if (const Setting& setting = next->second; setting.unit == "m" || setting.unit == "rad")
        if (const std::string key = next->first.substr(prefix_.size());
            key.find('/') == std::string::npos)
          values[key] = setting.numbers;
  }
  template <class Kind>
  void operator()(Stage, std::string_view, std::optional<PlacementSection>& value, const Kind&) {
    value.reset();
    if (has("tolerance")) visit(value.emplace(), *this);
  }
  void operator()(Stage stage, std::string_view key, std::optional<SurfaceRegion>& value, Any) {
    value.reset();
    const std::string path(key);
    if (!has_below(key)) return;
    value.emplace();
    if (has_below(path + "/below") || has_below(path + "/above") || has_below(path + "/box") ||
        has_below(path + "/sphere") || has_below(path + "/inside") || has_below(path + "/marked"))
      (*this)(stage, key, value->part.emplace(), Any{});
    if (!has(path + "/facing")) return;
    value->facing = get(path + "/facing").text;
    value->within_rad = number(path + "/within");
  }
  void operator()(Stage stage, std::string_view key, std::optional<fem::MaterialParameters>& value,
                  Any) {
    value.reset();
    if (has_below(key)) (*this)(stage, key, value.emplace(), Any{});
  }
  template <class Value, class Kind>
  void operator()(Stage stage, std::string_view key, std::optional<Value>& value,
                  const Kind& kind) {
    value.reset();
    if (has(key)) (*this)(stage, key, value.emplace(), kind);
  }
  void operator()(Stage, std::string_view key, Region& region, Any) {
    const std::string path = key.empty() ? "" : std::string(key) + "/";
    for (const bool is_below : {true, false}) {
      const std::string side = path + (is_below ? "below/" : "above/");
      if (has(side + "at"))
        region = HalfSpace{static_cast<int>(number(side + "axis")), number(side + "at"), is_below};
    }
    if (has(path + "box/low")) region = Box{point(path + "box/low"), point(path + "box/high")};
    if (has(path + "sphere/radius"))
      region = Ball{point(path + "sphere/center"), number(path + "sphere/radius")};
    if (has(path + "inside/triangles"))
      region = Solid{{}, std::make_shared<const Enclosed>(surface(path + "inside"))};
    if (has(path + "marked/is_painted"))
      region.emplace<Marked>().part = std::make_shared<const PaintedPart>(part(path + "marked"));
  }
  void operator()(Stage stage, std::string_view key, std::vector<Region>& value, Any) {
    for (std::string item; has_below(item = fmt::format("{}/{}", key, value.size()));)
      (*this)(stage, item, value.emplace_back(), Any{});
  }
  void operator()(Stage, std::string_view key, fem::MaterialParameters& value, Any) {
    const std::string path(key);
    value.law = get(path + "/law").text;
    for (const fem::ParameterRow& row : fem::find_law(value.law, where_).parameters) {
      const std::vector<double>& numbers = get(path + "/" + std::string(row.name)).numbers;
      if (numbers.size() != static_cast<std::size_t>(row.count))
        fail(path, "has the wrong number of values");
      value.values.insert(value.values.end(), numbers.begin(), numbers.end());
    }
    const auto number_at = [&](const char* name) {
      const std::vector<double>& numbers = get(path + "/softening/" + name).numbers;
      if (numbers.size() != 1) fail(path, "has the wrong number of values");
      return numbers[0];
    };
    if (has(path + "/softening/r"))
      value.softening = {number_at("r"), number_at("m"), number_at("beta")};
    if (!has(path + "/relaxation/share")) return;
    const auto vector_at = [&](const std::string& place) {
      const std::vector<double>& numbers = get(place).numbers;
      return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(
          numbers.data(), static_cast<Eigen::Index>(numbers.size())));
    };
    value.relaxation = {vector_at(path + "/relaxation/share"),
                        vector_at(path + "/relaxation/time")};
    if (value.relaxation.time_s.size() != value.relaxation.branches())
      fail(path, "has the wrong number of values");
  }

  bool has_section(const std::string& prefix) {
    prefix_ = prefix;
    return has_below("");
  }

 private:
  bool has(std::string_view key) const { return settings_.contains(prefix_ + std::string(key)); }
  bool has_below(std::string_view key) const {
    const std::string path = prefix_ + std::string(key) + (key.empty() ? "" : "/");
    const auto next = settings_.lower_bound(path);
    return next != settings_.end() && next->first.starts_with(path);
  }
  const Setting& get(std::string_view key) const {
    const auto found = settings_.find(prefix_ + std::string(key));
    if (found == settings_.end()) fail(key, "is missing");
    return found->second;
  }
  double number(std::string_view key) const {
    const Setting& setting = get(key);
    if (setting.numbers.size() != 1) fail(key, "is not one number");
    return setting.numbers.front();
  }
  Vec3 point(std::string_view key) const {
    const Setting& setting = get(key);
    if (setting.numbers.size() != 3) fail(key, "is not three numbers");
    return {setting.numbers[0], setting.numbers[1], setting.numbers[2]};
  }
  // Vertices and, by `key`, cells of as many corners as Cells has columns.
  template <class Cells>
  std::pair<Points, Cells> mesh(const std::string& path, const char* key) const {
    constexpr int width = Cells::ColsAtCompileTime;
    const std::vector<double>&places = get(path + "/vertices").numbers,
          &corners = get(path + key).numbers;
    const Points vertices =
        Eigen::Map<const Points>(places.data(), static_cast<Eigen::Index>(places.size() / 3), 3);
    const Cells cells =
        Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, width, Eigen::RowMajor>>(
            corners.data(), static_cast<Eigen::Index>(corners.size() / width), width)
            .template cast<std::int32_t>();
    if (places.size() % 3 || corners.size() % width || corners.empty() || cells.minCoeff() < 0 ||
        cells.maxCoeff() >= vertices.rows())
      fail(path, "is no mesh");
    return {vertices, cells};
  }
  Surface surface(const std::string& path) const {
    const auto [vertices, triangles] = mesh<Triangles>(path, "/triangles");
    return {vertices, triangles};
  }
  PaintedPart part(const std::string& path) const {
    const std::vector<double>& numbers = get(path + "/is_painted").numbers;
    const std::vector<char> flags(numbers.begin(), numbers.end());
    const auto check = [&](Eigen::Index corners) {
      if (corners != static_cast<Eigen::Index>(flags.size()))
        fail(path, "has flags of another mesh");
    };
    if (has(path + "/triangles")) {
      Surface on = surface(path);
      check(on.triangles.size());
      return {std::move(on), flags};
    }
    const auto [nodes, tets] = mesh<Tets>(path, "/tets");
    check(tets.size());
    return {TetMesh{nodes, tets, {}}, flags};
  }
  [[noreturn]] void fail(std::string_view key, const char* fact) const {
    throw Error(fmt::format("{}: settings/{}{}", where_, prefix_, key), fact,
                "Make the body again with `palpate prepare`.");
  }

  const Settings& settings_;
  std::string where_, prefix_;
};

}  // namespace palpate::tools
