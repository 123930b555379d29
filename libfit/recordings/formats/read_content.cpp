// The bytes of a recording's file, unpacked.

#include <fmt/core.h>

#include <zlib.h>

#include <algorithm>
#include <fstream>

#include "libfit/recordings/formats/importers.hpp"

namespace palpate::importers {
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kChunk = std::size_t{1} << 20;

std::string in_mebibytes(std::uintmax_t bytes) { return fmt::format("{} MiB", bytes >> 20); }

Error too_large(const fs::path& path, std::uintmax_t most) {
  return Error(path.string(), "holds more than " + in_mebibytes(most),
               "Cut it into one recording per file, or raise `largest_file` in the manifest.");
}

}  // namespace

std::string inflated(const fs::path& path, std::string_view packed, std::uintmax_t most,
                     const std::string& is_damaged) {
  const Error damaged(path.string(), is_damaged, "Pack or save it again from its source.");
  z_stream stream{};
  if (inflateInit2(&stream, 32 + MAX_WBITS) != Z_OK) throw damaged;
  struct End {
    z_stream& stream;
    ~End() { inflateEnd(&stream); }
  } end{stream};
  std::string text;
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(std::min<std::size_t>(packed.size(), 0xffffffffu));
  while (true) {
    const std::size_t before = text.size();
    text.resize(before + kChunk);
    stream.next_out = reinterpret_cast<Bytef*>(text.data() + before);
    stream.avail_out = kChunk;
    const int result = inflate(&stream, Z_NO_FLUSH);
    text.resize(before + kChunk - stream.avail_out);
    if (text.size() > most) throw too_large(path, most);
    if (result == Z_STREAM_END) {
      if (stream.avail_in == 0) return text;
      if (inflateReset(&stream) != Z_OK) throw damaged;
    } else if (result != Z_OK || (stream.avail_in == 0 && stream.avail_out != 0)) {
      throw damaged;
    }
  }
}

std::string read_bytes(const fs::path& path, std::uintmax_t max_bytes) {
  std::error_code failure;
  const fs::file_status status = fs::status(path, failure);
  if (!fs::exists(status))
    throw Error(path.string(), "no such file",
                "Correct its name in the manifest; names start at the manifest's folder.");
  if (!fs::is_regular_file(status))
    throw Error(path.string(), "is no regular file", "Name a file in the manifest.");
  const std::uintmax_t size = fs::file_size(path, failure);
  if (!failure && size > max_bytes) throw too_large(path, max_bytes);
  std::ifstream file(path, std::ios::binary);
  std::string bytes(failure ? 0 : size, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!file.is_open() || file.bad())
    throw Error(path.string(), "cannot be read", "Check its permissions.");
  bytes.resize(file.gcount());
  return bytes;
}

std::string unpacked(const fs::path& path, std::string bytes, std::uintmax_t max_bytes) {
  return bytes.starts_with("\x1f\x8b") ? inflated(path, bytes, max_bytes, "is a damaged gzip file")
                                       : std::move(bytes);
}

}  // namespace palpate::importers
