#include "libfem/mesh/fill/fill_steps.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <thread>

#include "libfit/core/error.hpp"

namespace palpate {
namespace {

std::string in_words(int code) { return "threw the int " + std::to_string(code); }

std::string reason_of(const std::function<TetMesh()>& mesher, double cpu_limit_s = 20) {
  const auto result = run_in_child(mesher, in_words, cpu_limit_s);
  return std::holds_alternative<std::string>(result) ? std::get<std::string>(result)
                                                     : "made a mesh";
}

TEST(ChildProcess, hands_a_mesh_over_bit_by_bit) {
  TetMesh made;
  made.nodes = Points::Random(30000, 3);  // more than a pipe would hold
  made.tets = Tets::Constant(50000, 4, 7);
  made.tets(49999, 3) = 29999;
  const auto result = run_in_child([&] { return made; }, in_words, 20);
  const auto& got = std::get<TetMesh>(result);
  EXPECT_EQ(got.nodes, made.nodes);
  EXPECT_EQ(got.tets, made.tets);
}

TEST(ChildProcess, deaths_throws_and_endless_loops_come_back_as_reasons) {
  const auto crash = []() -> TetMesh {
    std::raise(SIGSEGV);
    return {};
  };
  EXPECT_EQ(reason_of(crash).find("stopped on signal 11"), 0U);
  const auto give_up = []() -> TetMesh { std::abort(); };
  EXPECT_EQ(reason_of(give_up).find("stopped on signal 6"), 0U);
  const auto leave = []() -> TetMesh { std::_Exit(9); };
  EXPECT_EQ(reason_of(leave), "ended with exit status 9");
  EXPECT_EQ(reason_of([]() -> TetMesh { throw 3; }), "threw the int 3");
  EXPECT_EQ(reason_of([]() -> TetMesh { throw std::runtime_error("no luck"); }), "no luck");
  const auto loop = []() -> TetMesh {
    while (std::getenv("PALPATE_NO_SUCH_VARIABLE") == nullptr) {
    }
    return {};
  };
  // What only this machine knows is an error: it must not choose another mesher.
  const auto refusal_of = [](const std::function<TetMesh()>& mesher, double limit_s) {
    try {
      return "no error, but: " + reason_of(mesher, limit_s);
    } catch (const Error& error) {
      return error.fact();
    }
  };
  EXPECT_EQ(refusal_of(loop, 0.3),
            "the mesher had not ended after its safety limit of 0.3 CPU seconds");
  const auto sleep = []() -> TetMesh {
    for (;;) std::this_thread::sleep_for(std::chrono::seconds(1));
  };
  EXPECT_EQ(refusal_of(sleep, 0.02),
            "the mesher had not ended after its safety limit of 0.02 CPU seconds");
  EXPECT_EQ(refusal_of([]() -> TetMesh { throw std::bad_alloc(); }, 20),
            "the mesher ran out of memory");
  const auto killed = []() -> TetMesh {
    std::raise(SIGKILL);
    return {};
  };
  EXPECT_NE(refusal_of(killed, 20).find("from outside"), std::string::npos);
}

TEST(ChildProcess, what_the_mesher_prints_is_dropped) {
  testing::internal::CaptureStdout();
  reason_of([]() -> TetMesh {
    std::printf("chatter\n");
    std::fflush(stdout);
    return {};
  });
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

}  // namespace
}  // namespace palpate
