#include "libfit/recordings/indentation/models.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "libfit/core/geometry.hpp"
#include "libfit/core/linear_algebra.hpp"

namespace palpate::recordings {
namespace {

constexpr double kEverywhere = std::numeric_limits<double>::infinity();
constexpr double kIncompressible = 0.495;  // Poisson's ratio from which Garcia's coefficients hold

double square(double x) { return x * x; }
bool is_ball(const Indentation& p) { return p.tip == Tip::sphere && p.radius_m > 0; }
bool is_ball_on_layer(const Indentation& p) { return is_ball(p) && p.thickness_m > 0; }
double everywhere(const Indentation&) { return kEverywhere; }

ModelLaw power(double factor, double exponent) {
  return [=](double d) {
    const double below = std::pow(d, exponent - 1);
    return ModelForce{factor * below * d, factor * exponent * below};
  };
}

// (M35)
ModelLaw hertz(const Indentation& p) { return power(4. / 3 * std::sqrt(p.radius_m), 1.5); }

// Sneddon's sphere (M36): Newton's method on the contact radius, which is half the slope.
ModelLaw sneddon_sphere(const Indentation& p) {
  return [R = p.radius_m](double d) {
    if (!(d > 0)) return ModelForce{};
    // In s = atanh(a / R): depth = a s, which is convex in s, so steps from above never overshoot.
    double s = std::sqrt(d / R) * (1 + d / R);
    for (int i = 0; i < 60; ++i) {
      const double t = std::tanh(s), step = (R * s * t - d) / (R * (t + s * (1 - t * t)));
      s -= step;
      if (std::abs(step) < 1e-15 * s) break;
    }
    const double a = R * std::tanh(s);
    // (a^2 + R^2) s - a R without the cancellation of small contacts.
    const double area =
        s < 1e-2 ? R * R * s * s * s * (4. / 3 - 2. / 3 * s * s) : (a * a + R * R) * s - a * R;
    return ModelForce{area, 2 * a};
  };
}

// Nodes and weights of Gauss and Legendre's rule on [0, 1].
// Source: Abramowitz and Stegun (1964), 25.4.30; nodes by Newton's method on the polynomial.
struct Quadrature {
  std::vector<double> at, weight;
  explicit Quadrature(int n) {
    for (int k = 1; k <= n; ++k) {
      double x = std::cos(M_PI * (k - 0.25) / (n + 0.5)), slope = 1;
      for (int i = 0; i < 50; ++i) {
        double before = 1, here = x;
        for (int j = 2; j <= n; ++j) {
          const double next = ((2 * j - 1) * x * here - (j - 1) * before) / j;
          before = here;
          here = next;
        }
        slope = n * (x * here - before) / (x * x - 1);
        const double step = here / slope;
        x -= step;
        if (std::abs(step) < 1e-15) break;
      }
      at.push_back(0.5 * (1 - x));
      weight.push_back(1 / ((1 - x * x) * slope * slope));
    }
  }
};

// 1 - L of (M37), without the overflow of hyperbolic functions.
double layer_kernel(double x, double nu) {
  const double c = 3 - 4 * nu, e2 = std::exp(-2 * x), e4 = e2 * e2;
  const double below = c * (1 + e4) / 2 + (2 * x * x + 5 - 12 * nu + 8 * nu * nu) * e2;
  const double above = c * (1 - e4) / 2 - 2 * x * e2;
  return 1 - above / below;
}

// Force and depth of a ball on a bonded layer by contact radius (M37), in units of the thickness:
// the integral equation by Nystrom's method.
class LayerTable {
 public:
  explicit LayerTable(const Indentation& p) : R_(p.radius_m / p.thickness_m), h_(p.thickness_m) {
    constexpr int kNodes = 16, kRadii = 60, kKernelNodes = 72;
    constexpr double kMaxRadius = 3, kMaxWave = 12;
    const Quadrature nodes(kNodes), waves(kKernelNodes);
    std::vector<double> kernel;
    for (const double x : waves.at) kernel.push_back(layer_kernel(kMaxWave * x, p.poisson));
    const auto k = [&](double u) {
      double sum = 0;
      for (int i = 0; i < kKernelNodes; ++i)
        sum += waves.weight[i] * kernel[i] * std::cos(kMaxWave * waves.at[i] * u);
      return kMaxWave * sum;
    };
    const auto profile = [&](double t) { return t * std::atanh(t / R_); };  // of the sphere
    const double last = std::min(kMaxRadius, 0.995 * R_);
    depth_.push_back(0), area_.push_back(0), slope_.push_back(0);
    for (int j = 1; j <= kRadii; ++j) {
      const double a = last * square(static_cast<double>(j) / kRadii);
      Eigen::MatrixXd system = Eigen::MatrixXd::Identity(kNodes + 1, kNodes + 1);
      Eigen::MatrixXd right(kNodes + 1, 2);  // of a unit depth, and of the profile
      for (int r = 0; r <= kNodes; ++r) {
        const double t = r < kNodes ? a * nodes.at[r] : a;  // the last row is the contact's edge
        for (int s = 0; s < kNodes; ++s)
          system(r, s) -=
              a * nodes.weight[s] / M_PI * (k(t + a * nodes.at[s]) + k(t - a * nodes.at[s]));
        right(r, 0) = 1;
        right(r, 1) = -profile(t);
      }
      const Eigen::MatrixXd phi = lu_solve(system, right);
      const double depth = -phi(kNodes, 1) / phi(kNodes, 0);
      // Deeper by a bit, the ball presses as a flat punch of this radius does.
      const Eigen::Map<const Eigen::VectorXd> weight(nodes.weight.data(), kNodes);
      const Eigen::RowVector2d sum = 2 * a * weight.transpose() * phi.topRows(kNodes);
      depth_.push_back(depth), area_.push_back(depth * sum[0] + sum[1]), slope_.push_back(sum[0]);
    }
  }

