#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/error.hpp"

namespace palpate::importers {

/// How a value is stored, and as a double.
struct TdmsType {
  std::uint32_t code;
  std::size_t bytes;
  double (*read)(const char*, bool is_big);
};

/// Where a segment has values of a channel: `chunks` times `count` of them, `stride` bytes apart.
struct TdmsBlock {
  std::size_t at = 0, count = 0, stride = 0, chunks = 0, chunk_bytes = 0;
  bool is_big = false;
};

/// A channel of a TDMS file; groups and the file itself are objects like it, without values.
struct TdmsChannel {
  std::string group, name, unit;
  const TdmsType* type = nullptr;  ///< of numbers; strings and others: none
  std::size_t chunk_values = 0, chunk_bytes = 0;
  bool is_active = false;
  double step_s = 0;  ///< between readings (wf_increment); 0: not said
  std::map<std::string, std::string> text;
  std::map<std::string, double> number;
  std::vector<TdmsBlock> blocks;

  std::string header() const { return unit.empty() ? name : name + " (" + unit + ")"; }
  bool is_of_times() const;
};

/// The objects of LabVIEW's TDMS: segments, each a lead-in, meta data of the objects that changed,
/// and raw data of the channels that are active, in chunks: one channel after the other, or
/// interleaved row by row. Raw data of DAQmx, which has a layout of its own, is refused.
/// Safe on untrusted bytes; `path` and `bytes` must outlive it. Throws Error on damaged files.
/// Source: NI, "TDMS File Format Internal Structure".
class TdmsFile {
 public:
  TdmsFile(const std::filesystem::path& path, std::string_view bytes);

  const std::vector<TdmsChannel>& channels() const { return channels_; }
  bool is_cut_short() const { return is_cut_short_; }
  /// With linear scales of NI that the file leaves to the reader; times in seconds since the first.
  /// Precondition: the channel has a block.
  std::vector<double> values(const TdmsChannel& channel) const;

 private:
  template <class T>
  T next();
  std::string next_text();
  std::vector<std::string> parts_of(const std::string& path) const;
  void read_property(TdmsChannel& of);
  void read_object();
  std::size_t read_segment(std::size_t at);
  void add_blocks(std::size_t raw, std::size_t end, bool is_interleaved);
  void scale(const TdmsChannel& channel, std::vector<double>& values) const;
  Error damaged() const;
  Error too_much(const char* of, std::size_t limit) const;
  Error daqmx() const;

  const std::filesystem::path& path_;
  std::string_view bytes_;
  std::size_t at_ = 0, pieces_ = 0;
  bool is_big_ = false, is_cut_short_ = false;
  std::map<std::string, std::size_t> number_of_;  // of each channel, group and the file itself
  std::vector<TdmsChannel> channels_;
  std::vector<std::size_t> active_;
};

}  // namespace palpate::importers
