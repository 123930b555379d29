#pragma once

#include <array>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate::scan {

/// Regular grid of nodes over a region of a sphere (azimuthal equidistant coordinates), and a
/// height field on it. Heights [m] are inward and are coefficients of bicubic B-splines, so that
/// normals are smooth; whatever else nodes own is blended bilinearly. A cell has the nodes (i, j)
/// to (i + 1, j + 1).
class Nodes {
 public:
  static constexpr int kHeights = 16;  ///< nodes that the height in a cell depends on

  /// Nodes of a cell's corners, and of the B-splines alive there.
  struct Cell {
    std::array<int, 4> corner;
    std::array<int, kHeights> height;
  };
  /// A place in a cell: bilinear weights of its corners, and the B-splines with their slopes [1/m].
  struct CellPlace {
    int cell = -1;  ///< -1: outside
    std::array<double, 4> corner{};
    std::array<double, kHeights> height{}, slope1{}, slope2{};
  };

  /// points: # x 3 [m], that the cells with a margin of one shall cover. inward: mean of unit
  /// normals. curvature_1_m: of the sphere; a plane is one with a thousand times the points'
  /// extent.
  Nodes(const Points& points, const Vec3& inward, double spacing_m, double curvature_1_m = 0);

  int count() const { return columns_ * rows_; }
  int cells() const { return static_cast<int>(cell_.size()); }
  double spacing_m() const { return spacing_m_; }
  const Cell& cell(int c) const { return cell_[c]; }
  /// Pairs and triples of neighbouring nodes along both axes, for differences.
  std::vector<std::array<int, 2>> pairs() const;
  std::vector<std::array<int, 3>> triples() const;

  /// A node without height.
  Vec3 position(int node) const {
    return position(spacing_m_ * (node / rows_), spacing_m_ * (node % rows_), 0);
  }
  /// Point of two coordinates along the sphere and the height [m], and the reverse.
  Vec3 position(double first, double second, double height_m) const;
  Vec3 coordinates(const Vec3& point) const;
  /// Gradients of the three coordinates at a point, in its columns.
  Mat3 gradients(const Vec3& point) const;
  /// cell: of which the place is taken; -1: the one that the coordinates lie in.
  CellPlace at(double first, double second, int cell = -1) const;
  /// Point of the height field with its inward unit normal.
  struct Foot {
    CellPlace place;
    Vec3 position = Vec3::Zero(), normal = Vec3::Zero();
    double depth_m = 0;  ///< of the point asked for, along the normal
  };
  /// Foot of a point. Fixed point iteration: exact where the surface bends by less than its depth.
  Foot foot(const Vec3& point, const Eigen::VectorXd& height) const;

  /// The height field as triangles, each cell as `parts` x `parts` squares; vertices are shared.
  struct NodeMesh {
    Surface surface;
    std::vector<CellPlace> vertex;   ///< where each vertex is
    std::vector<int> triangle_cell;  ///< of each triangle
  };
  NodeMesh mesh(const Eigen::VectorXd& height, int parts) const;

 private:
  Vec3 axis_[3], center_;  // the third from the grid's middle to the center
  double spacing_m_, radius_m_, origin_[2] = {};
  int columns_ = 0, rows_ = 0;
  std::vector<Cell> cell_;
  std::vector<std::array<int, 2>> index_;  // of each cell
  std::vector<int> cell_at_;               // of each square of the grid; -1: none
};

}  // namespace palpate::scan
