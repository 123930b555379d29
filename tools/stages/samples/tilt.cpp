#include "tools/stages/samples/tilt.hpp"

#include <fmt/core.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "libfem/solve/experiments/simulate.hpp"
#include "libfit/core/error.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "libfit/io/content_hash.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/refine/refine.hpp"
#include "tools/build_identity.hpp"
#include "tools/console.hpp"
#include "tools/scene/settings.hpp"
#include "tools/stages/export.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/fit.hpp"
#include "tools/stages/samples/kept_paths.hpp"
#include "tools/stages/samples/simulate.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;

fs::path samples_path(const fs::path& folder) { return folder / "samples.tilts.h5"; }

Lean lean_at(const runtime::TiltNodes& nodes, int node) {
  const runtime::TiltLean lean = nodes.lean(node);
  return {lean.first, lean.second};
}

// All points once for each node but the upright one, node by node.
TestPoints at_leans(const TestPoints& points, int leans) {
  TestPoints out;
  out.triangles.resize(0, 3);
  out.position = points.position.replicate(leans, 1);
  out.normal = points.normal.replicate(leans, 1);
  for (int lean = 1; lean <= leans; ++lean)
    for (const std::string& name : points.name)
      out.name.push_back(fmt::format("{}/{}", name, lean));
  return out;
}

std::vector<ToolPath> leaning_presses(const TestPoints& points, const runtime::TiltNodes& nodes,
                                      const Experiments& each) {
  std::vector<ToolPath> paths;
  const auto count = static_cast<int>(points.position.rows());
  for (int node = 1; node < nodes.size(); ++node)
    for (int p = 0; p < count; ++p) {
      ToolPath path{(node - 1) * count + p, Points(each.press_steps, 3), {}, lean_at(nodes, node)};
      for (int step = 1; step <= each.press_steps; ++step)
        path.deflections.row(step - 1) =
            each.depth_m * step / each.press_steps * points.normal.row(p);
      paths.push_back(std::move(path));
    }
  return paths;
}

Samples simulate_tilts(const Scene& scene, const Body& body, const TiltRequest& request,
                       const std::string& fingerprint) {
  const runtime::TiltNodes nodes = tilt_nodes(scene);
  return simulate_kept_paths(fem::Simulator(make_setup(scene, body)),
                             at_leans(body.test_points, nodes.size() - 1),
                             leaning_presses(body.test_points, nodes, scene.experiments.each),
                             {.what = "tilt",
                              .jobs = request.jobs,
                              .output = samples_path(request.folder),
                              .fingerprint = fingerprint,
                              .resume = request.resume});
}

// Curves of every point at every node, node by node, on the knots of the upright tool's. Friction
// and the lateral ratio are the upright tool's, whose drags tell them.
FittedCurves fit_nodes(const Samples& upright, Samples tilted, const FittedCurves& known,
                       const Scene& scene, int jobs) {
  const Experiments each = experiments_of(scene);
  const int per_point = 1 + static_cast<int>(each.drag_depths_m.size()) * each.drag_directions;
  for (std::size_t row = 0; row < tilted.point.size(); ++row) {
    tilted.kind[row] = ExperimentKind::press;
    tilted.experiment[row] = per_point * tilted.point[row];
  }
  tilted.lean.resize(0, 2);
  Samples all = joined(upright, tilted, per_point);
  // The end is what touches: curves answer to its ball.
  all.probe = sphere_spec(end_radius_m(scene), scene.probe.spec.friction);
  all.poisson = upright.poisson;
  FitOptions options = fit_options(all, scene.fit, jobs);
  options.family = known.curves.family;
  options.degree = known.curves.basis[0].degree;
  options.knots_m[0] = known.curves.basis[0].knots_m;
  options.smoothing = 0;
  FittedCurves out = fit_curves(all, options);
  out.probe = all.probe;
  const Eigen::Index points = upright.points();
  for (const int part :
       {runtime::kLambda, runtime::kFriction, runtime::kFrictionSlope, runtime::kSway}) {
    Controls& control = out.curves.control[static_cast<std::size_t>(part)];
    const Controls first = control.topRows(points);
    for (Eigen::Index from = points; from < control.rows(); from += points)
      control.middleRows(from, points) = first;
  }
  return out;
}

// The control curves of (M59), node by node; where they are none of the family (a normal curve that
// falls), the nearest that is. cut: how far values were moved, over the curve's largest.
void solve_controls(const runtime::TiltNodes& nodes, Eigen::Index points, CurveSet& curves,
                    double& cut) {
  Eigen::MatrixXd weights(nodes.size(), nodes.size());
  for (int i = 0; i < nodes.size(); ++i) {
    const runtime::TiltWeights row = runtime::tilt_weights(nodes, nodes.lean(i));
    for (int j = 0; j < nodes.size(); ++j) weights(i, j) = row.w[j];
  }
  const Eigen::PartialPivLU<Eigen::MatrixXd> inverse(weights);
  for (const int part : {0, runtime::kSide2, runtime::kSide3}) {
    Controls& control = curves.control[static_cast<std::size_t>(part)];
    for (Eigen::Index p = 0; p < points; ++p) {
      Eigen::MatrixXd rows(nodes.size(), control.cols());
      for (int i = 0; i < nodes.size(); ++i) rows.row(i) = control.row(i * points + p);
      rows = inverse.solve(rows).eval();
      for (Eigen::Index j = 1; part == 0 && j < rows.cols(); ++j)
        for (int i = 0; i < nodes.size(); ++i) {
          const double least = rows(i, j - 1);
          if (rows(i, j) >= least) continue;
          cut = std::max(cut, (least - rows(i, j)) / rows.maxCoeff());
          rows(i, j) = least;
        }
      if (part == 0) rows.col(0).setZero();
      for (int i = 0; i < nodes.size(); ++i)
        control.row(i * points + p) = rows.row(i).cast<float>().cast<double>();
    }
  }
}

