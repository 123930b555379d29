#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "libfem/mesh/grade/smooth_surface.hpp"
#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/surface/surface.hpp"
#include "libfit/core/error.hpp"
#include "libfit/refine/points_on_surface.hpp"
#include "tools/console.hpp"
#include "tools/scene/fields.hpp"
#include "tools/stages/body/prepare.hpp"

namespace palpate::tools {
namespace {

// Overlap over depth, at first touch: a ball that begins a tenth of the way in feels 3 % of its
// force too early (0.1^1.5).
constexpr double kOverlapShare = 0.1;

// Vertex normals averaged over about width_m, so that folds and noise turn no side.
Points smoothed_normals(const Surface& surface, double width_m) {
  const Neighbours neighbours(surface.triangles, surface.vertices.rows());
  const double edges = width_m / mean_edge_m(surface);
  Points normals = vertex_normals(surface);
  for (int i = std::clamp(static_cast<int>(edges * edges), 1, 50); i > 0; --i) {
    Points next = normals;
    for (Eigen::Index v = 0; v < normals.rows(); ++v)
      for (const std::int32_t w : neighbours.of(static_cast<std::int32_t>(v)))
        next.row(v) += normals.row(w);
    normals = next.rowwise().normalized();
  }
  return normals;
}

// Of the vertices in a ball the patch that is nearest to its centre, on that side of the body.
// Returns what to say of the rest, if there is any.
std::string keep_near_side(const Surface& surface, const Vec3& center, double width_m,
                           std::vector<char>& is_in) {
  const auto inside = std::count(is_in.begin(), is_in.end(), 1);
  std::int32_t nearest = -1;
  for (std::size_t v = 0; v < is_in.size(); ++v) {
    const auto squared = [&](std::size_t at) {
      return (surface.vertices.row(at).transpose() - center).squaredNorm();
    };
    if (is_in[v] && (nearest < 0 || squared(v) < squared(static_cast<std::size_t>(nearest))))
      nearest = static_cast<std::int32_t>(v);
  }
  if (nearest < 0) return {};
  const Points normals = smoothed_normals(surface, width_m);
  // Up to 100 degrees from the normal at the middle: the flanks of a fold count as of its side, the
  // back of a rim does not.
  for (std::size_t v = 0; v < is_in.size(); ++v)
    is_in[v] = is_in[v] && normals.row(v).dot(normals.row(nearest)) > -0.17;
  std::vector<char> is_kept(is_in.size(), 0);
  for (const auto& patch : patches_of(surface, is_in))
    if (std::binary_search(patch.begin(), patch.end(), nearest))
      for (const std::int32_t v : patch) is_kept[v] = 1;
  is_in = std::move(is_kept);
  const auto kept = std::count(is_in.begin(), is_in.end(), 1);
  if (kept == inside) return {};
  return fmt::format(
      "  region: {} of {} vertices in the sphere, the patch nearest to its centre; the back and "
      "what is not joined to it are left out",
      kept, inside);
}

std::vector<char> vertices_where(const Surface& surface,
                                 const std::function<bool(Eigen::Index)>& is_in) {
  std::vector<char> flags(surface.vertices.rows(), 0);
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v) flags[v] = is_in(v);
  return flags;
}

// What the scene's region names, but for what is fixed. width_m: of the tool. left_out: what is
// said of a sphere's other side.
std::vector<char> region_of(const Scene& scene, const Surface& surface, double width_m,
                            std::string& left_out) {
  std::vector<char> is_in(surface.vertices.rows(), 1);
  if (const auto& region = scene.experiments.region) {
    is_in = vertices_where(
        surface, [&](Eigen::Index v) { return contains(*region, surface.vertices.row(v)); });
    if (const auto* ball = std::get_if<Ball>(&*region))
      left_out = keep_near_side(surface, ball->center_m, width_m, is_in);
  }
  return vertices_where(surface, [&](Eigen::Index v) {
    return is_in[v] && !any_contains(scene.body.fixed, surface.vertices.row(v), true) &&
           std::ranges::none_of(scene.beds, [&](const BedSection& bed) {
             return contains(bed.region, surface.vertices.row(v));
           });
  });
}

// A third of each triangle to each of its corners [m^2].
Eigen::VectorXd area_of_vertices(const Surface& surface) {
  Eigen::VectorXd area = Eigen::VectorXd::Zero(surface.vertices.rows());
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto [a, b, c] = corners_of(surface, f);
    for (const std::int32_t v : surface.triangles.row(f))
      area[v] += (b - a).cross(c - a).norm() / 6;
  }
  return area;
}

