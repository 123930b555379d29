#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "libfem/calibrate/homogeneous_tests.hpp"
#include "libfem/calibrate/pressed_body.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/manifest/specimens.hpp"
#include "tools/outputs.hpp"
#include "tools/scene/nearest_name.hpp"
#include "tools/scene/rewrite.hpp"
#include "tools/scene/settings.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/prepare.hpp"
#include "tools/stages/simulate.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::string_view kHeading = "# Calibrated by palpate";
constexpr double kKeepShare = 0.05;    // of the time, spent on keeping what is simulated
constexpr Eigen::Index kThinned = 60;  // rows of a test, while starts are compared
constexpr int kStarts = 12;

struct NamedParameter {
  std::string name;
  bool is_modulus = false;
};

// Names of a law's values, one each.
std::vector<NamedParameter> names_of(const fem::MaterialParameters& material) {
  std::vector<NamedParameter> out;
  for (const fem::ParameterRow& row : fem::find_law(material.law, "law").parameters)
    for (int k = 0; k < row.count; ++k) out.push_back({std::string(row.name), !row.unit.empty()});
  return out;
}

std::vector<std::string> split_names(const std::string& text) {
  std::vector<std::string> names{""};
  for (const char c : text)
    if (c == ',')
      names.emplace_back();
    else if (c != ' ')
      names.back() += c;
  return names;
}

std::vector<std::size_t> free_of(const fem::MaterialParameters& material, const std::string& wish) {
  if (wish.empty()) return fem::identifiable(material);
  const auto names = names_of(material);
  std::vector<std::size_t> free;
  for (const std::string& name : split_names(wish)) {
    const auto found = std::find_if(names.begin(), names.end(), [&](const NamedParameter& known) {
      return known.name == name;
    });
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
    if (std::count_if(names.begin(), names.end(), [&](const auto& n) { return n.name == name; }) >
        1)
      throw Error("--free", fmt::format("{} is a direction, which is not sought", name),
                  "Leave it out.");
    if (std::find(free.begin(), free.end(), at) == free.end()) free.push_back(at);
  }
  std::sort(free.begin(), free.end());
  return free;
}

// Pressures in the unit that suits the largest of them.
struct PressureUnit {
  explicit PressureUnit(double largest_Pa)
      : name(largest_Pa >= 1e6   ? "MPa"
             : largest_Pa >= 1e3 ? "kPa"
                                 : "Pa"),
        size_Pa(largest_Pa >= 1e6   ? 1e6
                : largest_Pa >= 1e3 ? 1e3
                                    : 1) {}
  std::string name;
  double size_Pa;
};

std::string in_toml(double value, bool is_modulus) {
  if (!is_modulus) return number(value, 6);
  const PressureUnit unit(std::abs(value));
  return fmt::format("\"{} {}\"", number(value / unit.size_Pa, 6), unit.name);
}

/// What was found, in words, as JSON and as values of [material].
class CalibrationAnswer {
 public:
  /// unit: of what was observed. is_stated: some rows state their error.
  CalibrationAnswer(const fem::Identification& found, Eigen::Index rows, std::string_view unit,
                    bool is_stated)
      : found_(found),
        names_(names_of(found.material)),
        rows_(rows),
        unit_(unit),
        is_stated_(is_stated) {}

