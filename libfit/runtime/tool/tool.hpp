// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Rigid tools against a rigid motion of the body: poses in, wrenches out. A tool is 1 to
// kMaxContacts balls fixed to each other, each with a place and a radius of its own
// (docs/method-tools.md, section 29): a tip or a ball, a lying capsule, a finger, a grasper whose
// jaw ends in a point. Its force and torque are the sums over the balls
//
//     F = sum_i f_i        T = sum_i (p_i + R u_i - O) x f_i                               (M70)
//
// with p_i the centres, O the tool's origin and u_i the inward normals at the contacts. A turn dA
// of the tool moves the surface of a ball by dA x R u_i, and its contact point as far back,
// so that a ball which rolls carries it along (M72). T dA works on what is stored as F dp
// does, and one ledger (section 18) books the rest. palpate.h is this file's face for C and every
// other language.

#include "../base/frame.hpp"
#include "../series/tick.hpp"

namespace palpate::runtime {

struct ToolBall {
  double centre_m[3] = {0, 0, 0};  ///< of the tip or the ball, in the tool's frame
  double radius_m = 0;             ///< 0: a tip
  /// Made by with_indenter() of the asset that is ticked, which it
  /// must outlive; null: as it is.
  const AssetView* asset = nullptr;
};

/// Geometry and limits of a tool; palpate_tool (palpate.h) defines damper, ramp and cap. The damper
/// resists the tool's own motion, so its work is never negative, whatever other tools do to the
/// surface.
struct ToolShape {
  int balls = 1;
  ToolBall ball[kMaxContacts];
  double damping_Ns_m = 0;
  double damper_depth_m = 0;  ///< > 0 where there is damping
  double lateral_damping_Ns_m = 0;
  double max_force_N = 0;  ///< 0: no cap
  double ramp_s = 0;       ///< 0: none

