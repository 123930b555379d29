// A surface through contact points.

#include "libfem/mesh/surface/surface.hpp"

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/linear_algebra.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/core/text.hpp"

namespace palpate {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

constexpr Eigen::Index kMinContacts = 6, kNear = 24;
// Damping of curvature where contacts do not determine it, and in gaps between them. Damped beyond
// the outermost as in gaps, the surface of six presses within 9 mm of a 60 mm ball curls up: it is
// 1.4 mm off one spacing beyond them instead of 0.03 mm. In a gap 1e-3 is 2.7 mm off, 1 is 0.5 mm.
constexpr double kRidge = 1e-3, kRidgeInGaps = 1;
constexpr double kReaches[] = {0.7, 1, 1.5, 2, 3};
// In spacings. kBeyond is the reach beyond the outermost contacts. On 10 layouts of 6 to 120
// contacts on two bodies the surface is 0.68 mm off there (mean of the largest) and 2 of 69
// contacts left out lie beyond its rim; with 0.75 it is 0.27 mm and 13, with 2 it is 1.2 mm and 1.
constexpr double kGrid = 0.5, kApart = 0.25, kNearby = 0.75, kBeyond = 1.5, kLongest = 2;

// Place and axes of a local height: rows u, v and inward.
struct HeightAxes {
  Vec3 origin;
  Mat3 axes;
  HeightAxes(const Vec3& at, const Vec3& inward) : origin(at) {
    const Vec3 u = inward.unitOrthogonal();
    axes << u.transpose(), inward.cross(u).transpose(), inward.transpose();
  }
  Vec3 local(const Vec3& x) const { return axes * (x - origin); }
};

struct Quadrics {
  const Contacts& contacts;
  double spacing_m = 0, reach = 1;
  bool uses_normals = false;

  // Contacts nearest to a place that face as its frame does, without one.
  std::vector<Eigen::Index> near(const HeightAxes& frame, const Vec3& at,
                                 Eigen::Index without) const {
    std::vector<Eigen::Index> all;
    // Contacts within 72 degrees are not on the other side of a thin body.
    for (Eigen::Index i = 0; i < contacts.position.rows(); ++i)
      if (i != without && frame.axes.row(2).dot(contacts.normal.row(i)) > 0.3) all.push_back(i);
    const auto away = [&](Eigen::Index i) {
      return (contacts.position.row(i).transpose() - at).squaredNorm();
    };
    const auto kept = std::min<std::size_t>(all.size(), kNear);
    std::partial_sort(all.begin(), all.begin() + kept, all.end(),
                      [&](Eigen::Index a, Eigen::Index b) {
                        return std::pair(away(a), a) < std::pair(away(b), b);
                      });
    all.resize(kept);
    return all;
  }

  // Height along the frame's inward axis at (u, v); nothing where too few contacts are near.
  std::optional<double> height(const HeightAxes& frame, double u, double v,
                               Eigen::Index without = -1, double damping = kRidge) const {
    const Vec3 at = frame.origin + frame.axes.transpose() * Vec3(u, v, 0);
    const auto used = near(frame, at, without);
    if (std::ssize(used) < kMinContacts) return std::nullopt;
    const auto n = static_cast<Eigen::Index>(used.size()), per = Eigen::Index{uses_normals ? 3 : 1};
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(per * n + 3, 6);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(per * n + 3);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Index c = used[i];
      const Vec3 x = frame.local(contacts.position.row(c));
      const Vec3 normal = frame.axes * contacts.normal.row(c).transpose();
      const double s = (x[0] - u) / spacing_m, t = (x[1] - v) / spacing_m;
      const double weight =
          std::exp(-0.5 * (s * s + t * t) / (reach * reach)) / contacts.deviation_m[c];
      a.row(per * i) << 1, s, t, s * s, s * t, t * t;
      b[per * i] = x[2];
      if (uses_normals) {  // z = f(u, v) has the inward normal (-f_u, -f_v, 1)
        a.row(per * i + 1) << 0, 1, 0, 2 * s, t, 0;
        a.row(per * i + 2) << 0, 0, 1, 0, s, 2 * t;
        b[per * i + 1] = -normal[0] / normal[2] * spacing_m;
        b[per * i + 2] = -normal[1] / normal[2] * spacing_m;
      }
      a.middleRows(per * i, per) *= weight;
      b.segment(per * i, per) *= weight;
    }
    const double ridge = damping * a.topRows(per * n).col(0).norm();
    for (int k = 0; k < 3; ++k) a(per * n + k, 3 + k) = ridge;
    return pivoted_least_squares(a, b)[0];
  }

  Eigen::VectorXd left_out_m() const {
    const Eigen::Index count = contacts.position.rows();
    Eigen::VectorXd out(count);
    for (Eigen::Index i = 0; i < count; ++i)
      out[i] = height(HeightAxes(contacts.position.row(i), contacts.normal.row(i)), 0, 0, i)
                   .value_or(std::numeric_limits<double>::quiet_NaN());
    return out;
  }
};

