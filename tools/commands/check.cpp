#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "libfit/assets/asset_file.hpp"
#include "libfit/certify/certificate.hpp"
#include "libfit/core/error.hpp"
#include "libfit/experiments/follow.hpp"
#include "libfit/io/atomic_file.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/manifest/manifest.hpp"
#include "tools/report/report_page.hpp"
#include "tools/scene/scene.hpp"
#include "tools/scene/tissues.hpp"
#include "tools/setup/check.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/samples/experiment_table.hpp"
#include "tools/stages/stage_table.hpp"
#include "tools/stages/validate.hpp"

namespace palpate::tools {
namespace {

using certify::Certificate;
using certify::DeviceVerdict;
using Json = nlohmann::ordered_json;

// The figures that decide and are not known.
std::string unknown_words(const certify::Device& device) {
  if (device.max_force_N > 0 && device.max_stiffness_N_m > 0) return {};
  return device.max_force_N > 0         ? "stiffness"
         : device.max_stiffness_N_m > 0 ? "force"
                                        : "force, stiffness";
}

Json to_json(const DeviceVerdict& verdict) {
  return {{"name", verdict.device.name},
          {"force_fits", verdict.force_fits},
          {"stiffness_fits", verdict.stiffness_fits},
          {"resolution_fits", verdict.resolution_fits},
          {"not_known", unknown_words(verdict.device)},
          {"source", verdict.device.source}};
}

Json to_json(const Certificate& c, const std::vector<DeviceVerdict>& devices) {
  const certify::ForceJumps& jumps = c.jumps;
  Json damping = Json::object(), verdicts = Json::array();
  for (const int rate : certify::kRates_Hz)
    damping[std::to_string(rate)] = certify::least_damping_Ns_m(c.stiffness_N_m, rate);
  for (const DeviceVerdict& device : devices) verdicts.push_back(to_json(device));
  return {
      {"passive_fixed", c.is_passive_fixed()},
      {"k_max_N_m", c.stiffness_N_m},
      {"b_min_Ns_m", damping},
      {"edge_jump_N", jumps.edge_N},
      {"edge_jump_at_m", c.edge_jump_at_m},
      {"guard", {{"held_ticks", c.held_ticks}, {"refused_J", c.refused_J}, {"work_J", c.work_J}}},
      {"continuity",
       {{"sampled_ticks", c.ticks},
        {"pulling_ticks", c.pulling_ticks},
        {"touch_N", jumps.touch_N},
        {"release_N", jumps.release_N},
        {"edge_N", jumps.edge_N},
        {"inside_N", jumps.inside_N},
        {"force_N", c.force_N}}},
      {"devices", verdicts}};
}

std::string certificate_text(const Certificate& c, bool has_guard) {
  std::string out = fmt::format("In {} ticks of seeded slides the body ", c.ticks);
  out += c.is_passive_fixed()
             ? "never pulled the tool in and never stored less than nothing. "
             : fmt::format("pulled the tool in or stored less than nothing {} times. ",
                           c.pulling_ticks);
  if (!has_guard)
    out += "The asset has no guard. ";
  else if (c.held_ticks == 0)
    out += "The guard never held its force back. ";
  else
    out += fmt::format(
        "The guard held its force back in {:.2g} % of them: slips would have created {:.3g} uJ, "
        "{:.2g} % of the work of the tool. ",
        100 * double(c.held_ticks) / double(c.ticks), 1e6 * c.refused_J,
        100 * c.refused_J / c.work_J);
  return out + fmt::format(
                   "The force changed by at most {:.3g} N in 50 um ({:.0f} N/m): over edges {:.3g} "
                   "N, at {}, at touch {:.3g} N, at release {:.3g} N. A device needs {:.2g} N s/m "
                   "of its own at 1 kHz.",
                   c.stiffness_N_m * certify::SlideOptions().step_m, c.stiffness_N_m,
                   c.jumps.edge_N, in_mm(Vec3::Map(c.edge_jump_at_m)), c.jumps.touch_N,
                   c.jumps.release_N, certify::least_damping_Ns_m(c.stiffness_N_m, 1000));
}

// A line for all devices of which the same is to be said.
std::string device_words(const std::vector<DeviceVerdict>& devices) {
  std::vector<std::pair<std::string, std::string>> lines;  // words, names
  for (const DeviceVerdict& verdict : devices) {
    std::string lacks;
    const auto add = [&](bool fits, const char* what) {
      if (!fits) lacks += (lacks.empty() ? "" : ", ") + std::string(what);
    };
    add(verdict.force_fits, "force");
    add(verdict.stiffness_fits, "stiffness");
    add(verdict.resolution_fits, "friction for its resolution");
    const std::string unknown = unknown_words(verdict.device);
    const std::string words = fmt::format("{}{}{}",
                                          !lacks.empty()    ? "lacks " + lacks
                                          : unknown.empty() ? "shows this body"
                                                            : "nothing against it",
                                          unknown.empty() ? "" : "; not known: ", unknown);
    const auto same = std::ranges::find(lines, words, &std::pair<std::string, std::string>::first);
    if (same != lines.end())
      same->second += ", " + verdict.device.name;
    else
      lines.emplace_back(words, verdict.device.name);
  }
  std::string out;
  for (const auto& [words, names] : lines) out += fmt::format("  {}: {}\n", names, words);
  return out;
}

// The certificate of an asset, as a paragraph and as an object. more_devices: a table beside the
// program's. tool: a scene whose [probe] meets it; empty: the asset's own ball.
int check_asset(const std::string& path, const std::string& more_devices, const std::string& tool,
                Reply& reply) {
  const AssetFile file = read_asset_file(path);
  IndenterAssets met(file.asset());
  const runtime::AssetView* other =
      tool.empty() ? nullptr : met.of(meeting_end(tool, file.asset()));
  const runtime::AssetView& asset = other != nullptr ? *other : file.asset();
  const Certificate certificate =
      certify::certify(asset, {.radius_m = asset.probe_radius_m});  // a tip stands for the ball
  std::vector<DeviceVerdict> devices;
  for (const certify::Device& device : read_devices(more_devices))
    devices.push_back(certify::judge(device, certificate.stiffness_N_m, certificate.force_N));
  reply.json = {{"asset", path}, {"radius_m", asset.probe_radius_m}};
  reply.json.update(to_json(certificate, devices));
  reply.text = fmt::format("Devices:\n{}\n{}\n", device_words(devices),
                           certificate_text(certificate, asset.has_guard));
  return certificate.is_passive_fixed() ? kDone : kSomeFailed;
}

class Check final : public Command {
 public:
  explicit Check(Arguments& arguments) {
    arguments.positional("file", scene_path_,
                         "Scene to check, scene.toml; recordings to look at, manifest.toml; or "
                         "asset to slide over, asset.palp");
    arguments.output(
        "--page", page_,
        "Page of the set-up to write, to turn and look at: what is held, window, points",
        {kPageKind}, false);
    arguments.option("--devices", devices_,
                     "Haptic devices to judge an asset by, besides data/devices.toml");
    arguments.option("--jobs", jobs_, "Threads for recordings; 0: all cores");
    arguments.option("--tool", tool_,
                     "Scene whose [probe] meets an asset, in place of the ball of its curves");
    arguments.flag("--no-trial", no_trial_, "Do not simulate a point");
  }

