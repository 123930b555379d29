#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::tools {

/// A figure in the making: SVG in points (1/72 in), text as text, no style sheet, so that every
/// program shows it alike.
class Svg {
 public:
  /// title: said to those who do not see it.
  Svg(double width_pt, double height_pt, const std::string& title);
  /// Adds an element as it is.
  void add(const std::string& element) { body_ += element + '\n'; }
  /// anchor: start, middle or end; more: further attributes, each with a space before it.
  void text(double x, double y, const std::string& words, std::string_view anchor = "start",
            const std::string& more = {});
  /// A marker with what it stands for; moves x to behind it.
  void legend(double& x, double y, const char* marker, const std::string& style,
              const std::string& words);
  std::string str() const;

 private:
  double width_, height_;
  std::string title_, body_;
};

/// Okabe and Ito's colours, told apart by people who see red and green alike; in this order they
/// also differ in lightness from one to the next.
inline constexpr std::array<const char*, 6> kSeriesColours{"#0072b2", "#e69f00", "#009e73",
                                                           "#d55e00", "#cc79a7", "#56b4e9"};
inline constexpr std::array<const char*, 6> kMarkers{
    "M-2 0a2 2 0 1 0 4 0a2 2 0 1 0-4 0z", "M-1.8-1.8h3.6v3.6h-3.6z", "M0-2.3l2.1 3.9h-4.2z",
    "M0-2.5l2.5 2.5-2.5 2.5-2.5-2.5z",    "M-2-2l4 4M2-2l-4 4",      "M0-2.5v5M-2.5 0h5"};

/// How the k-th series is drawn.
std::string marker_style(std::size_t k);

/// Round numbers that divide a range into at most `count` steps.
std::vector<double> round_ticks(double low, double high, int count = 5);
/// A tick's label, with the digits that the step needs.
std::string tick_label(double value, double step);
std::string escaped(std::string_view text);

struct Axis {
  std::string label;
  double low = 0, high = 1;
  bool has_ticks = true;
};

/// A panel with two linear axes; values are in the axes' units. Groups carry `class`, by which a
/// test finds them.
class Plot {
 public:
  /// The frame lies at (left, top) to (right, bottom) [pt]; labels are beside it.
  Plot(Svg& svg, double left, double top, double right, double bottom, Axis x, Axis y,
       const std::string& title = {});
  double x(double value) const;
  double y(double value) const;
  /// style: attributes, such as stroke="black".
  void line(const std::vector<double>& xs, const std::vector<double>& ys, const std::string& style);
  void band(const std::vector<double>& xs, const std::vector<double>& low,
            const std::vector<double>& high, const std::string& style);
  void marks(const std::string& name, const std::vector<double>& xs, const std::vector<double>& ys,
             const char* marker, const std::string& style);

 private:
  Svg& svg_;
  double left_, top_, right_, bottom_;
  Axis x_, y_;
};

}  // namespace palpate::tools