  std::string value_in_words(std::size_t k) const {
    const std::size_t i = found_.free[k];
    const double value = found_.material.values[i], deviation = found_.deviation(k);
    if (!names_[i].is_modulus) return fmt::format("{:.4g} ± {:.2g}", value, deviation);
    const PressureUnit unit(std::abs(value));
    return fmt::format("{:.4g} ± {:.2g} {}", value / unit.size_Pa, deviation / unit.size_Pa,
                       unit.name);
  }
  std::string in_words() const {
    std::string text =
        fmt::format("{:<12} {:>26}  95 %\n", found_.material.law, "value, deviation");
    for (std::size_t k = 0; k < found_.free.size(); ++k) {
      const std::size_t i = found_.free[k];
      const double value = found_.material.values[i],
                   half = found_.half_width * found_.deviation(k);
      const PressureUnit unit(names_[i].is_modulus ? std::abs(value) : 1);
      text += fmt::format("{:<12} {:>26}  {:.4g} to {:.4g}\n", names_[i].name, value_in_words(k),
                          (value - half) / unit.size_Pa, (value + half) / unit.size_Pa);
    }
    for (std::size_t k = 1; k < found_.free.size(); ++k)
      for (std::size_t m = 0; m < k; ++m)
        text += fmt::format(
            "correlation of {} and {}: {:.3f}\n", name(m), name(k),
            found_.correlation(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(m)));
    text +=
        is_stated_
            ? fmt::format("{} rows; residuals {:.2g} of the stated errors", rows_, found_.misfit)
            : fmt::format("{} rows; residuals {:.3g} {} rms", rows_,
                          std::sqrt(found_.sum_of_squares / static_cast<double>(rows_)), unit_);
    if (found_.rows_each > 1)
      text += fmt::format(", {:.2g} rows go together as one", found_.rows_each);
    for (const std::string& line : not_told_apart()) text += "\n" + line;
    return text;
  }
  std::vector<std::string> not_told_apart() const {
    if (found_.are_told_apart) return {};
    std::vector<std::string> all;
    for (std::size_t k = 0; k < found_.free.size(); ++k) all.push_back(name(k));
    if (all.size() == 1) return {fmt::format("the rows do not determine {}", all.front())};
    std::vector<std::string> lines{
        fmt::format("the rows do not tell {} apart{}", listed(all, ", "),
                    found_.determined.empty() ? " and determine none" : "; they determine")};
    for (const auto& one : found_.determined) lines.push_back("  " + in_words(one));
    return lines;
  }
  Json json() const {
    Json parameters = Json::array(), correlation = Json::array(), determined = Json::array();
    for (std::size_t k = 0; k < found_.free.size(); ++k) {
      const std::size_t i = found_.free[k];
      const double value = found_.material.values[i],
                   half = found_.half_width * found_.deviation(k);
      parameters.push_back({{"name", names_[i].name},
                            {"unit", names_[i].is_modulus ? "Pa" : "1"},
                            {"value", value},
                            {"deviation", found_.deviation(k)},
                            {"low", value - half},
                            {"high", value + half}});
      Json line = Json::array();
      for (std::size_t m = 0; m < found_.free.size(); ++m)
        line.push_back(
            found_.correlation(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(m)));
      correlation.push_back(line);
    }
    for (const auto& one : found_.determined)
      determined.push_back(
          {{"what", combination(one)}, {"value", one.value}, {"deviation", one.deviation}});
    return {{"law", found_.material.law},
            {"parameters", parameters},
            {"correlation", correlation},
            {"told_apart", found_.are_told_apart},
            {"determined", determined},
            {"rows", rows_},
            {"misfit", found_.misfit},
            {"rows_each", found_.rows_each},
            {"sum_of_squares", found_.sum_of_squares},
            {"converged", found_.is_converged}};
  }
  std::vector<NewValue> values() const {
    std::vector<NewValue> out;
    for (const std::size_t i : found_.free)
      out.push_back(
          {"material", names_[i].name, in_toml(found_.material.values[i], names_[i].is_modulus)});
    return out;
  }
  std::string heading() const {
    std::string line(kHeading);
    for (std::size_t k = 0; k < found_.free.size(); ++k)
      line += fmt::format("{} {} = {}", k == 0 ? ":" : ",", name(k), value_in_words(k));
    return line + "\n";
  }

 private:
  std::string name(std::size_t k) const { return names_[found_.free[k]].name; }
  std::string combination(const fem::DeterminedCombination& one) const {
    std::string text;
    for (Eigen::Index k = 0; k < one.weight.size(); ++k) {
      const double weight = one.weight[k];
      if (std::abs(weight) < 0.005) continue;
      const std::string shown = number(std::abs(weight), 3);
      const bool is_one = std::abs(std::abs(weight) - 1) < 0.005;
      const std::string its_name = name(static_cast<std::size_t>(k));
      if (one.is_product)
        text += fmt::format("{}{}{}", text.empty() ? "" : " ", its_name,
                            is_one && weight > 0 ? "" : fmt::format("^{:.3g}", weight));
      else
        text += fmt::format("{}{}{}",
                            text.empty() ? (weight < 0 ? "-" : "")
                            : weight < 0 ? " - "
                                         : " + ",
                            is_one ? "" : fmt::format("{} ", shown), its_name);
    }
    return text;
  }
  std::string in_words(const fem::DeterminedCombination& one) const {
    if (one.is_product)
      return fmt::format("{} = {:.4g} ± {:.2g}", combination(one), one.value, one.deviation);
    const PressureUnit unit(std::abs(one.value));
    return fmt::format("{} = {:.4g} ± {:.2g} {}", combination(one), one.value / unit.size_Pa,
                       one.deviation / unit.size_Pa, unit.name);
  }

  const fem::Identification& found_;
  std::vector<NamedParameter> names_;
  Eigen::Index rows_;
  std::string_view unit_;
  bool is_stated_;
};

/// Presses that were simulated, beside the output until it is written.
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
    body_.on_press = [this] {
      const double from_s = wall_seconds();
      if (from_s < next_s_) return;
      keep();
      next_s_ = wall_seconds() + (wall_seconds() - from_s) / kKeepShare;
    };
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
  const std::string& path() const { return path_; }

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
  double next_s_ = 0;
};

