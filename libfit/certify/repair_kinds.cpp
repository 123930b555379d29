#include "libfit/certify/repair_kinds.hpp"

#include <Eigen/Dense>
#include <algorithm>

#include "libfit/certify/sway_terms.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate::certify {
namespace {

using runtime::AssetView;

constexpr int kDepths = 4;            // where energies are compared
constexpr double kShare = 0.5;        // of the way, a turn at a time: no farther than it takes
constexpr double kMostLift = 0.05;    // of a coefficient of friction
constexpr double kLiftBeyond = 1.01;  // of what is needed
constexpr double kMinFacing = 0.1;    // cosine between a smoothed normal and its triangles'
constexpr double kWithinPull = 0.99;  // of (M22)

using Mat32 = Eigen::Matrix<double, 3, 2>;

/// A triangle at one of its corners, in the asset's axes: how the deflection falls (L) and the
/// normal turns (U) by a step over the facet, whose axes are the columns.
struct FacetCorner {
  Mat32 L, U;
  Eigen::Vector2d sway;  ///< what a sway under 1 N along the normal stores more
  double area;
};
FacetCorner corner_of(const AssetView& asset, const Facet& e, int t, int k) {
  PatchPoint place{{0, 0, 0}};
  place.n[k] = 1;
  const SurfaceTerms<double> frame = frame_at<double>(e, place);
  FacetCorner out{Mat32::Zero(), Mat32::Zero(), {}, 0};
  for (int j = 0; j < 2; ++j) out.sway[j] = sway_stores(e, frame, {1, 0, 0}, 1.0, j == 0, j == 1);
  for (int i = 0; i < 3; ++i) {
    const Vec3 axis(e.axis[i].x, e.axis[i].y, e.axis[i].z);
    for (int j = 0; j < 2; ++j) {
      out.L.col(j) += frame.L[i][j] * axis;
      out.U.col(j) += frame.U[i][j] * axis;
    }
  }
  const runtime::Vec3d normal = asset.area_vector(t);
  out.area = 0.5 * std::sqrt(dot(normal, normal));
  return out;
}

int corner_at(const AssetView& asset, int t, int vertex) {
  for (int k = 0; k < 2; ++k)
    if (asset.corner(t, k) == vertex) return k;
  return 2;
}

Vec3 normal_of(const AssetView& asset, int vertex) {
  const runtime::Vec3d u = asset.normal_at(vertex);
  return {u.x, u.y, u.z};
}

float* part(AssetEdit& edit, int vertex, int which) {
  return edit.node(vertex) + edit.asset().control_offset[which];
}

/// The share of a side force with which the body still pushes (M22) at a vertex.
double pushing_share(const AssetView& asset, int v, const Vec3& two, const Vec3& three,
                     double overshoot_m) {
  const runtime::CornerSpot spot{asset.node(v), asset.control_offset};
  double share = 1;
  for (int step = 1; step <= kDepths; ++step) {
    const double d = asset.max_fitted_m * step / kDepths;
    const double mu = std::max(double(spot.control(runtime::kFriction, 0)) +
                                   double(spot.control(runtime::kFrictionSlope, 0)) * d,
                               0.0),
                 reach_m = mu * d / spot.control(runtime::kLambda, 0) + overshoot_m;
    const runtime::SplineView& view = asset.curves.view[runtime::kNormal];
    const float* control = asset.node(v) + asset.control_offset[runtime::kNormal];
    const double force = runtime::curve_value(view, control, d),
                 energy = runtime::curve_energy(view, control, d);
    share = std::min(
        share, kWithinPull * force / (reach_m * (2 * d * two + 3 * d * d * three).norm() + 1e-30));
    share = std::min(share,
                     kWithinPull * energy / (reach_m * (d * d * (two + d * three)).norm() + 1e-30));
  }
  return share;
}

}  // namespace

Fans::Fans(const AssetView& asset) : first_(static_cast<std::size_t>(asset.vertices) + 1) {
  const auto each = [&](const auto& act) {
    for (int t = 0; t < asset.triangles; ++t) {
      bool is_interior = asset.is_solid(t);
      for (int k = 0; k < 3; ++k)
        is_interior = is_interior && asset.covered[asset.corner(t, k)] == runtime::kMeasured;
      for (int k = 0; k < 3 && is_interior; ++k)
        act(static_cast<std::size_t>(asset.corner(t, k)), t);
    }
  };
  each([&](std::size_t v, int) { ++first_[v + 1]; });
  for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
  item_.resize(first_.back());
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  each([&](std::size_t v, int t) { item_[next[v]++] = t; });
}

