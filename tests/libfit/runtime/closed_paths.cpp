// closed_paths PATHS SEED [ASSET...]: so many random closed ways of a ball of the probe's radius
// and of one of 4 mm over assets, a box, a groove and rough spheres, in moves of 20 to 100 um, 500
// times as many moves of 20 um, and slides of 16 mm over the rim of the measured region, 5 and 7 mm
// deep. Prints the largest changes of the force, what became of contacts, and forces above a limit:
//   slid off  a contact that was 0.2 mm deep ended in one move
//   lost      a tool that had let go sinks on by 0.2 mm below the surface on which it rests
//   friction  lateral force above what friction bears; range: normal force above that at the end of
//             the fitted depths, not EXTRAPOLATED; beside: not measured, not OUTSIDE; cap: shown
//             above the device's cap of half of the force, or not CAPPED
// Exits with 1 where a way gives work, what is stored and the tank rise in a tick without work, a
// force changes by more than twice as much at an edge, touch or release as within a triangle, a
// limit is passed, or, where the ball fits into the body's hollows, a contact is lost or a ball
// stands in the surface without INSIDE.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "libfit/assets/asset_file.hpp"
#include "tests/libfit/runtime/limits.hpp"
#include "tests/libfit/runtime/models.hpp"
#include "tests/libfit/runtime/outside_work.hpp"
#include "tests/libfit/runtime/standing.hpp"

namespace palpate::test {
namespace {

using runtime::AssetView;
using runtime::Vec3d;

constexpr double kTick_m = 5e-5, kSmall_m = 2e-5;  // 50 and 20 mm/s at 1 kHz
constexpr double kSinks_m = 4 * kTick_m;           // of a tool that nothing answers
constexpr double kRounding = 1e-6;
constexpr double kSettles_N = 1e-3;  // a body that sways settles once more after its slips
constexpr double kShare_N =
    2e-4;  // limits are times a share of before the slide (B3a); 1.3e-4 seen

struct Jumps {
  double edge_N = 0, inside_N = 0, touch_N = 0, release_N = 0, slide_in_N = 0;
};
struct Figures {
  long ways = 0, moves = 0, small = 0, in_contact = 0, held = 0;
  Jumps by_tick, by_small;
  long slid_off = 0, back_at_once = 0, lost = 0, inside = 0, unflagged_inside = 0;
  long above_friction = 0, above_range = 0, above_cap = 0, beside = 0;  // without a flag
  long blocked = 0, extrapolated = 0, outside = 0, capped = 0;          // flags
  long risen = 0;                   // ticks after which more is stored and in the tank than work
  double most_above_N = 0;          // of the lateral force over what friction bears
  double least_work[kLevels] = {};  // of a way over what was put in, in so many times the ticks
};

bool has_rings(const AssetView& asset) {
  return asset.curves.family == int(runtime::Family::rings);
}

// A tool on its ways over an asset.
class Path {
 public:
  Path(const AssetView& asset, double radius_m, double cap_N, Figures& out, int level = 0)
      : asset_(asset), out_(out), level_(level) {
    tool_.shape.ball[0].radius_m = radius_m;
    tool_.shape.max_force_N = cap_N;
    ++out.ways;
  }
  void go(const Vec3d& to, double step_m, bool slides_in = false) {
    const Vec3d from = x_, way = to - from;
    const double length = std::sqrt(dot(way, way));
    const int steps =
        has_begun_ ? kFiner[level_] * std::max(1, static_cast<int>(length / step_m)) : 1;
    slides_in_ = slides_in;
    for (int i = 1; i <= steps; ++i)
      move(has_begun_ ? from + way * (double(i) / steps) : to, length / steps);
  }
  void end() {
    double& least = out_.least_work[level_];
    least = std::min(least, work_.share());
  }

