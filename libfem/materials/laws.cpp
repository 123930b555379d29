#include "libfem/materials/fung.hpp"
#include "libfem/materials/holzapfel_gasser_ogden.hpp"
#include "libfem/materials/materials.hpp"
#include "libfem/materials/mooney_rivlin.hpp"
#include "libfem/materials/neo_hookean.hpp"
#include "libfem/materials/neo_hookean_isochoric.hpp"
#include "libfem/materials/ogden.hpp"
#include "libfem/materials/veronda_westmann.hpp"
#include "libfem/materials/yeoh.hpp"

namespace palpate::fem {
namespace {

template <class Law>
LawPoint evaluate_at(const LawConstants& constants, const Mat3& F) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> H = F - Mat3::Identity();
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> P;
  Mat9 A;
  double J, W;
  Law::template evaluate<double>(constants.data(), H.data(), 1.0, J, W, P.data(), A.data());
  return {W, P, A.selfadjointView<Eigen::Upper>()};
}

template <class Law>
void volumetric_at(const LawConstants& constants, double dilation, double& U, double& U1,
                   double& U2) {
  Law::template volumetric<double>(constants.data(), dilation, U, U1, U2);
}

template <class Law>
constexpr LawRow law_row() {
  static_assert(Law::kConstants <= kMaxConstants);
  return {.name = Law::kName,
          .summary = Law::kSummary,
          .parameters = Law::kParameters,
          .constants_used = Law::kConstants,
          .refusal = Law::refusal,
          .constants = Law::constants,
          .small_strain = Law::small_strain,
          .evaluate = evaluate_at<Law>,
          .volumetric = volumetric_at<Law>,
          .kernels = &kElementKernels<Law>};
}

// The kernels of all laws are compiled here, which takes half a minute.
constexpr LawRow kLaws[] = {
    law_row<NeoHookean>(),      law_row<NeoHookeanIsochoric>(),
    law_row<MooneyRivlin>(),    law_row<Yeoh>(),
    law_row<Ogden>(),           law_row<Fung>(),
    law_row<VerondaWestmann>(), law_row<HolzapfelGasserOgden>(),
};

}  // namespace

std::span<const LawRow> material_laws() { return kLaws; }

}  // namespace palpate::fem
