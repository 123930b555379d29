// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The hole that a tool has made in a body, and what a tool in it stores and bears (docs/method.md,
// section 26). puncture.hpp says when one is made and entered.

#include <cmath>

#include "../asset/view.hpp"

namespace palpate {
namespace runtime {

/// A straight hole from the surface inward. In a body's memory: plain data.
struct Channel {
  double mouth_m[3];     ///< on the surface, relative to the asset's origin
  double axis[3];        ///< unit, inward
  double length_m;       ///< as far as it is cut
  double rim_m;          ///< depth from which on its wall holds whole
  double stiffness_N_m;  ///< along it; across it kWallShare of that
  float weight[3];       ///< of the mouth in its triangle
  std::int32_t triangle;
};
static_assert(sizeof(Channel) == 88, "a channel is packed");

constexpr int kMaxChannels = 64;

/// Of a body: the newest kMaxChannels holes, number n in slot (n - 1) % kMaxChannels.
struct ChannelList {
  std::int64_t made;  ///< so far: the number of the newest
  Channel channel[kMaxChannels];
};

/// A tool in a hole: what a contact remembers beside its place.
struct ChannelContact {
  std::int64_t number = 0;        ///< from 1; 0: in none
  double mouth_m[3] = {0, 0, 0};  ///< where the tool is when it stands in the mouth
  double stretch_m = 0;           ///< of the body along the shaft: it sticks to it
};

/// Of a rigid flat punch on an incompressible half-space: its stiffness across over that along.
/// Source: Johnson, Contact Mechanics (1985), 3.3 and 7.4: 2 (1 - nu) / (2 - nu).
constexpr double kWallShare = 2.0 / 3.0;

/// The channel of a number, or null where it is not, or no longer, in the list.
inline Channel* channel_of(ChannelList& list, std::int64_t number) noexcept {
  const bool is_there = number >= 1 && number <= list.made && number > list.made - kMaxChannels;
  return is_there ? &list.channel[(number - 1) % kMaxChannels] : nullptr;
}

/// Whether bytes are channels of a body. Safe on hostile bytes.
inline bool are_channels(const AssetView& asset, const ChannelList& list) noexcept {
  if (list.made < 0 || list.made > (std::int64_t{1} << 60)) return false;
  const std::int64_t count = list.made < kMaxChannels ? list.made : kMaxChannels;
  for (std::int64_t i = 0; i < count; ++i) {
    const Channel& c = list.channel[i];
    const Vec3d axis = make_vec3<double>(c.axis), mouth = make_vec3<double>(c.mouth_m);
    double sum = 0;
    for (const float w : c.weight) {
      if (!(w >= -1e-3F && w <= 1.001F)) return false;
      sum += double(w);
    }
    if (!(std::fabs(dot(axis, axis) - 1) <= 1e-6) || !(dot(mouth, mouth) <= 1e6) ||
        !(c.length_m >= 0 && c.length_m <= 1e3) || !(c.rim_m > 0 && c.rim_m <= 1e3) ||
        !(c.stiffness_N_m > 0 && c.stiffness_N_m <= 1e12) || !(std::fabs(sum - 1) <= 1e-3) ||
        c.triangle < 0 || c.triangle >= asset.triangles)
      return false;
  }
  return true;
}

/// Where a tool is in a channel: s along its axis and y across it.
struct InChannel {
  double depth_m;
  Vec3d aside_m;
};
inline InChannel in_channel(const Channel& channel, const ChannelContact& hole,
                            const Vec3d& x) noexcept {
  const Vec3d axis = make_vec3<double>(channel.axis), way = x - make_vec3<double>(hole.mouth_m);
  const double s = dot(way, axis);
  return {s, way - axis * s};
}

/// How much of the wall holds at a depth, and its slope (M66): from 0 at the mouth to 1 at the rim.
struct Rim {
  double share, slope;
};
inline Rim rim_at(const Channel& channel, double depth_m) noexcept {
  const double t = depth_m / channel.rim_m;
  if (!(t > 0)) return {0, 0};
  if (t >= 1) return {1, 0};
  return {t * (2 - t), 2 * (1 - t) / channel.rim_m};
}

/// What the tool presses the end of the channel in by.
inline double end_m(const Channel& channel, const InChannel& at) noexcept {
  return at.depth_m > channel.length_m ? at.depth_m - channel.length_m : 0;
}

/// What a tool in a channel stores [J] (M66).
inline double channel_energy(const Channel& channel, const InChannel& at,
                             double stretch_m) noexcept {
  const double end = end_m(channel, at);
  const double wall = kWallShare * rim_at(channel, at.depth_m).share;
  return 0.5 * channel.stiffness_N_m *
         (wall * dot(at.aside_m, at.aside_m) + stretch_m * stretch_m + end * end);
}

/// Its gradient: the force on the body.
inline Vec3d channel_force(const Channel& channel, const InChannel& at, double stretch_m) noexcept {
  const Rim rim = rim_at(channel, at.depth_m);
  const double along =
      0.5 * kWallShare * rim.slope * dot(at.aside_m, at.aside_m) + stretch_m + end_m(channel, at);
  return (make_vec3<double>(channel.axis) * along + at.aside_m * (kWallShare * rim.share)) *
         channel.stiffness_N_m;
}

/// What gives way (M66): the shaft slips where it is drawn by more than friction, and the tool cuts
/// where it presses the end by more than cutting takes. Both lower the energy. Whether one did.
inline bool give_way(const DamageView& damage, const InChannel& at, Channel& channel,
                     double& stretch_m) noexcept {
  const double most_m =
      at.depth_m > 0 ? damage.friction_N_m * at.depth_m / channel.stiffness_N_m : 0;
  const double held_m = stretch_m > most_m ? most_m : (stretch_m < -most_m ? -most_m : stretch_m);
  const bool slips = held_m != stretch_m;
  stretch_m = held_m;
  const double end_most_m = damage.cutting_N / channel.stiffness_N_m;
  if (!(end_m(channel, at) > end_most_m)) return slips;
  channel.length_m = at.depth_m - end_most_m;
  return true;
}

}  // namespace runtime
}  // namespace palpate
