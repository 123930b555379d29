#include "libfem/mesh/grade/grade_steps.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

#include "libfem/mesh/topology.hpp"
#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

class Bisection {
 public:
  Bisection(const TetMesh& base, const GradeOptions& options)
      : options_(options), midpoint_(base.nodes.rows() * 8) {
    mesh_.base_nodes = static_cast<std::int32_t>(base.nodes.rows());
    mesh_.nodes.reserve(base.nodes.rows());
    for (Eigen::Index n = 0; n < base.nodes.rows(); ++n) mesh_.nodes.push_back(base.nodes.row(n));
    halved_at_.assign(mesh_.nodes.size(), 0);
    for (std::int32_t t = 0; t < base.tets.rows(); ++t) {
      const auto row = base.tets.row(t);
      mesh_.tets.push_back({{row[0], row[1], row[2], row[3]}, {-1, -1, -1, -1}, t});
      if (!options.halved.empty())
        largest_m_.push_back(options.halved[t] != 0
                                 ? tet_size_m(mesh_.nodes[row[0]], mesh_.nodes[row[1]],
                                              mesh_.nodes[row[2]], mesh_.nodes[row[3]]) /
                                       2
                                 : std::numeric_limits<double>::infinity());
    }
    mesh_.base_faces = boundary_faces(base.tets);
    const auto& faces = mesh_.base_faces;
    for (std::size_t f = 0; f < faces.size(); ++f)
      mesh_.tets[faces[f].tet].face[faces[f].face] = static_cast<std::int32_t>(f);
    checked_at_.assign(mesh_.tets.size(), 0);
    is_fine_.assign(mesh_.tets.size(), 0);
  }

  BisectedMesh run() {
    for (bool is_changed = true; is_changed;) {
      is_changed = false;
      for (std::size_t t = 0; t < mesh_.tets.size(); ++t)  // grows: children are appended
        while (is_too_large(t) || has_hanging_node(t)) {
          halve(t);
          is_changed = true;
        }
    }
    return std::move(mesh_);
  }

 private:
  // Lengths that are equal but for rounding must tie, so that symmetric meshes stay symmetric.
  auto order_of(std::int32_t a, std::int32_t b) const {
    const auto [low, high] = std::minmax(a, b);
    const double squared = (mesh_.nodes[low] - mesh_.nodes[high]).squaredNorm();
    return std::tuple(static_cast<float>(squared), -low, -high);
  }

  int longest_edge(const BisectedTet& tet) const {
    int longest = 0;
    auto best = order_of(tet.node[0], tet.node[1]);
    for (int e = 1; e < 6; ++e) {
      const auto order = order_of(tet.node[kTetEdge[e][0]], tet.node[kTetEdge[e][1]]);
      if (best < order) {
        best = order;
        longest = e;
      }
    }
    return longest;
  }

  bool is_too_large(std::size_t t) {
    if (is_fine_[t]) return false;
    const BisectedTet& tet = mesh_.tets[t];
    const Vec3 &x0 = mesh_.nodes[tet.node[0]], &x1 = mesh_.nodes[tet.node[1]],
               &x2 = mesh_.nodes[tet.node[2]], &x3 = mesh_.nodes[tet.node[3]];
    const Vec3 centroid = 0.25 * (x0 + x1 + x2 + x3);
    const double size = tet_size_m(x0, x1, x2, x3);
    double wanted = wanted_size_m(options_, centroid);
    if (!largest_m_.empty()) wanted = std::min(wanted, largest_m_[tet.base]);
    // A lump's border bends within an element, and halved ones see it; a layer's is flat. Presses
    // on a dome of skin, fat, muscle and tumour take 31, 20, 18 CPU s where 0, 0.03 and 0.08 of the
    // size count as flat, with forces 0.4 and 0.4 % apart; over a tumour alone 0.2 and 1.1 %.
    is_fine_[t] =
        size <= wanted &&
        (wanted > options_.interface_size_m || size <= options_.interface_share * wanted ||
         !is_shared({x0, x1, x2, x3}) || is_cut_flat({x0, x1, x2, x3}, 0.03 * size));
    return !is_fine_[t];
  }

