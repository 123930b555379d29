#pragma once

#include <filesystem>
#include <span>
#include <string_view>

namespace palpate {

/// A file of libfit/runtime, kept inside this library so that an export needs no source tree.
struct EngineFile {
  std::string_view name, text;
};

/// All headers, the licence, the example and the page that explain the engine.
std::span<const EngineFile> engine_files();

/// Writes the engine's files into `folder`, made when missing; other files there stay, and so do
/// those of these names where `folder` holds no engine: Error.
/// Throws Error when the folder or a file cannot be written.
void write_engine_folder(const std::filesystem::path& folder);

}  // namespace palpate
