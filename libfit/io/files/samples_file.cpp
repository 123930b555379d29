#include "libfit/io/files/files.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "libfit/io/files/columns.hpp"

namespace palpate {

using namespace h5;

namespace {

constexpr std::array<std::string_view, 3> kKindNames{"press", "drag", "path"};

std::size_t rows_of(const Samples& samples) { return samples.point.size(); }

template <class Integer>
std::string row_name(Integer row) {
  return fmt::format("row {}", row);
}

void check_sizes(const Samples& s, const h5::Complain& complain) {
  const Eigen::Index points = s.points(), rows = static_cast<Eigen::Index>(rows_of(s));
  const auto size = [](const auto& column) { return static_cast<Eigen::Index>(column.size()); };
  check_rows(complain, "points/normal", s.point_normal.rows(), points);
  check_rows(complain, "points/name", size(s.point_name), points);
  if (s.point_normal_gradient.rows() != 0)
    check_rows(complain, "points/normal_gradient", s.point_normal_gradient.rows(), points);
  check_rows(complain, "rows/experiment", size(s.experiment), rows);
  check_rows(complain, "rows/kind", size(s.kind), rows);
  check_rows(complain, "rows/step", size(s.step), rows);
  check_rows(complain, "rows/deflection", s.deflection.rows(), rows);
  check_rows(complain, "rows/force", s.force.rows(), rows);
  check_rows(complain, "rows/torque", s.torque.rows(), rows);
  check_rows(complain, "rows/force_error", s.force_error.size(), rows);
  check_rows(complain, "rows/status", size(s.status), rows);
  if (!s.doubt.empty()) check_rows(complain, "rows/doubt", size(s.doubt), rows);
}

void check_numbers(const Samples& s, const h5::Complain& complain) {
  check_finite(complain, "points/position", s.point_position);
  check_unit_length(complain, "points/normal", s.point_normal);
  if (!s.point_normal_gradient.allFinite())
    throw complain("points/normal_gradient", "is not finite");
  check_finite(complain, "rows/deflection", s.deflection);
  for (Eigen::Index i = 0; i < s.rows(); ++i) {
    const bool is_good = s.status[static_cast<std::size_t>(i)] == RowStatus::good;
    if (is_good && !s.force.row(i).allFinite())
      throw complain("rows/force", row_name(i) + " is good but not a finite number");
    if (is_good && !s.torque.row(i).allFinite())
      throw complain("rows/torque", row_name(i) + " is good but not a finite number");
    if (s.force_error[i] < 0) throw complain("rows/force_error", row_name(i) + " is negative");
  }
}

// Rows of an experiment follow one another and share point and kind.
void check_experiments(const Samples& s, const h5::Complain& complain) {
  std::unordered_set<std::int32_t> finished;
  for (std::size_t i = 1; i < rows_of(s); ++i) {
    if (s.experiment[i] != s.experiment[i - 1]) {
      finished.insert(s.experiment[i - 1]);
      if (finished.count(s.experiment[i]) != 0)
        throw complain("rows/experiment",
                       fmt::format("{} goes back to experiment {}", row_name(i), s.experiment[i]));
    } else if (s.point[i] != s.point[i - 1] || s.kind[i] != s.kind[i - 1]) {
      throw complain("rows/experiment", fmt::format("{} changes point or kind within experiment {}",
                                                    row_name(i), s.experiment[i]));
    }
  }
}

const std::vector<std::string> kGradeNames{"good", "fair", "poor"};

// The optional group `recordings`: empty when the file has none.
MeasuredRecordings read_measured(const Reader& reader) {
  MeasuredRecordings r;
  if (!reader.has("recordings/experiment")) return r;
  r.experiment = reader.integers("recordings/experiment", kNoUnit, {kAny, 0});
  const std::size_t rows = r.size();
  r.file = reader.strings("recordings/file", rows);
  r.hash = reader.strings("recordings/hash", rows);
  r.contact_m = read_vector(reader, "recordings/contact", "m", rows);
  r.contact_deviation_m = read_vector(reader, "recordings/contact_deviation", "m", rows);
  r.estimator = reader.strings("recordings/estimator", rows);
  r.speed_m_s = read_vector(reader, "recordings/speed", "m/s", rows, true);
  r.noise_N = read_vector(reader, "recordings/noise", "N", rows);
  r.hysteresis = read_vector(reader, "recordings/hysteresis", kNoUnit, rows, true);
  r.young_Pa = read_vector(reader, "recordings/young", "Pa", rows, true);
  r.grade = reader.bytes("recordings/grade", kNoUnit, {rows, 0});
  r.reasons = reader.strings("recordings/reasons", rows);
  return r;
}

void write_measured(Writer& writer, const MeasuredRecordings& r) {
  if (r.size() == 0) return;
  writer.integers("recordings/experiment", kNoUnit, r.experiment.data(), {r.size(), 0});
  writer.strings("recordings/file", r.file);
  writer.strings("recordings/hash", r.hash);
  write_vector(writer, "recordings/contact", "m", r.contact_m);
  write_vector(writer, "recordings/contact_deviation", "m", r.contact_deviation_m);
  writer.strings("recordings/estimator", r.estimator);
  write_vector(writer, "recordings/speed", "m/s", r.speed_m_s);
  write_vector(writer, "recordings/noise", "N", r.noise_N);
  write_vector(writer, "recordings/hysteresis", kNoUnit, r.hysteresis);
  write_vector(writer, "recordings/young", "Pa", r.young_Pa);
  writer.bytes("recordings/grade", kNoUnit, r.grade.data(), {r.size(), 0});
  writer.attribute("recordings/grade", "names", kGradeNames);
  writer.strings("recordings/reasons", r.reasons);
}

void check_measured(const MeasuredRecordings& r, const Complain& complain) {
  const auto rows = static_cast<Eigen::Index>(r.size());
  const auto size = [](const auto& column) { return static_cast<Eigen::Index>(column.size()); };
  check_rows(complain, "recordings/file", size(r.file), rows);
  check_rows(complain, "recordings/hash", size(r.hash), rows);
  check_rows(complain, "recordings/contact", r.contact_m.size(), rows);
  check_rows(complain, "recordings/contact_deviation", r.contact_deviation_m.size(), rows);
  check_rows(complain, "recordings/estimator", size(r.estimator), rows);
  check_rows(complain, "recordings/speed", r.speed_m_s.size(), rows);
  check_rows(complain, "recordings/noise", r.noise_N.size(), rows);
  check_rows(complain, "recordings/hysteresis", r.hysteresis.size(), rows);
  check_rows(complain, "recordings/young", r.young_Pa.size(), rows);
  check_rows(complain, "recordings/grade", size(r.grade), rows);
  check_rows(complain, "recordings/reasons", size(r.reasons), rows);
  if (!r.contact_m.allFinite()) throw complain("recordings/contact", "is not finite");
  if (!r.contact_deviation_m.allFinite() || (r.contact_deviation_m.array() < 0).any())
    throw complain("recordings/contact_deviation", "is not finite and positive");
}

void check(const Samples& s, const h5::Complain& complain) {
  check_sizes(s, complain);
  check_indices(complain, "rows/point", s.point.data(), static_cast<Eigen::Index>(rows_of(s)), 1,
                s.points());
  check_numbers(s, complain);
  check_experiments(s, complain);
  check_measured(s.recordings, complain);
}

void read_points_of(const h5::Reader& reader, Samples& s) {
  s.point_position = read_points(reader, "points/position", "m", h5::kAny);
  const auto points = static_cast<std::size_t>(s.points());
  s.point_normal = read_points(reader, "points/normal", h5::kNoUnit, points);
  s.point_name = reader.strings("points/name", points);
  s.probe = read_probe(reader);
  if (reader.has("body/poisson"))
    s.poisson = reader.numbers("body/poisson", h5::kNoUnit, {1, 0}).front();
  if (!reader.has("points/normal_gradient")) return;
  const auto values = reader.numbers("points/normal_gradient", "1/m", {points, 9});
  s.point_normal_gradient =
      Eigen::Map<const decltype(s.point_normal_gradient)>(values.data(), s.points(), 9);
}

void read_rows(const h5::Reader& reader, Samples& s) {
  const std::size_t rows = reader.shape_of("rows/point").rows;
  s.point = reader.integers("rows/point", h5::kNoUnit, {rows, 0});
  s.experiment = reader.integers("rows/experiment", h5::kNoUnit, {rows, 0});
  s.kind = read_codes<ExperimentKind>(reader, "rows/kind", rows, kKindNames);
  s.step = reader.integers("rows/step", h5::kNoUnit, {rows, 0});
  s.deflection = read_points(reader, "rows/deflection", "m", rows, false);
  s.force = read_points(reader, "rows/force", "N", rows, true);
  s.torque = read_points(reader, "rows/torque", "N m", rows, true);
  s.force_error = read_vector(reader, "rows/force_error", "N", rows, true);
  s.status = read_codes<RowStatus>(reader, "rows/status", rows, kRowStatusNames);
  if (reader.has("rows/doubt"))
    s.doubt = read_codes<StepCheck>(reader, "rows/doubt", rows, kStepCheckNames);
}

}  // namespace

Samples read_samples(const std::filesystem::path& path) {
  const h5::Reader reader = h5::open(path, kSamplesSchema);
  Samples s;
  read_points_of(reader, s);
  read_rows(reader, s);
  s.recordings = read_measured(reader);
  check(s, complain_about(reader));
  return s;
}

void write_samples(const std::filesystem::path& path, const Samples& s,
                   const Attributes& attributes) {
  check(s, h5::complain_about(path));
  h5::Writer writer = h5::create(path, kSamplesSchema, attributes);
  write_points(writer, "points/position", "m", s.point_position);
  write_points(writer, "points/normal", h5::kNoUnit, s.point_normal);
  writer.strings("points/name", s.point_name);
  if (s.point_normal_gradient.rows() != 0)
    writer.numbers("points/normal_gradient", "1/m", s.point_normal_gradient.data(),
                   {s.point_name.size(), 9});
  const h5::Shape column{rows_of(s), 0};
  writer.integers("rows/point", h5::kNoUnit, s.point.data(), column);
  writer.integers("rows/experiment", h5::kNoUnit, s.experiment.data(), column);
  write_codes(writer, "rows/kind", s.kind, kKindNames);
  writer.integers("rows/step", h5::kNoUnit, s.step.data(), column);
  write_points(writer, "rows/deflection", "m", s.deflection);
  write_points(writer, "rows/force", "N", s.force);
  write_points(writer, "rows/torque", "N m", s.torque);
  write_vector(writer, "rows/force_error", "N", s.force_error);
  write_codes(writer, "rows/status", s.status, kRowStatusNames);
  if (!s.doubt.empty()) write_codes(writer, "rows/doubt", s.doubt, kStepCheckNames);
  write_probe(writer, s.probe, complain_about(path));
  if (!std::isnan(s.poisson)) writer.numbers("body/poisson", h5::kNoUnit, &s.poisson, {1, 0});
  write_measured(writer, s.recordings);
  writer.commit();
}

}  // namespace palpate
