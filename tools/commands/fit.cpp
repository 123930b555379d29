#include <nlohmann/json.hpp>
#include <optional>

#include "libfit/core/error.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/fit.hpp"

namespace palpate::tools {
namespace {

constexpr std::string_view kCacheKinds[] = {kFitCacheSchema.name};

class Fit final : public Command {
 public:
  explicit Fit(Arguments& arguments) {
    arguments.positional("samples", samples_, "Samples to fit, samples.h5");
    arguments.output("-o,--output", output_, "curves.h5 to write", {kCurvesSchema.name});
    arguments.option("--degree", section_.degree, "Degree of the curves, 1 to 4");
    arguments.option(
        "--pieces", section_.pieces,
        "Number of pieces of every curve; 0 takes the fewest that held-out rows support");
    arguments.option(
        "--family NAME", section_.family,
        "Curve family of docs/method.md, sections 2 and 17: rings, which without drags are "
        "separable, or separable");
    arguments.option(
        "--warm-start", warm_start_,
        "Earlier curves.h5 whose bases are kept; only points whose rows changed are fitted again");
    arguments.option(
        "--free NAMES", frees_,
        "Nuisance parameters to estimate for each recording: any of contact,bias,drift");
    arguments.option("--jobs", jobs_,
                     "Number of threads; 0 uses all cores; results do not depend on it");
  }

  int run(Reply& reply) override {
    if (section_.degree < 1 || section_.degree > 4)
      throw Error("--degree", fmt::format("{} is no degree of a curve", section_.degree),
                  "Use 1 to 4.");
    if (section_.pieces < 0 || section_.pieces > 256)
      throw Error("--pieces", fmt::format("there cannot be {} pieces", section_.pieces),
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
    const Samples samples = read_samples(samples_);
    FittedCurves curves =
        fit_samples(samples, section_, jobs_,
                    {earlier ? &*earlier : nullptr, earlier_cache ? &*earlier_cache : nullptr},
                    nuisances_named(frees_), &cache);
    Attributes attributes;
    if (!earlier && frees_.empty())
      attributes[kInputsAttribute] = curves_fingerprint(section_, samples_);
    write_curves(output_, curves, attributes);
    write_fit_cache(output_, cache);
    say("wrote {}", output_);
    const std::size_t bad = list_bad_points(curves);
    reply.json = nlohmann::ordered_json{{"points", curves.position.rows()},
                                        {"family", name_of(curves.curves.family)},
                                        {"without_curves_of_their_own", bad}};
    return bad ? kSomeFailed : kDone;
  }

 private:
  std::string samples_, output_, warm_start_, frees_;
  FitSection section_;
  int jobs_ = 0;
};

}  // namespace

std::unique_ptr<Command> declare_fit(Arguments& arguments) {
  return std::make_unique<Fit>(arguments);
}

}  // namespace palpate::tools
