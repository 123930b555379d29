#include <benchmark/benchmark.h>

#include <memory>

#include "libfem/elements/element_kernels.hpp"
#include "libfem/materials/fung.hpp"
#include "libfem/materials/holzapfel_gasser_ogden.hpp"
#include "libfem/materials/mooney_rivlin.hpp"
#include "libfem/materials/neo_hookean.hpp"
#include "libfem/materials/neo_hookean_isochoric.hpp"
#include "libfem/materials/ogden.hpp"
#include "libfem/materials/st_venant_kirchhoff.hpp"
#include "libfem/materials/stable_neo_hookean.hpp"
#include "libfem/materials/veronda_westmann.hpp"
#include "libfem/materials/yeoh.hpp"
#include "tests/libfem/materials/examples.hpp"

// Time per ten-node element (four points) of every law:
//   law/...      the law alone, stress with tangent or stress: one double at a time against eight
//   lanes cell/...     the whole element, stiffness with force or force, on each instruction set
// The counter ns_per_element is what to compare.

namespace palpate::fem {
namespace {

using namespace examples;

constexpr int kPoints = 4, kNodes = 10;

void count_elements(benchmark::State& state, int elements) {
  state.counters["ns_per_element"] =
      benchmark::Counter(1e-9 * elements * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

PackArray gradients(double size) {
  std::mt19937 random(kSeed + 40);
  PackArray H(9 * kPoints);
  for (int i = 0; i < 9 * kPoints; ++i)
    for (int lane = 0; lane < kLanes; ++lane)
      H.at(i, lane) = std::uniform_real_distribution<double>(-size, size)(random);
  return H;
}

PackArray spread(const Material& material, int copies) {
  const int count = material.law->constants_used;
  PackArray constants(count * copies);
  for (int i = 0; i < count * copies; ++i)
    for (int lane = 0; lane < kLanes; ++lane) constants.at(i, lane) = material.constants[i % count];
  return constants;
}

template <class Law, bool kTangent>
void one_double_at_a_time(benchmark::State& state, const Material& material) {
  PackArray H = gradients(0.2);
  double A[81], P[9], J, W;
  for (auto _ : state) {
    for (int point = 0; point < kPoints; ++point) {
      double h[9];
      for (int i = 0; i < 9; ++i) h[i] = H.at(9 * point + i, 0);
      Law::template evaluate<double>(material.constants.data(), h, 1.0, J, W, P,
                                     kTangent ? A : nullptr);
      benchmark::DoNotOptimize(P);
      benchmark::DoNotOptimize(A);
    }
  }
  count_elements(state, 1);
}

void eight_lanes(benchmark::State& state, const Material& material, InstructionSet set,
                 bool tangent) {
  PackArray H = gradients(0.2), constants = spread(material, 1), out(92);
  const LawKernels& law = material.law->kernels->with(set);
  Pack* o = out.data();
  for (auto _ : state) {
    for (int point = 0; point < kPoints; ++point) {
      if (tangent)
        law.tangent(constants.data(), H.data() + 9 * point, 1.0, o[0], o[1], o + 2, o + 11);
      else
        law.stress(constants.data(), H.data() + 9 * point, o[0], o[1], o + 2);
      benchmark::ClobberMemory();
    }
  }
  count_elements(state, kLanes);
}

void cells(benchmark::State& state, const Material& material, InstructionSet set, bool stiffness) {
  std::mt19937 random(kSeed + 41);
  std::uniform_real_distribution<double> uniform(-1, 1);
  PackArray gradient(3 * kNodes * kPoints), weight(kPoints), mode(0), displacement(3 * kNodes),
      constants = spread(material, kPoints);
  for (int lane = 0; lane < kLanes; ++lane) {
    for (int i = 0; i < 3 * kNodes * kPoints; ++i) gradient.at(i, lane) = uniform(random);
    for (int i = 0; i < 3 * kNodes; ++i) displacement.at(i, lane) = 0.05 * uniform(random);
    for (int q = 0; q < kPoints; ++q) weight.at(q, lane) = 0.04;
  }
  const CellBatch batch{gradient.data(),
                        weight.data(),
                        constants.data(),
                        mode.data(),
                        material.law->constants_used,
                        0.0};
  const auto result = std::make_unique<CellResult>();
  const CellKernels kernels = cell_kernels(ElementKind::tet10, set);
  const LawKernels& law = material.law->kernels->with(set);
  for (auto _ : state) {
    if (stiffness)
      kernels.stiffness(batch, law, displacement.data(), 1.0, *result);
    else
      kernels.force(batch, law, displacement.data(), *result);
    benchmark::ClobberMemory();
  }
  count_elements(state, kLanes);
}

template <class Law>
void add(const std::string& example_name) {
  for (const Example& example : all()) {
    if (example.name != example_name) continue;
    const Material material = make_material(example.parameters, example_name);
    const auto name = [&](const char* what, const char* how) {
      return std::string(what) + "/" + example_name + "/" + how;
    };
    const auto time = [](const std::string& what, auto function, auto... arguments) {
      benchmark::RegisterBenchmark(what.c_str(), function, arguments...);
    };
    time(name("law/tangent", "scalar"), one_double_at_a_time<Law, true>, material);
    time(name("law/stress", "scalar"), one_double_at_a_time<Law, false>, material);
    constexpr std::pair<InstructionSet, const char*> kSets[] = {
        {InstructionSet::portable, "portable"},
        {InstructionSet::avx2, "avx2"},
        {InstructionSet::avx512, "avx512"}};
    for (const auto& [set, label] : kSets) {
      if (!has_instruction_set(set)) continue;
      time(name("law/tangent", label), eight_lanes, material, set, true);
      time(name("law/stress", label), eight_lanes, material, set, false);
      time(name("cell/stiffness", label), cells, material, set, true);
      time(name("cell/force", label), cells, material, set, false);
    }
  }
}

}  // namespace
}  // namespace palpate::fem

int main(int argc, char** argv) {
  using namespace palpate::fem;
  add<NeoHookean>("neo_hookean");
  add<NeoHookeanSimo>("neo_hookean_simo");
  add<NeoHookeanIsochoric>("neo_hookean_isochoric");
  add<NeoHookeanIsochoricLog>("neo_hookean_isochoric_log");
  add<NeoHookeanIsochoricSimo>("neo_hookean_isochoric_simo");
  add<StableNeoHookean>("stable_neo_hookean");
  add<MooneyRivlin>("mooney_rivlin");
  add<Yeoh>("yeoh");
  add<Ogden>("ogden_1");
  add<Ogden>("ogden_2");
  add<Ogden>("ogden_3");
  add<Fung>("fung");
  add<VerondaWestmann>("veronda_westmann");
  add<HolzapfelGasserOgden>("fibres");
  add<StVenantKirchhoff>("st_venant_kirchhoff");
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
