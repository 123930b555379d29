#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/manifest/manifest.hpp"
#include "tools/scene/toml_table.hpp"

// The parts of a manifest.toml, each read and checked; read_manifest puts them together.

namespace palpate::tools {

/// A recording's entry on its way: what [defaults] said, then what the entry says.
struct ManifestEntry {
  recordings::BatchItem item;
  std::string file;
  std::optional<std::vector<double>> position;  // in units.position
  std::optional<bool> is_force_on_tool;
  std::optional<double> friction;  // of the probe on the body
};

/// Throws Error at a key of the manifest.
[[noreturn]] void fail(const SceneTable& table, std::string_view key, const std::string& what,
                       const std::string& remedy);

inline constexpr double kAnyNumber = 1e15;  // in whatever unit a rig's files have

/// The keys of [defaults] and of [[recording]] alike.
void read_keys(SceneTable& table, ManifestEntry& entry);

/// Checks what an entry must say by the time all of it is known, and turns its position into m.
void complete(const SceneTable& table, ManifestEntry& entry);

/// The files of an entry: itself, or those that its pattern in the last component matches, sorted.
/// A summary that an import left there is none of them.
std::vector<std::string> files_of(const SceneTable& table, const std::string& file,
                                  const std::filesystem::path& folder);

}  // namespace palpate::tools
