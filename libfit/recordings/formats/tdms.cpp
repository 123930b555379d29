// LabVIEW's TDMS: segments, each a lead-in, meta data of the objects that changed, and raw data of
// the channels that are active, in chunks: one channel after the other, or interleaved row by row.
// A group of channels is a recording. Raw data of DAQmx, which has a layout of its own, is refused.
// Source: NI, "TDMS File Format Internal Structure".

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "libfit/core/text.hpp"
#include "libfit/recordings/formats/columns.hpp"
#include "libfit/recordings/formats/importers.hpp"

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

struct TdmsType {
  std::uint32_t code;
  std::size_t bytes;
  double (*read)(const char*, bool);
};
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

// Where a segment has values of a channel: `chunks` times `count` of them, `stride` bytes apart.
struct TdmsBlock {
  std::size_t at = 0, count = 0, stride = 0, chunks = 0, chunk_bytes = 0;
  bool is_big = false;
};

struct TdmsChannel {
  std::string group, name, unit;
  const TdmsType* type = nullptr;  // of numbers; strings and others: none
  std::size_t chunk_values = 0, chunk_bytes = 0;
  bool is_active = false;
  double step_s = 0;  // wf_increment
  std::map<std::string, std::string> text;
  std::map<std::string, double> number;
  std::vector<TdmsBlock> blocks;

  std::string header() const { return unit.empty() ? name : name + " (" + unit + ")"; }
};

class TdmsFile {
 public:
  TdmsFile(const std::filesystem::path& path, std::string_view bytes) : path_(path), bytes_(bytes) {
    for (std::size_t at = 0; at + kLeadIn <= bytes.size();) at = read_segment(at);
  }

  const std::vector<TdmsChannel>& channels() const { return channels_; }
  bool is_cut_short() const { return is_cut_short_; }

  std::vector<double> values(const TdmsChannel& channel) const {
    std::vector<double> out;
    for (const TdmsBlock& b : channel.blocks)
      for (std::size_t chunk = 0; chunk < b.chunks; ++chunk)
        for (std::size_t i = 0; i < b.count; ++i)
          out.push_back(channel.type->read(
              bytes_.data() + b.at + chunk * b.chunk_bytes + i * b.stride, b.is_big));
    if (channel.type->code == kTimestamp && !out.empty())
      for (const double first = out[0]; double& second : out) second -= first;
    scale(channel, out);
    return out;
  }

 private:
  Error damaged() const {
    return Error(path_.string(), "is a damaged TDMS file", "Copy it again from the rig.");
  }

  template <class T>
  T next() {
    if (bytes_.size() - at_ < sizeof(T)) throw damaged();
    at_ += sizeof(T);
    return stored<T>(bytes_.data() + at_ - sizeof(T), is_big_);
  }
  std::string next_text() {
    const std::size_t size = next<std::uint32_t>();
    if (size > bytes_.size() - at_) throw damaged();
    at_ += size;
    return std::string(bytes_.substr(at_ - size, size));
  }

