#include <algorithm>

#include "libfit/core/text.hpp"
#include "libfit/recordings/placing/assemble.hpp"

namespace palpate::recordings {
namespace {

template <class List>
auto named(const List& list, const std::string& name) -> decltype(&list[0]) {
  const auto found = std::ranges::find_if(list, [&](const auto& one) { return one.name == name; });
  return found == list.end() ? nullptr : &*found;
}

}  // namespace

std::vector<RecordedSignal> signals_of(const std::vector<BatchItem>& items,
                                       const std::vector<ItemResult>& results,
                                       const Assembled& assembled) {
  std::vector<RecordedSignal> all;
  for (const Outcome& outcome : assembled.outcomes) {
    const ItemResult& result = results[outcome.item];
    RecordedSignal signal;
    signal.file = items[outcome.item].shown + (outcome.name.empty() ? "" : "#" + outcome.name);
    signal.point = outcome.point;
    signal.experiment = outcome.experiment;
    if (const Conditioned* r = named(result.recordings, outcome.name)) {
      signal.grade = static_cast<std::int8_t>(r->grade);
      signal.reasons = listed(r->reasons, "; ");
      const FoundContact contact = contact_of(*r, outcome.aligned);
      signal.estimator = contact.estimator;
      signal.contact_m = contact.travel_m;
      signal.contact_deviation_m = contact.deviation_m;
      signal.noise_N = r->noise_N;
      signal.trace = r->trace;
    } else {
      const Refused* refused = named(result.refused, outcome.name);
      signal.trace = refused ? refused->trace : result.trace;
    }
    if (outcome.failure) {
      signal.grade = kRefusedGrade;
      const std::string& what = outcome.failure->what;
      signal.reasons = what + (what.ends_with('?') ? " " : ". ") + outcome.failure->remedy;
    }
    all.push_back(std::move(signal));
  }
  return all;
}

}  // namespace palpate::recordings
