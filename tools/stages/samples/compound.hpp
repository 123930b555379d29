#pragma once

#include <cstdint>

#include "libfit/core/body.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/experiments/draw.hpp"
#include "libfit/experiments/follow.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// Refuses a [tool] that the simulator or the engine does not know: balls in a row of no capsule, a
/// probe that is no ball. Throws Error.
void check_tool(const Scene& scene);

/// [tool] of a scene as the engine plays it. Throws Error where its probe is no shape.
runtime::ToolShape tool_shape(const Scene& scene);

/// The scene whose probe is its [tool].
Scene with_tool(const Scene& scene);

inline constexpr std::uint64_t kToolSeed = 0x746f6f6c;
/// Paths on which the tool leans and none of its balls leaves what answers.
HeldOut draw_tool_paths(const Scene& scene, const Body& body, int paths, std::uint64_t seed);

/// How the engine plays a row that [tool] made: as its balls, or as the one that goes deepest.
PlayedTool tool_played_as(const Scene& scene, const Samples& samples, Eigen::Index row);
PlayedTool foremost_played_as(const Scene& scene, const Samples& samples, Eigen::Index row);

}  // namespace palpate::tools
