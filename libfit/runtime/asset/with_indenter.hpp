// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// An asset for another round indenter (docs/method-tools.md, section 30). An even half-space has a
// stiffness of 2 E* a under any tool (Pharr, Oliver, Brotzen 1992, doi:10.1557/JMR.1992.0613). What
// a press by the asset's ball says of E* belongs to its depth or to its contact's radius. With d(a)
// of (M80), and a_0 and d_0 of the ball,
//
//     K_d(d) = f^z'(d) a(d) / a_0(d)      K_a(d) = f^z'(d_0(a(d)))                          (M81)
//     F(d) = int_0^d K ds      K = (1 + k ln(R/R_0)) K_d + w (K_a - K_d)                    (M83)
//
// F is linear in the control values of f^z. Its basis is tabulated here once, in memory of the
// caller's, and a tick costs what it costs with the indenter of the asset.

#include <new>

#include "../base/once.hpp"
#include "../law/indenter.hpp"
#include "view.hpp"

namespace palpate::runtime {

/// Intervals that the table of an asset has at most.
inline int max_indenter_pieces(const AssetView& asset) noexcept {
  return 2 * asset.curves.view[kNormal].pieces + kExtraIndenterPieces;
}
/// Bytes that with_indenter() needs, 8-byte aligned.
inline std::uint64_t indenter_bytes(const AssetView& asset) noexcept {
  const std::uint64_t rows = max_indenter_pieces(asset) + 1;
  const std::uint64_t size = asset.curves.view[kNormal].size();
  constexpr std::uint64_t kOrder = kMaxDegree + 1;
  return sizeof(IndenterView) + 8 * (2 * rows + 2 * ((rows + 1) / 2) +
                                     (1 + kRadiusEffects) * rows * (kOrder * kOrder + 2 * size));
}

/// Tabulates one indenter on one asset.
class IndenterTable {
 public:
  IndenterTable(const AssetView& asset, const Indenter& tool, void* memory) noexcept
      : own_(asset.curves.view[kNormal]),
        ball_(ball_indenter(asset.probe_radius_m)),
        tool_(tool),
        size_(own_.size()),
        order_(size_ < kMaxDegree + 1 ? size_ : kMaxDegree + 1),
        max_pieces_(max_indenter_pieces(asset)),
        depth_m_(own_.knots[own_.pieces]),
        first_row_m_(asset.first_row_m > 0 && asset.first_row_m < depth_m_ ? asset.first_row_m
                                                                           : own_.knots[1]),
        widest_m_(contact_radius_at(ball_, depth_m_)) {
    auto* at = static_cast<unsigned char*>(memory);
    view_ = new (at) IndenterView();
    at += sizeof(IndenterView);
    const auto take = [&at](int count) noexcept {
      auto* out = reinterpret_cast<double*>(at);
      at += 8 * static_cast<std::ptrdiff_t>(count);
      return out;
    };
    knots_ = take(max_pieces_ + 1);
    own_depth_m_ = take(max_pieces_ + 1);
    for (Set& set : set_) {
      set.weights = take((max_pieces_ + 1) * order_ * order_);
      set.begins = take((max_pieces_ + 1) * size_);
      set.integrals = take((max_pieces_ + 1) * size_);
    }
    for (std::int32_t*& first : first_)
      first = reinterpret_cast<std::int32_t*>(take((max_pieces_ + 2) / 2));
    fill();
  }

  SplineView normal() const noexcept { return spline(0); }
  IndenterView& view() const noexcept { return *view_; }
  SplineView by_radius(int i) const noexcept { return spline(1 + i); }
  /// Depth up to which its contact is no wider, and the tool no steeper, than what is known.
  double measured_m() const noexcept {
    const double wide = depth_at(tool_, widest_m_),
                 steep = known_depth_m(tool_, ball_.round_end_m, depth_m_);
    return wide < steep ? wide : steep;
  }

