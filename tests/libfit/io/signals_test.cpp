#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libfit/io/files/files.hpp"
#include "tests/libfit/io/scratch.hpp"
#include "tests/libfit/io/tamper.hpp"

namespace palpate::testing_io {
namespace {

class Signals : public ScratchTest {
 protected:
  // A sound recording, and one of which nothing was read.
  static RecordedSignals two() {
    const double none = std::numeric_limits<double>::quiet_NaN();
    RecordedSignals s;
    s.file = {"a.csv", "b.csv#1"}, s.point = {"p", ""}, s.experiment = {0, -1};
    s.grade = {1, kRefusedGrade}, s.reasons = {"begins in contact", "no. Do."};
    s.estimator = {"hertz", ""}, s.contact_m = {1e-3, none};
    s.contact_deviation_m = {1e-5, none}, s.noise_N = {1e-2, none};
    s.bias_N = {0.1, 0}, s.drift_N_m = {2, 0}, s.readings = {2, 0};
    s.time_s = {0, 0.5}, s.travel_m = {0, 2e-3}, s.push_N = {0.1, 0.7};
    s.phase = {0, 2}, s.is_used = {1, 0};
    return s;
  }
};

TEST_F(Signals, come_back_as_they_were_written) {
  write_signals(at("s.h5"), two(), {{"inputs_hash", "00ff"}});
  EXPECT_EQ(schema_of(at("s.h5")), "palpate-signals");
  const RecordedSignals a = read_signals(at("s.h5")), b = two();
  ASSERT_EQ(a.size(), 2u);
  EXPECT_EQ(a.file, b.file);
  EXPECT_EQ(a.point, b.point);
  EXPECT_EQ(a.experiment, b.experiment);
  EXPECT_EQ(a.grade, b.grade);
  EXPECT_EQ(a.reasons, b.reasons);
  EXPECT_EQ(a.estimator, b.estimator);
  EXPECT_EQ(a.contact_m[0], 1e-3);
  EXPECT_TRUE(std::isnan(a.contact_m[1]));
  EXPECT_EQ(a.noise_N[0], 1e-2);
  EXPECT_EQ(a.drift_N_m, b.drift_N_m);
  EXPECT_EQ(a.readings, b.readings);
  EXPECT_EQ(a.time_s, b.time_s);
  EXPECT_EQ(a.push_N, b.push_N);
  EXPECT_EQ(a.phase, b.phase);
  EXPECT_EQ(a.is_used, b.is_used);
}

TEST_F(Signals, of_other_counts_than_readings_are_refused) {
  write_signals(at("s.h5"), two());
  {
    Tamper tamper(at("s.h5"));
    tamper.replace<int>("recordings/readings", "1", H5T_STD_I32LE, H5T_NATIVE_INT, {3, 0}, 0);
  }
  EXPECT_EQ(error_of([&] { read_signals(at("s.h5")); }),
            "s.h5:recordings/readings: do not add up to the rows of readings/push");
}

}  // namespace
}  // namespace palpate::testing_io
