// What samples.h5 says of rows without unpacking them, and chunks copied from the file before.

#include <gtest/gtest.h>

#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/samples_file.hpp"
#include "tests/libfit/io/examples.hpp"
#include "tests/libfit/io/scratch.hpp"
#include "tests/libfit/io/tamper.hpp"

namespace palpate::testing_io {
namespace {

class SamplesIndex : public ScratchTest {};

// Points with `rows` rows each, several chunks a column.
Samples long_samples(int points, Eigen::Index rows) {
  Samples s;
  s.point_position = awkward_points(points, 1);
  s.point_normal = unit_vectors(points, 2);
  for (std::int32_t p = 0; p < points; ++p) {
    s.point_name.push_back("p" + std::to_string(p));
    for (std::int32_t i = 0; i < rows; ++i) {
      s.point.push_back(p), s.experiment.push_back(3 * p), s.step.push_back(i);
      s.kind.push_back(ExperimentKind::press), s.status.push_back(RowStatus::good);
    }
  }
  s.deflection = awkward_points(points * rows, 3), s.force = awkward_points(points * rows, 4);
  s.torque = Points::Zero(points * rows, 3);
  s.force_error = Eigen::VectorXd::Constant(points * rows, 1e-3);
  return s;
}

// Written where no file was before.
std::string fresh_bytes(const std::filesystem::path& path, const Samples& samples) {
  std::filesystem::remove(path);
  write_samples(path, samples);
  return read_whole_file(path);
}

TEST_F(SamplesIndex, rows_of_chosen_points_come_back_bit_for_bit) {
  const Samples s = long_samples(20, 700);
  write_samples(at("s.h5"), s);
  const auto indexed = read_samples_index(at("s.h5"));
  ASSERT_TRUE(indexed);
  EXPECT_EQ(indexed->rows, 14000U);
  EXPECT_TRUE(same_bits(indexed->points.point_position, s.point_position));
  EXPECT_EQ(indexed->index.hash, index_rows(s).hash);
  EXPECT_EQ(indexed->index.first_experiment[5], 15);
  std::vector<char> is_wanted(20, 0);
  is_wanted[4] = is_wanted[19] = 1;
  const Samples part = read_samples_of(at("s.h5"), *indexed, is_wanted);
  ASSERT_EQ(part.rows(), 1400);
  EXPECT_EQ(part.points(), 20);
  EXPECT_EQ(part.point[0], 4);
  EXPECT_EQ(part.experiment[700], 57);
  EXPECT_TRUE(same_bits(Points(part.force.topRows(700)), Points(s.force.middleRows(2800, 700))));
  EXPECT_TRUE(
      same_bits(Points(part.deflection.bottomRows(700)), Points(s.deflection.bottomRows(700))));
}

TEST_F(SamplesIndex, a_row_that_someone_edited_is_noticed) {
  const Samples s = long_samples(4, 5000);
  write_samples(at("s.h5"), s);
  ASSERT_TRUE(read_samples_index(at("s.h5")));
  Tamper(at("s.h5")).poke("rows/force", H5T_NATIVE_DOUBLE, 30011, 0.25);
  EXPECT_FALSE(read_samples_index(at("s.h5")));
  EXPECT_EQ(read_samples(at("s.h5")).force.data()[30011], 0.25);
  write_samples(at("s.h5"), s);
  Tamper(at("s.h5"))
      .replace("rows/status", "1", H5T_STD_I8LE, H5T_NATIVE_INT8,
               std::vector<std::int8_t>(20000, 0), 0);
  EXPECT_FALSE(read_samples_index(at("s.h5")));
  write_samples(at("s.h5"), s);
  Tamper(at("s.h5")).poke("points/row_count", H5T_NATIVE_INT32, 1, std::int32_t{4000});
  EXPECT_FALSE(read_samples_index(at("s.h5")));
}

TEST_F(SamplesIndex, files_of_before_have_none_and_are_read_whole) {
  const Samples s = long_samples(3, 50);
  write_samples(at("s.h5"), s);
  {
    Tamper tamper(at("s.h5"));
    for (const char* name : {"first_row", "row_count", "first_experiment", "rows_hash"})
      tamper.remove("points/" + std::string(name));
  }
  EXPECT_FALSE(read_samples_index(at("s.h5")));
  EXPECT_TRUE(same_bits(read_samples(at("s.h5")).force, s.force));
}

TEST_F(SamplesIndex, rows_of_a_point_here_and_there_have_no_index) {
  Samples s = long_samples(3, 10);
  for (std::size_t i = 20; i < 30; ++i) s.point[i] = 0;
  write_samples(at("s.h5"), s);
  EXPECT_FALSE(read_samples_index(at("s.h5")));
  EXPECT_EQ(read_samples(at("s.h5")).point, s.point);
}

TEST_F(SamplesIndex, the_hash_of_a_point_is_of_its_own_rows_alone) {
  const Samples s = long_samples(4, 30);
  Samples changed = s;
  changed.force(31, 0) += 1e-9;
  for (auto& id : changed.experiment) id += 100;  // one recording more before them
  changed.torque(61, 1) = 1;                      // which no fit reads
  const RowIndex before = index_rows(s), after = index_rows(changed);
  for (std::size_t p = 0; p < 4; ++p) EXPECT_EQ(before.hash[p] == after.hash[p], p != 1) << p;
}

TEST_F(SamplesIndex, a_file_written_over_another_has_the_bytes_it_has_alone) {
  const Samples s = long_samples(20, 700);
  Samples changed = s;
  changed.force(7000, 1) = 0.125;
  const std::string whole = fresh_bytes(at("fresh.h5"), changed);
  write_samples(at("s.h5"), s);
  write_samples(at("s.h5"), changed);
  EXPECT_TRUE(read_whole_file(at("s.h5")) == whole);
  for (const Samples& other :
       {long_samples(20, 699), long_samples(19, 700), long_samples(25, 700)}) {
    write_samples(at("s.h5"), other);
    EXPECT_TRUE(read_whole_file(at("s.h5")) == fresh_bytes(at("fresh.h5"), other));
  }
}

TEST_F(SamplesIndex, chunks_that_someone_changed_are_not_copied) {
  const Samples s = long_samples(20, 700);
  const std::string whole = fresh_bytes(at("fresh.h5"), s);
  write_samples(at("s.h5"), s);
  Tamper(at("s.h5")).poke("rows/force", H5T_NATIVE_DOUBLE, 30011, 0.25);
  write_samples(at("s.h5"), s);
  EXPECT_TRUE(read_whole_file(at("s.h5")) == whole);
  for (std::size_t cut = 100; cut < whole.size(); cut += whole.size() / 7) {
    write_quickly(at("s.h5"), whole.substr(0, cut) + std::string(whole.size() - cut, '\x5a'));
    write_samples(at("s.h5"), s);
    EXPECT_TRUE(read_whole_file(at("s.h5")) == whole) << cut;
  }
}

}  // namespace
}  // namespace palpate::testing_io
