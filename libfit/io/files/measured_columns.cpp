#include "libfit/io/files/measured_columns.hpp"

namespace palpate::h5 {
namespace {

const std::vector<std::string> kGradeNames{"good", "fair", "poor"};

}  // namespace

MeasuredRecordings read_measured(const Reader& reader) {
  MeasuredRecordings r;
  if (!reader.has("recordings/experiment")) return r;
  r.experiment = reader.integers("recordings/experiment", kNoUnit, {kAny, 0});
  const std::size_t rows = r.size();
  r.file = reader.strings("recordings/file", rows);
  r.hash = reader.strings("recordings/hash", rows);
  r.contact_m = read_vector(reader, "recordings/contact", "m", rows);
  r.contact_deviation_m = read_vector(reader, "recordings/contact_deviation", "m", rows);
  r.estimator = reader.strings("recordings/estimator", rows);
  r.speed_m_s = read_vector(reader, "recordings/speed", "m/s", rows, true);
  r.noise_N = read_vector(reader, "recordings/noise", "N", rows);
  r.hysteresis = read_vector(reader, "recordings/hysteresis", kNoUnit, rows, true);
  r.young_Pa = read_vector(reader, "recordings/young", "Pa", rows, true);
  r.grade = reader.bytes("recordings/grade", kNoUnit, {rows, 0});
  r.reasons = reader.strings("recordings/reasons", rows);
  return r;
}

void write_measured(Writer& writer, const MeasuredRecordings& r) {
  if (r.size() == 0) return;
  writer.integers("recordings/experiment", kNoUnit, r.experiment.data(), {r.size(), 0});
  writer.strings("recordings/file", r.file);
  writer.strings("recordings/hash", r.hash);
  write_vector(writer, "recordings/contact", "m", r.contact_m);
  write_vector(writer, "recordings/contact_deviation", "m", r.contact_deviation_m);
  writer.strings("recordings/estimator", r.estimator);
  write_vector(writer, "recordings/speed", "m/s", r.speed_m_s);
  write_vector(writer, "recordings/noise", "N", r.noise_N);
  write_vector(writer, "recordings/hysteresis", kNoUnit, r.hysteresis);
  write_vector(writer, "recordings/young", "Pa", r.young_Pa);
  writer.bytes("recordings/grade", kNoUnit, r.grade.data(), {r.size(), 0});
  writer.attribute("recordings/grade", "names", kGradeNames);
  writer.strings("recordings/reasons", r.reasons);
}

void check_measured(const MeasuredRecordings& r, const Complain& complain) {
  const auto rows = static_cast<Eigen::Index>(r.size());
  const auto size = [](const auto& column) { return static_cast<Eigen::Index>(column.size()); };
  check_rows(complain, "recordings/file", size(r.file), rows);
  check_rows(complain, "recordings/hash", size(r.hash), rows);
  check_rows(complain, "recordings/contact", r.contact_m.size(), rows);
  check_rows(complain, "recordings/contact_deviation", r.contact_deviation_m.size(), rows);
  check_rows(complain, "recordings/estimator", size(r.estimator), rows);
  check_rows(complain, "recordings/speed", r.speed_m_s.size(), rows);
  check_rows(complain, "recordings/noise", r.noise_N.size(), rows);
  check_rows(complain, "recordings/hysteresis", r.hysteresis.size(), rows);
  check_rows(complain, "recordings/young", r.young_Pa.size(), rows);
  check_rows(complain, "recordings/grade", size(r.grade), rows);
  check_rows(complain, "recordings/reasons", size(r.reasons), rows);
  if (!r.contact_m.allFinite()) throw complain("recordings/contact", "is not finite");
  if (!r.contact_deviation_m.allFinite() || (r.contact_deviation_m.array() < 0).any())
    throw complain("recordings/contact_deviation", "is not finite and positive");
}

}  // namespace palpate::h5
