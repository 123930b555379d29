#pragma once

#include <cstddef>
#include <vector>

namespace palpate::fem {

// Eight elements side by side: the arithmetic of one law, written once over a scalar S that is a
// double or a Pack. Lanes never mix and no multiply-add is fused (-ffp-contract=off), so a result
// has the same bits whichever instruction set the kernels were dispatched to.

inline constexpr int kLanes = 8;
/// The alignment is spelled out: left to itself it depends on the instruction set of the function.
typedef double Pack
    __attribute__((vector_size(kLanes * sizeof(double)), aligned(kLanes * sizeof(double))));

#define PALPATE_INLINE inline __attribute__((always_inline))

/// Packs on the heap. (std::vector<Pack> would drop the alignment.)
class PackArray {
 public:
  explicit PackArray(std::size_t size = 0) : lanes_(size) {}
  Pack* data() { return reinterpret_cast<Pack*>(lanes_.data()); }
  const Pack* data() const { return reinterpret_cast<const Pack*>(lanes_.data()); }
  std::size_t size() const { return lanes_.size(); }
  double& at(std::size_t i, int lane) { return lanes_[i].lane[lane]; }

 private:
  struct alignas(kLanes * sizeof(double)) Lanes {
    double lane[kLanes] = {};
  };
  std::vector<Lanes> lanes_;
};

}  // namespace palpate::fem
