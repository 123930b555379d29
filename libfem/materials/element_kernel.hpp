#pragma once

#include <sys/platform/x86.h>

#include "libfem/materials/pack_math.hpp"

namespace palpate::fem {

/// Instruction sets that kernels are compiled for, in rising order; avx2 is AVX2 with FMA.
enum class InstructionSet { portable, avx2, avx512 };
inline constexpr int kInstructionSets = 3;

/// True if this processor has it. AVX2 and AVX-512 can be hidden from the program by glibc's
/// tunables (glibc.cpu.hwcaps=-AVX512F).
inline bool has_instruction_set(InstructionSet set) {
  return set == InstructionSet::portable ||
         (set == InstructionSet::avx2
              ? CPU_FEATURE_ACTIVE(AVX2) && __builtin_cpu_supports("fma") != 0
              : CPU_FEATURE_ACTIVE(AVX512F));
}

/// The best that this processor has.
inline InstructionSet best_instruction_set() {
  static const InstructionSet best =
      has_instruction_set(InstructionSet::avx512) ? InstructionSet::avx512
      : has_instruction_set(InstructionSet::avx2) ? InstructionSet::avx2
                                                  : InstructionSet::portable;
  return best;
}

/// A law at one quadrature point of eight elements: see its evaluate() and volumetric().
/// constants: [constant]. H: displacement gradient, 9, row major. P and A are null where they are
/// not wanted. dilation: above -1.
struct LawKernels {
  void (*evaluate)(const Pack* constants, const Pack* H, double geometric_scale, Pack& J, Pack& W,
                   Pack* P, Pack* A);
  void (*volumetric)(const Pack* constants, const Pack& dilation, Pack& U, Pack& U1, Pack& U2);
};

/// The kernels of one law, one copy per instruction set: the compiler does not widen vectors by
/// itself across calls.
struct ElementKernels {
  LawKernels on[kInstructionSets];

  const LawKernels& with(InstructionSet set) const { return on[static_cast<int>(set)]; }
};

namespace kernel {

#define PALPATE_LAW_KERNELS(set, target)                                                           \
  template <class Law>                                                                             \
  target void evaluate_##set(const Pack* c, const Pack* H, double geometric_scale, Pack& J,        \
                             Pack& W, Pack* P, Pack* A) {                                          \
    Law::evaluate(c, H, geometric_scale, J, W, P, A);                                              \
  }                                                                                                \
  template <class Law>                                                                             \
  target void volumetric_##set(const Pack* c, const Pack& dilation, Pack& U, Pack& U1, Pack& U2) { \
    Law::volumetric(c, dilation, U, U1, U2);                                                       \
  }                                                                                                \
  template <class Law>                                                                             \
  inline constexpr LawKernels kLawKernels_##set{evaluate_##set<Law>, volumetric_##set<Law>};

PALPATE_LAW_KERNELS(portable, )
PALPATE_LAW_KERNELS(avx2, __attribute__((target("avx2"))))
PALPATE_LAW_KERNELS(avx512, __attribute__((target("avx512f"))))
#undef PALPATE_LAW_KERNELS

}  // namespace kernel

template <class Law>
inline constexpr ElementKernels kElementKernels{{kernel::kLawKernels_portable<Law>,
                                                 kernel::kLawKernels_avx2<Law>,
                                                 kernel::kLawKernels_avx512<Law>}};

}  // namespace palpate::fem
