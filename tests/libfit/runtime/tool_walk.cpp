// Random ways of random tools over random bodies: 1 to 3 tools of 1 to 8 balls between them, with
// and without dampers, each ball as another indenter than that of the asset or not (0.4 to 2 times
// its radius, and a cone), which changes between contacts; on bodies that are flat or round, even
// or rough, and that sway, relax, soften and couple contacts as each seed draws. Tools press,
// slide, turn, stand and lift, 10 um to 0.1 mm a tick. Fails where what all store and the tank rise
// without work, where a walk gives work as somebody beside it measures it (force over motion,
// torque over turns; every 10th walk in 4, 16 and 64 times as many ticks), or where a force jumps.
// tool_walk TICKS SEED
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "libfit/experiments/follow.hpp"
#include "libfit/runtime/engine.hpp"
#include "tests/libfit/runtime/damaged_body.hpp"
#include "tests/libfit/runtime/models.hpp"
#include "tests/libfit/runtime/outside_work.hpp"

namespace {

using namespace palpate;
using palpate::test::kLevels;
using runtime::Vec3d;

constexpr double kRadius_m = 0.004, kDepth_m = 0.005;
constexpr double kLeastRadius = 0.4, kMostRadius = 2;  ///< of indenters, over kRadius_m
/// Of a force, over the stiffest curve times all motion in a tick. A body that softens answers more
/// steeply where a deep press turns back, the more the wider its contact: over two ticks or three,
/// so that it is no jump.
constexpr double kMostJump = 3, kMostSoftenedJump = 10;

/// A tool that stands moves by rounding alone, while its body relaxes.
constexpr double kRounding_m = 1e-9;

/// Shares in [0, 1), the same on every machine.
struct Random {
  std::uint64_t state;
  double share() {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return double(state >> 11) / 9007199254740992.0;
  }
};
double sign(Random& random) { return 2 * random.share() - 1; }
Vec3d direction(Random& random) {
  const double x = sign(random), y = sign(random), z = sign(random);
  return {x, y, z};
}

/// A body as a seed draws it, with its asset, its coupling and its memory of damage.
struct DrawnBody {
  test::DrawnRings drawn;
  test::Loaded loaded;
  runtime::CouplingView coupling;
  std::unique_ptr<test::DamagedBody> damaged;
  runtime::AssetView asset;
  std::unique_ptr<IndenterAssets> met;
  double stiffest_N_m = 0;

  explicit DrawnBody(unsigned seed)
      : drawn(seed), loaded(test::load(model(seed))), asset(loaded.asset) {
    if (asset.damage.softens()) {
      damaged = std::make_unique<test::DamagedBody>(loaded.asset);
      asset = damaged->view;
    }
    if (drawn.unit() < 0.75) couple();
    met = std::make_unique<IndenterAssets>(asset);
    for (int v = 0; v < asset.vertices; ++v) {
      const runtime::SplineView& spline = asset.curves.view[runtime::kNormal];
      stiffest_N_m = std::max(
          stiffest_N_m,
          runtime::curve_slope(spline, asset.node(v) + asset.control_offset[runtime::kNormal],
                               spline.knots[spline.pieces]));
    }
    // Of the largest indenter: as much wider a contact is at its end.
    stiffest_N_m *= kMostRadius * (1 + asset.curves.relaxation.fast);
  }
  void heal() {
    if (damaged) runtime::start_body(loaded.asset, damaged->memory.data());
  }

