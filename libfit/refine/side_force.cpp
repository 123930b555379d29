#include "libfit/refine/side_force.hpp"

#include <Eigen/Dense>
#include <array>

#include "libfit/core/geometry.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate {
namespace {

constexpr int kDepths = 4;        // where energies are compared
constexpr double kHalfWay = 0.5;  // least error of held-out paths; all the way, least mismatch

/// Side force of a vertex over its press where curves end, by (M22), at most. Sound bodies have 4;
/// beside a point without good rows a slope is that of what is not known, and the engine refuses
/// 100 (runtime::is_side_carried).
constexpr double kMaxSide = 10;

// Reads the curves of a model of rings.
class SideForceReader {
 public:
  explicit SideForceReader(const Model& model)
      : model_(model), tables_(tabulate(model.curves.basis[0])) {}

  double depth_m(int step) const { return tables_.knots.back() * (step + 1) / kDepths; }
  double force_N(Eigen::Index vertex, double depth_m) const {
    return runtime::curve_value(view(), normal(vertex), depth_m);
  }
  Vec3 side_N(Eigen::Index vertex, double d) const {
    const auto& control = model_.curves.control;
    return (d * d * control[runtime::kSide2].row(vertex) +
            d * d * d * control[runtime::kSide3].row(vertex))
        .transpose();
  }
  bool is_covered(const Eigen::RowVector3i& triangle) const {
    for (int k = 0; k < 3; ++k)
      if (!model_.is_covered[static_cast<std::size_t>(triangle[k])]) return false;
    return true;
  }
  // Gradient of the normal energy over a triangle at a depth [N], and twice the triangle's area
  // along its normal.
  struct Slope {
    Vec3 slope_N, normal_m2;
  };
  Slope slope(const Eigen::RowVector3i& triangle, double depth_m) const {
    std::array<Vec3, 3> corner;
    std::array<double, 3> energy_J{};
    for (int k = 0; k < 3; ++k) {
      const auto at = static_cast<std::size_t>(k);
      corner[at] = model_.surface.vertices.row(triangle[k]);
      energy_J[at] = runtime::curve_energy(view(), normal(triangle[k]), depth_m);
    }
    const Vec3 ab = corner[1] - corner[0], ac = corner[2] - corner[0], n = ab.cross(ac);
    return {
        ((energy_J[1] - energy_J[0]) * ac.cross(n) + (energy_J[2] - energy_J[0]) * n.cross(ab)) /
            n.squaredNorm(),
        n};
  }

 private:
  runtime::SplineView view() const {
    return {tables_.degree, tables_.pieces, tables_.knots.data(), tables_.weights.data(),
            tables_.integrals.data()};
  }
  const double* normal(Eigen::Index vertex) const {
    return model_.curves.control[0].row(vertex).data();
  }

  const Model& model_;
  SplineTables tables_;
};

void bound_side_force(CurveSet& curves) {
  const double d = curves.basis[0].knots_m.back();
  Controls &square = curves.control[runtime::kSide2], &cube = curves.control[runtime::kSide3];
  for (Eigen::Index v = 0; v < square.rows(); ++v) {
    const double press_N = curves.control[0](v, curves.control[0].cols() - 1),
                 side_N = d * d * (2 * square.row(v).norm() + 3 * d * cube.row(v).norm());
    if (side_N <= kMaxSide * press_N) continue;
    square.row(v) *= kMaxSide * press_N / side_N;
    cube.row(v) *= kMaxSide * press_N / side_N;
  }
}

}  // namespace

NodeShape::NodeShape(const CurveSet& curves, Eigen::Index row, const Vec3& normal, double radius_m)
    : across(Mat3::Identity() - normal * normal.transpose()) {
  double k[6];
  for (int i = 0; i < 6; ++i) k[i] = curves.control[runtime::kCurvature](row, i);
  runtime::offset_curvature(k,
                            runtime::kCurvatureDepth * curves.basis[0].knots_m.back());  // (M15c)
  curvature << k[0], k[3], k[4], k[3], k[1], k[5], k[4], k[5], k[2];
  curvature = (across * curvature * across).eval();
  stretch = (Mat3::Identity() - radius_m * curvature).inverse();
}

