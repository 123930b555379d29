#include "libfem/solve/factor/blas.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <fstream>
#include <new>
#include <string>
#include <thread>

namespace palpate::fem {
namespace {

// Of /proc/self/status: "Threads:", "VmSize:" [kB].
long long status(const std::string& key) {
  std::ifstream file("/proc/self/status");
  for (std::string word; file >> word;)
    if (long long value = 0; word == key && file >> value) return value;
  return -1;
}

// Before main, once the libraries are loaded.
const long long kThreadsAtStart = status("Threads:");

TEST(blas, loading_it_starts_no_thread) { EXPECT_EQ(kThreadsAtStart, 1); }

TEST(blas, a_thread_that_finds_no_memory_for_it_is_told_so_and_later_finds_it) {
  use_one_blas_thread();
  rlimit before;
  ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
  bool is_refused = false, is_done = false;
  std::thread second([&] {
    const auto now = static_cast<rlim_t>(status("VmSize:")) << 10;
    const rlimit tight{now + (rlim_t{64} << 20), before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_AS, &tight), 0);
    try {
      use_one_blas_thread();
    } catch (const std::bad_alloc&) {
      is_refused = true;
    }
    setrlimit(RLIMIT_AS, &before);
    use_one_blas_thread();
    is_done = true;
  });
  second.join();
  EXPECT_TRUE(is_refused);
  EXPECT_TRUE(is_done);
}

TEST(blas, threads_one_after_the_other_share_their_memory) {
  use_one_blas_thread();
  std::thread(use_one_blas_thread).join();
  const long long before = status("VmSize:");
  for (int i = 0; i < 8; ++i) std::thread(use_one_blas_thread).join();
  EXPECT_LT(status("VmSize:") - before, 100'000);
}

TEST(blas, openblas_is_no_foreign_one) { EXPECT_EQ(foreign_blas(), ""); }

}  // namespace
}  // namespace palpate::fem