 private:
  Model model(unsigned) {
    Model out = drawn.model(drawn.unit() < 0.3 ? 0.1 : 1);
    out.probe = sphere_spec(kRadius_m, 0.3);
    out.curves.first_row_m = drawn.unit() < 0.5 ? 0.0005 : 0;
    auto& effect = out.curves.control[runtime::kRadiusEffect];
    for (Eigen::Index v = 0; v < effect.rows(); ++v)
      effect.row(v) << 0.1 * drawn.unit() - 0.05 + out.surface.vertices(v, 0), 0.1 * drawn.unit();
    effect = rounded_to_float(effect);
    if (drawn.unit() < 0.6) {
      const double size = 0.02 * drawn.unit();
      test::set_sway(out, [&](const Vec3& x) {
        return test::Symmetric(size * test::Symmetric{1 + 5 * x[0], 1.6, 0.4, 0.2, -0.1, 0.1});
      });
    }
    if (drawn.unit() < 0.5) {
      out.curves.relaxation.share = Eigen::Vector2d(0.2 + drawn.unit(), 0.5 * drawn.unit() + 0.1);
      out.curves.relaxation.time_s = Eigen::Vector2d(0.003 + 0.02 * drawn.unit(), 0.3);
    }
    if (drawn.unit() < 0.4)
      out.curves.damage = {1.2 + drawn.unit(), 0.05, 0.1 * drawn.unit(), 0.006};
    return out;
  }
  void couple() {
    coupling.length_m = 0.5 * kRadius_m;
    for (int k = 0; k < runtime::kCouplingScales; ++k) {
      coupling.isotropic_m_N[k] = 1.0 / (1 << k);
      coupling.tangential_m_N[k] = 0.2 / (1 << k);
    }
    // Up to three times what the stiffest place bears: stiff ones have a share, others all of it.
    const double corner[3] = {1, 0, 0};
    double excess = 0;
    for (int t = 0; t < asset.triangles; ++t) {
      const runtime::ContactStiffness at = runtime::stiffness_at_end(asset, t, corner);
      excess = std::max(excess, runtime::coupling_excess(coupling, at.along_N_m, at.across_N_m));
    }
    excess /= 1 + 2 * drawn.unit();
    for (int k = 0; k < runtime::kCouplingScales; ++k) {
      coupling.isotropic_m_N[k] /= excess;
      coupling.tangential_m_N[k] /= excess;
    }
    asset.coupling = &coupling;
  }
};

struct Sums {
  long all_ticks = 0;  ///< of walks in shorter ticks, too
  long ticks = 0, walks = 0, touching = 0, together = 0, slipping = 0, unfinished = 0,
       kinds[16] = {};
  double refused_J = 0, jump[2] = {}, rise = 0, jump_10um_N = 0, worst[kLevels] = {};
};

Vec3d turn_between(const runtime::Frame& before, const runtime::Frame& now) {
  Vec3d out{0, 0, 0};
  for (int k = 0; k < 3; ++k) {
    const Vec3d axis{k == 0 ? 1.0 : 0, k == 1 ? 1.0 : 0, k == 2 ? 1.0 : 0};
    out = out + cross(before.turn(axis), now.turn(axis)) * 0.5;
  }
  return out;
}

runtime::Pose pose_at(const Vec3d& place, const Vec3d& turn) {
  runtime::Pose pose;
  runtime::put(place, pose.position_m);
  const double angle = std::sqrt(dot(turn, turn));
  if (angle > 0) {
    pose.orientation[0] = std::cos(angle / 2);
    runtime::put(turn * (std::sin(angle / 2) / angle), pose.orientation + 1);
  }
  return pose;
}

/// One walk of some tools in ticks `finer` times as short.
class Walk {
 public:
  Walk(DrawnBody& body, Random& random, int finer, Sums& sums)
      : body_(body), random_(random), finer_(finer), sums_(sums) {
    body.heal();
    const bool couples = body.asset.coupling != nullptr;
    count_ = 1 + static_cast<int>(3 * random.share());
    int left = runtime::kMaxContacts;
    for (int i = 0; i < count_; ++i) {
      tool_[i] = runtime::Tool();
      runtime::ToolShape& shape = tool_[i].shape;
      shape.balls = couples ? 1 + static_cast<int>(random.share() * double(left - count_ + i)) : 1;
      left -= shape.balls;
      for (int k = 0; k < shape.balls; ++k) {
        shape.ball[k].radius_m =
            random.share() < 0.1 && shape.balls == 1 ? 0 : kRadius_m * (0.5 + 0.5 * random.share());
        take(shape.ball[k]);
        put(Vec3d{kRadius_m * k, 0, 0} + direction(random) * (0.2 * kRadius_m * (k > 0)),
            shape.ball[k].centre_m);
      }
      if (random.share() < 0.3) {
        shape.damping_Ns_m = 50 * random.share();
        shape.lateral_damping_Ns_m = 20 * random.share();
        shape.damper_depth_m = 1e-3;
      }
      home_[i] = {0.012 * (i - 1) + 0.003 * sign(random), 0.004 * sign(random),
                  body.drawn.top_m() + kRadius_m + 0.002};
      at_[i] = home_[i];
      turn_[i] = direction(random) * 0.2;
    }
  }

