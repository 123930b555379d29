#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace palpate::tools {

/// A manifest to start from.
struct ProposedManifest {
  std::string text;                   ///< manifest.toml, commented
  std::vector<std::string> notes;     ///< what was found, a sentence each
  std::vector<std::string> warnings;  ///< files that nothing could be made of, and guesses
  std::vector<std::string> unread;    ///< of those files, name and reason alone
  std::size_t files = 0;              ///< that it reads
};

/// Looks at every file of a folder and of those in it and proposes how they are read: format, by
/// their first bytes; else columns and units by the names in their headers, and whose force it is,
/// which way normals point and whether it was a press or a drag by what makes recordings of the
/// first file of each kind that makes any. Keys that all entries have are in [defaults]. Units that
/// no header says are guessed from the numbers, and said. Where a mesh lies in the folder and tools
/// touched one distance off it, positions are proposed as those of a ball's centre with that
/// radius. manifest: where it is going to be; names of files start at its folder. Throws Error
/// where the folder cannot be read or holds no recording.
ProposedManifest propose_manifest(const std::filesystem::path& folder,
                                  const std::filesystem::path& manifest);

}  // namespace palpate::tools
