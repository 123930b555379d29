#include "libfit/fit/rows_hash.hpp"

#include "libfit/io/content_hash.hpp"

namespace palpate::fit {
namespace {

template <class Derived>
void add(ContentHash& hash, const Eigen::DenseBase<Derived>& values) {
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const double value = values.derived().coeff(i);
    hash.add({reinterpret_cast<const char*>(&value), sizeof value});
  }
}
void add(ContentHash& hash, double value) {
  hash.add({reinterpret_cast<const char*>(&value), sizeof value});
}

}  // namespace

std::string rows_hash(const Samples& samples, Eigen::Index point, const PointData& data,
                      const FitOptions& options) {
  ContentHash hash;
  for (const double option : {static_cast<double>(options.loss), options.poor_above,
                              options.default_friction, options.default_lateral_ratio})
    add(hash, option);
  add(hash, Vec3(samples.point_position.row(point)));
  add(hash, Vec3(samples.point_normal.row(point)));
  if (samples.point_normal_gradient.rows() > 0)
    add(hash, Eigen::Matrix<double, 9, 1>(samples.point_normal_gradient.row(point)));
  hash.add(data.problem);
  for (const Experiment& e : data.experiments) {
    add(hash, static_cast<double>(e.kind));
    for (std::size_t i = 0; i < e.row.size(); ++i) {
      add(hash, Vec3(samples.deflection.row(e.row[i])));
      add(hash, Vec3(samples.force.row(e.row[i])));
      add(hash, e.weight[i] / data.force_N);
    }
  }
  return hash.hex();
}

}  // namespace palpate::fit
