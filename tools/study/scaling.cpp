#include "tools/study/scaling.hpp"

#include <fmt/format.h>

#include <cmath>

#include "libfem/materials/materials.hpp"
#include "tools/scene/canonical.hpp"

namespace palpate::tools {
namespace {

// The moduli of a scene, those of its body's material first.
std::vector<double*> moduli_of(Scene& scene) {
  std::vector<double*> moduli;
  const auto add = [&](fem::MaterialParameters& material) {
    for (const std::size_t at : fem::moduli_of(material)) moduli.push_back(&material.values[at]);
  };
  if (scene.material) add(*scene.material);
  for (InclusionSection& inclusion : scene.inclusions) add(inclusion.material);
  for (BedSection& bed : scene.beds) add(bed.material);
  return moduli;
}

}  // namespace

std::string unscaled(Scene scene) {
  const std::vector<double*> moduli = moduli_of(scene);
  const double unit = moduli.empty() ? 1 : *moduli.front();
  for (double* modulus : moduli) *modulus = std::stod(fmt::format("{:.12g}", *modulus / unit));
  return canonical(scene, Stage::prepare) + canonical(scene, Stage::simulate) +
         canonical(scene, Stage::surface);
}

double force_factor(const Scene& source, const Scene& scene) {
  if (source.experiments.placement || scene.experiments.placement || !source.material ||
      !scene.material || unscaled(source) != unscaled(scene))
    return 0;
  Scene a = source, b = scene;
  const auto from = moduli_of(a), to = moduli_of(b);
  return from.empty() ? 1 : *to.front() / *from.front();
}

}  // namespace palpate::tools
