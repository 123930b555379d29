#include "libfem/mesh/read/marked.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>

namespace palpate {
namespace {

constexpr double kSlack = 1e-9;  // of the mesh's extent
constexpr double kHalf = 0.5 - 1e-9;
constexpr double kAnywhere = std::numeric_limits<double>::infinity();

}  // namespace

PaintedPart::PaintedPart(Surface surface, std::vector<char> is_painted)
    : surface_(std::move(surface)),
      is_painted_(std::move(is_painted)),
      boxes_(triangle_boxes(surface_)),
      slack_m_(kSlack * extent_m(surface_.vertices).norm()) {}

PaintedPart::PaintedPart(TetMesh volume, std::vector<char> is_painted)
    : volume_(std::move(volume)),
      is_painted_(std::move(is_painted)),
      boxes_(tet_boxes(volume_)),
      slack_m_(kSlack * extent_m(volume_.nodes).norm()),
      interiors_(volume_.tets.rows()) {
  for (Eigen::Index t = 0; t < volume_.tets.rows(); ++t) {
    const auto painted = std::count(&is_painted_[4 * t], &is_painted_[4 * t] + 4, 1);
    if (painted != 0 && painted != 4) continue;
    Interior& tet = interiors_[t];
    for (int k = 0; k < 4; ++k) {
      const auto corner = [&](int i) -> Vec3 {
        return volume_.nodes.row(volume_.tets(t, (k + i) % 4));
      };
      Vec3 inward = (corner(2) - corner(1)).cross(corner(3) - corner(1)).normalized();
      if (inward.dot(corner(0) - corner(1)) < 0) inward = -inward;
      tet.normal.row(k) = inward;
      tet.offset_m[k] = inward.dot(corner(1));
    }
  }
}

// The tets that hold a place decide, unless one of them is painted in part.
std::optional<bool> PaintedPart::decided_by_holders(const Vec3& place) const {
  bool is_any = false, is_painted = false, is_in_part = false;
  double squared_best = slack_m_ * slack_m_;
  boxes_.visit_nearest(place, squared_best, [&](std::int32_t t, double& best) {
    const Interior& tet = interiors_[t];
    if ((tet.normal * place - tet.offset_m).minCoeff() < -slack_m_) return;
    is_any = true;
    is_in_part |= tet.normal.isZero();
    is_painted |= !tet.normal.isZero() && is_painted_[4 * t] != 0;
    if (is_painted) best = -1;  // ends the search
  });
  return is_painted              ? std::optional(true)
         : is_any && !is_in_part ? std::optional(false)
                                 : std::nullopt;
}

bool PaintedPart::contains(const Vec3& place) const {
  const auto is_painted = [&](std::int32_t cell, const auto& weight) {
    double painted = 0;
    for (Eigen::Index k = 0; k < weight.size(); ++k)
      if (is_painted_[weight.size() * cell + k]) painted += weight[k];
    return painted >= kHalf;
  };
  // The nearest place decides, and of places as near one that is painted.
  const auto decide = [&](const auto& nearest) {
    const auto any = nearest(kAnywhere, [](const auto&) { return true; });
    return any && nearest(any->distance_m + slack_m_, [&](const auto& at) {
                    if constexpr (requires { at.tet; })
                      return is_painted(at.tet, at.weight);
                    else
                      return is_painted(at.triangle, at.weight);
                  }).has_value();
  };
  if (is_on_faces())
    return decide([&](double max_m, auto accept) {
      return closest_point(surface_, boxes_, place, max_m, accept);
    });
  if (const auto decided = decided_by_holders(place)) return *decided;
  return decide([&](double max_m, auto accept) {
    return closest_in_volume(volume_, boxes_, place, max_m, accept);
  });
}

}  // namespace palpate
