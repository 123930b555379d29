#include "libfit/recordings/formats/importers.hpp"

#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <mutex>

#include "libfit/core/text.hpp"

namespace palpate::importers {
namespace fs = std::filesystem;

namespace {

constexpr std::array kImporters{
    Importer{"matlab", begins_matlab, read_matlab},
    Importer{"hdf5", begins_hdf5, read_columns_hdf5},
    Importer{"robot-palpation", nullptr, read_robot_palpation},
    Importer{"csv", begins_named_columns, read_columns_csv},
};

constexpr std::string_view kNamedTables = "csv hdf5 matlab", kDelimited = "csv robot-palpation",
                           kRobot = "robot-palpation",
                           kByItself = "Leave it out: a file of this format says it itself.",
                           kOfRobots = "Leave it out: it is of the format robot-palpation.",
                           kOfText = "Leave it out: it is of delimited text.";

constexpr std::array kKeys{
    FormatKey{"columns.depth", kNamedTables, "Name columns.position."},
    FormatKey{"columns.force_time", kNamedTables, kByItself},
    FormatKey{"columns.contact", kRobot, kOfRobots},
    FormatKey{"columns.normal", kRobot, kOfRobots},
    FormatKey{"normals", kRobot, "Leave it out, and turn `normal` around where it is outward."},
    FormatKey{"separator", kDelimited, kOfText},
    FormatKey{"decimal", kDelimited, kOfText},
    FormatKey{"comment", kDelimited, kOfText},
    FormatKey{"encoding", kDelimited, kOfText},
};

/// A kind of file that other programs write as a table.
struct ForeignFile {
  std::string_view begins, contains;  ///< its first bytes; what stands within its first megabyte
  const char *is, *remedy;
};
constexpr const char* kByAfmformats =
    "Convert it with the Python package afmformats, which writes tables, and name their columns "
    "in the manifest (docs/measured-data.md).";
constexpr const char* kBySheet = "Save the sheet as CSV.";
constexpr const char* kByNumpy =
    "Save it as text, here of an archive a: numpy.savetxt(\"a.csv\", "
    "numpy.column_stack(list(a.values())), delimiter=\",\", header=\",\".join(a), "
    "comments=\"\").";
constexpr ForeignFile kForeignFiles[] = {
    {"PK\3\4", "segments/", "is a force curve of JPK", kByAfmformats},
    {"PK\3\4", "xl/", "is a spreadsheet", kBySheet},
    {"PK\3\4", "opendocument", "is a spreadsheet", kBySheet},
    {"PK\3\4", ".npy", "is an archive of NumPy arrays", kByNumpy},
    {"PK\3\4", "", "is a zip file", "Unpack it, and name the recordings in it."},
    {"\x93NUMPY", "", "is an array of NumPy", kByNumpy},
    {"\\*F", "", "is a force curve of NanoScope", kByAfmformats},
    {{"\5\0", 2}, "", "is an Igor binary wave", kByAfmformats},
    {{"\0\5", 2}, "", "is an Igor binary wave", kByAfmformats},
    {"TDSm", "", "is a TDMS file of LabVIEW",
     "Convert it with the Python package npTDMS, whose as_dataframe().to_csv() writes a table."},
};

// The format of a file that the manifest leaves open. Columns named in the manifest mean a table.
const Importer& recognise(const fs::path& path, std::string_view bytes,
                          const ReadSettings& settings) {
  const std::string_view head = bytes.substr(0, 4096);
  const std::string_view searched = bytes.substr(0, 1 << 20);
  for (const ForeignFile& file : kForeignFiles)
    if (bytes.starts_with(file.begins) && searched.find(file.contains) != std::string_view::npos)
      throw Error(path.string(), std::string(file.is) + ", which is not read", file.remedy);
  const bool is_binary = begins_hdf5(head) || begins_matlab(head);
  if (settings.columns.has_signal() && !is_binary) return *importer_named("csv");
  for (const Importer& row : kImporters)
    if (row.begins && row.begins(head)) return row;
  const TextFile check(path, bytes, "latin-1");  // empty and binary files say so themselves
  throw Error(
      path.string() + ":1", "is in no format that is known by its beginning",
      "Name its columns in the manifest: columns = { time = ..., depth = ..., force = ... }, or in "
      "its header with their units: t_s, x_mm, F_N.");
}

Error too_large(const fs::path& path, std::uintmax_t most) {
  return Error(path.string(), fmt::format("holds more than {} MiB", most >> 20),
               "Cut it into one recording per file, or raise `largest_file` in the manifest.");
}

}  // namespace

std::span<const Importer> importers() { return kImporters; }

std::span<const FormatKey> format_keys() { return kKeys; }

const FormatKey* format_key(std::string_view name) {
  const auto row = std::ranges::find(kKeys, name, &FormatKey::name);
  return row == kKeys.end() ? nullptr : &*row;
}

const Importer* importer_named(std::string_view name) {
  const auto row = std::ranges::find(kImporters, name, &Importer::name);
  return row == kImporters.end() ? nullptr : &*row;
}

void rehearse(const fs::path& path, const std::function<void()>& read) {
  // HDF5 1.10 reads freed memory, follows null pointers or loops on some damaged files
  // (tests/fuzz/README.md), and a process that does so cannot say what it was reading.
  const pid_t child = ::fork();
  if (child == 0) {
    const rlimit seconds{60, 60}, no_core{0, 0};  // files of 100 MiB take a second
    ::setrlimit(RLIMIT_CPU, &seconds);
    ::setrlimit(RLIMIT_CORE, &no_core);
    for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL}) ::signal(signal, SIG_DFL);
    try {
      read();
    } catch (...) {  // the parent meets the same and says it
    }
    ::_exit(0);
  }
  int status = 0;
  pid_t ended = child;
  while (child > 0 && (ended = ::waitpid(child, &status, 0)) < 0 && errno == EINTR) {
  }
  if (ended < 0)
    throw Error(path.string(), std::string("cannot be tried in a process: ") + std::strerror(errno),
                "Free some memory or processes.");
  if (status == 0) return;
  const bool is_slow =
      WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL);
  throw Error(path.string(),
              is_slow ? "is damaged: the HDF5 library does not come to an end on it"
                      : "is damaged: the HDF5 library crashes on it",
              "Save it again from its source, or copy what is left of it with h5repack.");
}

