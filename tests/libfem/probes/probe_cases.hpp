#pragma once

#include <cmath>
#include <functional>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "libfem/probes/probes.hpp"
#include "solids.hpp"

namespace palpate::fem {

inline Vec3 random_unit(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vec3(normal(random), normal(random), normal(random)).normalized();
}

/// A probe of the shared suite, pressing along +z.
/// surface: a seeded point of its surface, as an offset from the reference point, from a
/// description of the shape that owes nothing to its signed distance. spacing_m: how far apart
/// 40000 such points lie at most, roughly. thin_m: the surface's least radius of curvature or
/// half-thickness.
struct ProbeCase {
  std::string name;
  ProbeSpec spec;
  double thin_m, spacing_m;
  std::function<Vec3(std::mt19937&)> surface;
};
inline void PrintTo(const ProbeCase& probe, std::ostream* out) { *out << probe.name; }

inline ProbeSpec spec_of(const std::string& shape,
                         std::map<std::string, std::vector<double>, std::less<>> values) {
  ProbeSpec spec;
  spec.shape = shape;
  spec.values = std::move(values);
  return spec;
}

/// Points of a surface of revolution: profile(s), s in [0, 1], gives distance from the axis and
/// height.
inline std::function<Vec3(std::mt19937&)> revolved(
    std::function<std::pair<double, double>(double)> profile) {
  return [profile](std::mt19937& random) {
    std::uniform_real_distribution<double> share(0, 1);
    const auto [away, height] = profile(share(random));
    const double angle = 6.283185307179586 * share(random);
    return Vec3(away * std::cos(angle), away * std::sin(angle), -height);
  };
}

inline ProbeCase flat_case(const std::string& name, double radius, double edge) {
  return {name, spec_of("flat", {{"radius", {radius}}, {"edge_radius", {edge}}}), edge,
          0.2 * radius, revolved([=](double s) -> std::pair<double, double> {
            const double core = radius - edge, quarter = 1.5707963267948966;
            if (s < 0.3) return {core * std::sqrt(s / 0.3), 0};
            if (s < 0.6) {
              const double angle = (s - 0.3) / 0.3 * quarter;
              return {core + edge * std::sin(angle), edge - edge * std::cos(angle)};
            }
            return {radius, edge + (s - 0.6) / 0.4 * 5 * radius};
          })};
}

inline ProbeCase cone_case(const std::string& name, double half_angle_deg, double tip) {
  const double alpha = half_angle_deg * 3.14159265358979323846 / 180;
  return {name, spec_of("cone", {{"half_angle", {alpha}}, {"tip_radius", {tip}}}), tip, 1.0 * tip,
          revolved([=](double s) -> std::pair<double, double> {
            const double joint = 1.5707963267948966 - alpha;  // angle at the ball's centre
            if (s < 0.3)
              return {tip * std::sin(s / 0.3 * joint), tip - tip * std::cos(s / 0.3 * joint)};
            const double up = std::pow((s - 0.3) / 0.7, 2) * 10 * tip;
            return {tip * std::cos(alpha) + up * std::sin(alpha),
                    tip - tip * std::sin(alpha) + up * std::cos(alpha)};
          })};
}

/// own: random surface point in own axes. touch: reference point there. turn: own axes to (x, y,
/// z).
inline std::function<Vec3(std::mt19937&)> placed(std::function<Vec3(std::mt19937&)> own,
                                                 const Vec3& touch,
                                                 const Mat3& turn = Mat3::Identity()) {
  return [=](std::mt19937& random) { return Vec3(turn * (own(random) - touch)); };
}

inline std::function<Vec3(std::mt19937&)> capsule_points(double radius, double length) {
  return [=](std::mt19937& random) {
    std::uniform_real_distribution<double> share(0, 1);
    const double half = length / 2 - radius;
    const Vec3 unit = random_unit(random);
    if (share(random) < 0.5)
      return Vec3(radius * unit + std::copysign(half, unit.z()) * Vec3::UnitZ());
    const double angle = 6.283185307179586 * share(random);
    return Vec3(radius * std::cos(angle), radius * std::sin(angle), half * (2 * share(random) - 1));
  };
}

inline std::vector<ProbeCase> probe_cases() {
  std::vector<ProbeCase> cases;
  cases.push_back({"sphere", sphere_spec(0.008), 0.008, 0.1 * 0.008,
                   placed([](std::mt19937& random) { return Vec3(0.008 * random_unit(random)); },
                          Vec3(0, 0, 0.008))});
  cases.push_back(flat_case("flat", 0.006, 0.0006));
  cases.push_back(flat_case("flat_round_end", 0.006, 0.006));
  cases.push_back(flat_case("flat_sharp", 0.006, 0.02 * 0.006));
  cases.push_back(cone_case("cone_needle", 15, 0.001));
  cases.push_back(cone_case("cone_blunt", 80, 0.002));

  const double R = 0.004, L = 0.02;
  ProbeSpec capsule = spec_of("capsule", {{"radius", {R}}, {"length", {L}}});
  cases.push_back(
      {"capsule_upright", capsule, R, 0.1 * L, placed(capsule_points(R, L), Vec3(0, 0, L / 2))});
  capsule.orientation = Vec3::UnitX();
  Mat3 turn;  // own x to z (into the body), own z to x
  turn.col(0) = Vec3::UnitZ();
  turn.col(2) = Vec3::UnitX();
  turn.col(1) = turn.col(2).cross(turn.col(0));
  cases.push_back(
      {"capsule_lying", capsule, R, 0.1 * L, placed(capsule_points(R, L), Vec3(R, 0, 0), turn)});
  capsule.orientation = Vec3(1, 0, 1);
  const double h = std::sqrt(0.5);  // own (1,0,1)/sqrt 2 to z, own z leans to x
  turn.col(2) = Vec3(h, 0, h);
  turn.col(0) = Vec3(-h, 0, h);
  turn.col(1) = Vec3(0, 1, 0);
  turn.col(1) = turn.col(2).cross(turn.col(0));
  cases.push_back({"capsule_tilted", capsule, R, 0.1 * L,
                   placed(capsule_points(R, L), Vec3(R * h, 0, L / 2 - R + R * h), turn)});

  ProbeSpec mesh;
  mesh.shape = "mesh";
  mesh.mesh = ball_mesh(0.008, 4);
  mesh.values["smoothing"] = {0.0005};
  cases.push_back({"mesh_of_a_ball", mesh, 0.008, 0.1 * 0.008,
                   placed([](std::mt19937& random) { return Vec3(0.008 * random_unit(random)); },
                          Vec3(0, 0, -0.008), Vec3(1, -1, -1).asDiagonal())});
  return cases;
}

}  // namespace palpate::fem
