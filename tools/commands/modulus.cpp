#include <algorithm>
#include <cmath>
#include <filesystem>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/io/vtu.hpp"
#include "libfit/recordings/batch/plausible.hpp"
#include "libfit/recordings/indentation/fit_model.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"
#include "tools/manifest/manifest.hpp"
#include "tools/report/contents.hpp"
#include "tools/report/page.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;
using namespace recordings;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kFairDeviation = 0.1, kPoorDeviation = 0.3;  // of the modulus
constexpr double kMuchBetter = 10;  // bic by which a free exponent beats the tip's models
constexpr double kContactsApart = 3, kContactShare = 0.02;   // deviations, and of the depth
constexpr double kRadiiOfBall = 1;                           // deep: fair; by the whole ball: poor
constexpr double kOtherExponent = 0.2, kNoSuchExponent = 1;  // off the tip's own
constexpr std::array<const char*, 3> kGrades{"good", "fair", "poor"};
constexpr std::array<std::string_view, 19> kColumns{"file",       "point",
                                                    "x_m",        "y_m",
                                                    "z_m",        "model",
                                                    "young_Pa",   "young_deviation_Pa",
                                                    "contact_m",  "contact_deviation_m",
                                                    "baseline_N", "depth_m",
                                                    "force_N",    "rms_N",
                                                    "exponent",   "exponent_deviation",
                                                    "grade",      "reasons",
                                                    "others"};
constexpr std::array<std::string_view, 14> kModelColumns{"file",
                                                         "point",
                                                         "model",
                                                         "young_Pa",
                                                         "young_deviation_Pa",
                                                         "contact_m",
                                                         "contact_deviation_m",
                                                         "baseline_N",
                                                         "exponent",
                                                         "exponent_deviation",
                                                         "rms_N",
                                                         "misfit_N",
                                                         "bic",
                                                         "remark"};

// A number, or an empty field where there is none.
void put(CsvWriter& csv, double value) {
  if (std::isfinite(value))
    csv.number(value);
  else
    csv.text("");
}

// One recording, or an item that gave none.
struct ModulusRow {
  std::string file, point;
  std::optional<Vec3> position_m;
  Indentation press;
  ModelFitOptions options;
  std::vector<ModelFit> fits;
  std::optional<std::size_t> best;
  int grade = 0;
  bool is_refused = false;
  std::vector<std::string> reasons;
  FoundContact contact;  // of the recording, before any model of the press
  Eigen::VectorXd travel_m, push_N;
  SignalTrace trace;
};

constexpr NamedOutput kBeside[] = {
    {".models.csv", "file,point,model"}, {".vtu", "vtu"}, {".html", kPageKind}};

class Modulus final : public Command {
 public:
  explicit Modulus(Arguments& arguments) {
    arguments.positional("manifest", manifest_,
                         "Manifest of the recordings and how to read them, manifest.toml");
    arguments.output("-o,--output", output_,
                     "Table to write, moduli.csv, with .models.csv, .vtu and .html beside it",
                     {"file,point,x_m"});
    arguments.named_outputs(output_, kBeside);
    arguments.option(
        "--models NAMES", models_,
        "Models to fit, with commas between (docs/method-recordings.md, section 22); without, all "
        "that the tip allows");
    arguments.option("--jobs", jobs_,
                     "Number of threads; 0 uses all cores; results do not depend on it");
    arguments.flag("--drop-invalid", drop_invalid_,
                   "Leave out rows that are not numbers or go back in time, and count them");
  }

