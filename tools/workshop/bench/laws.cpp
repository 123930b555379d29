// Each contact law at a test point: curves of held-out points from their own presses and drags,
// along the held-out paths from there, without mesh and interpolation.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "libfit/core/error.hpp"
#include "libfit/core/experiments.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/validation/replay.hpp"
#include "tools/console.hpp"
#include "tools/workshop/bench/bench.hpp"

namespace palpate::tools {

using namespace validation;

void bench_laws(const BenchRequest& request) {
  if (request.samples.empty())
    throw Error("bench laws", "needs reference.h5 of a run", "Give --samples RUN/reference.h5.");
  const Samples all = read_samples(request.samples),
                own = of_kinds(all, {ExperimentKind::press, ExperimentKind::drag}),
                paths = of_kinds(all, {ExperimentKind::path});
  // Of each path, the presses at its place: validation has them at every second one.
  std::vector<Eigen::Index> own_of;
  for (Eigen::Index p = 0; p < paths.points(); ++p) {
    Eigen::Index q = own.points() - 1;
    while (q >= 0 && own.point_position.row(q) != paths.point_position.row(p)) --q;
    own_of.push_back(q);
  }
  if (own.points() == 0 || own_of.empty() || std::ranges::max(own_of) < 0)
    throw Error("bench laws", "the file has no presses at its held-out points",
                "Run with causes = true in [validate].");
  static constexpr std::string_view kHeader[] = {"law",        "path",    "rows",
                                                 "median_rel", "p95_rel", "max_rel"};
  CsvWriter csv(request.folder / "laws.csv", kHeader);
  for (const CurveFamilyName& family : kCurveFamilyNames) {
    FitOptions options = options_for(own);
    options.family = family.family;
    options.jobs = request.jobs;
    const FittedCurves curves = fit_curves(own, options);
    Replayed replayed(paths);
    for (std::int32_t p = 0; p < paths.points(); ++p) {
      const Eigen::Index q = own_of[static_cast<std::size_t>(p)];
      if (q >= 0 && curves.status[static_cast<std::size_t>(q)] != FitStatus::failed)
        replay_point(paths, p, curves.curves, q, replayed);
    }
    const auto add = [&](std::string_view name, int kind) {
      Comparison compared = compare(paths, replayed);
      std::erase_if(compared.rows, [&](Eigen::Index row) {
        return kind >= 0 && paths.path_of(row) != static_cast<PathKind>(kind);
      });
      const Statement s = summarize(compared, {relative_floor_N(paths)});
      const ErrorFigures& force = s.all.force;
      csv.text(std::string(family.name))
          .text(std::string(name))
          .integer(static_cast<long long>(s.rows_above_floor));
      for (const double share : {force.median_rel, force.p95_rel, force.max_rel})
        std::isnan(share) ? csv.text("") : csv.number(share);
      csv.end_row();
      say("  {:<10} {:<15} {:>4} rows: median {}, p95 {}, max {}", family.name, name,
          s.rows_above_floor, stated_percent(force.median_rel), stated_percent(force.p95_rel),
          stated_percent(force.max_rel));
    };
    add("all", -1);
    for (std::size_t kind = 0; kind < kUprightKinds; ++kind)
      add(kPathKindNames[kind], static_cast<int>(kind));
  }
  csv.commit();
}

}  // namespace palpate::tools