  // Cubic Hermite in the square root of the depth; nothing past the last contact radius.
  ModelForce operator()(double depth_m) const {
    const double d = depth_m / h_;
    if (!(d > 0)) return {};
    const auto above = std::lower_bound(depth_.begin(), depth_.end(), d);
    if (above == depth_.end()) return {std::numeric_limits<double>::quiet_NaN(), 0};
    const auto i = static_cast<std::size_t>(above - depth_.begin());
    const double u0 = std::sqrt(depth_[i - 1]), u1 = std::sqrt(depth_[i]), w = u1 - u0;
    const double u = std::sqrt(d), t = (u - u0) / w;
    const double f0 = area_[i - 1], f1 = area_[i], g0 = 2 * u0 * slope_[i - 1],
                 g1 = 2 * u1 * slope_[i];
    const double f = (1 + 2 * t) * square(1 - t) * f0 + t * square(1 - t) * w * g0 +
                     t * t * (3 - 2 * t) * f1 + t * t * (t - 1) * w * g1;
    const double g =
        6 * t * (t - 1) * (f0 - f1) / w + (1 - t) * (1 - 3 * t) * g0 + t * (3 * t - 2) * g1;
    return {f * h_ * h_, g / (2 * u) * h_};
  }
  double last_depth_m() const { return depth_.back() * h_; }

