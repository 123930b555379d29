#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace palpate::tools {

/// Kind of a file by its first bytes: "palpate-samples" and the other schemas, "palp",
/// the beginning of JSON without its blanks ("{"files":12,..."), "HDF5" of another program or
/// "damaged HDF5" that nothing can open, the header of a table ("t_s,fx_N,..."), "" for an empty or
/// a missing file.
std::string kind_of_file(const std::filesystem::path& path);

/// Refuses an output that would replace something else: an input of the command, or a file of a
/// kind that the command does not write. kinds: what it may replace, a table by how its header
/// begins; none: nothing. Throws Error.
void check_output(const std::filesystem::path& output, std::span<const std::string_view> kinds,
                  std::span<const std::string> inputs);

/// A file that a command writes under a name that it chooses itself: in a folder ("asset.palp"), or
/// beside an output (".surface.h5" in the place of its extension, "../placed.h5"); and how one that
/// it may replace begins (kind_of_file).
struct NamedOutput {
  std::string_view name, kind;
};

/// Refuses to replace files of these names that Palpate did not write. target: an output, or the
/// folder of the files. can_force: the command has --force. Throws Error.
void check_named_outputs(const std::filesystem::path& target, std::span<const NamedOutput> files,
                         bool can_force);

/// Refuses "-": a command writes whole files and no stream, and would make one of that name. Throws
/// Error.
void refuse_stdout(const std::string& output);

/// Keeps a second writer from a file until this object or the program ends, however it ends: the
/// lock is the system's, on `OUTPUT.lock`, and a file of that name that a killed program left locks
/// nothing. Throws Error when another program writes the file, or its folder cannot be written.
class OutputLock {
 public:
  explicit OutputLock(const std::filesystem::path& output);
  ~OutputLock();
  OutputLock(const OutputLock&) = delete;
  OutputLock& operator=(const OutputLock&) = delete;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

/// The folder of a run. The constructor refuses (Error) what can be no such folder, and writes
/// nothing. `claim` makes the folder and keeps a second run out of it until this object or the
/// program ends.
class OutputFolder {
 public:
  explicit OutputFolder(std::filesystem::path path);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Throws Error when the folder cannot be made or another run has it.
  void claim();

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace palpate::tools
