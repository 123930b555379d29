#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libfit/core/probe.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/recordings/batch/batch.hpp"
#include "libfit/recordings/batch/registration.hpp"
#include "libfit/recordings/placing/assemble.hpp"
#include "tools/scene/key_log.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// Which points the error statement is of ([validate] of a manifest): every so many-th, or named.
struct HoldOut {
  std::optional<int> every;        ///< 0: none; not said: as whoever reads the manifest has it
  std::vector<std::string> names;  ///< of points; `*` and `?` are allowed
};
inline constexpr int kHeldOutEvery = 5, kHeldOutFrom = 10;  // fewer points are all needed

/// What a manifest.toml says (docs/formats/manifest.md).
struct Manifest {
  std::filesystem::path path;
  std::optional<std::filesystem::path> surface;
  double length_unit_m = 0;  ///< of the surface file
  std::vector<recordings::BatchItem>
      items;  ///< in the order written; a file pattern gives one per file
  std::vector<importers::SaidKey> said_by_default;       ///< in [defaults], of FormatKey
  std::optional<recordings::RigidMotion> motion;         ///< given
  Points rig_landmarks_m{0, 3}, body_landmarks_m{0, 3};  ///< or these
  bool fits_to_surface = false;
  double place_tolerance_m = recordings::AssembleOptions{}.place_tolerance_m;
  recordings::RelaxationUse relaxation = recordings::AssembleOptions{}.relaxation;
  double friction = kDefaultFriction;  ///< of the probe
  HoldOut hold_out;
  FitSection fit;  ///< as in a scene, for `run`
};

/// Whether a TOML file says that it is a manifest: it has recordings, no body. False where it
/// cannot be read or parsed.
bool is_manifest(const std::filesystem::path& path);

/// Which points are held out of the fit, in the order of the samples: one of every so many, each
/// time another one, so that no column of a raster goes as a whole; or those named. Throws Error
/// where a name fits no point, and where fewer than three are left.
/// by_default: one of kHeldOutEvery of kHeldOutFrom points or more where the manifest says nothing;
/// else none.
std::vector<char> held_out_points(const Manifest& manifest, const Samples& samples,
                                  bool by_default);

/// The probes of all recordings, as the manifest or their files say, in the order of the tips; a
/// "point" where nobody knows one.
std::vector<ProbeSpec> probes_of(const Manifest& manifest,
                                 const std::vector<recordings::UsedTip>& tips);

/// Poisson's ratio of the body, which the first recording says.
double poisson_of(const Manifest& manifest);

/// Reads and checks a manifest. Throws Error with file:line:column on unknown keys (naming the
/// nearest known one), wrong types, units or names, and recordings that lack what they need.
/// Recordings' files are not opened here. log: the keys that were asked for.
Manifest read_manifest(const std::filesystem::path& path, KeyLog* log = nullptr);

}  // namespace palpate::tools
