#include "libfit/certify/witness.hpp"

namespace palpate::certify {
namespace {

using runtime::AssetView;
using runtime::Vec3d;

constexpr double kWithin =
    0.98;  // of their limits: at it, what a ring gains by turning it loses again
constexpr double kBeyond_m[] = {2e-5, 5e-6, 1e-6};  // how far ring 1 is beyond its limit, by turns

Vec3d blended(const AssetView& asset, int t, const PatchPoint& place, const float* of) {
  Vec3d out{0, 0, 0};
  for (int l = 0; l < 3; ++l) {
    const float* v = of + 3 * asset.corner(t, l);
    out = out + Vec3d{double(v[0]), double(v[1]), double(v[2])} * place.n[l];
  }
  return out;
}

}  // namespace

StagedContact stage(const AssetView& asset, int t, double radius_m, const SlipState& state) {
  const Vec3d u = normalized(blended(asset, t, state.place, asset.normal)),
              c = blended(asset, t, state.place, asset.vertex), q = state.ring[0];
  double kappa[6] = {}, gamma = 0;
  for (int l = 0; l < 3; ++l) {
    runtime::Corner node;
    runtime::read_corner(asset, asset.corner(t, l), node);
    for (int i = 0; i < 6; ++i)
      kappa[i] += state.place.n[l] * node.row[runtime::kNumbersAt + 3 + i];
    gamma += state.place.n[l] * node.row[runtime::kSpreadAt];
  }
  const double height = state.depth_m + 0.5 * dot(q, runtime::curvature_times(kappa, q));
  const Vec3d x = c + u * (height - radius_m) + q;
  StagedContact out;
  out.contact.has_tip = true;
  out.contact.asset_checksum = asset.checksum;
  runtime::put(x, out.contact.tip_m);
  out.contact.triangle = t;
  for (int k = 0; k < 3; ++k) out.contact.weight[k] = state.place.n[k];
  out.contact.arm.reach_m = radius_m;
  runtime::Rings::Memory<double> anchors{};
  for (int i = 1; i < kRings; ++i) {
    anchors.set(i, q - state.ring[i]);
    const double d_i = asset.curves.rings.threshold_m[i];
    if (state.depth_m > d_i) anchors.out[i] = gamma * (state.depth_m * state.depth_m - d_i * d_i);
  }
  runtime::Rings::save(anchors, out.contact.memory);
  Vec3d tool = x;
  if (asset.sways) {
    const Vec3d force = runtime::with_law(asset, radius_m, [&](auto f, auto is_ball) {
      runtime::Depth depth;
      return runtime::hold<decltype(f), is_ball>(asset, out.contact, out.contact.cache, x, depth)
          .force_N;
    });
    const Vec3d aside = runtime::compliance_at(asset, t, out.contact.weight).times(force);
    runtime::put(force, out.contact.series.force_N);
    runtime::put(aside, out.contact.series.aside_m);
    tool = x + aside;
    runtime::put(tool, out.contact.tip_m);
  }
  runtime::put(tool + runtime::make_vec3<double>(asset.origin_m), out.tip_m);
  return out;
}

Witness replay_slip(const AssetView& asset, const Facet& e, int t, const PatchPoint& place,
                    double depth_m, int sector, OtherRings others) {
  const Vec3d field = blended(asset, t, place, asset.normal), u = normalized(field);
  const Directions& way = directions(false);
  const double toward[2] = {way.x[1][sector], way.y[1][sector]};
  Vec3d turned{0, 0, 0};
  for (int k = 0; k < 3; ++k)
    turned = turned + e.axis[k] * (e.turn[k][0] * toward[0] + e.turn[k][1] * toward[1]);
  turned = tangential(turned, u) * (1 / std::sqrt(dot(field, field)));
  const double turn_size = std::sqrt(dot(turned, turned));
  const Vec3d over_facet = e.axis[0] * toward[0] + e.axis[1] * toward[1];
  const Vec3d along = normalized(tangential(over_facet, u) - turned * e.radius_m);
  const double lambda = place.blend(e.lambda),
               mu = (place.blend(e.friction) + place.blend(e.friction_slope) * depth_m) *
                    limit_share(place, at_depth(asset, e, t, depth_m));
  Witness out;
  out.triangle = t;
  out.depth_m = depth_m;
  out.deflection_m = mu * depth_m / lambda;
  for (int k = 0; k < 3; ++k) out.weight[k] = place.n[k];
  runtime::put(along, out.direction);
  AssetView bare = asset;
  bare.has_guard = false;
  bare.curves.relaxation = {};  // slow motion
  for (const double beyond_m : kBeyond_m) {
    SlipState state{place, depth_m, {along * (out.deflection_m + beyond_m)}};
    for (int i = 1; i < kRings; ++i) {
      const double reach = depth_m - e.threshold[i], limit_m = reach > 0 ? mu * reach / lambda : 0;
      state.ring[i] = others == OtherRings::sliding ? along * (limit_m + beyond_m)
                      : turn_size > 0               ? turned * (-kWithin * limit_m / turn_size)
                                                    : Vec3d{0, 0, 0};
    }
    StagedContact staged = stage(bare, t, e.radius_m, state);
    runtime::Output tick;
    runtime::touch_ball(bare, staged.contact, staged.tip_m, e.radius_m, tick);
    if (-tick.dissipated_J > out.created_J) {
      out.created_J = -tick.dissipated_J;
      out.stored_J = tick.stored_J - out.created_J;
    }
  }
  return out;
}

}  // namespace palpate::certify
