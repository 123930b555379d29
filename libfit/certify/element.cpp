#include "libfit/certify/element.hpp"

#include <queue>
#include <vector>

namespace palpate::certify {
namespace {

using runtime::AssetView;
using runtime::CurvePiece;
using runtime::Vec3d;

constexpr double kFirstRange = 0.02;     // of the depths: from 0 on
constexpr double kRangeRatio = 1.3;      // of the ends of the others
constexpr double kTight = 1.1;           // bound over what was found, where it decides
constexpr double kTightEnough = 1.2;     // where it does not
constexpr double kLeastDepth = 1e-4;     // of the range: below it a range is not halved
constexpr double kMostHalvings = 9;      // of a patch
constexpr double kWitnessInside = 0.02;  // how far from the border a witness stands

double along(const Vec3d& v, const Vec3d& axis) { return dot(v, axis); }

void put_in_frame(const Element& e, const Vec3d& v, int corner, double out[3][3]) {
  for (int k = 0; k < 3; ++k) out[k][corner] = along(v, e.axis[k]);
}

void gradient_of(const Element& e, const double v[3][3], double out[3][2]) {
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 2; ++j)
      out[k][j] =
          v[k][0] * e.gradient[0][j] + v[k][1] * e.gradient[1][j] + v[k][2] * e.gradient[2][j];
}

/// kappa of a corner (xx, yy, zz, xy, xz, yz) in the element's frame.
void put_curvature(Element& e, const double* kappa, int corner) {
  const int from[6] = {0, 1, 2, 0, 0, 1}, to[6] = {0, 1, 2, 1, 2, 2};
  for (int i = 0; i < 6; ++i)
    e.curvature[i][corner] = along(runtime::curvature_times(kappa, e.axis[to[i]]), e.axis[from[i]]);
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

Patch patch_of(const Place& a, const Place& b, const Place& c) { return {{a, b, c}}; }
Place between(const Place& a, const Place& b) {
  return {{0.5 * (a.n[0] + b.n[0]), 0.5 * (a.n[1] + b.n[1]), 0.5 * (a.n[2] + b.n[2])}};
}
Place middle_of(const Patch& patch) {
  Place out{{0, 0, 0}};
  for (const Place& corner : patch.corner)
    for (int k = 0; k < 3; ++k) out.n[k] += corner.n[k] / 3;
  return out;
}
const Patch kWhole = patch_of({{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}});

struct Box {
  Patch patch;
  double from_m, to_m;
  int halvings;  // of the patch
  double ratio;
  bool operator<(const Box& other) const { return ratio < other.ratio; }
};

Cause cause_of(const Balance& b) {
  if (!(b.friction > 0)) return Cause::friction;
  const double turning = std::max(b.turning, 0.0);
  const double most = std::max(std::max(b.tilt, b.mismatch), std::max(turning, b.rings));
  if (b.paid == 0 && most == 0) return Cause::concave;
  return most == b.tilt       ? Cause::normals
         : most == b.mismatch ? Cause::stiffness
         : most == turning    ? Cause::curvature
                              : Cause::rings;
}

class Search {
 public:
  Search(const AssetView& asset, const Element& element, int t, double max_depth_m,
         const ElementOptions& options, OtherRings others)
      : asset_(asset),
        e_(element),
        t_(t),
        max_m_(max_depth_m),
        options_(options),
        others_(others) {}

  Sliding run(const std::vector<double>& ends) {
    for (const Place& place :
         {Place{{1, 0, 0}}, Place{{0, 1, 0}}, Place{{0, 0, 1}}, Place{{1.0 / 3, 1.0 / 3, 1.0 / 3}}})
      for (const double share : {1.0, 0.5, 0.2, 0.05}) look(place, share * max_m_);
    std::priority_queue<Box> open;
    double from_m = 0;
    for (const double end_m : ends) {
      open.push(bounded({kWhole, from_m, end_m, 0, 0}));
      from_m = end_m;
    }
    int boxes = static_cast<int>(ends.size());
    double closed = 0;  // of boxes that cannot be halved
    while (!open.empty() && boxes < options_.max_boxes) {
      const Box box = open.top();
      if (is_tight(std::max(box.ratio, closed))) break;
      open.pop();
      look(middle_of(box.patch), 0.5 * (box.from_m + box.to_m));
      const bool can_halve_depth = box.to_m > kLeastDepth * max_m_,
                 can_halve_patch = box.halvings < kMostHalvings;
      if (!can_halve_depth && !can_halve_patch) {
        closed = std::max(closed, box.ratio);
        continue;
      }
      const double range = 2 * (box.to_m - box.from_m) / box.to_m,
                   width = std::pow(0.7, box.halvings) * variation();
      const bool halves_depth = can_halve_depth && (!can_halve_patch || range > width);
      for (int half = 0; half < 2; ++half) {
        Box next = box;
        if (halves_depth) {
          const double cut_m = 0.5 * (box.from_m + box.to_m);
          (half == 0 ? next.to_m : next.from_m) = cut_m;
        } else {
          const Place cut = between(box.patch.corner[0], box.patch.corner[1]);
          next.patch = half == 0 ? patch_of(box.patch.corner[2], box.patch.corner[0], cut)
                                 : patch_of(box.patch.corner[1], box.patch.corner[2], cut);
          ++next.halvings;
        }
        open.push(bounded(next));
        ++boxes;
      }
    }
    Sliding out;
    out.ratio = std::max(closed, open.empty() ? 0.0 : open.top().ratio);
    out.worst_found = found_.ratio;
    out.friction = found_.friction;
    out.verdict = out.ratio <= 1 ? Verdict::certified : Verdict::undecided;
    if (out.ratio > 1 || found_.ratio > 0) out.cause = cause_of(found_);
    if (out.verdict == Verdict::undecided && found_.ratio > 1) {
      Place place = place_;
      for (double& n : place.n) n += kWitnessInside * (1.0 / 3 - n);
      for (const Place& at : {place, place_}) {
        out.witness = replay_slip(asset_, e_, t_, at, std::min(depth_m_, 0.999 * max_m_),
                                  found_.sector, others_);
        if (out.witness.created_J > 0) break;
      }
      if (out.witness.created_J > 0) out.verdict = Verdict::fails;
    }
    return out;
  }

 private:
  Box bounded(Box box) const {
    const auto depth = over_depths(asset_, e_, t_, box.from_m, box.to_m);
    box.ratio = balance(e_, box.patch, depth, others_).ratio;
    return box;
  }
  void look(const Place& place, double depth_m) {
    const Balance here = balance(e_, place, at_depth(asset_, e_, t_, depth_m), others_);
    if (has_looked_ && !(here.ratio > found_.ratio)) return;
    has_looked_ = true;
    found_ = here;
    place_ = place;
    depth_m_ = depth_m;
  }
  bool is_tight(double ratio) const {
    if (ratio <= 1) return ratio <= kTightEnough * found_.ratio || ratio < 0.1;
    return ratio <= kTight * found_.ratio;
  }
  /// How much more a patch matters than a range of depths: normals turn and stiffness changes.
  double variation() const { return 1; }

  const AssetView& asset_;
  const Element& e_;
  int t_;
  double max_m_;
  const ElementOptions& options_;
  OtherRings others_;
  Balance found_;
  bool has_looked_ = false;
  Place place_{};
  double depth_m_ = 0;
};

bool pushes_over(const AssetView& asset, const Element& e, int t, const Patch& patch, double from_m,
                 double to_m, int halvings) {
  if (pushes(e, patch, over_depths(asset, e, t, from_m, to_m))) return true;
  if (halvings == 0) return false;
  const Place cut = between(patch.corner[0], patch.corner[1]);
  const double cut_m = 0.5 * (from_m + to_m);
  const Patch half[2] = {patch_of(patch.corner[2], patch.corner[0], cut),
                         patch_of(patch.corner[1], patch.corner[2], cut)};
  if (halvings % 2 == 1)
    return pushes_over(asset, e, t, half[0], from_m, to_m, halvings - 1) &&
           pushes_over(asset, e, t, half[1], from_m, to_m, halvings - 1);
  return pushes_over(asset, e, t, patch, from_m, cut_m, halvings - 1) &&
         pushes_over(asset, e, t, patch, cut_m, to_m, halvings - 1);
}

/// Ends of ranges of depth, none across a knot.
std::vector<double> ranges_of(const AssetView& asset, double max_m) {
  std::vector<double> ends;
  const runtime::SplineView& view = asset.curves.view[runtime::kNormal];
  for (double end = kFirstRange * max_m; end < max_m; end *= kRangeRatio) ends.push_back(end);
  for (int i = 1; i < view.pieces; ++i)
    if (view.knots[i] < max_m) ends.push_back(view.knots[i]);
  ends.push_back(max_m);
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  return ends;
}

}  // namespace

Element element_of(const AssetView& asset, int t, const ElementOptions& options) {
  Element e;
  e.radius_m = options.radius_m;
  e.overshoot_m = 2 * options.max_step_m;
  const int corner[3] = {asset.corner(t, 0), asset.corner(t, 1), asset.corner(t, 2)};
  const Vec3d a = asset.vertex_at(corner[0]), area = asset.area_vector(t);
  e.origin = a;
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
    const runtime::CornerSpot spot{asset.node(corner[l]), asset.control_offset};
    e.lambda[l] = spot.control(runtime::kLambda, 0);
    e.friction[l] = spot.control(runtime::kFriction, 0);
    e.friction_slope[l] = spot.control(runtime::kFrictionSlope, 0);
    double c[kRings], side[6], kappa[6];
    runtime::ring_stiffness(asset.curves.rings, spot, c);
    for (int i = 0; i < kRings; ++i) e.stiffness[i][l] = c[i];
    runtime::copy_controls(spot, runtime::kSide2, 0, 6, side);
    put_in_frame(e, runtime::make_vec3<double>(side), l, e.side2);
    put_in_frame(e, runtime::make_vec3<double>(side + 3), l, e.side3);
    runtime::copy_controls(spot, runtime::kCurvature, 0, 6, kappa);
    put_curvature(e, kappa, l);
  }
  gradient_of(e, e.normal, e.turn);
  gradient_of(e, e.side2, e.side2_turn);
  gradient_of(e, e.side3, e.side3_turn);
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 6; ++i) {
      e.curvature_turn[j][i] = 0;
      for (int l = 0; l < 3; ++l) e.curvature_turn[j][i] += e.curvature[i][l] * e.gradient[l][j];
    }
  return e;
}