 private:
  static constexpr int kSets = 1 + kRadiusEffects;
  /// The sets of a table: K_d, what k is times, and K_a. The first two are of the ball's own depth.
  static constexpr int kSameWidth = kSets - 1;
  struct Set {
    double *weights, *begins, *integrals;
  };
  /// Slopes of basis functions that are alive at a depth, [1/m] of each set.
  struct LiveSlopes {
    double of[kSets][kMaxDegree + 1] = {};
  };
  /// Interval of the asset's own basis that answers: of the same depth, and of the same width.
  struct Pieces {
    int of[2];
    bool is_below[2];  ///< the first row
  };

  SplineView spline(int set) const noexcept {
    SplineView out;
    out.degree = order_ - 1;
    out.pieces = pieces_;
    out.knots = knots_;
    out.weights = set_[set].weights;
    out.integrals = set_[set].integrals;
    out.controls = size_;
    out.first = first_[set == kSameWidth];
    out.begins = set_[set].begins;
    return out;
  }

  /// Depth of the asset's own ball where its contact is as wide, at most the deepest measured.
  double as_wide_m(double depth_m) const noexcept {
    const double own_m = depth_at(ball_, contact_radius_at(tool_, depth_m));
    return own_m < depth_m_ ? own_m : depth_m_;
  }
  Pieces pieces_at(double depth_m) const noexcept {
    Pieces out{};
    const double own_m[2] = {depth_m, as_wide_m(depth_m)};
    for (int i = 0; i < 2; ++i) {
      out.is_below[i] = own_m[i] < first_row_m_;
      const int piece = find_piece(own_, out.is_below[i] ? first_row_m_ : own_m[i]);
      out.of[i] = piece < own_.pieces ? piece : own_.pieces - 1;
    }
    return out;
  }
  /// Below the first row and beyond the widest contact that was measured K is that of an even
  /// half-space, proportional to a (M82): with the force of the first row, and going on from the
  /// last.
  LiveSlopes slopes_at(double depth_m, const Pieces& pieces) const noexcept {
    LiveSlopes out;
    const double d = depth_m > 1e-9 * depth_m_ ? depth_m : 1e-9 * depth_m_;
    const double a = contact_radius_at(tool_, d);
    double radius = ball_as_deep(a, d) / ball_.round_end_m;
    radius = radius < kMinRadiusRatio   ? kMinRadiusRatio
             : radius > kMaxRadiusRatio ? kMaxRadiusRatio
                                        : radius;
    const double rounder = log_of(radius);
    for (int i = 0; i < 2; ++i) {
      const bool is_below = pieces.is_below[i];
      const double own_m = is_below ? first_row_m_ : i == 0 ? d : as_wide_m(d);
      const double stretch = is_below        ? a / first_area_
                             : i == 0        ? a / contact_radius_at(ball_, own_m)
                             : a > widest_m_ ? a / widest_m_
                                             : 1;
      const SplineWeights<double> at = spline_weights(own_, pieces.of[i], own_m);
      const int shift = at.first - first_of(pieces.of[i]);
      for (int k = 0; k <= own_.degree; ++k) {
        const double slope = (is_below ? at.value[k] : at.slope[k]) * stretch;
        if (i == 0) out.of[1][shift + k] = slope * rounder;
        out.of[i == 0 ? 0 : kSameWidth][shift + k] = slope;
      }
    }
    return out;
  }

  void fill() noexcept {
    // int_0^d a ds of the own ball, which c of K = c a below the first row is the force over.
    constexpr int kSteps = 32;
    for (int i = 0; i < kSteps; ++i)
      first_area_ +=
          contact_radius_at(ball_, first_row_m_ * (i + 0.5) / kSteps) * (first_row_m_ / kSteps);
    for (Set& set : set_)
      for (int j = 0; j < size_; ++j) set.begins[j] = set.integrals[j] = 0;
    pieces_ = 0;
    knots_[0] = 0;
    begin();
    // Breaks of K_d and of K_a, the nearest first.
    int next[2] = {0, 0};
    while (knots_[pieces_] < depth_m_ * (1 - 1e-9)) {
      double to_m = depth_m_;
      for (int i = 0; i < 2; ++i) {
        while (next[i] <= own_.pieces && !(break_m(i, next[i]) > knots_[pieces_] * (1 + 1e-6)))
          ++next[i];
        const double at_m = next[i] <= own_.pieces ? break_m(i, next[i]) : depth_m_;
        to_m = at_m < to_m ? at_m : to_m;
      }
      to_m = to_m < depth_m_ * (1 - 1e-6) ? to_m : depth_m_;
      divide(pieces_at(0.5 * (knots_[pieces_] + to_m)), knots_[pieces_], to_m, 0);
    }
    extrapolate();
    for (int i = 0; i <= pieces_; ++i) own_depth_m_[i] = as_wide_m(i > 0 ? knots_[i] : even_m());
    view_->own_depth_m = own_depth_m_;
  }
  /// Depth at which the first row (j = 0), or a knot of the asset, comes to answer.
  double break_m(int i, int j) const noexcept {
    const double own_m = j == 0 ? first_row_m_ : own_.knots[j];
    return i == 0 ? own_m : depth_at(tool_, contact_radius_at(ball_, own_m));
  }

