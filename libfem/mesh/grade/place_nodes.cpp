#include "libfem/mesh/grade/grade_steps.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <utility>

#include "libfem/mesh/topology.hpp"

namespace palpate::fem {
namespace {

// A right angle between neighbouring facets bulges by 0.21 of an edge; farther off is another
// sheet.
constexpr double kMoveLimit = 0.35;
constexpr double kSpoilt = 0.2;  // of the straight element: below it Newton steps start to invert

double volume_of(const std::vector<Vec3>& x, const std::array<std::int32_t, 4>& n) {
  return six_volumes(x[n[0]], x[n[1]], x[n[2]], x[n[3]]);
}

// A node without a goal is as far off as the surface's nearest facet.
double offset_of(const SmoothSurface& surface, const Vec3& node, const Vec3& goal, char is_lost) {
  return is_lost ? surface.closest(node).distance_m : (node - goal).norm();
}

// Mean length of the boundary edges at each base node, 0 inside. Every edge counts twice.
std::vector<double> boundary_spacing(const TetMesh& base, const std::vector<BoundaryFace>& faces) {
  std::vector<double> sum(base.nodes.rows(), 0.0);
  std::vector<int> count(sum.size(), 0);
  for (const auto [tet, face] : faces)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = base.tets(tet, kTetFace[face][k]);
      const std::int32_t b = base.tets(tet, kTetFace[face][(k + 1) % 3]);
      const double length_m = (base.nodes.row(a) - base.nodes.row(b)).norm();
      for (const std::int32_t n : {a, b}) {
        sum[n] += length_m;
        ++count[n];
      }
    }
  for (std::size_t n = 0; n < sum.size(); ++n)
    if (count[n] > 0) sum[n] /= count[n];
  return sum;
}

// Moves nodes from start to goal, all the distance where is_spoilt(element, positions) allows it
// for all elements around, else half, a quarter or none of it. All spoilt elements are found before
// any node is drawn back, so the result does not depend on their order.
template <class NodesOf, class IsSpoilt>
std::vector<Vec3> move_unless_spoilt(const std::vector<Vec3>& start, const std::vector<Vec3>& goal,
                                     std::size_t elements, NodesOf&& nodes_of,
                                     IsSpoilt&& is_spoilt) {
  std::vector<Vec3> at = goal;
  std::vector<double> scale(start.size(), 1.0);
  std::vector<char> is_suspect(elements, 1), is_moved(start.size(), 0);
  for (;;) {
    std::vector<std::int32_t> back;
    for (std::size_t e = 0; e < elements; ++e)
      if (is_suspect[e] && is_spoilt(e, at))
        for (const std::int32_t n : nodes_of(e))
          if (scale[n] > 0 && goal[n] != start[n]) back.push_back(n);
    sort_unique(back);
    if (back.empty()) return at;

    std::fill(is_moved.begin(), is_moved.end(), 0);
    for (const std::int32_t n : back) {
      scale[n] = scale[n] > 0.125 ? scale[n] / 2 : 0;  // three halvings, then the move is dropped
      at[n] = start[n] + scale[n] * (goal[n] - start[n]);
      is_moved[n] = 1;
    }
    for (std::size_t e = 0; e < elements; ++e) {
      is_suspect[e] = 0;
      for (const std::int32_t n : nodes_of(e)) is_suspect[e] |= is_moved[n];
    }
  }
}

// Positions of inside nodes by which what boundary nodes move spreads evenly: springs along the
// edges, as stiff as the edges are short. The middle of moved parents follows the boundary no
// better than its parents did, so a fine mesh under a base face that is far off is crushed.
void spread(const BisectedMesh& mesh, const Boundary& boundary, std::vector<Vec3>& at) {
  std::vector<Eigen::Index> row(at.size(), -1);
  Eigen::Index rows = 0;
  for (std::size_t n = 0; n < at.size(); ++n)
    if (boundary.kind[n] == NodeKind::inside) row[n] = rows++;
  if (rows == 0) return;
  std::vector<Eigen::Triplet<double>> springs;
  Points load = Points::Zero(rows, 3);
  for (const BisectedTet& tet : mesh.tets)
    for (const auto& edge : kTetEdge)
      for (int end = 0; end < 2; ++end) {
        const std::int32_t a = tet.node[edge[end]], b = tet.node[edge[1 - end]];
        if (row[a] < 0) continue;
        const double stiffness = 1 / (mesh.nodes[a] - mesh.nodes[b]).norm();
        springs.emplace_back(row[a], row[a], stiffness);
        if (row[b] >= 0)
          springs.emplace_back(row[a], row[b], -stiffness);
        else
          load.row(row[a]) += stiffness * (at[b] - mesh.nodes[b]).transpose();
      }
  Eigen::SparseMatrix<double> laplacian(rows, rows);
  laplacian.setFromTriplets(springs.begin(), springs.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(laplacian);
  if (factor.info() != Eigen::Success) return;
  const Points moved = factor.solve(load);
  for (std::size_t n = 0; n < at.size(); ++n)
    if (row[n] >= 0) at[n] = mesh.nodes[n] + Vec3(moved.row(row[n]));
}

// On the surface that faces `direction`, else on what is nearest: creases are not sought.
std::optional<Vec3> place_anywhere(const SmoothSurface& surface, const Vec3& guess,
                                   const Vec3& direction, double spacing_m) {
  if (const auto place = place_on(surface, guess, NodeKind::smooth, direction, spacing_m))
    return place;
  const SurfaceHit nearest = surface.closest(guess);
  if (nearest.distance_m > kMoveLimit * spacing_m) return std::nullopt;
  return nearest.position;
}

}  // namespace

std::optional<Vec3> place_on(const SmoothSurface& surface, const Vec3& guess, NodeKind kind,
                             const Vec3& direction, double spacing_m) {
  const double limit = kMoveLimit * spacing_m;
  if (kind != NodeKind::smooth) {
    // A thin round rim looks creased in a coarse base; only the surface's own creases count.
    if (const auto crease = surface.closest_crease(guess, limit))
      return kind == NodeKind::corner ? guess : *crease;
  }
  // Within 60 degrees it is never the other side, nor beyond an edge.
  const auto hit = surface.closest(guess, direction, 0.5);
  if (!hit || (hit->position - guess).norm() > limit) return std::nullopt;
  return hit->position;
}

Boundary classify_boundary(const TetMesh& base, const BisectedMesh& mesh) {
  Boundary out;
  out.spacing_m = boundary_spacing(base, mesh.base_faces);
  out.kind.assign(mesh.nodes.size(), NodeKind::inside);
  out.direction.assign(mesh.nodes.size(), Vec3::Zero());
  struct EdgeFaces {
    Vec3 normal;
    int faces;
  };
  std::vector<EdgeFaces> side;  // per edge: normal of its first face, number of faces
  const double crease_cosine = std::cos(SmoothSurface::kCreaseAngle_rad);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (int f = 0; f < 4; ++f) {
      if (mesh.tets[t].face[f] < 0) continue;
      out.faces.push_back({static_cast<std::int32_t>(t), f});
      std::int32_t n[3];
      for (int k = 0; k < 3; ++k) n[k] = mesh.tets[t].node[kTetFace[f][k]];
      const Vec3 area =
          (mesh.nodes[n[1]] - mesh.nodes[n[0]]).cross(mesh.nodes[n[2]] - mesh.nodes[n[0]]);
      const Vec3 normal = area.stableNormalized();
      for (int k = 0; k < 3; ++k) {
        out.kind[n[k]] = NodeKind::smooth;
        out.direction[n[k]] += area;
        const std::int32_t a = n[k], b = n[(k + 1) % 3];
        const auto [e, is_new] =
            out.edge_of.insert(a, b, static_cast<std::int32_t>(out.edges.size()));
        if (is_new) {
          out.edges.push_back({a, b, Vec3::Zero(), false});
          side.push_back({normal, 0});
        } else if (side[e].normal.dot(normal) < crease_cosine) {
          out.edges[e].is_crease = true;
        }
        out.edges[e].direction += normal;
        ++side[e].faces;
      }
    }

  std::vector<int> creases(mesh.nodes.size(), 0);
  for (std::size_t e = 0; e < out.edges.size(); ++e) {
    if (side[e].faces != 2) out.edges[e].is_crease = true;  // two sheets meet in it
    if (!out.edges[e].is_crease) continue;
    ++creases[out.edges[e].a];
    ++creases[out.edges[e].b];
  }
  for (std::size_t n = 0; n < creases.size(); ++n)
    if (creases[n] > 0) out.kind[n] = creases[n] == 2 ? NodeKind::crease : NodeKind::corner;
  return out;
}

NodePlacement place_corners(const BisectedMesh& mesh, const Boundary& boundary,
                            const SmoothSurface& surface, Placing placing) {
  std::vector<Vec3> goal = mesh.nodes;
  std::vector<char> is_lost(goal.size(), 0);
  for (std::size_t n = 0; n < goal.size(); ++n) {
    double spacing_m = 0;
    if (n < static_cast<std::size_t>(mesh.base_nodes)) {
      spacing_m = boundary.spacing_m[n];
    } else {
      const auto [a, b] = mesh.parents[n - mesh.base_nodes];
      goal[n] = 0.5 * (goal[a] + goal[b]);
      spacing_m = (goal[a] - goal[b]).norm();
    }
    if (boundary.kind[n] == NodeKind::inside) continue;
    const auto place =
        placing == Placing::by_birth
            ? place_on(surface, goal[n], boundary.kind[n], boundary.direction[n], spacing_m)
            : place_anywhere(surface, goal[n], boundary.direction[n], spacing_m);
    is_lost[n] = !place;
    if (place) goal[n] = *place;
  }
  if (placing == Placing::spread) spread(mesh, boundary, goal);

  NodePlacement out;
  out.nodes = move_unless_spoilt(
      mesh.nodes, goal, mesh.tets.size(), [&](std::size_t t) { return mesh.tets[t].node; },
      [&](std::size_t t, const std::vector<Vec3>& at) {
        return volume_of(at, mesh.tets[t].node) <
               kSpoilt * volume_of(mesh.nodes, mesh.tets[t].node);
      });
  out.offset_m.assign(goal.size(), 0.0);
  for (std::size_t n = 0; n < goal.size(); ++n)
    if (boundary.kind[n] != NodeKind::inside)
      out.offset_m[n] = offset_of(surface, out.nodes[n], goal[n], is_lost[n]);
  return out;
}

NodePlacement place_middles(const BisectedMesh& mesh, const Boundary& boundary,
                            const std::vector<Vec3>& corners, const SmoothSurface& surface) {
  const std::size_t count = boundary.edges.size();
  std::vector<Vec3> start(count), goal(count);
  std::vector<char> is_lost(count, 0);
  for (std::size_t e = 0; e < count; ++e) {
    const BoundaryEdge& edge = boundary.edges[e];
    start[e] = goal[e] = 0.5 * (corners[edge.a] + corners[edge.b]);
    const auto place =
        place_on(surface, start[e], edge.is_crease ? NodeKind::crease : NodeKind::smooth,
                 edge.direction, (corners[edge.a] - corners[edge.b]).norm());
    is_lost[e] = !place;
    if (place) goal[e] = *place;
  }

  // Only tets with an edge on the boundary can be spoilt; a tet has at most six such nodes.
  struct Curved {
    std::size_t tet;
    std::array<std::int32_t, 6> edge;  // into boundary.edges, -1 inside
    std::vector<std::int32_t> movable;
  };
  std::vector<Curved> curved;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    Curved tet{t, {}, {}};
    for (int k = 0; k < 6; ++k) {
      const auto& n = mesh.tets[t].node;
      tet.edge[k] = boundary.edge_of.find(n[kTetEdge[k][0]], n[kTetEdge[k][1]]);
      if (tet.edge[k] >= 0) tet.movable.push_back(tet.edge[k]);
    }
    if (!tet.movable.empty()) curved.push_back(std::move(tet));
  }

