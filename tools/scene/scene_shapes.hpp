#pragma once

#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// Calls of_region for each region of a scene and of_probe for each rigid shape beside [probe] that
/// stages after `prepare` need, always in one order.
template <class SomeScene, class OfRegion, class OfProbe>
void visit_shapes(SomeScene& scene, const OfRegion& of_region, const OfProbe& of_probe) {
  for (auto& region : scene.body.fixed) of_region(region);
  for (auto& inclusion : scene.inclusions) of_region(inclusion.region);
  for (auto& bed : scene.beds) of_region(bed.region);
  if (scene.experiments.region)
    if (auto& part = scene.experiments.region->part) of_region(*part);
  if (scene.tool) of_probe(scene.tool->probe);
  for (auto& tool : scene.pressed) of_probe(tool.probe);
}

}  // namespace palpate::tools