  double even_m() const noexcept { return kEvenShare * first_row_m_; }
  /// The first interval, with a stiffness that is not 0 at 0.
  void begin() noexcept {
    const Pieces pieces = pieces_at(even_m());
    const LiveSlopes slopes = slopes_at(even_m(), pieces);
    double c[kSets][kMaxDegree + 1][kMaxDegree + 1] = {};
    for (int set = 0; set < kSets; ++set)
      for (int k = 0; k < order_; ++k) c[set][k][0] = slopes.of[set][k];
    put(pieces, even_m(), c);
    knots_[pieces_] = even_m();
  }

  /// Puts in the interval, or its halves where one polynomial is not good enough.
  void divide(const Pieces& pieces, double from_m, double to_m, int halvings) noexcept {
    double c[kSets][kMaxDegree + 1][kMaxDegree + 1];
    const bool is_good = interpolate(pieces, from_m, to_m, c);
    // Every interval of the asset that is still to come needs one.
    const int to_come = 2 * own_.pieces - pieces.of[0] - pieces.of[1];
    const bool has_room = pieces_ + kMaxHalvings + 4 + to_come <= max_pieces_;
    if (!is_good && halvings < kMaxHalvings && has_room) {
      const double middle = 0.5 * (from_m + to_m);
      divide(pieces, from_m, middle, halvings + 1);
      divide(pieces, middle, to_m, halvings + 1);
      return;
    }
    put(pieces, to_m - from_m, c);
    knots_[pieces_] = to_m;
  }
  int first_of(int piece) const noexcept { return piece < size_ - order_ ? piece : size_ - order_; }

  /// Polynomials of the slopes through places of the interval: c[set][k][m], of t^m. Whether they
  /// are near enough between.
  bool interpolate(const Pieces& pieces, double from_m, double to_m,
                   double c[kSets][kMaxDegree + 1][kMaxDegree + 1]) const noexcept {
    constexpr double kInner = 0.27639320225002106;  // of Lobatto's rule
    static constexpr double kPlaces[kMaxDegree][kMaxDegree] = {
        {0.5, 0, 0, 0}, {0, 1, 0, 0}, {0, 0.5, 1, 0}, {0, kInner, 1 - kInner, 1}};
    const int count = order_ - 1;
    const double* const place = kPlaces[count - 1];
    const double width = to_m - from_m;
    LiveSlopes at[kMaxDegree];
    for (int i = 0; i < count; ++i) at[i] = slopes_at(from_m + place[i] * width, pieces);
    const LiveSlopes between[2] = {slopes_at(from_m + 0.12 * width, pieces),
                                   slopes_at(from_m + 0.62 * width, pieces)};
    bool is_good = true;
    for (int set = 0; set < kSets; ++set)
      for (int k = 0; k < order_; ++k) {
        double divided[kMaxDegree];  // Newton's form
        for (int i = 0; i < count; ++i) divided[i] = at[i].of[set][k];
        for (int step = 1; step < count; ++step)
          for (int i = count - 1; i >= step; --i)
            divided[i] = (divided[i] - divided[i - 1]) / (place[i] - place[i - step]);
        double* const out = c[set][k];
        for (int m = 0; m <= kMaxDegree; ++m) out[m] = 0;
        for (int i = count - 1; i >= 0; --i) {  // in powers of t / width
          for (int m = count - 1; m > 0; --m) out[m] = out[m - 1] - place[i] * out[m];
          out[0] = divided[i] - place[i] * out[0];
        }
        for (int b = 0; b < 2; ++b) {
          const double t = b == 0 ? 0.12 : 0.62;
          double value = 0;
          for (int m = count - 1; m >= 0; --m) value = value * t + out[m];
          const double off = std::fabs(value - between[b].of[set][k]);
          is_good = is_good && off <= kIndenterTolerance / own_.knots[own_.pieces];
        }
        double scale = 1;
        for (int m = 0; m < count; ++m, scale /= width) out[m] *= scale;
      }
    return is_good;
  }