  NodePlacement out;
  out.nodes = move_unless_spoilt(
      start, goal, curved.size(),
      [&](std::size_t c) -> const std::vector<std::int32_t>& { return curved[c].movable; },
      [&](std::size_t c, const std::vector<Vec3>& at) {
        const auto& n = mesh.tets[curved[c].tet].node;
        TetNodes nodes;
        for (int k = 0; k < 4; ++k) nodes[k] = corners[n[k]];
        for (int k = 0; k < 6; ++k)
          nodes[4 + k] = curved[c].edge[k] >= 0
                             ? at[curved[c].edge[k]]
                             : Vec3(0.5 * (nodes[kTetEdge[k][0]] + nodes[kTetEdge[k][1]]));
        return smallest_jacobian(nodes) < kSpoilt * volume_of(corners, n);
      });
  out.offset_m.resize(count);
  for (std::size_t e = 0; e < count; ++e)
    out.offset_m[e] = offset_of(surface, out.nodes[e], goal[e], is_lost[e]);
  return out;
}

double jacobian_determinant(const TetNodes& nodes, const Eigen::Vector4d& at) {
  Eigen::Matrix<double, 3, 4> by_coordinate;  // dx/dL_k, the four taken as independent
  for (int k = 0; k < 4; ++k) by_coordinate.col(k) = (4 * at[k] - 1) * nodes[k];
  for (int e = 0; e < 6; ++e) {
    const int a = kTetEdge[e][0], b = kTetEdge[e][1];
    by_coordinate.col(a) += 4 * at[b] * nodes[4 + e];
    by_coordinate.col(b) += 4 * at[a] * nodes[4 + e];
  }
  Mat3 jacobian;
  for (int k = 0; k < 3; ++k) jacobian.col(k) = by_coordinate.col(k + 1) - by_coordinate.col(0);
  return jacobian.determinant();
}

double smallest_jacobian(const TetNodes& nodes) {
  double smallest = jacobian_determinant(nodes, Eigen::Vector4d::Constant(0.25));
  for (int k = 0; k < 4; ++k) {
    Eigen::Vector4d at = Eigen::Vector4d::Constant(0.13819660112501050);  // degree-2 rule
    at[k] = 0.58541019662496852;
    smallest = std::min({smallest, jacobian_determinant(nodes, at),
                         jacobian_determinant(nodes, Eigen::Vector4d::Unit(k))});
  }
  return smallest;
}

}  // namespace palpate::fem
