#include "libfem/mesh/repair/mend.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/repair/repair_steps.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"

namespace palpate {
namespace {

using repair::Changes;
using repair::Soup;

// Between samples of the distance that mending moved, over kMostMoved: a pit as wide is met twice.
constexpr double kMovedSpacing = 0.5;
constexpr const char* kWrapHint = "Repair it in a mesh editor, or wrap it.";

// Everything that needs no new geometry.
Soup settled_soup(const Surface& surface, const std::string& where, Changes& changes) {
  // Below the coordinates' own roundoff nothing can be distinguished.
  const double roundoff_m = 4e-16 * surface.vertices.cwiseAbs().maxCoeff();
  const double weld_m =
      std::max(1e-9 * extent_m(surface.vertices).norm(), roundoff_m);  // roundoff of nine digits
  Soup soup = repair::to_soup(surface);
  repair::weld_vertices(soup, weld_m, changes);
  repair::drop_flat_faces(soup, weld_m, changes);
  repair::drop_duplicate_faces(soup, changes);
  if (soup.faces.empty())
    throw Error(where, "no triangle of the surface has an area",
                "Check the mesh and its length unit.");
  repair::split_t_junctions(soup, weld_m, changes);
  repair::drop_flat_faces(soup, weld_m, changes);
  repair::drop_duplicate_faces(soup, changes);
  repair::drop_stray_facets(soup, changes, where);
  repair::drop_unused_vertices(soup);
  repair::make_manifold(soup, changes, where);
  repair::drop_stray_components(soup, 1e-4, changes);  // of the largest's area
  repair::drop_unused_vertices(soup);
  repair::orient_outward(soup, changes);
  repair::drop_unused_vertices(soup);
  return soup;
}

Surface with_holes_filled(const Surface& surface, const std::string& where, Changes& changes) {
  const repair::FilledHoles holes = repair::fill_holes(surface);
  if (!holes.left.empty())
    throw Error(where,
                counted(holes.left.size(), "hole", "holes") +
                    " could not be filled, the first at " + coordinates(holes.left.front()),
                kWrapHint);
  changes.push_back("filled " + counted(holes.filled, "hole", "holes") + " (widest " +
                    millimetres(holes.widest_m) + ") with " +
                    counted(holes.triangles, "triangle", "triangles"));
  return holes.surface;
}

using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

// Which triangles cross, as far as the input had them, and where.
std::string name_pairs(const Surface& surface, const Pairs& pairs, const Soup& soup) {
  std::vector<std::int32_t> faces;
  for (const auto& [a, b] : pairs)
    for (const std::size_t f : {a, b})
      if (f < soup.faces.size()) faces.push_back(f);
  const Vec3 at = surface.vertices.row(surface.triangles(pairs.front().first, 0));
  return (faces.empty() ? "filled holes" : repair::name_faces(soup, faces)) + ", near " +
         coordinates(at);
}

// Largest distance to `to` of points on `from`, at most `spacing_m` apart.
double farthest_m(const Surface& from, const Surface& to, double spacing_m) {
  const BoxTree boxes = triangle_boxes(to);
  double farthest = 0;
  for (Eigen::Index f = 0; f < from.triangles.rows(); ++f) {
    const auto [a, b, c] = corners_of(from, f);
    const Vec3 u = b - a, v = c - a;
    const double longest = std::max({u.norm(), v.norm(), (u - v).norm()});
    const int steps = std::clamp(static_cast<int>(std::ceil(longest / spacing_m)), 1, 200);
    for (int i = 0; i <= steps; ++i)
      for (int j = 0; i + j <= steps; ++j)
        if (const auto hit = closest_point(to, boxes, a + (i * u + j * v) / steps))
          farthest = std::max(farthest, hit->distance_m);
  }
  return farthest;
}

// The surface without the triangles that cross, which are no part of a body's form: a spike through
// a wall goes, however long it is.
Surface without_pairs(const Surface& surface, const Pairs& pairs) {
  std::vector<char> is_crossing(surface.triangles.rows(), 0);
  for (const auto& [a, b] : pairs) is_crossing[a] = is_crossing[b] = 1;
  std::vector<std::size_t> kept;
  for (std::size_t f = 0; f < is_crossing.size(); ++f)
    if (!is_crossing[f]) kept.push_back(f);
  return {surface.vertices, surface.triangles(kept, Eigen::all)};
}

Surface without_crossings(const Surface& surface, const Soup& soup, const std::string& where,
                          Mended& report) {
  const Pairs pairs = repair::self_intersections(surface);
  if (pairs.empty()) return surface;
  const std::string names = name_pairs(surface, pairs, soup);
  std::optional<Surface> mended;
  // More crossings are no local flaw: a 2.6 k triangle mesh with 423 took 8 s to fail.
  if (pairs.size() <= 200) mended = repair::without_self_intersections(surface);
  if (!mended)
    throw Error(where,
                "the surface crosses itself in " + counted(pairs.size(), "pair", "pairs") +
                    " of triangles that could not be mended: " + names,
                kWrapHint);
  const double limit_m = kMostMoved * extent_m(surface.vertices).norm();
  const double spacing_m = kMovedSpacing * limit_m;
  report.moved_m = std::max(farthest_m(without_pairs(surface, pairs), *mended, spacing_m),
                            farthest_m(*mended, surface, spacing_m));
  const std::string crossings =
      counted(pairs.size(), "crossing pair", "crossing pairs") + " of triangles (" + names + ")";
  if (report.moved_m > limit_m)
    throw Error(where,
                "mending " + crossings + " moves the rest of the surface by " +
                    millimetres(report.moved_m) + ", more than " + percent(kMostMoved, 0) +
                    " of its diagonal",
                kWrapHint);
  report.changes.push_back("removed " + crossings +
                           ", which moves the rest of the surface by at most " +
                           millimetres(report.moved_m));
  return *mended;
}

// The last word: what is returned has these properties or is refused.
void verify(const Surface& surface, bool allow_open, const std::string& where) {
  const SurfaceFacts facts = surface_facts(surface);
  const auto refuse = [&](const std::string& what) {
    throw Error(where, "after mending, the surface " + what, kWrapHint);
  };
  if (facts.triangles == 0) refuse("has no triangles");
  if (!surface.vertices.allFinite()) refuse("has coordinates that are not finite");
  if (!facts.is_manifold) refuse("is not manifold");
  if (!facts.is_oriented) refuse("is not oriented");
  if (!facts.is_closed && !allow_open) refuse("is open");
  // Volume over area^1.5 below which a closed piece is two sheets on each other (a ball: 0.094).
  if (facts.is_closed && !(facts.volume_m3 > 1e-9 * std::pow(facts.area_m2, 1.5)))
    refuse("encloses no volume (two sheets on each other, or a flat piece)");
  const Pairs pairs = repair::self_intersections(surface);
  if (!pairs.empty())
    refuse("still crosses itself near " +
           coordinates(surface.vertices.row(surface.triangles(pairs.front().first, 0))));
}

void report_volume(const Surface& before, const Surface& after, Changes& changes) {
  const SurfaceFacts was = surface_facts(before), is = surface_facts(after);
  if (!was.is_closed || !was.is_oriented || !is.is_closed || was.volume_m3 == 0) return;
  const double share = is.volume_m3 / std::abs(was.volume_m3) - 1;
  if (std::abs(share) > 1e-9)
    changes.push_back(std::string("changed the volume by ") + (share > 0 ? "+" : "") +
                      number(100 * share) + " %");
}

// Refusal of a surface that only its lids make unsound.
Error is_open(const Surface& open, const std::string& where) {
  std::vector<std::int32_t> border;  // first vertices of the sides that no other triangle shares
  for_each_edge(sorted_sides(open.triangles), [&](auto begin, auto end) {
    if (end - begin == 1) border.push_back(begin->is_forward ? begin->low : begin->high);
  });
  return Error(where,
               "the surface is open: " + counted(border.size(), "open edge", "open edges") +
                   ", one at " + coordinates(open.vertices.row(std::ranges::min(border))) +
                   ", and no lid over them makes it enclose a volume",
               "Close it in a mesh editor, or wrap it.");
}

Mended mend(const Surface& surface, bool allow_open, const std::string& where) {
  Mended mended;
  const Soup soup = settled_soup(surface, where, mended.changes);
  const Surface settled = repair::to_surface(soup);
  mended.surface = settled;
  const bool needs_lid = !allow_open && surface_facts(settled).border_edges > 0;
  try {
    if (needs_lid) mended.surface = with_holes_filled(mended.surface, where, mended.changes);
    mended.surface = without_crossings(mended.surface, soup, where, mended);
    verify(mended.surface, allow_open, where);
  } catch (const Error&) {
    if (needs_lid && repair::self_intersections(settled).empty()) throw is_open(settled, where);
    throw;
  }
  report_volume(settled, mended.surface, mended.changes);
  return mended;
}

// The surface that a wrap goes around without its stray parts and with its holes filled where they
// can be, for a wrap goes into every opening wider than alpha and makes a shell of the body.
Surface with_lids(const Surface& surface, const std::string& where, Changes& changes) {
  try {
    Changes settling;
    const Soup soup = settled_soup(surface, where, settling);
    const Surface settled = repair::to_surface(soup);
    changes.insert(changes.end(), settling.begin(), settling.end());
    if (surface_facts(settled).border_edges == 0) return settled;
    const repair::FilledHoles holes = repair::fill_holes(settled);
    changes.push_back("filled " + counted(holes.filled, "hole", "holes") + " (widest " +
                      millimetres(holes.widest_m) + ") first" +
                      (holes.left.empty() ? ""
                                          : ", but could not fill " +
                                                counted(holes.left.size(), "hole", "holes")));
    return holes.surface;
  } catch (const Error&) {
    return surface;  // a soup: wrapped as it is
  }
}

// Share of a closed surface's area from where, going in, its other side is no farther than thin_m.
double thin_share(const Surface& closed, double thin_m) {
  const BoxTree boxes = triangle_boxes(closed);
  const double skip_m = 1e-3 * thin_m;
  double thin = 0, all = 0;
  for (Eigen::Index f = 0; f < closed.triangles.rows(); ++f) {
    const auto [a, b, c] = corners_of(closed, f);
    const Vec3 normal = (b - a).cross(c - a);
    const auto across =
        ray_distance_m(closed, boxes, (a + b + c) / 3, -normal.normalized(), skip_m);
    all += normal.norm();
    if (across && *across <= thin_m) thin += normal.norm();
  }
  return all > 0 ? thin / all : 0;
}

Mended wrap(const Surface& surface, double alpha_m, const std::string& where,
            const std::string& why) {
  const double offset_m = 1.0 / 10 * alpha_m;
  Mended mended{{}, {"could not mend it (" + why + "), so wrapped it"}, true, 0};
  const Surface lidded = with_lids(surface, where, mended.changes);
  const Surface wrapped = repair::wrap_surface(lidded, alpha_m, offset_m);
  verify(wrapped, false, where);
  // Around an open sheet both sides of the wrap lie an offset off it: three times that is thin.
  const double thin_m = 3 * 2 * offset_m, share = thin_share(wrapped, thin_m);
  // Fins and rims of solid bodies may be thin: half of the area.
  if (share > 0.5)
    throw Error(where,
                "wrapped with alpha " + millimetres(alpha_m) + " it is a hollow shell: over " +
                    number(std::round(100 * share)) + " % of its area the other side is within " +
                    millimetres(thin_m) + " (" + why + ")",
                "Close the openings in a mesh editor, or give wrap a length wider than they are; "
                "a body as thin as that takes a smaller wrap.");
  mended.surface = wrapped;
  mended.moved_m =
      std::max(farthest_m(lidded, wrapped, alpha_m / 2), farthest_m(wrapped, lidded, alpha_m / 2));
  mended.changes.push_back("wrapped with alpha " + millimetres(alpha_m) + ": " +
                           counted(wrapped.triangles.rows(), "triangle", "triangles") +
                           ", at most " + millimetres(mended.moved_m) +
                           " from the original (Hausdorff distance)");
  report_volume(surface, wrapped, mended.changes);
  return mended;
}

}  // namespace

Mended mend_surface(const Surface& surface, const MendOptions& options, const std::string& where) {
  if (!(extent_m(surface.vertices).norm() > 0))
    throw Error(where, "all vertices lie at one place", "Check the mesh and its length unit.");
  try {
    return mend(surface, options.allow_open, where);
  } catch (const Error& error) {
    if (!options.wrap_alpha_m) throw;
    return wrap(surface, *options.wrap_alpha_m, where, error.fact());
  }
}

}  // namespace palpate
