// NanoScope force curve of a Bruker (Veeco, Digital Instruments) microscope: a header of lines
// `\key: value` in sections `\*name`, then the images that it names. The image of a curve holds the
// way in and the way back, as 16-bit integers; both begin where the scanner was lowest, so the way
// in stands there backwards. A value is the integer times the volts of its scale, times the
// sensitivity that the scale names.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "libfit/core/text.hpp"
#include "libfit/recordings/formats/afm_curve.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::importers {
namespace {

constexpr std::string_view kFirstLine = "\\*Force file list", kHeaderEnd = "\\*File list end";
constexpr std::size_t kLargestHeader = std::size_t{1} << 20;
constexpr std::int16_t kNotWritten = -32768;  // of rows beyond the end of a ramp

struct HeaderSection {
  std::string name;
  std::map<std::string, std::string> value;  // keys without `@4:`

  std::string text(const std::string& key) const {
    const auto found = value.find(key);
    return found == value.end() ? std::string() : found->second;
  }
};

// "@4:Z scale" is "Z scale" of a group.
std::string plain_key(std::string_view key) {
  if (!key.starts_with('@')) return std::string(key);
  key.remove_prefix(1);
  const std::size_t colon = key.find(':');
  const bool has_group =
      colon != std::string_view::npos && colon > 0 &&
      key.substr(0, colon).find_first_not_of("0123456789") == std::string_view::npos;
  return std::string(has_group ? key.substr(colon + 1) : key);
}

std::vector<HeaderSection> sections_of(std::string_view bytes, const FailCantilever& fail) {
  std::vector<HeaderSection> sections;
  std::string_view rest = bytes.substr(0, kLargestHeader);
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find_first_of("\r\n"), rest.size());
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (line == kHeaderEnd) return sections;
    if (line.starts_with("\\*")) {
      sections.push_back({std::string(line.substr(2)), {}});
    } else if (line.starts_with('\\') && !sections.empty()) {
      // The value begins after the first colon that a blank or nothing follows.
      std::size_t colon = line.find(':');
      while (colon != std::string_view::npos && colon + 1 < line.size() && line[colon + 1] != ' ')
        colon = line.find(':', colon + 1);
      if (colon != std::string_view::npos)
        sections.back().value.try_emplace(plain_key(line.substr(1, colon - 1)),
                                          std::string(trimmed(line.substr(colon + 1))));
    }
  }
  throw fail("has no end of its header: it is cut short or damaged",
             "Copy it again from the instrument.");
}

// The number in front of a text: "4096 4096" is 4096.
double leading_number(std::string_view text) {
  text = trimmed(text);
  return parse_number(text.substr(0, text.find_first_of(" \t")), '.').value_or(std::nan(""));
}

// "V [Sens. DeflSens] (0.000375 V/LSB) 3.5 V": what a scale names, its volts per bit and its value.
struct VoltScale {
  std::string sensitivity;
  double volts_per_bit = std::nan(""), volts = std::nan("");
};

VoltScale scale_of(const std::string& text) {
  VoltScale out;
  const std::size_t name = text.find('['), name_end = text.find(']'), bit = text.find('('),
                    bit_end = text.find(')');
  if (name != std::string::npos && name_end != std::string::npos && name < name_end)
    out.sensitivity = text.substr(name + 1, name_end - name - 1);
  if (bit != std::string::npos && bit_end != std::string::npos && bit < bit_end) {
    out.volts_per_bit = leading_number(text.substr(bit + 1, bit_end - bit - 1));
    out.volts = leading_number(text.substr(bit_end + 1));
  }
  return out;
}

// One file, as it is read.
class ForceFile {
 public:
  ForceFile(std::string_view bytes, const FailCantilever& fail)
      : bytes_(bytes), fail_(fail), sections_(sections_of(bytes, fail)) {}

  const HeaderSection* section(std::string_view name) const {
    const auto found = std::ranges::find(sections_, name, &HeaderSection::name);
    return found == sections_.end() ? nullptr : &*found;
  }

