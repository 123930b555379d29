// Any bytes as a recording of any format but HDF5: refused with place and remedy, or finite. Where
// checksums would stop every mutation, they are made good first.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "libfit/core/error.hpp"
#include "libfit/recordings/batch/condition.hpp"
#include "libfit/recordings/contact_point/contact_point.hpp"
#include "libfit/recordings/formats/importers.hpp"
#include "tests/fuzz/promises.hpp"
#include "tests/fuzz/recording_seeds.hpp"

namespace {

using namespace palpate;
using palpate::fuzz::promise;

// The first byte names the format by its row, the second and fourth how it is read, the third how
// it is conditioned; the rest is the file.
importers::ReadSettings read_settings(unsigned char format, unsigned char choice,
                                      unsigned char more) {
  importers::ReadSettings read;
  const auto rows = importers::importers();
  read.format = rows[format % rows.size()].name;
  if (read.format.ends_with("hdf5"))
    read.format = "csv";  // HDF5's own code is not ours to make safe
  const bool names_itself = read.format == "csv" && more & 4;
  if (read.format == "matlab") {
    read.columns.time = "t_s";
    read.columns.depth = "M(:,1)";
    read.columns.force = {"M(:,2)"};
    read.units = {"s", "mm", "N", ""};
  }
  if (read.format == "csv" && !names_itself) {
    read.columns.time = choice & 1 ? "t" : "";
    if (choice & 2) {
      read.columns.position = {"x", "y", "z"};
      read.columns.force = {"fx", "fy", "fz"};
      if (choice & 4) read.columns.torque = {"tx", "ty", "tz"};
    } else {
      read.columns.depth = "z";
      read.columns.force = {"fz"};
    }
  }
  if ((read.format == "csv" && !names_itself) || read.format == "robot-palpation")
    read.units = {"s", "mm", "N", "Nmm"};
  read.is_force_on_tool = (choice & 8) != 0;
  read.drop_invalid = choice & 16;
  if (!(more & 1)) read.cantilever = importers::Cantilever{0.2, 1e-7, 0, 0};
  read.max_bytes = 1 << 20;
  return read;
}

recordings::SignalSettings signal_settings(unsigned char choice) {
  recordings::SignalSettings signal;
  const auto estimators = recordings::contact_estimators();
  signal.contact = estimators[choice % estimators.size()].name;
  signal.use = static_cast<recordings::Use>(choice / 8 % 3);
  signal.drift = static_cast<recordings::Drift>(choice / 24 % 3);
  signal.smooth_s = choice & 64 ? 0.02 : 0;
  return signal;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  if (size < 4) return 0;
  std::string bytes(reinterpret_cast<const char*>(data) + 4, size - 4);
  const auto read = read_settings(static_cast<unsigned char>(data[0] - '0'), data[1], data[3]);
  if (read.format == "jpk" && !(data[3] & 2)) bytes = palpate::fuzz::zip_of_list(bytes);
  if (read.format == "igor" && bytes.size() >= 384 && !(data[3] & 2))
    testing_support::check_igor(bytes);
  try {
    for (const auto& raw : importers::read_recordings("fuzz", bytes, read)) {
      if (raw.unread) continue;
      promise(raw.rows() > 0, "a recording has a row");
      try {
        const auto r = recordings::condition(raw, signal_settings(data[2]), Vec3(0, 0, -1), "fuzz",
                                             read.drop_invalid);
        promise(r.deflection_m.allFinite() && r.force_N.allFinite() && r.torque_Nm.allFinite(),
                "samples are finite");
        promise(std::isfinite(r.contact_travel_m) && r.contact_deviation_m >= 0,
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
