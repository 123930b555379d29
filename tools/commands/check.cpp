#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "libfit/assets/asset_file.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/vtu.hpp"
#include "tools/command.hpp"
#include "tools/commands/check_asset.hpp"
#include "tools/console.hpp"
#include "tools/manifest/manifest.hpp"
#include "tools/report/report_page.hpp"
#include "tools/setup/check_manifest.hpp"
#include "tools/setup/doubts.hpp"
#include "tools/setup/trial.hpp"
#include "tools/stages/body/open_scene.hpp"
#include "tools/stages/body/plausibility.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/stage_table.hpp"

namespace palpate::tools {
namespace {

// The set-up on the fine surface: what is held, the window, the test points.
void write_set_up(const std::string& path, const Scene& scene, const Body& body) {
  const Points& vertices = body.surface.vertices;
  const auto count = static_cast<std::size_t>(vertices.rows());
  std::vector<char> is_held(count), is_test_point(count);
  for (std::size_t v = 0; v < count; ++v)
    is_held[v] = any_contains(scene.body.fixed, vertices.row(static_cast<Eigen::Index>(v)), true);
  for (Eigen::Index p = 0; p < body.test_points.position.rows(); ++p) {
    Eigen::Index nearest = 0;
    (vertices.rowwise() - body.test_points.position.row(p))
        .rowwise()
        .squaredNorm()
        .minCoeff(&nearest);
    is_test_point[nearest] = 1;
  }
  VtuWriter vtu;
  vtu.add("is_held", 1, is_held);
  vtu.add("in_region", 1, body.in_region);
  vtu.add("is_reachable", 1, body.is_reachable);
  vtu.add("is_test_point", 1, is_test_point);
  write_file_atomically(path, vtu.text(body.surface, "is_reachable"));
}

class Check final : public Command {
 public:
  explicit Check(Arguments& arguments) {
    arguments.positional(
        "file", scene_path_,
        "Scene to check, scene.toml; recordings to look at, manifest.toml; or asset to "
        "slide over, asset.palp");
    arguments.output("--vtu", vtu_, "Picture to write: what is held, window, points", {"vtu"},
                     false);
    arguments.output("--page", page_, "Page of the set-up to write: the same, to turn and look at",
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
        AssetAnswer answer = check_asset({scene_path_, devices_, tool_});
        reply = std::move(answer.reply);
        return answer.is_passive ? kDone : kSomeFailed;
      }
      if (is_manifest(scene_path_)) {
        refuse_options_of_scenes(false);
        CheckedManifest checked = check_manifest(scene_path_, jobs_);
        reply = {std::move(checked.text), checked.json};
        return checked.refused > 0 ? kSomeFailed : kDone;
      }
      inspect();
    } catch (const Error& e) {
      errors_.push_back(e);
    }
    for (const Error& e : errors_) {
      report_["errors"].push_back(
          {{"where", e.where()}, {"what", e.fact()}, {"remedy", e.remedy()}});
      to_stderr("palpate: {}: {}\n", error_word(), e.what());
    }
    reply.text = std::move(text_);
    reply.json = report_;
    return !errors_.empty() ? kBadInput : has_good_rows_ ? kDone : kSomeFailed;
  }

 private:
  // An asset takes two of these options, recordings take none.
  void refuse_options_of_scenes(bool is_asset) const {
    struct Option {
      const char* name;
      bool is_given, is_of_assets;
    };
    const Option options[] = {{"--vtu", !vtu_.empty(), false},
                              {"--page", !page_.empty(), false},
                              {"--devices", !devices_.empty(), true},
                              {"--tool", !tool_.empty(), true},
                              {"--no-trial", no_trial_, false}};
    for (const Option& option : options) {
      if (!option.is_given || (is_asset && option.is_of_assets)) continue;
      if (is_asset)
        throw Error(option.name, "is of scenes, and " + scene_path_ + " is an asset",
                    "Leave it out; `palpate export` writes pictures of an asset's curves.");
      throw Error(option.name,
                  "is not of recordings, and " + scene_path_ + " is a manifest of them",
                  "Leave it out; `palpate run` makes a report with a picture of each.");
    }
  }

  void inspect() {
    report_ = {{"scene", scene_path_}, {"errors", nlohmann::ordered_json::array()}};
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
    report_["warnings"] = warnings;
    report_["tets"] = body.volume.tets.rows();
    report_["test_points"] = body.test_points.position.rows();
    if (!vtu_.empty()) write_set_up(vtu_, scene, body);
    if (!page_.empty())
      write_page(page_, contents_of_set_up(std::filesystem::path(scene_path_).stem(), body,
                                           report_["warnings"]));
    if (!no_trial_) report_trial(scene, body);
  }

  void report_trial(const Scene& scene, const Body& body) {
    const Trial trial = try_middle_point(scene, body);
    has_good_rows_ = trial.good > 0;
    if (!has_good_rows_) say_failed("{}: no row of the trial is good", scene_path_);
    const int points = points_of_run(scene, body);
    const double cpu_s = cpu_of_run_s(scene, body, trial);
    const std::vector<std::string> advices = advice(scene, trial);
    report_["trial"] = {{"point", trial.point},
                        {"force_N", trial.force_N},
                        {"sway_m", trial.sway_m},
                        {"depth_m", trial.depth_m},
                        {"force_error", trial.force_error},
                        {"rows", trial.rows},
                        {"good", trial.good},
                        {"sticking", trial.sticking},
                        {"slipping", trial.slipping},
                        {"nodes", trial.nodes},
                        {"cpu_s", trial.cpu_s}};
    report_["run"] = {{"points_at_most", points}, {"cpu_s", cpu_s}};
    report_["advice"] = advices;
    text_ = fmt::format(
        "tried {} at ({:.1f}, {:.1f}, {:.1f}) mm: {:.3g} N at {:.3g} mm, {} of {} rows good, "
        "stated "
        "force error {:.2g} %, drags stick in {} rows and slip in {}; {} nodes, {}\n"
        "a run simulates {} points at most, held-out ones among them: about {} of one core",
        trial.point, 1e3 * trial.position[0], 1e3 * trial.position[1], 1e3 * trial.position[2],
        trial.force_N, 1e3 * trial.depth_m, trial.good, trial.rows, 100 * trial.force_error,
        trial.sticking, trial.slipping, trial.nodes, in_words(trial.cpu_s), points,
        in_words(cpu_s));
    for (const std::string& sentence : advices) text_ += fmt::format("\nadvice: {}", sentence);
    if (advices.empty() && report_["warnings"].empty()) text_ += "\nnothing to change";
  }

  std::string scene_path_, vtu_, page_, devices_, tool_, text_;
  int jobs_ = 0;
  bool no_trial_ = false, has_good_rows_ = true;
  std::vector<Error> errors_;
  nlohmann::ordered_json report_;
};

}  // namespace

std::unique_ptr<Command> declare_check(Arguments& arguments) {
  return std::make_unique<Check>(arguments);
}

}  // namespace palpate::tools
