// Igor binary wave, version 5, as Asylum Research's microscopes store force curves: a matrix with a
// column per channel in metres (ZSnsr or Raw rises towards the body; Defl is what the cantilever
// bends) and a note of "key: value" lines. Source: Igor Pro technical note 003.

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "libfit/core/text.hpp"
#include "libfit/recordings/formats/afm_curve.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::importers {
namespace {

constexpr std::size_t kBinHeader = 64, kData = 384;  // bytes before the wave header, and the data
constexpr std::size_t kLabel = 32;                   // bytes of a column's name
constexpr double kLargestNumber = 1e15;              // as in text files

struct WaveType {
  int code;
  std::size_t bytes;
};
constexpr WaveType kTypes[] = {{2, 4}, {4, 8}};  // single and double precision

// Numbers of a wave in the order of bytes it was written with.
class Bytes {
 public:
  explicit Bytes(std::string_view bytes)
      : bytes_(bytes),
        is_swapped_((bytes[0] == 0) == (std::endian::native == std::endian::little)) {}

  template <class T>
  T at(std::size_t where) const {
    char copy[sizeof(T)];
    std::memcpy(copy, bytes_.data() + where, sizeof(T));
    if (is_swapped_) std::reverse(copy, copy + sizeof(T));
    T value;
    std::memcpy(&value, copy, sizeof(T));
    return value;
  }
  std::string_view part(std::size_t where, std::size_t size) const {
    return bytes_.substr(where, size);
  }
  std::size_t size() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
  bool is_swapped_;
};

// What is where in a wave.
struct Wave {
  std::size_t rows = 0, columns = 0, number_bytes = 0;
  double step_s = 0;  // 0: rows are not in time
  std::vector<std::string> labels;
  std::map<std::string, std::string> note;
};

std::map<std::string, std::string> note_of(std::string_view text) {
  std::map<std::string, std::string> note;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (const std::size_t colon = line.find(':'); colon != std::string_view::npos)
      note[std::string(trimmed(line.substr(0, colon)))] =
          std::string(trimmed(line.substr(colon + 1)));
  }
  return note;
}

Wave wave_of(const Bytes& bytes, const FailCantilever& fail) {
  const auto cut_short = [&] {
    return fail("is an Igor wave that is cut short", "Copy it again from the instrument.");
  };
  Wave wave;
  const int code = bytes.at<std::int16_t>(kBinHeader + 16);
  const auto type = std::find_if(std::begin(kTypes), std::end(kTypes),
                                 [&](const WaveType& t) { return t.code == code; });
  const auto rows = bytes.at<std::int32_t>(kBinHeader + 68),
             columns = bytes.at<std::int32_t>(kBinHeader + 72),
             layers = bytes.at<std::int32_t>(kBinHeader + 76);
  if (type == std::end(kTypes) || rows <= 0 || columns <= 0 || layers > 1)
    throw fail("is an Igor wave that is no table of numbers with a column per channel",
               "Export the force curve itself.");
  wave.rows = static_cast<std::size_t>(rows), wave.columns = static_cast<std::size_t>(columns);
  wave.number_bytes = type->bytes;
  if (wave.columns > bytes.size() || wave.rows > bytes.size() / wave.columns / wave.number_bytes)
    throw cut_short();
  std::size_t at = kData + wave.rows * wave.columns * wave.number_bytes;
  // After the data: formula, note, units of the data, units of four dimensions, labels of each.
  std::size_t sizes[11];
  for (std::size_t k = 0; k < 11; ++k) {
    const auto size = bytes.at<std::int32_t>(8 + 4 * k);
    if (size < 0) throw cut_short();
    sizes[k] = static_cast<std::size_t>(size);
  }
  for (std::size_t k = 0; k < 11; ++k) {
    if (at > bytes.size() || sizes[k] > bytes.size() - at) throw cut_short();
    const std::string_view part = bytes.part(at, sizes[k]);
    if (k == 1) wave.note = note_of(part);
    if (k == 8)  // of columns, after the dimension's own
      for (std::size_t c = 1; c <= wave.columns && (c + 1) * kLabel <= part.size(); ++c) {
        const std::string_view label = part.substr(c * kLabel, kLabel);
        wave.labels.emplace_back(label.substr(0, label.find('\0')));
      }
    at += sizes[k];
  }
  if (bytes.part(kBinHeader + 152, 2) == std::string_view("s\0", 2))
    wave.step_s = bytes.at<double>(kBinHeader + 84);
  return wave;
}