// Takes patches out that have less than least_m2, but for the largest.
void drop_specks(const Surface& surface, double least_m2, std::vector<char>& is_in) {
  const Eigen::VectorXd area = area_of_vertices(surface);
  const auto patches = patches_of(surface, is_in);
  std::vector<double> patch_m2;
  for (const auto& patch : patches) patch_m2.push_back(area(patch).sum());
  if (patches.empty()) return;
  const double kept_m2 = std::min(least_m2, *std::max_element(patch_m2.begin(), patch_m2.end()));
  for (std::size_t i = 0; i < patches.size(); ++i)
    if (patch_m2[i] < kept_m2)
      for (const std::int32_t v : patches[i]) is_in[v] = 0;
}

std::vector<double> distance_from_m(const Surface& surface, const std::vector<char>& is_source) {
  EdgePathSeeds seeds;
  for (std::size_t v = 0; v < is_source.size(); ++v)
    if (is_source[v]) seeds.push_back({static_cast<std::int32_t>(v), 0.0});
  return nearest_source(surface, {seeds}).distance_m;
}

// What is within width_m of a reachable vertex, or of such a gap: the region without wide patches
// that cannot be reached, narrow ones closed.
std::vector<char> with_gaps_closed(const Surface& surface, const std::vector<char>& in_region,
                                   const std::vector<char>& is_reachable, double width_m) {
  const std::vector<double> to_reachable = distance_from_m(surface, is_reachable);
  std::vector<char> is_far(in_region.size(), 0), is_kept(in_region.size(), 0);
  for (std::size_t v = 0; v < in_region.size(); ++v)
    is_far[v] = in_region[v] && to_reachable[v] > width_m;
  const std::vector<double> to_far = distance_from_m(surface, is_far);
  for (std::size_t v = 0; v < in_region.size(); ++v)
    is_kept[v] = in_region[v] && (is_reachable[v] || to_far[v] > width_m);
  return is_kept;
}

void say_out_of_reach(const Body& body, const std::vector<char>& in_region,
                      const std::vector<double>& overlap_m) {
  std::size_t out = 0, worst = 0, gaps = 0;
  for (std::size_t v = 0; v < in_region.size(); ++v) {
    if (!in_region[v] || body.is_reachable[v]) continue;
    ++out;
    gaps += body.in_region[v] != 0;
    if (overlap_m[v] >= overlap_m[worst]) worst = v;
  }
  if (out == 0) return;
  const Vec3 place = body.surface.vertices.row(worst);
  say("  out of reach: {} of {} vertices, where the tool would cut into the body first, by up to "
      "{:.2g} mm at {}, or has no way in; {} of them in gaps that curves are blended across",
      out, std::count(in_region.begin(), in_region.end(), 1), 1e3 * overlap_m[worst], in_mm(place),
      gaps);
}

}  // namespace

fem::ToolReach make_reach(const Scene& scene, const Surface& surface) {
  return {surface, rigid_probe(scene), kOverlapShare * scene.experiments.each.depth_m};
}

namespace {

// Throws where less than a triangle is left.
void refuse_few(const Scene& scene, const Surface& surface, const std::vector<char>& is_left,
                const std::string& remedy) {
  const auto count = std::count(is_left.begin(), is_left.end(), 1);
  if (count < 3)
    throw Error(
        scene.path.string() + ": [experiments] region",
        fmt::format("{} of {} surface vertices are reachable", count, surface.vertices.rows()),
        remedy);
}

}  // namespace

void find_region(const Scene& scene, Body& body) {
  std::string left_out;
  body.in_region = region_of(scene, body.surface,
                             scene.probe.rigid ? scene.probe.rigid->half_width_m : 0, left_out);
  if (!left_out.empty()) say("{}", left_out);
}

