#pragma once

#include <filesystem>
#include <string>

#include "libfit/core/body.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/runtime/tool/tool.hpp"
#include "libfit/validation/statement.hpp"
#include "tools/scene/scene.hpp"
#include "tools/stages/samples/coupling.hpp"

namespace palpate::tools {

/// Refuses a [tool] that the simulator or the engine does not know: balls in a row of no capsule, a
/// probe that is no ball. Throws Error.
void check_tool(const Scene& scene);

/// [tool] of a scene as the engine plays it. Throws Error where its probe is no shape.
runtime::ToolShape tool_shape(const Scene& scene);

/// Simulates the paths of [tool] into `output`, as simulate_kept_paths().
Samples simulate_tool(const Scene& scene, const Body& body, int jobs,
                      const std::filesystem::path& output, const std::string& fingerprint,
                      bool resume);

/// What those paths say of how the tool's balls feel each other.
CouplingEvidence tool_evidence(const runtime::AssetView& asset, const Scene& scene,
                               const Body& body, const Samples& samples);

/// The held-out paths of [tool] against the asset: as balls that feel each other, as balls by
/// themselves, and as its foremost ball alone. folder: keeps what is simulated; empty: nowhere.
void state_tool(const std::filesystem::path& asset, const Scene& scene, const Body& body, int jobs,
                const std::filesystem::path& folder, bool resume, validation::Statement& statement);

}  // namespace palpate::tools
