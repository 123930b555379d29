#include "libfem/mesh/fill/fill_steps.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "libfem/mesh/topology.hpp"

namespace palpate {
namespace {

constexpr double kNear = 0.03;  // over an edge's length: the boundary may move that far

using Corners = std::array<std::int32_t, 4>;
using Indices = std::vector<std::size_t>;

/// Tets that are replaced by others.
struct Change {
  Indices old;
  std::vector<Corners> fresh;
  std::optional<Vec3> node;  ///< a new one, whose number in `fresh` is the next
  double worst_deg = -1;     ///< of `fresh`; 180 where there are none
};

/// The tets around an edge, in order: nodes[i] and nodes[i + 1] belong to tets[i].
struct EdgeRing {
  std::vector<std::int32_t> nodes;
  Indices tets;
  bool is_closed = false;
};

/// A mesh whose tets come and go.
class Mender {
 public:
  explicit Mender(const TetMesh& mesh) : around_(mesh.nodes.rows()) {
    for (const auto& p : mesh.nodes.rowwise()) nodes_.emplace_back(p);
    for (const auto& t : mesh.tets.rowwise()) add({t[0], t[1], t[2], t[3]});
  }

  /// Changes made in one pass over the tets below an angle, worst first.
  int pass(double below_deg) {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t t = 0; t < tets_.size(); ++t)
      if (const double deg = angle_deg(tets_[t]); deg < below_deg) order.emplace_back(deg, t);
    std::sort(order.begin(), order.end());
    int changes = 0;
    for (const auto& [deg, t] : order)
      if (is_alive_[t]) changes += mend(t, deg);
    return changes;
  }

  TetMesh mesh() const {
    std::vector<Corners> tets;
    for (std::size_t t = 0; t < tets_.size(); ++t)
      if (is_alive_[t]) tets.push_back(tets_[t]);
    const auto used =
        renumber({tets.front().data(), 4 * tets.size()}, nodes_.size(), Numbering::by_use);
    return {rows_of(nodes_)(used, Eigen::all), rows_of(tets), {}};
  }

 private:
  const Vec3& at(std::int32_t v) const { return nodes_[v]; }
  const Indices& around(std::int32_t v) const { return around_[v]; }

  void add(const Corners& tet) {
    for (const std::int32_t v : tet) around_[v].push_back(tets_.size());
    tets_.push_back(tet);
    is_alive_.push_back(1);
  }

  void make(const Change& change) {
    if (change.node) {
      nodes_.push_back(*change.node);
      around_.emplace_back();
    }
    for (const std::size_t t : change.old) {
      is_alive_[t] = 0;
      for (const std::int32_t v : tets_[t]) std::erase(around_[v], t);
    }
    for (const Corners& tet : change.fresh) add(tet);
  }

  /// Least dihedral angle; -1 where the tet is not positive. fresh: place of the node that is next.
  double angle_deg(const Corners& tet, const Vec3* fresh = nullptr) const {
    TetCorners corner;
    for (std::size_t k = 0; k < 4; ++k)
      corner[k] = static_cast<std::size_t>(tet[k]) == nodes_.size() ? *fresh : at(tet[k]);
    return tet_volume_m3(corner) > 0 ? min_dihedral_deg(corner) : -1;
  }

  double worst_deg(const std::vector<Corners>& tets) const {
    double worst = 180;
    for (const Corners& tet : tets) worst = std::min(worst, angle_deg(tet));
    return worst;
  }

  bool has(std::size_t tet, std::int32_t v) const {
    return std::find(tets_[tet].begin(), tets_[tet].end(), v) != tets_[tet].end();
  }

  /// Tets that have all these nodes.
  Indices with(std::initializer_list<std::int32_t> nodes) const {
    Indices found;
    for (const std::size_t t : around(*nodes.begin()))
      if (std::ranges::all_of(nodes, [&](std::int32_t v) { return has(t, v); })) found.push_back(t);
    return found;
  }

  bool is_on_boundary(std::int32_t v) const {
    for (const std::size_t t : around(v))
      for (const auto& face : fem::kTetFace) {
        const auto corner = [&](int k) { return tets_[t][face[k]]; };
        if (corner(0) != v && corner(1) != v && corner(2) != v) continue;
        if (with({corner(0), corner(1), corner(2)}).size() == 1) return true;
      }
    return false;
  }

