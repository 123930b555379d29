// Damaged files give an Error that says where, or a mesh; never a crash (run under sanitizers too).
#include <gtest/gtest.h>

#include <random>

#include "libfem/mesh/read/read.hpp"
#include "libfit/core/error.hpp"
#include "tests/libfem/mesh/read/sample_files.hpp"

namespace palpate {
namespace {

using namespace mesh_read_test;

constexpr unsigned kSeed = 20260101;
constexpr int kFlips = 150;  // variations of each sample

bool is_tet_sample(const SampleFile& sample) {
  return sample.extension != ".vtk"
             ? tet_mesh_formats().find(sample.extension + " ") != std::string::npos
             : sample.bytes.find("UNSTRUCTURED") != std::string::npos;
}

// True when the file was read; a mesh that comes back must be whole.
bool survives(const std::filesystem::path& path, bool is_tet) {
  try {
    if (is_tet) {
      const TetMesh mesh = read_tet_mesh(path, 1);
      EXPECT_TRUE(mesh.nodes.allFinite());
      EXPECT_GE(mesh.tets.minCoeff(), 0);
      EXPECT_LT(mesh.tets.maxCoeff(), mesh.nodes.rows());
    } else {
      const Surface surface = read_surface(path, 1);
      EXPECT_TRUE(surface.vertices.allFinite());
      EXPECT_GE(surface.triangles.minCoeff(), 0);
      EXPECT_LT(surface.triangles.maxCoeff(), surface.vertices.rows());
    }
    return true;
  } catch (const Error& error) {
    EXPECT_NE(error.where().find("mesh"), std::string::npos) << error.what();
    EXPECT_FALSE(error.fact().empty());
    EXPECT_FALSE(error.remedy().empty());
    return false;
  }
}

std::vector<SampleFile> all_samples() {
  std::vector<SampleFile> samples = surface_samples();
  for (SampleFile& sample : tet_samples()) {
    sample.name = "tets_" + sample.name;
    samples.push_back(std::move(sample));
  }
  return samples;
}

class EveryFormat : public OfSamples {};
INSTANTIATE_TEST_SUITE_P(Samples, EveryFormat, testing::ValuesIn(all_samples()), sample_name);

TEST_P(EveryFormat, cut_short_anywhere_is_an_error_or_a_mesh) {
  const SampleFile& sample = GetParam();
  const std::size_t step = std::max<std::size_t>(sample.bytes.size() / 200, 1);
  int read = 0;
  for (std::size_t size = 0; size < sample.bytes.size(); size += step) {
    SCOPED_TRACE("cut to " + std::to_string(size) + " bytes");
    SampleFile cut = sample;
    cut.bytes.resize(size);
    read += survives(write(cut), is_tet_sample(sample));
  }
  // Most cuts lose something that must be missed; a text file without its last faces is a mesh.
  EXPECT_LT(read, 110) << sample.name;
}

TEST_P(EveryFormat, bytes_flipped_at_random_are_an_error_or_a_mesh) {
  const SampleFile& sample = GetParam();
  std::mt19937 random(kSeed);
  for (int i = 0; i < kFlips; ++i) {
    SampleFile flipped = sample;
    const int flips = 1 + static_cast<int>(random() % 4);
    for (int k = 0; k < flips; ++k)
      flipped.bytes[random() % sample.bytes.size()] = static_cast<char>(random());
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", variation " + std::to_string(i));
    survives(write(flipped), is_tet_sample(sample));
  }
}

TEST_P(EveryFormat, digits_changed_at_random_are_an_error_or_a_mesh) {
  // Text survives random bytes least: change only digits, so that counts and indices go wrong.
  const SampleFile& sample = GetParam();
  std::vector<std::size_t> digits;
  for (std::size_t i = 0; i < sample.bytes.size(); ++i)
    if (sample.bytes[i] >= '0' && sample.bytes[i] <= '9') digits.push_back(i);
  std::mt19937 random(kSeed);
  for (int i = 0; i < kFlips && !digits.empty(); ++i) {
    SampleFile changed = sample;
    changed.bytes[digits[random() % digits.size()]] = static_cast<char>('0' + random() % 10);
    if (i % 3 == 0) changed.bytes.insert(digits[random() % digits.size()], "99999999");
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", variation " + std::to_string(i));
    survives(write(changed), is_tet_sample(sample));
  }
}

TEST_P(EveryFormat, two_files_run_together_are_an_error_or_a_mesh) {
  SampleFile twice = GetParam();
  twice.bytes += twice.bytes;
  survives(write(twice), is_tet_sample(GetParam()));
}

}  // namespace
}  // namespace palpate
