#include <optional>

#include "libfit/io/files/body_file.hpp"
#include "libfit/io/files/curves_file.hpp"
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
        "Curve family: auto (by held-out rows) or one of those in docs/method.md, section 2");
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
    const std::optional<FittedCurves> earlier =
        warm_start_.empty() ? std::nullopt : std::optional(read_curves(warm_start_));
    section_.smoothing = smoothing_choice(smoothing_);
    const std::optional<Body> body = body_.empty() ? std::nullopt : std::optional(read_body(body_));
    const FittedCurves curves = fit_file(
        samples_, section_, ProbeSection{}.spec.friction, jobs_, earlier ? &*earlier : nullptr,
        sensor_choice(frees_, contact_deviation_), body ? &*body : nullptr);
    write_curves(output_, curves, {}, warm_start_);
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