  /// Nothing where the tets around an edge hang together in more than one piece.
  std::optional<EdgeRing> ring_of(std::int32_t a, std::int32_t b) const {
    const Indices tets = with({a, b});
    std::vector<std::array<std::int32_t, 2>> links;  // tet (a, b, from, to) is positive
    for (const std::size_t t : tets) {
      std::array<std::int32_t, 2> link{};
      std::size_t n = 0;
      for (const std::int32_t v : tets_[t])
        if (v != a && v != b) link[n++] = v;
      if (tet_volume_m3({at(a), at(b), at(link[0]), at(link[1])}) < 0) std::swap(link[0], link[1]);
      links.push_back(link);
    }
    const auto leaves_to = [&](std::int32_t v, std::size_t end) {
      return std::find_if(links.begin(), links.end(), [&](const auto& l) { return l[end] == v; });
    };
    auto link = links.begin();  // an open ring begins where nothing arrives
    for (auto l = links.begin(); l != links.end(); ++l)
      if (leaves_to((*l)[0], 1) == links.end()) link = l;
    EdgeRing ring;
    while (link != links.end() && ring.tets.size() < tets.size()) {
      ring.nodes.push_back((*link)[0]);
      ring.tets.push_back(tets[link - links.begin()]);
      const std::int32_t next = (*link)[1];
      link = leaves_to(next, 0);
      if (link == links.end()) ring.nodes.push_back(next);
    }
    ring.is_closed = link != links.end();
    const bool is_one =
        ring.tets.size() == tets.size() && (!ring.is_closed || (*link)[0] == ring.nodes.front());
    return is_one ? std::optional(ring) : std::nullopt;
  }

  /// The polygon of nodes around the edge in triangles, each the base of a tet to either end of it:
  /// the triangulation whose worst tet is best.
  Change remove_edge(std::int32_t a, std::int32_t b) const {
    const auto ring = ring_of(a, b);
    // The search over triangulations takes the cube of the ring.
    if (!ring || ring->tets.size() > 10) return {};
    if (!ring->is_closed && !may_go(*ring, a, b)) return {};
    const auto& v = ring->nodes;
    const std::size_t n = v.size();
    if (ring->is_closed && n < 3) return {};
    std::vector<std::vector<double>> best(n, std::vector<double>(n, 180));
    std::vector<std::vector<std::size_t>> apex(n, std::vector<std::size_t>(n, 0));
    for (std::size_t span = 2; span < n; ++span)
      for (std::size_t i = 0; i + span < n; ++i) {
        const std::size_t j = i + span;
        best[i][j] = -1;
        for (std::size_t k = i + 1; k < j; ++k) {
          const double deg = std::min(
              {best[i][k], best[k][j], worst_deg({{v[i], v[k], v[j], b}, {v[i], v[j], v[k], a}})});
          if (deg > best[i][j]) best[i][j] = deg, apex[i][j] = k;
        }
      }
    Change change{ring->tets, {}, {}, best[0][n - 1]};
    if (change.worst_deg < 0) return {};
    std::vector<std::pair<std::size_t, std::size_t>> spans{{0, n - 1}};
    while (!spans.empty()) {
      const auto [i, j] = spans.back();
      spans.pop_back();
      if (j < i + 2) continue;
      const std::size_t k = apex[i][j];
      change.fresh.push_back({v[i], v[k], v[j], b});
      change.fresh.push_back({v[i], v[j], v[k], a});
      spans.emplace_back(i, k);
      spans.emplace_back(k, j);
    }
    return change;
  }

  /// Two tets that share a face become three around the edge between their tips.
  Change remove_face(std::int32_t a, std::int32_t b, std::int32_t c) const {
    const Indices two = with({a, b, c});
    if (two.size() != 2) return {};
    const auto tip_of = [&](std::size_t t) {
      return *std::find_if(tets_[t].begin(), tets_[t].end(),
                           [&](std::int32_t v) { return v != a && v != b && v != c; });
    };
    const std::int32_t p = tip_of(two[0]), q = tip_of(two[1]);
    Change change{two, {{p, q, a, b}, {p, q, b, c}, {p, q, c, a}}, {}, -1};
    if (tet_volume_m3({at(p), at(q), at(a), at(b)}) < 0)
      for (Corners& tet : change.fresh) std::swap(tet[2], tet[3]);
    change.worst_deg = worst_deg(change.fresh);
    return change;
  }

  /// A node moves onto a neighbour and takes the tets between them away.
  Change collapse(std::int32_t v, std::int32_t onto) const {
    Change change{around(v), {}, {}, -1};
    for (const std::size_t t : change.old) {
      if (has(t, onto)) continue;
      change.fresh.push_back(tets_[t]);
      std::replace(change.fresh.back().begin(), change.fresh.back().end(), v, onto);
    }
    change.worst_deg = worst_deg(change.fresh);
    return change;
  }

