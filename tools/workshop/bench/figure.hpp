#pragma once

#include <string>
#include <vector>

namespace palpate::tools {

/// A method in a figure: one mark, or a line through the marks of its sizes.
struct FigureSeries {
  std::string name;
  std::vector<double> x, median, p95;  ///< p95: ends of the thin lines above the marks
  bool is_ours = false;                ///< drawn in a colour of its own, larger
};

/// A line across a figure, with its word.
struct FigureLine {
  double at = 0;
  std::string word;
};

struct LogFigure {
  std::string title, x_label, y_label;
  std::vector<FigureSeries> series;
  std::vector<FigureLine> upright, level;
};

/// The figure as SVG, both axes logarithmic over whole decades, y in percent of `median`. On white,
/// or on black. Marks of values that are not above 0 are left out.
std::string draw(const LogFigure& figure, bool is_dark);

}  // namespace palpate::tools
