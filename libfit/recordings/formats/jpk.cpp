// JPK force curves: a zip of Java property files and of channels in big-endian numbers. A file of
// one curve has segments/N; a map has index/I/segments/N. A header says how numbers become volts,
// volts a deflection, and that a force (conversions, each from its base); a channel's height falls
// towards the body.

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <map>

#include "libfit/core/text.hpp"
#include "libfit/core/units.hpp"
#include "libfit/recordings/formats/afm_curve.hpp"
#include "libfit/recordings/formats/importers.hpp"
#include "libfit/recordings/formats/jpk_properties.hpp"
#include "libfit/recordings/formats/zip_file.hpp"

namespace palpate::importers {
namespace {

constexpr int kMaxConversions = 8;  // from volts to force there are two
constexpr const char* kSaveAgain = "Save the recording again with all of its channels.";

// Channels of the height, the best first, and the conversion that makes it a length.
constexpr std::pair<const char*, const char*> kHeights[] = {{"measuredHeight", "nominal"},
                                                            {"capacitiveSensorHeight", "nominal"},
                                                            {"strainGaugeHeight", "nominal"},
                                                            {"head-height", "calibrated"},
                                                            {"height", "calibrated"}};

struct Linear {
  double offset = 0, multiplier = 1;
  double operator()(double x) const { return multiplier * x + offset; }
};

// Folders of the curves' segments by number: {0: {0: "segments/0/", 1: ...}}, and the curves' own.
struct Curve {
  std::string folder;
  std::map<int, std::string> segments;
};

std::optional<int> whole_number(std::string_view text) {
  int value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc() || end != text.data() + text.size() || value < 0) return std::nullopt;
  return value;
}

std::map<int, Curve> curves_of(const std::vector<std::string>& names) {
  std::map<int, Curve> curves;
  for (const std::string& name : names) {
    const auto part = split(name, '/');
    const std::size_t depth = part.size();
    if (depth < 3 || part[depth - 1] != "segment-header.properties" ||
        part[depth - 3] != "segments")
      continue;
    const auto segment = whole_number(part[depth - 2]);
    const auto index = depth == 3                         ? std::optional<int>(0)
                       : depth == 5 && part[0] == "index" ? whole_number(part[1])
                                                          : std::nullopt;
    if (!segment || !index) continue;
    Curve& curve = curves[*index];
    if (depth == 5) curve.folder = "index/" + std::string(part[1]) + "/";
    curve.segments[*segment] = name.substr(0, name.rfind('/') + 1);
  }
  return curves;
}

template <class T>
void append_numbers(const std::string& bytes, std::vector<double>& out) {
  for (std::size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T)) {
    char turned[sizeof(T)];
    for (std::size_t k = 0; k < sizeof(T); ++k)
      turned[std::endian::native == std::endian::little ? sizeof(T) - 1 - k : k] = bytes[at + k];
    T value;
    std::memcpy(&value, turned, sizeof value);
    out.push_back(static_cast<double>(value));
  }
}

struct NumberEncoding {
  const char* name;
  void (*read)(const std::string&, std::vector<double>&);
  std::size_t bytes;
};
constexpr NumberEncoding kEncodings[] = {{"signedshort", append_numbers<std::int16_t>, 2},
                                         {"unsignedshort", append_numbers<std::uint16_t>, 2},
                                         {"signedinteger", append_numbers<std::int32_t>, 4},
                                         {"unsignedinteger", append_numbers<std::uint32_t>, 4},
                                         {"signedlong", append_numbers<std::int64_t>, 8},
                                         {"float", append_numbers<float>, 4},
                                         {"float-data", append_numbers<float>, 4},
                                         {"double", append_numbers<double>, 8},
                                         {"double-data", append_numbers<double>, 8}};

// One segment of a curve: its header, and its channels as the header turns them into lengths.
class JpkSegment {
 public:
  JpkSegment(ZipFile& zip, const std::string& folder, std::shared_ptr<const jpk::Properties> shared)
      : zip_(zip),
        folder_(folder),
        header_(jpk::properties_of(zip.read(folder + "segment-header.properties")),
                std::move(shared)) {}

  Error error(const std::string& part, const std::string& what, const std::string& remedy) const {
    return zip_.error(folder_ + part, what, remedy);
  }
  // "extend", "pause" or "retract".
  std::string style() const {
    return header_
        .first_text({"force-segment-header.settings.style",
                     "force-segment-header.settings.segment-settings.style"})
        .value_or("");
  }
  std::optional<double> duration_s() const {
    return header_.first_number({"force-segment-header.duration",
                                 "force-segment-header.settings.segment-settings.duration"});
  }
  bool has(const std::string& channel) const { return zip_.has(file_of(channel)); }