double spacing_of(const Points& position) {
  std::vector<double> nearest;
  for (Eigen::Index i = 0; i < position.rows(); ++i) {
    double best = std::numeric_limits<double>::infinity();
    for (Eigen::Index j = 0; j < position.rows(); ++j)
      if (j != i) best = std::min(best, (position.row(j) - position.row(i)).norm());
    nearest.push_back(best);
  }
  return upper_median(std::move(nearest));
}

// Contacts at one place are one; deviations that are not known are as the others'.
Contacts checked(const Contacts& raw) {
  const double spacing_m = spacing_of(raw.position);
  Contacts out{Points(raw.position.rows(), 3), Points(raw.position.rows(), 3), raw.deviation_m};
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < raw.position.rows(); ++i) {
    bool is_new = true;
    for (Eigen::Index j = 0; j < count; ++j)
      is_new &= (out.position.row(j) - raw.position.row(i)).norm() > 1e-3 * spacing_m;
    if (!is_new) continue;
    out.position.row(count) = raw.position.row(i);
    out.normal.row(count) = raw.normal.row(i);
    out.deviation_m[count++] = raw.deviation_m[i];
  }
  out.position.conservativeResize(count, 3);
  out.normal.conservativeResize(count, 3);
  out.deviation_m.conservativeResize(count);
  std::vector<double> known;
  for (const double m : out.deviation_m)
    if (m > 0) known.push_back(m);
  const double typical_m = known.empty() ? 1 : upper_median(known);
  for (double& m : out.deviation_m) m = m > 0 ? std::max(m, 0.1 * typical_m) : typical_m;
  const Points centred = out.position.rowwise() - out.position.colwise().mean();
  const Vec3 spread = symmetric_eigen(Mat3(centred.transpose() * centred)).values;  // squared
  if (count < kMinContacts || !(spread[1] > 1e-6 * spread[2]))
    throw Error("contacts",
                count < kMinContacts
                    ? counted(count, "place is", "places are") + " too few for a surface"
                    : std::string("all lie on one line, which is no surface"),
                "Touch the body at six places or more, spread over the part that is wanted.");
  return out;
}

// The choice that predicts contacts left out best.
Quadrics chosen_quadrics(const Contacts& contacts, double spacing_m) {
  Quadrics best{contacts, spacing_m}, tried = best;
  double least = std::numeric_limits<double>::infinity();
  for (const bool uses_normals : {false, true})
    for (const double reach : kReaches) {
      tried.reach = reach, tried.uses_normals = uses_normals;
      std::vector<double> residuals;
      for (const double m : tried.left_out_m())
        if (std::isfinite(m)) residuals.push_back(std::abs(m));
      if (const double middle = upper_median(residuals); !residuals.empty() && middle < least) {
        least = middle;
        best.reach = reach, best.uses_normals = uses_normals;
      }
    }
  return best;
}

// Along the mean normal; nothing where contacts face too far from it or lie above one another.
std::optional<HeightAxes> height_frame(const Contacts& contacts, double spacing_m) {
  const Vec3 mean = contacts.normal.colwise().mean().transpose();
  if (!(mean.norm() > 0.3)) return std::nullopt;
  const HeightAxes frame(contacts.position.colwise().mean().transpose(), mean.normalized());
  if (!((contacts.normal * mean.normalized()).minCoeff() > 0.3)) return std::nullopt;
  for (Eigen::Index i = 0; i < contacts.position.rows(); ++i)
    for (Eigen::Index j = 0; j < i; ++j) {
      const Vec3 between =
          frame.axes * (contacts.position.row(i) - contacts.position.row(j)).transpose();
      if (between.head<2>().norm() < kApart * spacing_m && std::abs(between[2]) > spacing_m)
        return std::nullopt;
    }
  return frame;
}

