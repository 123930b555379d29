#include "tools/stages/samples/cycles.hpp"

#include <algorithm>

#include "libfit/fit/damage.hpp"
#include "tools/console.hpp"

namespace palpate::tools {

bool softens(const Scene& scene) {
  const auto is_soft = [](const fem::MaterialParameters& m) { return m.softening.is_any(); };
  return (scene.material && is_soft(*scene.material)) ||
         std::ranges::any_of(scene.inclusions, is_soft, &InclusionSection::material);
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
