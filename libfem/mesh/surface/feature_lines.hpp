#pragma once

#include <utility>
#include <vector>

#include "libfem/mesh/surface/half_edge.hpp"

namespace palpate {

/// The sharp edges of a fine surface, as segments to project onto.
struct FeatureLines {
  std::vector<std::pair<Vec3, Vec3>> segments;

  /// Nearest point of any segment; the query itself when there is none.
  Vec3 closest(const Vec3& query) const;
};

/// Marks edges whose triangles turn by more than 60 degrees as features, and their vertices;
/// vertices where a line ends, branches or turns sharply are locked (they stay where they are).
/// Strings of sharp edges shorter than `min_length_m` in all are noise and not marked.
FeatureLines mark_features(HalfEdgeMesh& mesh, double min_length_m);

}  // namespace palpate
