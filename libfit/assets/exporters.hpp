#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/curves.hpp"

namespace palpate {

/// Options of an export.
struct ExportOptions {
  bool fades_borders = true;  ///< forces fade out over the last ring before an open border
  /// Surface without test points answers with the mean curves of the covered vertices and says so
  /// (PALPATE_FLAG_OUTSIDE), so that no hole is noticed; false: with nothing.
  bool has_mean_elsewhere = false;
  std::string meta_json = "{}";           ///< for people: error statement, scene hash
  std::filesystem::path engine_dir = {};  ///< where the engine's folder goes; empty: not copied
  double max_step_m = 0;   ///< a tip moving farther in a tick has teleported; 0: 50 mm, or two
                           ///< diagonals of a smaller body
  std::uint64_t seed = 1;  ///< of the check path
};

/// Report of an export; remarks are sentences for people.
struct ExportReport {
  std::uint64_t bytes = 0;
  int vertices = 0, triangles = 0;
  int mean_vertices = 0, faded_vertices = 0, folded_triangles = 0;
  std::vector<std::string> remarks;
};

/// Throws Error where the arrays of a model differ in size.
void check_sizes(const Model& model);

/// Writes a model as an asset, and the engine beside it where that is asked for; never leaves half
/// a file. Throws Error on a bad model, or when the file cannot be written.
ExportReport export_palp(const Model& model, const std::filesystem::path& path,
                         const ExportOptions& options);

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
