#include "tools/stages/shape.hpp"

#include <algorithm>
#include <cmath>

#include "libfem/probes/probes.hpp"
#include "libfit/assets/asset_bytes.hpp"
#include "libfit/shape/identify_shape.hpp"
#include "tools/console.hpp"

namespace palpate::tools {
namespace {

// How the contact radius of a probe goes with the depth, to the nearest power (M30).
ShapeOptions options_for(const fem::Probe& probe, double depth_m) {
  ShapeOptions options;
  options.depth_m = depth_m;
  options.radius_m = probe.contact_radius_m(depth_m);
  const double quarter_m = probe.contact_radius_m(depth_m / 4);
  options.radius_power =
      std::clamp(static_cast<int>(std::lround(std::log2(options.radius_m / quarter_m))), 0, 2);
  return options;
}

}  // namespace

void add_shape(Model& model, const Samples& samples) {
  if (!samples.probe || samples.surface.rows() == 0 ||
      samples.surface.cols() != 3 * model.surface.vertices.rows())
    return;
  double depth_m = 0;
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    depth_m = std::max(depth_m, samples.deflection.row(row).dot(samples.point_normal.row(
                                    samples.point[static_cast<std::size_t>(row)])));
  if (!(depth_m > 0)) return;
  const double from_s = wall_seconds();
  const AssetBytes bytes = make_asset_bytes(model, {});
  runtime::Status status;
  const auto asset = runtime::Asset::open(bytes.data(), bytes.size(), &status);
  ShapeReport report;
  model.shape =
      identify_shape(asset, samples, model.blend_point, model.blend_weight,
                     options_for(fem::make_probe(*samples.probe, "[probe]"), depth_m), &report);
  if (model.shape.point.rows() == 0) return;
  say("  shape: {} fields of the whole body beside the dent, from {} rows ({:.1f} s); points left "
      "out are shown to within (p95, % of the depth, within three contact radii | everywhere)",
      model.shape.modes, report.rows, wall_seconds() - from_s);
  for (const ShapeReport::Count& count : report.tried)
    say("  shape: {:>2} fields {:.2f} | {:.2f}", count.modes, 100 * count.near_p95,
        100 * count.all_p95);
}

}  // namespace palpate::tools
