#pragma once

#include <vector>

#include "libfit/certify/certificate.hpp"
#include "libfit/certify/repair_kinds.hpp"

namespace palpate::certify {

/// What of an asset's interior is not certified, of triangles and of their area, (M25).
struct Uncertified {
  int any = 0, gross = 0, pulling = 0;  ///< triangles
  int witnesses = 0;                    ///< of `any` those that create energy in a replayed slip
  double any_area = 0, gross_area = 0, pulling_area = 0;  ///< shares of the interior
  double sum() const { return any_area + gross_area + pulling_area; }
};

/// How far forces are from those of the asset before, over its admissible range (M28): at seeded
/// places and depths of the interior, half of them straight presses, half deflected up to slip.
struct ForceChange {
  double p95_N = 0, max_N = 0, p95 = 0, max = 0;  ///< p95, max: relative, (M11a)
};
ForceChange force_change(const runtime::AssetView& before, const runtime::AssetView& after,
                         double radius_m);

/// A kind of repair as it was tried.
struct RepairStep {
  const RepairKind* kind = nullptr;
  bool is_kept = false;
  int vertices = 0;    ///< changed
  Uncertified after;   ///< of before: that of the last step that was kept
  ForceChange change;  ///< against the asset before this step
};

struct Repair {
  AssetEdit asset;
  Uncertified before, after;
  std::vector<RepairStep> steps;
  ForceChange change;  ///< of all of them
};

struct RepairOptions {
  FacetOptions facet;  ///< radius_m of the probe
  std::span<const RepairKind> kinds = kRepairKinds;
  int threads = 1;
};

/// Repairs an asset of rings, kind by kind, until none takes away uncertified
/// area (docs/method.md, section 19). An asset that needs no repair comes back as it is. The same
/// for every number of threads.
Repair repair(const runtime::AssetView& asset, const RepairOptions& options,
              const Progress& progress = {});

}  // namespace palpate::certify
