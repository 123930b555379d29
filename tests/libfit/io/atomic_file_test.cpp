#include "libfit/io/atomic_file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "libfit/io/csv/csv.hpp"
#include "libfit/io/files/files.hpp"
#include "tests/libfit/io/examples.hpp"
#include "tests/libfit/io/scratch.hpp"

namespace palpate::testing_io {
namespace {

class AtomicWrite : public ScratchTest {};

TEST_F(AtomicWrite, replaces_the_content_whole) {
  write_file_atomically(at("f"), "old");
  write_file_atomically(at("f"), std::string(3 << 20, 'n'));
  EXPECT_EQ(read_whole_file(at("f")), std::string(3 << 20, 'n'));
  EXPECT_EQ(names(), std::vector<std::string>{"f"});
}

TEST_F(AtomicWrite, writes_beside_the_final_name) {
  write_file_atomically(at("f"), "old");
  AtomicFile file(at("f"));
  EXPECT_EQ(file.partial_path(), at("f.partial-" + std::to_string(::getpid())));
  file.write(std::string(3 << 20, 'n'));
  EXPECT_EQ(read_whole_file(at("f")), "old");
}

TEST_F(AtomicWrite, an_interrupted_write_leaves_the_old_file_and_nothing_else) {
  write_file_atomically(at("f"), "old");
  EXPECT_THROW(
      {
        AtomicFile file(at("f"));
        file.write("half");
        throw std::runtime_error("interrupted");
      },
      std::runtime_error);
  EXPECT_EQ(read_whole_file(at("f")), "old");
  EXPECT_EQ(names(), std::vector<std::string>{"f"});
}

// A full disk, played by a limit on file size in a child process: 0 when the write was refused
// with our Error and the old file stayed alone and whole.
template <class Write>
int on_a_full_disk(const std::filesystem::path& path, const Write& write) {
  const std::string before = read_whole_file(path);
  const pid_t child = ::fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{4096, 4096};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    int code = 1;
    try {
      write();
    } catch (const Error& error) {
      code = error.fact().starts_with("cannot be written") ? 0 : 2;
    }
    ::_exit(code);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  if (!WIFEXITED(status)) return 100;
  return read_whole_file(path) == before ? WEXITSTATUS(status) : 50;
}

TEST_F(AtomicWrite, a_full_disk_leaves_the_old_file_and_nothing_else) {
  write_file_atomically(at("f"), "old");
  EXPECT_EQ(
      on_a_full_disk(at("f"), [&] { write_file_atomically(at("f"), std::string(9999, 'n')); }), 0);
  EXPECT_EQ(names(), std::vector<std::string>{"f"});
  write_curves(at("c.h5"), example_curves());
  EXPECT_EQ(on_a_full_disk(at("c.h5"), [&] { write_curves(at("c.h5"), example_curves()); }), 0);
  EXPECT_EQ(names().size(), 2u);
}

TEST_F(AtomicWrite, missing_folders_folders_and_devices_are_refused) {
  EXPECT_EQ(error_of([&] { write_file_atomically(at("no/f"), "x"); }),
            "no/f: cannot be written: No such file or directory");
  std::filesystem::create_directory(at("d"));
  EXPECT_EQ(error_of([&] { write_file_atomically(at("d"), "x"); }),
            "d: cannot be written: it is a folder");
  ASSERT_EQ(::mkfifo(at("pipe").c_str(), 0600), 0);
  EXPECT_EQ(error_of([&] { write_file_atomically(at("pipe"), "x"); }),
            "pipe: cannot be written: it is not a regular file");
  EXPECT_EQ(error_of([&] { write_curves(at("no/c.h5"), example_curves()); }),
            "no/c.h5: cannot be written: No such file or directory");
}

// Once a pipe without a writer was waited for, and /dev/zero read until memory was full.
TEST_F(AtomicWrite, a_pipe_or_a_device_to_read_is_refused) {
  ASSERT_EQ(::mkfifo(at("pipe").c_str(), 0600), 0);
  EXPECT_EQ(error_of([&] { read_whole_file(at("pipe")); }), "pipe: is no regular file");
  EXPECT_THROW(read_whole_file("/dev/zero"), Error);
}

TEST_F(AtomicWrite, follows_a_symbolic_link) {
  write_file_atomically(at("target"), "old");
  std::filesystem::create_symlink("target", at("link"));
  write_file_atomically(at("link"), "new");
  EXPECT_TRUE(std::filesystem::is_symlink(at("link")));
  EXPECT_EQ(read_whole_file(at("target")), "new");
}

TEST(Hash, agrees_with_published_values) {  // XXH3 of no bytes, xxhash's own sanity checks
  EXPECT_EQ(hex16(hash_of("")), "2d06800538d394c2");
  EXPECT_EQ(hex16(hash_of("", 0x9e3779b185ebca8d)), "a8a6b918b2f0364a");
}

TEST(ContentHash, tells_where_one_input_ends_and_the_next_begins) {
  EXPECT_NE(ContentHash().add("ab").add("c").hex(), ContentHash().add("a").add("bc").hex());
  EXPECT_NE(ContentHash().add("").hex(), ContentHash().hex());
  EXPECT_EQ(ContentHash().add("ab").add("c").hex(), ContentHash().add("ab").add("c").hex());
}

class ContentHashOfFiles : public ScratchTest {};

TEST_F(ContentHashOfFiles, depends_on_content_and_not_on_name) {
  write_file_atomically(at("1"), "same");
  write_file_atomically(at("2"), "same");
  write_file_atomically(at("3"), "other");
  const auto hash = [&](const char* name) { return ContentHash().add_file(at(name)).hex(); };
  EXPECT_EQ(hash("1"), hash("2"));
  EXPECT_NE(hash("1"), hash("3"));
  EXPECT_EQ(hash("1"), ContentHash().add("same").hex());
  EXPECT_EQ(error_of([&] { hash("4"); }), "4: no such file");
}

}  // namespace
}  // namespace palpate::testing_io
