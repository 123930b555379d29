#include "tools/workshop/bench/figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

namespace palpate::tools {
namespace {

constexpr double kWide = 760, kHigh = 440, kLeft = 80, kRight = 560, kTop = 44, kBottom = 384;

// Okabe and Ito's colours, told apart by people who see red and green alike; the darker blue is
// ours. From the eighth series on a colour comes with another mark.
constexpr std::string_view kOurColour = "#0072b2",
                           kOurMark = "M-6 0a6 6 0 1 0 12 0a6 6 0 1 0-12 0z";
constexpr std::string_view kColours[] = {"#8c8c8c", "#e69f00", "#009e73", "#d55e00",
                                         "#cc79a7", "#56b4e9", "#a6761d"};
constexpr std::string_view kMarks[] = {"M-5-5l5 3 5-3-3 5 3 5-5-3-5 3 3-5z",
                                       "M-4.5-4.5h9v9h-9z",
                                       "M0-5.5l5 9.5h-10z",
                                       "M0-6l6 6-6 6-6-6z",
                                       "M0 5.5l5-9.5h-10z",
                                       "M-5-2h3v-3h4v3h3v4h-3v3h-4v-3h-3z",
                                       "M-3-5h6l3 5-3 5h-6l-3-5z"};

std::string decade_label(double at) {
  return at < 1 ? fmt::format("{:g}", at) : fmt::format("{:.0f}", at);
}

struct Decades {
  double low = std::numeric_limits<double>::infinity(), high = 0;

  void take(double value) {
    if (!(value > 0) || !std::isfinite(value)) return;
    low = std::min(low, value), high = std::max(high, value);
  }
  void widen() {
    if (!(high > 0)) low = high = 1;
    low = std::pow(10, std::floor(std::log10(low)));
    high = std::pow(10, std::ceil(std::log10(high)));
    if (high <= low) high = 10 * low;
  }
  double share(double value) const {
    return std::clamp(std::log10(value / low) / std::log10(high / low), 0.0, 1.0);
  }
};

struct FigureDrawing {
  const LogFigure& figure;
  std::string_view ink, faint, paper;
  Decades x = {}, y = {};
  std::string svg = {};

  double px(double value) const { return kLeft + (kRight - kLeft) * x.share(value); }
  double py(double value) const { return kBottom - (kBottom - kTop) * y.share(value); }
  void text(double at_x, double at_y, std::string_view words, std::string_view anchor,
            std::string_view colour, std::string_view more = "") {
    svg +=
        fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" fill=\"{}\"{}>{}</text>\n",
                    at_x, at_y, anchor, colour, more, words);
  }
  void line(double x1, double y1, double x2, double y2, std::string_view colour,
            std::string_view more = "") {
    svg += fmt::format(
        "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\"{}/>\n", x1, y1,
        x2, y2, colour, more);
  }
};

void draw_axes(FigureDrawing& d) {
  const double half = 0.999;
  for (double at = d.x.low; at * half < d.x.high; at *= 10) {
    d.line(d.px(at), kTop, d.px(at), kBottom, d.faint);
    d.text(d.px(at), kBottom + 18, decade_label(at), "middle", d.ink);
  }
  for (double at = d.y.low; at * half < d.y.high; at *= 10) {
    d.line(kLeft, d.py(at), kRight, d.py(at), d.faint);
    d.text(kLeft - 8, d.py(at) + 4, decade_label(100 * at) + " %", "end", d.ink);
  }
  d.text(kLeft, kTop - 20, d.figure.title, "start", d.ink, " font-weight=\"bold\"");
  d.text((kLeft + kRight) / 2, kBottom + 42, d.figure.x_label, "middle", d.ink);
  d.text(14, (kTop + kBottom) / 2, d.figure.y_label, "middle", d.ink,
         fmt::format(" transform=\"rotate(-90 14 {:.0f})\"", (kTop + kBottom) / 2));
  for (const FigureLine& each : d.figure.upright) {
    d.line(d.px(each.at), kTop, d.px(each.at), kBottom, d.ink, " stroke-dasharray=\"5 4\"");
    d.text(d.px(each.at) - 5, kTop + 14, each.word, "end", d.ink);
  }
  for (const FigureLine& each : d.figure.level) {
    d.line(kLeft, d.py(each.at), kRight, d.py(each.at), d.ink, " stroke-dasharray=\"5 4\"");
    d.text(kRight - 5, d.py(each.at) - 5, each.word, "end", d.ink);
  }
}

void draw_series(FigureDrawing& d, std::size_t k) {
  const FigureSeries& series = d.figure.series[k];
  const std::size_t round = k / std::size(kColours);
  const std::string_view colour = series.is_ours ? kOurColour : kColours[k % std::size(kColours)];
  const std::string_view mark =
      series.is_ours ? kOurMark : kMarks[(k + 2 * round) % std::size(kMarks)];
  std::string way;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!(series.x[i] > 0) || !(series.median[i] > 0)) continue;
    const double x = d.px(series.x[i]), y = d.py(series.median[i]);
    way += fmt::format("{:.1f},{:.1f} ", x, y);
    if (series.p95[i] > series.median[i])
      d.line(x, y, x, d.py(series.p95[i]), colour, " stroke-opacity=\"0.6\"");
    d.svg += fmt::format(
        "<path class=\"mark\" transform=\"translate({:.1f} {:.1f})\" d=\"{}\" fill=\"{}\" "
        "stroke=\"{}\"/>\n",
        x, y, mark, colour, d.paper);
  }
  d.svg += fmt::format(
      "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\"/>\n", way, colour);
  const double at = kTop + 12 + 24 * static_cast<double>(k);
  d.svg += fmt::format("<path transform=\"translate({:.1f} {:.1f})\" d=\"{}\" fill=\"{}\"/>\n",
                       kRight + 24, at, mark, colour);
  d.text(kRight + 38, at + 4, series.name, "start", d.ink);
}

}  // namespace

std::string draw(const LogFigure& figure, bool is_dark) {
  FigureDrawing d{figure, is_dark ? "#e6e6e6" : "#1a1a1a", is_dark ? "#3a3a3a" : "#dddddd",
                  is_dark ? "#0d1117" : "#ffffff"};
  for (const FigureSeries& series : figure.series)
    for (std::size_t i = 0; i < series.x.size(); ++i)
      d.x.take(series.x[i]), d.y.take(series.median[i]), d.y.take(series.p95[i]);
  for (const FigureLine& each : figure.upright) d.x.take(each.at);
  for (const FigureLine& each : figure.level) d.y.take(each.at);
  d.x.widen(), d.y.widen();
  d.svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} "
      "{1}\" font-family=\"sans-serif\" font-size=\"12\" role=\"img\"><title>{2}</title>\n<rect "
      "width=\"{0}\" height=\"{1}\" fill=\"{3}\"/>\n",
      kWide, kHigh, figure.title, d.paper);
  draw_axes(d);
  for (std::size_t k = 0; k < figure.series.size(); ++k) draw_series(d, k);
  return d.svg + "</svg>\n";
}

}  // namespace palpate::tools
