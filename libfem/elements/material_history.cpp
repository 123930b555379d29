#include <algorithm>
#include <cmath>
#include <utility>

#include "libfem/elements/cell_integrals.hpp"
#include "libfem/elements/elastic_body.hpp"
#include "libfem/materials/kinematics.hpp"

namespace palpate::fem {
namespace {

constexpr int kRow[kSymmetric] = {0, 1, 2, 0, 0, 1}, kColumn[kSymmetric] = {0, 1, 2, 1, 2, 2};

// W - U where the displacement gradient is H; 0 on idle lanes.
void energy_of_shape(const LawKernels& law, const Pack* constants, const Pack& weight,
                     const Pack* H, Pack& energy) {
  const Pack zero = Pack{};
  Pack J, W, dilation, cofactor[9], U, U1, U2;
  law.evaluate(constants, H, 1, J, W, nullptr, nullptr);
  dilation_of(H, dilation, cofactor);
  volumetric(law, constants, weight, dilation, U, U1, U2);
  energy = weight > 0.0 ? W - U : zero;
}

// Second Piola-Kirchhoff stress of W - U where the displacement gradient is H.
void stress_of_shape(const LawKernels& law, const Pack* constants, const Pack& weight,
                     const Pack* H, Pack* stress) {
  const Pack zero = Pack{};
  Pack J, W, P[9], F[9], cofactor[9], U, U1, U2;
  law.evaluate(constants, H, 1, J, W, P, nullptr);
  for (int i = 0; i < 9; ++i) F[i] = i % 4 == 0 ? H[i] + 1.0 : H[i];
  cofactors_of(F, cofactor);
  const Pack dilation = weight > 0.0 ? J - 1.0 : zero;
  law.volumetric(constants, dilation, U, U1, U2);
  for (int entry = 0; entry < kSymmetric; ++entry) {
    Pack sum = zero;
    for (int i = 0; i < 3; ++i) {
      const int at = 3 * i + kColumn[entry];
      sum += cofactor[3 * i + kRow[entry]] * (P[at] - U1 * cofactor[at]);  // J F^-1 = cofactor'
    }
    stress[entry] = weight > 0.0 ? sum / J : zero;
  }
}

}  // namespace

double MaterialStep::max_stiffening() const {
  return stiffening.empty() ? 1.0 : *std::max_element(stiffening.begin(), stiffening.end());
}

BranchDecay branch_decay(double dt_over_time) {
  if (dt_over_time <= 0) return {1, 1};
  if (std::isinf(dt_over_time)) return {0, 0};
  return {std::exp(-dt_over_time), -std::expm1(-dt_over_time) / dt_over_time};
}

bool ElasticBody::relaxes() const {
  return std::any_of(relaxations_.begin(), relaxations_.end(),
                     [](const Relaxation& relaxation) { return relaxation.branches() > 0; });
}

bool ElasticBody::softens() const {
  return std::any_of(softenings_.begin(), softenings_.end(),
                     [](const Softening& softening) { return softening.is_any(); });
}

double ElasticBody::steps_in_time(double from_s, double to_s) const {
  const double duration_s = to_s - from_s;
  double steps = 1;
  // Steps over a branch's time that need no division.
  for (const Relaxation& relaxation : relaxations_)
    for (const double time_s : relaxation.time_s)
      if (duration_s > 0.05 * time_s && duration_s < 200.0 * time_s)
        steps = std::max(steps, std::ceil(6 * duration_s / to_s - 1e-9));  // see kStepError
  return steps;
}

MaterialStep ElasticBody::step_from(std::shared_ptr<const MaterialHistory> from,
                                    double dt_s) const {
  MaterialStep step{std::move(from), dt_s, {}, {}, {}};
  for (std::size_t b = 0; b < batches_.size(); ++b) {
    PackArray& peak =
        step.peak.emplace_back(softenings_[batches_[b].material].is_any() ? kElementPoints : 0);
    if (step.from && peak.size() > 0) peak = step.from->peak[b];
    const Relaxation& relaxation = relaxations_[batches_[b].material];
    const auto branches = static_cast<int>(relaxation.branches());
    double& stiffening = step.stiffening.emplace_back(1.0);
    PackArray& held = step.held.emplace_back(branches > 0 ? kSymmetric * kElementPoints : 0);
    for (int k = 0; k < branches; ++k) {
      const BranchDecay decay = branch_decay(dt_s / relaxation.time_s[k]);
      const double now = relaxation.share[k] * decay.taken;  // g z
      stiffening += now;
      if (!step.from) continue;
      const Pack* stress = step.from->stress[b].data();
      for (int q = 0; q < kElementPoints; ++q, stress += kSymmetric * (1 + branches))
        for (int i = 0; i < kSymmetric; ++i)
          held.data()[kSymmetric * q + i] +=
              decay.kept * stress[kSymmetric * (1 + k) + i] - now * stress[i];
    }
  }
  return step;
}

MaterialHistory ElasticBody::remembered(const Points& u, const MaterialStep& step) const {
  MaterialHistory out;
  const double* rows = displacement_rows(u);
  Pack displacement[3 * kElementNodes], H[9], stress[kSymmetric];
  for (std::size_t b = 0; b < batches_.size(); ++b) {
    const Batch& batch = batches_[b];
    const Relaxation& relaxation = relaxations_[batch.material];
    const auto branches = static_cast<int>(relaxation.branches());
    const int size = kSymmetric * (1 + branches);
    PackArray& to = out.stress.emplace_back(branches > 0 ? size * kElementPoints : 0);
    PackArray& peak = out.peak.emplace_back(step.peak[b]);
    if (branches == 0 && peak.size() == 0) continue;
    batch.kernels.gather(rows, batch.points.data(), displacement);
    for (int q = 0; q < kElementPoints; ++q) {
      displacement_gradient(batch.gradient.data() + 3 * kElementNodes * q, displacement, H);
      const LawKernels& law = batch.law->kernels->with(set_);
      const Pack *constants = batch.constants.data() + batch.law->constants_used * q,
                 &weight = batch.weight.data()[q];
      if (peak.size() > 0) {
        Pack shape;
        energy_of_shape(law, constants, weight, H, shape);
        peak.data()[q] = shape > peak.data()[q] ? shape : peak.data()[q];
      }
      if (branches == 0) continue;
      stress_of_shape(law, constants, weight, H, stress);
      Pack* now = to.data() + size * q;
      const Pack* before = step.from ? step.from->stress[b].data() + size * q : now;  // 0
      for (int k = 0; k < branches; ++k) {
        const BranchDecay decay = branch_decay(step.dt_s / relaxation.time_s[k]);
        for (int i = 0; i < kSymmetric; ++i)
          now[kSymmetric * (1 + k) + i] =
              decay.kept * before[kSymmetric * (1 + k) + i] +
              relaxation.share[k] * decay.taken * (stress[i] - before[i]);
      }
      for (int i = 0; i < kSymmetric; ++i) now[i] = stress[i];
    }
  }
  return out;
}

}  // namespace palpate::fem
