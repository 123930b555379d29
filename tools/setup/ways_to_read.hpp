#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libfit/recordings/batch/batch.hpp"

namespace palpate::tools {

/// A way to read a file, and the words of the manifest for it.
struct FileWay {
  importers::ReadSettings read;
  ExperimentKind kind = ExperimentKind::press;
  std::vector<std::string> lines;    ///< of the manifest
  std::vector<std::string> guesses;  ///< what no header says, a phrase each
};

/// The first line that is no comment, split; empty of files that are no text.
std::vector<std::string> header_of(const std::filesystem::path& path, const std::string& bytes);

/// Every way in which a file may be meant, the likeliest first: by its first bytes; columns by
/// their names; units, where no header says them; whose force it is; which way normals point.
std::vector<FileWay> ways_of(const std::filesystem::path& path, const std::string& bytes);

struct TriedWay {
  FileWay way;
  recordings::ItemResult result;
};

/// The way that makes most recordings of a file; of equals the first.
TriedWay best_way(const std::filesystem::path& path, std::vector<FileWay> ways);

}  // namespace palpate::tools
