#include <gtest/gtest.h>

#include <cmath>

#include "libfit/io/files/files.hpp"
#include "tests/libfit/io/scratch.hpp"
#include "tests/libfit/io/tamper.hpp"

namespace palpate::testing_io {
namespace {

class Signals : public ScratchTest {
 protected:
  // A sound recording, and one of which nothing was read.
  static std::vector<RecordedSignal> two() {
    std::vector<RecordedSignal> signals(2);
    signals[0].file = "a.csv", signals[0].point = "p", signals[0].experiment = 0;
    signals[0].grade = 1, signals[0].reasons = "begins in contact", signals[0].estimator = "hertz";
    signals[0].contact_m = 1e-3, signals[0].contact_deviation_m = 1e-5, signals[0].noise_N = 1e-2;
    signals[0].trace = {{0, 0.5f}, {0, 2e-3f}, {0.1f, 0.7f}, {0, 2}, {1, 0}, 0.1, 2};
    signals[1].file = "b.csv#1", signals[1].grade = kRefusedGrade, signals[1].reasons = "no. Do.";
    return signals;
  }
};

TEST_F(Signals, come_back_as_they_were_written) {
  write_signals(at("s.h5"), two(), {{"inputs_hash", "00ff"}});
  EXPECT_EQ(schema_of(at("s.h5")), "palpate-signals");
  const auto back = read_signals(at("s.h5"));
  ASSERT_EQ(back.size(), 2u);
  const RecordedSignal a = back[0], b = two()[0];
  EXPECT_EQ(a.file, b.file);
  EXPECT_EQ(a.experiment, 0);
  EXPECT_EQ(a.grade, 1);
  EXPECT_EQ(a.reasons, b.reasons);
  EXPECT_EQ(a.estimator, b.estimator);
  EXPECT_EQ(a.contact_m, 1e-3);
  EXPECT_EQ(a.noise_N, 1e-2);
  EXPECT_EQ(a.trace.time_s, b.trace.time_s);
  EXPECT_EQ(a.trace.push_N, b.trace.push_N);
  EXPECT_EQ(a.trace.phase, b.trace.phase);
  EXPECT_EQ(a.trace.is_used, b.trace.is_used);
  EXPECT_EQ(a.trace.drift_N_m, 2);
  EXPECT_EQ(back[1].experiment, -1);
  EXPECT_EQ(back[1].trace.readings(), 0u);
  EXPECT_TRUE(std::isnan(back[1].contact_m));
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
