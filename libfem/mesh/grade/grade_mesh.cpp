#include "libfem/mesh/grade/grade_mesh.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>

#include "libfem/mesh/grade/grade_steps.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

// Corners of all tets and their mid-edge nodes, those of boundary edges first.
void number_nodes(const BisectedMesh& mesh, const Boundary& boundary, const NodePlacement& corners,
                  const NodePlacement& middles, QuadraticMesh& out) {
  const auto corner_count = static_cast<std::int32_t>(corners.nodes.size());
  std::vector<Vec3> nodes = corners.nodes;
  nodes.insert(nodes.end(), middles.nodes.begin(), middles.nodes.end());
  EdgeMap inner(mesh.tets.size() * 2);
  out.tets.resize(mesh.tets.size(), 10);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const auto& n = mesh.tets[t].node;
    const auto row = static_cast<Eigen::Index>(t);
    for (int k = 0; k < 4; ++k) out.tets(row, k) = n[k];
    for (int k = 0; k < 6; ++k) {
      const std::int32_t a = n[kTetEdge[k][0]], b = n[kTetEdge[k][1]];
      const std::int32_t edge = boundary.edge_of.find(a, b);
      if (edge >= 0) {
        out.tets(row, 4 + k) = corner_count + edge;
        continue;
      }
      const auto [node, is_new] = inner.insert(a, b, static_cast<std::int32_t>(nodes.size()));
      if (is_new) nodes.push_back(0.5 * (corners.nodes[a] + corners.nodes[b]));
      out.tets(row, 4 + k) = node;
    }
  }
  out.nodes = rows_of(nodes);
}

void list_faces(const BisectedMesh& mesh, const Boundary& boundary, QuadraticMesh& out) {
  const auto corner_count = static_cast<std::int32_t>(mesh.nodes.size());
  out.faces.resize(boundary.faces.size(), 6);
  for (std::size_t f = 0; f < boundary.faces.size(); ++f) {
    const auto [tet, face] = boundary.faces[f];
    std::int32_t n[3];
    for (int k = 0; k < 3; ++k) n[k] = mesh.tets[tet].node[kTetFace[face][k]];
    for (int k = 0; k < 3; ++k) {
      out.faces(f, k) = n[k];
      out.faces(f, 3 + k) = corner_count + boundary.edge_of.find(n[k], n[(k + 1) % 3]);
    }
  }
}

// Parts of base faces and base tets that are held at every corner are held throughout, and so are
// new nodes at held places and corner nodes on the border of what is held.
void hold(const TetMesh& base, const std::vector<char>& is_held, const HeldAt& held_at,
          const std::vector<char>& is_border, const BisectedMesh& mesh, const Boundary& boundary,
          QuadraticMesh& out) {
  out.is_held.assign(out.nodes.rows(), 0);
  std::copy(is_held.begin(), is_held.end(), out.is_held.begin());
  std::vector<char> is_face_held;
  for (const auto [tet, face] : mesh.base_faces) {
    char all = 1;
    for (const int corner : kTetFace[face]) all &= is_held[base.tets(tet, corner)] != 0;
    is_face_held.push_back(all);
  }
  for (std::size_t f = 0; f < boundary.faces.size(); ++f) {
    const auto [tet, face] = boundary.faces[f];
    if (!is_face_held[mesh.tets[tet].face[face]]) continue;
    for (const std::int32_t n : out.faces.row(f)) out.is_held[n] = 1;
  }
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    bool is_all = true;
    for (const std::int32_t n : base.tets.row(mesh.tets[t].base)) is_all &= is_held[n] != 0;
    if (!is_all) continue;
    for (const std::int32_t n : out.tets.row(t)) out.is_held[n] = 1;
  }
  if (!held_at) return;
  std::vector<char> is_on_boundary(out.is_held.size(), 0);
  for (const std::int32_t n : out.faces.reshaped()) is_on_boundary[n] = 1;
  for (Eigen::Index n = base.nodes.rows(); n < out.nodes.rows(); ++n)
    if (held_at(out.nodes.row(n), is_on_boundary[n] != 0)) out.is_held[n] = 1;
  for (std::size_t n = 0; n < is_border.size(); ++n) out.is_held[n] |= is_border[n];
  // Which side of the border a mid-edge node on it is on is a matter of rounding.
  const auto hold_where_corners_are = [&](const auto& nodes, int corners) {
    for (int k = 0; k < corners; ++k)
      if (!out.is_held[nodes[k]]) return;
    for (const std::int32_t n : nodes) out.is_held[n] = 1;
  };
  for (const auto& tet : out.tets.rowwise()) hold_where_corners_are(tet, 4);
  for (const auto& face : out.faces.rowwise()) hold_where_corners_are(face, 3);
}

double distance_m(const Segment& piece, const Vec3& x) {
  const double t = nearest_on_segment(x, piece.from, piece.to);
  return (piece.from + t * (piece.to - piece.from) - x).norm();
}

double wanted_size_m(const Segment& piece, double growth, const Vec3& x) {
  return std::max(piece.h_m, growth * (distance_m(piece, x) - piece.reach_m));
}

// True of a place, or one so far away, where some piece wants its h_m.
bool is_finest_of_a_piece(const GradeOptions& options, const Vec3& x, double away_m) {
  return std::ranges::any_of(options.path, [&](const Segment& piece) {
    return options.growth * (distance_m(piece, x) - away_m - piece.reach_m) <= piece.h_m;
  });
}

