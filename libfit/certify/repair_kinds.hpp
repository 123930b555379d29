#pragma once

// What a repair may change of an asset's numbers (docs/method.md, section 19).

#include <span>
#include <vector>

#include "libfit/assets/asset_edit.hpp"
#include "libfit/certify/facet.hpp"

namespace palpate::certify {

/// A measured vertex of triangles that are not certified.
struct OpenVertex {
  int vertex = 0;
  double ratio = 0;  ///< largest share of their friction that they need; infinite: none is enough
};

/// The triangles about each vertex that have three measured corners and can be touched.
class Fans {
 public:
  explicit Fans(const runtime::AssetView& asset);
  std::span<const int> about(int vertex) const {
    const auto v = static_cast<std::size_t>(vertex);
    return {item_.data() + first_[v], item_.data() + first_[v + 1]};
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<int> item_;
};

/// What a kind of repair reads.
struct RepairPlan {
  const Fans& fans;
  const runtime::AssetView& original;  ///< before any repair
  std::vector<OpenVertex> open;
  FacetOptions facet;  ///< of the probe's radius
};

struct RepairKind {
  const char* name;
  const char* what;  ///< it does, for people
  void (*apply)(AssetEdit& edit, const RepairPlan& plan);
};

void bring_side_force(AssetEdit& edit, const RepairPlan& plan);
void smooth_normals(AssetEdit& edit, const RepairPlan& plan);
void lift_friction(AssetEdit& edit, const RepairPlan& plan);

constexpr RepairKind kRepairKinds[] = {
    {"side", "side forces meet the slope of the stored energy", bring_side_force},
    {"normals", "normals are smoothed", smooth_normals},
    {"friction", "friction is raised", lift_friction},
};

}  // namespace palpate::certify
