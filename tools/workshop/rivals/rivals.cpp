// What a millisecond can buy: force error against time of a tick, method by method.

#include "tools/workshop/rivals/rivals.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>

#include "libfit/core/error.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/experiments/draw.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/console.hpp"
#include "tools/scene/canonical.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/workshop/bench/bench.hpp"
#include "tools/workshop/bench/machine.hpp"
#include "tools/workshop/rivals/measure.hpp"

namespace palpate::tools {
namespace {

constexpr double kBudget_s = 3, kQuickBudget_s = 1;

// CPU of this process and of those that it started and that have ended [s].
double all_cpu_s() {
  rusage ended{};
  getrusage(RUSAGE_CHILDREN, &ended);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return cpu_seconds() + seconds(ended.ru_utime) + seconds(ended.ru_stime);
}

// CPU of one point by the simulator, as the run's samples were made.
double point_cpu_s(const RivalBody& body, bool is_dragged) {
  const fem::Simulator simulator(make_setup(body.scene, body.body));
  const TestPoints& points = body.body.test_points;
  const double began_s = cpu_seconds();
  const Vec3 position = points.position.row(0), normal = points.normal.row(0);
  if (is_dragged)
    simulator.press_and_drag(position, normal, body.scene.experiments.each);
  else
    simulator.press_quickly(position, normal, body.scene.experiments.each);
  return cpu_seconds() - began_s;
}

std::filesystem::path file_of(const std::filesystem::path& run, const char* name) {
  if (std::filesystem::exists(run / name)) return run / name;
  throw Error("bench rivals", fmt::format("there is no {} in \"{}\"", name, run.string()),
              "Make it with `palpate run SCENE -o DIR` and give --run DIR.");
}

RivalBody read_run(const std::filesystem::path& run) {
  RivalBody body;
  body.body = read_body(file_of(run, "body.h5"));
  body.scene = scene_of(body.body, run / "body.h5");
  body.samples = of_kinds(read_samples(file_of(run, "samples.h5")),
                          {ExperimentKind::press, ExperimentKind::drag});
  body.paths = of_kinds(read_samples(file_of(run, "reference.h5")), {ExperimentKind::path});
  body.asset = read_asset_file(file_of(run, "asset.palp"));
  body.depth_m = body.scene.experiments.each.depth_m;
  body.radius_m = ball_radius_m(body.body.probe);
  if (!(body.radius_m > 0))
    throw Error("bench rivals", "the probe is no ball, which rivals need", "Give another run.");
  if (body.paths.time_s.size() > 0 || body.paths.rows() == 0)
    throw Error("bench rivals", "the run has no held-out paths in slow motion",
                "Give the run of a body that does not relax.");
  return body;
}

// p95 of what the reference says its own rows are off by.
double own_error(const Samples& paths) {
  std::vector<ForceError> rows;
  for (Eigen::Index row = 0; row < paths.rows(); ++row)
    if (paths.status[row] == RowStatus::good && std::isfinite(paths.force_error[row]))
      rows.push_back({paths.force_error[row], paths.force.row(row).norm()});
  return stated_quantile(stated_errors(rows), 0.95);
}

// Refuses a name that no rival has; empty: all of them.
void check_part(const std::string& part) {
  std::string names;
  for (const RivalRow& row : kRivals) {
    if (part.empty() || row.name == part) return;
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  }
  throw Error("bench rivals", "there is no rival called " + part, "Use one of: " + names + ".");
}

// The last part of its folder's name.
std::string name_of_run(const std::filesystem::path& run) {
  const std::filesystem::path whole = std::filesystem::absolute(run).lexically_normal();
  return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
}

void say_row(const Rival& rival, const Performance& did) {
  say("{:<22} {:>6.0f}  {:>6} median, {:>6} p95, tick {:.3g} us, p99.9 {:.3g}; {} bytes, "
      "{:.3g} s; {:.2g} mN per 10 um; loop {:+.2g} %; {} paths: {}",
      rival.name, rival.size, stated_percent(did.statement.all.force.median_rel),
      stated_percent(did.statement.all.force.p95_rel), did.tick_median_us, did.tick_p999_us,
      rival.bytes, rival.preparation_cpu_s, 1e3 * did.jump_N, 100 * did.created_share, did.paths,
      rival.settings);
}

}  // namespace

void measure_part(const RivalRow& row, const RivalBody& body, double budget_s, RivalsTable& table) {
  const double began_s = all_cpu_s();
  const auto leave_out = [&](const std::string& name, const std::string& why) {
    say("left out: {}: {}", name, why);
    table.leave_out(row.name, name, why);
  };
  {
    const std::vector<Rival> sizes = row.prepare(body);
    if (sizes.empty()) leave_out(std::string(row.summary), "its package is missing");
    for (const Rival& rival : sizes) {
      const std::string name = fmt::format("{}, {:.0f} nodes", rival.name, rival.size);
      if (!rival.rest.is_kept()) {
        leave_out(name, rival.rest.words("presses", rival.rest_ticks));
        continue;
      }
      const Performance did = measure(rival, body, budget_s);
      if (!did.rest.is_kept()) {
        leave_out(name, did.rest.words("paths", rival.rest_ticks));
        continue;
      }
      say_row(rival, did);
      table.add(row.name, rival, did);
    }
  }  // and another process that it had has ended
  const double cpu_s = all_cpu_s() - began_s;
  say("{}: {:.0f} s of CPU", row.name, cpu_s);
  table.end(row.name, cpu_s);
}

void bench_rivals(const BenchRequest& request) {
  check_part(request.part);
  if (request.run.empty())
    throw Error("bench rivals", "there is no run to compare on",
                "Make one with `palpate run SCENE -o DIR` and give --run DIR.");
  const std::string name = name_of_run(request.run);
  RivalBody body = read_run(request.run);
  body.packages = request.packages;
  RivalsTable table(request.folder, name, ContentHash().add_file(request.run / "asset.palp").hex(),
                    request.part.empty());
  const double began_s = all_cpu_s();
  body.dragged_cpu_s = point_cpu_s(body, true);
  body.pressed_cpu_s =
      body.samples.point_scale.size() > 0 ? point_cpu_s(body, false) : body.dragged_cpu_s;
  const double own_p95 = own_error(body.paths);
  say("{} paths, {} rows, whose own error is {:.2g} % (p95); a test point takes {:.2g} s of CPU "
      "with drags, {:.2g} s pressed alone",
      body.paths.points(), body.paths.rows(), 100 * own_p95, body.dragged_cpu_s,
      body.pressed_cpu_s);
  for (const RivalRow& row : kRivals)
    if (request.part.empty() || row.name == request.part)
      measure_part(row, body, request.is_quick ? kQuickBudget_s : kBudget_s, table);
  table.write(own_p95);
  say("{:.0f} s of CPU in all", all_cpu_s() - began_s);
}

}  // namespace palpate::tools
