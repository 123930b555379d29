#include "libfit/certify/repair.hpp"

#include <algorithm>
#include <random>

#include "libfit/certify/for_all.hpp"
#include "libfit/certify/witness.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate::certify {
namespace {

using runtime::AssetView;

constexpr int kRounds = 4;         // of all kinds
constexpr int kTurns = 6;          // of a kind in a round
constexpr double kFar = 10;        // shares of friction above it are alike
constexpr int kForces = 4000;      // that are compared
constexpr double kFloor_N = 0.04;  // of a force that a change is related to (M11a)

bool is_open(const Sliding& sliding) { return sliding.verdict != Verdict::certified; }

/// What is known of a triangle.
struct TriangleState {
  Sliding any, gross;
  bool pulls = false;

  bool is_open() const { return certify::is_open(any) || certify::is_open(gross) || pulls; }
  /// How many of the three are open, and how far, so that a turn may come closer.
  double cost() const {
    double sum = pulls;
    for (const Sliding* sliding : {&any, &gross})
      if (certify::is_open(*sliding)) sum += 1 + std::min(sliding->ratio, kFar) / kFar;
    return sum;
  }
};

class Repairer {
 public:
  Repairer(const AssetView& asset, const RepairOptions& options, const Progress& progress)
      : original_(asset),
        options_(options),
        progress_(progress),
        fans_(asset),
        out_{AssetEdit(asset), {}, {}, {}, {}},
        state_(static_cast<std::size_t>(asset.triangles)) {
    for (int t = 0; t < asset.triangles; ++t)
      if (zone_of(asset, t) == Zone::interior) interior_.push_back(t);
  }

  Repair run() {
    certify_these(out_.asset.asset(), interior_, state_);
    out_.before = out_.after = count(state_);
    bool helps = true;
    for (int round = 0; round < kRounds && helps && !progress_.stopped(); ++round) {
      helps = false;
      for (const RepairKind& kind : options_.kinds)
        if (out_.after.sum() > 0) helps = apply(kind) || helps;
    }
    out_.change = force_change(original_, out_.asset.asset(), options_.facet.radius_m);
    return std::move(out_);
  }

 private:
  using States = std::vector<TriangleState>;
  TriangleState& at(States& states, int t) const { return states[static_cast<std::size_t>(t)]; }

  void certify_these(const AssetView& asset, const std::vector<int>& these, States& states) const {
    for_all(static_cast<int>(these.size()), options_.threads, progress_, [&](int i) {
      const int t = these[static_cast<std::size_t>(i)];
      TriangleState& state = at(states, t);
      state.any = certify_sliding(asset, t, OtherRings::any, options_.facet);
      state.gross = certify_sliding(asset, t, OtherRings::sliding, options_.facet);
      state.pulls = !pushes_on(asset, t, options_.facet);
    });
  }
  // (M25)
  Uncertified count(const States& states) const {
    Uncertified out;
    double area = 0;
    for (const int t : interior_) {
      const TriangleState& state = states[static_cast<std::size_t>(t)];
      const double here = area_of(original_, t);
      area += here;
      out.any += is_open(state.any);
      out.gross += is_open(state.gross);
      out.pulling += state.pulls;
      out.witnesses += state.any.verdict == Verdict::fails;
      out.any_area += is_open(state.any) * here;
      out.gross_area += is_open(state.gross) * here;
      out.pulling_area += state.pulls * here;
    }
    for (double* share : {&out.any_area, &out.gross_area, &out.pulling_area})
      *share /= area > 0 ? area : 1;
    return out;
  }
  std::vector<OpenVertex> open_vertices(const AssetView& asset, const States& states) const {
    std::vector<double> ratio(static_cast<std::size_t>(asset.vertices), -1);
    for (const int t : interior_) {
      const TriangleState& state = states[static_cast<std::size_t>(t)];
      if (!state.is_open()) continue;
      for (int k = 0; k < 3; ++k) {
        double& of = ratio[static_cast<std::size_t>(asset.corner(t, k))];
        of = std::max({of, is_open(state.any) ? state.any.ratio : 0,
                       is_open(state.gross) ? state.gross.ratio : 0});
      }
    }
    std::vector<OpenVertex> out;
    for (std::size_t v = 0; v < ratio.size(); ++v)
      if (ratio[v] >= 0) out.push_back({static_cast<int>(v), ratio[v]});
    return out;
  }
  std::vector<int> about(const std::vector<int>& vertices) const {
    std::vector<int> out;
    for (const int v : vertices)
      for (const int t : fans_.about(v)) out.push_back(t);
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }
  double cost_about(int vertex, const States& states) const {
    double sum = 0;
    for (const int t : fans_.about(vertex))
      sum += states[static_cast<std::size_t>(t)].cost() * area_of(original_, t);
    return sum;
  }