  bool run() {
    if (!tick()) return false;
    for (int leg = 0; leg < 7; ++leg) {
      Vec3d from[3], to[3], from_turn[3], to_turn[3];
      double longest_m = 1e-5;
      for (int i = 0; i < count_; ++i) {
        from[i] = to[i] = at_[i];
        from_turn[i] = to_turn[i] = turn_[i];
        const double choice = random_.share();
        const Vec3d aside = direction(random_) * (1.5 * kDepth_m),
                    turned = direction(random_) * 0.25;
        const double depth_m = kDepth_m * (0.1 + 0.8 * random_.share());
        if (leg == 6 || choice < 0.2) {
          to[i] = home_[i] + Vec3d{0, 0, 0.03};
        } else if (choice < 0.3 && is_in_air(tool_[i])) {  // another tool, where it is
          for (int k = 0; k < tool_[i].shape.balls; ++k) take(tool_[i].shape.ball[k]);
          runtime::forget(tool_[i]);
        } else if (choice < 0.85) {
          to[i] = home_[i] + Vec3d{aside.x, aside.y, -0.002 - depth_m};
          to_turn[i] = turned;
        }
        const Vec3d way = to[i] - from[i];
        longest_m = std::max(longest_m, std::sqrt(dot(way, way)));
      }
      const double step_m = 1e-5 * (1 + 9 * random_.share());
      dt_s_ = 1e-3 * (0.7 + 2 * random_.share()) / finer_;
      const long ticks = finer_ * (1 + static_cast<long>(longest_m / step_m));
      for (long k = 1; k <= ticks; ++k) {
        for (int i = 0; i < count_; ++i) {
          const double share = double(k) / double(ticks);
          at_[i] = from[i] + (to[i] - from[i]) * share;
          turn_[i] = from_turn[i] + (to_turn[i] - from_turn[i]) * share;
        }
        if (!tick()) return false;
      }
    }
    return true;
  }
  double share_given() const { return in_J_ > 0 ? work_J_ / in_J_ : 0; }

 private:
  /// Makes a ball another indenter, or that of the asset.
  void take(runtime::ToolBall& ball) {
    const double choice = random_.share(), drawn = random_.share();
    ball.asset = nullptr;
    if (!(ball.radius_m > 0) || choice < 0.3) return;
    runtime::Indenter end = runtime::ball_indenter(
        kRadius_m * (kLeastRadius + (kMostRadius - kLeastRadius) * std::floor(8 * drawn) / 8));
    if (choice < 0.5) {  // a cone with a round tip
      end.round_end_m = 0.25 * kRadius_m;
      end.points = 3;
      end.r_m[1] = 0.5 * end.round_end_m;
      end.r_m[2] = 1;
      end.slope[1] = end.slope[2] = 0.577;
    }
    ball.asset = body_.met->of(end);
    if (ball.asset != nullptr) ball.radius_m = end.round_end_m;
  }
  static bool is_in_air(const runtime::Tool& tool) {
    for (int k = 0; k < tool.shape.balls; ++k)
      if (tool.contact[k].triangle >= 0) return false;
    return true;
  }

  bool tick() {
    runtime::ToolInput in[3];
    runtime::ToolOutput out[3];
    runtime::Status status[3];
    runtime::Tool* tools[3] = {};
    for (int i = 0; i < count_; ++i) {
      in[i].pose = pose_at(at_[i], turn_[i]);
      in[i].dt_s = dt_s_;
      tools[i] = &tool_[i];
    }
    touch_tools(body_.asset, tools, in, out, status, count_);
    double stored_J = 0, moved_m = 0, changed_N = 0, work_J = 0;
    int touching = 0;
    for (int i = 0; i < count_; ++i) {
      if (status[i] != runtime::Status::ok) return fail("is refused");
      runtime::Frame now;
      make_frame(in[i].pose, now);
      if (!has_before_) before_[i] = now;
      const Vec3d step = now.origin - before_[i].origin, turned = turn_between(before_[i], now);
      const Vec3d force = runtime::make_vec3<double>(out[i].force_on_tool_N),
                  torque = runtime::make_vec3<double>(out[i].torque_on_tool_Nm),
                  changed = force - force_[i];
      work_J -= 0.5 * (dot(force + force_[i], step) + dot(torque + torque_[i], turned));
      moved_m += std::sqrt(dot(step, step)) +
                 kRadius_m * tool_[i].shape.balls * std::sqrt(dot(turned, turned));
      changed_N = std::max(changed_N, std::sqrt(dot(changed, changed)));
      force_[i] = force;
      torque_[i] = torque;
      before_[i] = now;
      stored_J += out[i].stored_J;
      touching += out[i].touching;
      sums_.unfinished += (out[i].flags & PALPATE_FLAG_UNFINISHED) != 0;
      if (finer_ == 1) sums_.slipping += out[i].state == runtime::ContactState::slip;
    }
    has_before_ = true;
    work_J_ += work_J;
    in_J_ += std::max(work_J, 0.0);
    return account(stored_J, touching, moved_m, changed_N);
  }