  // "/'Group'/'It''s a channel'": its parts.
  std::vector<std::string> parts_of(const std::string& path) const {
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

  void read_property(TdmsChannel& of) {
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
  void read_object() {
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
  std::size_t read_segment(std::size_t at) {
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

  void add_blocks(std::size_t raw, std::size_t end, bool is_interleaved) {
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

  Error too_much(const char* of, std::size_t limit) const {
    return Error(path_.string(), fmt::format("has more than {} {}", limit, of),
                 "Defragment it (TDMS Defragment), or save it as text.");
  }
  Error daqmx() const {
    return Error(path_.string(), "holds raw data of DAQmx, whose layout is not read",
                 "Save it with scaled numbers (the TDMS Write function), or as text.");
  }

  // Scales of NI that the file leaves to the reader: linear ones.
  void scale(const TdmsChannel& channel, std::vector<double>& values) const {
    const auto status = channel.text.find("NI_Scaling_Status");
    const auto count = channel.number.find("NI_Number_Of_Scales");
    if (status == channel.text.end() || status->second != "unscaled" ||
        count == channel.number.end())
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

  const std::filesystem::path& path_;
  std::string_view bytes_;
  std::size_t at_ = 0, pieces_ = 0;
  bool is_big_ = false, is_cut_short_ = false;
  std::map<std::string, std::size_t> number_of_;  // of each channel, group and the file itself
  std::vector<TdmsChannel> channels_;
  std::vector<std::size_t> active_;
};

using TdmsGroup = std::vector<const TdmsChannel*>;

// Channels with numbers, by their group; all in one where columns are named "Group/Channel".
std::vector<std::pair<std::string, TdmsGroup>> groups_of(const TdmsFile& file, bool is_whole) {
  std::vector<std::pair<std::string, TdmsGroup>> groups;
  for (const TdmsChannel& channel : file.channels()) {
    if (channel.blocks.empty()) continue;
    const std::string name = is_whole ? "" : channel.group;
    auto found = std::ranges::find(groups, name, &std::pair<std::string, TdmsGroup>::first);
    if (found == groups.end()) found = groups.insert(groups.end(), {name, {}});
    found->second.push_back(&channel);
  }
  return groups;
}

bool names_group(const ColumnNames& names) {
  return std::ranges::any_of(
      roles_of(names), [](const Role& role) { return role.name.find('/') != std::string::npos; });
}

// Whether a group has a channel that is named, or channels that name themselves.
bool offers_columns(const TdmsGroup& group, const ColumnNames& names) {
  std::vector<std::string> header;
  for (const TdmsChannel* c : group) header.push_back(c->header());
  const auto roles = roles_of(names);
  if (roles.empty()) return !columns_named(header).columns.force.empty();
  return std::ranges::any_of(roles, [&](const Role& role) {
    return std::ranges::any_of(header, [&](const std::string& of) {
      return split_unit(of).first == split_unit(role.name).first;
    });
  });
}

RawRecording recording_of(const std::filesystem::path& path, const TdmsFile& file,
                          const TdmsGroup& group, bool is_whole, const ReadSettings& given) {
  const auto fail_at = [&](const std::string& name) {
    return [&path, name](const std::string& what, const std::string& remedy) {
      return Error(path.string() + (name.empty() ? "" : ":" + name), what, remedy);
    };
  };
  std::vector<std::string> header;
  for (const TdmsChannel* c : group)
    header.push_back((is_whole ? c->group + "/" : "") + c->header());
  std::string taken;
  const ReadSettings settings = with_named_columns(given, header, fail_at(""), taken);
  const auto roles = roles_of(settings.columns);
  if (roles.empty())
    throw fail_at("")("no channel is named",
                      "Name columns = { depth = ..., force = ... } in the manifest. There are: " +
                          listed(header) + ".");
  const auto fields = find_columns(roles, header, fail_at(""));
  std::vector<std::vector<double>> columns;
  std::vector<double> factors;
  double step_s = group[fields[0]]->step_s;
  for (std::size_t k = 0; k < roles.size(); ++k) {
    const TdmsChannel& channel = *group[fields[k]];
    columns.push_back(file.values(channel));
    factors.push_back(
        channel.type->code == kTimestamp
            ? 1
            : factor_of(roles[k], header[fields[k]], settings.units, fail_at(roles[k].name)));
    if (channel.step_s != step_s) step_s = 0;
  }
  RawRecording r = recording_of_arrays(
      roles, std::move(columns), factors, settings,
      [&](const Role& role, const std::string& what, const std::string& remedy) {
        return fail_at(role.name)(what, remedy);
      });
  if (!taken.empty()) r.taken.push_back(taken);
  if (r.time_s.empty() && settings.columns.retract_depth.empty() && step_s > 0 && step_s < 1e6) {
    for (const std::size_t line : r.line)
      r.time_s.push_back(step_s * static_cast<double>(line - 1));
    r.taken.push_back("readings every " + number(step_s) + " s");
  }
  if (file.is_cut_short()) r.taken.push_back("the file is cut short: what is whole was read");
  return r;
}

}  // namespace

bool begins_tdms(std::string_view head) { return head.starts_with("TDSm"); }

std::vector<RawRecording> read_tdms(const std::filesystem::path& path, std::string_view bytes,
                                    const ReadSettings& settings) {
  if (!begins_tdms(bytes))
    throw Error(path.string(), "is no TDMS file", "Name the file with the data, not its index.");
  const TdmsFile file(path, bytes);
  const bool is_whole = names_group(settings.columns);
  const auto groups = groups_of(file, is_whole);
  if (groups.empty())
    throw Error(path.string(), "has no channel with numbers", "Record it again, or leave it out.");
  if (groups.size() == 1) return {recording_of(path, file, groups[0].second, is_whole, settings)};
  std::vector<RawRecording> out;
  for (const auto& [name, group] : groups) {
    if (!offers_columns(group, settings.columns)) continue;  // settings, notes
    RawRecording r;
    try {
      r = recording_of(path, file, group, is_whole, settings);
    } catch (const Error& error) {
      r.unread = error;
    }
    r.name = name;
    out.push_back(std::move(r));
  }
  if (out.empty()) {
    std::vector<std::string> names;
    for (const auto& [name, group] : groups)
      for (const TdmsChannel* c : group) names.push_back(name + "/" + c->header());
    throw Error(path.string(), "has no group with the channels that are wanted",
                "Name columns = { depth = ..., force = ... } in the manifest. There are: " +
                    listed(names).substr(0, 300) + ".");
  }
  return out;
}

}  // namespace palpate::importers
