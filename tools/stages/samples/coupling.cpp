#include "tools/stages/samples/coupling.hpp"

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/runtime/engine.hpp"
#include "tools/console.hpp"

namespace palpate::tools {

void add_coupling(Model& model, const std::vector<MakeEvidence>& evidence, double scale_m) {
  if (model.curves.family != CurveFamily::rings) {
    say("  coupling: the curves are {}, and only rings feel another contact",
        name_of(model.curves.family));
    return;
  }
  const AssetBytes bytes = make_asset_bytes(model, {});
  runtime::Status status;
  const auto asset = runtime::Asset::open(bytes.data(), bytes.size(), &status);
  std::vector<CouplingEvidence> all;
  for (const MakeEvidence& make : evidence) all.push_back(make(asset));
  const auto residual = [&](const runtime::CouplingView& coupling) {
    Eigen::VectorXd out;
    for (const CouplingEvidence& one : all) {
      const Eigen::VectorXd own = one.residual(coupling);
      out.conservativeResize(out.size() + own.size());
      out.tail(own.size()) = own;
    }
    return out;
  };
  double scaled = 1;
  model.curves.coupling = identify_coupling(asset, residual, scale_m, &scaled);
  for (const CouplingEvidence& one : all) one.report(model.curves.coupling);
  if (!model.curves.coupling.is_any()) say("  coupling: that is no gain, there is none");
  if (scaled < 1)
    say("  coupling was made smaller by {:.2g}, to stay below what contacts give", scaled);
}

}  // namespace palpate::tools
