#include "libfit/io/files/smoothing_columns.hpp"

#include <array>
#include <charconv>
#include <cmath>

#include "libfit/io/files/curve_set_columns.hpp"

namespace palpate::h5 {
namespace {

constexpr const char* kStrength = "smoothing";
constexpr const char* kReason = "smoothing_reason";

std::string group_of(std::size_t kind) { return "curves/" + std::string(kCurveNames[kind]); }

std::string text_of(double value) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

Controls read_table(const Reader& reader, const std::string& name, std::string_view unit,
                    Eigen::Index rows, Eigen::Index columns, bool may_be_nan) {
  const auto values = reader.numbers(
      name, unit, {static_cast<std::size_t>(rows), static_cast<std::size_t>(columns)}, may_be_nan);
  return Eigen::Map<const Controls>(values.data(), rows, columns);
}

void write_table(Writer& writer, const std::string& name, std::string_view unit,
                 const Controls& values) {
  writer.numbers(
      name, unit, values.data(),
      {static_cast<std::size_t>(values.rows()), static_cast<std::size_t>(values.cols())});
}

}  // namespace

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
    if (!reader.has(group + "/own_controls")) continue;
    const Controls& covariance = curves.covariance[kind];
    curves.own.control[kind] =
        read_table(reader, group + "/own_controls", "N", curves.position.rows(),
                   curves.curves.basis[kind].size(), false);
    curves.own.covariance[kind] = read_table(reader, group + "/own_covariance", "N^2",
                                             covariance.rows(), covariance.cols(), true);
  }
}

void write_smoothing(Writer& writer, const FittedCurves& curves) {
  for (std::size_t kind = 0; kind < curves_of(curves.curves.family); ++kind) {
    const std::string group = group_of(kind);
    if (curves.smoothing_reason[kind].empty()) continue;
    writer.attribute(group, kStrength, text_of(curves.smoothing[kind]));
    writer.attribute(group, kReason, curves.smoothing_reason[kind]);
    if (curves.own.control[kind].rows() == 0) continue;
    write_table(writer, group + "/own_controls", "N", curves.own.control[kind]);
    write_table(writer, group + "/own_covariance", "N^2", curves.own.covariance[kind]);
  }
}

void check_smoothing(const Complain& complain, const FittedCurves& curves) {
  for (std::size_t kind = 0; kind < curves_of(curves.curves.family); ++kind) {
    const std::string group = group_of(kind);
    const double strength = curves.smoothing[kind];
    if (!(strength >= 0) || std::isinf(strength))
      throw complain(group, "attribute `smoothing` is negative or not finite");
    const Controls &control = curves.own.control[kind], &covariance = curves.own.covariance[kind];
    if ((strength > 0) != (control.size() > 0))
      throw complain(group + "/own_controls", "does not go with the strength of smoothing");
    if (control.size() == 0) continue;
    check_controls(complain, group + "/own_controls", parts_of(curves.curves.family)[kind], control,
                   curves.curves.basis[kind], curves.position.rows());
    if (covariance.rows() != curves.covariance[kind].rows() ||
        covariance.cols() != curves.covariance[kind].cols())
      throw complain(group + "/own_covariance", "is of another size than the covariance");
    for (Eigen::Index p = 0; p < covariance.rows(); ++p)
      for (Eigen::Index i = 0, at = 0; at < covariance.cols(); ++i, at += i + 1)
        if (covariance(p, at) < 0)
          throw complain(group + "/own_covariance",
                         "row " + std::to_string(p) + " has a negative variance");
  }
}

}  // namespace palpate::h5