  // True where the border through a tet is within off_m of a plane at its middle. Tets that several
  // borders cross count as cut flat, too: all are split there.
  bool is_cut_flat(const std::array<Vec3, 4>& x, double off_m) const {
    const auto region_at = [&](const Vec3& place) { return options_.region_at(place); };
    std::array<int, 4> region;
    std::ranges::transform(x, region.begin(), region_at);
    std::vector<Vec3> cut;
    for (const auto& [a, b] : kTetEdge)
      if (region[a] != region[b])
        cut.push_back(x[a] + region_change(options_.region_at, x[a], x[b], 1, 12) * (x[b] - x[a]));
    if (cut.size() != 3 && cut.size() != 4) return !cut.empty();
    const Vec3 middle = std::reduce(cut.begin() + 1, cut.end(), cut[0]) / double(cut.size()),
               off = off_m * (cut[1] - cut[0]).cross(cut[2] - cut[0]).stableNormalized();
    return region_at(middle - off) != region_at(middle + off);
  }

  // True where several regions fill a tet, as its corners, edges' middles and centroid show.
  bool is_shared(const std::array<Vec3, 4>& x) const {
    if (!options_.region_at) return false;
    const int region = options_.region_at(0.25 * (x[0] + x[1] + x[2] + x[3]));
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t k = 0; k <= i; ++k)
        if (options_.region_at(0.5 * (x[i] + x[k])) != region) return true;
    return false;
  }

  // An edge can hang only if both its ends saw an edge halved since the tet was last looked at.
  bool has_hanging_node(std::size_t t) {
    const BisectedTet& tet = mesh_.tets[t];
    int touched = 0;
    for (const std::int32_t n : tet.node) touched += halved_at_[n] > checked_at_[t];
    if (touched < 2) return false;
    checked_at_[t] = clock_;
    for (const auto& edge : kTetEdge)
      if (midpoint_.find(tet.node[edge[0]], tet.node[edge[1]]) >= 0) return true;
    return false;
  }

  std::int32_t midpoint_of(std::int32_t a, std::int32_t b) {
    const auto next = static_cast<std::int32_t>(mesh_.nodes.size());
    const auto [middle, is_new] = midpoint_.insert(a, b, next);
    if (is_new) {
      if (next >= options_.max_corners)
        throw Error("grade_mesh",
                    "refinement passes " + std::to_string(options_.max_corners) + " corner nodes",
                    "Ask for larger elements at the contact, a shorter path or more growth.");
      mesh_.nodes.push_back(0.5 * (mesh_.nodes[a] + mesh_.nodes[b]));
      mesh_.parents.push_back({std::min(a, b), std::max(a, b)});
      ++clock_;
      halved_at_.push_back(0);
      halved_at_[a] = halved_at_[b] = clock_;
    }
    return middle;
  }

  // Tet t becomes the half at one end of its longest edge; the other half is appended. Each half
  // has the far face of its end, half of the two faces at the edge, and the cut, which is inside.
  void halve(std::size_t t) {
    const int edge = longest_edge(mesh_.tets[t]);
    const int a = kTetEdge[edge][0], b = kTetEdge[edge][1];
    const std::int32_t middle = midpoint_of(mesh_.tets[t].node[a], mesh_.tets[t].node[b]);
    BisectedTet at_a = mesh_.tets[t], at_b = at_a;
    at_a.node[b] = middle;
    at_a.face[a] = -1;
    at_b.node[a] = middle;
    at_b.face[b] = -1;
    mesh_.tets[t] = at_a;
    mesh_.tets.push_back(at_b);
    checked_at_[t] = 0;
    is_fine_[t] = 0;
    checked_at_.push_back(0);
    is_fine_.push_back(0);
  }

  const GradeOptions& options_;
  BisectedMesh mesh_;
  EdgeMap midpoint_;
  std::int64_t clock_ = 0;                // edges halved so far
  std::vector<std::int64_t> halved_at_;   // per node: clock when an edge at it was halved last
  std::vector<std::int64_t> checked_at_;  // per tet: clock when last found without hanging node
  std::vector<double> largest_m_;         // per base tet: what its parts may be; empty: anything
  std::vector<char> is_fine_;             // per tet: known to be small enough
};

}  // namespace

BisectedMesh bisect(const TetMesh& base, const GradeOptions& options) {
  return Bisection(base, options).run();
}

}  // namespace palpate::fem
