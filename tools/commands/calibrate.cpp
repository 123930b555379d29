#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "libfem/calibrate/pressed_body.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/commands/calibration_answer.hpp"
#include "tools/console.hpp"
#include "tools/outputs.hpp"
#include "tools/scene/canonical.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/samples/experiment_table.hpp"
#include "tools/stages/samples/sample_cache.hpp"
#include "tools/stages/stage_table.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::vector<std::size_t> free_of(const fem::MaterialParameters& material, const std::string& wish) {
  if (wish.empty()) return fem::identifiable(material);
  const auto names = names_of(material);
  std::vector<std::size_t> free;
  for (const std::string& name : parts_of_list(wish)) {
    const auto found = std::ranges::find(names, name, &NamedParameter::name);
    const auto at = static_cast<std::size_t>(found - names.begin());
    const std::string law = "law " + material.law;
    std::vector<std::string> known;
    for (std::size_t i = 0; i < names.size(); ++i)
      if (std::isfinite(material.values[i]) &&
          std::find(known.begin(), known.end(), names[i].name) == known.end())
        known.push_back(names[i].name);
    if (found == names.end() || !std::isfinite(material.values[at]))
      throw Error("--free",
                  found == names.end() ? fmt::format("{} has no \"{}\"", law, name)
                                       : fmt::format("[material] gives no {} to start from", name),
                  "Use any of " + listed(known, ",") + ".");
    if (!found->is_number)
      throw Error("--free", fmt::format("{} is a direction, which is not sought", name),
                  "Leave it out.");
    if (std::find(free.begin(), free.end(), at) == free.end()) free.push_back(at);
  }
  std::sort(free.begin(), free.end());
  return free;
}

// Presses that were simulated, beside the output until it is written.
class PressCache {
 public:
  PressCache(const std::string& output, std::string fingerprint, bool resume,
             fem::PressedBody& body)
      : path_(output + ".partial"), fingerprint_(std::move(fingerprint)), body_(body) {
    if (fs::exists(path_)) {
      const Json kept = resume ? Json::parse(read_whole_file(path_), nullptr, false) : Json();
      if (!resume)
        say("  {} of an interrupted run is not used (no --resume)", path_);
      else if (!kept.is_object() || kept.value("made_from", "") != fingerprint_)
        say("  {} was made from something else and is not used", path_);
      else
        take(kept);
    }
    body_.on_press = [this] { clock_.keep([this] { keep(); }); };
  }
  void keep() const {
    Json presses = Json::object();
    for (const auto& [name, press] : body_.known)
      presses[name] = {{"force_N", press.force_N}, {"error_N", press.error_N}};
    write_file_atomically(path_, Json{{"made_from", fingerprint_}, {"presses", presses}}.dump());
  }
  void remove() const {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }

 private:
  void take(const Json& kept) {
    try {
      for (const auto& [name, press] : kept.at("presses").items()) {
        fem::SimulatedPress& known = body_.known[name];
        known.force_N = press.at("force_N").get<std::vector<double>>();
        for (const Json& error : press.at("error_N"))
          known.error_N.push_back(error.is_number() ? error.get<double>() : NAN);
      }
      say("  resuming: {} presses are done", body_.known.size());
    } catch (const Json::exception&) {
      body_.known.clear();
    }
  }

  std::string path_, fingerprint_;
  fem::PressedBody& body_;
  KeepClock clock_;
};

class Calibrate final : public Command {
 public:
  explicit Calibrate(Arguments& arguments) {
    arguments.positional("input", input_, "Scene whose material is sought, scene.toml");
    arguments.option("--samples", samples_,
                     "Presses on the scene's body, samples.h5 as import or simulate write it",
                     true);
    arguments.option("--free NAMES", free_,
                     "Parameters to find, such as c10,c01; without it all of the law's but "
                     "Poisson's ratio and the bulk modulus");
    arguments.option("--points", points_,
                     "Points of the samples to use, evenly among them; 0 uses all");
    arguments.output("-o,--output", output_, "The scene with the material found, calibrated.toml",
                     {kCalibrationHeading});
    arguments.jobs(jobs_);
    arguments.flag("--resume", resume_, "Go on from the presses that an interrupted run kept");
  }

