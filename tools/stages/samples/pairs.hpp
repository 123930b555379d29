#pragma once

#include <filesystem>
#include <string>

#include "libfit/core/body.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/validation/statement.hpp"
#include "tools/scene/scene.hpp"
#include "tools/stages/samples/coupling.hpp"

namespace palpate::tools {

/// Refuses pairs of two tools of a probe that is no ball: the simulator has no other second tool.
/// Throws Error.
void check_pairs(const Scene& scene);

/// Simulates the pairs of [experiments] into pairs.h5, as simulate_kept_paths().
Samples simulate_pairs(const Scene& scene, const Body& body, int jobs,
                       const std::filesystem::path& output, const std::string& fingerprint,
                       bool resume);

/// What they say of how tools feel each other.
CouplingEvidence pairs_evidence(const runtime::AssetView& asset, const Scene& scene,
                                const Body& body, const Samples& pairs);

/// The held-out pairs of [validate] against the asset, and against each tool by itself. folder:
/// keeps what is simulated; empty: nowhere.
void state_two_tools(const std::filesystem::path& asset, const Scene& scene, const Body& body,
                     int jobs, const std::filesystem::path& folder, bool resume,
                     validation::Statement& statement);

}  // namespace palpate::tools
