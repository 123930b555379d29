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

// A law's row from the law, and evaluation at a point.

namespace at_point {

struct Result {
  double J, W;
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> P;
  Mat9 A;  ///< upper triangle
};

template <class Law>
Result evaluate(const LawConstants& constants, const Mat3& F) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> H = F - Mat3::Identity();
  Result out;
  Law::template evaluate<double>(constants.data(), H.data(), 1.0, out.J, out.W, out.P.data(),
                                 out.A.data());
  return out;
}

template <class Law>
double energy(const LawConstants& constants, const Mat3& F) {
  return evaluate<Law>(constants, F).W;
}

template <class Law>
Mat3 stress(const LawConstants& constants, const Mat3& F) {
  return evaluate<Law>(constants, F).P;
}

template <class Law>
Mat9 tangent(const LawConstants& constants, const Mat3& F) {
  return evaluate<Law>(constants, F).A.template selfadjointView<Eigen::Upper>();
}

template <class Law>
void volumetric(const LawConstants& constants, double dilation, double& U, double& U1, double& U2) {
  Law::template volumetric<double>(constants.data(), dilation, U, U1, U2);
}

}  // namespace at_point

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
          .energy = at_point::energy<Law>,
          .stress = at_point::stress<Law>,
          .tangent = at_point::tangent<Law>,
          .volumetric = at_point::volumetric<Law>,
          .kernels = &kElementKernels<Law>};
}

// One row per law; add a law by its file and a row. The kernels of all are compiled here, which
// takes half a minute.
constexpr LawRow kLaws[] = {
    law_row<NeoHookean>(),      law_row<NeoHookeanIsochoric>(),
    law_row<MooneyRivlin>(),    law_row<Yeoh>(),
    law_row<Ogden>(),           law_row<Fung>(),
    law_row<VerondaWestmann>(), law_row<HolzapfelGasserOgden>(),
};

}  // namespace

std::span<const LawRow> material_laws() { return kLaws; }

}  // namespace palpate::fem
