#include "libfit/fit/rows_hash.hpp"

#include <cinttypes>
#include <cstdio>

#include "libfit/runtime/format.hpp"

namespace palpate::fit {
namespace {

template <class Derived>
void add(std::vector<double>& out, const Eigen::DenseBase<Derived>& values) {
  for (Eigen::Index i = 0; i < values.size(); ++i) out.push_back(values.derived().coeff(i));
}

}  // namespace

std::string rows_hash(const Samples& samples, Eigen::Index point, const PointData& data,
                      double length_m, const FitOptions& options) {
  std::vector<double> all{static_cast<double>(options.loss), options.poor_above,
                          options.default_friction, options.default_lateral_ratio};
  add(all, samples.point_position.row(point));
  add(all, samples.point_normal.row(point));
  if (samples.point_normal_gradient.rows() > 0) add(all, samples.point_normal_gradient.row(point));
  for (const char c : data.problem) all.push_back(static_cast<double>(c));
  for (const Experiment& e : data.experiments) {
    all.push_back(static_cast<double>(e.kind));
    all.push_back(static_cast<double>(e.row.size()));
    for (const double d : {e.unknown.contact * length_m, e.unknown.bias * data.force_N,
                           e.unknown.drift * data.force_N})
      if (d > 0) all.push_back(d);
    for (std::size_t i = 0; i < e.row.size(); ++i) {
      add(all, samples.deflection.row(e.row[i]));
      add(all, samples.force.row(e.row[i]));
      all.push_back(e.weight[i] / data.force_N);
    }
  }
  char text[17];
  std::snprintf(text, sizeof text, "%016" PRIx64,
                runtime::checksum(all.data(), all.size() * sizeof(double)));
  return text;
}

}  // namespace palpate::fit
