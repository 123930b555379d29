#include <algorithm>
#include <array>
#include <cmath>

#include "libfit/core/linear_algebra.hpp"
#include "libfit/recordings/relaxation/fit_relaxation.hpp"

namespace palpate::recordings {
namespace {

using State = std::array<double, runtime::kMaxBranches>;

// One ring's Maxwell branches between two places of the path.
class RingStep {
 public:
  explicit RingStep(const Relaxation& of) : branches_(static_cast<int>(of.branches())) {
    for (int k = 0; k < branches_; ++k) {
      share_[k] = of.share[k], time_s_[k] = of.time_s[k];
      all_ += of.share[k];
    }
    // Free, the ring's surface follows its branches: v' = A v, symmetric in other units.
    Eigen::MatrixXd free(branches_, branches_);
    scale_.resize(branches_);
    for (int k = 0; k < branches_; ++k) {
      scale_[k] = std::sqrt(of.share[k] * of.time_s[k]);
      for (int l = 0; l < branches_; ++l)
        free(k, l) =
            std::sqrt(of.share[k] * of.share[l] / (of.time_s[k] * of.time_s[l])) / (1 + all_) -
            (k == l ? 1 / of.time_s[k] : 0);
    }
    if (branches_ == 0) return;
    const SymmetricEigen eigen = symmetric_eigen(free);
    rate_ = eigen.values;
    mode_ = eigen.vectors;
  }

  void begin(double duration_s) {
    duration_s_ = duration_s;
    for (int k = 0; k < branches_; ++k) decay_[k] = std::exp(-duration_s / time_s_[k]);
  }

  // Moves the ring on while the tool goes from h0 to h1 beyond it; the force at the end.
  double go(double h0, double h1, State& v, bool& is_touching) const {
    if (!is_touching && h1 <= 0 && is_at_rest(v)) return 0;
    const double speed = (h1 - h0) / duration_s_;
    double gone_s = 0, h = h0;
    for (int n = 0; n < 8; ++n) {  // more switches than touched, left, touched
      const double rest_s = duration_s_ - gone_s;
      const auto after = [&](double s) {
        return is_touching ? pressed(v, h, speed, s) : freed(v, s);
      };
      // Above 0 while the ring stays as it is.
      const auto margin = [&](double s) {
        const double pull = force(after(s), h + speed * s);
        return is_touching ? pull : -pull;
      };
      const State end =
          gone_s == 0 && is_touching ? pressed_by(v, h, h1, speed, decay_) : after(rest_s);
      const double pull = force(end, h1);
      if (is_touching ? pull >= 0 : pull <= 0) {
        v = end;
        return is_touching ? pull : 0;
      }
      double in = 0, out = rest_s;
      for (int i = 0; i < 60 && out - in > 1e-15 * duration_s_; ++i) {  // to all bits
        const double middle = (in + out) / 2;
        (margin(middle) > 0 ? in : out) = middle;
      }
      v = after(out);
      h += speed * out;
      gone_s += out;
      is_touching = !is_touching;
      if (gone_s >= duration_s_) break;
    }
    return is_touching ? std::max(0., force(v, h1)) : 0;
  }

 private:
  bool is_at_rest(const State& v) const {
    return std::all_of(v.begin(), v.begin() + branches_, [](double each) { return each == 0; });
  }
  // The force of a tool that would hold the ring's surface at h.
  double force(const State& v, double h) const {
    double sum = (1 + all_) * h;
    for (int k = 0; k < branches_; ++k) sum -= share_[k] * v[k];
    return sum;
  }
  State pressed_by(const State& v, double h0, double h1, double speed, const State& decay) const {
    State next = v;
    for (int k = 0; k < branches_; ++k)
      next[k] = h1 - speed * time_s_[k] * (1 - decay[k]) + (v[k] - h0) * decay[k];
    return next;
  }
  State pressed(const State& v, double h, double speed, double s) const {
    State decay{};
    for (int k = 0; k < branches_; ++k) decay[k] = std::exp(-s / time_s_[k]);
    return pressed_by(v, h, h + speed * s, speed, decay);
  }
  State freed(const State& v, double s) const {
    State next{};
    for (int m = 0; m < branches_; ++m) {
      double part = 0;
      for (int k = 0; k < branches_; ++k) part += mode_(k, m) * scale_[k] * v[k];
      part *= std::exp(rate_[m] * s);
      for (int k = 0; k < branches_; ++k) next[k] += mode_(k, m) * part / scale_[k];
    }
    return next;
  }

  int branches_;
  double all_ = 0, duration_s_ = 0;
  State share_{}, time_s_{}, decay_{};
  Eigen::VectorXd scale_, rate_;
  Eigen::MatrixXd mode_;
};

}  // namespace

Eigen::MatrixXd ring_forces(const Eigen::VectorXd& time_s, const Eigen::VectorXd& depth_m,
                            const Relaxation& relaxation, const Eigen::VectorXd& ring_depth_m) {
  const Eigen::Index rows = time_s.size(), rings = ring_depth_m.size();
  if (relaxation.branches() == 0)
    return (depth_m.replicate(1, rings).rowwise() - ring_depth_m.transpose()).cwiseMax(0);
  Eigen::MatrixXd forces = Eigen::MatrixXd::Zero(rows, rings);
  std::vector<State> state(rings, State{});
  std::vector<char> touching(rings, 0);
  RingStep step(relaxation);
  for (Eigen::Index r = 0; r < rings; ++r)  // what begins in contact has been there for long
    if (const double h = rows > 0 ? depth_m[0] - ring_depth_m[r] : 0; h > 0) {
      state[r].fill(h);
      touching[r] = 1;
      forces(0, r) = h;
    }
  for (Eigen::Index i = 1; i < rows; ++i) {
    step.begin(time_s[i] - time_s[i - 1]);
    for (Eigen::Index r = 0; r < rings; ++r) {
      bool is_touching = touching[r] != 0;
      forces(i, r) = step.go(depth_m[i - 1] - ring_depth_m[r], depth_m[i] - ring_depth_m[r],
                             state[r], is_touching);
      touching[r] = is_touching;
    }
  }
  return forces;
}

Eigen::VectorXd stiffening(const Relaxation& relaxation, const Eigen::VectorXd& time_s) {
  Eigen::VectorXd out = Eigen::VectorXd::Ones(time_s.size());
  for (Eigen::Index k = 0; k < relaxation.branches(); ++k)
    out.array() += relaxation.share[k] * (-time_s.array() / relaxation.time_s[k]).exp();
  return out;
}

}  // namespace palpate::recordings
