// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// When a tool breaks into a body, and the ticks that it spends in the hole (docs/method.md,
// section 26).

#include "../answer.hpp"

#if defined(__GNUC__)
#define PALPATE_OUT_OF_LINE __attribute__((noinline))
#elif defined(_MSC_VER)
#define PALPATE_OUT_OF_LINE __declspec(noinline)
#else
#define PALPATE_OUT_OF_LINE
#endif

namespace palpate {
namespace runtime {

/// Where a tool would be in a channel's mouth: the foremost point of its ball stands there.
inline Vec3d place_in_mouth(const Channel& channel, double radius_m) noexcept {
  return make_vec3<double>(channel.mouth_m) - make_vec3<double>(channel.axis) * radius_m;
}

/// The channel that a tool at x, before at `before`, comes into: within the mouth's radius of its
/// axis and not deeper than it is cut; through the mouth where the tool touches nothing. The number
/// of the newest such; 0: none.
inline std::int64_t channel_at(const AssetView& asset, bool is_touching, double radius_m,
                               const Vec3d& before, const Vec3d& x) noexcept {
  if (asset.channels == nullptr) return 0;
  ChannelList& list = *asset.channels;
  for (std::int64_t n = list.made; n > 0 && n > list.made - kMaxChannels; --n) {
    const Channel& channel = *channel_of(list, n);
    const Vec3d axis = make_vec3<double>(channel.axis), mouth = place_in_mouth(channel, radius_m);
    const double s = dot(x - mouth, axis);
    if (!(s > 0 && s <= channel.length_m)) continue;
    if (!is_touching && dot(before - mouth, axis) > 0) continue;
    const Vec3d aside = x - mouth - axis * s;
    if (dot(aside, aside) <= asset.damage.mouth_m * asset.damage.mouth_m) return n;
  }
  return 0;
}

/// What a tick in a channel says.
inline void describe(const AssetView& asset, const Contact& contact, const Channel& channel,
                     const Vec3d& x, double radius_m, Output& out, double* tangent_N_m) noexcept {
  const InChannel at = in_channel(channel, contact.hole, x);
  const Vec3d origin = make_vec3<double>(asset.origin_m), axis = make_vec3<double>(channel.axis);
  const Vec3d reach = axis * radius_m;
  put(make_vec3<double>(contact.hole.mouth_m) + reach + origin, out.contact_m);
  put(x + reach + origin, out.acts_at_m);
  put(axis, out.normal);
  out.triangle = contact.triangle;
  for (int k = 0; k < 3; ++k) out.weight[k] = contact.weight[k];
  out.normal_m = at.depth_m;
  out.lateral_m = std::sqrt(dot(at.aside_m, at.aside_m));
  out.stored_J = channel_energy(channel, at, contact.hole.stretch_m);
  put(channel_force(channel, at, contact.hole.stretch_m) * -1.0, out.force_on_tool_N);
  out.flags |= kFlagChannel;
  if (tangent_N_m == nullptr) return;
  const Rim rim = rim_at(channel, at.depth_m);
  const double k = channel.stiffness_N_m, most_N = asset.damage.friction_N_m * at.depth_m,
               bent = at.depth_m < channel.rim_m ? -2 / (channel.rim_m * channel.rim_m) : 0;
  const bool slips = std::fabs(contact.hole.stretch_m) * k >= most_N * (1 - 1e-12);
  const bool cuts = end_m(channel, at) * k >= asset.damage.cutting_N * (1 - 1e-12);
  const double along =
      (slips ? (contact.hole.stretch_m > 0 ? 1 : -1) * asset.damage.friction_N_m : k) +
      (end_m(channel, at) > 0 && !cuts ? k : 0) +
      0.5 * kWallShare * k * bent * dot(at.aside_m, at.aside_m);
  const double a[3] = {axis.x, axis.y, axis.z}, y[3] = {at.aside_m.x, at.aside_m.y, at.aside_m.z};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      tangent_N_m[3 * i + j] =
          along * a[i] * a[j] + kWallShare * k *
                                    (rim.share * ((i == j ? 1 : 0) - a[i] * a[j]) +
                                     rim.slope * (a[i] * y[j] + y[i] * a[j]));
}

/// The contact is in a channel from here on, with nothing of what it was: the law's energy is gone.
inline void enter(Contact& contact, std::int64_t number, const Vec3d& mouth,
                  double stored_J) noexcept {
  const int triangle = contact.triangle;
  const double weight[3] = {contact.weight[0], contact.weight[1], contact.weight[2]};
  release(contact);
  contact.ledger.dissipated_J += stored_J;
  contact.triangle = triangle;
  for (int k = 0; k < 3; ++k) contact.weight[k] = weight[k];
  contact.has_lifted = false;
  contact.damage_share = 1, contact.damage_slope = 0;
  contact.hole.number = number;
  put(mouth, contact.hole.mouth_m);
}

/// A tool that came into a channel of the body: nothing is stored, whatever was.
inline void fall_in(const AssetView& asset, Contact& contact, std::int64_t number, double radius_m,
                    const Vec3d& x, Output& out, double* tangent_N_m) noexcept {
  const Channel& channel = *channel_of(*asset.channels, number);
  const Vec3d axis = make_vec3<double>(channel.axis);
  const double s = dot(x - place_in_mouth(channel, radius_m), axis), stored_J = out.stored_J;
  contact.triangle = channel.triangle;
  for (int k = 0; k < 3; ++k) contact.weight[k] = double(channel.weight[k]);
  enter(contact, number, x - axis * s, stored_J);  // the axis is where the tool came in
  out = Output();
  out.state = ContactState::slip;
  describe(asset, contact, channel, x, radius_m, out, tangent_N_m);
}

/// A contact whose force along the normal has come to what the body bears breaks into it (M65), or
/// falls into a channel that it came to.
inline void break_in(const AssetView& asset, Contact& contact, double radius_m, const Vec3d& before,
                     const Vec3d& x, Output& out, double* tangent_N_m) noexcept {
  const Vec3d origin = make_vec3<double>(asset.origin_m),
              force = make_vec3<double>(out.force_on_tool_N),
              surface = make_vec3<double>(out.contact_m) - origin;
  const Vec3d way = make_vec3<double>(out.acts_at_m) - origin - surface;
  if (const std::int64_t number = channel_at(asset, true, radius_m, before, x))
    return fall_in(asset, contact, number, radius_m, x, out, tangent_N_m);
  if (!(-dot(force, make_vec3<double>(out.normal)) >= asset.damage.puncture_N)) return;
  const double depth_m = std::sqrt(dot(way, way)), stored_J = out.stored_J;
  if (!(depth_m > 0) || !(dot(way, make_vec3<double>(out.normal)) > 0)) return;
  ChannelList& list = *asset.channels;
  ++list.made;
  Channel& channel = *channel_of(list, list.made);
  channel = Channel();
  const double k = std::sqrt(dot(force, force)) / depth_m;
  put(surface, channel.mouth_m);
  put(way * (1 / depth_m), channel.axis);
  channel.rim_m = depth_m;
  channel.stiffness_N_m = k;
  for (int i = 0; i < 3; ++i) channel.weight[i] = static_cast<float>(contact.weight[i]);
  channel.triangle = contact.triangle;
  // The shaft is drawn in and the end is cut, as far as what is stored pays for that.
  double stretch_m = asset.damage.friction_N_m * depth_m / k, end_m = asset.damage.cutting_N / k;
  const double wanted_J = 0.5 * k * (stretch_m * stretch_m + end_m * end_m);
  if (wanted_J > stored_J) {
    const double share = std::sqrt((stored_J > 0 ? stored_J : 0) / wanted_J);
    stretch_m *= share, end_m *= share;
  }
  channel.length_m = depth_m - end_m;
  enter(contact, list.made, x - way, stored_J);
  contact.hole.stretch_m = stretch_m;
  const unsigned flags = out.flags & kFlagOutside;
  out = Output();
  out.state = ContactState::slip;
  out.flags = flags | kFlagPunctured;
  describe(asset, contact, channel, x, radius_m, out, tangent_N_m);
  contact.ledger.dissipated_J -= out.stored_J;
}

/// A tick of a tool in a channel (M66). It ends in the air where the tool has left the mouth, or
/// the channel is no more.
inline void tick_in_channel(const AssetView& asset, Contact& contact, double radius_m, bool is_ball,
                            const Vec3d& before, const Vec3d& x, Output& out,
                            double* tangent_N_m) noexcept {
  Channel* channel =
      asset.channels != nullptr ? channel_of(*asset.channels, contact.hole.number) : nullptr;
  if (channel == nullptr) return release(contact);
  const InChannel was = in_channel(*channel, contact.hole, before),
                  now = in_channel(*channel, contact.hole, x);
  const double was_J = channel_energy(*channel, was, contact.hole.stretch_m);
  if (!(now.depth_m > 0)) {  // friction and wall have come to nothing there
    release(contact, was_J);
    contact.has_lifted = is_ball;
    return;
  }
  double stretch_m = contact.hole.stretch_m + (now.depth_m - was.depth_m);
  const double held_J = channel_energy(*channel, now, stretch_m);
  const bool has_given = give_way(asset.damage, now, *channel, stretch_m);
  contact.hole.stretch_m = stretch_m;
  out.state = has_given ? ContactState::slip : ContactState::stick;
  describe(asset, contact, *channel, x, radius_m, out, tangent_N_m);
  contact.ledger.dissipated_J += held_J - out.stored_J;
}

}  // namespace runtime
}  // namespace palpate