SideMismatch side_mismatch(const Model& model) {
  if (model.curves.family != CurveFamily::rings) return {};
  const SideForceReader reader(model);
  const double radius_m = ball_radius_m(model.probe);
  std::vector<double> found;
  for (const auto& t : model.surface.triangles.rowwise()) {
    if (!reader.is_covered(t)) continue;
    for (int step = 0; step < kDepths; ++step) {
      const double d = reader.depth_m(step);
      double force_N = 0;
      Vec3 side_N = Vec3::Zero();
      for (int k = 0; k < 3; ++k) {
        const NodeShape shape(model.curves, t[k], model.inward_normal.row(t[k]), radius_m);
        const Vec3 g = shape.across * reader.side_N(t[k], d);
        side_N += shape.stretch * (g - d * (shape.curvature * g)) / 3;
        force_N += reader.force_N(t[k], d) / 3;
      }
      const auto [slope_N, normal] = reader.slope(t, d);
      const Vec3 flat = side_N - normal * (normal.dot(side_N) / normal.squaredNorm());
      if (force_N > 0) found.push_back((slope_N - flat).norm() / force_N);
    }
  }
  if (found.empty()) return {};
  return {median(found), lower_quantile(found, 0.95), lower_quantile(found, 1)};
}

void meet_slope(Model& model) {
  if (model.curves.family != CurveFamily::rings) return;
  const SideForceReader reader(model);
  const Eigen::Index vertices = model.surface.vertices.rows();
  // Sums over the triangles about a vertex, weighted by area; a border has none.
  Eigen::VectorXd area = Eigen::VectorXd::Zero(vertices);
  Eigen::MatrixXd slope = Eigen::MatrixXd::Zero(vertices, 3 * kDepths);
  std::vector<char> moves(static_cast<std::size_t>(vertices), 1);
  for (const auto& t : model.surface.triangles.rowwise()) {
    const bool is_covered = reader.is_covered(t);
    for (int k = 0; k < 3 && !is_covered; ++k) moves[static_cast<std::size_t>(t[k])] = 0;
    for (int step = 0; step < kDepths && is_covered; ++step) {
      const auto [slope_N, normal] = reader.slope(t, reader.depth_m(step));
      for (int k = 0; k < 3; ++k) {
        slope.row(t[k]).segment<3>(3 * step) += normal.norm() * slope_N.transpose();
        if (step == 0) area[t[k]] += normal.norm();
      }
    }
  }
  for (Eigen::Index v = 0; v < vertices; ++v) {
    if (moves[static_cast<std::size_t>(v)] == 0 || !(area[v] > 0)) continue;
    const NodeShape shape(model.curves, v, model.inward_normal.row(v), ball_radius_m(model.probe));
    Eigen::Matrix2d square = Eigen::Matrix2d::Zero();  // of g / d^2 = g_2 + g_3 d
    Eigen::Matrix<double, 2, 3> right = Eigen::Matrix<double, 2, 3>::Zero();
    for (int step = 0; step < kDepths; ++step) {
      const double d = reader.depth_m(step);
      const Vec3 along = shape.across * slope.row(v).segment<3>(3 * step).transpose() / area[v];
      const Mat3 moved = shape.stretch * (Mat3::Identity() - d * shape.curvature);
      const Vec3 g = moved.partialPivLu().solve(along);
      const Eigen::Vector2d w(1, d);
      square += w * w.transpose();
      right += w * (g / (d * d)).transpose();
    }
    const Eigen::Matrix<double, 2, 3> wanted = square.ldlt().solve(right);
    if (!wanted.allFinite()) continue;
    for (const int k : {0, 1}) {
      auto own = model.curves.control[static_cast<std::size_t>(runtime::kSide2 + k)].row(v);
      own += kHalfWay * (wanted.row(k) - own);
    }
  }
  bound_side_force(model.curves);
  for (const int part : {runtime::kSide2, runtime::kSide3}) {
    Controls& control = model.curves.control[static_cast<std::size_t>(part)];
    control = rounded_to_float(control);
  }
}

}  // namespace palpate
