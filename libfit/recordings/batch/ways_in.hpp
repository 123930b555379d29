#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/recordings/batch/condition.hpp"
#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {

/// Where the tip goes into the body.
struct WaysIn {
  std::vector<RowRange> loadings;  ///< of a press in cycles that go deeper and deeper; else none
  std::vector<RowRange> cycles;    ///< other ways whose rows count with those of `range`
  RowRange range, whole;           ///< the part that loads, and all of it
  std::optional<Eigen::Index> broken;  ///< last row before the tool breaks in
};

/// The way in that the settings ask for, up to where the tool breaks in. Says in `recording` that
/// there are others as deep, and how they differ. Throws Error (file:line, what, remedy) where the
/// tip never goes in, or not as often as `cycle` asks for.
WaysIn ways_in(const Signal& signal, const std::vector<Phase>& phases,
               const SignalSettings& settings, const std::string& file, Conditioned& recording);

/// Rows that samples come from. back: the way out after the press.
RowRange used_rows(const Signal& signal, const std::vector<Phase>& phases,
                   const SignalSettings& settings, const WaysIn& ways, const RowRange& back);

}  // namespace palpate::recordings
