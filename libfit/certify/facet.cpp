#include "libfit/certify/facet.hpp"

#include <algorithm>

namespace palpate::certify {
namespace {

using runtime::AssetView;
using runtime::CurvePiece;
using runtime::Vec3d;

double along(const Vec3d& v, const Vec3d& axis) { return dot(v, axis); }

void put_in_frame(const Facet& e, const Vec3d& v, int corner, double out[3][3]) {
  for (int k = 0; k < 3; ++k) out[k][corner] = along(v, e.axis[k]);
}

void gradient_of(const Facet& e, const double v[3][3], double out[3][2]) {
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 2; ++j)
      out[k][j] =
          v[k][0] * e.gradient[0][j] + v[k][1] * e.gradient[1][j] + v[k][2] * e.gradient[2][j];
}

/// A symmetric tensor of a corner (xx, yy, zz, xy, xz, yz) in the facet's frame.
void put_tensor(const Facet& e, const double* tensor, int corner, double out[6][3]) {
  const int from[6] = {0, 1, 2, 0, 0, 1}, to[6] = {0, 1, 2, 1, 2, 2};
  for (int i = 0; i < 6; ++i)
    out[i][corner] = along(runtime::curvature_times(tensor, e.axis[to[i]]), e.axis[from[i]]);
}
void gradient_of(const Facet& e, const double tensor[6][3], double out[2][6]) {
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 6; ++i)
      out[j][i] = tensor[i][0] * e.gradient[0][j] + tensor[i][1] * e.gradient[1][j] +
                  tensor[i][2] * e.gradient[2][j];
}

/// A corner's force and area as polynomials in t from a knot.
struct Polynomials {
  double force[runtime::kMaxDegree + 1], area[runtime::kMaxDegree + 2];
  int order;
  double knot;
};
Polynomials polynomials_of(const AssetView& asset, int vertex, double d) {
  const CurvePiece<double> piece = runtime::piece_under(
      asset.curves, runtime::CornerSpot{asset.node(vertex), asset.control_offset}, runtime::kNormal,
      d, true);
  Polynomials out{{}, {}, piece.order, piece.knot};
  out.area[0] = piece.area_J;
  for (int m = 0; m < piece.order; ++m) {
    out.force[m] = piece.c[m];
    out.area[m + 1] = piece.c[m] / (m + 1);
  }
  return out;
}

/// A polynomial over [from, to], by its Taylor series about the middle.
Interval over(const double* c, int terms, double from, double to) {
  double shifted[runtime::kMaxDegree + 2];
  std::copy(c, c + terms, shifted);
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  for (int i = 0; i < terms; ++i)
    for (int m = terms - 2; m >= i; --m) shifted[m] += middle * shifted[m + 1];
  double reach = 0, power = half;
  for (int m = 1; m < terms; ++m, power *= half) reach += std::fabs(shifted[m]) * power;
  return {shifted[0] - reach, shifted[0] + reach};
}

/// h_i of the law, and over the depth.
double reach_m(const Facet& e, int ring, double d) {
  return ring == 0 ? d : std::max(d - e.threshold[ring], 0.0);
}
double share_touching(const Facet& e, int ring, double d) {
  return ring == 0 ? 1 : d > 0 ? reach_m(e, ring, d) / d : 0;
}
/// What limit_share() reads of corner l over a range of depths.
void put_bearing(const Facet& e, int l, const Polynomials& p, CurveTerms<Interval>& out) {
  const double middle_m = 0.5 * (out.m.lo + out.m.hi), from = out.m.lo - p.knot,
               to = out.m.hi - p.knot;
  double slope[runtime::kMaxDegree + 1] = {};
  for (int m = 1; m < p.order; ++m) slope[m - 1] = m * p.force[m];
  out.half_m = 0.5 * (out.m.hi - out.m.lo);
  out.force_there[l] = over(p.force, p.order, middle_m - p.knot, middle_m - p.knot).lo;
  out.force_rise[l] = over(slope, std::max(p.order - 1, 1), from, to);
  out.bed_there[l] = 0;
  out.bed_rise[l] = out.bed[l] = Interval(0);
  for (int i = 0; i < kRings; ++i) {
    const double c = e.stiffness[i][l];
    out.bed_there[l] += c * reach_m(e, i, middle_m);
    out.bed[l] =
        out.bed[l] + Interval(share_touching(e, i, out.m.lo), share_touching(e, i, out.m.hi)) * c;
    const bool all_touch = i == 0 || out.m.lo >= e.threshold[i],
               some_touch = i == 0 || out.m.hi > e.threshold[i];
    out.bed_rise[l] = out.bed_rise[l] + Interval(all_touch, some_touch) * c;
  }
}

}  // namespace

