#include "tools/setup/divide.hpp"

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/text.hpp"

namespace palpate::tools {
namespace {

using Corners = std::array<std::int32_t, 3>;
using Edge = std::pair<std::int32_t, std::int32_t>;

class Division {
 public:
  explicit Division(const Surface& surface) {
    for (const auto& p : surface.vertices.rowwise()) places_.emplace_back(p);
    for (const auto& t : surface.triangles.rowwise()) faces_.push_back({t[0], t[1], t[2]});
  }

  // Cuts the longest edges of what is too long, and says whether there was any.
  bool cut_once(const Vec3& centre, double radius_m, double longest_m) {
    cut_.clear();
    for (Corners& face : faces_) {
      turn_longest_first(face);
      if (squared(edge_of(face, 0)) > longest_m * longest_m && comes_near(face, centre, radius_m))
        cut_.try_emplace(edge_of(face, 0), -1);
    }
    if (cut_.empty()) return false;
    spread();
    for (auto& [edge, middle] : cut_) {
      middle = static_cast<std::int32_t>(places_.size());
      places_.push_back((place(edge.first) + place(edge.second)) / 2);
    }
    std::vector<Corners> faces;
    for (const Corners& face : faces_) append_parts(face, faces);
    faces_ = std::move(faces);
    return true;
  }

  Surface surface() const {
    Surface out;
    out.vertices.resize(static_cast<Eigen::Index>(places_.size()), 3);
    out.triangles.resize(static_cast<Eigen::Index>(faces_.size()), 3);
    for (std::size_t v = 0; v < places_.size(); ++v)
      out.vertices.row(static_cast<Eigen::Index>(v)) = places_[v];
    for (std::size_t f = 0; f < faces_.size(); ++f)
      out.triangles.row(static_cast<Eigen::Index>(f)) << faces_[f][0], faces_[f][1], faces_[f][2];
    return out;
  }

 private:
  const Vec3& place(std::int32_t v) const { return places_[static_cast<std::size_t>(v)]; }
  double squared(const Edge& edge) const {
    return (place(edge.first) - place(edge.second)).squaredNorm();
  }
  static Edge edge_of(const Corners& face, std::size_t k) {
    return std::minmax(face[k], face[(k + 1) % 3]);
  }
  // Of edges of one length that with the lower vertices, so that both its triangles choose alike.
  void turn_longest_first(Corners& face) const {
    std::size_t longest = 0;
    const auto rank = [&](std::size_t k) {
      return std::pair(-squared(edge_of(face, k)), edge_of(face, k));
    };
    for (std::size_t k = 1; k < 3; ++k)
      if (rank(k) < rank(longest)) longest = k;
    face = {face[longest], face[(longest + 1) % 3], face[(longest + 2) % 3]};
  }
  bool comes_near(const Corners& face, const Vec3& centre, double radius_m) const {
    const Vec3 &a = place(face[0]), &b = place(face[1]), &c = place(face[2]);
    const Vec3 w = nearest_weights(centre, a, b, c);
    return (w[0] * a + w[1] * b + w[2] * c - centre).norm() <= radius_m;
  }
  // A triangle that is cut at all is cut at its longest edge.
  void spread() {
    for (bool is_stable = false; !is_stable;) {
      is_stable = true;
      for (const Corners& face : faces_)
        if (!cut_.contains(edge_of(face, 0)) &&
            (cut_.contains(edge_of(face, 1)) || cut_.contains(edge_of(face, 2)))) {
          cut_.try_emplace(edge_of(face, 0), -1);
          is_stable = false;
        }
    }
  }
  // From the middle of the longest edge to the far corner, then each half at its own cut.
  void append_parts(const Corners& face, std::vector<Corners>& out) const {
    const auto longest = cut_.find(edge_of(face, 0));
    if (longest == cut_.end()) {
      out.push_back(face);
      return;
    }
    const std::int32_t middle = longest->second;
    const auto append_half = [&](std::int32_t from, std::int32_t to, const Edge& side,
                                 std::int32_t apex) {
      if (const auto cut = cut_.find(side); cut != cut_.end()) {
        out.push_back({apex, from, cut->second});
        out.push_back({apex, cut->second, to});
      } else {
        out.push_back({apex, from, to});
      }
    };
    append_half(face[1], face[2], edge_of(face, 1), middle);
    append_half(face[2], face[0], edge_of(face, 2), middle);
  }

  std::vector<Vec3> places_;
  std::vector<Corners> faces_;
  std::map<Edge, std::int32_t> cut_;
};

}  // namespace

Surface divided_near(const Surface& surface, const Vec3& centre, double radius_m,
                     double longest_m) {
  Division division(surface);
  while (division.cut_once(centre, radius_m, longest_m)) {
  }
  return division.surface();
}

std::string off_text(const Surface& surface) {
  std::string text = "OFF\n" + std::to_string(surface.vertices.rows()) + " " +
                     std::to_string(surface.triangles.rows()) + " 0\n";
  for (const auto& p : surface.vertices.rowwise())
    text += to_text(p[0]) + " " + to_text(p[1]) + " " + to_text(p[2]) + "\n";
  for (const auto& t : surface.triangles.rowwise())
    text += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) +
            "\n";
  return text;
}

}  // namespace palpate::tools
