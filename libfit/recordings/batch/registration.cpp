#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/linear_algebra.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/recordings/batch/batch.hpp"

namespace palpate::recordings {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;

Points moved(const Points& points, const RigidMotion& motion) {
  Points out(points.rows(), 3);
  for (Eigen::Index i = 0; i < points.rows(); ++i) out.row(i) = motion(points.row(i));
  return out;
}

// The small motion that minimises distances along the normals of the nearest surface points.
RigidMotion step_towards(const Points& points,
                         const std::vector<std::optional<SurfacePlace>>& places) {
  std::vector<double> sizes;
  for (const auto& place : places) sizes.push_back(place ? place->distance_m : 0);
  const double limit_m =
      3 * upper_median(sizes) / kMedianOfNormal + std::numeric_limits<double>::min();
  const Vec3 centre = points.colwise().mean();
  const double scale = std::max((points.rowwise() - centre.transpose()).rowwise().norm().mean(),
                                std::numeric_limits<double>::min());
  Eigen::Matrix<double, 6, 6> normal_matrix = Eigen::Matrix<double, 6, 6>::Zero();
  Vec6 right = Vec6::Zero();
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const auto& place = places[i];
    if (!place || place->distance_m > limit_m) continue;
    const Vec3 p = (Vec3(points.row(i)) - centre) / scale;
    Vec6 row;
    row << p.cross(place->inward), place->inward;
    normal_matrix += row * row.transpose();
    right += row * place->inward.dot(place->position_m - Vec3(points.row(i))) / scale;
  }
  // Motions stay that change distances by less than a twentieth of what the best determined does: a
  // smooth patch leaves turns about its normal, and slides, to the start.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> motions(normal_matrix);
  Vec6 x = Vec6::Zero();
  for (int k = 0; k < 6; ++k)
    if (const double known = motions.eigenvalues()[k]; known > 0.003 * motions.eigenvalues()[5])
      x += motions.eigenvectors().col(k) * motions.eigenvectors().col(k).dot(right) / known;
  const Vec3 turn = x.head<3>();
  RigidMotion step;
  if (turn.norm() > 0)
    step.rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  step.translation_m = centre + scale * Vec3(x.tail<3>()) - step.rotation * centre;
  return step;
}

}  // namespace

Registration register_landmarks(const Points& from, const Points& to) {
  if (from.rows() < 3 || from.rows() != to.rows())
    throw Error("registration", fmt::format("has {} landmarks", from.rows()),
                "Give at least three pairs.");
  for (const Points* points : {&from, &to}) {
    const Points spread = points->rowwise() - points->colwise().mean();
    const Mat3 squares = spread.transpose() * spread;
    const Vec3 widths = symmetric_eigen(squares).values;
    if (!(widths[1] > 1e-6 * 1e-6 * widths[2]))
      throw Error("registration", "the landmarks lie on one line", "Add a landmark away from it.");
  }
  const Eigen::Matrix4d motion =
      Eigen::umeyama(Eigen::Matrix3Xd(from.transpose()), Eigen::Matrix3Xd(to.transpose()), false);
  Registration out;
  out.motion = {motion.topLeftCorner<3, 3>(), motion.topRightCorner<3, 1>()};
  const Eigen::VectorXd left = (moved(from, out.motion) - to).rowwise().norm();
  out.rms_m = std::sqrt(left.squaredNorm() / static_cast<double>(left.size()));
  out.largest_m = left.maxCoeff();
  return out;
}

Registration register_to_surface(const Points& points, const Surface& surface,
                                 const RigidMotion& start) {
  if (points.rows() < 6)
    throw Error("registration",
                fmt::format("has {} contact points to fit to the surface", points.rows()),
                "Give at least six, or landmarks alone.");
  Registration out;
  out.motion = start;
  const double extent = extent_m(surface.vertices).norm();
  std::vector<std::optional<SurfacePlace>> places;
  for (out.iterations = 1; out.iterations <= 50; ++out.iterations) {
    const Points here = moved(points, out.motion);
    places = project(here, surface);
    const RigidMotion step = step_towards(here, places);
    out.motion = {step.rotation * out.motion.rotation, step(out.motion.translation_m)};
    if ((moved(here, step) - here).rowwise().norm().maxCoeff() < 1e-9 * extent) break;
  }
  places = project(moved(points, out.motion), surface);
  double squares = 0;
  for (const auto& place : places) {
    if (!place) continue;
    squares += place->distance_m * place->distance_m;
    out.largest_m = std::max(out.largest_m, place->distance_m);
  }
  out.rms_m = std::sqrt(squares / static_cast<double>(points.rows()));
  return out;
}

std::vector<std::optional<SurfacePlace>> project(const Points& points, const Surface& surface) {
  const BoxTree boxes = triangle_boxes(surface);
  const Points outward = vertex_normals(surface);
  std::vector<std::optional<SurfacePlace>> places(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const auto hit = closest_point(surface, boxes, points.row(i));
    if (!hit) continue;
    SurfacePlace place{hit->position, Vec3::Zero(), hit->distance_m};
    for (int k = 0; k < 3; ++k)
      place.inward -= hit->weight[k] * Vec3(outward.row(surface.triangles(hit->triangle, k)));
    if (!(place.inward.norm() > 1e-12)) continue;
    place.inward.normalize();
    places[i] = place;
  }
  return places;
}

}  // namespace palpate::recordings