  // The force image of a channel, by the name in its square brackets.
  const HeaderSection* image(std::string_view channel) const {
    for (const HeaderSection& s : sections_)
      if (s.name == "Ciao force image list" &&
          s.text("Image Data").find(fmt::format("[{}]", channel)) != std::string::npos)
        return &s;
    return nullptr;
  }

  // Metres per volt of a sensitivity that some section states: "V 23.47 nm/V"; 0: none does.
  double metres_per_volt(const std::string& sensitivity) const {
    for (const HeaderSection& s : sections_) {
      const std::string text = s.text(sensitivity);
      if (!text.starts_with("V ")) continue;
      const double value = leading_number(text.substr(2));
      for (const auto& [unit, metre] :
           {std::pair{" nm/V", 1e-9}, {" um/V", 1e-6}, {" \xb5m/V", 1e-6}})
        if (text.ends_with(unit) && value > 0) return value * metre;
    }
    return 0;
  }

  // Rows of the way in and of the way back.
  std::pair<std::size_t, std::size_t> rows_of(const HeaderSection& image) const {
    const std::string text = image.text("Samps/line");
    const std::size_t blank = text.find(' ');
    const double in = leading_number(text),
                 back = blank == std::string::npos ? in : leading_number(text.substr(blank));
    if (!(in >= 2 && in <= 1e8 && back >= 0 && back <= 1e8))
      throw fail_("does not say how many rows its curve has (Samps/line)",
                  "Save the force curve again.");
    return {static_cast<std::size_t>(in), static_cast<std::size_t>(back)};
  }

  // Integers of an image in the order of time: the way in, then the way back.
  std::vector<std::int16_t> integers(const HeaderSection& image, std::size_t in,
                                     std::size_t back) const {
    if (const double width = leading_number(image.text("Bytes/pixel")); width != 2)
      throw fail_(fmt::format("stores numbers of {} bytes, and those of 2 are read", number(width)),
                  "Export the curve as text from NanoScope Analysis.");
    const double offset = leading_number(image.text("Data offset")),
                 length = leading_number(image.text("Data length"));
    const auto size = static_cast<double>(2 * (in + back));
    if (!(offset >= 0) || !(length >= size) ||
        !(offset + size <= static_cast<double>(bytes_.size())))
      throw fail_("is cut short: a channel lies beyond its end", "Copy it again.");
    if (length >= 2 * size)
      throw fail_("holds a map of force curves", "Export its curves one by one, or as text.");
    std::vector<std::int16_t> out(in + back);
    std::memcpy(out.data(), bytes_.data() + static_cast<std::size_t>(offset), 2 * out.size());
    std::reverse(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(in));
    return out;
  }

 private:
  std::string_view bytes_;
  const FailCantilever& fail_;
  std::vector<HeaderSection> sections_;
};

// Height of the scanner, rising towards the body: of the sensor, else of the ramp that was asked
// for.
std::vector<double> scanner_of(const ForceFile& file, const HeaderSection& deflection,
                               std::size_t in, std::size_t back, const FailCantilever& fail,
                               RawRecording& r) {
  std::vector<double> out;
  if (const HeaderSection* sensor = file.image("ZSensor")) {
    const VoltScale scale = scale_of(sensor->text("Z scale"));
    const double metre = file.metres_per_volt(scale.sensitivity) * scale.volts_per_bit;
    if (metre > 0 && file.rows_of(*sensor) == std::pair{in, back}) {
      for (const std::int16_t bits : file.integers(*sensor, in, back)) out.push_back(metre * bits);
      if (out[in - 1] < out[0])  // a sensor that falls where the scanner extends
        for (double& height : out) height = -height;
      r.taken.push_back("height of the sensor");
      return out;
    }
  }
  const VoltScale ramp = scale_of(deflection.text("Ramp size"));
  const double length_m = file.metres_per_volt(ramp.sensitivity) * ramp.volts;
  if (!(length_m > 0))
    throw fail("has neither a height sensor nor the size of its ramp",
               "Save the force curve with the channel Height Sensor.");
  for (std::size_t i = 0; i < in; ++i)
    out.push_back(length_m * static_cast<double>(i) / static_cast<double>(in - 1));
  for (std::size_t i = 0; i < back; ++i)
    out.push_back(length_m * (1 - static_cast<double>(i) /
                                      static_cast<double>(std::max<std::size_t>(2, back) - 1)));
  r.taken.push_back("height of the ramp");
  return out;
}

