#include "libfit/recordings/formats/tdms_file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "libfit/recordings/formats/text_file.hpp"

namespace palpate::importers {
namespace {

constexpr std::size_t kLeadIn = 28, kMaxPieces = 10'000'000, kMaxChannels = 10'000;
enum Contents : std::uint32_t {  // bits of a lead-in
  kMeta = 1 << 1,
  kNewList = 1 << 2,
  kRaw = 1 << 3,
  kInterleaved = 1 << 5,
  kBigEndian = 1 << 6,
  kDaqmx = 1 << 7
};
constexpr std::uint32_t kNoData = 0xffffffff, kAsBefore = 0, kDaqmxIndex = 0x1269,
                        kDaqmxDigital = 0x1369, kStrings = 0x20;
constexpr std::uint64_t kToTheEnd = ~std::uint64_t{0};

template <class T>
T stored(const char* bytes, bool is_big) {
  char copy[sizeof(T)];
  std::memcpy(copy, bytes, sizeof(T));
  if (is_big != (std::endian::native == std::endian::big)) std::reverse(copy, copy + sizeof(T));
  T value;
  std::memcpy(&value, copy, sizeof(T));
  return value;
}

template <class T>
double number_of(const char* bytes, bool is_big) {
  return static_cast<double>(stored<T>(bytes, is_big));
}

// Seconds since 1904: a fraction in 2^-64 and whole seconds, the other way round in big-endian.
double seconds_of(const char* bytes, bool is_big) {
  const auto fraction = stored<std::uint64_t>(bytes + (is_big ? 8 : 0), is_big);
  const auto whole = stored<std::int64_t>(bytes + (is_big ? 0 : 8), is_big);
  return static_cast<double>(whole) + std::ldexp(static_cast<double>(fraction), -64);
}

constexpr std::uint32_t kTimestamp = 0x44;
constexpr TdmsType kTypes[] = {{1, 1, number_of<std::int8_t>},     {2, 2, number_of<std::int16_t>},
                               {3, 4, number_of<std::int32_t>},    {4, 8, number_of<std::int64_t>},
                               {5, 1, number_of<std::uint8_t>},    {6, 2, number_of<std::uint16_t>},
                               {7, 4, number_of<std::uint32_t>},   {8, 8, number_of<std::uint64_t>},
                               {9, 4, number_of<float>},           {10, 8, number_of<double>},
                               {0x19, 4, number_of<float>},        {0x1a, 8, number_of<double>},
                               {0x21, 1, number_of<std::uint8_t>}, {kTimestamp, 16, seconds_of}};

const TdmsType* type_of(std::uint32_t code) {
  const auto found = std::ranges::find(kTypes, code, &TdmsType::code);
  return found == std::end(kTypes) ? nullptr : found;
}

}  // namespace

bool TdmsChannel::is_of_times() const { return type != nullptr && type->code == kTimestamp; }

TdmsFile::TdmsFile(const std::filesystem::path& path, std::string_view bytes)
    : path_(path), bytes_(bytes) {
  for (std::size_t at = 0; at + kLeadIn <= bytes.size();) at = read_segment(at);
}

std::vector<double> TdmsFile::values(const TdmsChannel& channel) const {
  std::vector<double> out;
  for (const TdmsBlock& b : channel.blocks)
    for (std::size_t chunk = 0; chunk < b.chunks; ++chunk)
      for (std::size_t i = 0; i < b.count; ++i)
        out.push_back(channel.type->read(
            bytes_.data() + b.at + chunk * b.chunk_bytes + i * b.stride, b.is_big));
  if (channel.is_of_times() && !out.empty())
    for (const double first = out[0]; double& second : out) second -= first;
  scale(channel, out);
  return out;
}

Error TdmsFile::damaged() const {
  return Error(path_.string(), "is a damaged TDMS file", "Copy it again from the rig.");
}

template <class T>
T TdmsFile::next() {
  if (bytes_.size() - at_ < sizeof(T)) throw damaged();
  at_ += sizeof(T);
  return stored<T>(bytes_.data() + at_ - sizeof(T), is_big_);
}

std::string TdmsFile::next_text() {
  const std::size_t size = next<std::uint32_t>();
  if (size > bytes_.size() - at_) throw damaged();
  at_ += size;
  return std::string(bytes_.substr(at_ - size, size));
}

// "/'Group'/'It''s a channel'": its parts.
std::vector<std::string> TdmsFile::parts_of(const std::string& path) const {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i + 1 < path.size();) {
    if (path[i] != '/' || path[i + 1] != '\'') throw damaged();
    std::string part;
    for (i += 2;; ++i) {
      if (i >= path.size()) throw damaged();
      if (path[i] == '\'' && (i + 1 == path.size() || path[i + 1] != '\'')) break;
      i += path[i] == '\'';
      part += path[i];
    }
    parts.push_back(part);
    ++i;
  }
  return parts;
}

