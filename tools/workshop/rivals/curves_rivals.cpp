// (d) and (i): curves of the surface's vertices, by the paper's separable law and by Palpate.

#include <fmt/format.h>

#include <memory>
#include <numeric>

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "libfit/refine/refine.hpp"
#include "libfit/runtime/engine.hpp"
#include "tests/support/bodies.hpp"
#include "tools/stages/fit.hpp"
#include "tools/workshop/bench/machine.hpp"
#include "tools/workshop/rivals/rival.hpp"

namespace palpate::tools {
namespace {

constexpr Eigen::Index kPointCounts[] = {12, 20, 40, 135};

// An opened asset and the tool on it.
struct Played {
  BenchAsset asset;
  runtime::Tool tool;
};

Rival played(const std::shared_ptr<Played>& on) {
  Rival rival;
  rival.bytes = on->asset.bytes.size();
  rival.start = [on](const Vec3&) { on->tool = runtime::Tool(); };
  rival.force = [on](const Vec3& tip) -> Vec3 {
    runtime::ToolInput in;
    in.dt_s = runtime::kMaxTimeStep_s;
    Eigen::Map<Vec3>(in.pose.position_m) = tip;
    runtime::ToolOutput out;
    runtime::Tool* const tool = &on->tool;
    runtime::Status status;
    touch_tools(on->asset.asset, &tool, &in, &out, &status, 1);
    return -Eigen::Map<const Vec3>(out.force_on_tool_N);
  };
  return rival;
}

Rival curves_rival(const RivalBody& body, const Samples& samples, const FitSection& fit) {
  const double began_s = cpu_seconds();
  const FittedCurves curves = fit_curves(samples, fit_options(samples, fit, 1));
  const Model model = refine(curves, body.body);
  const auto on = std::make_shared<Played>(Played{make_bench_asset(model), {}});
  Rival rival = played(on);
  rival.preparation_cpu_s = cpu_seconds() - began_s + simulation_cpu_s(body, samples);
  rival.size = static_cast<double>(samples.points());
  rival.settings = fmt::format("{} test points, family {}, degree {}", samples.points(),
                               name_of(curves.curves.family), curves.curves.basis.front().degree);
  return rival;
}

}  // namespace

Samples at_points(const Samples& samples, const std::vector<Eigen::Index>& points) {
  std::vector<std::int32_t> place(samples.points(), -1);
  for (std::size_t i = 0; i < points.size(); ++i) place[points[i]] = static_cast<std::int32_t>(i);
  std::vector<Eigen::Index> rows;
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    if (place[samples.point[row]] >= 0) rows.push_back(row);
  Samples out;
  static_cast<SampleOrigin&>(out) = samples;
  append_points(out, samples, points);
  append_rows(out, samples, rows);
  for (std::int32_t& point : out.point) point = place[point];
  return out;
}

double simulation_cpu_s(const RivalBody& body, const Samples& samples) {
  std::vector<char> is_dragged(samples.points(), 0);
  for (std::size_t row = 0; row < samples.kind.size(); ++row)
    if (samples.kind[row] == ExperimentKind::drag) is_dragged[samples.point[row]] = 1;
  const auto dragged =
      static_cast<double>(std::accumulate(is_dragged.begin(), is_dragged.end(), 0));
  return dragged * body.dragged_cpu_s +
         (static_cast<double>(samples.points()) - dragged) * body.pressed_cpu_s;
}

std::vector<Rival> prepare_separable(const RivalBody& body) {
  FitSection fit = body.scene.fit;
  fit.family = "separable";
  Rival rival = curves_rival(body, body.samples, fit);
  rival.name = "separable law";
  rival.size = 0;
  rival.settings += "; area interpolation alone, as published";
  return {rival};
}

std::vector<Rival> prepare_palpate(const RivalBody& body) {
  std::vector<Rival> out;
  const Eigen::Index all = body.samples.points();
  for (const Eigen::Index wanted : kPointCounts) {
    if (!out.empty() && out.back().size == static_cast<double>(all)) break;
    std::vector<Eigen::Index> points(std::min(wanted, all));
    std::iota(points.begin(), points.end(), Eigen::Index{0});
    out.push_back(curves_rival(body, at_points(body.samples, points), body.scene.fit));
    out.back().name = "Palpate";
  }
  return out;
}

}  // namespace palpate::tools
