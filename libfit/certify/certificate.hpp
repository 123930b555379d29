#pragma once

#include <string>
#include <vector>

#include "libfit/certify/continuity.hpp"
#include "libfit/certify/search.hpp"
#include "libfit/core/progress.hpp"

namespace palpate::certify {

/// Where a triangle lies. A skirt has measured corners and others, where it fades to nothing or to
/// the body's mean curves (M12e); `mean` has no measured one.
enum class Zone : char { air, skirt, interior, mean };

Zone zone_of(const runtime::AssetView& asset, int t);
double area_of(const runtime::AssetView& asset, int t);  ///< [m^2]

/// What one tool finds on a body of rings.
struct ToolCertificate {
  double radius_m = 0;              ///< 0: a tip
  std::vector<Sliding> any, gross;  ///< by triangle, with OtherRings; of the interior alone
  Continuity continuity;
};

/// Figures of a kind of sliding over the interior of all tools.
struct SlidingFigures {
  int certified = 0, failed = 0, undecided = 0;  ///< triangles; of several tools the worst counts
  double certified_area = 0;                     ///< share of the interior
  /// Least friction factor that certifies, and the friction that it is there; infinite where no
  /// friction is enough. Above 1 to first order (docs/method-certificate.md, section 19).
  double factor_required = 0, mu_required = 0;
  double depth_share = 1;   ///< of their depths to which all triangles are certified, in tenths
  double factor_found = 0;  ///< largest at a place, infinite ones left out: how tight the bound is
  double cause_share[std::size(kCauseNames)] = {};  ///< of the triangles that are not certified
  std::vector<Witness> witnesses;                   ///< the worst, at most kWitnesses
  bool is_passive() const { return failed == 0 && undecided == 0; }
};
constexpr std::size_t kWitnesses = 10;

/// The certificate of an asset (docs/method-certificate.md, section 19).
struct Certificate {
  std::string family;
  bool sways = false;     ///< as a whole (method-body.md, section 21)
  bool relaxes = false;   ///< in time (section 24): what is certified is slow motion
  bool softens = false;   ///< where it was pressed (section 26): certified is what nothing has
  bool couples = false;   ///< contacts move each other (section 28): certified is one by itself
  bool is_rings = false;  ///< sliding is certified for no other family
  bool passive_fixed = false;
  int pulling = 0;                                 ///< triangles where (M22) does not hold
  double least_slope_N_m = 0, least_friction = 0;  ///< over covered vertices and all depths
  std::vector<Zone> zone;
  int interior = 0, skirt = 0, mean = 0;
  double skirt_area = 0, mean_area = 0;  ///< shares of what can be touched
  std::vector<ToolCertificate> tools;
  SlidingFigures any, gross;
  Continuity continuity;  ///< largest of the tools'
  double max_depth_m = 0;
  double seen_step_m = 0;  ///< of the tool that the law sees, in a tick, that is certified

  bool passive_sliding() const { return is_rings && interior > 0 && any.is_passive(); }
  bool certified() const { return passive_fixed && passive_sliding(); }
};

struct CertifyOptions {
  FacetOptions facet;  ///< radius_m is taken from radii_m
  std::vector<double> radii_m = {0};
  ContinuityOptions continuity;
  int threads = 1;
};

/// Certifies an opened asset. The same for every number of threads.
Certificate certify(const runtime::AssetView& asset, const CertifyOptions& options,
                    const Progress& progress = {});

/// What it says to a person: a paragraph.
std::string in_words(const Certificate& certificate);

}  // namespace palpate::certify
