#pragma once

#include <filesystem>

#include "libfit/core/body.hpp"
#include "tools/scene.hpp"
#include "tools/statement.hpp"

namespace palpate::tools {

struct ValidateRequest {
  int points = 12;
  int seed = 1;
  int jobs = 0;
  std::filesystem::path rows_csv;  ///< every compared row; empty for none
};

/// Fresh experiments against the engine, loaded from the asset's bytes: contact points uniform by
/// area over what the asset covers, at each one a seeded path (straight press, oblique press, or
/// press and drag) that no fit saw. The engine follows the same tip at 20 um a tick from outside.
Statement validate_asset(const std::filesystem::path& asset, const Scene& scene, const Body& body,
                         const ValidateRequest& request);

}  // namespace palpate::tools
