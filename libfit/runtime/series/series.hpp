// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The contacts of a tick on one body, in series with how it is_compliant (docs/method-tools.md,
// section 28). Where nothing slips they store
//
//     E = sum_i E_i + 1/2 sum_ij f_i . C_ij f_j                                         (M64)
//
// whose gradient by the places of the balls are the forces. It is found with the slips, with
// nothing slipping, and once more where a contact point has moved, for there C is another; one
// ledger (section 18) books what slips did to E. A contact by itself on a body without
// compliance is tick_alone().

#include "../base/room.hpp"
#include "compliance.hpp"
#include "series_contact.hpp"

namespace palpate::runtime {

/// A slip of one contact, tried from where it stands.
struct SlipTrial {
  ContactPoint at;  ///< of its memory what the law uses
  SpotCache cache;  ///< of where it has moved
  Slipped slipped;
  SlipReport report;
};

/// The contacts of a tick that touch, while their series is solved.
class Series {
 public:
  Series(const AssetView& asset, SeriesContact* at, int count) noexcept
      : asset_(asset), relaxation_(asset.curves.relaxation) {
    compliance_.count = 0;
    for (int i = 0; i < count; ++i) {
      if (at[i].status != Status::ok || at[i].contact->triangle < 0) continue;
      Member& m = member_.make(compliance_.count++);
      const Contact& contact = *at[i].contact;
      m.at = &at[i];
      m.tool_m = at[i].x - make_vec3<double>(contact.arm.pole_m);
      m.before = m.tool_m - at[i].step - make_vec3<double>(contact.series.aside_m);
      m.now.force = contact.series.force();
      has_tangents_ = has_tangents_ || at[i].tangent_N_m != nullptr;
    }
  }

  void tick(Ledger& ledger) noexcept {
    couple();
    rest(ledger);
    bool is_settled = settle_slipping();
    double worked_J = 0;
    for (int i = 0; i < count(); ++i) worked_J += member_[i].at->worked_J;
    const bool is_booked = has_slipped() || worked_J != 0 || has_memory(asset_, Memories());
    const double before_J = is_booked ? settle_before() : 0;
    for (int i = 0; i < count() && has_tangents_; ++i) find_tangent(i, member_[i].tangent_N_m);
    if (commit()) {
      couple();
      is_settled = settle_holding(kSettleTolerance) && is_settled;
    }
    double each_J[kMaxContacts];
    const double after_J = load_all(each_J);
    if (is_booked) ledger.book(before_J, after_J, asset_.has_guard, worked_J);
    if (count() == 0) ledger.close(0);
    for (int i = 0; i < count(); ++i) write_output(i, ledger, after_J, each_J[i], is_settled);
    if (has_tangents_) write_tangents(ledger, after_J);
    if (count() == 1 &&
        exceeds_debt_limit(asset_of(0), ledger, after_J, member_[0].now.depth.normal_m)) {
      ledger.close(after_J);
      *member_[0].at->out = Output();
      end_contact(asset_of(0), *member_[0].at, true, member_[0].at->x);
    }
  }

 private:
  /// The law's result in a trial.
  struct LawState {
    Vec3d force;  ///< of the contact on the body, at which the law was evaluated
    Vec3d residual_N,
        correction_N;     ///< law's force minus `force`; root's force minus `force`
    Vec3d relative_m;     ///< of the tool to the displaced body: the argument of the law
    MemoryEnergy energy;  ///< energy after the memories of the body
    double law_J;         ///< E
    Depth depth;
  };
  struct Member {
    SeriesContact* at;
    Vec3d tool_m;  ///< position of the tool: relative_m under no force
    Vec3d before;  ///< relative_m at the tick before
    LawState now;
    SlipReport report;
    double tangent_N_m[9];
  };

