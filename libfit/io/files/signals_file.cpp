#include "libfit/io/files/files.hpp"

#include <algorithm>

#include "libfit/core/error.hpp"
#include "libfit/io/files/columns.hpp"

namespace palpate {

using namespace h5;

namespace {

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
void columns(C& c, F& f) {
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
  RowChecker rows(complain);
  columns(c, rows);
  check_flags(complain, "readings/is_used", c.is_used);
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

std::filesystem::path signals_path(std::filesystem::path samples_path) {
  return samples_path.replace_extension(".signals.h5");
}

std::vector<RecordedSignal> read_signals(const std::filesystem::path& path) {
  const h5::Reader reader = h5::open(path, kSignalsSchema);
  SignalColumns c;
  ColumnReader in(reader);
  columns(c, in);
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
  columns(c, out);
  writer.commit();
}

}  // namespace palpate