 private:
  double R_, h_;
  std::vector<double> depth_, area_, slope_;  // by contact radius, ascending
};

ModelLaw layer(const Indentation& p) {
  return [table = std::make_shared<const LayerTable>(p)](double d) { return (*table)(d); };
}

// Hertz times a polynomial of chi = sqrt(R depth) / thickness.
ModelLaw corrected(const Indentation& p, const std::array<double, 4>& c) {
  return [c, R = p.radius_m, h = p.thickness_m](double d) {
    const double x = std::sqrt(R * d) / h, hertz = 4. / 3 * std::sqrt(R * d);
    const double sum = 1 + x * (c[0] + x * (c[1] + x * (c[2] + x * c[3])));
    const double slope = 1.5 + x * (2 * c[0] + x * (2.5 * c[1] + x * (3 * c[2] + x * 3.5 * c[3])));
    return ModelForce{hertz * d * sum, hertz * slope};
  };
}

// (M38)
ModelLaw dimitriadis(const Indentation& p) {
  const double nu = p.poisson, pi = M_PI;
  const double a = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1 - nu);
  const double b = (0.6387 - 1.0277 * nu + 1.5164 * nu * nu) / (1 - nu);
  return corrected(p, {-2 * a / pi, 4 * a * a / (pi * pi),
                       -8 / (pi * pi * pi) * (a * a * a + 4 * pi * pi / 15 * b),
                       16 * a / (pi * pi * pi * pi) * (a * a * a + 3 * pi * pi / 5 * b)});
}

// (M39)
ModelLaw garcia(const Indentation& p) { return corrected(p, {1.133, 1.497, 1.469, 0.755}); }

// (M40): what is pi/2, Bilodeau's pyramid of four and of three faces.
template <int kFaces>
ModelLaw wedge(const Indentation& p) {
  constexpr double kFactor = kFaces == 0 ? 2 / M_PI : kFaces == 4 ? 0.7453 : 0.8887;
  return power(kFactor * std::tan(p.half_angle_rad), 2);
}

// (M41)
ModelLaw punch(const Indentation& p) { return power(2 * p.radius_m, 1); }

double tenth_of_radius(const Indentation& p) { return 0.1 * p.radius_m; }
// Up to this chi the paraboloid and, of it, up to that depth.
double up_to(const Indentation& p, double chi) {
  return std::min(square(chi * p.thickness_m) / p.radius_m, tenth_of_radius(p));
}

constexpr std::array<IndentationModel, 10> kModels{{
    {"layer", "sphere on a bonded layer, exact (Lebedev and Ufliand 1958)", is_ball_on_layer, layer,
     [](const Indentation& p) { return LayerTable(p).last_depth_m(); }},
    {"layer-garcia", "Hertz with the corrections of Garcia and Garcia (2018), incompressible",
     [](const Indentation& p) { return is_ball_on_layer(p) && p.poisson >= kIncompressible; },
     garcia, [](const Indentation& p) { return up_to(p, 0.45); }},
    {"layer-dimitriadis", "Hertz with the corrections of Dimitriadis et al. (2002), bonded",
     is_ball_on_layer, dimitriadis, [](const Indentation& p) { return up_to(p, 0.15); }},
    {"sphere", "rigid sphere (Sneddon 1965)", is_ball, sneddon_sphere, everywhere},
    {"hertz", "paraboloid; a sphere while it is shallow (Hertz 1881)", is_ball, hertz,
     tenth_of_radius},
    {"cone", "cone (Love 1939, Sneddon 1965)",
     [](const Indentation& p) { return p.tip == Tip::cone && p.half_angle_rad > 0; }, wedge<0>,
     everywhere},
    {"pyramid", "pyramid of four faces (Bilodeau 1992)",
     [](const Indentation& p) { return p.tip == Tip::pyramid && p.half_angle_rad > 0; }, wedge<4>,
     everywhere},
    {"pyramid-3", "pyramid of three faces (Bilodeau 1992)",
     [](const Indentation& p) { return p.tip == Tip::pyramid_3 && p.half_angle_rad > 0; }, wedge<3>,
     everywhere},
    {"punch", "flat cylinder (Boussinesq 1885, Sneddon 1965)",
     [](const Indentation& p) { return p.tip == Tip::flat && p.radius_m > 0; }, punch, everywhere},
    {"power", "power law of free exponent: no modulus, tells whether the others describe the curve",
     [](const Indentation&) { return true; }, nullptr, everywhere},
}};

}  // namespace

std::span<const IndentationModel> indentation_models() { return kModels; }

const IndentationModel* indentation_model_named(std::string_view name) {
  const auto row = std::ranges::find(kModels, name, &IndentationModel::name);
  return row == kModels.end() ? nullptr : &*row;
}

}  // namespace palpate::recordings
