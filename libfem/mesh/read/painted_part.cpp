#include "libfem/mesh/read/painted_part.hpp"

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
      slack_m_(kSlack * extent_m(volume_.nodes).norm()) {}

bool PaintedPart::contains(const Vec3& place) const {
  const auto is_painted = [&](std::int32_t cell, const auto& weight) {
    double painted = 0;
    for (Eigen::Index k = 0; k < weight.size(); ++k)
      if (is_painted_[static_cast<std::size_t>(weight.size() * cell + k)]) painted += weight[k];
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
  return decide([&](double max_m, auto accept) {
    return closest_in_volume(volume_, boxes_, place, max_m, accept);
  });
}

}  // namespace palpate