  int run(Reply& reply) override {
    try {
      if (is_asset_file(scene_path_)) {
        refuse_options_of_scenes(true);
        return check_asset(scene_path_, devices_, tool_, reply);
      }
      if (is_manifest(scene_path_)) {
        refuse_options_of_scenes(false);
        CheckedManifest checked = check_manifest(scene_path_, jobs_);
        reply = {std::move(checked.text), checked.json};
        return checked.refused > 0 ? kSomeFailed : kDone;
      }
      inspect(reply);
    } catch (const Error& e) {
      errors_.push_back(e);
    }
    for (const Error& e : errors_) {
      reply.json["errors"].push_back(
          {{"where", e.where()}, {"what", e.fact()}, {"remedy", e.remedy()}});
      to_stderr("palpate: error: {}\n", e.what());
    }
    return !errors_.empty() ? kBadInput : has_good_rows_ ? kDone : kSomeFailed;
  }

 private:
  // An asset takes two of these options, recordings take none.
  void refuse_options_of_scenes(bool is_asset) const {
    if (is_asset)
      return refuse_options({{"--page", !page_.empty()}, {"--no-trial", no_trial_}},
                            "is of scenes, and " + scene_path_ + " is an asset",
                            "Leave it out; `palpate export` writes pictures of an asset's curves.");
    refuse_options({{"--page", !page_.empty()},
                    {"--devices", !devices_.empty()},
                    {"--tool", !tool_.empty()},
                    {"--no-trial", no_trial_}},
                   "is not of recordings, and " + scene_path_ + " is a manifest of them",
                   "Leave it out; `palpate run` makes a report with a picture of each.");
  }

