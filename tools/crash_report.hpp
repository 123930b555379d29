#pragma once

#include <string_view>

namespace palpate::tools {

/// Makes SIGSEGV, SIGILL, SIGBUS, SIGFPE and SIGABRT write one line to stderr and a report to the
/// crash file, before they end the program as they would without. A sanitizer keeps its own
/// handlers. build: version and identity of the program.
void report_crashes(std::string_view build);

/// Names the report `OUTPUT.crash.txt`; without an output it is palpate.crash.txt in the working
/// folder. Reports of several crashes follow each other in the file.
void set_crash_file(std::string_view output);

/// Names what the program does now.
void set_stage(std::string_view stage);

/// Names what the calling thread computes now, such as "press at p0003"; empty: nothing.
void set_item(std::string_view item);

}  // namespace palpate::tools