  bool has_damper() const noexcept { return damping_Ns_m > 0 || lateral_damping_Ns_m > 0; }
};

inline Status check_tool(const ToolShape& shape) noexcept {
  bool is_good = shape.balls >= 1 && shape.balls <= kMaxContacts;
  for (int i = 0; is_good && i < shape.balls; ++i) {
    for (double x : shape.ball[i].centre_m) is_good = is_good && std::fabs(x) <= 1e3;
    is_good = is_good && is_possible_radius(shape.ball[i].radius_m);
  }
  const auto is_size = [](double x, double most) noexcept { return x >= 0 && x <= most; };
  is_good = is_good && is_size(shape.damping_Ns_m, kMaxDamping_Ns_m) &&
            is_size(shape.lateral_damping_Ns_m, kMaxDamping_Ns_m) &&
            is_size(shape.damper_depth_m, 1e3) && is_size(shape.max_force_N, kMaxForce_N) &&
            is_size(shape.ramp_s, 1e3) && (!shape.has_damper() || shape.damper_depth_m > 0);
  return is_good ? Status::ok : Status::tool_wrong;
}

/// Rolling state of a ball's contact.
struct Rolling {
  double followed = 0;  ///< share of the roll that its contact point follows; the rest slips
  double torque_Nm[3] = {0, 0, 0};  ///< (M72), on the ball about its centre, of the last tick
};

/// One tool on one body: what is remembered between ticks. Plain data.
struct Tool {
  ToolShape shape;
  double damped_J = 0;  ///< taken by the damper since the start, never falling
  double since_start_s = 0;
  double capped_from_J = 0;  ///< energy above which the cap holds the force back; 0: it does not
  bool has_pose = false;
  double row[3][3] = {};                ///< of the turn from the tool's axes to the body's
  TogetherMemory together;              ///< what all tools of a tick remember, the same in each
  double normal[kMaxContacts][3] = {};  ///< of each contact at the last tick
  Rolling rolling[kMaxContacts];
  Contact contact[kMaxContacts];
};

/// Contacts end, and where the tool was is forgotten; sums stay.
inline void forget(Tool& tool) noexcept {
  for (int i = 0; i < tool.shape.balls; ++i) {
    forget(tool.contact[i]);
    tool.rolling[i] = Rolling();
  }
  tool.has_pose = false;
}

/// A tick in world coordinates. Of several balls contact_m, acts_at_m and normal are means by what
/// each carries; triangle, weight, normal_m and lateral_m are of the one that carries most.
struct ToolOutput : Output {
  double torque_on_tool_Nm[3] = {0, 0, 0};  ///< about the tool pose's position
  double deflection_m[3] = {0, 0, 0};       ///< from contact_m to acts_at_m
  double damped_J = 0;
  int touching = 0;                                ///< balls in contact
  bool has_touched = false, has_released = false;  ///< at this tick
  double approach_m_s = 0;                         ///< along u, of the tick of a touch
};

/// One tool's question at a tick. tangent_N_m: as of touch_ball(), in world coordinates, without
/// the damper and for tools that do not turn; null: not wanted.
struct ToolInput {
  Pose pose, body;
  double dt_s = 0;
  TangentOut tangent_N_m = nullptr;
};

/// The damper's force on the body [N] at a ball for a motion `step` [m] in dt_s. Its work, force
/// times step, is never negative.
struct DamperForce {
  double along_N;  ///< u
  Vec3d lateral_N;
};
inline DamperForce damper_force(const ToolShape& shape, const Output& out, const Vec3d& step,
                                double dt_s) noexcept {
  if (!shape.has_damper()) return {0, {0, 0, 0}};
  const Vec3d u = make_vec3<double>(out.normal);
  const double depth = out.normal_m > 0 ? out.normal_m : 0;
  const double rate =
      (depth < shape.damper_depth_m ? depth / shape.damper_depth_m : 1) / (dt_s * shape.balls);
  const double wanted = shape.damping_Ns_m * rate * dot(step, u);
  const double elastic = -dot(make_vec3<double>(out.force_on_tool_N), u);
  const double least = elastic > 0 ? -elastic : 0;
  return {wanted > least ? wanted : least,
          tangential(step, u) * (shape.lateral_damping_Ns_m * rate)};
}

/// The share of its force that the ramp and the cap leave to a tool that stores stored_J. A force
/// cut by its size would be no gradient, and return more round a loop than it took. The capped
/// one is the gradient of 2 sqrt(U0 U) - U0 where U > U0 (M71), U0 being capped_from_J. It is
/// lowered where the force would exceed max_force_N: what the tool stores then only falls.
inline double force_share(Tool& tool, double stored_J, const Vec3d& force,
                          unsigned& flags) noexcept {
  const ToolShape& shape = tool.shape;
  double share = 1;
  if (tool.since_start_s < shape.ramp_s) {
    share = tool.since_start_s / shape.ramp_s;
    flags |= PALPATE_FLAG_RAMP;
  }
  if (!(shape.max_force_N > 0)) return share;
  if (!(stored_J > tool.capped_from_J)) tool.capped_from_J = 0;
  double capped = tool.capped_from_J > 0 ? std::sqrt(tool.capped_from_J / stored_J) : 1;
  const double size = share * std::sqrt(dot(force, force));
  if (size * capped > shape.max_force_N) {
    capped = shape.max_force_N / size;
    tool.capped_from_J = stored_J * (capped * capped);
  }
  if (capped < 1) flags |= PALPATE_FLAG_CAPPED;
  return share * capped;
}

inline bool is_time_step(double dt_s) noexcept {
  return dt_s >= kMinTimeStep_s && dt_s <= kMaxTimeStep_s;
}

/// A tool at a tick, before and after its contacts answer.
class ToolTick {
 public:
  /// Refuses a bad pose or time step, and a tool whose balls the asset cannot have together;
  /// contacts are forgotten then.
  Status begin(const AssetView& asset, Tool& tool, const ToolInput& in, BallTick* ball,
               int number) noexcept {
    asset_ = &asset;
    tool_ = &tool;
    in_ = &in;
    ball_ = ball;
    const ToolShape& shape = tool.shape;
    const bool needs_time = shape.has_damper() || shape.ramp_s > 0 || has_flow(asset, Memories());
    bool is_of_asset = true;
    for (int i = 0; i < shape.balls; ++i)
      if (const AssetView* own = shape.ball[i].asset)
        is_of_asset = is_of_asset && own->control == asset.control && own->body == asset.body;
    status_ = !is_of_asset || (shape.balls > 1 && asset.coupling == nullptr) ? Status::tool_wrong
              : needs_time && !is_time_step(in.dt_s) ? Status::time_step_wrong
              : !make_frame(in.pose, frame_) || !make_frame(in.body, body_) ? Status::pose_wrong
                                                                            : Status::ok;
    if (status_ != Status::ok) forget(tool);
    if (status_ == Status::ok && is_time_step(in.dt_s)) tool.since_start_s += in.dt_s;
    if (status_ == Status::ok) roll();
    for (int i = 0; i < shape.balls; ++i) place(i, number);
    return status_;
  }

