#pragma once

#include "libfit/assets/asset_edit.hpp"
#include "libfit/certify/devices.hpp"

namespace palpate::certify {

/// The stiffest spring [N/m] that a device shows with none of its simulated hands swinging, and no
/// stiffer than its maker lets it; infinite where neither mass nor stiffness is stated. force_N:
/// the largest of the body. To 1 %.
double stiffness_shown_N_m(const Device& device, double force_N);

/// The asset with normal curves nowhere steeper than stiffness_N_m (M29c). Rings follow their
/// curve.
AssetEdit capped(const runtime::AssetView& asset, double stiffness_N_m);

}  // namespace palpate::certify