void divide_region(const Scene& scene, Body& body) {
  const fem::Probe& probe = rigid_probe(scene);
  const double depth_m = scene.experiments.each.depth_m;
  // A contact point that slides comes as much too deep as triangles are off, and force goes as
  // depth^1.5: 6 % at a quarter of the depth. A third of a hundredth gains nothing (liver-smooth).
  const double sagitta_m = 0.01 * depth_m;
  const auto is_in_region = [&](std::int32_t of, const Vec3&, const Vec3&, const Vec3&) {
    for (int k = 0; k < 3; ++k)
      if (body.in_region[body.surface.triangles(of, k)]) return true;
    return false;
  };
  Surface fine =
      fem::divided(fem::SmoothSurface(body.surface), is_in_region,
                   {.sagitta_m = sagitta_m, .shortest_m = 0.5 * probe.contact_radius_m(depth_m)});
  if (fine.vertices.rows() == body.surface.vertices.rows()) return;
  say("  region: triangles more than {:.2g} mm off the smooth surface through their corners are "
      "divided, which makes {} vertices of {}",
      1e3 * sagitta_m, fine.vertices.rows(), body.surface.vertices.rows());
  body.surface = std::move(fine);
  std::string left_out;  // as it was said of the surface before
  body.in_region = region_of(scene, body.surface, probe.half_width_m, left_out);
}

void find_reachable(const Scene& scene, bool surface_only, Body& body) {
  body.is_reachable = body.in_region;
  refuse_few(scene, body.surface, body.is_reachable,
             "Move the region onto the surface, and not into what is fixed. If it is there and the "
             "surface is coarse, make the region larger, or divide the triangles there: `palpate "
             "new` writes such a mesh.");
  if (surface_only) return;
  const fem::Probe& probe = rigid_probe(scene);
  const std::vector<char> wanted = body.in_region;
  std::vector<double> overlap_m;
  body.is_reachable =
      make_reach(scene, body.surface).vertices(wanted, vertex_normals(body.surface), &overlap_m);
  const double contact_m = probe.contact_radius_m(scene.experiments.each.depth_m);
  drop_specks(body.surface, std::numbers::pi * contact_m * contact_m, body.is_reachable);
  refuse_few(scene, body.surface, body.is_reachable,
             "The tool would cut into the body elsewhere before it touches there: take a smaller "
             "tool, or another region.");
  // Test points some spacing apart cannot go around less.
  const Eigen::Map<const Eigen::VectorX<char>> is_wanted(wanted.data(), std::ssize(wanted));
  const double spacing_m = std::sqrt(area_of_vertices(body.surface).dot(is_wanted.cast<double>()) /
                                     scene.experiments.test_points.value_or(kMaxPoints));
  body.in_region = with_gaps_closed(body.surface, wanted, body.is_reachable,
                                    std::max(probe.half_width_m, spacing_m / 2));
  say_out_of_reach(body, wanted, overlap_m);
}

TestPoints spread_test_points(Body& body, int count) {
  for (;;) {
    TestPoints points = choose_test_points(body.surface, body.in_region, body.is_reachable, count);
    std::vector<char> is_gap(body.in_region.size(), 0);
    for (std::size_t v = 0; v < is_gap.size(); ++v)
      is_gap[v] = body.in_region[v] && !body.is_reachable[v];
    bool is_done = true;
    for (const auto& gap : patches_of(body.surface, is_gap))
      if (std::any_of(gap.begin(), gap.end(), [&](std::int32_t v) {
            return (points.position.rowwise() - body.surface.vertices.row(v))
                       .rowwise()
                       .squaredNorm()
                       .minCoeff() == 0;
          })) {
        is_done = false;
        for (const std::int32_t v : gap) body.in_region[v] = 0;
      }
    if (is_done) return points;
  }
}

void leave_out_of_reach(const Scene& scene, Body& body) {
  const fem::ToolReach reach = make_reach(scene, body.surface);
  TestPoints& points = body.test_points;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index p = 0; p < points.position.rows(); ++p) {
    const double overlap_m = reach.overlap_m(points.position.row(p), points.normal.row(p));
    if (overlap_m <= kOverlapShare * scene.experiments.each.depth_m) {
      kept.push_back(p);
      continue;
    }
    say("  left out: {} at {}, where the tool would cut {:.2g} mm into the body at first touch",
        points.name[p], in_mm(points.position.row(p)), 1e3 * overlap_m);
  }
  const auto left_out = points.position.rows() - static_cast<Eigen::Index>(kept.size());
  if (left_out == 0) return;
  if (kept.empty())
    throw Error(scene.path.string() + ": [experiments] test_points",
                "the tool can touch at none of the test points",
                "Take a smaller tool, or other points.");
  warn("{} test points are left out: the tool would cut into the body there", left_out);
  points.position = Points(points.position(kept, Eigen::all));
  points.normal = Points(points.normal(kept, Eigen::all));
  std::vector<std::string> names;
  for (const Eigen::Index p : kept) names.push_back(points.name[p]);
  points.name = std::move(names);
}

}  // namespace palpate::tools
