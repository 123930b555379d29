#include "tools/command.hpp"

namespace palpate::tools {
namespace {

constexpr CommandRow kCommands[] = {
    {"run",
     "Run all stages, or those still missing, from a scene to an asset and its error statement",
     declare_run},
    {"new", "Write a commented scene to start from, for a surface mesh", declare_new},
    {"check", "Say all that is wrong with a scene, try one point, and say what a run will cost",
     declare_check},
    {"prepare", "Repair a surface, place test points on it and fill it with tetrahedra",
     declare_prepare},
    {"simulate", "Simulate presses and drags of the probe at every test point", declare_simulate},
    {"merge", "Put the samples of several simulate --shard together", declare_merge},
    {"import", "Turn the recordings that a manifest names into samples", declare_import},
    {"calibrate", "Identify a material from presses on a body or from tests of specimens",
     declare_calibrate},
    {"modulus", "Fit contact models to recordings: Young's modulus of each press, and maps of it",
     declare_modulus},
    {"fit", "Identify response curves at the test points", declare_fit},
    {"refine", "Interpolate the curves onto every vertex of the fine surface", declare_refine},
    {"export", "Write a model as a runtime asset or in another format", declare_export},
    {"replay", "Play a tool path on an asset and write the forces", declare_replay},
    {"validate", "Compare an asset with fresh simulated experiments", declare_validate},
    {"predict", "Compare a model with experiments at points where it was not fitted",
     declare_predict},
    {"inspect", "Print what a file holds", declare_inspect},
    {"tabulate", "Write curves as a table", declare_tabulate},
    {"report", "Write a page to look at: errors, the body, its curves, and the body to poke",
     declare_report},
    {"study", "Run many scenes: bodies, materials, probes and settings, here or on a cluster",
     declare_study},
    {"bench", "Measure speed and error, and write tables and pictures", declare_bench},
};

}  // namespace
}  // namespace palpate::tools

int main(int argc, char** argv) {
  using namespace palpate::tools;
  return run_program("palpate",
                     "Palpate turns soft bodies, simulated or measured, into force-deflection "
                     "curves for real-time haptics",
                     kCommands, argc, argv);
}
