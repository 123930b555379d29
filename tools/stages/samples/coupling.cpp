#include "tools/stages/samples/coupling.hpp"

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/core/experiments.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/fit/coupling.hpp"
#include "libfit/validation/replay.hpp"
#include "tools/console.hpp"
#include "tools/stages/samples/experiment_table.hpp"

namespace palpate::tools {
namespace {

constexpr double kShortest = 0.5;  // its scale over the ball's radius (M62)

void say_kind(const runtime::AssetView& asset, const runtime::CouplingView& coupling,
              const Scene& scene, const Samples& all, ExperimentKind kind, const char* what) {
  const Samples rows = of_kinds(all, {kind});
  if (rows.rows() == 0) return;
  const auto error = [&](const runtime::AssetView& view) {
    return validation::summarize(
               validation::compare(rows, follow(view, rows, scene.experiments.each.depth_m,
                                                played_as(scene, Purpose::identify, rows))
                                             .force_N))
        .all.force;
  };
  const auto felt = error(coupled_by(asset, coupling)), alone = error(coupled_by(asset, {}));
  say("  {}: forces of {} rows are off by {} (median), {} (p95) if contacts feel each other, {} "
      "and {} if not",
      what, rows.rows(), stated_percent(felt.median_rel), stated_percent(felt.p95_rel),
      stated_percent(alone.median_rel), stated_percent(alone.p95_rel));
}

}  // namespace

void add_coupling(Model& model, const Scene& scene, const Samples& samples) {
  const Samples rows = of_kinds(samples, {ExperimentKind::pair, ExperimentKind::tool});
  if (rows.rows() == 0) return;
  if (model.curves.family != CurveFamily::rings) {
    say("  coupling: the curves are {}, and only rings feel another contact",
        name_of(model.curves.family));
    return;
  }
  const AssetBytes bytes = make_asset_bytes(model, {});
  runtime::Status status;
  const auto asset = runtime::Asset::open(bytes.data(), bytes.size(), &status);
  runtime::CouplingView& coupling = model.curves.coupling;
  coupling = identify_coupling(asset,
                               coupling_residual(asset, rows, scene.experiments.each.depth_m,
                                                 played_as(scene, Purpose::identify, rows)),
                               kShortest * ball_radius_m(scene.probe.spec));
  say_kind(asset, coupling, scene, rows, ExperimentKind::pair, "two tools");
  say_kind(asset, coupling, scene, rows, ExperimentKind::tool, "tool");
  if (!coupling.is_any()) say("  coupling: that is no gain, there is none");
}

}  // namespace palpate::tools
