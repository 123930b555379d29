#include "libfit/certify/search.hpp"

#include <algorithm>
#include <queue>
#include <vector>

namespace palpate::certify {
namespace {

using runtime::AssetView;

constexpr double kFirstRange = 0.02;     // of the depths: from 0 on
constexpr double kRangeRatio = 1.3;      // of the ends of the others
constexpr double kTight = 1.1;           // bound over what was found
constexpr double kLeastDepth = 1e-4;     // of the range: below it a range is not halved
constexpr int kMostHalvings = 13;        // of a patch
constexpr double kWitnessInside = 0.02;  // how far from the border a witness stands

Patch patch_of(const PatchPoint& a, const PatchPoint& b, const PatchPoint& c) {
  return {{a, b, c}};
}
PatchPoint between(const PatchPoint& a, const PatchPoint& b) {
  return {{0.5 * (a.n[0] + b.n[0]), 0.5 * (a.n[1] + b.n[1]), 0.5 * (a.n[2] + b.n[2])}};
}
PatchPoint middle_of(const Patch& patch) {
  PatchPoint out{{0, 0, 0}};
  for (const PatchPoint& corner : patch.corner)
    for (int k = 0; k < 3; ++k) out.n[k] += corner.n[k] / 3;
  return out;
}
const Patch kWhole = patch_of({{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}});

struct SearchBox {
  Patch patch;
  double from_m, to_m;
  int halvings;  // of the patch
  double ratio;
  bool operator<(const SearchBox& other) const { return ratio < other.ratio; }
};

Cause cause_of(const Balance& b) {
  if (!(b.friction > 0)) return Cause::friction;
  const double turning = std::max(b.turning, 0.0);
  const double most = std::max({b.tilt, b.mismatch, turning, b.rings, b.sway});
  if (b.paid == 0 && most == 0) return Cause::concave;
  return most == b.tilt       ? Cause::normals
         : most == b.mismatch ? Cause::stiffness
         : most == turning    ? Cause::curvature
         : most == b.rings    ? Cause::rings
                              : Cause::sway;
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

class Search {
 public:
  Search(const AssetView& asset, const Facet& facet, int t, const FacetOptions& options,
         OtherRings others)
      : asset_(asset),
        e_(facet),
        t_(t),
        max_m_(options.depth_share * range_of(asset, t)),
        options_(options),
        others_(others) {}

  Sliding run() {
    const std::vector<double> ends = ranges_of(asset_, max_m_);
    for (const PatchPoint& place : {PatchPoint{{1, 0, 0}}, PatchPoint{{0, 1, 0}},
                                    PatchPoint{{0, 0, 1}}, PatchPoint{{1.0 / 3, 1.0 / 3, 1.0 / 3}}})
      for (const double share : {1.0, 0.5, 0.2, 0.05}) look(place, share * max_m_);
    std::priority_queue<SearchBox> open;
    double from_m = 0;
    for (const double end_m : ends) {
      open.push(bounded({kWhole, from_m, end_m, 0, 0}));
      from_m = end_m;
    }
    int boxes = static_cast<int>(ends.size());
    double closed = 0;  // of boxes that cannot be halved
    while (!open.empty() &&
           boxes < (found_.ratio > 1 ? options_.of_failing : 1) * options_.max_boxes) {
      const SearchBox box = open.top();
      if (is_tight(std::max(box.ratio, closed))) break;
      open.pop();
      look(middle_of(box.patch), 0.5 * (box.from_m + box.to_m));
      const bool can_halve_depth = box.to_m > kLeastDepth * max_m_,
                 can_halve_patch = box.halvings < kMostHalvings;
      if (!can_halve_depth && !can_halve_patch) {
        closed = std::max(closed, box.ratio);
        continue;
      }
      const double range = 5 * (box.to_m - box.from_m) / box.to_m,
                   width = std::pow(0.7, box.halvings);  // about their weights in the bound
      const bool halves_depth = can_halve_depth && (!can_halve_patch || range > width);
      for (int half = 0; half < 2; ++half) {
        SearchBox next = box;
        if (halves_depth) {
          const double cut_m = 0.5 * (box.from_m + box.to_m);
          (half == 0 ? next.to_m : next.from_m) = cut_m;
        } else {
          const PatchPoint cut = between(box.patch.corner[0], box.patch.corner[1]);
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
      PatchPoint place = place_;
      for (double& n : place.n) n += kWitnessInside * (1.0 / 3 - n);
      for (const PatchPoint& at : {place, place_}) {
        out.witness = replay_slip(asset_, e_, t_, at, std::min(depth_m_, 0.999 * max_m_),
                                  found_.sector, others_);
        if (out.witness.created_J > 0) break;
      }
      if (out.witness.created_J > 0) out.verdict = Verdict::fails;
    }
    return out;
  }

 private:
  SearchBox bounded(SearchBox box) const {
    const auto depth = over_depths(asset_, e_, t_, box.from_m, box.to_m);
    box.ratio = balance(e_, box.patch, depth, others_).ratio;
    return box;
  }
  void look(const PatchPoint& place, double depth_m) {
    const Balance here = balance(e_, place, at_depth(asset_, e_, t_, depth_m), others_);
    if (has_looked_ && !(here.ratio > found_.ratio)) return;
    has_looked_ = true;
    found_ = here;
    place_ = place;
    depth_m_ = depth_m;
  }
  bool is_tight(double ratio) const {
    if (ratio > 1 && found_.ratio <= 1) return false;  // it says nothing yet
    return ratio <= std::max(std::min(options_.far, 1.0), kTight * found_.ratio);
  }
  const AssetView& asset_;
  const Facet& e_;
  int t_;
  double max_m_;
  const FacetOptions& options_;
  OtherRings others_;
  Balance found_;
  bool has_looked_ = false;
  PatchPoint place_{};
  double depth_m_ = 0;
};

bool pushes_over(const AssetView& asset, const Facet& e, int t, const Patch& patch, double from_m,
                 double to_m, int halvings) {
  if (pushes(e, patch, over_depths(asset, e, t, from_m, to_m))) return true;
  if (halvings == 0) return false;
  const PatchPoint cut = between(patch.corner[0], patch.corner[1]);
  const double cut_m = 0.5 * (from_m + to_m);
  const Patch half[2] = {patch_of(patch.corner[2], patch.corner[0], cut),
                         patch_of(patch.corner[1], patch.corner[2], cut)};
  if (halvings % 2 == 1)
    return pushes_over(asset, e, t, half[0], from_m, to_m, halvings - 1) &&
           pushes_over(asset, e, t, half[1], from_m, to_m, halvings - 1);
  return pushes_over(asset, e, t, patch, from_m, cut_m, halvings - 1) &&
         pushes_over(asset, e, t, patch, cut_m, to_m, halvings - 1);
}

}  // namespace

bool pushes_on(const AssetView& asset, int t, const FacetOptions& options) {
  const Facet e = facet_of(asset, t, options);
  // Towards a corner without curves all sides of (M22) fade alike: the others say it.
  PatchPoint corner[3];
  int known = 0;
  for (int k = 0; k < 3; ++k)
    if (asset.covered[asset.corner(t, k)]) corner[known++] = kWhole.corner[k];
  if (known == 0) return true;
  for (int k = known; k < 3; ++k) corner[k] = corner[0];
  double from_m = 0;
  for (const double end_m : ranges_of(asset, range_of(asset, t))) {
    if (!pushes_over(asset, e, t, patch_of(corner[0], corner[1], corner[2]), from_m, end_m, 6))
      return false;
    from_m = end_m;
  }
  return true;
}

Sliding certify_sliding(const AssetView& asset, int t, OtherRings others,
                        const FacetOptions& options) {
  const Facet e = facet_of(asset, t, options);
  return Search(asset, e, t, options, others).run();
}

}  // namespace palpate::certify