// Seconds of the way in and of the way back, by the ramp's speed, else by its rate; 0: not known.
std::pair<double, double> durations_of(const ForceFile& file, const HeaderSection& deflection) {
  const HeaderSection* force = file.section("Ciao force list");
  if (force == nullptr) return {0, 0};
  const double volts = scale_of(deflection.text("Ramp size")).volts,
               in = volts / leading_number(force->text("Forward vel.")),
               back = volts / leading_number(force->text("Reverse vel."));
  if (in > 0 && back > 0 && std::isfinite(in) && std::isfinite(back)) return {in, back};
  const double rate = leading_number(force->text("Scan rate"));
  return rate > 0 ? std::pair{0.5 / rate, 0.5 / rate} : std::pair{0., 0.};
}

std::optional<double> in_metres(const std::string& text) {
  const double value = leading_number(text);
  if (!std::isfinite(value)) return std::nullopt;
  if (text.ends_with(" nm")) return value * 1e-9;
  if (text.ends_with(" um") || text.ends_with(" \xb5m") || text.ends_with("~m"))
    return value * 1e-6;
  return std::nullopt;
}

}  // namespace

bool begins_nanoscope(std::string_view head) { return head.starts_with(kFirstLine); }

std::vector<RawRecording> read_nanoscope(const std::filesystem::path& path, std::string_view bytes,
                                         const ReadSettings& settings) {
  const FailCantilever fail = [&](const std::string& what, const std::string& remedy) {
    return Error(path.string(), what, remedy);
  };
  if (!begins_nanoscope(bytes))
    throw fail("is no NanoScope force curve", "Save it again, or leave out `format`.");
  const ForceFile file(bytes, fail);
  const HeaderSection* deflection = file.image("DeflectionError");
  if (deflection == nullptr) deflection = file.image("Deflection");
  if (deflection == nullptr)
    throw fail("has no channel of the deflection", "Save the force curve with Deflection Error.");
  const auto [in, back] = file.rows_of(*deflection);
  const VoltScale scale = scale_of(deflection->text("Z scale"));
  if (!(scale.volts_per_bit > 0))
    throw fail("does not say the scale of its deflection", "Save the force curve again.");

  RawRecording r;
  const double spring_N_m = leading_number(deflection->text("Spring Constant"));
  const Cantilever stated{spring_N_m > 0 ? spring_N_m : 0, file.metres_per_volt(scale.sensitivity),
                          0, 0};
  const Cantilever cantilever = cantilever_of(settings, stated, fail, r);
  const std::vector<std::int16_t> bits = file.integers(*deflection, in, back);
  const std::vector<double> height_m = scanner_of(file, *deflection, in, back, fail, r);
  const auto [in_s, back_s] = durations_of(file, *deflection);
  std::vector<double> scanner_m, volts;
  for (std::size_t i = 0; i < bits.size(); ++i) {
    if (bits[i] == kNotWritten) continue;
    if (i == in) r.retract_begins = static_cast<Eigen::Index>(r.line.size());
    scanner_m.push_back(height_m[i]);
    volts.push_back(scale.volts_per_bit * bits[i]);
    r.line.push_back(i + 1);
    if (in_s > 0)
      r.time_s.push_back(i < in ? in_s * static_cast<double>(i) / static_cast<double>(in)
                                : in_s + back_s * static_cast<double>(i - in) /
                                             static_cast<double>(back));
  }
  if (r.line.empty()) throw fail("has no row of numbers", "Record it again, or leave it out.");
  bend_cantilever(cantilever, scanner_m, bent_by(cantilever, volts), r);
  check_numbers(r, fail);
  if (const HeaderSection* scan = file.section("Ciao scan list")) {
    const auto x = in_metres(scan->text("X Offset")), y = in_metres(scan->text("Y Offset"));
    if (x && y) place_in_plane(*x, *y, r);
  }
  return {r};
}

}  // namespace palpate::importers