  /// Gathers what the balls answered. Where one is refused the ball_force tool is out of contact.
  Status end(ToolOutput& out) noexcept {
    Tool& tool = *tool_;
    out = ToolOutput();
    for (int i = 0; status_ == Status::ok && i < tool.shape.balls; ++i) status_ = ball_[i].status;
    if (status_ != Status::ok) forget(tool);
    gather_sums(out);
    out.has_released = was_touching_ && (status_ != Status::ok || out.touching == 0);
    if (status_ != Status::ok || out.touching == 0) return in_air(out);
    out.has_touched = !was_touching_;
    Vec3d ball_force[kMaxContacts], total{0, 0, 0};
    bool is_first = true;
    for (int i = 0; i < tool.shape.balls; ++i) {
      if (ball_[i].out.state == ContactState::air) continue;
      ball_force[i] = damped(i, out);
      total = is_first ? ball_force[i] : total + ball_force[i];
      is_first = false;
    }
    for (int i = 0; i < tool.shape.balls; ++i) find_rolling(i);
    const double share = force_share(tool, out.stored_J, total, out.flags);
    out.damped_J = tool.damped_J;
    put_wrench(ball_force, share, out);
    put_place(ball_force, out);
    turn_tangent();
    return Status::ok;
  }

 private:
  /// The turn since the tick before moves the balls' surfaces, and their contacts' anchors.
  void roll() noexcept {
    Tool& tool = *tool_;
    const Frame relative = relative_to(body_, frame_);
    const Vec3d turned = tool.has_pose ? turn_since(tool.row, relative) : Vec3d{0, 0, 0};
    for (int i = 0; i < tool.shape.balls; ++i) {
      rolled_[i] = {0, 0, 0};
      Contact& contact = tool.contact[i];
      if (contact.triangle < 0) tool.rolling[i] = Rolling();
      ball_[i].worked_J = -dot(make_vec3<double>(tool.rolling[i].torque_Nm), turned);
      if (contact.triangle < 0 || !(tool.shape.ball[i].radius_m > 0)) continue;
      const Vec3d normal = make_vec3<double>(tool.normal[i]);
      rolled_[i] = cross(turned, normal * contact.arm.reach_m);
      if (!(dot(rolled_[i], rolled_[i]) > kLateralZero_m * kLateralZero_m)) {  // rounding
        rolled_[i] = {0, 0, 0};
        continue;
      }
      const AssetView* own = tool.shape.ball[i].asset;
      drag_anchors(own != nullptr ? *own : *asset_, contact, rolled_[i] * -1.0, normal);
    }
    for (int k = 0; k < 3; ++k) put(relative.row[k], tool.row[k]);
    tool.has_pose = true;
  }
  /// Updates a ball's rolling state for the next tick.
  void find_rolling(int i) noexcept {
    Rolling& rolling = tool_->rolling[i];
    const double rolled_m = std::sqrt(dot(rolled_[i], rolled_[i]));
    Contact& contact = tool_->contact[i];
    if (ball_[i].out.state == ContactState::air || !(rolled_m > 0 || rolling.followed > 0)) return;
    const ConfigurationalForce by_place =
        configurational_force(ball_asset(*asset_, ball_[i]), contact);
    const double reach_m = contact.arm.reach_m, onset_m = kRollOnset * reach_m;
    const double fresh = rolled_m < onset_m ? rolled_m / onset_m : 1;
    const double wanted = by_place.holds ? rolling.followed + fresh : rolling.followed - fresh;
    rolling.followed = wanted > 1 ? 1 : wanted > 0 ? wanted : 0;
    const Vec3d lever = make_vec3<double>(ball_[i].out.normal) * reach_m;
    put(cross(lever, by_place.gradient_N) * (rolling.followed * ball_[i].out.law_share),
        rolling.torque_Nm);
  }
  void place(int i, int number) noexcept {
    Tool& tool = *tool_;
    BallTick& b = ball_[i];
    b.contact = &tool.contact[i];
    b.asset = tool.shape.ball[i].asset;
    b.radius_m = tool.shape.ball[i].radius_m;
    b.tool = number;
    b.tangent_N_m = in_->tangent_N_m != nullptr ? tangent_ : nullptr;
    b.status = status_;
    was_touching_ = was_touching_ || tool.contact[i].triangle >= 0;
    before_[i] = make_vec3<double>(tool.contact[i].tip_m);
    if (status_ != Status::ok) {  // no place at all is refused, like any that is not finite
      for (double& x : b.place_m) x = std::numeric_limits<double>::infinity();
      return;
    }
    put(body_.place_back(frame_.place(make_vec3<double>(tool.shape.ball[i].centre_m))), b.place_m);
  }

