// Any bytes as a recording of any format but HDF5: refused with place and remedy, or finite. The
// first byte names the format (kSeedFormats), the second and fourth how it is read, the third how
// it is conditioned; the rest is the file.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "libfit/core/error.hpp"
#include "libfit/recordings/batch/batch.hpp"
#include "libfit/recordings/contact_point/contact_point.hpp"
#include "libfit/recordings/formats/importers.hpp"
#include "tests/fuzz/promises.hpp"
#include "tests/fuzz/read_settings.hpp"
#include "tests/fuzz/recording_seeds.hpp"

namespace {

using namespace palpate;
using palpate::fuzz::kSeedFormats;
using palpate::fuzz::promise;

recordings::SignalSettings signal_settings(unsigned char choice) {
  recordings::SignalSettings signal;
  const auto estimators = recordings::contact_estimators();
  signal.contact = estimators[choice % estimators.size()].name;
  signal.use = static_cast<recordings::Use>(choice / 8 % 2);
  signal.drift = static_cast<recordings::Drift>(choice / 24 % 3);
  signal.smooth_s = choice & 64 ? 0.02 : 0;
  return signal;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  if (size < 4) return 0;
  const std::string bytes(reinterpret_cast<const char*>(data) + 4, size - 4);
  for (const auto& row : importers::importers())
    promise(row.name.ends_with("hdf5") || std::ranges::count(kSeedFormats, row.name) > 0,
            "every format is fuzzed");
  const std::string_view format =
      kSeedFormats[static_cast<unsigned char>(data[0] - '0') % kSeedFormats.size()];
  const auto read = palpate::fuzz::read_settings(format, data[1], data[3]);
  try {
    for (const auto& raw : importers::read_recordings("fuzz", bytes, read)) {
      if (raw.unread) continue;
      promise(raw.rows() > 0, "a recording has a row");
      try {
        const auto r = recordings::condition(raw, signal_settings(data[2]), Vec3(0, 0, -1), "fuzz");
        promise(r.deflection_m.allFinite() && r.force_N.allFinite() && r.torque_Nm.allFinite(),
                "samples are finite");
        promise(std::isfinite(r.contact.travel_m) && r.contact.deviation_m >= 0,
                "a contact has a place and a deviation");
      } catch (const Error& error) {
        promise(!error.where().empty() && !error.remedy().empty(), "an error has place and remedy");
      }
    }
  } catch (const Error& error) {
    promise(!error.where().empty() && !error.remedy().empty(), "an error has place and remedy");
  }
  return 0;
}