  int count() const noexcept { return compliance_.count; }
  Contact& contact(int i) const noexcept { return *member_[i].at->contact; }
  const AssetView& asset_of(int i) const noexcept { return *member_[i].at->asset; }
  template <class Act>
  auto with_law_of(int i, const Act& act) const noexcept {
    return with_law(asset_of(i), member_[i].at->radius_m, act);
  }

  /// C where the contacts stand.
  void couple() noexcept {
    const bool is_together = asset_.coupling != nullptr && count() > 1;
    CouplingPlace place[kMaxContacts];
    for (int i = 0; i < count(); ++i) {
      const ContactPoint& at = contact(i);
      const Compliance sway = compliance_at(asset_, at.triangle, at.weight);
      const double* c = sway.c;
      const double own[9] = {c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2]};
      std::memcpy(compliance_.block[i][i], own, sizeof own);
      if (!is_together) continue;
      place[i] = coupling_place(asset_of(i), at);
      for (int j = 0; j < i; ++j)
        runtime::couple(asset_, place[i], place[j], compliance_.block[i][j],
                        compliance_.block[j][i]);
    }
  }

  /// Energy that the compliance stores under the forces (M49a), and the part of each contact.
  double compliance_energy_J(double* each_J) const noexcept {
    Vec3d slow[kMaxContacts], left[kMaxContacts];
    for (int i = 0; i < count(); ++i)
      slow[i] = slow_force(relaxation_, contact(i).series, member_[i].now.force);
    double sum = 0;
    for (int i = 0; i < count(); ++i)
      each_J[i] = 0.5 * dot(slow[i], compliance_.displacement(i, slow));
    for (int k = 0; k < relaxation_.branches; ++k) {
      for (int i = 0; i < count(); ++i) left[i] = slow[i] - contact(i).series.flowed(k);
      for (int i = 0; i < count(); ++i)
        each_J[i] += relaxation_.share[k] * (0.5 * dot(left[i], compliance_.displacement(i, left)));
    }
    for (int i = 0; i < count(); ++i) sum += each_J[i];
    return sum;
  }

  /// Before the tools leave where they were, half of the tick's time passes for the rings and all
  /// of it for the dashpots of what is_compliant, which stays where it is (M47).
  void rest(Ledger& ledger) noexcept {
    if (!has_flow(asset_, Memories())) return;
    double each_J[kMaxContacts], after_J = 0;
    double before_J = compliance_energy_J(each_J);
    bool has_flowed = false;
    for (int i = 0; i < count(); ++i) {
      Contact& at = contact(i);
      before_J += stored_in(asset_, at, at.law_J, Memories()).stored_J;
      double law_J = at.law_J;
      const bool is_due = !at.is_rested;
      at.is_rested = true;
      const bool flows =
          is_due && with_law_of(i, [&](auto f, auto is_ball) noexcept {
            using F = decltype(f);
            return runtime::rest<F, is_ball>(asset_of(i), at, member_[i].before, law_J);
          });
      after_J += stored_in(asset_, at, law_J, Memories()).stored_J;
      if (!flows) continue;
      has_flowed = true;
      Vec3d& force = member_[i].now.force;
      const Vec3d slow = slow_force(relaxation_, at.series, force);
      relax_compliance(relaxation_, at.left, slow, at.series);
      force = (slow - rest_force(relaxation_, at.series)) * relaxation_.fast;
    }
    if (has_flowed) ledger.book(before_J, after_J + compliance_energy_J(each_J), asset_.has_guard);
  }