  // One turn from `edit`: vertices that a kind does not help keep what they have. Whether any is
  // helped.
  bool turn(const RepairKind& kind, AssetEdit& edit, States& states) const {
    RepairPlan plan{fans_, original_, open_vertices(edit.asset(), states), options_.facet};
    while (!plan.open.empty() && !progress_.stopped()) {
      AssetEdit next(edit.asset());
      kind.apply(next, plan);
      next.seal();
      std::vector<int> vertices;
      for (const OpenVertex& open : plan.open) vertices.push_back(open.vertex);
      States after = states;
      certify_these(next.asset(), about(vertices), after);
      std::vector<OpenVertex> helped;
      for (const OpenVertex& open : plan.open)
        if (cost_about(open.vertex, after) < cost_about(open.vertex, states))
          helped.push_back(open);
      if (helped.size() == plan.open.size()) {
        edit = std::move(next);
        states = std::move(after);
        return true;
      }
      plan.open = std::move(helped);
    }
    return false;
  }

  bool apply(const RepairKind& kind) {
    AssetEdit edit(out_.asset.asset());
    States states = state_;
    for (int i = 0; i < kTurns; ++i)
      if (!turn(kind, edit, states)) break;
    RepairStep step;
    step.kind = &kind;
    for (int v = 0; v < original_.vertices; ++v)
      step.vertices += differs(edit.asset(), out_.asset.asset(), v);
    if (step.vertices == 0) return false;
    step.after = count(states);
    step.is_kept = step.after.sum() < out_.after.sum();
    step.change = force_change(out_.asset.asset(), edit.asset(), options_.facet.radius_m);
    out_.steps.push_back(step);
    if (!step.is_kept) return false;
    out_.asset = std::move(edit);
    out_.after = step.after;
    state_ = std::move(states);
    return true;
  }
  static bool differs(const AssetView& a, const AssetView& b, int v) {
    return !std::equal(a.node(v), a.node(v) + a.controls_per_vertex, b.node(v)) ||
           !std::equal(a.normal + 3 * v, a.normal + 3 * v + 3, b.normal + 3 * v);
  }

  const AssetView& original_;
  const RepairOptions& options_;
  const Progress& progress_;
  Fans fans_;
  Repair out_;
  States state_;
  std::vector<int> interior_;
};

}  // namespace

ForceChange force_change(const AssetView& before, const AssetView& after, double radius_m) {
  std::vector<int> interior;
  for (int t = 0; t < before.triangles; ++t)
    if (zone_of(before, t) == Zone::interior) interior.push_back(t);
  if (interior.empty()) return {};
  std::mt19937_64 random(1);
  const auto unit = [&] { return double(random() >> 11) * 0x1p-53; };  // the same everywhere
  std::vector<double> newtons, shares;
  FacetOptions options;
  options.radius_m = radius_m;
  for (int i = 0; i < kForces; ++i) {
    const int t = interior[static_cast<std::size_t>(unit() * double(interior.size()))];
    double p = unit(), q = unit();
    if (p + q > 1) p = 1 - p, q = 1 - q;
    SlipState state{{{1 - p - q, p, q}}, range_of(before, t) * unit(), {}};
    const Facet e = facet_of(before, t, options);
    const runtime::Vec3d u = runtime::blended_normal(before, t, state.place.n),
                         side = normalized(cross(u, e.axis[0])), across = cross(u, side);
    const double mu =
        state.place.blend(e.friction) + state.place.blend(e.friction_slope) * state.depth_m;
    const double angle = 6.283185307179586 * unit(),
                 limit_m = std::max(mu, 0.0) * state.depth_m / state.place.blend(e.lambda),
                 length_m = i % 2 == 0 ? 0 : 1.2 * limit_m * unit();
    for (runtime::Vec3d& ring : state.ring)
      ring = side * (length_m * std::cos(angle)) + across * (length_m * std::sin(angle));
    StagedContact staged = stage(before, t, radius_m, state);
    runtime::Contact contact = staged.contact;
    contact.asset_checksum = after.checksum;
    runtime::Output was, is;
    touch_ball(before, staged.contact, staged.tip_m, radius_m, was);
    touch_ball(after, contact, staged.tip_m, radius_m, is);
    const runtime::Vec3d f = runtime::make_vec3<double>(was.force_on_tool_N),
                         more = runtime::make_vec3<double>(is.force_on_tool_N) - f;
    newtons.push_back(std::sqrt(dot(more, more)));
    shares.push_back(newtons.back() / std::max(std::sqrt(dot(f, f)), kFloor_N));
  }
  return {lower_quantile(newtons, 0.95), lower_quantile(newtons, 1), lower_quantile(shares, 0.95),
          lower_quantile(shares, 1)};
}

Repair repair(const AssetView& asset, const RepairOptions& options, const Progress& progress) {
  return Repairer(asset, options, progress).run();
}

}  // namespace palpate::certify
