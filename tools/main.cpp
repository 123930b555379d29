#include "tools/command.hpp"

namespace palpate::tools {
namespace {

constexpr CommandRow kCommands[] = {
    {"new", "Write a commented scene to start from, for a surface mesh", declare_new, "Start",
     "new organ.stl --unit mm -o organ.toml"},
    {"check", "Say all that is wrong with a scene, try one point, and say what a run will cost",
     declare_check, "Start", "check organ.toml"},
    {"run",
     "Run all stages, or those still missing, from a scene or recordings to an asset and its error "
     "statement",
     declare_run, "Start", "run organ.toml -o out --quick"},
    {"report", "Write a page to look at: errors, the body, its curves, and the body to poke",
     declare_report, "Start", "report out"},
    {"prepare", "Repair a surface, place test points on it and fill it with tetrahedra",
     declare_prepare, "Stages of a run", "prepare organ.toml -o body.h5"},
    {"simulate", "Simulate presses and drags of the probe at every test point", declare_simulate,
     "Stages of a run", "simulate body.h5 -o samples.h5"},
    {"merge", "Put the samples of several simulate --shard together", declare_merge,
     "Stages of a run", "merge shards -o samples.h5"},
    {"fit", "Identify response curves at the test points", declare_fit, "Stages of a run",
     "fit samples.h5 -o curves.h5"},
    {"refine", "Interpolate the curves onto every vertex of the fine surface", declare_refine,
     "Stages of a run", "refine curves.h5 --body body.h5 -o model.h5"},
    {"export", "Write a model as a runtime asset or in another format", declare_export,
     "Stages of a run", "export model.h5 -o asset.palp --engine engine"},
    {"validate", "Compare an asset with fresh simulated experiments", declare_validate,
     "Stages of a run", "validate asset.palp organ.toml"},
    {"import", "Turn the recordings that a manifest names into samples", declare_import,
     "Recordings", "import manifest.toml -o samples.h5"},
    {"surface", "Make a surface from where recordings touched the body", declare_surface,
     "Recordings", "surface samples.h5 -o body.obj"},
    {"calibrate", "Identify a material from presses on a body or from tests of specimens",
     declare_calibrate, "Recordings",
     "calibrate organ.toml --samples samples.h5 -o calibrated.toml"},
    {"replay", "Play a tool path on an asset and write the forces", declare_replay,
     "Assets and files", "replay asset.palp path.csv -o forces.csv"},
    {"inspect", "Print what a file holds", declare_inspect, "Assets and files",
     "inspect asset.palp"},
    {"tabulate", "Write curves as a table", declare_tabulate, "Assets and files",
     "tabulate curves.h5 -o table.csv"},
    {"predict", "Compare a model with experiments at points where it was not fitted",
     declare_predict, "Studies", "predict model.h5 samples.h5"},
    {"study", "Run many scenes: bodies, materials, probes and settings, here or on a cluster",
     declare_study, "Studies", "study study.toml -o out"},
    {"bench", "Measure speed and error, and write tables and pictures", declare_bench, "Studies",
     "bench tick -o bench"},
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
