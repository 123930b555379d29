#include "libfit/io/files/files.hpp"

#include <fmt/core.h>

#include <cmath>

#include "libfit/io/files/columns.hpp"

namespace palpate {

using namespace h5;

namespace {

// Curves: FittedCurves or const FittedCurves.
template <class Curves, class F>
void columns(Curves& c, F& f) {
  f.first("points/position", c.position, {"m"});
  f("points/normal", c.normal);
  f("points/name", c.name);
  f("points/status", c.status, {.names = kFitStatusNames});
  f("points/message", c.message);
  f("points/rms_residual", c.rms_residual_N, {"N", true});
  f("points/max_residual", c.max_residual_N, {"N", true});
  f("points/depth_range", c.depth_range_m, {"m", true});

  auto& r = c.recordings;
  if (!f.first("experiments/experiment", r.experiment, {.is_optional = true})) return;
  f("experiments/point", r.point);
  f("experiments/contact", r.contact_m, {"m"});
  f("experiments/contact_deviation", r.contact_deviation_m, {"m"});
  f("experiments/bias", r.bias_N, {"N"});
  f("experiments/bias_deviation", r.bias_deviation_N, {"N"});
  f("experiments/drift", r.drift_N, {"N"});
  f("experiments/drift_deviation", r.drift_deviation_N, {"N"});
}

std::string covariance_name(std::size_t kind) {
  return fmt::format("curves/{}/covariance", kCurveNames[kind]);
}
std::string deviation_name(const runtime::Part& part) {
  return fmt::format("curves/{}/deviation", part.name);
}

template <class Curves, class F>
void uncertainty_columns(Curves& c, F& f) {
  for (std::size_t kind = 0; kind < curves_of(c.curves.family); ++kind)
    f(covariance_name(kind), c.covariance[kind],
      {.unit = "N^2", .may_be_nan = true, .is_optional = true});
  const auto parts = parts_of(c.curves.family);
  for (std::size_t i = 0; i < c.deviation.size(); ++i)
    if (has_deviation(parts[i]))
      f(deviation_name(parts[i]), c.deviation[i],
        {.unit = parts[i].unit, .may_be_nan = true, .is_optional = true});
}

// Residuals and ranges: not negative; NaN where there is none.
void check_measure(const h5::Complain& complain, const std::string& name,
                   const Eigen::VectorXd& values) {
  for (Eigen::Index i = 0; i < values.size(); ++i)
    if (values[i] < 0 || std::isinf(values[i]))
      throw complain(name, fmt::format("row {} is negative or infinite", i));
}

// A row is finite with a diagonal of variances, or all NaN.
void check_covariance(const h5::Complain& complain, const FittedCurves& f, std::size_t kind) {
  const std::string name = covariance_name(kind);
  const Controls& values = f.covariance[kind];
  check_rows(complain, name, values.rows(), f.position.rows());
  const Eigen::Index n = f.curves.basis[kind].size() - 1;
  if (values.cols() != n * (n + 1) / 2)
    throw complain(name, "has another number of columns than the basis asks for");
  for (Eigen::Index p = 0; p < values.rows(); ++p) {
    if (values.row(p).array().isNaN().all()) continue;
    const std::string row = fmt::format("row {}", p);
    if (!values.row(p).allFinite()) throw complain(name, row + " is not finite");
    for (Eigen::Index i = 0, at = 0; at < values.cols(); ++i, at += i + 1)
      if (values(p, at) < 0) throw complain(name, row + " has a negative variance");
  }
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

void check(const FittedCurves& f, const h5::Complain& complain) {
  ColumnChecker all(complain);
  columns(f, all);
  const Eigen::Index points = f.position.rows();
  check_unit_length(complain, "points/normal", f.normal);
  check_measure(complain, "points/rms_residual", f.rms_residual_N);
  check_measure(complain, "points/max_residual", f.max_residual_N);
  check_measure(complain, "points/depth_range", f.depth_range_m);
  check_curve_set(complain, f.curves, points);
  for (std::size_t kind = 0; kind < curves_of(f.curves.family); ++kind)
    if (f.covariance[kind].size() > 0) check_covariance(complain, f, kind);
  check_deviations(complain, f);
  check_indices(complain, "experiments/point", f.recordings.point, points);
}

}  // namespace

FittedCurves read_curves(const std::filesystem::path& path) {
  const h5::Reader reader = h5::open(path, kCurvesSchema);
  FittedCurves f;
  ColumnReader in(reader);
  columns(f, in);
  f.curves = read_curve_set(reader, f.name.size());
  f.deviation.resize(parts_of(f.curves.family).size());
  const ColumnReader of_points(reader, f.name.size());
  uncertainty_columns(f, of_points);
  f.probe = read_probe(reader);
  check(f, complain_about(reader));
  return f;
}

void write_curves(const std::filesystem::path& path, const FittedCurves& f,
                  const Attributes& attributes) {
  check(f, h5::complain_about(path));
  h5::Writer writer = h5::create(path, kCurvesSchema, attributes);
  ColumnWriter out(writer);
  columns(f, out);
  write_curve_set(writer, f.curves);
  uncertainty_columns(f, out);
  write_probe(writer, f.probe, complain_about(path));
  writer.commit();
}

}  // namespace palpate