// Largest offset of nodes where the mesh is finest.
double largest_offset_m(const NodePlacement& placed, const GradeOptions& options) {
  double largest_m = 0;
  for (std::size_t n = 0; n < placed.nodes.size(); ++n)
    if (placed.offset_m[n] > largest_m &&
        is_finest_of_a_piece(options, placed.nodes[n], placed.offset_m[n]))
      largest_m = placed.offset_m[n];
  return largest_m;
}

// Mean offset of the boundary nodes that a contact touches, largest of the contacts along the path.
double contact_deviation_m(const std::vector<Vec3>& nodes, const std::vector<double>& offset_m,
                           const GradeOptions& options) {
  double largest_m = 0;
  for (const Segment& piece : options.path) {
    const double radius_m = piece.reach_m + piece.h_m / options.growth;
    const auto steps = static_cast<int>((piece.to - piece.from).norm() / piece.h_m);
    for (int k = 0; k <= steps; ++k) {
      const Vec3 middle =
          piece.from + (steps > 0 ? double(k) / steps : 0.0) * (piece.to - piece.from);
      double sum_m = 0;
      int count = 0;
      for (std::size_t n = 0; n < nodes.size(); ++n) {
        // A node may be as far from where it should be as its offset.
        if ((nodes[n] - middle).norm() - offset_m[n] > radius_m) continue;
        sum_m += offset_m[n];
        ++count;
      }
      if (count > 0) largest_m = std::max(largest_m, sum_m / count);
    }
  }
  return largest_m;
}

void note_deviation(const NodePlacement& corners, const NodePlacement& middles,
                    const Boundary& boundary, const GradeOptions& options, QuadraticMesh& out) {
  std::vector<Vec3> nodes = middles.nodes;
  std::vector<double> offset_m = middles.offset_m;
  for (std::size_t n = 0; n < corners.nodes.size(); ++n) {
    if (boundary.kind[n] == NodeKind::inside) continue;
    nodes.push_back(corners.nodes[n]);
    offset_m.push_back(corners.offset_m[n]);
  }
  for (const double one_m : offset_m) out.deviation_m = std::max(out.deviation_m, one_m);
  if (out.deviation_m > 0) out.contact_deviation_m = contact_deviation_m(nodes, offset_m, options);
}

}  // namespace

double tet_size_m(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const double volumes = std::abs(six_volumes(a, b, c, d));
  const double longest =
      std::sqrt(std::max({(a - b).squaredNorm(), (b - c).squaredNorm(), (c - a).squaredNorm(),
                          (a - d).squaredNorm(), (b - d).squaredNorm(), (c - d).squaredNorm()}));
  return std::max(std::cbrt(volumes), longest / std::sqrt(3.0));
}

double wanted_size_m(const GradeOptions& options, const Vec3& x) {
  double least = std::numeric_limits<double>::infinity();
  for (const Segment& piece : options.path)
    least = std::min(least, wanted_size_m(piece, options.growth, x));
  return least;
}

QuadraticMesh grade_mesh(const TetMesh& base, const std::vector<char>& is_held,
                         const SmoothSurface& surface, const GradeOptions& options) {
  assert(std::ssize(is_held) == base.nodes.rows() && !options.path.empty() && options.growth > 0);
  for (Eigen::Index t = 0; t < base.tets.rows(); ++t)
    if (!(tet_volume_m3(corners_of(base, t)) > 0))
      throw Error("grade_mesh", "tet " + std::to_string(t) + " has no positive volume",
                  "Order its nodes so that it is positive, or fill the body again.");
  BisectedMesh mesh = bisect(base, options);
  Boundary boundary = classify_boundary(base, mesh);
  NodePlacement corners = place_corners(mesh, boundary, surface, Placing::by_birth);
  const double finest_m = std::ranges::min_element(options.path, {}, &Segment::h_m)->h_m;
  if (largest_offset_m(corners, options) > 0.05 * finest_m) {
    NodePlacement spread = place_corners(mesh, boundary, surface, Placing::spread);
    if (largest_offset_m(spread, options) < largest_offset_m(corners, options))
      corners = std::move(spread);
  }
  std::vector<char> is_border;
  if (options.held_at)
    is_border = conform_to_held(mesh, corners, boundary, surface, options.held_at);
  if (options.region_at) {
    conform_to_regions(mesh, corners, boundary, surface, options);
    boundary = classify_boundary(base, mesh);
  }
  const NodePlacement middles = place_middles(mesh, boundary, corners.nodes, surface);

  QuadraticMesh out;
  number_nodes(mesh, boundary, corners, middles, out);
  if (options.region_at)
    curve_borders(out, static_cast<std::int32_t>(corners.nodes.size() + middles.nodes.size()),
                  options.region_at);
  list_faces(mesh, boundary, out);
  hold(base, is_held, options.held_at, is_border, mesh, boundary, out);
  for (const BisectedTet& tet : mesh.tets) out.base.push_back(tet.base);
  note_deviation(corners, middles, boundary, options, out);
  if (base.region.size() > 0) {
    out.region.resize(out.tets.rows());
    for (std::size_t t = 0; t < mesh.tets.size(); ++t)
      out.region[t] = base.region[mesh.tets[t].base];
  }
  return out;
}

}  // namespace palpate::fem