  int run(Reply& reply) override {
    const std::string text = read_whole_file(input_);
    const OutputLock lock(output_);
    const Scene scene = open_scene(input_);
    check_choices(scene);
    const auto free = free_of(*scene.material, free_);
    for (std::size_t i = 0; i < scene.inclusions.size(); ++i)
      if (canonical(scene.inclusions[i].material) == canonical(*scene.material))
        throw Error(input_ + ": " + name_of_part(scene, i),
                    "has the material of the body, and the search would change it, too",
                    "Start the search of [material] from other numbers, or leave the part out.");
    Samples samples = read_samples(samples_);
    const Body body = prepare_body(scene, false);
    place(scene, body, samples);
    fem::PressedBody pressed(make_setup(scene, body), samples, samples_, job_count(jobs_));
    const Eigen::Index rows = pressed.observed().value.size();
    if (rows <= std::ssize(free))
      throw Error(input_,
                  fmt::format("{} cannot tell {}", counted(rows, "row", "rows"),
                              counted(std::ssize(free), "parameter", "parameters")),
                  "Give more rows, or fewer parameters by --free.");
    say("calibrate: {} rows of {} presses", rows, pressed.presses());
    ContentHash made_from;
    made_from.add(point_fingerprint(scene, body)).add_file(samples_).add(std::to_string(points_));
    const PressCache cache(output_, made_from.hex(), resume_, pressed);
    ConsoleProgress progress("calibrate");
    const fem::Identification found =
        fem::identify(pressed, *scene.material, {.free = free, .progress = progress.progress()});
    if (is_interrupted()) {
      cache.keep();
      throw Interrupted(fmt::format("calibrate: what is done is kept in {}; go on with --resume",
                                    output_ + ".partial"));
    }
    if (found.response.size() == 0)
      throw Error(input_, "a press fails with the material that the search starts from",
                  "Start from another material, or leave out rows deeper than the body allows: "
                  "`palpate check` tries one.");
    const CalibrationAnswer answer(found, rows, (pressed.observed().deviation.array() > 0).any());
    std::string whole = text;
    if (whole.starts_with(kCalibrationHeading)) whole.erase(0, whole.find('\n') + 1);
    if (fs::absolute(output_).parent_path() != fs::absolute(input_).parent_path())
      for (const NewValue& named : absolute_files(whole, input_))
        whole = rewritten(whole, input_, {{named.section, named.key, quoted(named.value)}});
    whole = answer.heading() + rewritten(whole, input_, answer.values());
    parse_scene(whole, input_);  // what is written can be read
    reply.json = answer.json();
    reply.json["presses"] = pressed.presses();
    reply.json["simulated"] = pressed.simulated;
    reply.text = fmt::format("{} presses, {} simulated\n", pressed.presses(), pressed.simulated);
    if (!found.shared_error.empty()) {
      double largest = 0;
      for (const double error : found.shared_error) largest = std::max(largest, std::abs(error));
      reply.json["contacts"] = found.shared_error;
      reply.text += fmt::format(
          "contacts of {} are free within their deviations; the one that moves farthest moves by "
          "{:.2g} of its own\n",
          counted(std::ssize(found.shared_error), "press", "presses"), largest);
    }
    write_file_atomically(output_, whole);
    cache.remove();
    say("wrote {}", output_);
    reply.text += answer.in_words();
    if (const std::string doubt = answer.undetermined(); !doubt.empty()) warn("{}", doubt);
    if (found.is_converged) return kDone;
    say_failed("the search did not converge; the material is the best that it saw");
    return kSomeFailed;
  }

 private:
  // The samples at the points that are used, on the body's surface.
  void place(const Scene& scene, const Body& body, Samples& samples) const {
    if (samples.probe && samples.probe->shape != "point") {
      ProbeSpec theirs = *samples.probe, ours = scene.probe.spec;
      theirs.friction = ours.friction;
      if (canonical(theirs) != canonical(ours))
        warn("the samples are of another probe than the scene's, which is simulated");
    }
    const PointTable table{samples.point_position, samples.point_normal};
    samples.point_position = place_points(table, body.surface, samples_).position;
    const Eigen::Index all = samples.points();
    if (points_ < 0)
      throw Error("--points", fmt::format("{} is no number of points", points_),
                  "Use 1 or more, or 0 for all.");
    if (points_ > all)
      throw Error("--points", fmt::format("{} has {} points, not {}", samples_, all, points_),
                  "Use at most as many, or 0 for all.");
    if (points_ == 0 || points_ == all) return;
    std::vector<char> is_used(all, 0);
    for (int i = 0; i < points_; ++i) is_used[(2 * i + 1) * all / (2 * points_)] = 1;
    for (std::size_t row = 0; row < samples.status.size(); ++row)
      if (!is_used[samples.point[row]]) samples.status[row] = RowStatus::not_reached;
  }

  std::string input_, samples_, free_, output_;
  int jobs_ = 0, points_ = 0;
  bool resume_ = false;
};

}  // namespace

const CommandRow kCalibrateCommand{"calibrate", "Identify a material from presses on a body",
                                   declared<Calibrate>, "Recordings",
                                   "calibrate organ.toml --samples samples.h5 -o calibrated.toml"};

}  // namespace palpate::tools