Depth<double> at_depth(const AssetView& asset, const Element& e, int t, double d) {
  Depth<double> out{d, {}, {0, 0}, {}};
  double energy[3];
  for (int l = 0; l < 3; ++l) {
    const Polynomials p = polynomials_of(asset, asset.corner(t, l), d);
    const double s = d - p.knot;
    out.force[l] = over(p.force, p.order, s, s).lo / d;
    energy[l] = over(p.area, p.order + 1, s, s).lo / d;
    out.energy[l] = energy[l] / d;
  }
  for (int j = 0; j < 2; ++j)
    out.energy_slope[j] =
        (energy[1] - energy[0]) * e.gradient[1][j] + (energy[2] - energy[0]) * e.gradient[2][j];
  return out;
}

Depth<Interval> over_depths(const AssetView& asset, const Element& e, int t, double from_m,
                            double to_m) {
  Depth<Interval> out{{from_m, to_m}, {}, {}, {}};
  Polynomials p[3];
  for (int l = 0; l < 3; ++l)
    p[l] = polynomials_of(asset, asset.corner(t, l), 0.5 * (from_m + to_m));
  const double from = from_m - p[0].knot, to = to_m - p[0].knot;
  Interval difference[3];
  for (int l = 0; l < 3; ++l) {
    double area[runtime::kMaxDegree + 2];
    for (int m = 0; m <= p[l].order; ++m) area[m] = p[l].area[m] - (l > 0 ? p[0].area[m] : 0);
    if (from_m > 0) {
      out.force[l] = over(p[l].force, p[l].order, from, to) / out.m;
      out.energy[l] = over(p[l].area, p[l].order + 1, from, to) / out.m / out.m;
      difference[l] = over(area, p[l].order + 1, from, to) / out.m;
    } else {  // polynomials that begin at 0 and with a slope
      out.force[l] = over(p[l].force + 1, p[l].order - 1, from, to);
      out.energy[l] = over(p[l].area + 2, p[l].order - 1, from, to);
      difference[l] = over(area + 1, p[l].order, from, to);
    }
  }
  for (int j = 0; j < 2; ++j)
    out.energy_slope[j] = difference[1] * e.gradient[1][j] + difference[2] * e.gradient[2][j];
  return out;
}

