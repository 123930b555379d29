#include <optional>

#include "libfit/io/files/body_file.hpp"
#include "libfit/io/files/curves_file.hpp"
#include "libfit/io/files/fit_cache_file.hpp"
#include "libfit/io/files/samples_file.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/stages/fit.hpp"

namespace palpate::tools {
namespace {

class Fit final : public Command {
 public:
  explicit Fit(Arguments& arguments) {
    arguments.positional("samples", samples_, "samples.h5");
    arguments.option("-o,--output", output_, "curves.h5 to write", true);
    arguments.option("--degree", section_.degree,
                     "Degree of the curves, 1 to 4; 0: by held-out rows");
    arguments.option("--pieces", section_.pieces,
                     "Pieces of every curve; 0: as few as the data support");
    arguments.option(
        "--family", section_.family,
        "Curve family: auto (by held-out rows), separable, leaning, coupled, coupled-leaning, and "
        "each with an anisotropy (anisotropic, anisotropic-leaning, ...)");
    arguments.option(
        "--warm-start", warm_start_,
        "curves.h5 of an earlier fit: keep its bases, refit only points whose rows changed");
    arguments.option("--free", frees_,
                     "Found out about each recording, too: contact, bias, drift (commas between)");
    arguments.option("--contact-deviation", contact_deviation_,
                     "How far off a contact point may be where the samples do not say: \"0.1 mm\"");
    arguments.option("--smoothing", smoothing_,
                     "Over neighbouring points: auto (by held-out rows), none, or a strength");
    arguments.option(
        "--body", body_,
        "body.h5 whose surface says which points are neighbours; else their places do");
    arguments.option("--jobs", jobs_, "Threads; 0: all cores");
  }

  int run() override {
    say("fit {}", samples_);
    std::optional<FittedCurves> earlier;
    std::optional<FitCache> earlier_cache;
    if (!warm_start_.empty()) {
      earlier = read_curves(warm_start_);
      earlier_cache = read_fit_cache(warm_start_, *earlier);
    }
    section_.smoothing = smoothing_choice(smoothing_);
    const std::optional<Body> body = body_.empty() ? std::nullopt : std::optional(read_body(body_));
    FitCache cache;
    const FittedCurves curves =
        fit_samples(read_samples(samples_), section_, ProbeSection{}.spec.friction, jobs_,
                    body ? &*body : nullptr,
                    {earlier ? &*earlier : nullptr, earlier_cache ? &*earlier_cache : nullptr},
                    nuisance_choice(frees_, contact_deviation_), &cache);
    write_curves(output_, curves);
    write_fit_cache(output_, cache);
    say("wrote {}", output_);
    return list_bad_points(curves) ? kSomeFailed : kDone;
  }

 private:
  std::string samples_, output_, warm_start_, frees_, contact_deviation_, body_;
  std::string smoothing_ = "auto";
  FitSection section_;
  int jobs_ = 0;
};

}  // namespace

std::unique_ptr<Command> declare_fit(Arguments& arguments) {
  return std::make_unique<Fit>(arguments);
}

}  // namespace palpate::tools
