// One build on several kinds of processor: those without AVX-512, and a C library that takes no
// variant of a function with FMA. Tunables of glibc hide both from the program.

#include <algorithm>

#include "tests/tools/block_scene.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

// The block with exponential fibres, a stiffer ball inside, presses and drags.
class Processors : public BlockRun {
 protected:
  void SetUp() override {
    const std::string text =
        replaced(kScene, "young = \"10 kPa\"\n",
                 "law = \"holzapfel-gasser-ogden\"\nshear = \"3.4 kPa\"\nk1 = \"10 kPa\"\n"
                 "k2 = 2\nfibre = [1, 0, 0]\n");
    folder.write("scene.toml", text + R"([[inclusion]]
sphere = { center = ["40 mm", "40 mm", "20 mm"], radius = "6 mm" }
[inclusion.material]
young = "60 kPa"
poisson = 0.45
)");
  }

  Outcome palpate_on(const std::string& hidden, const std::string& arguments) {
    return shell(folder, "GLIBC_TUNABLES=glibc.cpu.hwcaps=" + hidden + " " + PALPATE_PROGRAM + " " +
                             arguments);
  }

  void expect_same_files(const std::string& one, const std::string& other) {
    for (const char* file : {"body.h5", "samples.h5", "curves.h5", "model.h5", "asset.palp"}) {
      const std::string content = content_of(folder / one / file);
      EXPECT_FALSE(content.empty()) << file;
      EXPECT_TRUE(content == content_of(folder / other / file)) << file << " of " << other;
    }
  }
};

constexpr const char* kOlder = "-AVX512F,-AVX512VL,-AVX512BW,-AVX512DQ,-AVX512CD,-FMA,-FMA4";

TEST_F(Processors, with_avx2_make_the_same_bytes_alone_and_as_shards) {
  const Outcome young = palpate_on("", "run scene.toml -o young --jobs 2");
  const Outcome old = palpate_on(kOlder, "run scene.toml -o old --jobs 2");
  ASSERT_TRUE(young.status == 0 || young.status == 3) << young.said();
  EXPECT_EQ(old.status, young.status) << old.said();
  expect_same_files("young", "old");

  for (const char* shard : {"1", "2"})
    ASSERT_EQ(palpate_on(*shard == '1' ? "" : kOlder,
                         std::string("simulate scene.toml -o shards --shard ") + shard + "/2")
                  .status,
              0);
  ASSERT_EQ(palpate_on("", "merge shards -o merged.h5").status, 0);
  EXPECT_TRUE(content_of(folder / "merged.h5") == content_of(folder / "young" / "samples.h5"));
}

TEST_F(Processors, without_avx2_compute_as_well_and_say_whose_digits_these_are) {
  ASSERT_EQ(palpate_on("", "prepare scene.toml -o body.h5").status, 0);
  folder.write("one.csv", "x_m,y_m,z_m\n0.04,0.04,0.03\n");
  const std::string simulate = "simulate body.h5 --points one.csv -o ";
  const Outcome young = palpate_on("", simulate + "young.h5");
  const Outcome old = palpate_on("-AVX2,-AVX512F", simulate + "old.h5");
  ASSERT_EQ(old.status, 0) << old.err;
  const std::string line = "this processor has no AVX2 with FMA";
  EXPECT_FALSE(holds(young.err, line));
  const std::size_t at = old.err.find(line);
  ASSERT_NE(at, std::string::npos) << old.err;
  EXPECT_EQ(old.err.find(line, at + 1), std::string::npos) << old.err;
}

}  // namespace
}  // namespace palpate::tools
