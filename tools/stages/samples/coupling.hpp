#pragma once

#include <functional>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/fit/coupling.hpp"

namespace palpate::tools {

/// Experiments that tell how contacts feel each other: what is left of them by a coupling, and
/// words about what one leaves.
struct CouplingEvidence {
  CouplingResidual residual;
  std::function<void(const runtime::CouplingView&)> report;
};
/// Of an asset made from the model, without coupling.
using MakeEvidence = std::function<CouplingEvidence(const runtime::AssetView&)>;

/// Identifies how contacts feel each other (M62) from all of the evidence, and says how well.
/// scale_m: the shortest scale of the coupling.
void add_coupling(Model& model, const std::vector<MakeEvidence>& evidence, double scale_m);

}  // namespace palpate::tools
