#include "tools/command.hpp"

int main(int argc, char** argv) {
  using namespace palpate::tools;
  // In the order of --help; each row stands beside its command.
  const CommandRow commands[] = {
      kNewCommand,      kCheckCommand,    kRunCommand,     kReportCommand,    kPrepareCommand,
      kSimulateCommand, kMergeCommand,    kFitCommand,     kRefineCommand,    kExportCommand,
      kValidateCommand, kImportCommand,   kSurfaceCommand, kCalibrateCommand, kReplayCommand,
      kInspectCommand,  kTabulateCommand, kStudyCommand};
  return run_program("palpate",
                     "Palpate turns soft bodies, simulated or measured, into force-deflection "
                     "curves for real-time haptics",
                     commands, argc, argv);
}