 private:
  void move(const Vec3d& x, double step_m) {
    const Vec3d step = has_begun_ ? x - x_ : Vec3d{0, 0, 0};
    x_ = x;
    const double at[3] = {x.x, x.y, x.z}, dt_s = 1e-3 / kFiner[level_];
    Output now;
    touch_ball(asset_, contact_, at, radius_m(), now, nullptr, dt_s);
    work_.add(runtime::make_vec3<double>(now.force_on_tool_N), step);
    if (level_ > 0) {
      has_begun_ = true;
      return;
    }
    if (has_begun_) compare(now, step_m);
    look_at_ledger(now);
    has_begun_ = true;
    if (now.state == ContactState::air)
      look_into_surface(now);
    else
      look_at_limits(now);
    look_at_cap(now, dt_s);
    before_ = now;
  }
  void compare(const Output& now, double step_m) {
    ++out_.moves;
    out_.small += step_m <= kSmall_m;
    const bool was = before_.state != ContactState::air, is = now.state != ContactState::air;
    if (!was && !is) return;
    const Vec3d step = runtime::make_vec3<double>(now.force_on_tool_N) -
                       runtime::make_vec3<double>(before_.force_on_tool_N);
    const double jump_N = std::sqrt(dot(step, step));
    const auto note = [&](Jumps& jumps, double share) {
      double& most = !was                               ? jumps.touch_N
                     : !is                              ? jumps.release_N
                     : slides_in_                       ? jumps.slide_in_N
                     : now.triangle != before_.triangle ? jumps.edge_N
                                                        : jumps.inside_N;
      most = std::max(most, jump_N * share);
    };
    if (step_m <= kSmall_m)
      note(out_.by_small, 1);
    else
      note(out_.by_tick, kTick_m / std::max(step_m, kTick_m));
    out_.held += (now.flags & PALPATE_FLAG_HELD_BACK) != 0;
    if (was && !is) {
      is_watched_ = (before_.flags & PALPATE_FLAG_OUTSIDE) == 0;
      was_deep_ = is_watched_ && before_.normal_m > kSinks_m;
      out_.slid_off += was_deep_;
      least_m_ = 1;
      ticks_out_ = 0;
    } else if (is_watched_) {
      out_.back_at_once += was_deep_ && ticks_out_ <= 1;
      is_watched_ = false;
    }
  }
  // After a release: whether the tool sinks into the surface and nothing answers.
  void look_into_surface(const Output& now) {
    out_.inside += (now.flags & PALPATE_FLAG_INSIDE) != 0;
    if (!is_watched_) return;
    ++ticks_out_;
    const double depth_m = depth_in_surface_m(asset_, place(), radius_m());
    is_watched_ = depth_m > 0;
    if (!is_watched_) return;  // it has come out
    out_.unflagged_inside += ticks_out_ > 1 && depth_m > kSinks_m && radius_m() > 0 &&
                             (now.flags & PALPATE_FLAG_INSIDE) == 0;
    least_m_ = std::min(least_m_, depth_m);
    if (depth_m < least_m_ + kSinks_m) return;
    ++out_.lost;
    is_watched_ = false;
  }
  void look_at_ledger(const Output& now) {
    const double lost_J = now.dissipated_J - contact_.ledger.tank_J;
    most_J_ = std::max(most_J_, now.stored_J);
    const double rounding_J = 1e-18 + 1e-11 * most_J_ + 1e-14 * std::fabs(lost_J);
    out_.risen += !(lost_J >= lost_J_ - rounding_J);
    lost_J_ = lost_J;
  }
  void look_at_limits(const Output& now) {
    ++out_.in_contact;
    const auto has = [&](unsigned flag) { return (now.flags & flag) != 0; };
    out_.blocked += has(PALPATE_FLAG_BLOCKED);
    out_.extrapolated += has(PALPATE_FLAG_EXTRAPOLATED);
    out_.outside += has(PALPATE_FLAG_OUTSIDE);
    bool is_measured = true;
    for (int k = 0; k < 3; ++k)
      is_measured &= asset_.covered[asset_.corner(now.triangle, k)] == runtime::kMeasured;
    out_.beside += !is_measured && !has(PALPATE_FLAG_OUTSIDE);
    const Vec3d force = runtime::make_vec3<double>(now.force_on_tool_N) * -1.0,
                u = runtime::make_vec3<double>(now.normal), aside = tangential(force, u);
    const Limits most = limits_of(asset_, now);
    const double lateral_N = std::sqrt(dot(aside, aside)), noise = 1 + kRounding;
    out_.above_friction += lateral_N > most.lateral_N * noise + (asset_.sways        ? kSettles_N
                                                                 : has_rings(asset_) ? kShare_N
                                                                                     : kRounding);
    out_.most_above_N = std::max(out_.most_above_N, lateral_N - most.lateral_N);
    out_.above_range += dot(force, u) > most.normal_N * noise && !has(PALPATE_FLAG_EXTRAPOLATED);
  }
  // The same ball as a tool with a cap.
  void look_at_cap(const Output& now, double dt_s) {
    runtime::ToolInput in;
    runtime::ToolOutput tick;
    runtime::put(x_, in.pose.position_m);
    in.dt_s = dt_s;
    runtime::Tool* const only = &tool_;
    Status status;
    touch_tools(asset_, &only, &in, &tick, &status, 1);
    const bool is_capped = (tick.flags & PALPATE_FLAG_CAPPED) != 0;
    const Vec3d force = runtime::make_vec3<double>(now.force_on_tool_N),
                shown = runtime::make_vec3<double>(tick.force_on_tool_N);
    const double cap_N = tool_.shape.max_force_N, noise = 1 + kRounding;
    const bool is_above = dot(force, force) > cap_N * cap_N * noise;
    out_.capped += is_capped;
    out_.above_cap += dot(shown, shown) > cap_N * cap_N * noise || (is_above && !is_capped);
  }
  double radius_m() const { return tool_.shape.ball[0].radius_m; }
  Vec3d place() const { return x_ - runtime::make_vec3<double>(asset_.origin_m); }