  int run(Reply& reply) override {
    const std::vector<std::string> names = names_of(models_);
    Manifest manifest = read_manifest(manifest_);
    std::erase_if(manifest.items,
                  [](const BatchItem& item) { return item.signal.kind != ExperimentKind::press; });
    if (manifest.items.empty())
      throw Error(manifest_, "names no press", "Moduli come from recordings of kind = \"press\".");
    for (BatchItem& item : manifest.items) {
      item.read.drop_invalid |= drop_invalid_;
      item.signal.keeps_way_in = true;
    }
    ConsoleProgress progress("modulus");
    BatchOptions batch;
    batch.jobs = job_count(jobs_);
    if (manifest.motion) batch.body_from_rig = *manifest.motion;
    const auto results = run_batch(manifest.items, batch, progress.progress());
    if (progress.progress().stopped()) throw Interrupted("modulus: nothing was written");
    std::vector<ModulusRow> rows = rows_of(manifest, results);
    std::vector<ModelFitTask> tasks;
    for (const ModulusRow& row : rows)
      tasks.push_back({&row.travel_m, &row.push_N, row.press, row.options});
    auto fits = fit_all(tasks, names, job_count(jobs_));
    std::size_t failed = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      rows[i].fits = std::move(fits[i]);
      judge(rows[i]);
      failed += !rows[i].best;
    }
    write_all(rows);
    report(rows);
    if (failed == rows.size())
      throw Error(manifest_, "none of its recordings has a modulus", "See the list above.");
    reply.json = nlohmann::ordered_json{{"recordings", rows.size()}, {"without_modulus", failed}};
    return failed > 0 ? kSomeFailed : kDone;
  }

 private:
  static std::vector<std::string> names_of(const std::string& text) {
    std::vector<std::string> names;
    for (std::size_t begin = 0; begin <= text.size() && !text.empty();) {
      const std::size_t end = std::min(text.find(',', begin), text.size());
      const std::string name = text.substr(begin, end - begin);
      std::vector<std::string> known;
      for (const auto& model : indentation_models()) known.emplace_back(model.name);
      if (!indentation_model_named(name))
        throw Error("--models", "there is no model \"" + name + "\"",
                    "Use any of: " + listed(known) + ".");
      if (std::ranges::count(names, name) > 0)
        throw Error("--models", "names " + name + " twice", "Name every model once.");
      names.push_back(name);
      begin = end + 1;
    }
    return names;
  }

  static ModelFitOptions options_of(const SignalSettings& signal) {
    ModelFitOptions options;
    if (signal.known_contact) options.contact_m = signal.known_contact->travel_m;
    options.has_slope = signal.drift == Drift::line;
    options.force_share = signal.contact_range;
    return options;
  }

  static std::vector<ModulusRow> rows_of(const Manifest& manifest,
                                         const std::vector<ItemResult>& results) {
    std::vector<ModulusRow> rows;
    const auto questions = question_stiffness(manifest.items, results);
    for (std::size_t i = 0; i < results.size(); ++i) {
      const BatchItem& item = manifest.items[i];
      const auto refuse = [&](const std::string& name, const Failure& failure,
                              const SignalTrace& trace) {
        ModulusRow row;
        row.file = item.shown + (name.empty() ? "" : "#" + name);
        row.point = point_of(item, name);
        row.is_refused = true;
        row.reasons = {failure.what + (failure.what.ends_with('?') ? " " : ". ") + failure.remedy};
        row.trace = trace;
        rows.push_back(std::move(row));
      };
      if (results[i].failure) refuse("", *results[i].failure, results[i].trace);
      for (const Refused& refused : results[i].refused)
        refuse(refused.name, refused.failure, refused.trace);
      for (std::size_t k = 0; k < results[i].recordings.size(); ++k) {
        const Conditioned& r = results[i].recordings[k];
        if (questions[i][k]) {
          refuse(r.name, *questions[i][k], r.trace);
          continue;
        }
        ModulusRow row;
        row.file = item.shown + (r.name.empty() ? "" : "#" + r.name);
        row.point = point_of(item, r.name);
        if (item.position_m)
          row.position_m = item.position_m;
        else if (r.contact_m)
          row.position_m = manifest.motion ? (*manifest.motion)(*r.contact_m) : *r.contact_m;
        const SignalSettings& s = item.signal;
        row.press = {s.tip, r.source.tip_radius_m, s.half_angle_rad, s.thickness_m, s.poisson};
        row.options = options_of(s);
        row.travel_m = r.way_in.travel_m, row.push_N = r.way_in.push_N;
        row.trace = r.trace;
        row.grade = static_cast<int>(r.grade), row.reasons = r.reasons;
        row.contact = r.contact;
        rows.push_back(std::move(row));
      }
    }
    return rows;
  }

  static void judge(ModulusRow& row) {
    if (row.is_refused) return;
    const auto note = [&](int least, const std::string& reason) {
      row.grade = std::max(row.grade, least);
      if (!reason.empty()) row.reasons.push_back(reason);
    };
    row.best = best_model(row.fits);
    if (!row.best) {
      const Tip tip = row.press.tip;
      const bool is_round = tip == Tip::sphere || tip == Tip::flat;
      const bool is_known = (is_round ? row.press.radius_m : row.press.half_angle_rad) > 0;
      return note(2, is_known ? "no model finds a contact"
                              : std::string("no model speaks of a tip without ") +
                                    (is_round ? "radius" : "half_angle") + ": say it in `probe`");
    }
    ModelFit& fit = row.fits[*row.best];
    fit.young_deviation_Pa = chosen_deviation_Pa(row.fits, *row.best);
    note(fit.misfit_N > 0.05 * fit.force_N ? 2 : fit.remark.empty() ? 0 : 1, fit.remark);
    const double deviation = fit.young_deviation_Pa / fit.young_Pa;
    if (deviation > kFairDeviation)
      note(deviation > kPoorDeviation ? 2 : 1, "the modulus is uncertain by " + percent(deviation));
    if (fit.contact_m < row.travel_m.minCoeff()) note(1, "begins in contact");
    if (const double radii = fit.depth_m / row.press.radius_m;
        row.press.tip == Tip::sphere && radii > kRadiiOfBall)
      note(radii > 2 * kRadiiOfBall ? 2 : 1,
           fmt::format("the ball went in by {:.3g} of its radii: is `probe` right?", radii));
    const double apart_m = std::abs(fit.contact_m - row.contact.travel_m),
                 either_m = std::hypot(fit.contact_deviation_m, row.contact.deviation_m);
    if (apart_m > kContactsApart * either_m && apart_m > kContactShare * fit.depth_m)
      note(1,
           fmt::format("the model's contact lies {} from that of the onset, which are known to {}",
                       millimetres(apart_m), millimetres(either_m)));
    const ModelFit& last = row.fits.back();
    const double tip_exponent = row.press.tip == Tip::sphere ? 1.5
                                : row.press.tip == Tip::flat ? 1.0
                                                             : 2.0;
    const double off = std::abs(last.exponent - tip_exponent);
    if (!last.model->law && last.bic + kMuchBetter < fit.bic && off > kOtherExponent)
      note(off > kNoSuchExponent ? 2 : 1,
           fmt::format("the force rises as depth to the {:.2f} +- {:.2g}, the tip's models have {}",
                       last.exponent, last.exponent_deviation, tip_exponent));
  }

  void write_all(const std::vector<ModulusRow>& rows) const {
    CsvWriter csv(output_, kColumns), models(beside(".models.csv"), kModelColumns);
    for (const ModulusRow& row : rows) {
      ModelFit none;
      for (double* value :
           {&none.young_Pa, &none.young_deviation_Pa, &none.contact_m, &none.contact_deviation_m,
            &none.baseline_N, &none.depth_m, &none.force_N, &none.rms_N})
        *value = kNan;
      const ModelFit& fit = row.best ? row.fits[*row.best] : none;
      const bool has_power = !row.fits.empty() && !row.fits.back().model->law;
      csv.text(row.file).text(row.point);
      for (int k = 0; k < 3; ++k) put(csv, row.position_m ? (*row.position_m)[k] : kNan);
      csv.text(row.best ? fit.model->name : "");
      for (const double value : {fit.young_Pa, fit.young_deviation_Pa, fit.contact_m,
                                 fit.contact_deviation_m, fit.baseline_N, fit.depth_m, fit.force_N,
                                 fit.rms_N, has_power ? row.fits.back().exponent : kNan,
                                 has_power ? row.fits.back().exponent_deviation : kNan})
        put(csv, value);
      std::string others;
      for (const ModelFit& other : row.fits)
        if (other.model->law && &other != &fit)
          others += fmt::format("{}{} {:.4g} Pa (bic +{:.3g})", others.empty() ? "" : "; ",
                                other.model->name, other.young_Pa, other.bic - fit.bic);
      csv.text(grade_of(row)).text(listed(row.reasons, "; ")).text(others);
      csv.end_row();
      for (const ModelFit& each : row.fits) {
        models.text(row.file).text(row.point).text(each.model->name);
        const bool is_power = !each.model->law;
        for (const double value :
             {each.young_Pa, each.young_deviation_Pa, each.contact_m, each.contact_deviation_m,
              each.baseline_N, is_power ? each.exponent : kNan,
              is_power ? each.exponent_deviation : kNan, each.rms_N, each.misfit_N, each.bic})
          put(models, value);
        models.text(each.remark).end_row();
      }
    }
    csv.commit(), models.commit();
    write_pictures(rows);
  }

  void write_pictures(const std::vector<ModulusRow>& rows) const {
    std::vector<RecordingPicture> pictures;
    Surface cloud;
    std::vector<double> young, deviation, depth;
    std::vector<char> grade;
    std::vector<Vec3> places;
    for (const ModulusRow& row : rows) {
      pictures.push_back(picture_of(row));
      if (!row.best || !row.position_m) continue;
      const ModelFit& fit = row.fits[*row.best];
      places.push_back(*row.position_m);
      young.push_back(fit.young_Pa), deviation.push_back(fit.young_deviation_Pa);
      depth.push_back(fit.depth_m), grade.push_back(static_cast<char>(row.grade));
    }
    if (find_page())
      write_page(beside(".html"), contents_of_moduli(manifest_, pictures));
    else
      warn("{} was not written: the page is not built (Node.js)", beside(".html").string());
    if (places.empty()) return;
    cloud.vertices.resize(static_cast<Eigen::Index>(places.size()), 3);
    for (std::size_t i = 0; i < places.size(); ++i)
      cloud.vertices.row(static_cast<Eigen::Index>(i)) = places[i];
    VtuWriter vtu;
    vtu.add("young_Pa", 1, young), vtu.add("young_deviation_Pa", 1, deviation);
    vtu.add("depth_m", 1, depth), vtu.add("grade", 1, grade);
    write_file_atomically(beside(".vtu"), vtu.text(cloud, "young_Pa"));
  }

  static RecordingPicture picture_of(const ModulusRow& row) {
    RecordingPicture p;
    p.signal.file = row.file, p.signal.point = row.point;
    p.signal.grade = row.is_refused ? kRefusedGrade : static_cast<std::int8_t>(row.grade);
    p.signal.reasons = listed(row.reasons, "; ");
    p.signal.trace = row.trace;
    p.young_Pa = p.young_deviation_Pa = kNan;
    p.position_m = row.position_m;
    if (!row.best) return p;
    const ModelFit& fit = row.fits[*row.best];
    p.model = fit.model->name;
    p.signal.contact_m = fit.contact_m, p.signal.contact_deviation_m = fit.contact_deviation_m;
    p.young_Pa = fit.young_Pa, p.young_deviation_Pa = fit.young_deviation_Pa;
    SignalTrace& t = p.signal.trace;
    t.bias_N = fit.baseline_N - fit.slope_N_m * fit.contact_m, t.drift_N_m = fit.slope_N_m;
    const Eigen::VectorXd travel_m = Eigen::Map<const Eigen::VectorXf>(
                                         t.travel_m.data(), static_cast<Eigen::Index>(t.readings()))
                                         .cast<double>();
    const Eigen::VectorXd push_N = model_push_N(fit, row.press, travel_m);
    for (std::size_t i = 0; i < t.readings(); ++i)
      p.fitted_N.push_back(static_cast<float>(push_N[static_cast<Eigen::Index>(i)] - t.bias_N -
                                              t.drift_N_m * t.travel_m[i]));
    return p;
  }

  static std::string grade_of(const ModulusRow& row) {
    return row.is_refused ? "refused" : kGrades[static_cast<std::size_t>(row.grade)];
  }

  // "out/moduli.csv" -> "out/moduli.vtu"
  fs::path beside(const char* extension) const {
    const fs::path output(output_);
    return output.parent_path() / (output.stem().string() + extension);
  }

  void report(const std::vector<ModulusRow>& rows) const {
    constexpr std::size_t kListed = 20;
    std::size_t shown = 0;
    for (const ModulusRow& row : rows) {
      if (++shown > kListed) break;
      if (!row.best) {
        say_failed("  {}: {}: {}", row.file, grade_of(row), listed(row.reasons, "; "));
        continue;
      }
      const ModelFit& fit = row.fits[*row.best];
      say("  {}: {:.4g} +- {:.2g} Pa ({}), contact {:.4g} +- {:.2g} um, {}{}{}", row.file,
          fit.young_Pa, fit.young_deviation_Pa, fit.model->name, 1e6 * fit.contact_m,
          1e6 * fit.contact_deviation_m, grade_of(row), row.reasons.empty() ? "" : ": ",
          listed(row.reasons, "; "));
    }
    if (rows.size() > kListed) say("  and {} more recordings", rows.size() - kListed);
    say("wrote {}; {} shows every recording", output_, beside(".html").string());
  }

  std::string manifest_, output_, models_;
  int jobs_ = 0;
  bool drop_invalid_ = false;
};

}  // namespace

std::unique_ptr<Command> declare_modulus(Arguments& arguments) {
  return std::make_unique<Modulus>(arguments);
}

}  // namespace palpate::tools
