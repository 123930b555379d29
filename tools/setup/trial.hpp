#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "libfit/core/body.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// What all of a scene's experiments gave at one test point, the one in the middle of the window.
struct Trial {
  std::string point;
  Vec3 position = Vec3::Zero();
  double force_N = 0;       ///< normal force of the press where its good rows end
  double depth_m = 0;       ///< there
  double half_space_N = 0;  ///< on a half-space of the body's material at that depth
  double sway_m = 0;  ///< of the body as a whole (M33), by the force there in the softest direction
  double force_error = 0;                       ///< largest stated error of the good rows, relative
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

/// What the trial says about the scene, a sentence each with the key to change; none: it will do.
std::vector<std::string> advice(const Scene& scene, const Trial& trial);

}  // namespace palpate::tools
