#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "libfit/io/hdf5/handle.hpp"

// Chunks of compressed data sets as they lie in a file; for the HDF5 files of this layer alone.

namespace palpate::h5 {

/// Attribute of our compressed data sets, # x 2 uint64, a row per chunk in order: hash of its
/// values and of how they are packed, hash of its stored bytes.
inline constexpr const char* kChunkHash = "chunk_hash";

struct ChunkHash {
  std::uint64_t values = 0, stored = 0;
};

/// Hash of a chunk's values, whole and padded, as `pack` packs them.
std::uint64_t values_hash(std::string_view values, std::size_t value_bytes);
/// A chunk as HDF5 stores it: shuffled, deflated, Fletcher-32 behind. Same values, same bytes.
std::string packed_chunk(std::string_view values, std::size_t value_bytes, unsigned deflate_level);
inline constexpr unsigned kDeflateLevel = 4;  // 6: 1 % less on control values for twice the time

/// Stored bytes of the chunk that begins at `row`, into `bytes`. False where there is none, or
/// one that claims more than `max_bytes`.
bool read_chunk(std::int64_t data_set, std::size_t row, std::uintmax_t max_bytes,
                std::string& bytes);

/// Chunks of one data set of a file written before, found by their values.
class EarlierChunks {
 public:
  EarlierChunks() = default;
  /// Nothing is found where the file holds no such data set, or one packed otherwise.
  EarlierChunks(const Handle& file, const std::string& name, std::size_t value_bytes,
                std::size_t chunk_rows);
  /// The stored bytes of a chunk with these values. False where there is none, or where its bytes
  /// are no longer those that were stored.
  bool find(std::uint64_t values, std::string& bytes, std::uint64_t& stored) const;

 private:
  Handle set_;
  std::size_t chunk_rows_ = 0;
  unsigned long long file_bytes_ = 0;
  std::unordered_map<std::uint64_t, std::pair<std::size_t, std::uint64_t>> chunk_;
};

/// A file to take chunks from, opened for reading; not valid where there is none.
Handle open_earlier(const std::filesystem::path& path);

}  // namespace palpate::h5
