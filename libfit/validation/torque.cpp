#include "libfit/validation/torque.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate::validation {

// (M58a)
std::vector<ComparedTorque> compared_torques(const Reference& reference, const Replayed& engine,
                                             double radius_m,
                                             const std::function<bool(std::size_t path)>& counts) {
  const Samples& rows = reference.paths;
  std::vector<ComparedTorque> out;
  for (Eigen::Index row = 0; row < rows.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    const auto path = static_cast<std::size_t>(rows.point[r]);
    if (rows.status[r] != RowStatus::good || !engine.is_answered[r] || !counts(path)) continue;
    const Vec3 to_tip = radius_m * reference.held_out.points.normal.row(rows.point[r]);
    const auto moved = [&](const Points& torque_Nm, const Points& force_N) {
      return Vec3(torque_Nm.row(row).transpose() + to_tip.cross(Vec3(force_N.row(row))));
    };
    out.push_back({moved(rows.torque, rows.force), moved(engine.torque_Nm, engine.force_N)});
  }
  return out;
}

double torque_floor_Nm(const std::vector<ComparedTorque>& rows) {
  double largest_Nm = 0;
  for (const ComparedTorque& row : rows) largest_Nm = std::max(largest_Nm, row.reference_Nm.norm());
  return relative_floor_Nm(largest_Nm);
}

NamedTorque named_torque(std::string name, const std::vector<ComparedTorque>& rows,
                         double floor_Nm) {
  std::vector<double> torque, error, relative;
  for (const ComparedTorque& row : rows) {
    torque.push_back(row.reference_Nm.norm());
    error.push_back((row.engine_Nm - row.reference_Nm).norm());
    if (floor_Nm > 0) relative.push_back(relative_error(error.back(), torque.back(), floor_Nm));
  }
  return {std::move(name),
          stated_quantile(torque, 0.5),
          stated_quantile(error, 0.5),
          stated_quantile(error, 0.95),
          stated_quantile(error, 1),
          stated_quantile(relative, 0.5),
          stated_quantile(relative, 0.95),
          stated_quantile(relative, 1)};
}

std::vector<NamedTorque> torque_errors(const Reference& reference, const Replayed& engine,
                                       double radius_m) {
  std::vector<NamedTorque> out;
  const auto all = compared_torques(reference, engine, radius_m, [](std::size_t) { return true; });
  if (all.empty()) return out;
  const double floor_Nm = torque_floor_Nm(all);
  out.push_back(named_torque("all", all, floor_Nm));
  for (std::size_t kind = 0; kind < kPathKindNames.size(); ++kind) {
    const auto rows = compared_torques(reference, engine, radius_m, [&](std::size_t path) {
      return static_cast<std::size_t>(reference.held_out.kind[path]) == kind;
    });
    if (!rows.empty())
      out.push_back(named_torque(std::string(kPathKindNames[kind]), rows, floor_Nm));
  }
  return out;
}

}  // namespace palpate::validation