std::string inflated(const fs::path& path, std::string_view packed, std::uintmax_t most,
                     const std::string& is_damaged) {
  const Error damaged(path.string(), is_damaged, "Pack or save it again from its source.");
  z_stream stream{};
  if (inflateInit2(&stream, 32 + MAX_WBITS) != Z_OK) throw damaged;
  struct End {
    z_stream& stream;
    ~End() { inflateEnd(&stream); }
  } end{stream};
  constexpr std::size_t kChunk = 1 << 20;
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

std::vector<RawRecording> read_recordings(const fs::path& path, std::string_view bytes,
                                          const ReadSettings& given) {
  ReadSettings settings = given;
  std::string text;
  if (is_utf16(bytes)) {
    text = utf8_of(path, bytes);
    bytes = text, settings.encoding = "utf-8";
  }
  const Importer* row = settings.format == "auto" ? &recognise(path, bytes, settings)
                                                  : importer_named(settings.format);
  if (!row)
    throw Error(path.string(), "format \"" + settings.format + "\" is not known",
                "Leave it out, or name one that is.");
  for (const SaidKey& said : settings.said)
    if (const FormatKey* key = format_key(said.name); key && !has_word(key->formats, row->name))
      throw Error(said.where,
                  fmt::format("`{}` does nothing for {}, which is read as {}", said.name,
                              path.string(), row->name),
                  std::string(key->remedy));
  // The library keeps global state: one file at a time, and none is open where the process forks.
  static std::mutex library;
  std::unique_lock lock(library, std::defer_lock);
  if (begins_hdf5(bytes) || bytes.starts_with("MATLAB 7.3")) {
    lock.lock();
    rehearse(path, [&] { row->read(path, bytes, settings); });
  }
  auto recordings = row->read(path, bytes, settings);
  for (RawRecording& r : recordings) {
    r.format = row->name;
    if (!r.unread && ((r.travel_m.empty() && r.position_m.rows() == 0) ||
                      (r.push_N.empty() && r.force_N.rows() == 0)))
      throw Error(path.string(), "names neither one axis nor three of position and force",
                  "Name depth or three positions, and one force or three, under `columns`.");
    if (r.contact_m) r.taken.push_back("position " + coordinates(*r.contact_m));
  }
  return recordings;
}

}  // namespace palpate::importers