bool pushes_on(const AssetView& asset, int t, const ElementOptions& options) {
  const Element e = element_of(asset, t, options);
  // Towards a corner where nothing is known all sides of (M22) fade alike: the others say it.
  Place corner[3];
  int known = 0;
  for (int k = 0; k < 3; ++k)
    if (asset.covered[asset.corner(t, k)]) corner[known++] = kWhole.corner[k];
  for (int k = known; k < 3; ++k) corner[k] = corner[0];
  double from_m = 0;
  for (const double end_m :
       ranges_of(asset, std::min(asset.max_fitted_m, double(asset.max_depth_m[t])))) {
    if (!pushes_over(asset, e, t, patch_of(corner[0], corner[1], corner[2]), from_m, end_m, 6))
      return false;
    from_m = end_m;
  }
  return true;
}

ElementCertificate certify_element(const AssetView& asset, int t, const ElementOptions& options) {
  ElementCertificate out;
  const Element e = element_of(asset, t, options);
  out.max_depth_m = std::min(asset.max_fitted_m, double(asset.max_depth_m[t]));
  const std::vector<double> ends = ranges_of(asset, out.max_depth_m);
  out.any = Search(asset, e, t, out.max_depth_m, options, OtherRings::any).run(ends);
  out.sliding = Search(asset, e, t, out.max_depth_m, options, OtherRings::sliding).run(ends);
  return out;
}