FittedCurves node_of(const FittedCurves& all, const FittedCurves& known, int node, int nodes) {
  FittedCurves out = known;
  out.probe = all.probe;
  const Eigen::Index points = known.position.rows();
  for (std::size_t part = 0; part < all.curves.control.size(); ++part)
    out.curves.control[part] = all.curves.control[part].middleRows(node * points, points);
  out.curves.basis = all.curves.basis;
  for (Controls& covariance : out.covariance) covariance.resize(points, 0);
  for (Controls& deviation : out.deviation) deviation.resize(points, 0);
  for (Eigen::Index p = 0; p < points; ++p)
    for (int i = 0; i < nodes; ++i)  // all nodes of a point answer or none
      if (all.status[static_cast<std::size_t>(i * points + p)] == FitStatus::failed)
        out.status[static_cast<std::size_t>(p)] = FitStatus::failed;
  return out;
}

}  // namespace

double end_radius_m(const Scene& scene) {
  return fem::round_end_m(fem::make_probe(scene.probe.spec, "[probe]"));
}

runtime::TiltNodes tilt_nodes(const Scene& scene) {
  runtime::TiltNodes nodes;
  for (const double tilt : scene.experiments.tilts_rad) nodes.sine[++nodes.tilts] = std::sin(tilt);
  return nodes;
}

void check_tilts(const Scene& scene) {
  if (scene.experiments.tilts_rad.empty()) return;
  const std::string where = scene.path.string() + ": tilts of [experiments]";
  if (!(end_radius_m(scene) > 0))
    throw Error(where,
                fmt::format("this {} is not round about its axis, or does not end with a ball",
                            scene.probe.spec.shape),
                "Take a capsule that presses with its end, a cone, a sphere or a flat whose "
                "edge_radius is its radius; or leave tilts out.");
  const fem::Probe probe = fem::make_probe(scene.probe.spec, "[probe]");
  fem::tilted(probe, -Vec3::UnitZ(), lean_of(scene.experiments.tilts_rad.back(), 0), where);
}

std::string tilt_fingerprint(const Scene& scene, const fs::path& folder) {
  ContentHash hash;
  hash.add("tilts").add(build_identity()).add(canonical(scene, Stage::tilt));
  hash.add(canonical(scene, Stage::export_));
  return hash.add_file(folder / "samples.h5").add_file(folder / "curves.h5").hex();
}

void make_turning_asset(const Scene& scene, const Body& body, const TiltRequest& request) {
  const fs::path& folder = request.folder;
  const FittedCurves known = read_curves(folder / "curves.h5");
  if (known.curves.family != CurveFamily::rings)
    throw Error(scene.path.string() + ": tilts of [experiments]",
                fmt::format("the curves are {}, and only rings know a tool that turns",
                            name_of(known.curves.family)),
                "Write family = \"rings\" in [fit], or leave tilts out.");
  const std::string fingerprint = tilt_fingerprint(scene, folder);
  const runtime::TiltNodes nodes = tilt_nodes(scene);
  const Samples upright = read_samples(folder / "samples.h5");
  const Samples tilted = simulate_tilts(scene, body, request, fingerprint);
  FittedCurves all = fit_nodes(upright, tilted, known, scene, request.jobs);
  RefineOptions options;
  RefineReport report;
  Model model = refine(node_of(all, known, 0, nodes.size()), body, options, &report);
  options.slope_share = report.interpolation.slope_share;  // alike at all nodes
  options.follows_shape = report.interpolation.follows_shape;
  model.probe = all.probe;
  double cut = 0;
  solve_controls(nodes, upright.points(), all.curves, cut);
  if (cut > 0)
    say("  control values of curves over the lean were kept rising by up to {:.2g} %", 100 * cut);
  LeanCurves leans;
  leans.sine.assign(nodes.sine + 1, nodes.sine + 1 + nodes.tilts);
  for (int node = 0; node < nodes.size(); ++node) {
    Model at = refine(node_of(all, known, node, nodes.size()), body, options);
    leans.node.push_back({std::move(at.curves.control[0]),
                          std::move(at.curves.control[runtime::kSide2]),
                          std::move(at.curves.control[runtime::kSide3])});
  }
  ExportSection settings = scene.export_;
  settings.repair = ExportSection().repair;  // it knows the upright tool alone
  export_model(model, folder / kTurningAsset, "palp",
               {.settings = settings,
                .fingerprint = fingerprint,
                .jobs = request.jobs,
                .engine = {},
                .leans = std::move(leans)});
}

}  // namespace palpate::tools
