#pragma once

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <vector>

namespace palpate::fem {

/// A linear elastic layer, thickness_m down.
struct GroundLayer {
  double thickness_m, young_Pa, poisson;
};

/// Surface of a stack of bonded layers, the first one on top, on rigid ground, under pressure
/// p J0(k r) without shear: downward displacement over p [m/Pa]. Displacement and stress of one
/// wave number, (u, w, sigma, tau) of J1 and J0, obey y' = M y; the relation d = S s at the rigid
/// ground, S = 0, is carried up in steps of k dz <= 1, which keeps its digits.
inline double wave_compliance_m_Pa(const std::vector<GroundLayer>& stack, double k) {
  Eigen::Matrix2d S = Eigen::Matrix2d::Zero();
  const double unit = stack.front().young_Pa;  // of stress, displacements times k
  for (auto layer = stack.rbegin(); layer != stack.rend(); ++layer) {
    const double mu = layer->young_Pa / (2 * (1 + layer->poisson)) / unit,
                 lambda = 2 * mu * layer->poisson / (1 - 2 * layer->poisson), M = lambda + 2 * mu;
    Eigen::Matrix4d rate;                           // over k z
    rate << 0, 1, 0, 1 / mu,                        // u'
        -lambda / M, 0, 1 / M, 0,                   // w'
        0, 0, 0, -1,                                // sigma'
        M - lambda * lambda / M, 0, lambda / M, 0;  // tau'
    const int steps = std::max(1, static_cast<int>(std::ceil(k * layer->thickness_m)));
    const Eigen::Matrix4d step = rate * (k * layer->thickness_m / steps);
    Eigen::Matrix4d power = Eigen::Matrix4d::Identity(), E = power;
    for (int n = 1; n < 40; ++n) {
      power = power * step / n;
      E += power;
    }
    for (int n = 0; n < steps; ++n)
      S = (E.topLeftCorner<2, 2>() * S + E.topRightCorner<2, 2>()) *
          (E.bottomLeftCorner<2, 2>() * S + E.bottomRightCorner<2, 2>()).inverse();
  }
  return S(1, 0) / (k * unit);
}

/// Force [N] of a frictionless paraboloid of tip radius R on the stack, by depth. With the
/// pressure's transform int_0^a phi(t) cos(k t) dt, Abel's operator turns the contact into an
/// integral equation of the second kind, c (pi/2 phi(x) + int phi K(x, t) dt) = depth - x^2/R
/// (Perriot and Barthel 2004, doi:10.1557/jmr.2004.19.2.600), c = 2 (1 - nu^2)/E of the top, K =
/// int (C k/c - 1) cos cos dk; phi(a) = 0 at the rim.
class LayeredContact {
 public:
  LayeredContact(std::vector<GroundLayer> stack, double radius_m)
      : radius_m_(radius_m),
        c_(2 * (1 - stack[0].poisson * stack[0].poisson) / stack[0].young_Pa),
        step_(0.02 / stack[0].thickness_m) {
    for (int i = 0; i < 1000; ++i) {  // midpoints, to e^-40
      const double k = (i + 0.5) * step_;
      excess_.push_back(wave_compliance_m_Pa(stack, k) * k / c_ - 1);
    }
  }

  double force_N(double depth_m) const {
    double low = 0, high = 4 * std::sqrt(depth_m * radius_m_);
    for (int halving = 0; halving < 40; ++halving) {
      const double middle = (low + high) / 2;
      (rim(middle, depth_m).pressure > 0 ? low : high) = middle;
    }
    return rim(low, depth_m).force_N;
  }

 private:
  struct Rim {
    double pressure, force_N;  // phi(a)
  };
  static constexpr int kParts = 40;

  double kernel(double x, double t) const {
    double sum = 0;
    for (std::size_t i = 0; i < excess_.size(); ++i) {
      const double k = (double(i) + 0.5) * step_;
      sum += excess_[i] * std::cos(k * x) * std::cos(k * t) * step_;
    }
    return sum;
  }

  // By Simpson's rule on the radius.
  Rim rim(double a, double depth_m) const {
    Eigen::MatrixXd A(kParts + 1, kParts + 1);
    Eigen::VectorXd right(kParts + 1), weight(kParts + 1);
    const double h = a / kParts;
    for (int j = 0; j <= kParts; ++j)
      weight[j] = h / 3 * (j == 0 || j == kParts ? 1 : j % 2 == 1 ? 4 : 2);
    for (int i = 0; i <= kParts; ++i) {
      right[i] = (depth_m - h * i * h * i / radius_m_) / c_;
      for (int j = 0; j <= i; ++j) A(i, j) = A(j, i) = kernel(h * i, h * j);
    }
    A = A * weight.asDiagonal();
    A.diagonal().array() += std::numbers::pi / 2;
    const Eigen::VectorXd phi = A.partialPivLu().solve(right);
    return {phi[kParts], 2 * std::numbers::pi * phi.dot(weight)};
  }

  double radius_m_, c_, step_;
  std::vector<double> excess_;
};

}  // namespace palpate::fem
