#pragma once

#include <array>
#include <limits>
#include <span>
#include <string>
#include <string_view>

namespace palpate::fem {

/// Constants as a law's kernel reads them; a law uses the first few.
inline constexpr int kMaxConstants = 8;
using LawConstants = std::array<double, kMaxConstants>;

/// The law's isotropic limit at small strains: shear modulus and Lame's first constant.
struct SmallStrain {
  double mu_Pa = 0;
  double lambda_Pa = 0;

  double bulk_Pa() const { return lambda_Pa + 2 * mu_Pa / 3; }
  double young_Pa() const { return mu_Pa * (3 * lambda_Pa + 2 * mu_Pa) / (lambda_Pa + mu_Pa); }
  double poisson() const { return lambda_Pa / (2 * (lambda_Pa + mu_Pa)); }
};

/// Values of ParameterRow::fallback: the key must be given; or it may be left out, and the law sees
/// NaN in its place.
inline constexpr double kRequired = std::numeric_limits<double>::infinity();
inline constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();

/// A key of [material] in a scene.
/// unit: "" for plain numbers. fallback: the value of a key left out, or kRequired, or kAbsent.
/// count: how many numbers the key holds (a list when more than 1). instead_of: a key that must not
/// be given beside this one.
struct ParameterRow {
  std::string_view name, unit, summary;
  double fallback = kRequired;
  int count = 1;
  std::string_view instead_of = {};
};

/// Why a material's values cannot be used: the key at fault and "must be ...". Empty text: they
/// can.
struct Refusal {
  std::string_view key;
  std::string text;

  bool is_refused() const { return !text.empty(); }
};

}  // namespace palpate::fem
