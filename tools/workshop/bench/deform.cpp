#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "libfit/io/csv/csv.hpp"
#include "tests/support/bodies.hpp"
#include "tools/console.hpp"
#include "tools/workshop/bench/bench.hpp"
#include "tools/workshop/bench/machine.hpp"
#include "tools/workshop/bench/tick_timing.hpp"

namespace palpate::tools {
namespace {

/// A response of one point: its dent falls off, its modes are sines. What a vertex costs does not
/// depend on the numbers.
void add_shape(Model& model, int modes) {
  const Eigen::Index vertices = model.surface.vertices.rows();
  ShapeResponse& shape = model.shape;
  shape.intervals = 10;
  shape.modes = modes;
  shape.depth_m = shape.radius_m = 0.005;
  shape.point = Controls::Zero(1, runtime::shape_numbers(shape.intervals, modes));
  for (int j = 0; j < shape.intervals; ++j)
    shape.point(0, j) = rounded_to_float(std::exp(-0.3 * j));
  shape.point.rightCols(3 * modes).setConstant(1e-4);
  shape.drag = Eigen::VectorXd::Zero(runtime::shape_drag_numbers(shape.intervals));
  shape.mode = Controls::Zero(vertices, 3 * modes);
  for (Eigen::Index i = 0; i < shape.mode.size(); ++i)
    shape.mode.data()[i] = rounded_to_float(0.1 * std::sin(0.01 * double(i)));
  model.blend_point = Triangles::Zero(vertices, 3);
  model.blend_weight = Points::Zero(vertices, 3);
  model.blend_weight.col(0).setOnes();
}

}  // namespace

void bench_deform(const BenchRequest& request) {
  static constexpr std::string_view kHeader[] = {"vertices", "modes",        "median_us",
                                                 "p99_us",   "us_per_10000", "machine"};
  CsvWriter csv(request.folder / "deform.csv", kHeader);
  const int calls = request.is_quick ? 20 : 400;
  const std::string processor = machine();
  say("{:>8} {:>5} {:>10} {:>10} {:>18}", "vertices", "modes", "median us", "p99 us",
      "us of 10000");
  struct Size {
    int around, along;
  };
  static constexpr Size kSizes[] = {{150, 66}, {480, 208}};
  for (const Size& size : kSizes)
    for (const int modes : {0, 8, 24}) {
      if (request.is_quick && (&size != kSizes || modes == 24)) continue;
      Model model = bench_cylinder(size.around, size.along, 4);
      add_shape(model, modes);
      const BenchAsset body = make_bench_asset(model);
      runtime::Contact contact;
      runtime::Output out;
      for (int k = 0; k <= 100; ++k) {
        const double tip[3] = {kCylinderRadius_m + 0.001 - 5e-5 * k, 0, 0.5 * kCylinderLength_m};
        runtime::touch(body.asset, contact, tip, out);
      }
      std::vector<float> moved(3 * static_cast<std::size_t>(body.asset.vertices));
      std::vector<double> us;
      SwitchWatch watch;
      for (int i = 0; i < calls; ++i) {
        watch.was_switched();
        const double started = now_ns();
        runtime::deform(body.asset, contact, 0.01, 0, body.asset.vertices, moved.data());
        const double spent = 1e-3 * (now_ns() - started);
        if (!watch.was_switched()) us.push_back(spent);
      }
      const double median_us = quantile(us, 0.5), p99_us = quantile(us, 0.99);
      const double scaled_us = median_us * 1e4 / body.asset.vertices;
      say("{:8} {:5} {:10.0f} {:10.0f} {:18.0f}", body.asset.vertices, modes, median_us, p99_us,
          scaled_us);
      csv.integer(body.asset.vertices)
          .integer(modes)
          .number(median_us)
          .number(p99_us)
          .number(scaled_us)
          .text(processor)
          .end_row();
    }
  csv.commit();
  say("wrote {}", (request.folder / "deform.csv").string());
}

}  // namespace palpate::tools
