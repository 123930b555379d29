// A fuzzer's main where libFuzzer is not: mutates seeds for a bounded time, or runs given files.
//   PROGRAM [--seconds N] [--seed S] [FILE...]        a folder stands for the files in it

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>

#include "tests/fuzz/seeds.hpp"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size);

namespace {

using palpate::fuzz::Bytes;

// What a hostile writer would put where a number is.
constexpr std::int64_t kAwkward[] = {0,          -1,         1,          127,     128,    255,
                                     0x7fffffff, 0x80000000, 0xffffffff, 1 << 16, 1 << 26};
constexpr double kAwkwardReal[] = {0.0, -0.0, 1e-300, 1e300, -1.0, 1e15};

void mutate(Bytes& bytes, std::mt19937_64& random) {
  const auto below = [&](std::size_t n) {
    return static_cast<std::size_t>(random() % std::max<std::size_t>(n, 1));
  };
  const std::size_t edits = 1 + below(6);
  for (std::size_t edit = 0; edit < edits && !bytes.empty(); ++edit) {
    const std::size_t at = below(bytes.size());
    const auto overwrite = [&](const void* value, std::size_t size) {
      const std::size_t aligned = at / size * size;
      if (aligned + size <= bytes.size()) std::memcpy(bytes.data() + aligned, value, size);
    };
    switch (below(8)) {
      case 0:
        bytes[at] ^= static_cast<unsigned char>(1 << below(8));
        break;
      case 1:
        bytes[at] = static_cast<unsigned char>(random());
        break;
      case 2: {
        const auto value = static_cast<std::int32_t>(kAwkward[below(std::size(kAwkward))]);
        overwrite(&value, sizeof value);
        break;
      }
      case 3: {
        const double value =
            below(4) == 0 ? std::nan("") : kAwkwardReal[below(std::size(kAwkwardReal))];
        overwrite(&value, sizeof value);
        break;
      }
      case 4: {
        const float value = below(4) == 0 ? std::nanf("") : float(kAwkwardReal[below(3)]);
        overwrite(&value, sizeof value);
        break;
      }
      case 5:  // small integers drift: indices, counts
        bytes[at] = static_cast<unsigned char>(bytes[at] + below(7) - 3);
        break;
      case 6: {
        const std::size_t from = below(bytes.size()),
                          size = below(
                              std::min(bytes.size() - std::max(from, at), std::size_t{64}) + 1);
        std::memmove(bytes.data() + at, bytes.data() + from, size);
        break;
      }
      default:
        if (below(8) == 0) bytes.resize(at);
    }
  }
}

Bytes to_bytes(const std::string& text) { return {text.begin(), text.end()}; }

Bytes current;  // what runs now, for the report of a crash

void write_failure() {
  if (std::FILE* file = std::fopen("fuzz-failure.bin", "wb")) {
    std::fwrite(current.data(), 1, current.size(), file);
    std::fclose(file);
  }
}

void run(const Bytes& bytes) {
  current = bytes;
  LLVMFuzzerTestOneInput(current.data(), current.size());
}

}  // namespace

// Called by the sanitizers and by abort().
extern "C" void __asan_on_error() { write_failure(); }

int main(int argc, char** argv) {
  double seconds = 5;
  std::uint64_t seed = 1;
  std::vector<Bytes> given;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--seconds") == 0 && i + 1 < argc) {
      seconds = std::atof(argv[++i]);
    } else if (std::strcmp(argv[i], "--seed") == 0 && i + 1 < argc) {
      seed = std::strtoull(argv[++i], nullptr, 10);
    } else if (std::filesystem::is_directory(argv[i])) {
      for (const auto& entry : std::filesystem::directory_iterator(argv[i]))
        given.push_back(to_bytes(palpate::read_whole_file(entry.path())));
    } else {
      run(to_bytes(palpate::read_whole_file(argv[i])));
      std::printf("%s: no promise broken\n", argv[i]);
      return 0;
    }
  }
  if (given.empty()) {
    given.push_back(palpate::fuzz::asset_seed(PALPATE_GOLDEN));
    for (int kind = 0; kind < 4; ++kind) given.push_back(palpate::fuzz::ticks_seed(kind));
  }
  std::signal(SIGABRT, [](int) { write_failure(); });
  std::printf("seed %llu, %g s\n", static_cast<unsigned long long>(seed), seconds);
  std::fflush(stdout);
  std::mt19937_64 random(seed);
  for (const Bytes& bytes : given) run(bytes);
  const auto started = std::chrono::steady_clock::now();
  long runs = 0;
  while (std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count() <
         seconds) {
    Bytes bytes = given[random() % given.size()];
    mutate(bytes, random);
    run(bytes);
    ++runs;
  }
  std::printf("%ld inputs, no promise broken\n", runs);
  return 0;
}
