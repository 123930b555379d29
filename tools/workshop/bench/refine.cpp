#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "libfit/core/geometry.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/refine/refine.hpp"
#include "tests/support/bodies.hpp"
#include "tools/console.hpp"
#include "tools/workshop/bench/bench.hpp"
#include "tools/workshop/bench/machine.hpp"

namespace palpate::tools {
namespace {

struct SurfaceSize {
  int around, along;
};
constexpr SurfaceSize kSizes[] = {{100, 99}, {316, 315}, {1000, 999}};  // 10^4, 10^5, 10^6 vertices
constexpr SurfaceSize kPoints = {32, 30};                               // 992 test points
constexpr int kPieces = 12;

// Three digits: more are noise.
double rounded(double value) {
  const double scale = std::pow(10, 2 - std::floor(std::log10(value)));
  return std::round(value * scale) / scale;
}

FittedCurves curves_of(const Model& model) {
  FittedCurves curves;
  const auto points = static_cast<std::size_t>(model.surface.vertices.rows());
  curves.position = model.surface.vertices;
  curves.normal = model.inward_normal;
  curves.name.assign(points, "p");
  curves.message.assign(points, "");
  curves.status.assign(points, FitStatus::good);
  curves.curves = model.curves;
  for (Controls& control : curves.curves.control) control = rounded_to_float(control);
  return curves;
}

// Largest relative error of the normal curves' last control value, whose field is known.
double largest_error(const Model& model) {
  const double range_m = model.curves.basis[0].knots_m.back();
  const Controls& control = model.curves.control[0];
  double largest = 0;
  for (Eigen::Index v = 0; v < control.rows(); ++v) {
    const double exact =
        cylinder_stiffness_N_m(model.surface.vertices.row(v)) * range_m * range_m / 0.01;
    largest = std::max(largest, std::abs(control(v, control.cols() - 1) / exact - 1));
  }
  return largest;
}

}  // namespace

void bench_refine(const BenchRequest& request) {
  static constexpr std::string_view kHeader[] = {
      "vertices",  "test_points", "triangulation",     "cpu_s",
      "model_MiB", "peak_MiB",    "largest_error_rel", "machine"};
  CsvWriter csv(request.folder / "refine.csv", kHeader);
  const Model coarse = bench_cylinder(kPoints.around, kPoints.along, kPieces);
  const FittedCurves curves = curves_of(coarse);
  for (const SurfaceSize& size : kSizes) {
    if (request.is_quick && &size != &kSizes[0]) break;
    // One piece: curves of this body would hide in the peak what refinement itself takes.
    const Surface fine = bench_cylinder(size.around, size.along, 1).surface;
    const std::vector<char> is_reachable(static_cast<std::size_t>(fine.vertices.rows()), 1);
    for (const bool is_given : {true, false}) {
      const double started = cpu_seconds();
      const Model model =
          refine(curves, fine, is_reachable, is_given ? coarse.surface.triangles : Triangles(0, 3));
      const double seconds = cpu_seconds() - started, peak = peak_MiB();
      double bytes = 0;
      for (const Controls& control : model.curves.control)
        bytes += static_cast<double>(control.size()) * sizeof(double);
      csv.integer(fine.vertices.rows())
          .integer(curves.position.rows())
          .text(is_given ? "given" : "made")
          .number(rounded(seconds))
          .number(rounded(bytes / (1 << 20)))
          .number(rounded(peak))
          .number(rounded(largest_error(model)))
          .text(machine())
          .end_row();
      say("{} vertices, {} triangulation: {:.2f} s of CPU, peak {:.0f} MiB", fine.vertices.rows(),
          is_given ? "given" : "made", seconds, peak);
    }
  }
  csv.commit();
}

}  // namespace palpate::tools