  /// An inner edge gets a node, which looks for the best place.
  Change split_edge(std::int32_t a, std::int32_t b) const {
    const auto ring = ring_of(a, b);
    if (!ring || !ring->is_closed) return {};
    const auto fresh_node = static_cast<std::int32_t>(nodes_.size());
    Change change{ring->tets, {}, (at(a) + at(b)) / 2, -1};
    for (const std::size_t t : change.old)
      for (const std::int32_t end : {a, b}) {
        change.fresh.push_back(tets_[t]);
        std::replace(change.fresh.back().begin(), change.fresh.back().end(), end, fresh_node);
      }
    const auto worst_at = [&](const Vec3& place) {
      double worst = 180;
      for (const Corners& tet : change.fresh) {
        worst = std::min(worst, angle_deg(tet, &place));
        if (worst <= change.worst_deg) break;
      }
      return worst;
    };
    change.worst_deg = worst_at(*change.node);
    search_place(*change.node, (at(b) - at(a)).norm(), [&](const Vec3& place) {
      const double worst = worst_at(place);
      if (!(worst > change.worst_deg)) return false;
      change.worst_deg = worst;
      return true;
    });
    return change;
  }

  /// A node may move onto a neighbour if it is an inner one, or one of the boundary that lies next
  /// to the other; and the body stays a body (the link condition).
  bool may_move(std::int32_t v, std::int32_t onto, double near_m) const {
    if (!is_on_boundary(v)) return true;
    const auto ring = ring_of(v, onto);
    if (!ring || ring->is_closed || (at(v) - at(onto)).norm() > near_m) return false;
    std::set<std::int32_t> beside_v, beside_both;
    for (const std::size_t t : around(v)) beside_v.insert(tets_[t].begin(), tets_[t].end());
    for (const std::size_t t : around(onto))
      for (const std::int32_t w : tets_[t])
        if (w != v && w != onto && beside_v.contains(w)) beside_both.insert(w);
    return beside_both.size() == ring->nodes.size();
  }

  /// A boundary edge may go where it is flat across it and no dent, and what replaces it was not on
  /// the boundary.
  bool may_go(const EdgeRing& ring, std::int32_t a, std::int32_t b) const {
    const std::int32_t from = ring.nodes.front(), to = ring.nodes.back();
    const Vec3 edge = at(b) - at(a), in = edge.cross(at(from) - at(a)),
               out = edge.cross(at(to) - at(a));
    // The body's angle at the edge: from the face that the ring begins at to the one it ends at. A
    // face whose tip lies on the edge has none, and nothing moves.
    const double turn = std::atan2(edge.normalized().dot(in.cross(out)), in.dot(out));
    const double inside_deg =
        (turn < 0 ? turn + 2 * std::numbers::pi : turn) * 180 / std::numbers::pi;
    // A boundary edge that turns by less than 20 degrees may go.
    const bool is_flat = inside_deg >= 180 - 20 && inside_deg <= 180 + 1e-6;
    if (!is_flat && std::min(in.norm(), out.norm()) > kNear * edge.squaredNorm()) return false;
    if (ring.tets.size() > 1) return with({from, to}).empty();
    const auto below = ring_of(from, to);
    return below && below->is_closed;
  }

  bool mend(std::size_t tet, double deg);

  std::vector<Vec3> nodes_;
  std::vector<Corners> tets_;
  std::vector<char> is_alive_;
  std::vector<Indices> around_;
};

bool Mender::mend(std::size_t tet, double deg) {
  const Corners v = tets_[tet];
  Change best;
  const auto offer = [&](Change change) {
    if (change.old.empty()) return;
    double was = 180;
    std::ptrdiff_t more = 0;
    for (const std::size_t t : change.old) {
      was = std::min(was, angle_deg(tets_[t]));
      more -= angle_deg(tets_[t]) < kSliverDeg;
    }
    for (const Corners& fresh : change.fresh)
      more += angle_deg(fresh, change.node ? &*change.node : nullptr) < kSliverDeg;
    // A change must gain a quarter of a degree, for it may make more tets.
    if (more <= 0 && change.worst_deg > std::max(best.worst_deg, was + 0.25))
      best = std::move(change);
  };
  double longest_m = 0;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < a; ++b)
      longest_m = std::max(longest_m, (at(v[a]) - at(v[b])).norm());
  for (const std::int32_t from : v)
    for (const std::int32_t onto : v)
      if (onto != from && may_move(from, onto, kNear * longest_m)) offer(collapse(from, onto));
  for (const auto& edge : fem::kTetEdge) offer(remove_edge(v[edge[0]], v[edge[1]]));
  for (const auto& face : fem::kTetFace) offer(remove_face(v[face[0]], v[face[1]], v[face[2]]));
  if (best.worst_deg < kSliverDeg)  // a node more is the last means
    for (const auto& edge : fem::kTetEdge) offer(split_edge(v[edge[0]], v[edge[1]]));
  if (best.worst_deg <= deg) return false;
  make(best);
  return true;
}

}  // namespace

int mend_slivers(TetMesh& mesh, double below_deg) {
  int changes = 0;
  for (int round = 0; round < 8 && quality_of(mesh).min_dihedral_deg < below_deg; ++round) {
    Mender mender(mesh);
    const int made = mender.pass(below_deg);
    if (made == 0) break;
    changes += made;
    mesh = mender.mesh();
    smooth_interior(mesh);
  }
  return changes;
}

}  // namespace palpate