  void gather_sums(ToolOutput& out) noexcept {
    out.damped_J = tool_->damped_J;
    for (int i = 0; i < tool_->shape.balls; ++i) {
      const Output& ball = ball_[i].out;
      out.flags |= ball.flags;
      out.stored_J += ball.stored_J;
      out.dissipated_J = ball.dissipated_J;
      out.refused_J = ball.refused_J;
      out.refused_ticks = ball.refused_ticks;
      if (ball.state != ContactState::air) ++out.touching;
      if (ball.state == ContactState::slip || out.state == ContactState::air)
        out.state = ball.state;
    }
  }
  Status in_air(ToolOutput& out) noexcept {
    tool_->capped_from_J = 0;
    if (TangentOut tangent = in_->tangent_N_m)
      for (int k = 0; k < 9; ++k) tangent[k] = 0;
    if (status_ == Status::ok) return status_;
    out.flags = 0;
    out.state = ContactState::air;
    out.stored_J = 0;
    out.touching = 0;
    return status_;
  }

  /// The force on the tool at a ball, with its share of the damper.
  Vec3d damped(int i, ToolOutput& out) noexcept {
    const Output& ball = ball_[i].out;
    const Vec3d u = make_vec3<double>(ball.normal);
    const Vec3d step = make_vec3<double>(tool_->contact[i].tip_m) - before_[i] + rolled_[i];
    put(u, tool_->normal[i]);
    if (out.has_touched && is_time_step(in_->dt_s)) {
      const double approach_m_s = dot(step, u) / in_->dt_s;
      if (approach_m_s > out.approach_m_s || out.approach_m_s == 0) out.approach_m_s = approach_m_s;
    }
    const DamperForce damper = damper_force(tool_->shape, ball, step, in_->dt_s);
    tool_->damped_J += damper.along_N * dot(step, u) + dot(damper.lateral_N, step);
    return make_vec3<double>(ball.force_on_tool_N) - u * damper.along_N - damper.lateral_N;
  }

