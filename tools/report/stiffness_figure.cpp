#include <fmt/core.h>

#include <Eigen/Dense>
#include <numeric>

#include "libfit/assets/stiffness_map.hpp"
#include "tools/report/figure_parts.hpp"

namespace palpate::tools {
namespace {

constexpr double kSize_pt = 300, kLeft_pt = 10, kTop_pt = 14;

/// Orthographic: right, up, and towards who looks.
struct View {
  Eigen::Matrix3d axes;
  Eigen::Vector2d middle;  ///< [m]
  double scale = 1;        ///< pt/m
  Eigen::Vector3d seen(const Eigen::RowVector3d& place) const { return axes * place.transpose(); }
  double x(const Eigen::Vector3d& p) const {
    return kLeft_pt + kSize_pt / 2 + scale * (p.x() - middle.x());
  }
  double y(const Eigen::Vector3d& p) const {
    return kTop_pt + kSize_pt / 2 - scale * (p.y() - middle.y());
  }
};

// Along the test points' mean inward normal, z up, or y where one looks along z.
View view_of(const Rows& inward, const Rows& vertices, const std::vector<std::int32_t>& covered) {
  View view;
  const Eigen::Vector3d towards = -inward.colwise().mean().transpose().normalized();
  const Eigen::Vector3d up =
      std::abs(towards.z()) < 0.8 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d right = up.cross(towards).normalized();
  view.axes << right.transpose(), towards.cross(right).transpose(), towards.transpose();
  Eigen::AlignedBox2d box;
  for (const std::int32_t v : covered) box.extend(view.seen(vertices.row(v)).head<2>().eval());
  view.middle = box.center();
  view.scale = kSize_pt / (1.15 * box.sizes().maxCoeff());
  return view;
}

std::string hex(const Rgb& c) { return fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]); }

struct Map {
  Numbers stiffness_N_m;  ///< by vertex, NaN where not covered
  double low = 1e300, high = 0, depth_m = 0;
};

Map map_of(const Json& maps, Eigen::Index vertices) {
  Map map;
  const auto covered = unpacked<std::int32_t>(maps["vertices"]);
  const auto depths = maps["depths_m"].get<Numbers>();
  const Numbers values = numbers(maps["stiffness_N_m"]);
  const std::size_t row = (depths.size() - 1) / 2;  // the middle of the range
  map.depth_m = depths[row];
  map.stiffness_N_m.assign(static_cast<std::size_t>(vertices), std::nan(""));
  for (std::size_t i = 0; i < covered.size(); ++i) {
    const double value = values[row * covered.size() + i];
    map.stiffness_N_m[static_cast<std::size_t>(covered[i])] = value;
    map.low = std::min(map.low, value);
    map.high = std::max(map.high, value);
  }
  return map;
}

// Triangles that face the viewer, far ones first. Grey is shaded, so that its form is seen.
void draw_body(Svg& svg, const View& view, const Map& map, const Rows& vertices,
               const std::vector<std::int32_t>& corner) {
  std::vector<std::pair<double, std::string>> drawn;
  for (std::size_t t = 0; t < corner.size(); t += 3) {
    Eigen::Vector3d p[3];
    double mean = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] = view.seen(vertices.row(corner[t + k]));
      mean += map.stiffness_N_m[static_cast<std::size_t>(corner[t + k])] / 3;
    }
    const Eigen::Vector3d n = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    if (!(n.z() > 0)) continue;
    const auto grey = static_cast<std::uint8_t>(120 + 90 * n.z());
    const std::string colour =
        hex(std::isfinite(mean) ? viridis((mean - map.low) / std::max(map.high - map.low, 1e-300))
                                : Rgb{grey, grey, grey});
    std::string d;
    for (int k = 0; k < 3; ++k)
      d += fmt::format("{}{:.1f} {:.1f}", k ? "L" : "M", view.x(p[k]), view.y(p[k]));
    drawn.emplace_back(p[0].z() + p[1].z() + p[2].z(),
                       fmt::format("<path d=\"{0}z\" fill=\"{1}\" stroke=\"{1}\"/>", d, colour));
  }
  std::stable_sort(drawn.begin(), drawn.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  svg.add("<g class=\"body\" stroke-width=\"0.4\" stroke-linejoin=\"round\">");
  for (const auto& [depth, element] : drawn) svg.add(element);
  svg.add("</g>");
}

