#include "libfit/io/files/files.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "libfit/io/files/columns.hpp"

namespace palpate {

using namespace h5;

namespace {

// R: a kind of RecordingColumns, or const; false where the file has none. Refused ones, which
// signals have, may have no numbers.
template <class R, class F>
bool recording_columns(R& r, F& f, bool has_refused) {
  if (!f.first("recordings/experiment", r.experiment, {.is_optional = !has_refused})) return false;
  f("recordings/file", r.file);
  f("recordings/contact", r.contact_m, {"m", has_refused});
  f("recordings/contact_deviation", r.contact_deviation_m, {"m", has_refused});
  f("recordings/estimator", r.estimator);
  f("recordings/noise", r.noise_N, {"N", has_refused});
  f("recordings/grade", r.grade,
    {.names = {kRecordingGradeNames.data(), std::size_t{kRefusedGrade} + has_refused}});
  f("recordings/reasons", r.reasons);
  return true;
}

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
  if (!recording_columns(r, f, false)) return;
  f("recordings/hash", r.hash);
  f("recordings/speed", r.speed_m_s, {"m/s", true});
  f("recordings/hysteresis", r.hysteresis, {kNoUnit, true});
  f("recordings/young", r.young_Pa, {"Pa", true});
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
  if (std::ranges::any_of(s.recordings.contact_deviation_m, [](double m) { return m < 0; }))
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

// S: RecordedSignals or const RecordedSignals.
template <class S, class F>
void signal_columns(S& s, F& f) {
  recording_columns(s, f, true);
  f("recordings/point", s.point);
  f("recordings/bias", s.bias_N, {"N"});
  f("recordings/drift", s.drift_N_m, {"N/m"});
  f("recordings/readings", s.readings);

  f.first("readings/time", s.time_s, {"s", true});
  f("readings/travel", s.travel_m, {"m"});
  f("readings/push", s.push_N, {"N"});
  f("readings/phase", s.phase, {.names = kPhaseNames});
  f("readings/is_used", s.is_used);
}

void check(const RecordedSignals& s, const Complain& complain) {
  ColumnChecker rows(complain);
  signal_columns(s, rows);
  std::int64_t all = 0;
  for (const std::int32_t own : s.readings) {
    if (own < 0) throw complain("recordings/readings", "is negative");
    all += own;
  }
  if (all != std::ssize(s.push_N))
    throw complain("recordings/readings", "do not add up to the rows of readings/push");
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

RecordedSignals read_signals(const std::filesystem::path& path) {
  const h5::Reader reader = h5::open(path, kSignalsSchema);
  RecordedSignals signals;
  ColumnReader in(reader);
  signal_columns(signals, in);
  check(signals, complain_about(reader));
  return signals;
}

void write_signals(const std::filesystem::path& path, const RecordedSignals& signals,
                   const Attributes& attributes) {
  check(signals, complain_about(path));
  h5::Writer writer = h5::create(path, kSignalsSchema, attributes);
  ColumnWriter out(writer);
  signal_columns(signals, out);
  writer.commit();
}

}  // namespace palpate
