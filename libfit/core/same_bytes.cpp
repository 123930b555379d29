#include "libfit/core/same_bytes.hpp"

#include <sleef.h>

#include <Eigen/Core>

namespace palpate {

void fix_order_of_sums() {
  Eigen::setCpuCacheSizes(kFirstCache_bytes, kSecondCache_bytes, kThirdCache_bytes);
}

}  // namespace palpate

// The functions of <math.h> that Palpate, Ceres, METIS or TetGen call, and that a C library may
// have with and without FMA. SLEEF's "cinz" functions have the same bits on every processor, to one
// unit in the last place. A program's own definition precedes a shared library's.
#define PALPATE_ELEMENTARY(name, sleef_name) \
  double name(double x) noexcept { return Sleef_cinz_##sleef_name##purec(x); }
extern "C" {
PALPATE_ELEMENTARY(acos, acosd1_u10)
PALPATE_ELEMENTARY(asin, asind1_u10)
PALPATE_ELEMENTARY(atan, atand1_u10)
PALPATE_ELEMENTARY(atanh, atanhd1_u10)
PALPATE_ELEMENTARY(cbrt, cbrtd1_u10)
PALPATE_ELEMENTARY(cos, cosd1_u10)
PALPATE_ELEMENTARY(cosh, coshd1_u10)
PALPATE_ELEMENTARY(erfc, erfcd1_u15)
PALPATE_ELEMENTARY(exp, expd1_u10)
PALPATE_ELEMENTARY(exp2, exp2d1_u10)
PALPATE_ELEMENTARY(expm1, expm1d1_u10)
PALPATE_ELEMENTARY(log, logd1_u10)
PALPATE_ELEMENTARY(log10, log10d1_u10)
PALPATE_ELEMENTARY(log1p, log1pd1_u10)
PALPATE_ELEMENTARY(log2, log2d1_u10)
PALPATE_ELEMENTARY(sin, sind1_u10)
PALPATE_ELEMENTARY(sinh, sinhd1_u10)
PALPATE_ELEMENTARY(tan, tand1_u10)
PALPATE_ELEMENTARY(tanh, tanhd1_u10)
double atan2(double y, double x) noexcept { return Sleef_cinz_atan2d1_u10purec(y, x); }
double hypot(double x, double y) noexcept { return Sleef_cinz_hypotd1_u05purec(x, y); }
double pow(double x, double y) noexcept { return Sleef_cinz_powd1_u10purec(x, y); }
float powf(float x, float y) noexcept { return Sleef_cinz_powf1_u10purec(x, y); }
void sincos(double x, double* sine, double* cosine) noexcept {
  const auto both = Sleef_cinz_sincosd1_u10purec(x);
  *sine = both.x;
  *cosine = both.y;
}
}
#undef PALPATE_ELEMENTARY
