#include "tools/stages/samples/cycles.hpp"

#include <algorithm>

#include "libfem/solve/experiments/cycled_path.hpp"
#include "libfem/solve/experiments/simulate.hpp"
#include "libfit/core/error.hpp"
#include "libfit/fit/damage.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/console.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/samples/simulate.hpp"

namespace palpate::tools {

bool softens(const Scene& scene) {
  const auto is_soft = [](const fem::MaterialParameters& m) { return m.softening.is_any(); };
  return (scene.material && is_soft(*scene.material)) ||
         std::ranges::any_of(scene.inclusions, is_soft, &InclusionSection::material);
}

Samples simulate_cycles(const Scene& scene, const Body& body, int jobs,
                        const std::filesystem::path& output, const std::string& fingerprint) {
  const Eigen::Index points = body.test_points.position.rows(),
                     count = std::min<Eigen::Index>(points, scene.experiments.cycles);
  TestPoints cycled;
  cycled.position.resize(count, 3);
  cycled.normal.resize(count, 3);
  std::vector<ToolPath> paths;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index p = i * points / count;
    cycled.position.row(i) = body.test_points.position.row(p);
    cycled.normal.row(i) = body.test_points.normal.row(p);
    cycled.name.push_back(body.test_points.name[static_cast<std::size_t>(p)]);
    paths.push_back(fem::cycled_press(static_cast<int>(i), cycled.normal.row(i),
                                      scene.experiments.each.depth_m));
  }
  const fem::Simulator simulator(make_setup(scene, body));
  Samples samples;
  {
    ConsoleProgress progress("simulate, cycles");
    samples =
        fem::simulate_paths(simulator, cycled, paths, {.jobs = job_count(jobs), .already_done = {}},
                            {}, progress.progress());
  }
  if (is_interrupted()) throw Interrupted("simulate: the cycles are not whole and were not kept");
  add_origin(samples, simulator);
  write_samples(output, samples, {{kInputsAttribute, fingerprint}});
  list_bad_experiments(samples);
  return samples;
}

void add_damage(FittedCurves& curves, const Samples& cycles, bool may_dent) {
  fit::DamageReport report;
  curves.curves.damage = fit::identify_damage(curves, cycles, &report, may_dent);
  const runtime::DamageView& damage = curves.curves.damage;
  if (!damage.softens()) {
    say("  damage   none: {} cycles of {} rows, {:.1f} % off without it (median)", report.cycles,
        report.rows, 100 * report.median_undamaged);
    return;
  }
  say("  damage   r {:.3g}, m {:.3g} of a whole press's energy, beta {:.3g}: {} cycles of {} rows "
      "are off by {:.1f} % "
      "(median), {:.1f} % (p95); without it {:.1f} % and {:.1f} %",
      damage.r, damage.scale, damage.beta, report.cycles, report.rows, 100 * report.median,
      100 * report.p95, 100 * report.median_undamaged, 100 * report.p95_undamaged);
  say("           standard deviations: r {:.2g} %, m {:.2g} %, beta {:.2g} %",
      100 * report.deviation[0], 100 * report.deviation[1], 100 * report.deviation[2]);
  if (report.dent > 0)
    say("           a dent stays: nothing answers in the first {:.0f} % of the depth pressed "
        "before",
        100 * report.dent);
}

}  // namespace palpate::tools
