// Any bytes as a recording of the one format that PALPATE_FUZZ_FORMAT names, HDF5's too, or as a
// manifest: refused with place and remedy, or finite. Of an input the first byte is passed over and
// the second and fourth say how it is read, as in fuzz_recordings.cpp; nothing is conditioned.

#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <string>

#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "tests/fuzz/promises.hpp"
#include "tests/fuzz/read_settings.hpp"
#include "tests/fuzz/recording_seeds.hpp"
#include "tools/manifest/manifest.hpp"

// HDF5 1.10 leaks a little of its own whenever it gives up on a damaged file.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace {

using namespace palpate;
using palpate::fuzz::promise;
namespace fs = std::filesystem;

// The file that a library insists on, in memory, with these bytes.
fs::path written(std::string_view bytes) {
  static const struct MemoryFile {
    fs::path path = "/dev/shm/palpate-fuzz-" + std::to_string(getpid());
    ~MemoryFile() { fs::remove(path); }
  } file;
  std::FILE* out = std::fopen(file.path.c_str(), "wb");
  promise(out && std::fwrite(bytes.data(), 1, bytes.size(), out) == bytes.size(), "there is room");
  std::fclose(out);
  return file.path;
}

void promise_finite(const std::vector<double>& values) {
  fuzz::promise_finite(values.data(), static_cast<int>(values.size()), "readings are finite");
}

void read_recording(const std::string& format, const unsigned char* data, std::size_t size) {
  if (size < 4) return;
  const std::string bytes(reinterpret_cast<const char*>(data) + 4, size - 4);
  auto read = fuzz::read_settings(format, data[1], data[3]);
  const bool needs_file = format.ends_with("hdf5") || bytes.starts_with("MATLAB 7.3");
  // What HDF5 reads is read here, without the rehearsal, so that its crashes are seen.
  for (const auto& raw : needs_file
                             ? importers::importer_named(format)->read(written(bytes), bytes, read)
                             : importers::read_recordings("fuzz", bytes, read)) {
    if (raw.unread) continue;
    promise(raw.rows() > 0, "a recording has a row");
    promise_finite(raw.time_s), promise_finite(raw.travel_m), promise_finite(raw.push_N);
    promise(raw.position_m.allFinite() && raw.force_N.allFinite(), "readings are finite");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  static const char* const name = std::getenv("PALPATE_FUZZ_FORMAT");
  promise(name != nullptr, "PALPATE_FUZZ_FORMAT names a format, or is manifest");
  try {
    if (name == std::string_view("manifest"))
      tools::read_manifest(written({reinterpret_cast<const char*>(data), size}));
    else
      read_recording(name, data, size);
  } catch (const Error& error) {
    promise(!error.where().empty() && !error.remedy().empty(), "an error has place and remedy");
  }
  return 0;
}
