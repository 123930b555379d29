#include "libfit/io/files/curves_file.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "libfit/io/files/curve_set_columns.hpp"
#include "libfit/io/files/probe_group.hpp"

namespace palpate {

using namespace h5;

namespace {

// Residuals and ranges: not negative; NaN where there is none.
void check_measure(const h5::Complain& complain, const std::string& name,
                   const Eigen::VectorXd& values, Eigen::Index rows) {
  check_rows(complain, name, values.size(), rows);
  for (Eigen::Index i = 0; i < rows; ++i)
    if (values[i] < 0 || std::isinf(values[i]))
      throw complain(name, fmt::format("row {} is negative or infinite", i));
}

std::string covariance_name(std::size_t kind) {
  return fmt::format("curves/{}/covariance", kCurveNames[kind]);
}

// Entries of the lower triangle of a curve's increments.
Eigen::Index covariance_columns(const CurveBasis& basis) {
  const Eigen::Index n = basis.size() - 1;
  return n * (n + 1) / 2;
}

// A row is finite with a diagonal of variances, or all NaN.
void check_covariance(const h5::Complain& complain, const FittedCurves& f, std::size_t kind) {
  const std::string name = covariance_name(kind);
  const Controls& values = f.covariance[kind];
  check_rows(complain, name, values.rows(), f.position.rows());
  if (values.cols() != covariance_columns(f.curves.basis[kind]))
    throw complain(name, "has another number of columns than the basis asks for");
  for (Eigen::Index p = 0; p < values.rows(); ++p) {
    if (values.row(p).array().isNaN().all()) continue;
    const std::string row = fmt::format("row {}", p);
    if (!values.row(p).allFinite()) throw complain(name, row + " is not finite");
    for (Eigen::Index i = 0, at = 0; at < values.cols(); ++i, at += i + 1)
      if (values(p, at) < 0) throw complain(name, row + " has a negative variance");
  }
}

std::string deviation_name(const runtime::Part& part) {
  return fmt::format("curves/{}/deviation", part.name);
}

void check_deviations(const h5::Complain& complain, const FittedCurves& f) {
  if (f.deviation.empty()) return;
  const auto parts = parts_of(f.curves.family);
  if (f.deviation.size() != parts.size())
    throw complain("curves", "has standard errors of another number of parts");
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Controls& values = f.deviation[i];
    if (values.size() == 0) continue;
    const std::string name = deviation_name(parts[i]);
    check_rows(complain, name, values.rows(), f.position.rows());
    if (values.cols() != f.curves.control[i].cols())
      throw complain(name, "has another number of columns than the part");
    for (const double value : values.reshaped())
      if (value < 0 || std::isinf(value)) throw complain(name, "is negative or infinite");
  }
}

struct NuisanceColumn {
  const char* name;
  const char* unit;
  Eigen::VectorXd FittedRecordings::*values;
};
constexpr NuisanceColumn kNuisanceColumns[] = {
    {"experiments/contact", "m", &FittedRecordings::contact_m},
    {"experiments/contact_deviation", "m", &FittedRecordings::contact_deviation_m},
    {"experiments/bias", "N", &FittedRecordings::bias_N},
    {"experiments/bias_deviation", "N", &FittedRecordings::bias_deviation_N},
    {"experiments/drift", "N", &FittedRecordings::drift_N},
    {"experiments/drift_deviation", "N", &FittedRecordings::drift_deviation_N},
};

void check_recordings(const h5::Complain& complain, const FittedCurves& f) {
  const auto rows = static_cast<Eigen::Index>(f.recordings.experiment.size());
  check_rows(complain, "experiments/point", static_cast<Eigen::Index>(f.recordings.point.size()),
             rows);
  check_indices(complain, "experiments/point", f.recordings.point.data(), rows, 1,
                f.position.rows());
  for (const NuisanceColumn& column : kNuisanceColumns) {
    const Eigen::VectorXd& values = f.recordings.*column.values;
    check_rows(complain, column.name, values.size(), rows);
    if (!values.allFinite()) throw complain(column.name, "is not finite");
  }
}

constexpr const char* kStrength = "smoothing";
constexpr const char* kReason = "smoothing_reason";

std::string group_of(std::size_t kind) { return fmt::format("curves/{}", kCurveNames[kind]); }

void read_smoothing(const Reader& reader, FittedCurves& curves) {
  for (std::size_t kind = 0; kind < curves_of(curves.curves.family); ++kind) {
    const std::string group = group_of(kind);
    if (!reader.has_attribute(group, kStrength)) continue;
    const std::string text = reader.text_attribute(group, kStrength);
    const char* const end = text.data() + text.size();
    const auto found = std::from_chars(text.data(), end, curves.smoothing[kind]);
    if (found.ec != std::errc{} || found.ptr != end)
      throw reader.error(group, "attribute `smoothing` is not a number");
    if (reader.has_attribute(group, kReason))
      curves.smoothing_reason[kind] = reader.text_attribute(group, kReason);
  }
}

void write_smoothing(Writer& writer, const FittedCurves& curves) {
  for (std::size_t kind = 0; kind < curves_of(curves.curves.family); ++kind) {
    if (curves.smoothing_reason[kind].empty()) continue;
    writer.attribute(group_of(kind), kStrength, fmt::format("{}", curves.smoothing[kind]));
    writer.attribute(group_of(kind), kReason, curves.smoothing_reason[kind]);
  }
}

void check_smoothing(const Complain& complain, const FittedCurves& curves) {
  for (std::size_t kind = 0; kind < curves_of(curves.curves.family); ++kind)
    if (!(curves.smoothing[kind] >= 0) || std::isinf(curves.smoothing[kind]))
      throw complain(group_of(kind), "attribute `smoothing` is negative or not finite");
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
  check_curve_set(complain, f.curves, points);
  for (std::size_t kind = 0; kind < curves_of(f.curves.family); ++kind)
    if (f.covariance[kind].size() > 0) check_covariance(complain, f, kind);
  check_deviations(complain, f);
  check_smoothing(complain, f);
  check_recordings(complain, f);
}

FittedRecordings read_recordings(const h5::Reader& reader) {
  FittedRecordings out;
  if (!reader.has("experiments/experiment")) return out;
  out.experiment = reader.integers("experiments/experiment", h5::kNoUnit, {h5::kAny, 0});
  const std::size_t rows = out.experiment.size();
  out.point = reader.integers("experiments/point", h5::kNoUnit, {rows, 0});
  for (const NuisanceColumn& column : kNuisanceColumns)
    out.*column.values = read_vector(reader, column.name, column.unit, rows);
  return out;
}

void write_recordings(h5::Writer& writer, const FittedRecordings& recordings) {
  const std::size_t rows = recordings.experiment.size();
  if (rows == 0) return;
  writer.integers("experiments/experiment", h5::kNoUnit, recordings.experiment.data(), {rows, 0});
  writer.integers("experiments/point", h5::kNoUnit, recordings.point.data(), {rows, 0});
  for (const NuisanceColumn& column : kNuisanceColumns)
    write_vector(writer, column.name, column.unit, recordings.*column.values);
}

std::vector<FitStatus> read_status(const h5::Reader& reader, std::size_t points) {
  std::vector<FitStatus> status;
  for (const std::int8_t code : reader.bytes("points/status", h5::kNoUnit, {points, 0})) {
    if (code < 0 || static_cast<std::size_t>(code) >= kFitStatusNames.size())
      throw reader.error("points/status",
                         fmt::format("row {} has code {} without a name", status.size(), code));
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
  f.curves = read_curve_set(reader, points);
  for (std::size_t kind = 0; kind < curves_of(f.curves.family); ++kind) {
    if (!reader.has(covariance_name(kind))) continue;
    f.covariance[kind] = read_table(reader, covariance_name(kind), "N^2", f.position.rows(),
                                    covariance_columns(f.curves.basis[kind]), true);
  }
  const auto parts = parts_of(f.curves.family);
  f.deviation.resize(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (has_deviation(parts[i]) && reader.has(deviation_name(parts[i])))
      f.deviation[i] = read_table(reader, deviation_name(parts[i]), parts[i].unit,
                                  f.position.rows(), f.curves.control[i].cols(), true);
  read_smoothing(reader, f);
  f.recordings = read_recordings(reader);
  f.probe = read_probe(reader);
  check(f, complain_about(reader));
  return f;
}

void write_curves(const std::filesystem::path& path, const FittedCurves& f,
                  const Attributes& attributes) {
  check(f, h5::complain_about(path));
  h5::Writer writer = h5::create(path, kCurvesSchema, attributes);
  write_points(writer, "points/position", "m", f.position);
  write_points(writer, "points/normal", h5::kNoUnit, f.normal);
  writer.strings("points/name", f.name);
  write_status(writer, f.status);
  writer.strings("points/message", f.message);
  write_vector(writer, "points/rms_residual", "N", f.rms_residual_N);
  write_vector(writer, "points/max_residual", "N", f.max_residual_N);
  write_vector(writer, "points/depth_range", "m", f.depth_range_m);
  write_curve_set(writer, f.curves);
  for (std::size_t kind = 0; kind < curves_of(f.curves.family); ++kind)
    if (f.covariance[kind].size() > 0)
      write_table(writer, covariance_name(kind), "N^2", f.covariance[kind]);
  const auto parts = parts_of(f.curves.family);
  for (std::size_t i = 0; i < f.deviation.size(); ++i)
    if (f.deviation[i].size() > 0)
      write_table(writer, deviation_name(parts[i]), parts[i].unit, f.deviation[i]);
  write_smoothing(writer, f);
  write_recordings(writer, f.recordings);
  write_probe(writer, f.probe, complain_about(path));
  writer.commit();
}

}  // namespace palpate