  /// A root from the forces that there are.
  template <class Respond>
  bool settle_from(Vec3d* before, SeriesMatrix& matrix, double (SeriesMemory::*stiffness)[9],
                   double tolerance, const Respond& respond) noexcept {
    SeriesForces s;
    s.compliance = &compliance_;
    s.share = 1 / relaxation_.fast;
    Vec3d flowed[kMaxContacts];
    for (int i = 0; i < count(); ++i) {
      flowed[i] = rest_force(relaxation_, contact(i).series);
      s.force[i] = member_[i].now.force;
      s.stiffness[i] = contact(i).series.*stiffness;
    }
    for (int i = 0; i < count(); ++i)
      s.rest[i] = relaxation_.branches > 0 ? member_[i].tool_m - compliance_.displacement(i, flowed)
                                           : member_[i].tool_m;
    const auto answer = [&](int i, const Vec3d& y) noexcept {
      LawState& now = member_[i].now;
      now.relative_m = y;
      const Answer<double> law = respond(i, y);
      now.law_J = law.stored_J;
      return law.force_N * now.energy.share;
    };
    for (int i = 0; i < count(); ++i)
      if (before != nullptr && is_unknown(s.stiffness[i])) {
        before[i] = s.relative_position(i);
        answer(i, before[i]);
        find_tangent(i, s.stiffness[i]);
      }
    const bool is_root = settle(s, matrix, before, answer, tolerance);
    for (int i = 0; i < count(); ++i) {
      member_[i].now.force = s.force[i];
      member_[i].now.residual_N = s.residual_N[i];
      member_[i].now.correction_N = s.correction_N[i];
    }
    return is_root;
  }

  /// With slips, each from where its contact stands.
  bool settle_slipping() noexcept {
    Vec3d before[kMaxContacts];
    for (int i = 0; i < count(); ++i) before[i] = member_[i].before;
    SeriesMatrix matrix;
    return settle_from(before, matrix, &SeriesMemory::slipping_N_m, kSettleTolerance,
                       [&](int i, const Vec3d& y) noexcept { return try_slip(i, y); });
  }
  Answer<double> try_slip(int i, const Vec3d& y) noexcept {
    Contact& from = contact(i);
    SlipTrial& trial = trial_[i];
    static_cast<ContactPlace&>(trial.at) = from;
    trial.report = SlipReport();
    with_law_of(i, [&](auto f, auto is_ball) noexcept {
      using F = decltype(f);
      auto memory = F::template load<double>(from.memory, relaxation_);
      trial.slipped = slip<F, is_ball>(asset_of(i), trial.at, from.cache, trial.cache, from.left, y,
                                       member_[i].at->step, memory, trial.report);
      F::save(memory, trial.at.memory, relaxation_);
    });
    const Answer<double>& law = trial.slipped.law;
    member_[i].now.energy = stored_in(asset_, trial.at, law.stored_J, Memories());
    return law;
  }
  /// With nothing slipping, where contacts stand.
  bool settle_holding(double tolerance) noexcept {
    const auto hold_at = [&](int i, const Vec3d& y) noexcept {
      Contact& at = contact(i);
      LawState& now = member_[i].now;
      const Answer<double> law = with_law_of(i, [&](auto f, auto is_ball) noexcept {
        return hold<decltype(f), is_ball>(asset_of(i), at, at.cache, y, now.depth);
      });
      now.energy = stored_in(asset_, at, law.stored_J, Memories());
      return law;
    };
    return settle_from(nullptr, holding_, &SeriesMemory::holding_N_m, tolerance, hold_at);
  }

  bool has_slipped() const noexcept {
    for (int i = 0; i < count(); ++i)
      if (trial_[i].slipped.is_booked || trial_[i].slipped.is_released) return true;
    return false;
  }

  /// Returns the energy stored before anything slipped: tools where they are, contacts as they
  /// stood. At forces f which the laws answer with f + r the least of E is, where laws are convex,
  /// not below
  ///
  ///     E(f) - 1/2 sum_ij r_i . C_ij r_j                                            (M64b)
  ///
  /// so that a root which was not quite found never counts as energy that was there.
  double settle_before() noexcept {
    LawState slipping[kMaxContacts];
    double each_J[kMaxContacts];
    Vec3d residual_N[kMaxContacts];
    for (int i = 0; i < count(); ++i) slipping[i] = member_[i].now;
    settle_holding(kEnergyTolerance);
    double before_J = compliance_energy_J(each_J);
    for (int i = 0; i < count(); ++i) {
      residual_N[i] = member_[i].now.residual_N;
      before_J += member_[i].now.energy.stored_J;
      member_[i].now = slipping[i];
    }
    return before_J - compliance_.stored_J(residual_N) / relaxation_.fast;
  }

