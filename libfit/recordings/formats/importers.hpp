#pragma once

#include <functional>
#include <span>
#include <string_view>

#include "libfit/recordings/formats/recording.hpp"
#include "libfit/recordings/formats/text_file.hpp"

namespace palpate::importers {

/// A row of the table of recording formats.
struct Importer {
  std::string_view name;
  std::string_view summary;
  /// Whether a file begins like this format (its first bytes, unpacked); nullptr: never chosen by
  /// itself.
  bool (*begins)(std::string_view head);
  /// The recordings of a file. bytes: its content, unpacked. Throws Error naming file and line.
  std::vector<RawRecording> (*read)(const std::filesystem::path& path, std::string_view bytes,
                                    const ReadSettings& settings);
};

/// All formats, in the order in which a file is tried; "csv" takes what no other takes.
std::span<const Importer> importers();

/// The row of a name, nullptr when there is none.
const Importer* importer_named(std::string_view name);

/// A key of a recording's entry that some formats alone read.
struct FormatKey {
  std::string_view name;     ///< as in the manifest: "separator", "columns.normal"
  std::string_view formats;  ///< that read it, with blanks between
  std::string_view remedy;   ///< for other formats
};

std::span<const FormatKey> format_keys();

/// The key's row; nullptr of a key that every format reads.
const FormatKey* format_key(std::string_view name);

/// Bytes of a recording's file as it lies there. Throws Error when it is missing, cannot be read or
/// is larger than `max_bytes`; nothing of a larger file is read.
std::string read_bytes(const std::filesystem::path& path, std::uintmax_t max_bytes);

/// Takes bytes apart that are gzip, and leaves others as they are. Throws Error when they are
/// damaged or unpack to more than `max_bytes`.
std::string unpacked(const std::filesystem::path& path, std::string bytes,
                     std::uintmax_t max_bytes);

/// Takes one stream of zlib or gzip members apart, never more than `max_bytes`. Throws Error saying
/// that the file `is_damaged`, or that it holds more.
std::string inflated(const std::filesystem::path& path, std::string_view packed,
                     std::uintmax_t max_bytes, const std::string& is_damaged);

/// Reads once in a process of its own, whose result is dropped. Throws Error where that process
/// crashes or takes a minute of CPU time; what `read` throws is left to the second reading.
void rehearse(const std::filesystem::path& path, const std::function<void()>& read);

/// The recordings in the content of a file by its format, or by the format it begins like.
/// Every recording has at least one row, or of several says why it is unread; all numbers are
/// finite and within 1e15 of zero. Each names the format and what was taken from the file. Safe on
/// untrusted bytes: what the HDF5 library reads is rehearsed, one file at a time.
std::vector<RawRecording> read_recordings(const std::filesystem::path& path, std::string_view bytes,
                                          const ReadSettings& settings);

// The rows' functions, each in the file of its name.
std::vector<RawRecording> read_columns_csv(const std::filesystem::path&, std::string_view,
                                           const ReadSettings&);
std::vector<RawRecording> read_columns_hdf5(const std::filesystem::path&, std::string_view,
                                            const ReadSettings&);
std::vector<RawRecording> read_robot_palpation(const std::filesystem::path&, std::string_view,
                                               const ReadSettings&);
std::vector<RawRecording> read_matlab(const std::filesystem::path&, std::string_view,
                                      const ReadSettings&);
bool begins_matlab(std::string_view head);
bool begins_named_columns(std::string_view head);
bool begins_hdf5(std::string_view head);

}  // namespace palpate::importers