// (M26)
void bring_side_force(AssetEdit& edit, const RepairPlan& plan) {
  const AssetView& asset = edit.asset();
  struct SideOfVertex {
    int vertex;
    Vec3 two, three;
  };
  std::vector<SideOfVertex> sides;
  for (const OpenVertex& open : plan.open) {
    Eigen::Matrix<double, 6, 6> square = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    for (const int t : plan.fans.about(open.vertex)) {
      const Facet e = facet_of(asset, t, plan.facet);
      const int k = corner_at(asset, t, open.vertex);
      const FacetCorner corner = corner_of(asset, e, t, k);
      for (int step = 1; step <= kDepths; ++step) {
        const double d = asset.max_fitted_m * step / kDepths;
        const Depth<double> depth = at_depth(asset, e, t, d);
        const Mat32 M = corner.L + d * corner.U;
        const Eigen::Vector2d slope =
            Eigen::Vector2d(depth.energy_slope[0] / d, depth.energy_slope[1] / d) +
            depth.force[k] * depth.force[k] * corner.sway;
        Eigen::Matrix<double, 2, 6> row;
        row << M.transpose(), d * M.transpose();
        square += corner.area * row.transpose() * row;
        right += corner.area * row.transpose() * slope;
      }
    }
    const Vec3 u = normal_of(asset, open.vertex);
    const double d = asset.max_fitted_m, weight = square.trace();
    square.topLeftCorner<3, 3>() += weight * u * u.transpose();
    square.bottomRightCorner<3, 3>() += weight * u * u.transpose();
    square.diagonal().head<3>().array() += 1e-9 * weight;
    square.diagonal().tail<3>().array() += 1e-9 * weight * d * d;
    const Eigen::Matrix<double, 6, 1> g = square.ldlt().solve(right);
    if (!g.allFinite()) continue;
    const double share =
        pushing_share(asset, open.vertex, g.head<3>(), g.tail<3>(), 2 * plan.facet.max_step_m);
    sides.push_back({open.vertex, share * g.head<3>(), share * g.tail<3>()});
  }
  for (const SideOfVertex& side : sides)
    for (int k = 0; k < 3; ++k) {
      float &two = part(edit, side.vertex, runtime::kSide2)[k],
            &three = part(edit, side.vertex, runtime::kSide3)[k];
      two += static_cast<float>(kShare * (side.two[k] - double(two)));
      three += static_cast<float>(kShare * (side.three[k] - double(three)));
    }
}

void smooth_normals(AssetEdit& edit, const RepairPlan& plan) {
  const AssetView& asset = edit.asset();
  std::vector<std::pair<int, Vec3>> found;
  for (const OpenVertex& open : plan.open) {
    Vec3 mean = Vec3::Zero();
    for (const int t : plan.fans.about(open.vertex))
      for (int k = 0; k < 3; ++k)
        if (asset.corner(t, k) != open.vertex) mean += normal_of(asset, asset.corner(t, k));
    const Vec3 u =
        ((1 - kShare) * normal_of(asset, open.vertex) + kShare * mean.normalized()).normalized();
    bool faces = mean.norm() > 0;
    for (const int t : plan.fans.about(open.vertex)) {
      const runtime::Vec3d area = asset.area_vector(t);
      faces = faces && -Vec3(area.x, area.y, area.z).normalized().dot(u) > kMinFacing;
    }
    if (faces) found.emplace_back(open.vertex, u);
  }
  for (const auto& [v, u] : found) {
    float* out = edit.normal(v);
    for (int k = 0; k < 3; ++k) out[k] = static_cast<float>(u[k]);
  }
}

// (M27)
void lift_friction(AssetEdit& edit, const RepairPlan& plan) {
  const double most_m = edit.asset().max_fitted_m;
  const auto largest = [&](const AssetView& asset, int v) {
    const float* mu = asset.node(v) + asset.control_offset[runtime::kFriction];
    const float* slope = asset.node(v) + asset.control_offset[runtime::kFrictionSlope];
    return std::max(double(*mu), double(*mu) + double(*slope) * most_m);
  };
  for (const OpenVertex& open : plan.open) {
    const double now = largest(edit.asset(), open.vertex),
                 most = largest(plan.original, open.vertex) + kMostLift;
    if (!(now > 0)) continue;
    const double factor =
        std::max(1.0, std::min(kLiftBeyond * std::max(open.ratio, 1.0), most / now));
    for (const int which : {runtime::kFriction, runtime::kFrictionSlope}) {
      float& number = part(edit, open.vertex, which)[0];
      number = static_cast<float>(number * factor);
    }
  }
}

}  // namespace palpate::certify