Witness replay_slip(const AssetView& asset, const Element& e, int t, const Place& place,
                    double depth_m, int sector, OtherRings others) {
  Witness out;
  out.triangle = t;
  out.depth_m = depth_m;
  for (int k = 0; k < 3; ++k) out.weight[k] = place.n[k];
  // The spot, and where its deflection points.
  Vec3d field{0, 0, 0}, c{0, 0, 0};
  for (int l = 0; l < 3; ++l) {
    field = field + asset.normal_at(asset.corner(t, l)) * place.n[l];
    c = c + asset.vertex_at(asset.corner(t, l)) * place.n[l];
  }
  const double inverse = 1 / std::sqrt(dot(field, field));
  const Vec3d u = field * inverse;
  const auto& way = detail::directions(false);
  const double toward[2] = {way.x[sector], way.y[sector]};
  Vec3d turned{0, 0, 0};
  for (int k = 0; k < 3; ++k)
    turned = turned + e.axis[k] * (e.turn[k][0] * toward[0] + e.turn[k][1] * toward[1]);
  turned = tangential(turned, u) * inverse;
  const Vec3d over_facet = e.axis[0] * toward[0] + e.axis[1] * toward[1];
  const Vec3d along_q = normalized(tangential(over_facet, u) - turned * e.radius_m);
  const double lambda = place.blend(e.lambda),
               mu = place.blend(e.friction) + place.blend(e.friction_slope) * depth_m;
  double kappa[6];
  for (int i = 0; i < 6; ++i) {
    kappa[i] = 0;
    for (int l = 0; l < 3; ++l)
      kappa[i] +=
          place.n[l] *
          double(asset.node(asset.corner(t, l))[asset.control_offset[runtime::kCurvature] + i]);
  }
  out.deflection_m = mu * depth_m / lambda;
  runtime::put(along_q, out.direction);
  AssetView bare = asset;
  bare.has_guard = false;
  for (const double beyond_m : {2e-5, 5e-6, 1e-6}) {
    const Vec3d q = along_q * (out.deflection_m + beyond_m);
    const double height = depth_m + 0.5 * dot(q, runtime::curvature_times(kappa, q));
    const Vec3d x = c + u * (height - e.radius_m) + q;
    runtime::Contact contact;
    contact.has_tip = true;
    contact.asset_checksum = asset.checksum;
    runtime::put(x, contact.tip_m);
    contact.triangle = t;
    for (int k = 0; k < 3; ++k) contact.weight[k] = place.n[k];
    contact.arm.reach_m = e.radius_m;
    const double turn_size = std::sqrt(dot(turned, turned));
    for (int i = 1; i < kRings; ++i) {
      const double reach = depth_m - e.threshold[i], limit_m = reach > 0 ? mu * reach / lambda : 0;
      Vec3d qi = along_q * (limit_m + beyond_m);
      if (others == OtherRings::any)
        qi = turn_size > 0 ? turned * (-limit_m / turn_size) : Vec3d{0, 0, 0};
      runtime::put(q - qi, contact.memory + 3 * i);
    }
    double tip_m[3];
    runtime::put(x + runtime::make_vec3<double>(asset.origin_m), tip_m);
    runtime::Output tick;
    runtime::touch_ball(bare, contact, tip_m, e.radius_m, tick);
    if (-tick.dissipated_J > out.created_J) {
      out.created_J = -tick.dissipated_J;
      out.stored_J = tick.stored_J - out.created_J;
    }
  }
  return out;
}

}  // namespace palpate::certify
