#include "libfit/io/files/curves_file.hpp"

#include <cmath>

#include "libfit/io/files/curve_set_columns.hpp"
#include "libfit/io/files/smoothing_columns.hpp"

namespace palpate {

using namespace h5;

namespace {

constexpr std::string_view kMillionth = "1e-6";

// Residuals and ranges: not negative; NaN where there is none.
void check_measure(const h5::Complain& complain, const std::string& name,
                   const Eigen::VectorXd& values, Eigen::Index rows) {
  check_rows(complain, name, values.size(), rows);
  for (Eigen::Index i = 0; i < rows; ++i)
    if (values[i] < 0 || std::isinf(values[i]))
      throw complain(name, "row " + std::to_string(i) + " is negative or infinite");
}

std::string covariance_name(std::size_t kind) {
  return "curves/" + std::string(kCurveNames[kind]) + "/covariance";
}

// Entries of the lower triangle of a curve's increments.
std::size_t covariance_columns(const CurveBasis& basis) {
  const auto n = static_cast<std::size_t>(basis.size() - 1);
  return n * (n + 1) / 2;
}

// A row is finite with a diagonal of variances, or all NaN.
void check_covariance(const h5::Complain& complain, const FittedCurves& f, std::size_t kind) {
  const std::string name = covariance_name(kind);
  const Controls& values = f.covariance[kind];
  check_rows(complain, name, values.rows(), f.position.rows());
  if (static_cast<std::size_t>(values.cols()) != covariance_columns(f.curves.basis[kind]))
    throw complain(name, "has another number of columns than the basis asks for");
  for (Eigen::Index p = 0; p < values.rows(); ++p) {
    if (values.row(p).array().isNaN().all()) continue;
    const std::string row = "row " + std::to_string(p);
    if (!values.row(p).allFinite()) throw complain(name, row + " is not finite");
    for (Eigen::Index i = 0, at = 0; at < values.cols(); ++i, at += i + 1)
      if (values(p, at) < 0) throw complain(name, row + " has a negative variance");
  }
}

struct SensorColumn {
  const char* name;
  const char* unit;
  Eigen::VectorXd FittedRecordings::*values;
};
constexpr SensorColumn kSensorColumns[] = {
    {"experiments/contact", "m", &FittedRecordings::contact_m},
    {"experiments/contact_deviation", "m", &FittedRecordings::contact_deviation_m},
    {"experiments/bias", "N", &FittedRecordings::bias_N},
    {"experiments/bias_deviation", "N", &FittedRecordings::bias_deviation_N},
    {"experiments/drift", "N", &FittedRecordings::drift_N},
    {"experiments/drift_deviation", "N", &FittedRecordings::drift_deviation_N},
};

// Scores belong to the points and to one another.
void check_scores(const h5::Complain& complain, const FitScores& s, Eigen::Index points) {
  const auto size = [](const auto& column) { return static_cast<Eigen::Index>(column.size()); };
  check_measure(complain, "points/relative_residual", s.relative_residual, points);
  check_rows(complain, "points/worst_experiment", size(s.worst_experiment), points);
  check_rows(complain, "points/worst_row", size(s.worst_row), points);
  check_rows(complain, "points/row_counts", s.rows.rows(), points);
  check_rows(complain, "points/curve_end", s.curve_end_m.rows(), points);
  check_rows(complain, "points/states_errors", size(s.states_errors), points);
  if ((s.rows.array() < 0).any()) throw complain("points/row_counts", "is negative");
  Eigen::Index scored_rows = 0;
  for (Eigen::Index p = 0; p < points; ++p)
    if (!std::isnan(s.relative_residual[p])) scored_rows += s.rows(p, 0);
  check_rows(complain, "rows/relative_error", size(s.relative_error), scored_rows);
}

FitScores read_scores(const h5::Reader& reader, std::size_t points) {
  FitScores s;
  if (!reader.has("points/row_counts")) return s;
  s.relative_residual = read_vector(reader, "points/relative_residual", h5::kNoUnit, points, true);
  s.worst_experiment = reader.integers("points/worst_experiment", h5::kNoUnit, {points, 0});
  s.worst_row = reader.integers("points/worst_row", h5::kNoUnit, {points, 0});
  const auto rows = reader.integers("points/row_counts", h5::kNoUnit, {points, 4});
  s.rows = Eigen::Map<const decltype(s.rows)>(rows.data(), static_cast<Eigen::Index>(points), 4);
  s.curve_end_m = read_points(reader, "points/curve_end", "m", points, true);
  s.states_errors = reader.bytes("points/states_errors", h5::kNoUnit, {points, 0});
  s.relative_error = reader.integers("rows/relative_error", kMillionth, {h5::kAny, 0});
  return s;
}

void write_scores(h5::Writer& writer, const FitScores& s) {
  if (s.empty()) return;
  const h5::Shape column{s.worst_row.size(), 0};
  write_vector(writer, "points/relative_residual", h5::kNoUnit, s.relative_residual);
  writer.integers("points/worst_experiment", h5::kNoUnit, s.worst_experiment.data(), column);
  writer.integers("points/worst_row", h5::kNoUnit, s.worst_row.data(), column);
  writer.integers("points/row_counts", h5::kNoUnit, s.rows.data(), {column.rows, 4});
  write_points(writer, "points/curve_end", "m", s.curve_end_m);
  writer.bytes("points/states_errors", h5::kNoUnit, s.states_errors.data(), column);
  writer.integers("rows/relative_error", kMillionth, s.relative_error.data(),
                  {s.relative_error.size(), 0});
}

void check_recordings(const h5::Complain& complain, const FittedCurves& f) {
  const auto rows = static_cast<Eigen::Index>(f.recordings.experiment.size());
  check_rows(complain, "experiments/point", static_cast<Eigen::Index>(f.recordings.point.size()),
             rows);
  check_indices(complain, "experiments/point", f.recordings.point.data(), rows, 1,
                f.position.rows());
  for (const SensorColumn& column : kSensorColumns) {
    const Eigen::VectorXd& values = f.recordings.*column.values;
    check_rows(complain, column.name, values.size(), rows);
    if (!values.allFinite()) throw complain(column.name, "is not finite");
  }
}

void check(const FittedCurves& f, const h5::Complain& complain) {
  const Eigen::Index points = f.position.rows();
  check_finite(complain, "points/position", f.position);
  check_rows(complain, "points/normal", f.normal.rows(), points);
  check_unit_length(complain, "points/normal", f.normal);
  check_rows(complain, "points/name", static_cast<Eigen::Index>(f.name.size()), points);
  check_rows(complain, "points/status", static_cast<Eigen::Index>(f.status.size()), points);
  check_rows(complain, "points/message", static_cast<Eigen::Index>(f.message.size()), points);
  check_measure(complain, "points/rms_residual", f.rms_residual_N, points);
  check_measure(complain, "points/max_residual", f.max_residual_N, points);
  check_measure(complain, "points/depth_range", f.depth_range_m, points);
  if (!f.rows_hash.empty())
    check_rows(complain, "points/rows_hash", static_cast<Eigen::Index>(f.rows_hash.size()), points);
  check_curve_set(complain, f.curves, points);
  for (std::size_t kind = 0; kind < curves_of(f.curves.family); ++kind)
    if (f.covariance[kind].size() > 0) check_covariance(complain, f, kind);
  check_smoothing(complain, f);
  check_recordings(complain, f);
  if (!f.scores.empty()) check_scores(complain, f.scores, points);
}

FittedRecordings read_recordings(const h5::Reader& reader) {
  FittedRecordings out;
  if (!reader.has("experiments/experiment")) return out;
  out.experiment = reader.integers("experiments/experiment", h5::kNoUnit, {h5::kAny, 0});
  const std::size_t rows = out.experiment.size();
  out.point = reader.integers("experiments/point", h5::kNoUnit, {rows, 0});
  for (const SensorColumn& column : kSensorColumns)
    out.*column.values = read_vector(reader, column.name, column.unit, rows);
  return out;
}

void write_recordings(h5::Writer& writer, const FittedRecordings& recordings) {
  const std::size_t rows = recordings.experiment.size();
  if (rows == 0) return;
  writer.integers("experiments/experiment", h5::kNoUnit, recordings.experiment.data(), {rows, 0});
  writer.integers("experiments/point", h5::kNoUnit, recordings.point.data(), {rows, 0});
  for (const SensorColumn& column : kSensorColumns)
    write_vector(writer, column.name, column.unit, recordings.*column.values);
}

std::vector<FitStatus> read_status(const h5::Reader& reader, std::size_t points) {
  std::vector<FitStatus> status;
  for (const std::int8_t code : reader.bytes("points/status", h5::kNoUnit, {points, 0})) {
    if (code < 0 || static_cast<std::size_t>(code) >= kFitStatusNames.size())
      throw reader.error("points/status", "row " + std::to_string(status.size()) + " has code " +
                                              std::to_string(code) + " without a name");
    status.push_back(static_cast<FitStatus>(code));
  }
  return status;
}

void write_status(h5::Writer& writer, const std::vector<FitStatus>& status) {
  std::vector<std::int8_t> codes;
  for (const FitStatus s : status) codes.push_back(static_cast<std::int8_t>(s));
  writer.bytes("points/status", h5::kNoUnit, codes.data(), {codes.size(), 0});
  std::vector<std::string> names;
  for (const auto& row : kFitStatusNames) names.emplace_back(row.name);
  writer.attribute("points/status", "names", names);
}

}  // namespace

FittedCurves read_curves(const std::filesystem::path& path) {
  const h5::Reader reader = h5::open(path, kCurvesSchema);
  FittedCurves f;
  f.position = read_points(reader, "points/position", "m", h5::kAny);
  const auto points = static_cast<std::size_t>(f.position.rows());
  f.normal = read_points(reader, "points/normal", h5::kNoUnit, points);
  f.name = reader.strings("points/name", points);
  f.status = read_status(reader, points);
  f.message = reader.strings("points/message", points);
  f.rms_residual_N = read_vector(reader, "points/rms_residual", "N", points, true);
  f.max_residual_N = read_vector(reader, "points/max_residual", "N", points, true);
  f.depth_range_m = read_vector(reader, "points/depth_range", "m", points, true);
  if (reader.has("points/rows_hash")) f.rows_hash = reader.strings("points/rows_hash", points);
  f.curves = read_curve_set(reader, points);
  for (std::size_t kind = 0; kind < curves_of(f.curves.family); ++kind) {
    if (!reader.has(covariance_name(kind))) continue;
    const std::size_t columns = covariance_columns(f.curves.basis[kind]);
    const auto values = reader.numbers(covariance_name(kind), "N^2", {points, columns}, true);
    f.covariance[kind] = Eigen::Map<const Controls>(values.data(), f.position.rows(),
                                                    static_cast<Eigen::Index>(columns));
  }
  read_smoothing(reader, f);
  f.recordings = read_recordings(reader);
  f.scores = read_scores(reader, points);
  check(f, complain_about(reader));
  return f;
}

void write_curves(const std::filesystem::path& path, const FittedCurves& f,
                  const Attributes& attributes, const std::filesystem::path& earlier) {
  check(f, h5::complain_about(path));
  h5::Writer writer = h5::create(path, kCurvesSchema, attributes, earlier);
  write_points(writer, "points/position", "m", f.position);
  write_points(writer, "points/normal", h5::kNoUnit, f.normal);
  writer.strings("points/name", f.name);
  write_status(writer, f.status);
  writer.strings("points/message", f.message);
  write_vector(writer, "points/rms_residual", "N", f.rms_residual_N);
  write_vector(writer, "points/max_residual", "N", f.max_residual_N);
  write_vector(writer, "points/depth_range", "m", f.depth_range_m);
  if (!f.rows_hash.empty()) writer.strings("points/rows_hash", f.rows_hash);
  write_curve_set(writer, f.curves);
  for (std::size_t kind = 0; kind < curves_of(f.curves.family); ++kind) {
    const Controls& values = f.covariance[kind];
    if (values.size() == 0) continue;
    writer.numbers(
        covariance_name(kind), "N^2", values.data(),
        {static_cast<std::size_t>(values.rows()), static_cast<std::size_t>(values.cols())});
  }
  write_smoothing(writer, f);
  write_recordings(writer, f.recordings);
  write_scores(writer, f.scores);
  writer.commit();
}

}  // namespace palpate