void TdmsFile::read_property(TdmsChannel& of) {
  const std::string name = next_text();
  const auto code = next<std::uint32_t>();
  if (code == kStrings) {
    of.text[name] = next_text();
    if (name == "unit_string") of.unit = std::string(trimmed(of.text[name]));
    return;
  }
  const TdmsType* type = type_of(code);
  if (!type || type->bytes > bytes_.size() - at_) throw damaged();
  of.number[name] = type->read(bytes_.data() + at_, is_big_);
  if (name == "wf_increment") of.step_s = of.number[name];
  at_ += type->bytes;
}

// One object of a segment's meta data.
void TdmsFile::read_object() {
  const std::string path = next_text();
  const auto [known, is_new] = number_of_.try_emplace(path, channels_.size());
  const std::size_t number = known->second;
  if (is_new) {
    const auto parts = parts_of(path);
    if (channels_.size() == kMaxChannels) throw too_much("channels", kMaxChannels);
    channels_.emplace_back();
    if (!parts.empty()) channels_.back().group = parts[0];
    if (parts.size() > 1) channels_.back().name = parts[1];
  }
  TdmsChannel& channel = channels_[number];
  const auto index = next<std::uint32_t>();
  if (index == kDaqmxIndex || index == kDaqmxDigital) throw daqmx();
  if (index != kNoData && index != kAsBefore) {
    const auto code = next<std::uint32_t>(), dimension = next<std::uint32_t>();
    const auto count = next<std::uint64_t>();
    const TdmsType* type = type_of(code);
    if (dimension != 1 || count > bytes_.size() || (channel.type && channel.type != type))
      throw damaged();
    channel.type = type;
    channel.chunk_values = static_cast<std::size_t>(count);
    const auto size = code == kStrings ? next<std::uint64_t>() : type ? count * type->bytes : 0;
    if ((!type && code != kStrings) || size > bytes_.size())
      throw Error(path_.string() + ":" + channel.name,
                  fmt::format("holds numbers of type {:#x}, which is not read", code),
                  "Save it as numbers of 1 to 8 bytes, or as text.");
    channel.chunk_bytes = static_cast<std::size_t>(size);
  }
  if (channel.is_active && index == kNoData) std::erase(active_, number);
  if (!channel.is_active && index != kNoData) active_.push_back(number);
  channel.is_active = index != kNoData;
  for (auto left = next<std::uint32_t>(); left > 0; --left) read_property(channel);
}

