// closed_paths PATHS SEED [ASSET...]: so many random closed ways of a ball of the probe's radius
// and of one of 4 mm over assets, a box, a groove and rough spheres, in moves of 20 to 100 um. Of
// each it says the largest change of the force in a move of 50 um, at an edge between triangles and
// elsewhere, contacts lost over measured triangles, and the least work of a way over what it moved.
// Exits with 1 where a way gives work.

#include <cstdio>
#include <cstdlib>
#include <string>

#include "libfit/assets/asset_file.hpp"
#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

using runtime::AssetView;
using runtime::Vec3d;

constexpr double kTick_m = 5e-5;  // 50 mm/s at 1 kHz

struct Figures {
  long paths = 0, moves = 0, lost = 0, held = 0;
  double edge_N = 0, inside_N = 0, touch_N = 0, release_N = 0;  // in a move of kTick_m
  double least_J = 0;                                           // of a way, over what it moved
};

class Path {
 public:
  Path(const AssetView& asset, double radius_m, double step_m, Figures& out)
      : asset_(asset), radius_m_(radius_m), step_m_(step_m), out_(out) {
    ++out.paths;
  }
  void go(const Vec3d& to) {
    const Vec3d from = x_, way = to - from;
    const double length = std::sqrt(dot(way, way));
    const int steps = has_begun_ ? std::max(1, static_cast<int>(length / step_m_)) : 1;
    for (int i = 1; i <= steps; ++i)
      move(has_begun_ ? from + way * (double(i) / steps) : to, length / steps);
  }
  void end() {
    const double work_J = before_.stored_J + before_.dissipated_J;
    if (moved_J_ > 0) out_.least_J = std::min(out_.least_J, work_J / moved_J_);
  }

 private:
  void move(const Vec3d& x, double step_m) {
    double at[3];
    runtime::put(x_ = x, at);
    Output now;
    touch_ball(asset_, contact_, at, radius_m_, now);
    if (has_begun_) compare(now, kTick_m / std::max(step_m, kTick_m));
    has_begun_ = true;
    before_ = now;
  }
  void compare(const Output& now, double share) {
    ++out_.moves;
    moved_J_ +=
        std::fabs(now.stored_J + now.dissipated_J - before_.stored_J - before_.dissipated_J);
    const bool was = before_.state != ContactState::air, is = now.state != ContactState::air;
    if (!was && !is) return;
    const Vec3d step = runtime::make_vec3<double>(now.force_on_tool_N) -
                       runtime::make_vec3<double>(before_.force_on_tool_N);
    const double jump_N = std::sqrt(dot(step, step)) * share;
    double& most = !was                               ? out_.touch_N
                   : !is                              ? out_.release_N
                   : now.triangle != before_.triangle ? out_.edge_N
                                                      : out_.inside_N;
    most = std::max(most, jump_N);
    out_.held += (now.flags & runtime::kFlagHeldBack) != 0;
    // A contact that stood deep over measured triangles may not end in a move.
    out_.lost += was && !is && before_.normal_m > 4 * kTick_m &&
                 (before_.flags & (runtime::kFlagOutside | runtime::kFlagBlocked)) == 0;
  }

  const AssetView& asset_;
  double radius_m_, step_m_;
  Figures& out_;
  Contact contact_;
  Output before_;
  Vec3d x_{0, 0, 0};
  double moved_J_ = 0;
  bool has_begun_ = false;
};

Figures walk(const AssetView& asset, double radius_m, int paths, unsigned seed) {
  std::mt19937_64 random(seed);
  const auto unit = [&] { return double(random() >> 11) * 0x1p-53; };
  std::vector<int> measured;
  for (int v = 0; v < asset.vertices; ++v)
    if (asset.covered[v] == runtime::kMeasured) measured.push_back(v);
  Figures out;
  for (int i = 0; i < paths; ++i) {
    const int v = measured[static_cast<std::size_t>(unit() * double(measured.size()))];
    const Vec3d u = asset.normal_at(v),
                p = asset.vertex_at(v) + runtime::make_vec3<double>(asset.origin_m) - u * radius_m;
    const double depth_m = std::min(asset.max_fitted_m, 0.007);
    Path path(asset, radius_m, 2e-5 * std::pow(5, unit()), out);
    const Vec3d air = p - u * 0.002;
    path.go(air);
    for (int leg = 0; leg < 5; ++leg) {
      const Vec3d side{unit() - 0.5, unit() - 0.5, unit() - 0.5};
      path.go(p + runtime::tangential(side, u) * (2 * depth_m) +
              u * (depth_m * (1.1 * unit() - 0.05)));
    }
    path.go(air);
    path.end();
  }
  return out;
}

Model rough_sphere(unsigned seed, double height_m) {
  Model model = sphere_model(0.03, 24, uniform(400, 300, 0.3));
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(-1, 1);
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v)
    model.surface.vertices.row(v) *= 1 + height_m / 0.03 * draw(random);
  make_rings(model, 1, 0.03, [](const Vec3&) { return 1.0; });
  return model;
}
Model groove() {
  Model model = plate_model(0.04, 40, uniform(400, 300, 0.3));
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v) {
    const double x = model.surface.vertices(v, 0), side = std::abs(x) < 1e-6 ? 0 : x > 0 ? 1 : -1;
    model.surface.vertices(v, 2) = std::tan(std::numbers::pi / 6) * std::abs(x);
    model.inward_normal.row(v) = Vec3(0.5 * side, 0, side == 0 ? -1 : -std::sqrt(0.75)).transpose();
  }
  make_rings(model, 1, 0, [](const Vec3&) { return 1.0; });
  return model;
}
Model box() {
  Model model = box_model(0.03, 12, uniform(400, 300, 0.3));
  make_rings(model, 1, 0, [](const Vec3&) { return 1.0; });
  return model;
}

bool report(const std::string& name, const AssetView& asset, int paths, unsigned seed) {
  bool is_good = true;
  for (const double radius_m : {asset.probe_radius_m, 0.004}) {
    const Figures f = walk(asset, radius_m, paths, seed);
    std::printf(
        "%-16s %4.1f mm: %5ld ways, %7ld moves, %5ld held back, %ld lost; N in 50 um: edge %.4f, "
        "inside %.4f, touch %.4f, release %.4f; least work %.2g\n",
        name.c_str(), 1e3 * radius_m, f.paths, f.moves, f.held, f.lost, f.edge_N, f.inside_N,
        f.touch_N, f.release_N, f.least_J);
    is_good = is_good && f.least_J >= -1e-12;
  }
  return is_good;
}

int run(int paths, unsigned seed, const std::vector<std::string>& files) {
  bool is_good = true;
  for (const std::string& path : files) {
    const AssetFile file = read_asset_file(path);
    is_good &= report(path.substr(path.rfind('/') + 1), file.asset(), paths, seed);
  }
  const auto of = [&](const std::string& name, const Model& model) {
    const Loaded body = load(model);
    is_good &= report(name, body.asset, paths, seed);
  };
  of("box", box());
  of("groove", groove());
  for (const double height_m : {0.0001, 0.0003, 0.001})
    of("rough " + std::to_string(height_m * 1e3).substr(0, 3) + " mm",
       rough_sphere(seed, height_m));
  return is_good ? 0 : 1;
}

}  // namespace
}  // namespace palpate::test

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  return palpate::test::run(std::atoi(argv[1]),
                            static_cast<unsigned>(std::strtoul(argv[2], nullptr, 10)),
                            std::vector<std::string>(argv + 3, argv + argc));
}