Facet facet_of(const AssetView& asset, int t, const FacetOptions& options) {
  Facet e;
  e.radius_m = options.radius_m;
  e.overshoot_m = 2 * options.max_step_m;
  const int corner[3] = {asset.corner(t, 0), asset.corner(t, 1), asset.corner(t, 2)};
  const Vec3d a = asset.vertex_at(corner[0]), area = asset.area_vector(t);
  e.axis[2] = normalized(area) * -1.0;
  e.axis[0] = normalized(asset.vertex_at(corner[1]) - a);
  e.axis[1] = cross(e.axis[2], e.axis[0]);
  double x[3], y[3];
  for (int l = 0; l < 3; ++l) {
    const Vec3d p = asset.vertex_at(corner[l]) - a;
    x[l] = along(p, e.axis[0]);
    y[l] = along(p, e.axis[1]);
  }
  const double twice = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
  for (int l = 0; l < 3; ++l) {
    const int p = (l + 1) % 3, q = (l + 2) % 3;
    e.gradient[l][0] = (y[p] - y[q]) / twice;
    e.gradient[l][1] = (x[q] - x[p]) / twice;
  }
  for (int i = 0; i < kRings; ++i) e.threshold[i] = asset.curves.rings.threshold_m[i];
  for (int l = 0; l < 3; ++l) {
    put_in_frame(e, asset.normal_at(corner[l]), l, e.normal);
    runtime::Corner node;
    runtime::read_corner(asset, corner[l], node);
    const double* const number = node.row + runtime::kNumbersAt;
    e.lambda[l] = number[0];
    e.friction[l] = number[1];
    e.friction_slope[l] = number[2];
    e.outward[l] = node.row[runtime::kSpreadAt];
    for (int i = 0; i < kRings; ++i) e.stiffness[i][l] = node.row[runtime::kStiffnessAt + i];
    put_in_frame(e, runtime::make_vec3<double>(node.row + runtime::kSideAt), l, e.side2);
    put_in_frame(e, runtime::make_vec3<double>(node.row + runtime::kSideAt + 3), l, e.side3);
    put_tensor(e, number + 3, l, e.curvature);
    double tensor[6];
    runtime::copy_controls(runtime::CornerSpot{node.node, asset.control_offset}, runtime::kSway, 0,
                           6, tensor);
    put_tensor(e, tensor, l, e.sway);
  }
  for (int j = 0; j < 2; ++j)
    e.outward_turn[j] = e.outward[0] * e.gradient[0][j] + e.outward[1] * e.gradient[1][j] +
                        e.outward[2] * e.gradient[2][j];
  gradient_of(e, e.normal, e.turn);
  gradient_of(e, e.side2, e.side2_turn);
  gradient_of(e, e.side3, e.side3_turn);
  gradient_of(e, e.curvature, e.curvature_turn);
  gradient_of(e, e.sway, e.sway_turn);
  e.sways = asset.sways;
  return e;
}

double range_of(const AssetView& asset, int t) {
  return std::min(asset.max_fitted_m, double(asset.max_depth_m[t]));
}

CurveTerms<double> at_depth(const AssetView& asset, const Facet& e, int t, double d) {
  CurveTerms<double> out;
  out.m = d;
  double energy[3];
  for (int l = 0; l < 3; ++l) {
    const Polynomials p = polynomials_of(asset, asset.corner(t, l), d);
    const double s = d - p.knot;
    out.force[l] = over(p.force, p.order, s, s).lo / d;
    energy[l] = over(p.area, p.order + 1, s, s).lo / d;
    out.energy[l] = energy[l] / d;
    out.bed[l] = 0;
    for (int i = 0; i < kRings; ++i) out.bed[l] += e.stiffness[i][l] * share_touching(e, i, d);
  }
  for (int j = 0; j < 2; ++j) {
    out.force_slope[j] = (out.force[1] - out.force[0]) * e.gradient[1][j] +
                         (out.force[2] - out.force[0]) * e.gradient[2][j];
    out.energy_slope[j] =
        (energy[1] - energy[0]) * e.gradient[1][j] + (energy[2] - energy[0]) * e.gradient[2][j];
  }
  return out;
}

CurveTerms<Interval> over_depths(const AssetView& asset, const Facet& e, int t, double from_m,
                                 double to_m) {
  CurveTerms<Interval> out;
  out.m = {from_m, to_m};
  Polynomials p[3];
  for (int l = 0; l < 3; ++l)
    p[l] = polynomials_of(asset, asset.corner(t, l), 0.5 * (from_m + to_m));
  const double from = from_m - p[0].knot, to = to_m - p[0].knot;
  Interval difference[3], stiffer[3];
  for (int l = 0; l < 3; ++l) {
    double area[runtime::kMaxDegree + 2], force[runtime::kMaxDegree + 1];
    for (int m = 0; m <= p[l].order; ++m) area[m] = p[l].area[m] - (l > 0 ? p[0].area[m] : 0);
    for (int m = 0; m < p[l].order; ++m) force[m] = p[l].force[m] - (l > 0 ? p[0].force[m] : 0);
    if (from_m > 0) {
      out.force[l] = over(p[l].force, p[l].order, from, to) / out.m;
      out.energy[l] = over(p[l].area, p[l].order + 1, from, to) / out.m / out.m;
      difference[l] = over(area, p[l].order + 1, from, to) / out.m;
      stiffer[l] = over(force, p[l].order, from, to) / out.m;
    } else {  // polynomials that begin at 0 and with a slope
      out.force[l] = over(p[l].force + 1, p[l].order - 1, from, to);
      out.energy[l] = over(p[l].area + 2, p[l].order - 1, from, to);
      difference[l] = over(area + 1, p[l].order, from, to);
      stiffer[l] = over(force + 1, p[l].order - 1, from, to);
    }
    put_bearing(e, l, p[l], out);
  }
  for (int j = 0; j < 2; ++j) {
    out.force_slope[j] = stiffer[1] * e.gradient[1][j] + stiffer[2] * e.gradient[2][j];
    out.energy_slope[j] = difference[1] * e.gradient[1][j] + difference[2] * e.gradient[2][j];
  }
  return out;
}

}  // namespace palpate::certify
