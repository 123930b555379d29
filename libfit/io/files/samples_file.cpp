#include "libfit/io/files/files.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "libfit/io/files/columns.hpp"

namespace palpate {

using namespace h5;

namespace {

// S: Samples or const Samples.
template <class S, class F>
void columns(S& s, F& f) {
  const auto of_group = [&s, &f](const char* first) {
    return [&s, &f, first](const char* name, auto column, const ColumnFormat& format, auto...) {
      if (std::string_view(name) == first)
        f.first(name, s.*column, format);
      else
        f(name, s.*column, format);
    };
  };
  each_point_column(of_group("points/position"));
  each_row_column(of_group("rows/point"));

  relaxation_columns(s.relaxation, f);

  auto& r = s.recordings;
  if (!f.first("recordings/experiment", r.experiment, {.is_optional = true})) return;
  f("recordings/file", r.file);
  f("recordings/hash", r.hash);
  f("recordings/contact", r.contact_m, {"m"});
  f("recordings/contact_deviation", r.contact_deviation_m, {"m"});
  f("recordings/estimator", r.estimator);
  f("recordings/speed", r.speed_m_s, {"m/s", true});
  f("recordings/noise", r.noise_N, {"N"});
  f("recordings/hysteresis", r.hysteresis, {kNoUnit, true});
  f("recordings/young", r.young_Pa, {"Pa", true});
  f("recordings/grade", r.grade, {.names = {kRecordingGradeNames.data(), kRefusedGrade}});
  f("recordings/reasons", r.reasons);
}

std::string other_probe(std::size_t i) { return fmt::format("probe_{}/", i + 1); }

std::string row_name(std::int64_t row) { return fmt::format("row {}", row); }

void check_numbers(const Samples& s, const h5::Complain& complain) {
  check_unit_length(complain, "points/normal", s.point_normal);
  for (Eigen::Index i = 0; i < s.rows(); ++i) {
    const bool is_good = s.status[i] == RowStatus::good;
    if (is_good && !s.force.row(i).allFinite())
      throw complain("rows/force", row_name(i) + " is good but not a finite number");
    if (is_good && !s.torque.row(i).allFinite())
      throw complain("rows/torque", row_name(i) + " is good but not a finite number");
    if (!(s.lean_at(i).norm() < 1))
      throw complain("rows/lean", row_name(i) + " is not shorter than 1");
    if (s.force_error[i] < 0) throw complain("rows/force_error", row_name(i) + " is negative");
    if (s.time_s.size() == 0 || std::isnan(s.time_s[i])) continue;
    const bool is_first = i == 0 || s.experiment[i] != s.experiment[i - 1];
    const bool is_next_tool = s.tool_of(i) > 0;
    if (!(s.time_s[i] >= 0) || !std::isfinite(s.time_s[i]) ||
        (!is_first && !is_next_tool && !(s.time_s[i] > s.time_s[i - 1])))
      throw complain("rows/time", row_name(i) + " does not come after the row before");
  }
}

// Rows of an experiment follow one another and share kind and, tool by tool, place.
void check_experiments(const Samples& s, const h5::Complain& complain) {
  std::unordered_set<std::int32_t> finished;
  std::vector<std::int32_t> place;  // of each tool of the experiment
  for (std::size_t i = 0; i < s.point.size(); ++i) {
    if (i > 0 && s.experiment[i] != s.experiment[i - 1]) {
      finished.insert(s.experiment[i - 1]);
      place.clear();
      if (finished.count(s.experiment[i]) != 0)
        throw complain("rows/experiment",
                       fmt::format("{} goes back to experiment {}", row_name(i), s.experiment[i]));
    }
    const int tool = s.tool_of(i), before = i > 0 && !place.empty() ? s.tool_of(i - 1) : -1;
    if (tool != 0 && tool != before + 1)
      throw complain("rows/tool", row_name(i) + " does not follow the tool before");
    if (static_cast<std::size_t>(tool) == place.size()) place.push_back(s.point[i]);
    if (s.point[i] != place[tool] || (before >= 0 && s.kind[i] != s.kind[i - 1]))
      throw complain("rows/experiment", fmt::format("{} changes point or kind within experiment {}",
                                                    row_name(i), s.experiment[i]));
  }
}

// Rows name probes that the file has.
void check_probes(const Samples& s, const h5::Complain& complain) {
  const auto others = static_cast<std::int32_t>(s.other_probes.size());
  for (std::size_t i = 0; i < s.probe_number.size(); ++i) {
    if (s.probe_number[i] < 0 || s.probe_number[i] > others)
      throw complain("rows/probe", row_name(i) + " names a probe that the file does not have");
    if (i > 0 && s.experiment[i] == s.experiment[i - 1] &&
        s.probe_number[i] != s.probe_number[i - 1])
      throw complain("rows/probe", row_name(i) + " changes the probe within an experiment");
  }
  for (std::size_t i = 0; i < s.kind.size(); ++i)
    if ((s.kind[i] == ExperimentKind::other) != (s.probe_of(i) > 0))
      throw complain("rows/probe", row_name(i) +
                                       " of kind `other` is of the samples' own probe, "
                                       "or the other way round");
}

void check(const Samples& s, const h5::Complain& complain) {
  ColumnChecker all(complain);
  columns(s, all);
  check_indices(complain, "rows/point", s.point, s.points());
  check_numbers(s, complain);
  check_experiments(s, complain);
  check_probes(s, complain);
  check_relaxation(complain, s.relaxation);
  if ((s.recordings.contact_deviation_m.array() < 0).any())
    throw complain("recordings/contact_deviation", "is negative");
}

// S: Samples or const Samples.
template <class S, class F>
void surface_columns(S& s, F& f) {
  f.first("rows/point", s.point);
  f("rows/experiment", s.experiment);
  f("rows/step", s.step);
  f("rows/displacement", s.surface, {"m"});
}

// R recordings and the N readings of all of them, one recording's after another's.
struct SignalColumns {
  std::vector<std::string> file, point, reasons, estimator;                    // R
  std::vector<std::int32_t> experiment, readings;                              // R
  std::vector<std::int8_t> grade;                                              // R
  Eigen::VectorXd contact_m, contact_deviation_m, noise_N, bias_N, drift_N_m;  // R
  Eigen::VectorXd time_s, travel_m, push_N;                                    // N
  std::vector<std::int8_t> phase;                                              // N
  std::vector<char> is_used;                                                   // N
};

// C: SignalColumns or const SignalColumns.
template <class C, class F>
void signal_columns(C& c, F& f) {
  f.first("recordings/file", c.file);
  f("recordings/point", c.point);
  f("recordings/experiment", c.experiment);
  f("recordings/grade", c.grade, {.names = kRecordingGradeNames});
  f("recordings/reasons", c.reasons);
  f("recordings/estimator", c.estimator);
  f("recordings/contact", c.contact_m, {"m", true});
  f("recordings/contact_deviation", c.contact_deviation_m, {"m", true});
  f("recordings/noise", c.noise_N, {"N", true});
  f("recordings/bias", c.bias_N, {"N"});
  f("recordings/drift", c.drift_N_m, {"N/m"});
  f("recordings/readings", c.readings);

  f.first("readings/time", c.time_s, {"s", true});
  f("readings/travel", c.travel_m, {"m"});
  f("readings/push", c.push_N, {"N"});
  f("readings/phase", c.phase, {.names = kPhaseNames});
  f("readings/is_used", c.is_used);
}

void check(const SignalColumns& c, const Complain& complain) {
  ColumnChecker rows(complain);
  signal_columns(c, rows);
  std::int64_t all = 0;
  for (const std::int32_t own : c.readings) {
    if (own < 0) throw complain("recordings/readings", "is negative");
    all += own;
  }
  if (all != c.push_N.size())
    throw complain("recordings/readings", "do not add up to the rows of readings/push");
}

SignalColumns columns_of(const std::vector<RecordedSignal>& signals) {
  SignalColumns c;
  Eigen::Index all = 0, row = 0, at = 0;
  for (const RecordedSignal& s : signals) all += static_cast<Eigen::Index>(s.trace.readings());
  for (Eigen::VectorXd* column :
       {&c.contact_m, &c.contact_deviation_m, &c.noise_N, &c.bias_N, &c.drift_N_m})
    column->resize(static_cast<Eigen::Index>(signals.size()));
  for (Eigen::VectorXd* column : {&c.time_s, &c.travel_m, &c.push_N}) column->resize(all);
  for (const RecordedSignal& s : signals) {
    const SignalTrace& t = s.trace;
    c.file.push_back(s.file), c.point.push_back(s.point), c.reasons.push_back(s.reasons);
    c.estimator.push_back(s.estimator), c.experiment.push_back(s.experiment);
    c.grade.push_back(s.grade);
    c.readings.push_back(static_cast<std::int32_t>(t.readings()));
    c.contact_m[row] = s.contact_m, c.contact_deviation_m[row] = s.contact_deviation_m;
    c.noise_N[row] = s.noise_N, c.bias_N[row] = t.bias_N, c.drift_N_m[row] = t.drift_N_m;
    ++row;
    std::ranges::copy(t.time_s, c.time_s.begin() + at);
    std::ranges::copy(t.travel_m, c.travel_m.begin() + at);
    std::ranges::copy(t.push_N, c.push_N.begin() + at);
    c.phase.insert(c.phase.end(), t.phase.begin(), t.phase.end());
    c.is_used.insert(c.is_used.end(), t.is_used.begin(), t.is_used.end());
    at += static_cast<Eigen::Index>(t.readings());
  }
  return c;
}

}  // namespace

Samples read_samples(const std::filesystem::path& path) {
  const h5::Reader reader = h5::open(path, kSamplesSchema);
  Samples s;
  ColumnReader in(reader);
  columns(s, in);
  s.probe = read_probe(reader);
  while (auto other = read_probe(reader, other_probe(s.other_probes.size())))
    s.other_probes.push_back(*std::move(other));
  if (reader.has("body/poisson"))
    s.poisson = reader.numbers("body/poisson", kNoUnit, {1, 0}).front();
  check(s, complain_about(reader));
  return s;
}

void write_samples(const std::filesystem::path& path, const Samples& s,
                   const Attributes& attributes) {
  check(s, h5::complain_about(path));
  h5::Writer writer = h5::create(path, kSamplesSchema, attributes);
  ColumnWriter out(writer);
  columns(s, out);
  write_probe(writer, s.probe, complain_about(path));
  for (std::size_t i = 0; i < s.other_probes.size(); ++i)
    write_probe(writer, s.other_probes[i], complain_about(path), other_probe(i));
  if (!std::isnan(s.poisson)) writer.numbers("body/poisson", h5::kNoUnit, &s.poisson, {1, 0});
  writer.commit();
}

std::filesystem::path surface_path(std::filesystem::path samples_path) {
  return samples_path.replace_extension(".surface.h5");
}

void read_surface_motion(const std::filesystem::path& path, Samples& samples) {
  const h5::Reader reader = h5::open(path, kSurfaceSchema);
  Samples stored;
  ColumnReader in(reader);
  surface_columns(stored, in);
  if (stored.point != samples.point || stored.experiment != samples.experiment ||
      stored.step != samples.step)
    throw reader.error("rows", "are not those of the samples beside it");
  if (stored.surface.cols() % 3 != 0)
    throw reader.error("rows/displacement", "has no three columns a vertex");
  samples.surface = std::move(stored.surface);
}

void write_surface_motion(const std::filesystem::path& path, const Samples& samples,
                          const Attributes& attributes) {
  const h5::Complain complain = h5::complain_about(path);
  if (samples.surface.rows() != samples.rows() || samples.surface.cols() % 3 != 0)
    throw complain("rows/displacement", "has no row of three columns a vertex for each row");
  if (!samples.surface.allFinite()) throw complain("rows/displacement", "is not finite");
  h5::Writer writer = h5::create(path, kSurfaceSchema, attributes);
  ColumnWriter out(writer);
  surface_columns(samples, out);
  writer.commit();
}

std::filesystem::path signals_path(std::filesystem::path samples_path) {
  return samples_path.replace_extension(".signals.h5");
}

std::vector<RecordedSignal> read_signals(const std::filesystem::path& path) {
  const h5::Reader reader = h5::open(path, kSignalsSchema);
  SignalColumns c;
  ColumnReader in(reader);
  signal_columns(c, in);
  check(c, complain_about(reader));
  std::vector<RecordedSignal> signals(c.file.size());
  Eigen::Index at = 0;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    RecordedSignal& s = signals[i];
    s = {c.file[i],      c.point[i],     c.experiment[i],          c.grade[i],   c.reasons[i],
         c.estimator[i], c.contact_m[i], c.contact_deviation_m[i], c.noise_N[i], {}};
    s.trace.bias_N = c.bias_N[i], s.trace.drift_N_m = c.drift_N_m[i];
    for (const Eigen::Index end = at + c.readings[i]; at < end; ++at) {
      s.trace.time_s.push_back(static_cast<float>(c.time_s[at]));
      s.trace.travel_m.push_back(static_cast<float>(c.travel_m[at]));
      s.trace.push_N.push_back(static_cast<float>(c.push_N[at]));
      s.trace.phase.push_back(c.phase[at]);
      s.trace.is_used.push_back(c.is_used[at]);
    }
  }
  return signals;
}

void write_signals(const std::filesystem::path& path, const std::vector<RecordedSignal>& signals,
                   const Attributes& attributes) {
  const SignalColumns c = columns_of(signals);
  check(c, complain_about(path));
  h5::Writer writer = h5::create(path, kSignalsSchema, attributes);
  ColumnWriter out(writer);
  signal_columns(c, out);
  writer.commit();
}

}  // namespace palpate