// Nodes of a grid near contacts, but not at them, with their heights.
std::vector<Vec3> grid_between(const Quadrics& quadrics, const HeightAxes& frame) {
  const Points& position = quadrics.contacts.position;
  const double step_m = kGrid * quadrics.spacing_m, around_m = kBeyond * quadrics.spacing_m;
  std::vector<Vec3> contact;
  Eigen::AlignedBox2d box;
  std::vector<double> residual_m;  // of the contact, from the quadric
  for (Eigen::Index i = 0; i < position.rows(); ++i) {
    contact.push_back(frame.local(position.row(i)));
    box.extend(contact.back().head<2>());
    residual_m.push_back(
        contact.back()[2] -
        quadrics.height(frame, contact.back()[0], contact.back()[1]).value_or(contact.back()[2]));
  }
  CGAL::Delaunay_triangulation_2<Kernel> hull;
  for (const Vec3& at : contact) hull.insert(Kernel::Point_2(at[0], at[1]));
  std::vector<Vec3> out;
  for (double v = box.min()[1] - around_m; v <= box.max()[1] + around_m; v += step_m)
    for (double u = box.min()[0] - around_m; u <= box.max()[0] + around_m; u += step_m) {
      double nearest = std::numeric_limits<double>::infinity(), correction_m = 0;
      for (std::size_t i = 0; i < contact.size(); ++i) {
        const double away =
            (contact[i].head<2>() - Eigen::Vector2d(u, v)).norm() / quadrics.spacing_m;
        nearest = std::min(nearest, away);
        correction_m += residual_m[i] * std::exp(-0.5 * std::pow(away / (0.5 * kGrid), 2));
      }
      const bool is_beyond = hull.is_infinite(hull.locate(Kernel::Point_2(u, v)));
      if (nearest < kApart || nearest > (is_beyond ? kBeyond : kLongest)) continue;
      const double ridge = nearest > kNearby && !is_beyond ? kRidgeInGaps : kRidge;
      if (const auto height = quadrics.height(frame, u, v, -1, ridge))
        out.emplace_back(u, v, *height + correction_m);
    }
  return out;
}

Surface height_field(const Quadrics& quadrics, const HeightAxes& frame) {
  const std::vector<Vec3> grid = grid_between(quadrics, frame);
  const Points& position = quadrics.contacts.position;
  Points vertices(position.rows() + std::ssize(grid), 3);
  vertices.topRows(position.rows()) = position;
  for (std::size_t i = 0; i < grid.size(); ++i)
    vertices.row(position.rows() + i) =
        (frame.origin + frame.axes.transpose() * grid[i]).transpose();
  using Base = CGAL::Triangulation_vertex_base_with_info_2<std::int32_t, Kernel>;
  using Delaunay =
      CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Base>>;
  Delaunay delaunay;
  std::vector<std::pair<Kernel::Point_2, std::int32_t>> places;
  for (Eigen::Index i = 0; i < vertices.rows(); ++i) {
    const Vec3 at = frame.local(vertices.row(i));
    places.emplace_back(Kernel::Point_2(at[0], at[1]), static_cast<std::int32_t>(i));
  }
  delaunay.insert(places.begin(), places.end());
  std::vector<Triangle> triangles;
  for (auto face = delaunay.finite_faces_begin(); face != delaunay.finite_faces_end(); ++face) {
    double longest_m = 0;
    for (int k = 0; k < 3; ++k)
      longest_m =
          std::max(longest_m, std::sqrt(CGAL::squared_distance(
                                  face->vertex(k)->point(), face->vertex((k + 1) % 3)->point())));
    if (longest_m > kLongest * quadrics.spacing_m) continue;
    // Counter-clockwise seen along the inward axis, so turned round.
    triangles.push_back(
        {face->vertex(0)->info(), face->vertex(2)->info(), face->vertex(1)->info()});
  }
  return compact(vertices, rows_of(triangles));
}

Surface around(const Contacts& contacts) {
  std::vector<Kernel::Point_3> points;
  for (Eigen::Index i = 0; i < contacts.position.rows(); ++i)
    points.emplace_back(contacts.position(i, 0), contacts.position(i, 1), contacts.position(i, 2));
  std::vector<std::array<std::size_t, 3>> facets;
  CGAL::advancing_front_surface_reconstruction(points.begin(), points.end(),
                                               std::back_inserter(facets));
  Triangles triangles(facets.size(), 3);
  double agreement = 0;  // of facets' normals with outward ones
  for (std::size_t f = 0; f < facets.size(); ++f) {
    const auto& facet = facets[f];
    for (std::size_t k = 0; k < 3; ++k) triangles(f, k) = static_cast<std::int32_t>(facet[k]);
    const auto at = [&](std::size_t k) { return Vec3(contacts.position.row(facet[k])); };
    const Vec3 area = (at(1) - at(0)).cross(at(2) - at(0));
    for (const std::size_t corner : facet) agreement -= area.dot(contacts.normal.row(corner));
  }
  if (agreement < 0) triangles.col(1).swap(triangles.col(2));
  return compact(contacts.position, triangles);
}

}  // namespace

ContactSurface surface_from_contacts(const Contacts& raw) {
  const Contacts contacts = checked(raw);
  ContactSurface out;
  out.spacing_m = spacing_of(contacts.position);
  const Quadrics quadrics = chosen_quadrics(contacts, out.spacing_m);
  out.reach = quadrics.reach;
  out.uses_normals = quadrics.uses_normals;
  out.left_out_m = quadrics.left_out_m();
  const auto frame = height_frame(contacts, out.spacing_m);
  out.is_height_field = frame.has_value();
  out.surface = frame ? height_field(quadrics, *frame) : around(contacts);
  if (out.surface.triangles.rows() == 0)
    throw Error("contacts", "lie too far apart for triangles between them",
                "Touch more places between them.");
  return out;
}

}  // namespace palpate
