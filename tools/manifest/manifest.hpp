#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libfit/core/probe.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/recordings/placing/assemble.hpp"
#include "tools/scene/key_log.hpp"
#include "tools/scene/scene.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {

/// Which points the error statement is of ([validate] of a manifest): every so many-th, or named.
struct HoldOut {
  std::optional<int> every;        ///< 0: none; not said: as whoever reads the manifest has it
  std::vector<std::string> names;  ///< of points; `*` and `?` are allowed
};

/// Contents of a manifest.toml (docs/formats/manifest.md).
struct Manifest {
  std::filesystem::path path;
  std::optional<std::filesystem::path> surface;
  double length_unit_m = 0;                  ///< of the surface file
  std::vector<recordings::BatchItem> items;  ///< as written; a file pattern makes one per file
  std::vector<importers::SaidKey> said_by_default;       ///< in [defaults], of FormatKey
  recordings::BatchOptions options;                      ///< without surface
  Points rig_landmarks_m{0, 3}, body_landmarks_m{0, 3};  ///< where they stand for the motion
  double friction = kDefaultFriction;                    ///< of the probe
  HoldOut hold_out;
  FitSection fit;  ///< as in a scene, for `run`
};

/// True if a TOML file says that it is a manifest: it has recordings, no body. False where it
/// cannot be read or parsed.
bool is_manifest(const std::filesystem::path& path);

/// Which points are held out of the fit, in the order of the samples: one of every so many, each
/// time another one, so that no column of a raster goes as a whole; or those named. Throws Error
/// where a name fits no point, and where fewer than three are left.
/// by_default: one of 5 of 10 points or more where the manifest says nothing; else none.
std::vector<char> held_out_points(const Manifest& manifest, const Samples& samples,
                                  bool by_default);

/// The probes of all recordings, as the manifest or their files say, in the order of the tips; a
/// "point" where nobody knows one.
std::vector<ProbeSpec> probes_of(const Manifest& manifest,
                                 const std::vector<recordings::UsedTip>& tips);

/// Has all recordings read as passes beside a scan.
void read_as_passes(Manifest& manifest);

/// Reads and checks a manifest. Throws Error with file:line:column on unknown keys (naming the
/// nearest known one), wrong types, units or names, and recordings that lack what they need.
/// Recordings' files are not opened here. log: the keys that were asked for.
Manifest read_manifest(const std::filesystem::path& path, KeyLog* log = nullptr);

// Parts of read_manifest.

/// A recording's entry on its way: what [defaults] said, then what the entry says.
struct ManifestEntry {
  recordings::BatchItem item;
  std::string file;
  std::optional<std::vector<double>> position;  // in units.position
  std::optional<double> friction;               // of the probe on the body
};

/// Throws Error at a key of the manifest.
[[noreturn]] void fail(const SceneTable& table, std::string_view key, const std::string& what,
                       const std::string& remedy);

/// A column by its name, or "#3" by its number in a file without header. Throws Error where the
/// node is neither.
std::string column(const SceneTable& table, std::string_view key, const toml::node* node);

inline constexpr double kAnyNumber = 1e15;  // in whatever unit a rig's files have

/// The keys of [defaults] and of [[recording]] alike.
void read_keys(SceneTable& table, ManifestEntry& entry);

}  // namespace palpate::tools