class Calibrate final : public Command {
 public:
  explicit Calibrate(Arguments& arguments) {
    arguments.positional("input", input_,
                         "Scene whose material is sought, scene.toml; or tests of specimens, "
                         "tests.toml (docs/formats.md)");
    arguments.option("--samples", samples_,
                     "Presses on the scene's body, samples.h5 as import or simulate write it");
    arguments.option("--free", free_,
                     "Parameters to find, such as c10,c01; without it all of the law's but "
                     "Poisson's ratio and the bulk modulus");
    arguments.option("--points", points_,
                     "Points of the samples to use, evenly among them; 0 uses all");
    arguments.output("-o,--output", output_, "The scene with the material found, calibrated.toml",
                     {kHeading});
    arguments.option("--jobs", jobs_,
                     "Number of threads; 0 uses all cores; results do not depend on it");
    arguments.flag("--resume", resume_, "Go on from the presses that an interrupted run kept");
  }

  int run(Reply& reply) override {
    const std::string text = read_whole_file(input_);
    const bool has_tests = text.find('\0') == std::string::npos && has_specimens(text, input_);
    if (has_tests != samples_.empty())
      throw Error(has_tests ? "--samples" : input_,
                  has_tests ? "the input has tests of specimens, which need no samples"
                            : "the scene says nothing of what was measured",
                  has_tests ? "Leave it out, or name a scene."
                            : "Add --samples samples.h5, or name a file with [[test]].");
    const OutputLock lock(output_);
    return has_tests ? from_specimens(text, reply) : from_presses(text, reply);
  }

 private:
  int from_specimens(const std::string& text, Reply& reply) {
    const Specimens specimens = read_specimens(text, input_);
    const auto free = free_of(specimens.material, free_);
    Eigen::Index rows = 0;
    for (const fem::HomogeneousTest& test : specimens.tests) rows += test.stretch.size();
    check_rows(rows, free);
    const auto identify = [&](const fem::MaterialParameters& start,
                              const std::vector<fem::HomogeneousTest>& tests, int starts) {
      const fem::MaterialResponses responses = [&](const auto& materials) {
        std::vector<Eigen::VectorXd> out;
        for (const auto& material : materials) out.push_back(fem::stresses(material, tests));
        return out;
      };
      return fem::identify(start, observed(tests), responses,
                           {.free = free,
                            .starts = starts,
                            .max_iterations = 100,
                            .progress = {.step = {}, .is_stopped = is_interrupted}});
    };
    std::vector<fem::HomogeneousTest> few;
    for (const fem::HomogeneousTest& test : specimens.tests)
      few.push_back(fem::thinned(test, kThinned));
    const fem::Identification rough = identify(specimens.material, few, kStarts);
    const fem::Identification found = identify(
        rough.response.size() > 0 ? rough.material : specimens.material, specimens.tests, 1);
    if (found.is_stopped) throw Interrupted("calibrate: nothing is kept");
    check_answer(found, "[material] has no answer to the tests",
                 "Start from other values: no state of the tests may be beyond the law.");
    const CalibrationAnswer answer(
        found, rows, "Pa",
        std::any_of(specimens.tests.begin(), specimens.tests.end(),
                    [](const auto& test) { return test.deviation > 0; }));
    std::string out =
        answer.heading() + fmt::format("[material]\nlaw = \"{}\"\n", found.material.law);
    const auto names = names_of(found.material);
    for (std::size_t i = 0; i < names.size(); ++i)
      if (std::isfinite(found.material.values[i]) &&
          std::count_if(names.begin(), names.end(),
                        [&](const auto& n) { return n.name == names[i].name; }) == 1)
        out += fmt::format("{} = {}\n", names[i].name,
                           in_toml(found.material.values[i], names[i].is_modulus));
    reply.json = answer.json();
    const Eigen::VectorXd at_start = fem::stresses(specimens.material, specimens.tests);
    if (at_start.size() > 0)
      reply.json["sum_of_squares_at_start"] =
          (at_start - observed(specimens.tests).value).squaredNorm();
    Eigen::Index at = 0;
    for (std::size_t t = 0; t < specimens.tests.size(); ++t) {
      const auto& test = specimens.tests[t];
      const Eigen::Index n = test.stretch.size();
      const double squares = (found.response.segment(at, n) - test.stress).squaredNorm();
      at += n;
      reply.json["tests"].push_back(
          {{"test", specimens.name[t]}, {"rows", n}, {"sum_of_squares", squares}});
      reply.text += fmt::format("{}: {} rows, rms {:.3g} Pa, largest stress {:.3g} Pa\n",
                                specimens.name[t], n, std::sqrt(squares / static_cast<double>(n)),
                                test.stress.lpNorm<Eigen::Infinity>());
    }
    return finish(answer, found, out, reply);
  }

