#include "tools/report/svg_plot.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace palpate::tools {
namespace {

constexpr double kTick_pt = 3;

std::string points_of(const std::string& element, const std::vector<std::array<double, 2>>& points,
                      const std::string& style) {
  std::string list;
  for (const auto& [x, y] : points)
    if (std::isfinite(x) && std::isfinite(y)) list += fmt::format("{:.2f},{:.2f} ", x, y);
  return fmt::format("<{} points=\"{}\" {}/>", element, list, style);
}

}  // namespace

Svg::Svg(double width_pt, double height_pt, const std::string& title)
    : width_(width_pt), height_(height_pt), title_(escaped(title)) {}

void Svg::text(double x, double y, const std::string& words, std::string_view anchor,
               const std::string& more) {
  add(fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"{}\"{}>{}</text>", x, y, anchor,
                  more, escaped(words)));
}

void Svg::legend(double& x, double y, const char* marker, const std::string& style,
                 const std::string& words) {
  add(fmt::format("<path transform=\"translate({:.2f} {:.2f})\" d=\"{}\" {}/>", x + 6, y - 2.8,
                  marker, style));
  text(x + 17, y, words);
  x += 30 + 4.2 * static_cast<double>(words.size());
}

std::string Svg::str() const {
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- palpate -->\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}pt\" height=\"{1}pt\" "
      "viewBox=\"0 0 {0} {1}\" role=\"img\" font-family=\"Helvetica, Arial, sans-serif\" "
      "font-size=\"8\" fill=\"black\">\n<title>{2}</title>\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n{3}</svg>\n",
      width_, height_, title_, body_);
}

std::string marker_style(std::size_t k) {
  return fmt::format("fill=\"{0}\" stroke=\"{0}\" stroke-width=\"0.9\" fill-opacity=\"0.75\"",
                     kSeriesColours[k % kSeriesColours.size()]);
}

std::vector<double> round_ticks(double low, double high, int count) {
  const double rough = (high - low) / count;
  if (!(rough > 0)) return {low};
  const double power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double s : {5.0, 2.0, 1.0})
    if (s * power >= rough * (1 - 1e-9)) step = s * power;
  std::vector<double> ticks;
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k)
    ticks.push_back(k == 0 ? 0 : k * step);
  return ticks;
}

std::string tick_label(double value, double step) {
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  return fmt::format("{:.{}f}", value, decimals);
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text)
    out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  return out;
}

Plot::Plot(Svg& svg, double left, double top, double right, double bottom, Axis x, Axis y,
           const std::string& title)
    : svg_(svg), left_(left), top_(top), right_(right), bottom_(bottom), x_(x), y_(y) {
  svg.add("<g class=\"axes\" stroke=\"black\" stroke-width=\"0.6\" fill=\"none\">");
  const auto ticks_of = [](const Axis& axis) {
    return axis.has_ticks ? round_ticks(axis.low, axis.high) : std::vector<double>{};
  };
  const auto xs = ticks_of(x), ys = ticks_of(y);
  std::string ticks = fmt::format("M{:.2f} {:.2f}V{:.2f}H{:.2f}", left, top, bottom, right);
  for (const double v : xs) ticks += fmt::format("M{:.2f} {:.2f}v{}", this->x(v), bottom, kTick_pt);
  for (const double v : ys) ticks += fmt::format("M{:.2f} {:.2f}h{}", left, this->y(v), -kTick_pt);
  svg.add("<path d=\"" + ticks + "\"/></g>");
  const auto step = [](const std::vector<double>& all) {
    return all.size() > 1 ? all[1] - all[0] : 1.0;
  };
  for (const double v : xs)
    svg.text(this->x(v), bottom + kTick_pt + 8, tick_label(v, step(xs)), "middle", " class=\"x\"");
  double widest = 0;
  for (const double v : ys) {
    const std::string label = tick_label(v, step(ys));
    widest = std::max(widest, 4.5 * static_cast<double>(label.size()));
    svg.text(left - kTick_pt - 2, this->y(v) + 2.8, label, "end", " class=\"y\"");
  }
  svg.text((left + right) / 2, bottom + kTick_pt + 19, x.label, "middle");
  const double at = left - kTick_pt - widest - 7, middle = (top + bottom) / 2;
  svg.text(at, middle, y.label, "middle",
           fmt::format(" transform=\"rotate(-90 {:.2f} {:.2f})\"", at, middle));
  if (!title.empty()) svg.text(left, top - 5, title, "start", " font-weight=\"bold\"");
}

double Plot::x(double value) const {
  return left_ + (value - x_.low) / (x_.high - x_.low) * (right_ - left_);
}
double Plot::y(double value) const {
  return bottom_ - (value - y_.low) / (y_.high - y_.low) * (bottom_ - top_);
}

void Plot::line(const std::vector<double>& xs, const std::vector<double>& ys,
                const std::string& style) {
  std::vector<std::array<double, 2>> points;
  for (std::size_t i = 0; i < xs.size(); ++i) points.push_back({x(xs[i]), y(ys[i])});
  svg_.add(points_of("polyline", points, "fill=\"none\" " + style));
}

void Plot::band(const std::vector<double>& xs, const std::vector<double>& low,
                const std::vector<double>& high, const std::string& style) {
  std::vector<std::array<double, 2>> points;
  for (std::size_t i = 0; i < xs.size(); ++i) points.push_back({x(xs[i]), y(high[i])});
  for (std::size_t i = xs.size(); i-- > 0;) points.push_back({x(xs[i]), y(low[i])});
  svg_.add(points_of("polygon", points, style));
}

void Plot::marks(const std::string& name, const std::vector<double>& xs,
                 const std::vector<double>& ys, const char* marker, const std::string& style) {
  svg_.add(fmt::format("<g class=\"{}\" {}>", escaped(name), style));
  for (std::size_t i = 0; i < xs.size(); ++i)
    if (std::isfinite(xs[i]) && std::isfinite(ys[i]))
      svg_.add(fmt::format("<path transform=\"translate({:.2f} {:.2f})\" d=\"{}\"/>", x(xs[i]),
                           y(ys[i]), marker));
  svg_.add("</g>");
}

}  // namespace palpate::tools
