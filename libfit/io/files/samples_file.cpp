#include "libfit/io/files/files.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "libfit/io/files/columns.hpp"

namespace palpate {

using namespace h5;

namespace {

constexpr std::array<std::string_view, 3> kGradeNames{"good", "fair", "poor"};

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
  f("recordings/grade", r.grade, {.names = kGradeNames});
  f("recordings/reasons", r.reasons);
}

std::string other_probe(std::size_t i) { return fmt::format("probe_{}/", i + 1); }

template <class Integer>
std::string row_name(Integer row) {
  return fmt::format("row {}", row);
}

void check_numbers(const Samples& s, const h5::Complain& complain) {
  check_finite(complain, "points/position", s.point_position);
  check_unit_length(complain, "points/normal", s.point_normal);
  if (!s.point_normal_gradient.allFinite())
    throw complain("points/normal_gradient", "is not finite");
  if (!s.point_sway.allFinite()) throw complain("points/sway", "is not finite");
  if (!s.point_scale.allFinite()) throw complain("points/scale", "is not finite");
  check_finite(complain, "rows/deflection", s.deflection);
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

void check_measured(const MeasuredRecordings& r, const Complain& complain) {
  if (!r.contact_m.allFinite()) throw complain("recordings/contact", "is not finite");
  if (!r.contact_deviation_m.allFinite() || (r.contact_deviation_m.array() < 0).any())
    throw complain("recordings/contact_deviation", "is not finite and positive");
}

void check(const Samples& s, const h5::Complain& complain) {
  RowChecker rows(complain);
  columns(s, rows);
  check_indices(complain, "rows/point", s.point.data(), s.rows(), 1, s.points());
  check_numbers(s, complain);
  check_experiments(s, complain);
  check_probes(s, complain);
  check_relaxation(complain, s.relaxation);
  check_measured(s.recordings, complain);
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

}  // namespace palpate