  static fem::Observations observed(const std::vector<fem::HomogeneousTest>& tests) {
    fem::Observations out;
    for (std::size_t t = 0; t < tests.size(); ++t) {
      const Eigen::Index n = tests[t].stress.size(), before = out.value.size();
      out.value.conservativeResize(before + n), out.value.tail(n) = tests[t].stress;
      out.deviation.conservativeResize(before + n);
      out.deviation.tail(n).setConstant(tests[t].deviation);
      out.group.insert(out.group.end(), static_cast<std::size_t>(n), static_cast<int>(t));
    }
    return out;
  }

  int from_presses(const std::string& text, Reply& reply) {
    const Scene scene = open_scene(input_);
    check_choices(scene);
    const auto free = free_of(*scene.material, free_);
    Samples samples = read_samples(samples_);
    const Body body = prepare_body(scene, false);
    place(scene, body, samples);
    fem::PressedBody pressed(make_setup(scene, body), samples, samples_, job_count(jobs_));
    const Eigen::Index rows = pressed.observed().value.size();
    check_rows(rows, free);
    say("calibrate: {} rows of {} presses", rows, pressed.presses());
    ContentHash made_from;
    made_from.add(point_fingerprint(scene, body)).add_file(samples_).add(std::to_string(points_));
    const PressCache cache(output_, made_from.hex(), resume_, pressed);
    ConsoleProgress progress("calibrate");
    const fem::Identification found =
        fem::identify(pressed, *scene.material, {.free = free, .progress = progress.progress()});
    if (is_interrupted()) {
      cache.keep();
      throw Interrupted(
          fmt::format("calibrate: what is done is kept in {}; go on with --resume", cache.path()));
    }
    check_answer(found, "a press fails with the material that the search starts from",
                 "Start from another material, or leave out rows deeper than the body allows: "
                 "`palpate check` tries one.");
    const CalibrationAnswer answer(found, rows, "N",
                                   (pressed.observed().deviation.array() > 0).any());
    std::string whole = text;
    if (whole.starts_with(kHeading)) whole.erase(0, whole.find('\n') + 1);
    if (fs::absolute(output_).parent_path() != fs::absolute(input_).parent_path())
      for (const NewValue& named : absolute_files(whole, input_))
        whole = rewritten(whole, input_, {{named.section, named.key, quoted(named.value)}});
    whole = answer.heading() + rewritten(whole, input_, answer.values());
    parse_scene(whole, input_);  // what is written can be read
    reply.json = answer.json();
    reply.json["presses"] = pressed.presses();
    reply.json["simulated"] = pressed.simulated;
    reply.text = fmt::format("{} presses, {} simulated\n", pressed.presses(), pressed.simulated);
    const int status = finish(answer, found, whole, reply);
    cache.remove();
    return status;
  }

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
    if (points_ == 0 || points_ >= all) return;
    std::vector<char> is_used(static_cast<std::size_t>(all), 0);
    for (int i = 0; i < points_; ++i)
      is_used[static_cast<std::size_t>((2 * i + 1) * all / (2 * points_))] = 1;
    for (std::size_t row = 0; row < samples.status.size(); ++row)
      if (!is_used[static_cast<std::size_t>(samples.point[row])])
        samples.status[row] = RowStatus::not_reached;
  }

  void check_rows(Eigen::Index rows, const std::vector<std::size_t>& free) const {
    if (rows > static_cast<Eigen::Index>(free.size())) return;
    throw Error(input_,
                fmt::format("{} cannot tell {}", counted(rows, "row", "rows"),
                            counted(std::ssize(free), "parameter", "parameters")),
                "Give more rows, or fewer parameters by --free.");
  }
  void check_answer(const fem::Identification& found, const std::string& what,
                    const std::string& remedy) const {
    if (found.response.size() == 0) throw Error(input_, what, remedy);
  }

  int finish(const CalibrationAnswer& answer, const fem::Identification& found,
             const std::string& text, Reply& reply) const {
    write_file_atomically(output_, text);
    say("wrote {}", output_);
    reply.text += answer.in_words();
    for (const std::string& line : answer.not_told_apart()) warn("{}", line);
    if (found.is_converged) return kDone;
    say_failed("the search did not converge; the material is the best that it saw");
    return kSomeFailed;
  }

  std::string input_, samples_, free_, output_;
  int jobs_ = 0, points_ = 0;
  bool resume_ = false;
};

}  // namespace

std::unique_ptr<Command> declare_calibrate(Arguments& arguments) {
  return std::make_unique<Calibrate>(arguments);
}

}  // namespace palpate::tools