  /// The next interval, of which the slopes are known.
  void put(const Pieces& pieces, double width,
           const double c[kSets][kMaxDegree + 1][kMaxDegree + 1]) noexcept {
    for (int i = 0; i < 2; ++i) first_[i][pieces_] = first_of(pieces.of[i]);
    for (int s = 0; s < kSets; ++s) {
      const int first = first_[s == kSameWidth][pieces_];
      Set& set = set_[s];
      double* const w = set.weights + pieces_ * order_ * order_;
      double *begins = set.begins + pieces_ * size_, *integrals = set.integrals + pieces_ * size_;
      for (int j = 0; j < size_; ++j) {
        begins[size_ + j] = begins[j];
        integrals[size_ + j] = integrals[j] + begins[j] * width;
      }
      for (int k = 0; k < order_; ++k) {
        w[k * order_] = 0;
        double power = 1, value = 0, area = 0;
        for (int m = 1; m < order_; ++m) {
          w[k * order_ + m] = c[s][k][m - 1] / m;
          power *= width;
          value += w[k * order_ + m] * power;
          area += w[k * order_ + m] * power * width / (m + 1);
        }
        begins[size_ + first + k] += value;
        integrals[size_ + first + k] += area;
      }
    }
    ++pieces_;
  }

  /// Beyond the last knot curves go on along their last slope.
  void extrapolate() noexcept {
    const int last = pieces_ - 1;
    const double t = knots_[pieces_] - knots_[last];
    for (std::int32_t* first : first_) first[pieces_] = first[last];
    for (Set& set : set_)
      for (int k = 0; k < order_; ++k) {
        const double* from = set.weights + (last * order_ + k) * order_;
        double* to = set.weights + (pieces_ * order_ + k) * order_;
        double slope = 0;
        for (int m = order_ - 1; m >= 1; --m) slope = slope * t + m * from[m];
        for (int m = 0; m < order_; ++m) to[m] = 0;
        to[1] = slope;
      }
  }

  const SplineView& own_;
  Indenter ball_, tool_;
  int size_, order_, max_pieces_, pieces_ = 0;
  double depth_m_, first_row_m_, widest_m_;
  double first_area_ = 0;  ///< int_0^d a ds of the own ball to the first row [m^2]
  IndenterView* view_ = nullptr;
  double *knots_ = nullptr, *own_depth_m_ = nullptr;
  Set set_[kSets] = {};
  std::int32_t* first_[2] = {};  ///< of the same depth, and of the same width
};

/// Finds the ploughing of a tool (M84): R_0 s tanh s of its steepness s, fitted by a line over the
/// depth that is as right where it is shallow as where it is deep, and begins at 0 at least.
inline void find_ploughing(const Indenter& tool, double ball_m, double depth_m,
                           IndenterView& view) noexcept {
  if (tool.points == 0) {
    view.plough_offset_m = 0;
    view.plough_slope = ball_m / tool.round_end_m;
    return;
  }
  constexpr int kDepths = 16;
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int i = 1; i <= kDepths; ++i) {
    const double x = depth_m * i / kDepths, steep = steepness_at(tool, x),
                 y = ball_m * steep * tanh_of(steep), weight = 1 / (x * x);
    n += weight;
    sx += weight * x;
    sy += weight * y;
    sxx += weight * x * x;
    sxy += weight * x * y;
  }
  view.plough_slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  view.plough_offset_m = (sy - view.plough_slope * sx) / n;
  if (view.plough_offset_m >= 0 && view.plough_slope >= 0) return;
  const bool is_even = view.plough_slope < 0;
  view.plough_offset_m = is_even ? sy / n : 0;
  view.plough_slope = is_even ? 0 : sxy / sxx;
}