  // How the value of `slot` comes from what is stored, the first step first; nothing when the
  // header does not define it.
  std::optional<std::vector<Linear>> conversions(const std::string& channel,
                                                 std::string slot) const {
    const std::string set = "channel." + channel + ".conversion-set.";
    const std::string base = header_.text(set + "conversions.base").value_or("volts");
    std::vector<Linear> steps;
    for (; slot != base && steps.size() < kMaxConversions;
         slot = header_.text(set + "conversion." + slot + ".base-calibration-slot").value_or("")) {
      const auto step = scaling(set + "conversion." + slot + ".scaling.");
      if (!step) return std::nullopt;
      steps.insert(steps.begin(), *step);
    }
    if (slot != base) return std::nullopt;
    return steps;
  }

  // As the file encodes it, before any conversion.
  std::vector<double> stored(const std::string& channel) {
    const std::string key = "channel." + channel + ".";
    if (!has(channel))
      throw error(file_name_of(channel), "channel `" + channel + "` is missing", kSaveAgain);
    const auto type = header_.first_text(
        {key + "data.encoder.type", key + "encoder.type", key + "data.type", key + "type"});
    const auto encoding =
        std::find_if(std::begin(kEncodings), std::end(kEncodings),
                     [&](const NumberEncoding& e) { return type && *type == e.name; });
    if (encoding == std::end(kEncodings))
      throw error(
          "segment-header.properties",
          "channel `" + channel + "` is stored as `" + type.value_or("") + "`, which is not known",
          kSaveAgain);
    const std::string bytes = zip_.read(file_of(channel));
    if (bytes.empty() || bytes.size() % encoding->bytes != 0)
      throw error(
          file_name_of(channel),
          fmt::format("has {} bytes, which are no numbers of {}", bytes.size(), encoding->bytes),
          kSaveAgain);
    std::vector<double> values;
    encoding->read(bytes, values);
    auto step = scaling(key + "data.encoder.scaling.");
    if (!step) step = scaling(key + "encoder.scaling.");
    if (!step && !std::string_view(encoding->name).starts_with("float") &&
        !std::string_view(encoding->name).starts_with("double"))
      throw error("segment-header.properties", "channel `" + channel + "` has no scaling",
                  kSaveAgain);
    for (double& value : values) value = step.value_or(Linear{})(value);
    return values;
  }

  // Name of the unit of a slot, "" when it is not said.
  std::string unit(const std::string& channel, const std::string& slot) const {
    const std::string key =
        "channel." + channel + ".conversion-set.conversion." + slot + ".scaling.unit";
    return header_.first_text({key + ".unit", key}).value_or("");
  }

 private:
  std::optional<Linear> scaling(const std::string& key) const {
    const auto offset = header_.number(key + "offset"),
               multiplier = header_.number(key + "multiplier");
    if (!multiplier) return std::nullopt;
    return Linear{offset.value_or(0), *multiplier};
  }
  std::string file_name_of(const std::string& channel) const {
    return header_.text("channel." + channel + ".data.file.name")
        .value_or("channels/" + channel + ".dat");
  }
  std::string file_of(const std::string& channel) const { return folder_ + file_name_of(channel); }

  ZipFile& zip_;
  std::string folder_;
  jpk::SegmentHeader header_;
};

std::vector<double> converted(std::vector<double> values, const std::vector<Linear>& steps) {
  for (const Linear& step : steps)
    for (double& value : values) value = step(value);
  return values;
}

// The best height that the segment has, and its name.
std::pair<std::vector<double>, std::string> height_of(JpkSegment& segment) {
  for (const auto& [channel, slot] : kHeights) {
    if (!segment.has(channel)) continue;
    for (const std::string& of : {std::string(slot), std::string("nominal")}) {
      const auto steps = segment.conversions(channel, of);
      if (!steps || unit_factor(segment.unit(channel, of), Dimension::length) != 1.0) continue;
      return {converted(segment.stored(channel), *steps), channel};
    }
  }
  throw segment.error("channels", "has no channel of the height in metres", kSaveAgain);
}

