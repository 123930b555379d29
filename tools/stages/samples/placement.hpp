#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "tools/scene/scene.hpp"
#include "tools/stages/samples/experiment_table.hpp"
#include "tools/stages/samples/sample_cache.hpp"

namespace palpate::tools {

/// One round of a placement: how well the points before it predicted the new ones.
struct PlacementRound {
  int points = 0;                                   ///< that predicted
  int new_points = 0;                               ///< that were predicted, then simulated
  double median_rel = 0, p95_rel = 0, max_rel = 0;  ///< of the force at the new points
  int dragged = 0;                                  ///< points with drags after it
  int poor = 0;  ///< new points that the errors leave out: the fit calls them poor
  int rows = 0;  ///< rows that the errors are of
};

/// How well a model predicted the points that were added to what it was made of: the last ones of
/// samples, `vertices` of the model. fits: of all points, with the new ones; poor ones do not
/// count.
PlacementRound judge_round(const Samples& samples, const Model& model,
                           const std::vector<std::int32_t>& vertices,
                           const std::vector<FitStatus>& fits);

/// Points that a round adds to so many. is_quick: they are pressed on one mesh; is_within: the
/// round before met the tolerance, and this one need only say so again.
int round_size(int points, bool is_quick, bool is_within);

/// What simulates the experiments of a scene for a purpose. output: samples.h5 or reference.h5;
/// empty: nothing is kept.
SimulateRequest request_for(const Scene& scene, const Body& body, Purpose purpose, int jobs,
                            const std::filesystem::path& output, bool resume = true);

/// All experiments of a scene, at the body's points or at points that place themselves and wherever
/// else they are drawn, written to
/// request.output with all that says what they come from; placed.h5, the body that `refine` needs
/// then, and placement.csv beside it where points placed themselves.
/// known: samples that need not be simulated, none: those of earlier runs.
Samples simulate_scene(const Scene& scene, const Body& body, const SimulateRequest& request,
                       std::optional<Samples> known = std::nullopt);

/// Points that are dragged first, and solved on two meshes: those from which the rings of a body
/// and the error of presses on one mesh are known. Four on the phantom miss how rings change above
/// its tumour (p95 back and forth 8.6 % in place of 3).
inline constexpr std::size_t kFirstDrags = 6;

/// Chooses by presses of every first point; numbers of points, ascending. By their force points
/// fall into kFirstDrags groups; of each the one is dragged whose force leans least off the normal,
/// of the last the one of greatest force. The constants of rings go with the force; beside a fold
/// or a ridge a drag tells of it and not of the rings. A point whose press did not come to its end
/// is taken where its group has no other.
std::vector<std::size_t> points_to_drag(const Samples& presses);

/// A last drag costs 2.5 CPU seconds on the phantom and 8 on the dragon: one for so many points,
/// and no more than these.
inline constexpr std::size_t kPointsPerDrag = 30, kLastDrags = 3;

/// Points that are dragged last, numbers of points of presses, the furthest first: upright ones
/// whose force no upright one of `dragged` tells. Twelve first points do not meet a tumour's top.
/// None where all of `dragged` lean.
std::vector<std::size_t> points_beyond_drags(const Samples& presses,
                                             const std::vector<std::size_t>& dragged);

}  // namespace palpate::tools