  /// The trials are what happened: contacts stand where they slid to, and those that ended leave
  /// the series. Whether C may be another.
  bool commit() noexcept {
    bool has_moved = false, stays[kMaxContacts];
    for (int i = 0; i < count(); ++i) {
      const Slipped& slipped = trial_[i].slipped;
      const bool is_number = is_finite(slipped.law.force_N) && is_finite(slipped.law.stored_J);
      take(trial_[i], contact(i));
      member_[i].now.depth = slipped.depth;
      member_[i].report = trial_[i].report;
      has_moved = has_moved || slipped.has_moved;
      stays[i] = is_number && !slipped.is_released;
      if (!stays[i]) leave(i, is_number, slipped.is_lifted);
    }
    int kept = 0;
    for (int i = 0; i < count(); ++i)
      if (stays[i]) member_[kept++] = member_[i];
    has_moved = has_moved || kept < count();
    compliance_.count = kept;
    return has_moved;
  }
  void take(const SlipTrial& trial, Contact& to) noexcept {
    static_cast<ContactPlace&>(to) = trial.at;
    with_family(asset_.curves, [&](auto f) noexcept {
      std::memcpy(to.memory, trial.at.memory, sizeof(double) * f.numbers(relaxation_));
    });
    if (trial.slipped.has_moved) to.cache = trial.cache;
  }
  /// The body under it stays where the others have moved it.
  void leave(int i, bool is_number, bool hovers) noexcept {
    SeriesContact& at = *member_[i].at;
    if (!is_number) {
      at.status = Status::force_not_finite;
      at.out->state = ContactState::air;
      forget(*at.contact);
      return;
    }
    Vec3d aside{0, 0, 0};
    for (int j = 0; j < count(); ++j)
      if (j != i)
        aside = aside + times(compliance_.block[i][j],
                              slow_force(relaxation_, contact(j).series, member_[j].now.force));
    end_contact(*at.asset, at, hovers, at.x - aside);
    put(aside, at.contact->series.aside_m);
  }

  /// The body keeps of each contact what its memories keep; returns what is stored then.
  double load_all(double* each_J) noexcept {
    double sum = compliance_energy_J(each_J);
    for (int i = 0; i < count(); ++i) {
      LawState& now = member_[i].now;
      const MemoryEnergy energy =
          load(asset_of(i), contact(i), now.depth.normal_m, now.law_J, Memories());
      each_J[i] += energy.stored_J;
      sum += energy.stored_J;
    }
    return sum;
  }

  void write_output(int i, const Ledger& ledger, double all_J, double own_J,
                    bool is_settled) noexcept {
    const Member& m = member_[i];
    Contact& at = contact(i);
    Output& out = *m.at->out;
    const Vec3d force = m.now.force + m.now.correction_N;
    put(force, at.series.force_N);
    put(m.tool_m - m.now.relative_m, at.series.aside_m);
    at.law_J = m.now.law_J;
    describe(asset_of(i), at, at.cache, m.now.depth, m.tool_m, m.report, out);
    if (!is_settled) out.flags |= PALPATE_FLAG_UNFINISHED;
    if (ledger.debt_J > 0) out.flags |= PALPATE_FLAG_HELD_BACK;
    out.law_share = ledger.share(all_J) * m.now.energy.share;
    put(force * -ledger.share(all_J), out.force_on_tool_N);
    out.stored_J = all_J > 0 ? own_J * (ledger.stored_J(all_J) / all_J) : own_J;
  }

