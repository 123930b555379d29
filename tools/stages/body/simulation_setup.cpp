#include "tools/stages/body/simulation_setup.hpp"

#include <mutex>
#include <utility>
#include <vector>

#include "libfem/materials/element_kernel.hpp"
#include "libfem/solve/factor/schur_factor.hpp"
#include "tools/console.hpp"

namespace palpate::tools {
namespace {

void warn_of_old_processor() {
  if (!fem::has_instruction_set(fem::InstructionSet::avx2))
    warn(
        "this processor has no AVX2 with FMA: a simulation takes several times as long, and forces "
        "differ from those of other processors in their last digits");
}

}  // namespace

fem::SimulationSetup make_setup(const Scene& scene, const Body& body) {
  static std::once_flag said;
  std::call_once(said, warn_of_old_processor);
  fem::bound_factor_memory(1e9 * scene.experiments.memory_GB);
  fem::SimulationSetup setup;
  setup.volume = body.volume;
  setup.is_held = body.is_held;
  setup.held_at = [fixed = scene.body.fixed](const Vec3& place, bool is_on_boundary) {
    return any_contains(fixed, place, is_on_boundary);
  };
  setup.surface = body.surface;
  setup.materials.push_back(*scene.material);
  std::vector<Region> regions;
  for (const InclusionSection& inclusion : scene.inclusions) {
    setup.materials.push_back(inclusion.material);
    regions.push_back(inclusion.region);
  }
  // The last inclusion named wins where several overlap.
  if (!regions.empty())
    setup.region_at = [regions](const Vec3& place) {
      for (std::size_t i = regions.size(); i-- > 0;)
        if (contains(regions[i], place)) return static_cast<int>(i) + 1;
      return 0;
    };
  // Of a layer that is thin against its breadth: confined along the normal, in shear across (M13f).
  std::vector<std::pair<Region, fem::BedStiffness>> beds;
  for (const BedSection& bed : scene.beds) {
    const fem::Material layer = fem::make_material(bed.material, "material of [[bed]]");
    const fem::SmallStrain moduli = layer.law->small_strain(layer.constants);
    beds.push_back({bed.region,
                    {(moduli.lambda_Pa + 2 * moduli.mu_Pa) / bed.thickness_m,
                     bed.slides ? 0 : moduli.mu_Pa / bed.thickness_m}});
  }
  if (!beds.empty())
    setup.bed_at = [beds](const Vec3& place) {
      for (const auto& [region, stiffness] : beds)
        if (contains(region, place)) return stiffness;
      return fem::BedStiffness{};
    };
  setup.probe = scene.probe.spec;
  setup.options.force_tolerance = scene.experiments.force_tolerance;
  return setup;
}

fem::Experiments experiments_of(const Scene& scene) {
  fem::Experiments experiments = scene.experiments.each;
  if (experiments.drag_directions == 0) experiments.drag_depths_m.clear();
  return experiments;
}

}  // namespace palpate::tools
