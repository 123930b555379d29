#include <nlohmann/json.hpp>
#include <optional>

#include "libfit/core/error.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/stages/stage_table.hpp"

namespace palpate::tools {
namespace {

constexpr std::string_view kCacheKinds[] = {kFitCacheSchema.name};

class Fit final : public Command {
 public:
  explicit Fit(Arguments& arguments) {
    arguments.positional("samples", samples_, "Samples to fit, samples.h5");
    arguments.output("-o,--output", output_, "curves.h5 to write", {kCurvesSchema.name});
    FitSection& section = stage_.fit;
    arguments.option("--degree", section.degree, "Degree of the curves, 1 to 4");
    arguments.option(
        "--pieces", section.pieces,
        "Number of pieces of every curve; 0 takes the fewest that held-out rows support");
    arguments.option(
        "--family NAME", section.family,
        "Curve family of docs/method.md, sections 2 and 17: rings, which without drags are "
        "separable, or separable");
    arguments.option(
        "--warm-start", warm_start_,
        "Earlier curves.h5 whose bases are kept; only points whose rows changed are fitted again");
    arguments.option(
        "--free NAMES", frees_,
        "Nuisance parameters to estimate for each recording: any of contact,bias,drift");
    arguments.option("--jobs", stage_.jobs,
                     "Number of threads; 0 uses all cores; results do not depend on it");
  }

  int run(Reply& reply) override {
    const FitSection& section = stage_.fit;
    if (section.degree < 1 || section.degree > 4)
      throw Error("--degree", fmt::format("{} is no degree of a curve", section.degree),
                  "Use 1 to 4.");
    if (section.pieces < 0 || section.pieces > 256)
      throw Error("--pieces", fmt::format("there cannot be {} pieces", section.pieces),
                  "Use 1 to 256, or 0 to have the number chosen.");
    check_output(fit_cache_path(output_), kCacheKinds, {});
    say("fit {}", samples_);
    std::optional<FittedCurves> earlier;
    std::optional<FitCache> earlier_cache;
    if (!warm_start_.empty()) {
      earlier = read_curves(warm_start_);
      earlier_cache = read_fit_cache(warm_start_, *earlier);
    }
    FitCache cache;
    stage_.files = {.samples = samples_, .curves = output_};
    stage_.fit_choices = {earlier ? &*earlier : nullptr, earlier_cache ? &*earlier_cache : nullptr,
                          nuisances_named(frees_), &cache};
    kFitStage.make(stage_, !earlier && frees_.empty() ? kFitStage.wanted(stage_) : "");
    write_fit_cache(output_, cache);
    say("wrote {}", output_);
    const FittedCurves curves = read_curves(output_);
    const std::size_t bad = list_bad_points(curves);
    reply.json = nlohmann::ordered_json{{"points", curves.position.rows()},
                                        {"family", name_of(curves.curves.family)},
                                        {"without_curves_of_their_own", bad}};
    return bad ? kSomeFailed : kDone;
  }

 private:
  std::string samples_, output_, warm_start_, frees_;
  Pipeline stage_;
};

}  // namespace

std::unique_ptr<Command> declare_fit(Arguments& arguments) {
  return std::make_unique<Fit>(arguments);
}

}  // namespace palpate::tools