// Force and tip travel of one segment, after those before it.
void append(JpkSegment& segment, const ReadSettings& settings, RawRecording& r) {
  const FailCantilever fail = [&](const std::string& what, const std::string& remedy) {
    return segment.error("segment-header.properties", what, remedy);
  };
  const auto to_bent = segment.conversions("vDeflection", "distance"),
             to_force = segment.conversions("vDeflection", "force");
  const auto gain = [](const std::optional<std::vector<Linear>>& steps) {
    return steps && !steps->empty() ? steps->back().multiplier : 0;
  };
  const std::vector<double> volts = segment.stored("vDeflection");
  RawRecording noted;
  const Cantilever cantilever =
      cantilever_of(settings, {gain(to_force), gain(to_bent), 0, 0}, fail, noted);
  auto [height_m, channel] = height_of(segment);
  if (height_m.size() != volts.size())
    throw segment.error("channels",
                        fmt::format("channel `{}` has {} numbers, vDeflection {}", channel,
                                    height_m.size(), volts.size()),
                        kSaveAgain);
  // A sensitivity of the manifest counts from 0 V; the file's has an offset of its own.
  const bool is_own = cantilever.sensitivity_m == gain(to_bent);
  const auto bent_m =
      converted(volts, is_own ? *to_bent : std::vector<Linear>{{0, cantilever.sensitivity_m}});
  for (double& z : height_m) z = -z;
  bend_cantilever(cantilever, height_m, bent_m, r);
  if (r.cantilever) return;  // noted before
  r.cantilever = cantilever;
  r.is_force_from_signal = true;
  r.taken = noted.taken;
  r.taken.push_back("height of " + channel);
}

RawRecording read_curve(ZipFile& zip, const Curve& curve,
                        const std::shared_ptr<const jpk::Properties>& shared,
                        const ReadSettings& settings) {
  RawRecording r;
  std::vector<std::string> styles;
  double begins_s = 0;
  bool has_clock = true;
  for (const auto& [number, folder] : curve.segments) {
    JpkSegment segment(zip, folder, shared);
    styles.push_back(segment.style());
    if (styles.size() == 2 && styles[0] == "extend" && styles[1] == "retract")
      r.retract_begins = static_cast<Eigen::Index>(r.push_N.size());
    const std::size_t before = r.push_N.size();
    append(segment, settings, r);
    const double rows = static_cast<double>(r.push_N.size() - before),
                 duration_s = segment.duration_s().value_or(0);
    has_clock = has_clock && duration_s > 0;
    for (std::size_t i = before; i < r.push_N.size(); ++i) {
      r.time_s.push_back(begins_s + duration_s * static_cast<double>(i - before) / rows);
      r.line.push_back(i + 1);
    }
    begins_s += duration_s;
  }
  if (!has_clock) r.time_s.clear();
  if (styles.size() != 2) r.retract_begins.reset();
  r.taken.push_back("segments " + listed(styles));
  check_numbers(r, [&](const std::string& what, const std::string& remedy) {
    return zip.error(curve.folder, what, remedy);
  });
  const std::string own = curve.folder + "header.properties";
  if (!zip.has(own)) return r;
  std::optional<double> x, y;
  for (const auto& [key, value] : jpk::properties_of(zip.read(own))) {
    if (key.ends_with(".header.position.x")) x = parse_number(value, '.');
    if (key.ends_with(".header.position.y")) y = parse_number(value, '.');
  }
  if (x && y) place_in_plane(*x, *y, r);
  return r;
}

}  // namespace

bool begins_zip(std::string_view head) { return head.starts_with("PK\x03\x04"); }

std::vector<RawRecording> read_jpk(const std::filesystem::path& path, std::string_view bytes,
                                   const ReadSettings& settings) {
  ZipFile zip(path, bytes, settings.max_bytes);
  const auto curves = curves_of(zip.names());
  if (curves.empty())
    throw Error(path.string(), "is a zip file without a JPK force curve (segments/0)",
                "Unpack it and name the recordings in it, or save the curve again.");
  const std::string common = "shared-data/header.properties";
  const auto shared = std::make_shared<const jpk::Properties>(
      zip.has(common) ? jpk::properties_of(zip.read(common)) : jpk::Properties{});
  std::map<std::string, const Curve*> by_name;
  std::vector<std::string> names;
  for (const auto& [index, curve] : curves) {
    names.push_back(curve.folder.empty() ? "" : std::to_string(index));
    by_name[names.back()] = &curve;
  }
  return read_each(path, names, [&](const std::string& name) {
    return read_curve(zip, *by_name[name], shared, settings);
  });
}

}  // namespace palpate::importers
