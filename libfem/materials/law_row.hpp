#pragma once

#include "libfem/materials/materials.hpp"

namespace palpate::fem {

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

}  // namespace palpate::fem
