#pragma once

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

namespace palpate::validation {

/// CPU time of this process [s].
inline double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Appends a row to the file named by PALPATE_VALIDATION_CSV, from which docs/validation.md is
/// made; does nothing when that is unset. unit: "" for plain numbers. relative_error: signed.
inline void record_case(const std::string& case_id, double reference, double ours,
                        const std::string& unit, double relative_error, double cost_cpu_s) {
  const char* path = std::getenv("PALPATE_VALIDATION_CSV");
  if (!path || !*path) return;
  std::FILE* file = std::fopen(path, "a");
  if (!file) return;
  std::fseek(file, 0, SEEK_END);
  if (std::ftell(file) == 0)
    std::fprintf(file, "case,reference,ours,unit,relative_error,cost_cpu_s\n");
  std::fprintf(file, "\"%s\",%.9g,%.9g,%s,%.3e,%.3g\n", case_id.c_str(), reference, ours,
               unit.c_str(), relative_error, cost_cpu_s);
  std::fclose(file);
}

/// Appends a point of a force curve to the file named by PALPATE_VALIDATION_CURVES, from which the
/// figures in docs/validation are drawn; does nothing when that is unset. curve: such as "press" or
/// "drag at 3 mm". at_mm: depth or travel. error_N: the row's own bound. reference_N: NaN for none.
inline void record_curve(const std::string& case_id, const std::string& curve, double at_mm,
                         double force_N, double error_N, double reference_N) {
  const char* path = std::getenv("PALPATE_VALIDATION_CURVES");
  if (!path || !*path) return;
  std::FILE* file = std::fopen(path, "a");
  if (!file) return;
  std::fseek(file, 0, SEEK_END);
  if (std::ftell(file) == 0) std::fprintf(file, "case,curve,at_mm,force_N,error_N,reference_N\n");
  std::fprintf(file, "\"%s\",\"%s\",%.6g,%.9g,%.3g,%.9g\n", case_id.c_str(), curve.c_str(), at_mm,
               force_N, error_N, reference_N);
  std::fclose(file);
}

}  // namespace palpate::validation