  void put_wrench(const Vec3d* ball_force, double share, ToolOutput& out) const noexcept {
    Vec3d force{0, 0, 0}, torque{0, 0, 0};
    bool is_first = true;
    for (int i = 0; i < tool_->shape.balls; ++i) {
      if (ball_[i].out.state == ContactState::air) continue;
      const Vec3d f = body_.turn(ball_force[i] * share);
      const Vec3d acts_at = make_vec3<double>(ball_[i].out.acts_at_m);
      const Vec3d t = cross(body_.place(acts_at) - frame_.origin, f) +
                      body_.turn(make_vec3<double>(tool_->rolling[i].torque_Nm) * share);
      force = is_first ? f : force + f;
      torque = is_first ? t : torque + t;
      is_first = false;
    }
    put(force, out.force_on_tool_N);
    put(torque, out.torque_on_tool_Nm);
  }
  void put_place(const Vec3d* ball_force, ToolOutput& out) const noexcept {
    Vec3d contact{0, 0, 0}, acts{0, 0, 0}, normal{0, 0, 0};
    double most = -1, sum = 0;
    for (int i = 0; i < tool_->shape.balls; ++i) {
      const Output& ball = ball_[i].out;
      if (ball.state == ContactState::air) continue;
      const double size =
          out.touching == 1 ? 1 : std::sqrt(dot(ball_force[i], ball_force[i])) + kSettleZero_N;
      sum += size;
      contact = contact + make_vec3<double>(ball.contact_m) * size;
      acts = acts + make_vec3<double>(ball.acts_at_m) * size;
      normal = normal + make_vec3<double>(ball.normal) * size;
      if (!(size > most)) continue;
      most = size;
      out.triangle = ball.triangle;
      for (int k = 0; k < 3; ++k) out.weight[k] = ball.weight[k];
      out.normal_m = ball.normal_m;
      out.lateral_m = ball.lateral_m;
    }
    if (out.touching > 1) {
      const double length = std::sqrt(dot(normal, normal));
      contact = contact * (1 / sum);
      acts = acts * (1 / sum);
      if (length > 0) normal = normal * (1 / length);
    }
    const Vec3d at = body_.place(acts);
    put(body_.place(contact), out.contact_m);
    put(body_.turn(normal), out.normal);
    put(at, out.acts_at_m);
    put(at - make_vec3<double>(out.contact_m), out.deflection_m);
  }
  void turn_tangent() const noexcept {  // R K R^T
    if (in_->tangent_N_m == nullptr) return;
    Vec3d turned[3];
    for (int k = 0; k < 3; ++k)
      turned[k] = body_.turn({tangent_[k], tangent_[3 + k], tangent_[6 + k]});
    for (int i = 0; i < 3; ++i) {
      const Vec3d& r = body_.row[i];
      const Vec3d column = turned[0] * r.x + turned[1] * r.y + turned[2] * r.z;
      in_->tangent_N_m[i] = column.x;
      in_->tangent_N_m[3 + i] = column.y;
      in_->tangent_N_m[6 + i] = column.z;
    }
  }

  const AssetView* asset_ = nullptr;
  Tool* tool_ = nullptr;
  const ToolInput* in_ = nullptr;
  BallTick* ball_ = nullptr;
  Status status_ = Status::ok;
  Frame frame_, body_;
  Vec3d before_[kMaxContacts];  ///< of each ball, at the tick before
  Vec3d rolled_[kMaxContacts];  ///< how far its turn has moved its surface at the contact
  bool was_touching_ = false;
  double tangent_[9];
};

/// One tick of 1 to kMaxContacts tools on one body, of kMaxContacts balls at most between them:
/// in any order; tools may join and leave between ticks. Between ticks balls move straight as
/// moves relative to the body; a body that turns by an angle a in a tick is off by at most a^2/8 of
/// a ball's distance from its axis. A tool that is refused is out of contact (zero force and a
/// status), and the others go on. Where contacts move each other, stored_J of the outputs add up to
/// what all store together, the other sums are of all tools, and tools are passive as a ball_force:
/// one may return what another has put in. Otherwise each tool is by itself.
inline void touch_tools(const AssetView& asset, Tool* const* tool, const ToolInput* in,
                        ToolOutput* out, Status* status, int count) noexcept {
  Room<ToolTick, kMaxContacts> tick;
  Room<BallTick, kMaxContacts> ball;
  int balls = 0;
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < tool[i]->shape.balls; ++k) ball.make(balls + k);
    tick.make(i).begin(asset, *tool[i], in[i], &ball[balls], i);
    balls += tool[i]->shape.balls;
  }
  // Each tool carries the group's ledger, so that any of them may leave or begin anew.
  TogetherMemory* group = &tool[0]->together;
  for (int i = count - 1; i >= 0; --i)
    if (tool[i]->together.asset_checksum == asset.checksum) group = &tool[i]->together;
  touch_together(asset, *group, ball.begin(), balls, in[0].dt_s);
  for (int i = 0; i < count; ++i) {
    tool[i]->together = *group;
    status[i] = tick[i].end(out[i]);
  }
}

}  // namespace palpate::runtime
