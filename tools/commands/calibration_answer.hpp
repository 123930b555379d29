#pragma once

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "libfem/calibrate/identify.hpp"
#include "libfem/materials/materials.hpp"
#include "libfit/core/text.hpp"
#include "libfit/core/units.hpp"
#include "tools/scene/canonical.hpp"

namespace palpate::tools {

/// The first line of what `calibrate` writes.
inline constexpr std::string_view kCalibrationHeading = "# Calibrated by palpate";

struct NamedParameter {
  std::string name;
  bool is_modulus = false, is_number = true;  ///< else a component of a direction
};

/// Names of a law's values, one each.
inline std::vector<NamedParameter> names_of(const fem::MaterialParameters& material) {
  std::vector<NamedParameter> out;
  for (const fem::ParameterRow& row : fem::find_law(material.law, "law").parameters)
    for (int k = 0; k < row.count; ++k)
      out.push_back({std::string(row.name), !row.unit.empty(), row.count == 1});
  return out;
}

/// Pressures in the unit that suits the largest of them.
struct PressureUnit {
  explicit PressureUnit(double largest_Pa)
      : name(largest_Pa >= 1e6   ? "MPa"
             : largest_Pa >= 1e3 ? "kPa"
                                 : "Pa"),
        size_Pa(*unit_factor(name, Dimension::pressure)) {}
  std::string name;
  double size_Pa;
};

/// A value as a scene has it.
inline std::string in_toml(double value, bool is_modulus) {
  if (!is_modulus) return number(value, 6);
  const PressureUnit unit(std::abs(value));
  return fmt::format("\"{} {}\"", number(value / unit.size_Pa, 6), unit.name);
}

/// "2.1 ± 0.03 kPa".
inline std::string with_deviation(double value, double deviation, bool is_modulus) {
  if (!is_modulus) return fmt::format("{:.4g} ± {:.2g}", value, deviation);
  const PressureUnit unit(std::abs(value));
  return fmt::format("{:.4g} ± {:.2g} {}", value / unit.size_Pa, deviation / unit.size_Pa,
                     unit.name);
}

/// What was found, in words, as JSON and as values of [material].
class CalibrationAnswer {
 public:
  /// is_stated: some rows state their error.
  CalibrationAnswer(const fem::Identification& found, Eigen::Index rows, bool is_stated)
      : found_(found), names_(names_of(found.material)), rows_(rows), is_stated_(is_stated) {}

  std::string value_in_words(std::size_t k) const {
    const std::size_t i = found_.free[k];
    return with_deviation(found_.material.values[i], found_.deviation(k), names_[i].is_modulus);
  }
  std::string in_words() const {
    std::string text =
        fmt::format("{:<12} {:>26}  95 %\n", found_.material.law, "value, deviation");
    for (std::size_t k = 0; k < found_.free.size(); ++k) {
      const std::size_t i = found_.free[k];
      const double value = found_.material.values[i],
                   half = found_.half_width * found_.deviation(k);
      const PressureUnit unit(names_[i].is_modulus ? std::abs(value) : 1);
      text += fmt::format("{:<12} {:>26}  {:.4g} to {:.4g}\n", names_[i].name, value_in_words(k),
                          (value - half) / unit.size_Pa, (value + half) / unit.size_Pa);
    }
    for (std::size_t k = 1; k < found_.free.size(); ++k)
      for (std::size_t m = 0; m < k; ++m)
        text += fmt::format(
            "correlation of {} and {}: {:.3f}\n", name(m), name(k),
            found_.correlation(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(m)));
    text += is_stated_ ? fmt::format("{} rows; residuals {:.2g} of the stated errors", rows_,
                                     found_.misfit)
                       : fmt::format("{} rows; residuals {:.3g} N rms", rows_,
                                     std::sqrt(found_.sum_of_squares / static_cast<double>(rows_)));
    if (found_.rows_each > 1)
      text += fmt::format(", {:.2g} rows go together as one", found_.rows_each);
    const std::string doubt = undetermined();
    return doubt.empty() ? text : text + "\n" + doubt;
  }
  /// The parameters that the rows do not determine, in a sentence; empty where they do.
  std::string undetermined() const {
    if (found_.are_told_apart) return {};
    std::vector<std::string> all;
    for (std::size_t k = 0; k < found_.free.size(); ++k) all.push_back(name(k));
    return all.size() == 1 ? fmt::format("the rows do not determine {}", all.front())
                           : fmt::format("the rows do not tell {} apart", listed(all, ", "));
  }
  nlohmann::ordered_json json() const {
    nlohmann::ordered_json parameters = nlohmann::ordered_json::array(),
                           correlation = nlohmann::ordered_json::array();
    for (std::size_t k = 0; k < found_.free.size(); ++k) {
      const std::size_t i = found_.free[k];
      const double value = found_.material.values[i],
                   half = found_.half_width * found_.deviation(k);
      parameters.push_back({{"name", names_[i].name},
                            {"unit", names_[i].is_modulus ? "Pa" : "1"},
                            {"value", value},
                            {"deviation", found_.deviation(k)},
                            {"low", value - half},
                            {"high", value + half}});
      nlohmann::ordered_json line = nlohmann::ordered_json::array();
      for (std::size_t m = 0; m < found_.free.size(); ++m)
        line.push_back(
            found_.correlation(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(m)));
      correlation.push_back(line);
    }
    return {{"law", found_.material.law},
            {"parameters", parameters},
            {"correlation", correlation},
            {"told_apart", found_.are_told_apart},
            {"rows", rows_},
            {"misfit", found_.misfit},
            {"rows_each", found_.rows_each},
            {"sum_of_squares", found_.sum_of_squares},
            {"converged", found_.is_converged}};
  }
  /// Values of [material], and of a modulus the deviation that the statement's interval
  /// needs (M11d).
  std::vector<NewValue> values() const {
    std::vector<NewValue> out;
    for (std::size_t k = 0; k < found_.free.size(); ++k) {
      const auto& [name, is_modulus, is_number] = names_[found_.free[k]];
      const double value = found_.material.values[found_.free[k]];
      out.push_back({"material", name, in_toml(value, is_modulus)});
      // A modulus that the rows do not determine has the key's bound, which a scene can hold.
      if (name == "young" || name == "shear")
        out.push_back(
            {"validate", "young_deviation", number(std::fmin(found_.deviation(k) / value, 10), 2)});
    }
    return out;
  }
  std::string heading() const {
    std::string line(kCalibrationHeading);
    for (std::size_t k = 0; k < found_.free.size(); ++k)
      line += fmt::format("{} {} = {}", k == 0 ? ":" : ",", name(k), value_in_words(k));
    return line + "\n";
  }

 private:
  std::string name(std::size_t k) const { return names_[found_.free[k]].name; }

  const fem::Identification& found_;
  std::vector<NamedParameter> names_;
  Eigen::Index rows_;
  bool is_stated_;
};

}  // namespace palpate::tools
