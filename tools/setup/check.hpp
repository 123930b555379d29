#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/core/geometry.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// Results of a scene's experiments at one test point, the one in the middle of the window.
struct Trial {
  std::string point;
  Vec3 position = Vec3::Zero();
  double force_N = 0;       ///< normal force of the press where its good rows end
  double depth_m = 0;       ///< there
  double half_space_N = 0;  ///< on a half-space of the body's material at that depth
  double sway_m = 0;  ///< of the body as a whole (M33), by the force there in the softest direction
  double held_share = 0;   ///< of the force, lost where only the farther half of what is held is
  double force_error = 0;  ///< largest stated error of the good rows, relative
  std::size_t rows = 0, good = 0, pressed = 0;  ///< pressed: rows of the press
  std::size_t wedged = 0;                       ///< of the press (RowStatus::wedged)
  std::size_t sticking = 0, slipping = 0;       ///< good rows of drags
  int nodes = 0;                                ///< of the mesh that its rows come from
  double cpu_s = 0;                             ///< of this thread
  double quick_s = 0;                           ///< of a press on one mesh, likewise
};

/// Throws Interrupted when the user stopped it.
Trial try_middle_point(const Scene& scene, const Body& body);

/// Points that a run simulates at most: test points or budget, and the held-out ones, each with a
/// path, and twice where the error is split by cause.
int points_of_run(const Scene& scene, const Body& body);

/// CPU seconds of such a run, by the trial. Where points place themselves most are pressed only,
/// and but for the first ones on one mesh, if rings are what the first drags tell. A held-out path
/// costs as much as a point with its drags: 0.8 to 1.0 of it on two livers and a hand.
double cpu_of_run_s(const Scene& scene, const Body& body, const Trial& trial);

/// Advice from the trial about the scene, a sentence each with the key to change; none: it will do.
std::vector<std::string> advice(const Scene& scene, const Trial& trial);

/// The length unit that makes a mesh an organ: its largest extent is then between 3 cm and 1 m, by
/// mm, cm, m or um where one of these does, else by a power of ten.
std::string likely_unit(const Vec3& extent);

/// The doubt, a sentence with the unit that would be likelier, where a mesh measures what few
/// organs do: less than 4 cm or more than 60 cm. extent: in the file's unit, which is unit_m long.
std::optional<std::string> doubt_of_size(const Vec3& extent, double unit_m);

/// The doubt of a lid: a surface that mending had to close over an opening half as wide as the body
/// or more. in_file: as it was read, scaled to m; changes: what mending said of it.
std::optional<std::string> doubt_of_lid(const Surface& in_file,
                                        const std::vector<std::string>& changes);

/// Doubts of a scene's body file: its lid, and a wrap that was not needed.
std::vector<std::string> doubts_of_body(const Scene& scene,
                                        const std::vector<std::string>& changes);

/// Each recording of a manifest, with its faults.
struct CheckedManifest {
  std::string text;             ///< a line each, then what the points are and what is held out
  nlohmann::ordered_json json;  ///< the same, with what `import` tells
  std::size_t refused = 0;
};

/// Reads and places all recordings as `import` does and writes nothing. Refusals and notes are said
/// on stderr. Throws Error on what `import` would refuse as a whole,
/// and where no recording can be used.
CheckedManifest check_manifest(const std::filesystem::path& manifest, int jobs);

}  // namespace palpate::tools