// The first of these columns that the wave has.
std::size_t column_of(const Wave& wave, std::initializer_list<const char*> names,
                      const FailCantilever& fail) {
  for (const char* name : names)
    for (std::size_t c = 0; c < wave.labels.size(); ++c)
      if (wave.labels[c] == name) return c;
  throw fail(
      fmt::format("has no channel `{}`", *names.begin()),
      "Save the force curve with it. There are: " + listed(wave.labels).substr(0, 200) + ".");
}

double number_in(const Wave& wave, const std::string& key) {
  const auto found = wave.note.find(key);
  return found == wave.note.end() ? 0 : parse_number(found->second, '.').value_or(0);
}

// The row where the way back begins, where the note tells of one way in and one back.
std::optional<Eigen::Index> retract_row(const Wave& wave) {
  const auto directions = wave.note.find("Direction"), indexes = wave.note.find("Indexes");
  if (directions == wave.note.end() || indexes == wave.note.end() ||
      !directions->second.starts_with("NaN,1,-1"))
    return std::nullopt;
  const auto rows = split(indexes->second, ',');
  const auto row = rows.size() >= 3 ? parse_number(rows[1], '.') : std::nullopt;
  if (!row || !(*row >= 1) || !(*row < static_cast<double>(wave.rows))) return std::nullopt;
  return static_cast<Eigen::Index>(*row);
}

}  // namespace

bool begins_igor(std::string_view head) {
  if (head.size() < kData || (head.substr(0, 2) != std::string_view("\x05\0", 2) &&
                              head.substr(0, 2) != std::string_view("\0\x05", 2)))
    return false;
  const Bytes bytes(head);  // its 16-bit numbers add up to 0
  std::uint16_t sum = 0;
  for (std::size_t at = 0; at < kData; at += 2)
    sum = static_cast<std::uint16_t>(sum + bytes.at<std::uint16_t>(at));
  return sum == 0;
}

std::vector<RawRecording> read_igor(const std::filesystem::path& path, std::string_view content,
                                    const ReadSettings& settings) {
  const FailCantilever fail = [&](const std::string& what, const std::string& remedy) {
    return Error(path.string(), what, remedy);
  };
  if (!begins_igor(content))
    throw fail("is no Igor binary wave of version 5", "Save it again, or leave out `format`.");
  const Bytes bytes(content);
  const Wave wave = wave_of(bytes, fail);
  const std::size_t height = column_of(wave, {"ZSnsr", "ZSensor", "Raw", "Height"}, fail),
                    bend = column_of(wave, {"Defl", "Deflection"}, fail);
  RawRecording r;
  r.facts = wave.note;
  const Cantilever stated{number_in(wave, "SpringConstant"), number_in(wave, "InvOLS"), 0, 0};
  const Cantilever cantilever = cantilever_of(settings, stated, fail, r, true);
  const double gain =
      stated.sensitivity_m > 0 ? cantilever.sensitivity_m / stated.sensitivity_m : 1;
  const auto value = [&](std::size_t row, std::size_t column) {
    const std::size_t at = kData + (column * wave.rows + row) * wave.number_bytes;
    return wave.number_bytes == 4 ? static_cast<double>(bytes.at<float>(at)) : bytes.at<double>(at);
  };
  std::vector<double> scanner_m, bent_m;
  for (std::size_t i = 0; i < wave.rows; ++i) {
    const double z = value(i, height), d = gain * value(i, bend);
    if (std::abs(z) <= kLargestNumber && std::abs(d) <= kLargestNumber) {
      scanner_m.push_back(z), bent_m.push_back(d);
      r.line.push_back(i + 1);
    } else if (settings.drop_invalid) {
      ++r.dropped_rows;
    } else {
      throw fail(fmt::format("row {} is not a number in range", i + 1),
                 "Import with --drop-invalid to skip and count such rows.");
    }
  }
  if (r.line.empty()) throw fail("has no row of numbers", "Record it again, or leave it out.");
  bend_cantilever(cantilever, scanner_m, bent_m, r);
  if (wave.step_s > 0)
    for (const std::size_t line : r.line)
      r.time_s.push_back(wave.step_s * static_cast<double>(line - 1));
  check_numbers(r, fail);
  if (r.dropped_rows == 0) r.retract_begins = retract_row(wave);
  r.taken.push_back("height of " + wave.labels[height]);
  if (wave.note.count("XLVDT") && wave.note.count("YLVDT"))
    place_in_plane(number_in(wave, "XLVDT"), number_in(wave, "YLVDT"), r);
  return {r};
}

}  // namespace palpate::importers
