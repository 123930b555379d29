#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libfem/probes/probes.hpp"
#include "libfit/core/body.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/experiments/draw.hpp"
#include "libfit/experiments/follow.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// Refuses tools beside [probe] that the simulator or the engine does not know: balls in a row of
/// no capsule, a probe that is no ball, a tool that is neither balls nor round along its press.
/// Throws Error.
void check_tools(const Scene& scene);

/// A tool as the engine plays it: its balls, or the ball or tip that it ends with. Throws Error
/// where it is no shape.
PlayedTool tool_shape(const Scene& scene, const ToolSection& tool);

/// [tool] and each [[validate.tool]] of a scene, as the engine plays them.
struct NamedTool {
  std::string name;
  PlayedTool tool;
};
std::vector<NamedTool> played_tools(const Scene& scene);

/// The round end of the scene's own probe; nothing of one that is not round along its press, or no
/// shape at all.
std::optional<Indenter> own_end(const Scene& scene);

/// The round end with which the probe of a scene's file meets an asset. Throws Error where it has
/// none, or the asset knows no other than its own.
Indenter meeting_end(const std::string& scene_path, const runtime::AssetView& asset);

/// The scene whose probe is that tool.
Scene with_tool(const Scene& scene, const ToolSection& tool);

/// Paths on which the tool leans and none of its balls leaves what answers.
HeldOut draw_tool_paths(const Scene& scene, const ToolSection& tool, const Body& body, int paths,
                        std::uint64_t seed);

/// How deep a tool is pressed that is not played as balls: as the probe, or as it is known for.
double known_depth_m(const Scene& scene, const ToolSection& tool);

/// tool_shape() of each tool of a scene, found once.
using ToolShapes = std::map<const ToolSection*, PlayedTool>;

/// How the engine plays a row that the tool made; [tool] as the ball that goes deepest.
PlayedTool played_as_tool(const Scene& scene, const ToolSection& tool, ToolShapes& shapes,
                          const Samples& samples, Eigen::Index row);
PlayedTool foremost_played_as(const Scene& scene, const Samples& samples, Eigen::Index row);

}  // namespace palpate::tools
