#include "tools/scene/settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "libfem/materials/materials.hpp"
#include "libfit/core/error.hpp"
#include "tools/scene/fields.hpp"

namespace palpate::tools {
namespace {

constexpr const char* kPlain = "1";

std::string_view unit_of(const fem::ParameterRow& row) {
  return row.unit.empty() ? kPlain : row.unit;
}

std::vector<double> numbers_of(const Vec3& v) { return {v[0], v[1], v[2]}; }

// Puts each member of the sections it visits under its path; with a stage, that stage's alone.
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
    if (const auto* region = std::get_if<Region>(&value.part)) (*this)(stage, key, *region, Any{});
    if (const auto* disc = std::get_if<Disc>(&value.part)) {
      put(stage, path + "/disc/center", "m", numbers_of(disc->center_m));
      put(stage, path + "/disc/radius", "m", {disc->radius_m});
    }
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

// Takes the members of a section from where SettingsWriter put them.
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
    if (has(path + "/disc/radius"))
      value->part = Disc{point(path + "/disc/center"), number(path + "/disc/radius")};
    else if (has_below(path + "/below") || has_below(path + "/above") || has_below(path + "/box") ||
             has_below(path + "/sphere") || has_below(path + "/inside") ||
             has_below(path + "/marked"))
      (*this)(stage, key, value->part.emplace<Region>(), Any{});
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

constexpr const char* kGravityPrefix = "gravity/";
constexpr const char* kToolPrefix = "tool/";
std::string pressed_prefix(std::size_t i) { return fmt::format("pressed/{}/", i); }
std::string inclusion_prefix(std::size_t i) { return fmt::format("inclusion/{}/", i); }
std::string bed_prefix(std::size_t i) { return fmt::format("bed/{}/", i); }

void write_scene(const Scene& scene, SettingsWriter& writer) {
  writer.section("body/", scene.body);
  writer.section("", scene.material);
  for (std::size_t i = 0; i < scene.inclusions.size(); ++i)
    writer.section(inclusion_prefix(i), scene.inclusions[i]);
  for (std::size_t i = 0; i < scene.beds.size(); ++i) writer.section(bed_prefix(i), scene.beds[i]);
  if (scene.gravity) writer.section(kGravityPrefix, *scene.gravity);
  writer.section("experiments/", scene.experiments);
  writer.section("fit/", scene.fit);
}

void write_tool(const ToolSection& tool, const std::string& prefix, SettingsWriter& writer) {
  writer.section(prefix, tool);
  writer.section(prefix + "probe/", tool.probe.spec);
}
ToolSection tool_of(SettingsReader& reader, const std::string& prefix) {
  ToolSection tool = reader.section<ToolSection>(prefix);
  tool.probe.spec = reader.section<ProbeSpec>(prefix + "probe/");
  return tool;
}

template <class Section>
std::string canonical_section(const Section& section) {
  SettingsWriter writer;
  writer.section("", section);
  return canonical(writer.settings());
}

}  // namespace

Settings settings_of(const Scene& scene) {
  SettingsWriter writer;
  write_scene(scene, writer);
  if (scene.tool) write_tool(*scene.tool, kToolPrefix, writer);
  for (std::size_t i = 0; i < scene.pressed.size(); ++i)
    write_tool(scene.pressed[i], pressed_prefix(i), writer);
  return writer.settings();
}

Scene scene_of(const Body& body, const std::filesystem::path& path) {
  Scene scene;
  scene.path = path;
  SettingsReader reader(body.settings, path.string());
  scene.body = reader.section<BodySection>("body/");
  scene.material = reader.section<std::optional<fem::MaterialParameters>>("");
  for (std::size_t i = 0; reader.has_section(inclusion_prefix(i)); ++i)
    scene.inclusions.push_back(reader.section<InclusionSection>(inclusion_prefix(i)));
  for (std::size_t i = 0; reader.has_section(bed_prefix(i)); ++i)
    scene.beds.push_back(reader.section<BedSection>(bed_prefix(i)));
  if (reader.has_section(kGravityPrefix))
    scene.gravity = reader.section<GravitySection>(kGravityPrefix);
  if (body.probe) scene.probe.spec = *body.probe;
  scene.experiments = reader.section<ExperimentsSection>("experiments/");
  scene.fit = reader.section<FitSection>("fit/");
  if (reader.has_section(kToolPrefix)) scene.tool = tool_of(reader, kToolPrefix);
  for (std::size_t i = 0; reader.has_section(pressed_prefix(i)); ++i)
    scene.pressed.push_back(tool_of(reader, pressed_prefix(i)));
  return scene;
}

std::string canonical(const Settings& settings) {
  std::string text;
  for (const auto& [key, setting] : settings)
    text += setting.unit.empty()
                ? fmt::format("{} = \"{}\"\n", key, setting.text)
                : fmt::format("{} = {} {}\n", key, fmt::join(setting.numbers, " "), setting.unit);
  return text;
}

std::string canonical(const Scene& scene, Stage stage) {
  SettingsWriter writer(stage);
  write_scene(scene, writer);
  writer.section("probe/", scene.probe.spec);
  writer.section("export/", scene.export_);
  writer.section("validate/", scene.validate);
  return canonical(writer.settings());
}

std::string canonical(const BodySection& section) { return canonical_section(section); }
std::string canonical(const FitSection& section) { return canonical_section(section); }
std::string canonical(const ExportSection& section) { return canonical_section(section); }
std::string canonical(const ProbeSpec& probe) { return canonical_section(probe); }
std::string canonical(const ToolSection& tool) {
  SettingsWriter writer;
  write_tool(tool, "", writer);
  return canonical(writer.settings());
}

}  // namespace palpate::tools
