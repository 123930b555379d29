#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "libfit/core/surface.hpp"

namespace palpate::fem {

/// The two sides of an edge of a closed mesh: 3 * triangle + k for the side from corner k to the
/// next.
struct EdgePair {
  std::array<std::int32_t, 2> side;
};

/// Every edge of a mesh that check_probe_mesh accepted.
std::vector<EdgePair> edge_pairs(const Triangles& triangles);

/// Refuses a mesh that has no inside. Throws Error at `where`, counting and naming (from 1) the
/// faults: no triangle, a missing vertex, a triangle without area, an edge with one triangle (open)
/// or more than two or two against each other, a vertex where several sheets meet, volume not
/// positive.
void check_probe_mesh(const Surface& surface, const std::string& where);

}  // namespace palpate::fem