  bool account(double stored_J, int touching, double moved_m, double changed_N) {
    double lost_J = 0;
    for (int i = 0; i < count_; ++i) {
      const bool together = body_.asset.coupling != nullptr;
      const runtime::Ledger& ledger =
          together ? tool_[0].together.ledger : tool_[i].contact[0].ledger;
      lost_J += ledger.dissipated_J - ledger.tank_J;
      if (together) break;
    }
    peak_J_ = std::max(peak_J_, stored_J);
    const double rounding_J = 1e-11 * peak_J_ + 1e-14 * std::fabs(lost_J);
    const double rise = lost_J_ - lost_J;
    lost_J_ = lost_J;
    ++sums_.all_ticks;
    if (peak_J_ > 0) sums_.rise = std::max(sums_.rise, rise / peak_J_);
    if (finer_ == 1) {
      ++sums_.ticks;
      sums_.touching += touching > 0;
      sums_.together += touching > 1;
      const bool has_damper =
          tool_[0].shape.has_damper() || tool_[1].shape.has_damper() || tool_[2].shape.has_damper();
      if (moved_m > kRounding_m && !has_damper) {
        double& jump = sums_.jump[body_.asset.body != nullptr];
        jump = std::max(jump, changed_N / (body_.stiffest_N_m * moved_m));
        sums_.jump_10um_N = std::max(sums_.jump_10um_N, changed_N * std::min(1.0, 1e-5 / moved_m));
      }
    }
    if (!(rise <= rounding_J)) return fail("raises what is stored without work");
    return stored_J >= -rounding_J || fail("stores less than nothing");
  }
  bool fail(const char* what) const {
    std::printf("a walk of %d tools %s\n", count_, what);
    return false;
  }

  DrawnBody& body_;
  Random& random_;
  int finer_;
  Sums& sums_;
  int count_ = 0;
  runtime::Tool tool_[3];
  Vec3d home_[3], at_[3], turn_[3], force_[3] = {}, torque_[3] = {};
  runtime::Frame before_[3];
  bool has_before_ = false;
  double dt_s_ = 1e-3, work_J_ = 0, in_J_ = 0, lost_J_ = 0, peak_J_ = 0;
};

/// Bit 0: sways, 1: relaxes, 2: softens, 3: couples.
int kind_of(const DrawnBody& body) {
  return (body.asset.sways ? 1 : 0) + (body.asset.curves.relaxation.branches > 0 ? 2 : 0) +
         (body.asset.body != nullptr ? 4 : 0) + (body.asset.coupling != nullptr ? 8 : 0);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const auto seed = static_cast<unsigned>(std::strtoul(argv[2], nullptr, 10));
  Sums sums;
  for (unsigned number = 0; sums.ticks < std::atol(argv[1]); ++number) {
    DrawnBody body(1000 * seed + number);
    Random random{2 * (1000ull * seed + number) + 1};
    for (int walk = 0; walk < 10; ++walk) {
      ++sums.walks;
      const Random again = random;
      for (int level = 0; level < (walk == 0 ? kLevels : 1); ++level) {
        random = again;
        static std::unique_ptr<Walk> run;
        run = std::make_unique<Walk>(body, random, test::kFiner[level], sums);
        const long before = sums.ticks;
        if (!run->run()) {
          std::printf("body %u of seed %u, walk %d, in %d times as many ticks\n", number, seed,
                      walk, test::kFiner[level]);
          return 1;
        }
        sums.kinds[kind_of(body)] += sums.ticks - before;
        sums.worst[level] = std::min(sums.worst[level], run->share_given());
      }
    }
  }
  std::printf(
      "%ld ticks in %ld walks, %ld in contact, %ld of two balls and more, %ld slips; %ld with "
      "those "
      "of the same walks in shorter ticks, %ld of all unfinished\n",
      sums.ticks, sums.walks, sums.touching, sums.together, sums.slipping, sums.all_ticks,
      sums.unfinished);
  std::printf("ticks by sway 1 + relaxation 2 + softening 4 + coupling 8:");
  for (const long ticks : sums.kinds) std::printf(" %ld", ticks);
  std::printf(
      "\nlargest rise of what is stored less the tank, over the most stored: %.3g\n"
      "least share of what was put in that a walk took, from outside, in 1, 4, 16 and 64 "
      "times as many ticks: %.3g %.3g %.3g %.3g\n"
      "largest change of a force, over the stiffest curve times all motion: %.3g, on "
      "bodies that soften %.3g; per 10 um: "
      "%.3g N\n",
      sums.rise, sums.worst[0], sums.worst[1], sums.worst[2], sums.worst[3], sums.jump[0],
      sums.jump[1], sums.jump_10um_N);
  const bool gives = sums.worst[kLevels - 1] < -test::kMostGiven;
  const bool jumps = sums.jump[0] > kMostJump || sums.jump[1] > kMostSoftenedJump;
  return sums.together > sums.ticks / 10 && !jumps && !gives ? 0 : 1;
}
