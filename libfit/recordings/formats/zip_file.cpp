#include "libfit/recordings/formats/zip_file.hpp"

#include <fmt/core.h>
#include <zip.h>

namespace palpate::importers {
namespace {

constexpr std::size_t kChunk = std::size_t{1} << 16;

struct PartCloser {
  void operator()(zip_file* part) const { zip_fclose(part); }
};

}  // namespace

ZipFile::ZipFile(const std::filesystem::path& path, std::string_view bytes,
                 std::uintmax_t max_bytes)
    : path_(path),
      left_(max_bytes),
      max_bytes_(max_bytes),
      archive_(nullptr, [](zip* archive) { zip_discard(archive); }) {
  zip_error_t failure;
  zip_error_init(&failure);
  zip_source_t* source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &failure);
  if (source) archive_.reset(zip_open_from_source(source, ZIP_RDONLY, &failure));
  if (source && !archive_) zip_source_free(source);
  zip_error_fini(&failure);
  if (!archive_)
    throw Error(path_.string(), "is a zip file that is cut short or damaged",
                "Copy it again from the instrument.");
  for (zip_int64_t i = 0; i < zip_get_num_entries(archive_.get(), 0); ++i)
    if (const char* name = zip_get_name(archive_.get(), static_cast<zip_uint64_t>(i), 0))
      names_.emplace_back(name);
}

bool ZipFile::has(const std::string& name) const {
  return zip_name_locate(archive_.get(), name.c_str(), 0) >= 0;
}

std::string ZipFile::read(const std::string& name) {
  zip_stat_t stat;
  if (zip_stat(archive_.get(), name.c_str(), 0, &stat) != 0)
    throw error(name, "is missing", "Save the recording again with all of its channels.");
  if ((stat.valid & ZIP_STAT_ENCRYPTION_METHOD) && stat.encryption_method != ZIP_EM_NONE)
    throw error(name, "is encrypted", "Save the recording without a password.");
  const std::unique_ptr<zip_file, PartCloser> part(zip_fopen(archive_.get(), name.c_str(), 0));
  std::string content;
  for (zip_int64_t got = part ? 1 : -1; got != 0;) {
    const std::size_t before = content.size();
    if (got > 0) {
      content.resize(before + kChunk);
      got = zip_fread(part.get(), content.data() + before, kChunk);
    }
    if (got < 0)
      throw error(name, "is damaged or packed in a way that is not known",
                  "Copy the file again from the instrument.");
    content.resize(before + static_cast<std::size_t>(got));
    if (static_cast<std::uintmax_t>(got) > left_)
      throw Error(path_.string(), fmt::format("holds more than {} MiB", max_bytes_ >> 20),
                  "Cut it into one recording per file, or raise `largest_file` in the manifest.");
    left_ -= static_cast<std::uintmax_t>(got);
  }
  return content;
}

Error ZipFile::error(const std::string& part, const std::string& what,
                     const std::string& remedy) const {
  return Error(path_.string() + "#" + part, what, remedy);
}

}  // namespace palpate::importers
