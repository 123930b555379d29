#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/recordings/contact_point/contact_point.hpp"
#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {

/// The way in, as the estimators and the checks see it: W rows, and means of them and of others.
struct Approach {
  RowRange range;
  Eigen::VectorXd travel, push;    ///< W
  double noise_N = 0;              ///< of one reading, without contact
  std::vector<Eigen::Index> rows;  ///< of the signal, that the curve is the means of
  PressCurve curve;
  std::optional<double> wide_contact_m;  ///< of a curve with more free travel
};

/// The way in without its last rows where the force falls already: a soft sensor springs back
/// before the tip does.
RowRange loading_part(const Signal& signal, RowRange range);

/// The rows of `range`, and in the means those of `more` too. Saturated rows are in no mean.
Approach approach_of(const Signal& signal, const RowRange& range,
                     const std::vector<RowRange>& more);

/// Spends the means around the contact point where the press is a small part of the travel: leaves
/// out what lies farther before it than forty, then twelve times the depth, as the power law of
/// this exponent has it. Sets `wide_contact_m` where it leaves anything out, and
/// `curve.least_explained` where the press is under a fifth of the travel.
void focus_on_contact(const Signal& signal, double exponent, Approach& approach);

/// Throws Error (file:line, what, remedy) where the way in holds no contact: too few rows, a force
/// that falls (its sign is reversed), saturates at once, or stays in the noise.
void check_contact(const Signal& signal, const Approach& approach, const std::string& file);

/// Throws Error (file:line, what, remedy) where depth and force both have the other sign: the
/// recording first goes out by as much as it comes in, its force falls below zero meanwhile, and
/// the way in, which is the way back then, bends as no press does. With both signs wrong a curve
/// comes out of the way back, and a modulus two times too large.
void check_sign(const Signal& signal, const Approach& approach, const std::string& file);

/// "file:line" of a row.
std::string place(const std::string& file, const Signal& signal, Eigen::Index row);

}  // namespace palpate::recordings
