#include <array>
#include <limits>
#include <string>

#include "libfit/assets/exporters.hpp"
#include "libfit/assets/stiffness_map.hpp"
#include "libfit/core/node_forces.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/vtu.hpp"

namespace palpate {
namespace {

constexpr std::array<double, 4> kDepthShares{0.25, 0.5, 0.75, 1.0};  // of the normal curve's range

// Nothing is known there: a viewer must not take it for soft.
constexpr float kUncovered = std::numeric_limits<float>::quiet_NaN();

template <class F>
std::vector<float> per_vertex(const Model& model, F value) {
  std::vector<float> out;
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v)
    out.push_back(model.is_covered[v] ? float(value(v)) : kUncovered);
  return out;
}

std::string at_depth(double depth_m) {  // "_at_2.5mm"
  std::string digits = std::to_string(depth_m * 1e3);
  digits.erase(digits.find_last_not_of('0') + 1);
  if (digits.back() == '.') digits.pop_back();
  return "_at_" + digits + "mm";
}

void add_point_data(const Model& model, VtuWriter& vtu) {
  const NodeForces forces(model.curves);
  vtu.add("is_covered", 1, std::vector<char>(model.is_covered));
  vtu.add("inward_normal", 3,
          std::vector<double>(model.inward_normal.data(),
                              model.inward_normal.data() + model.inward_normal.size()));
  for (double share : kDepthShares) {
    const double depth = share * model.curves.basis[0].knots_m.back();
    const std::string at = at_depth(depth);
    const auto force = [&](Eigen::Index v) { return forces.normal_N(v, depth); };
    const auto mu = [&](Eigen::Index v) {
      return force(v) > 0 ? forces.limit_N(v, depth) / force(v) : 0;
    };
    vtu.add("normal_force_N" + at, 1, per_vertex(model, force));
    vtu.add("normal_stiffness_N_m" + at, 1,
            per_vertex(model, [&](Eigen::Index v) { return forces.normal_slope_N_m(v, depth); }));
    vtu.add("lateral_stiffness_N_m" + at, 1,
            per_vertex(model, [&](Eigen::Index v) { return forces.lateral_slope_N_m(v, depth); }));
    vtu.add("friction_limit_N" + at, 1,
            per_vertex(model, [&](Eigen::Index v) { return forces.limit_N(v, depth); }));
    vtu.add("friction" + at, 1, per_vertex(model, mu));
  }
}

}  // namespace

ExportReport export_vtu(const Model& model, const std::filesystem::path& path,
                        const ExportOptions&) {
  check_sizes(model);
  VtuWriter vtu;
  add_point_data(model, vtu);
  const std::string text = vtu.text(model.surface, "is_covered");
  write_file_atomically(path, text);
  return written(model, text.size());
}

}  // namespace palpate
