#pragma once

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

namespace palpate::validation {

/// CPU time of this process [s].
inline double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Appends a row to the file that a variable names, below the header where it is new; does nothing
/// when the variable is unset.
template <class... Values>
void append_row(const char* variable, const char* header, const char* format, Values... values) {
  const char* path = std::getenv(variable);
  std::FILE* file = path && *path ? std::fopen(path, "a") : nullptr;
  if (!file) return;
  std::fseek(file, 0, SEEK_END);
  if (std::ftell(file) == 0) std::fputs(header, file);
  std::fprintf(file, format, values...);
  std::fclose(file);
}

/// A row of PALPATE_VALIDATION_CSV, from which docs/validation.md is made. unit: "" for plain
/// numbers. relative_error: signed.
inline void record_case(const std::string& case_id, double reference, double ours,
                        const std::string& unit, double relative_error, double cost_cpu_s) {
  append_row("PALPATE_VALIDATION_CSV", "case,reference,ours,unit,relative_error,cost_cpu_s\n",
             "\"%s\",%.9g,%.9g,%s,%.3e,%.3g\n", case_id.c_str(), reference, ours, unit.c_str(),
             relative_error, cost_cpu_s);
}

/// A point of a force curve in PALPATE_VALIDATION_CURVES, from which the figures in docs/validation
/// are drawn. curve: such as "press" or "drag at 3 mm". at_mm: depth or travel. error_N: the row's
/// own bound. reference_N: NaN for none.
inline void record_curve(const std::string& case_id, const std::string& curve, double at_mm,
                         double force_N, double error_N, double reference_N) {
  append_row("PALPATE_VALIDATION_CURVES", "case,curve,at_mm,force_N,error_N,reference_N\n",
             "\"%s\",\"%s\",%.6g,%.9g,%.3g,%.9g\n", case_id.c_str(), curve.c_str(), at_mm, force_N,
             error_N, reference_N);
}

}  // namespace palpate::validation