/// Finds the side force g = g_2 d^2 + g_3 d^3 (M85): it is the change of Z from place to place,
/// and goes with Z from one indenter to another at the same a, as of an even half-space. The same
/// two powers of d are fitted to it.
inline void find_side(const Indenter& tool, double ball_m, double depth_m,
                      IndenterView& view) noexcept {
  constexpr int kSteps = 64, kFine = 16;
  const Indenter ball = ball_indenter(ball_m);
  double force = 0, energy = 0, own_force = 0, own_energy = 0, own_m = 0;
  double xx = 0, xy = 0, yy = 0, right[2][2] = {};
  for (int i = 1; i <= kSteps; ++i) {
    const double step = depth_m / kSteps, d = step * i;
    for (int k = 0; k < kFine; ++k) {
      force += contact_radius_at(tool, d - step + step * (k + 0.5) / kFine) * (step / kFine);
      energy += force * (step / kFine);
    }
    const double next_m = depth_at(ball, contact_radius_at(tool, d)), own_step = next_m - own_m;
    for (int k = 0; k < kFine; ++k) {
      own_force +=
          contact_radius_at(ball, own_m + own_step * (k + 0.5) / kFine) * (own_step / kFine);
      own_energy += own_force * (own_step / kFine);
    }
    own_m = next_m;
    const double ratio = energy / own_energy, x = d * d, y = x * d;
    const double own[2] = {ratio * own_m * own_m, ratio * own_m * own_m * own_m};
    xx += x * x;
    xy += x * y;
    yy += y * y;
    for (int j = 0; j < 2; ++j) {
      right[j][0] += own[j] * x;
      right[j][1] += own[j] * y;
    }
  }
  const double under = xx * yy - xy * xy;
  for (int j = 0; j < 2; ++j) {
    view.side[0][j] = (right[j][0] * yy - right[j][1] * xy) / under;
    view.side[1][j] = (right[j][1] * xx - right[j][0] * xy) / under;
  }
}

/// Number that identifies an indenter, for contacts.
inline std::uint64_t mark_of(const Indenter& tool) noexcept {
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&hash](double x) noexcept {
    std::uint64_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 29;
  };
  add(tool.round_end_m);
  for (int i = 0; i < tool.points; ++i) {
    add(tool.r_m[i]);
    add(tool.slope[i]);
  }
  return hash;
}

/// Returns true if curves that were measured with this asset's ball can be those of another
/// indenter.
inline bool knows_radius(const AssetView& asset) noexcept {
  return asset.probe_radius_m > 0 && asset.curves.indenter == nullptr;
}

/// The asset for a tool with this end: touch() it in place of the asset. memory
/// [indenter_bytes(asset)], 8-byte aligned, must outlive it. The tool is possible and the asset
/// knows_radius(). Some milliseconds; not for the real-time thread.
PALPATE_ONCE AssetView with_indenter(const AssetView& asset, const Indenter& tool,
                                     void* memory) noexcept
#if PALPATE_HAS_BODIES
{
  const IndenterTable table(asset, tool, memory);
  AssetView out = asset;
  const double known_m = table.measured_m();
  out.curves.view[kNormal] = table.normal();
  out.curves.rings = ring_table(out.curves.view[kNormal], known_m);
  IndenterView& view = table.view();
  view.has_radius_effect = asset.curves.family == int(Family::rings);
  for (int i = 0; i < kRadiusEffects; ++i) {
    view.by_radius[i] = table.by_radius(i);
    view.rings_by_radius[i] = ring_table(view.by_radius[i], known_m);
  }
  view.surface_offset_m = tool.round_end_m - asset.probe_radius_m;
  find_ploughing(tool, asset.probe_radius_m, known_m, view);
  find_side(tool, asset.probe_radius_m, known_m, view);
  out.curves.indenter = &view;
  out.max_fitted_m = known_m;
  out.probe_radius_m = tool.round_end_m;
  out.checksum ^= mark_of(tool);
  out.is_rough = asset.curves.family != int(Family::rings) || asset.damage.softens();
  return out;
}
#else
    ;
#endif

}  // namespace palpate::runtime