  /// True for a contact that begins, or whose last root was not found. A first step without it goes
  /// as far as the force would press the body, which is further than the tool where much
  /// sways: the law is zero there, and so is its slope. Laws stiffen with
  /// depth, so Newton's steps from the deeper side stay on it.
  static bool is_unknown(const double K[9]) noexcept {
    for (int c = 0; c < 9; ++c)
      if (K[c] != 0) return false;
    return true;
  }
  /// Stiffness of a law along the branches that its slip took, as the memories let it through.
  void find_tangent(int i, double K[9]) noexcept {
    with_law_of(i, [&](auto f, auto is_ball) noexcept {
      const Member& m = member_[i];
      law_tangent<decltype(f), is_ball>(asset_of(i), contact(i), contact(i).left, m.now.relative_m,
                                        m.at->step, K);
      scale_tangent(m.now.energy.share, m.now.energy.slope, trial_[i].slipped.law.force_N, K);
    });
  }
  /// (1 + K C)^-1 K of the contacts of each tool that wants it, which move together.
  void write_tangents(const Ledger& ledger, double all_J) noexcept {
    SeriesMatrix matrix;
    const double* K[kMaxContacts] = {};
    for (int i = 0; i < count(); ++i) K[i] = member_[i].tangent_N_m;
    matrix.factor(compliance_, 1 / relaxation_.fast, K);
    for (int i = 0; i < count(); ++i) {
      double* const out = member_[i].at->tangent_N_m;
      if (out == nullptr || (i > 0 && out == member_[i - 1].at->tangent_N_m)) continue;
      const int tool = member_[i].at->tool;
      Vec3d force{0, 0, 0};
      for (int c = 0; c < 3; ++c) {
        Vec3d column[kMaxContacts], sum{0, 0, 0};
        for (int j = 0; j < count(); ++j) {
          const bool moves = member_[j].at->tool == tool;
          column[j] = moves ? Vec3d{K[j][c], K[j][3 + c], K[j][6 + c]} : Vec3d{0, 0, 0};
          if (c == 0 && moves) force = force + member_[j].now.force + member_[j].now.correction_N;
        }
        matrix.solve(column);
        for (int j = 0; j < count(); ++j)
          if (member_[j].at->tool == tool) sum = sum + column[j];
        out[c] = sum.x;
        out[3 + c] = sum.y;
        out[6 + c] = sum.z;
      }
      scale_tangent(ledger.share(all_J), ledger.share_slope(all_J), force, out);
    }
  }

  const AssetView& asset_;
  const RelaxationView& relaxation_;
  ComplianceMatrix compliance_;
  SeriesMatrix holding_;
  Room<Member, kMaxContacts> member_;
  Room<SlipTrial, kMaxContacts> trial_;
  bool has_tangents_ = false;
};

/// A body's ledger and contacts at one tick: at [count], which have been brought here by
/// approach().
PALPATE_ONCE void tick_contacts(const AssetView& asset, Ledger& ledger, SeriesContact* at,
                                int count) noexcept
#if PALPATE_HAS_BODIES
{
  SeriesContact* only = nullptr;
  int touching = 0;
  for (int i = 0; i < count; ++i)
    if (at[i].status == Status::ok && at[i].contact->triangle >= 0) {
      only = &at[i];
      ++touching;
    }
  if (touching == 0) return ledger.close(0);
  const bool is_compliant =
      asset.sways && compliance_at(asset, only->contact->triangle, only->contact->weight).is_any();
  if (touching > 1 || is_compliant) return Series(asset, at, count).tick(ledger);
  only->status = with_law(*only->asset, only->radius_m, [&](auto f, auto is_ball) noexcept {
    return tick_alone<decltype(f), is_ball>(*only->asset, *only, ledger, only->tangent_N_m);
  });
}
#else
    ;
#endif

}  // namespace palpate::runtime