void draw_points(Svg& svg, const View& view, const Json& contents, const Rows& inward) {
  const Rows places = rows(contents["points"]["position_m"]);
  svg.add("<g class=\"test-points\" fill=\"white\" stroke=\"black\" stroke-width=\"0.7\">");
  for (Eigen::Index p = 0; p < places.rows(); ++p) {
    if (view.seen(inward.row(p)).z() > -0.1) continue;  // on the far side
    const Eigen::Vector3d at = view.seen(places.row(p));
    svg.add(fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"1.7\"/>", view.x(at), view.y(at)));
  }
  svg.add("</g>");
}

void draw_scales(Svg& svg, const View& view, const Map& map) {
  const double left = kLeft_pt + kSize_pt + 22, top = kTop_pt + 40, height = kSize_pt - 110;
  constexpr int kSteps = 64;
  svg.text(left - 8, top - 24, "normal stiffness [N/m]");
  svg.text(left - 8, top - 13, fmt::format("at a depth of {:.1f} mm", map.depth_m * 1e3));
  for (int i = 0; i < kSteps; ++i)
    svg.add(
        fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"12\" height=\"{:.2f}\" fill=\"{}\"/>",
                    left, top + height * (1 - (i + 1.0) / kSteps), height / kSteps + 0.2,
                    hex(viridis((i + 0.5) / kSteps))));
  svg.add(
      fmt::format("<rect x=\"{}\" y=\"{}\" width=\"12\" height=\"{}\" fill=\"none\" "
                  "stroke=\"black\" stroke-width=\"0.6\"/>",
                  left, top, height));
  const Numbers ticks = round_ticks(map.low, map.high);
  for (const double v : ticks) {
    const double y = top + height * (1 - (v - map.low) / (map.high - map.low));
    svg.add(fmt::format("<path d=\"M{:.2f} {:.2f}h3\" stroke=\"black\" stroke-width=\"0.6\"/>",
                        left + 12, y));
    svg.text(left + 17, y + 2.8, tick_label(v, ticks.size() > 1 ? ticks[1] - ticks[0] : 1), "start",
             " class=\"bar\"");
  }
  double x = left - 8, y = top + height + 18;
  svg.legend(x, y, "M-5-3.5h10v7h-10z", "fill=\"#c4c4c4\"", "not measured");
  x = left - 8;
  svg.legend(x, y + 13, "M-1.7 0a1.7 1.7 0 1 0 3.4 0a1.7 1.7 0 1 0-3.4 0z",
             "fill=\"white\" stroke=\"black\" stroke-width=\"0.7\"", "test point");
  // A round length, a sixth to a third of the view.
  const double length_m = round_ticks(0, kSize_pt / view.scale / 3, 2).at(1);
  const double end = kLeft_pt + 4 + length_m * view.scale, base = kTop_pt + kSize_pt + 14;
  svg.add(
      fmt::format("<path class=\"scale\" d=\"M{:.2f} {:.2f}H{:.2f}\" stroke=\"black\" "
                  "stroke-width=\"2\"/>",
                  kLeft_pt + 4, base, end));
  svg.text(end + 5, base + 2.8, fmt::format("{:g} mm", length_m * 1e3));
}

}  // namespace

std::string stiffness_svg(const Json& contents) {
  const Rows vertices = rows(contents["surface"]["vertices_m"]),
             inward = rows(contents["points"]["inward_normal"]);
  const auto corner = unpacked<std::int32_t>(contents["surface"]["triangles"]);
  const Map map = map_of(contents["maps"], vertices.rows());
  const View view = view_of(inward, vertices, unpacked<std::int32_t>(contents["maps"]["vertices"]));
  Svg svg(kSize_pt + 120, kSize_pt + 38,
          "Normal stiffness of " + contents["name"].get<std::string>() +
              ", seen along the mean normal of its test points");
  svg.add(
      fmt::format("<clipPath id=\"view\"><rect x=\"{0}\" y=\"{1}\" width=\"{2}\" "
                  "height=\"{2}\"/></clipPath><g clip-path=\"url(#view)\">",
                  kLeft_pt, kTop_pt, kSize_pt));
  draw_body(svg, view, map, vertices, corner);
  draw_points(svg, view, contents, inward);
  svg.add("</g>");
  draw_scales(svg, view, map);
  return svg.str();
}

}  // namespace palpate::tools
