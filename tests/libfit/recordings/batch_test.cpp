// Batches: nothing bad stops the rest or disappears, and results do not depend on how they were
// made.

#include <atomic>
#include <cstdio>
#include <functional>

#include "tests/libfit/recordings/batches.hpp"

namespace palpate::recordings {
namespace {

TEST_F(BatchTest, every_bad_recording_is_named_and_no_good_one_is_lost) {
  const auto items = make(300);
  check(items, run_batch(items, {}, {}));
}

TEST_F(BatchTest, results_do_not_depend_on_the_thread_count) {
  const auto items = make(120);
  EXPECT_EQ(outcome(items, run_batch(items, {.jobs = 1}, {}), "one"),
            outcome(items, run_batch(items, {.jobs = 4}, {}), "four"));
}

TEST_F(BatchTest, a_stop_leaves_the_rest_undone) {
  const auto items = make(40);
  std::atomic<std::size_t> done{0};
  Progress progress;
  progress.step = [&](std::size_t n, std::size_t, const std::string&) { done = n; };
  progress.is_stopped = [&] { return done >= 10; };
  std::size_t finished = 0;
  for (const ItemResult& result : run_batch(items, {.jobs = 1}, progress))
    finished += result.is_done;
  EXPECT_EQ(finished, 10u);
}

// A ruled strip through the places of the recordings, and off_m(number) off them.
Surface strip_through(int count, const std::function<double(int)>& off_m) {
  Surface strip{Points(2 * count, 3), Triangles(2 * (count - 1), 3)};
  for (int i = 0; i < count; ++i) {
    const Vec3 place = truth_of(i, kSeed).position_m + Vec3(0, 0, off_m(i));
    strip.vertices.row(2 * i) = place - Vec3(0, 0.02, 0);
    strip.vertices.row(2 * i + 1) = place + Vec3(0, 0.02, 0);
    if (i == 0) continue;
    strip.triangles.row(2 * i - 2) << 2 * i - 2, 2 * i, 2 * i + 1;
    strip.triangles.row(2 * i - 1) << 2 * i - 2, 2 * i + 1, 2 * i - 1;
  }
  return strip;
}

TEST_F(BatchTest, a_contact_less_sure_than_the_surface_is_weighed_with_it) {
  constexpr int kCount = 30;
  const double noise_N = 0.06;
  std::vector<BatchItem> items;
  for (int i = 0; i < kCount; ++i) {
    if (truth_of(i, kSeed).bad >= 0) continue;
    items.push_back(item_of(folder_, i, kSeed));
    write_recording(items.back().file, i, kSeed, noise_N);
  }
  struct Found {
    double rms_mm = 0;
    int within_two_deviations = 0, weighed = 0, all = 0;
  };
  const auto found = [&](const Surface* surface) {
    Found out;
    BatchOptions options;
    options.surface = surface;
    const auto results = run_batch(items, options, {});
    for (std::size_t k = 0; k < items.size(); ++k)
      for (const Conditioned& r : results[k].recordings) {
        const double off_m = r.contact.travel_m + items[k].position_m->z();  // travel is -z
        out.rms_mm += 1e6 * off_m * off_m;
        out.within_two_deviations += std::abs(off_m) <= 2 * r.contact.deviation_m;
        out.weighed += r.contact.estimator.ends_with(", surface");
        ++out.all;
      }
    out.rms_mm = std::sqrt(out.rms_mm / out.all);
    std::printf("contacts %.3f mm rms off, %d of %d within two deviations, %d weighed\n",
                out.rms_mm, out.within_two_deviations, out.all, out.weighed);
    return out;
  };
  const Found alone = found(nullptr);
  std::mt19937 random(kSeed);
  std::normal_distribution<double> normal(0, 1);
  const auto strip = [&](double deviation_m) {
    return strip_through(kCount, [&](int) { return deviation_m * normal(random); });
  };
  const Surface fine = strip(0.05e-3), rough = strip(3e-3);
  const Found with_fine = found(&fine), with_rough = found(&rough);
  EXPECT_LT(with_fine.rms_mm, 0.5 * alone.rms_mm);
  EXPECT_GE(with_fine.within_two_deviations, 0.9 * with_fine.all);
  EXPECT_EQ(with_rough.weighed, 0);
  EXPECT_EQ(with_rough.rms_mm, alone.rms_mm);
}

}  // namespace
}  // namespace palpate::recordings
