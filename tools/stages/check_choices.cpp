#include "tools/stages/check_choices.hpp"

#include "tools/stages/body/open_scene.hpp"
#include "tools/stages/samples/compound.hpp"
#include "tools/stages/samples/experiment_table.hpp"

namespace palpate::tools {

void check_choices(const Scene& scene) {
  check_simulated(scene);
  check_pairs(scene);
  check_tools(scene);
}

}  // namespace palpate::tools
