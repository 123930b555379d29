#pragma once

#include <Eigen/Core>

namespace palpate::fem {

/// How preconditioned conjugate gradients ended.
struct PcgOutcome {
  int iterations = 0;
  double relative_residual = 1;
  bool met_negative_curvature = false;
};

/// Solves K x = b from x = 0, stopping at |b - K x| <= tolerance |b|, after `most` iterations, or
/// where K is not positive along the search direction: x is then the last iterate, or the
/// preconditioned b when that was the first one (Steihaug 1983, doi:10.1137/0720042), so it always
/// descends. multiply(x, y): y = K x. precondition(b, x): x = M^-1 b.
/// The search direction is corrected by the change of the residual (flexible CG, Notay 2000).
template <class Multiply, class Precondition>
PcgOutcome pcg(const Multiply& multiply, const Precondition& precondition, const Eigen::VectorXd& b,
               Eigen::VectorXd& x, double tolerance, int most) {
  PcgOutcome out;
  Eigen::VectorXd r = b, r_before, z, p, Kp;
  x.setZero(b.size());
  const double goal = tolerance * b.norm();
  double rz = 0;
  for (; out.iterations < most; ++out.iterations) {
    precondition(r, z);
    const double rz_new = r.dot(z);
    p = out.iterations == 0 ? z : Eigen::VectorXd(z + (rz_new - z.dot(r_before)) / rz * p);
    rz = rz_new;
    multiply(p, Kp);
    const double curvature = p.dot(Kp);
    if (!(curvature > 0)) {
      out.met_negative_curvature = true;
      if (out.iterations == 0) x = z;
      ++out.iterations;
      return out;
    }
    const double step = rz / curvature;
    r_before = r;
    x += step * p;
    r -= step * Kp;
    out.relative_residual = r.norm() / b.norm();
    if (r.norm() <= goal) {
      ++out.iterations;
      return out;
    }
  }
  return out;
}

}  // namespace palpate::fem