  void inspect(Reply& reply) {
    Json& report = reply.json;
    report = {{"scene", scene_path_}, {"errors", nlohmann::ordered_json::array()}};
    Scene scene = parse_scene(read_whole_file(scene_path_), scene_path_, &errors_);
    if (!errors_.empty()) return;
    scene = open_scene(scene_path_);
    check_choices(scene);
    const Body body = prepare_body(scene, false);
    check_experiments(scene, body);
    std::vector<std::string> warnings = implausible(scene, body);
    for (const std::string& doubt : doubts_of_body(scene, body.mended)) {
      warn("{}", doubt);
      warnings.push_back(doubt);
    }
    report["warnings"] = warnings;
    report["tets"] = body.volume.tets.rows();
    report["test_points"] = body.test_points.position.rows();
    if (!page_.empty())
      write_page(page_, contents_of_set_up(std::filesystem::path(scene_path_).stem(), body,
                                           report["warnings"]));
    if (!no_trial_) report_trial(scene, body, reply);
  }

  void report_trial(const Scene& scene, const Body& body, Reply& reply) {
    Json& report = reply.json;
    const Trial trial = try_middle_point(scene, body);
    has_good_rows_ = trial.good > 0;
    if (!has_good_rows_) say_failed("{}: no row of the trial is good", scene_path_);
    const int points = points_of_run(scene, body);
    const double cpu_s = cpu_of_run_s(scene, body, trial);
    const std::vector<std::string> advices = advice(scene, trial);
    report["trial"] = {{"point", trial.point},       {"force_N", trial.force_N},
                       {"sway_m", trial.sway_m},     {"held_share", trial.held_share},
                       {"depth_m", trial.depth_m},   {"force_error", trial.force_error},
                       {"rows", trial.rows},         {"good", trial.good},
                       {"sticking", trial.sticking}, {"slipping", trial.slipping},
                       {"nodes", trial.nodes},       {"cpu_s", trial.cpu_s}};
    const auto interval = interval_of(scene, trial.held_share);
    if (interval)
      report["interval"] = {{"low_rel", interval->low_rel}, {"high_rel", interval->high_rel}};
    report["run"] = {{"points_at_most", points}, {"cpu_s", cpu_s}};
    report["advice"] = advices;
    reply.text = fmt::format(
        "tried {} at {}: {:.3g} N at {:.3g} mm, {} of {} rows good, stated force error {:.2g} %, "
        "drags stick in {} rows and slip in {}; {} nodes, {}\n"
        "a run simulates {} points at most, held-out ones among them: about {} of one core",
        trial.point, in_mm(trial.position), trial.force_N, 1e3 * trial.depth_m, trial.good,
        trial.rows, 100 * trial.force_error, trial.sticking, trial.slipping, trial.nodes,
        in_words(trial.cpu_s), points, in_words(cpu_s));
    if (interval) reply.text += "\n" + validation::in_words(*interval);
    for (const std::string& sentence : advices) reply.text += fmt::format("\nadvice: {}", sentence);
    if (advices.empty() && report["warnings"].empty()) reply.text += "\nnothing to change";
  }

  std::string scene_path_, page_, devices_, tool_;
  int jobs_ = 0;
  bool no_trial_ = false, has_good_rows_ = true;
  std::vector<Error> errors_;
};

}  // namespace

const CommandRow kCheckCommand{
    "check", "Say all that is wrong with a scene, try one point, and say what a run will cost",
    declared<Check>, "Start", "check organ.toml"};

}  // namespace palpate::tools