  const AssetView& asset_;
  Figures& out_;
  runtime::Contact contact_;
  runtime::Tool tool_;
  Output before_;
  Vec3d x_{0, 0, 0};
  const int level_;  // of kFiner; above 0 work alone is measured
  OutsideWork work_;
  double least_m_ = 0, lost_J_ = 0, most_J_ = 0;
  int ticks_out_ = 0;
  bool has_begun_ = false, slides_in_ = false, is_watched_ = false, was_deep_ = false;
};

// Measured vertices, and those of them that have a neighbour which is not.
struct Starts {
  std::vector<int> measured, rim;
};
Starts starts_of(const AssetView& asset) {
  Starts out;
  std::vector<char> is_rim(static_cast<std::size_t>(asset.vertices), 0);
  for (int t = 0; t < asset.triangles; ++t)
    for (int k = 0; k < 3; ++k)
      if (asset.covered[asset.corner(t, k)] != runtime::kMeasured)
        for (int j = 0; j < 3; ++j) is_rim[static_cast<std::size_t>(asset.corner(t, j))] = 1;
  for (int v = 0; v < asset.vertices; ++v) {
    if (asset.covered[v] != runtime::kMeasured) continue;
    out.measured.push_back(v);
    if (is_rim[static_cast<std::size_t>(v)]) out.rim.push_back(v);
  }
  return out;
}

Figures walk(const AssetView& asset, double radius_m, int ways, unsigned seed) {
  std::mt19937_64 random(seed);
  const auto unit = [&] { return double(random() >> 11) * 0x1p-53; };
  const Starts starts = starts_of(asset);
  const auto one_of = [&](const std::vector<int>& of) {
    return of[static_cast<std::size_t>(unit() * double(of.size()))];
  };
  const double depth_m = std::min(asset.max_fitted_m, 0.007);
  const auto foot = [&](int v) {
    return asset.vertex_at(v) + runtime::make_vec3<double>(asset.origin_m) -
           asset.normal_at(v) * radius_m;
  };
  const double cap_N = 0.5 * runtime::curve_value(asset.curves.view[runtime::kNormal],
                                                  asset.node(starts.measured[0]), depth_m);
  Figures out;
  const auto closed_way = [&](double step_m, int legs, int levels) {
    const int v = one_of(starts.measured);
    const Vec3d u = asset.normal_at(v), p = foot(v), air = p - u * 0.002;
    std::vector<Vec3d> places{air};
    for (int leg = 0; leg < legs; ++leg) {
      const Vec3d side{unit() - 0.5, unit() - 0.5, unit() - 0.5};
      places.push_back(p + runtime::tangential(side, u) * (2 * depth_m) +
                       u * (depth_m * (1.1 * unit() - 0.05)));
    }
    places.push_back(air);
    Figures finer;
    for (int level = 0; level < levels; ++level) {
      Path path(asset, radius_m, cap_N, level == 0 ? out : finer, level);
      for (const Vec3d& place : places) path.go(place, step_m);
      path.end();
    }
    for (int level = 1; level < levels; ++level)
      out.least_work[level] = std::min(out.least_work[level], finer.least_work[level]);
  };
  for (int i = 0; i < ways; ++i)
    closed_way(2e-5 * std::pow(5, unit()), 5, i % 10 == 0 ? kLevels : 1);
  while (out.small < 500L * ways) closed_way(0.999 * kSmall_m, 5, 1);
  // From beside the measured region into it and back, 16 mm long, 5 and 7 mm deep.
  Vec3d middle{0, 0, 0};
  for (const int v : starts.measured)
    middle = middle + foot(v) * (1.0 / double(starts.measured.size()));
  for (int i = 0; i < ways / 7 && !starts.rim.empty(); ++i) {
    const int v = one_of(starts.rim);
    const Vec3d u = asset.normal_at(v), p = foot(v),
                inward = normalized(runtime::tangential(middle - p, u)) * 0.008;
    const double deep_m = i % 2 == 0 ? 0.005 : 0.007;
    const double step_m = i % 4 < 2 ? kTick_m : 0.999 * kSmall_m;
    Path path(asset, radius_m, cap_N, out);
    path.go(p - inward - u * 0.004, step_m);
    path.go(p - inward + u * deep_m, step_m);
    path.go(p + inward + u * deep_m, step_m, true);
    path.go(p - inward + u * deep_m, step_m, true);
    path.go(p - inward - u * 0.004, step_m);
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
  make_rings(model, 1, 0.03, even);
  return model;
}
Model groove() {
  Model model = groove_model(0.04, 40, std::numbers::pi / 6);
  make_rings(model, 1, 0, even);
  return model;
}
Model box() {
  Model model = box_model(0.03, 12, uniform(400, 300, 0.3));
  make_rings(model, 1, 0, even);
  return model;
}

struct Row {
  std::string body;
  Figures figures;
};

bool is_good(const Figures& f) {
  const auto is_smooth = [](const Jumps& j) {
    return std::max({j.edge_N, j.touch_N, j.release_N, j.slide_in_N}) <= 2 * j.inside_N;
  };
  const bool fits = f.blocked < f.in_contact / 100;  // into the body's hollows
  return f.least_work[kLevels - 1] >= -kMostGiven && is_smooth(f.by_tick) &&
         is_smooth(f.by_small) && (f.lost + f.unflagged_inside == 0 || !fits) &&
         f.above_friction + f.above_range + f.above_cap + f.beside + f.risen == 0 && f.capped > 0;
}

void print(const std::vector<Row>& rows) {
  Figures sum;
  std::printf(
      "Largest change of the force [mN] at an edge, within a triangle, at touch, at release,\n"
      "in a slide into the measured region; least work of a way over what was put in, from "
      "outside,\n"
      "in as many ticks, in 4, 16 and 64 times as many\n"
      "%-20s %38s  %38s %8s\n",
      "", "in 50 um", "in 20 um", "work");
  for (const Row& row : rows) {
    const Figures& f = row.figures;
    std::printf("%-20s ", row.body.c_str());
    for (const Jumps& j : {f.by_tick, f.by_small})
      std::printf("%7.1f %7.1f %7.1f %7.1f %7.1f  ", 1e3 * j.edge_N, 1e3 * j.inside_N,
                  1e3 * j.touch_N, 1e3 * j.release_N, 1e3 * j.slide_in_N);
    for (const double least : f.least_work) std::printf(" %7.1g", least);
    std::printf("%s\n", is_good(f) ? "" : "  not as promised");
    sum.ways += f.ways;
    sum.moves += f.moves;
    sum.small += f.small;
  }
  std::printf("%ld ways, %ld moves, %ld of them of 20 um\n\n", sum.ways, sum.moves, sum.small);
  std::printf(
      "Ticks: in contact, in debt, in the surface without a contact; contacts that slid off a\n"
      "ridge, of these back in a tick, lost; ticks BLOCKED,\n"
      "EXTRAPOLATED, OUTSIDE; above a limit without a flag: friction (most [mN]), range, beside,\n"
      "cap, in the surface without INSIDE; ticks in which what is stored rose without work\n");
  for (const Row& row : rows) {
    const Figures& f = row.figures;
    std::printf(
        "%-20s %8ld %7ld %7ld | %3ld %3ld %3ld | %7ld %7ld %7ld | %ld (%.2g) %ld %ld %ld %ld %ld\n",
        row.body.c_str(), f.in_contact, f.held, f.inside, f.slid_off, f.back_at_once, f.lost,
        f.blocked, f.extrapolated, f.outside, f.above_friction, 1e3 * f.most_above_N, f.above_range,
        f.beside, f.above_cap, f.unflagged_inside, f.risen);
  }
}

int run(int ways, unsigned seed, const std::vector<std::string>& files) {
  std::vector<Row> rows;
  const auto go = [&](const std::string& name, const AssetView& asset) {
    for (const double radius_m : {asset.probe_radius_m, 0.004}) {
      char body[64];
      std::snprintf(body, sizeof body, "%s, %.0f mm", name.c_str(), 1e3 * radius_m);
      rows.push_back({body, walk(asset, radius_m, ways, seed)});
    }
  };
  for (const std::string& path : files) {
    const AssetFile file = read_asset_file(path);
    go(path.substr(path.rfind('/') + 1), file.asset());
  }
  go("box", load(box()).asset);
  go("groove", load(groove()).asset);
  for (const double height_m : {0.0001, 0.0003, 0.001})
    go("rough " + std::to_string(height_m * 1e3).substr(0, 3) + " mm",
       load(rough_sphere(seed, height_m)).asset);
  print(rows);
  for (const Row& row : rows)
    if (!is_good(row.figures)) return 1;
  return 0;
}

}  // namespace
}  // namespace palpate::test

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  return palpate::test::run(std::atoi(argv[1]),
                            static_cast<unsigned>(std::strtoul(argv[2], nullptr, 10)),
                            std::vector<std::string>(argv + 3, argv + argc));
}
