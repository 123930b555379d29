// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The numbers that the engine is tuned with and the bounds of its inputs. Layout numbers of the
// file are in asset/format.hpp.

#include "rounding.hpp"

namespace palpate::runtime {

// Sizes of local arrays.
constexpr int kMaxDegree = 4;    ///< of splines; a higher degree fits measured curves no better
constexpr int kMaxContacts = 8;  ///< balls and tips of a tick on one body
constexpr int kMaxBranches = 3;  ///< of a Prony series
constexpr int kRings = 8;        ///< 4 are too few; 6 to 24 agree to 0.3 % of force
constexpr int kMaxProfilePoints = 48;     ///< of an indenter
constexpr int kMaxDamagedTriangles = 96;  ///< that one loading visits

// Bounds of inputs, beyond which a number is an error of its unit.
constexpr double kMaxLength_m = 1e3;       ///< coordinates, radii, reaches: floats keep 0.1 mm
constexpr double kMaxForce_N = 1e6;        ///< of a curve, and of a tool's cap: no body carries it
constexpr double kMaxNumber = 1e15;        ///< of a node: products of a few stay finite
constexpr double kMaxDamping_Ns_m = 1e4;   ///< of a tool's damper
constexpr double kMinTimeStep_s = 1e-5;    ///< of a tick that reads time: 100 kHz
constexpr double kMaxTimeStep_s = 1e6;     ///< of a tick that reads time: 12 days
constexpr double kMaxShare = 1000;         ///< of a branch: stiffer at first than any tissue
constexpr double kMinRelaxation_s = 1e-4;  ///< a faster branch is over within a tick
constexpr double kMaxRelaxation_s = 1e6;   ///< a slower branch never moves
constexpr double kMinDamage = 0.01, kMaxDamage = 1e3;  ///< r, m and beta of (M56) [1]
constexpr double kMaxCoupling_m_N = 1e6;               ///< a_k and b_k of (M62)

// Tolerances of rounding.
constexpr double kQuaternionTolerance = 1e-3;  ///< of its length: floats drift, angles must not
constexpr double kLateralZero_m = 1e-12;       ///< below a picometre the lateral direction is noise
constexpr double kEnergyNoise = 1e-13;         ///< of a stored energy, relative; measured 2e-15
constexpr double kMaxDebt_J = 1e300;           ///< of a contact that may store nothing
constexpr double kAlongEdge = 1e-12;  ///< share of a direction below which it follows the edge
constexpr double kVertexTolerance = 1e-15;  ///< area coordinate of a tip aimed at a vertex [1]
constexpr double kSameRadius = 1e-6;        ///< of the radius that curves were measured with
/// Damage of a vertex is rounded up [1]: a contact would store more if a float forgot some of it.
constexpr double kRoundUp = 1 + 3e-7;
/// A flow below it is over [m]: halving for ever ends in numbers that processors are slow with.
constexpr double kMinFlow_m = 1e-30;
/// l^2 over R d (M48a) [1]: on a scanned liver that relaxes, p95 and largest error of held-out
/// paths are 6.3 and 9 %; with half of it 7.6 and 14, with twice 7.4 and 16, where slides renew
/// nothing 11 and 45 (validation.md, "Time").
constexpr double kRenewal = 1.6;

// Slides of a contact point (law/slide.hpp, surface/mesh_surface.hpp).
constexpr int kMaxRootSteps = 12;  ///< Newton needs 1 to 3; 12 bisections leave 1/4096 of a slip
constexpr int kMaxSegments = 16;   ///< of a slip at one tick; 14 were needed on 800 k triangles
constexpr double kSlipTolerance = 1e-10;  ///< of the limit: keeps a solved slip from slipping again
constexpr double kRootTolerance = 1e-12;  ///< of excess_scale: Newton stops there
/// Share of a path at which its end is judged [1]: at a skirt's rim all curves are zero.
constexpr double kPathEndShare = 1 - 1e-9;
constexpr double kMinOpen = 1e-3;     ///< share to which a hollow may shrink a ball's rest triangle
constexpr double kFreeSlip_m = 5e-5;  ///< slip budget of a tick at rest: 50 mm/s at 1 kHz
constexpr double kSlipPerStep = 2;    ///< slip budget for each metre that the tool moves [1]
/// Excess over the limit, as a share of the lateral force, above which a contact point slips [1]: a
/// slide ends within kSlipTolerance. At half, at twice and at a thousand times of it all claims of
/// tests/libfit/runtime/rolling_test.cpp hold.
constexpr double kStickMargin = -1e-6;

// Collision of balls (surface/sweep_ball.hpp).
/// Share of its radius that a ball may lie in the surface and still count as resting on it [1]:
/// after a lift-off the facets may stand above the blended normals' surface by R angle^2 / 2 (0.8 %
/// of R at 14 degrees between facets).
constexpr double kRestShare = 0.05;
constexpr double kMinFacing = 0.01;  ///< least cosine of a normal to its facet or to a ball's arm

// Rings (law/ring_bed.hpp, surface/quadric.hpp).
/// Depth at which a node's curvature is that of the surface of a ball's centres, over that at which
/// its curves end (M15c) [1]. With 0 a hollow counts as too narrow for a ball that is deep in it.
constexpr double kCurvatureDepth = 0.5;
constexpr double kMinHollowShare = 0.25;  ///< of a hollow's radius that an offset leaves (M15b)
constexpr double kMaxLimitShare = 2;      ///< of (B3a), where a concave curve leaves hardly any bed
constexpr double kMinStiffening = 0.2;    ///< of rings beside their test point, on uneven bodies

// Another indenter (law/indenter.hpp, asset/with_indenter.hpp).
constexpr double kNeverDeep_m = 1e30;  ///< depth of a contact that the tool cannot reach
/// Steepness over the measured one up to which the law is known to follow [1]: a body closes around
/// a small ball, whose friction then grows faster than (M84).
constexpr double kMaxSteepness = 1.2;
constexpr int kExtraIndenterPieces = 40;  ///< intervals beside those of the asset
constexpr int kMaxHalvings = 5;           ///< of an interval between two knots of the asset
constexpr double kMinRadiusRatio = 0.4, kMaxRadiusRatio = 2;  ///< range of (M83), over the ball's
/// Bound of k (M83) [1] over 1 - w: at 0.4 of the radius a sixth of the stiffness is left, so that
/// curves rise; twice the bound would let them fall.
constexpr double kMostRadiusEffect = 0.9;
/// Share of the first row's depth below which stiffness is constant [1]. The force there is 1e-4 of
/// the row's; a stiffness of 0 at depth 0 would leave slips there without one.
constexpr double kEvenShare = 0.002;
constexpr double kIndenterTolerance = 2e-4;  ///< of the largest slope of a basis function

// Contacts in series (series/root.hpp).
constexpr int kMaxSettleSteps = 16;        ///< evaluations of each law for one root; 2 to 4 suffice
constexpr double kSettleTolerance = 1e-7;  ///< of the forces, before the last correction
constexpr double kEnergyTolerance = 1e-4;  ///< of forces whose energy alone counts: 1e-8 by (M64b)
constexpr double kSettleZero_N = 1e-12;    ///< a smaller force is noise
constexpr double kMaxErrorRatio = 0.1;     ///< a step that leaves more has a new matrix factored
/// Least move for a secant of a stiffness, over how far the body has moved [1]: a slip is solved to
/// 1e-10 of its limit.
constexpr double kMinSecantMove = 1e-7;
/// Largest s^2 a(0) over a contact's own compliance [1]: below 1 the joint energy of any number of
/// tools stays convex.
constexpr double kMaxCouplingShare = 0.8;

// The ledger (base/ledger.hpp, series/series_contact.hpp).
constexpr double kTank_J = 1e-3;  ///< largest reserve that friction lays by
/// With less than kMinForceShare of a force that is deeper than kMinDepthShare of the curves [1] a
/// contact begins anew: debt falls only as work comes in, and a contact without force does none.
constexpr double kMinForceShare = 0.1, kMinDepthShare = 0.01;

// Damage (contact/body.hpp).
constexpr double kMinDamageReach = 1.5;  ///< over the longest edge: a place needs its vertices
/// Rise of M over w of (M56) at which the vertices are loaded [1]: loading takes several ticks'
/// time, and M rises a little at every tick of a first loading.
constexpr double kDamageStep = 0.05;

// The shape response (contact/deform.hpp).
constexpr double kShapeReach = 8;  ///< range of near functions, in contact radii
constexpr double kShapeEnd = kShapeReach / (1 + kShapeReach);  ///< the same as s / (1 + s)
/// Share of the rings' mean deflection that the surface under a tool follows [1]: of 0.7 to 1.1 the
/// best on held-out paths of the liver phantom (near p95 5.1 %; 5.5 at 1).
constexpr double kShapeCarried = 0.8;

// Tools (tool/tool.hpp).
/// Roll of a ball, over its radius [1], within which its torque rises or falls: at once the torque
/// would jump. Chosen: nobody senses 40 um of a ball of 4 mm. At half and at twice of it all claims
/// of tests/libfit/runtime/rolling_test.cpp hold.
constexpr double kRollOnset = 0.01;

}  // namespace palpate::runtime
