#pragma once

#include <vector>

#include "libfit/core/geometry.hpp"
#include "tools/workshop/rivals/rival.hpp"

namespace palpate::tools {

/// A point of the fine surface that moves with a tet, by barycentric weights that may be below 0.
struct CarriedPoint {
  int tet = 0;
  Eigen::Vector4d weight = Eigen::Vector4d::Zero();
  double area_m2 = 0;
};

/// A coarse body of linear tetrahedra that carries points of a fine surface, which touch.
struct CoarseBody {
  Points nodes;
  Tets tets;
  std::vector<char> is_held;
  Eigen::VectorXd young_Pa, poisson;  ///< of each tet
  std::vector<CarriedPoint> carried;
};

/// Three points on each triangle of a surface of which a corner is near a place (within_m).
std::vector<CarriedPoint> carried_points(const Points& nodes, const Tets& tets,
                                         const Surface& surface, const Points& places,
                                         double within_m);

/// A coarse body of a run with its mesh in words.
struct CoarseMesh {
  CoarseBody body;
  std::string words;
  double cpu_s = 0;  ///< of making it
};

/// Bodies of a run from even meshes of few nodes to graded ones; without the even ones, whose
/// surface lies millimetres off, where it must touch by itself. Each is tet by tet of small strain.
std::vector<CoarseMesh> coarse_meshes(const RivalBody& body, bool with_even);

/// Edges of a tet from its first corner, as columns.
Mat3 edges_of(const Points& nodes, const Tets& tets, Eigen::Index tet);
/// Gradients of a tet's four linear shape functions, as rows, from the inverse of its edges.
Eigen::Matrix<double, 4, 3> shape_gradients(const Mat3& inverse_edges);

/// How a ball touches the points that a body carries.
struct BallContact {
  double radius_m = 0, friction = 0;
  double penalty_Pa_m = 0;  ///< pressure over depth of overlap
};

/// Push of a ball on a carried point [N] and its stiffness [N/m].
struct CarriedPush {
  Vec3 force = Vec3::Zero();
  Mat3 tangent = Mat3::Zero();
};

/// Contact of a ball with the points that a coarse body carries: a penalty on each, Coulomb
/// friction by a tangential spring that slips at the limit.
class CarriedContact {
 public:
  CarriedContact(const CoarseBody& body, const BallContact& ball);

  void start();
  /// A tick with the ball about centre_m begins: finds the points about it. False without any.
  bool gather(const Points& u, const Vec3& centre_m);
  /// Calls `add(carried point, push)` for each point that the ball touches at displacements u;
  /// returns whether there is one.
  template <class Add>
  bool each_touch(const Points& u, const Add& add) {
    bool touches = false;
    CarriedPush push;
    for (const std::size_t point : near_)
      if (push_on(point, u, push)) add(body_.carried[point], push), touches = true;
    return touches;
  }
  /// The tick ends at displacements u: what is held is held from here.
  void remember(const Points& u);

 private:
  // What a carried point did: its side force, and where it was at the last tick.
  struct CarriedTouch {
    Vec3 side_N = Vec3::Zero(), side_before_N = Vec3::Zero(), place_before_m = Vec3::Zero();
    bool is_pressed = false;
  };

  Vec3 place_of(std::size_t point, const Points& u) const;
  bool push_on(std::size_t point, const Points& u, CarriedPush& push);

  const CoarseBody& body_;
  BallContact ball_;
  std::vector<CarriedTouch> touch_;  // of each carried point
  std::vector<std::size_t> near_;    // of them, about the ball
  bool has_centre_ = false;
  Vec3 centre_m_ = Vec3::Zero(), moved_m_ = Vec3::Zero();
};

}  // namespace palpate::tools