// Reads the segment at a place; where the next one begins.
std::size_t TdmsFile::read_segment(std::size_t at) {
  if (bytes_.substr(at, 4) != "TDSm") throw damaged();
  const auto contents = stored<std::uint32_t>(bytes_.data() + at + 4, false);
  is_big_ = contents & kBigEndian;
  at_ = at + 12;
  const auto next_at = next<std::uint64_t>(), raw_at = next<std::uint64_t>();
  const std::size_t left = bytes_.size() - at_;
  is_cut_short_ |= next_at > left;
  const std::size_t size = next_at > left ? left : static_cast<std::size_t>(next_at);
  if (raw_at > size) {
    if (next_at == kToTheEnd || next_at > left) return bytes_.size();  // stopped in the meta data
    throw damaged();
  }
  const std::size_t raw = at_ + static_cast<std::size_t>(raw_at), end = at_ + size;
  if (contents & kNewList) {
    for (const std::size_t c : active_) channels_[c].is_active = false;
    active_.clear();
  }
  if (contents & kMeta)
    for (auto objects = next<std::uint32_t>(); objects > 0; --objects) read_object();
  if (contents & kDaqmx) throw daqmx();
  if (contents & kRaw) add_blocks(raw, end, contents & kInterleaved);
  return end;
}

void TdmsFile::add_blocks(std::size_t raw, std::size_t end, bool is_interleaved) {
  std::size_t chunk = 0, row = 0, rows = 0;
  if ((pieces_ += active_.size()) > kMaxPieces) throw too_much("pieces", kMaxPieces);
  for (const std::size_t c : active_) {
    chunk += channels_[c].chunk_bytes;
    row += channels_[c].type ? channels_[c].type->bytes : 0;
    rows = std::max(rows, channels_[c].chunk_values);
  }
  if (chunk == 0 || raw >= end) return;
  if (is_interleaved) {  // rows alone count, however many chunks they are
    for (const std::size_t c : active_)
      if (!channels_[c].type || channels_[c].chunk_values != rows) throw damaged();
    rows = (end - raw) / row;
  }
  const std::size_t chunks = is_interleaved ? 1 : (end - raw) / chunk;
  is_cut_short_ |= (end - raw) % (is_interleaved ? row : chunk) != 0;
  std::size_t at = raw;
  for (const std::size_t c : active_) {
    TdmsChannel& channel = channels_[c];
    const std::size_t bytes = channel.type ? channel.type->bytes : 0;
    if (channel.type && chunks > 0) {
      channel.blocks.push_back({at, is_interleaved ? rows : channel.chunk_values,
                                is_interleaved ? row : bytes, chunks, chunk, is_big_});
    }
    at += is_interleaved ? bytes : channel.chunk_bytes;
  }
}

Error TdmsFile::too_much(const char* of, std::size_t limit) const {
  return Error(path_.string(), fmt::format("has more than {} {}", limit, of),
               "Defragment it (TDMS Defragment), or save it as text.");
}

Error TdmsFile::daqmx() const {
  return Error(path_.string(), "holds raw data of DAQmx, whose layout is not read",
               "Save it with scaled numbers (the TDMS Write function), or as text.");
}

// Scales of NI that the file leaves to the reader: linear ones.
void TdmsFile::scale(const TdmsChannel& channel, std::vector<double>& values) const {
  const auto status = channel.text.find("NI_Scaling_Status");
  const auto count = channel.number.find("NI_Number_Of_Scales");
  if (status == channel.text.end() || status->second != "unscaled" || count == channel.number.end())
    return;
  for (int k = 0; k < std::min(count->second, 100.0); ++k) {
    const std::string name = fmt::format("NI_Scale[{}]_", k);
    const auto type = channel.text.find(name + "Scale_Type");
    const auto slope = channel.number.find(name + "Linear_Slope"),
               zero = channel.number.find(name + "Linear_Y_Intercept");
    if (type == channel.text.end()) continue;
    if (type->second != "Linear" || slope == channel.number.end() || zero == channel.number.end())
      throw Error(path_.string() + ":" + channel.name,
                  "has a scale of type " + type->second + ", and linear ones are read",
                  "Save scaled numbers, or text.");
    for (double& value : values) value = slope->second * value + zero->second;
  }
}

}  // namespace palpate::importers
