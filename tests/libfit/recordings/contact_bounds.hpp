#pragma once

#include <Eigen/QR>
#include <cmath>
#include <string>
#include <vector>

#include "tests/libfit/recordings/case_recordings.hpp"

// Cramer-Rao bounds of a contact point: no unbiased estimator has a smaller deviation.
namespace palpate::testing_recordings {

/// Noise of a case in full forces: white, rounding, and drift of a spectrum 1/f over the recording
/// (the periodograms of all six N2 recordings agree with 1 % rms). Hysteresis, outliers and what
/// N7 has beside its white noise come on top: bounds of those cases are too low.
struct Noise {
  double white = 0, quantum = 0, drift = 0;
};

inline Noise noise_of(const std::string& name) {
  if (name == "N0") return {};
  if (name == "N2_drift") return {0.005, 0, 0.01};
  if (name == "N4_quant") return {0.003, 0.02, 0};
  return {name == "N1_gauss" || name == "N3_outlier" || name == "N7_all" ? 0.01 : 0.005, 0, 0};
}

/// Fisher information of one reading about its force; of the rounded reading where it is rounded.
inline double information(double force, const Noise& noise) {
  const double s = noise.white;
  if (noise.quantum == 0) return 1 / (s * s);
  double sum = 0;
  const double nearest = std::round(force / noise.quantum);
  for (double k = nearest - 3; k <= nearest + 3; ++k) {
    const double a = ((k - 0.5) * noise.quantum - force) / s,
                 b = ((k + 0.5) * noise.quantum - force) / s;
    const double p = 0.5 * (std::erfc(-b * M_SQRT1_2) - std::erfc(-a * M_SQRT1_2));
    const double dp = (std::exp(-a * a / 2) - std::exp(-b * b / 2)) / (s * std::sqrt(2 * M_PI));
    if (p > 1e-300) sum += dp * dp / p;
  }
  return sum;
}

/// Columns as the whitened readings see them: each frequency over its own deviation.
inline Eigen::MatrixXd whitened(const Eigen::MatrixXd& J, const Noise& noise) {
  const Eigen::Index n = J.rows();
  double sum = 0;
  for (Eigen::Index m = 1; m < n; ++m) sum += 1.0 / static_cast<double>(std::min(m, n - m));
  Eigen::MatrixXd rows(n, J.cols());
  for (Eigen::Index k = 0; k < n; ++k) {  // cosines, then sines
    const Eigen::Index m = k <= n / 2 ? k : n - k;
    Eigen::VectorXd wave(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const double phase = 2 * M_PI * static_cast<double>(m * i % n) / static_cast<double>(n);
      wave[i] = k <= n / 2 ? std::cos(phase) : std::sin(phase);
    }
    const double pink =
        m > 0 ? noise.drift * noise.drift * static_cast<double>(n) / sum / static_cast<double>(m)
              : 0;
    rows.row(k) = wave.normalized().transpose() * J / std::sqrt(noise.white * noise.white + pink);
  }
  return rows;
}

/// Of all rows of the clean recording; unknown beside the contact point are the scale alone (the
/// shape is known, as cases.json counts), or the force before contact and a whole curve: pieces of
/// the C1 cubic over 8 mm, zero at contact.
inline double contact_bound_m(const std::string& truth, const Noise& noise, bool knows_shape) {
  constexpr int kPieces = 4;
  constexpr double kDepth = 8;  // mm
  const auto exact = case_rows(truth, "TRUTH");
  double full = 0;
  for (const auto& row : exact) full = std::max(full, row[1]);
  const auto at = [&](double d) {
    const double x = std::clamp(d / 0.02, 0.0, static_cast<double>(exact.size() - 1) - 1e-9);
    const auto k = static_cast<std::size_t>(x);
    return ((1 - x + double(k)) * exact[k][1] + (x - double(k)) * exact[k + 1][1]) / full;
  };
  const auto rows = case_rows(truth, "N0");
  const int unknowns = knows_shape ? 2 : 2 * kPieces + 3;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows.size()), unknowns);
  for (Eigen::Index i = 0; i < J.rows(); ++i) {
    const double d = rows[static_cast<std::size_t>(i)][1];
    const double force = d > 0 ? at(d) : 0;
    if (!knows_shape) J(i, unknowns - 2) = 1;
    if (d > 0) {
      J(i, unknowns - 1) = (at(d + 0.01) - at(std::max(0.0, d - 0.01))) /
                           (std::min(d + 0.01, kDepth) - std::max(0.0, d - 0.01));
      if (knows_shape) {
        J(i, 0) = force;
      } else {
        const int piece = std::min(static_cast<int>(d / kDepth * kPieces), kPieces - 1);
        const double t = d / kDepth * kPieces - piece, u = 1 - t;
        const int c = 2 * piece - 1;  // value, slope at the piece's ends; value 0 at contact
        if (piece > 0) J(i, c) = (1 + 2 * t) * u * u;
        J(i, c + 1) = t * u * u;
        J(i, c + 2) = t * t * (3 - 2 * t);
        J(i, c + 3) = -t * t * u;
      }
    }
    if (noise.drift == 0) J.row(i) *= std::sqrt(information(force, noise));
  }
  if (noise.drift > 0) J = whitened(J, noise);
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(J);
  return 1e-3 / std::abs(qr.matrixQR()(unknowns - 1, unknowns - 1));
}

}  // namespace palpate::testing_recordings
