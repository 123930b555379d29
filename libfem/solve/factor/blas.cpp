#include "libfem/solve/factor/blas.hpp"

#include <dlfcn.h>
#include <sys/mman.h>

#include <mutex>
#include <new>
#include <set>
#include <vector>

extern "C" {
// OpenBLAS's own, in each of its variants.
void openblas_set_num_threads(int);
void* blas_memory_alloc(int);
void blas_memory_free(void*);
// Present when CHOLMOD was built with OpenMP.
void omp_set_max_active_levels(int) __attribute__((weak));

// How many threads the environment wants: OpenBLAS asks itself when it is loaded, before main, and
// a program's answer precedes a library's. It would otherwise start a thread per core, which spin.
int openblas_num_threads_env();
int openblas_num_threads_env() { return 1; }
}

namespace palpate::fem {
namespace {

constexpr std::size_t kBuffer_bytes = std::size_t{128} << 20;  // OpenBLAS's BUFFER_SIZE on x86-64

// As many of OpenBLAS's buffers are mapped as there are threads that compute with it. They are
// shared, so those of one thread cannot be told from those of another.
class Buffers {
 public:
  void add_thread() {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<void*> taken;
    while (mapped_.size() <= threads_ && is_room()) {
      taken.push_back(blas_memory_alloc(0));
      mapped_.insert(taken.back());
    }
    for (void* buffer : taken) blas_memory_free(buffer);
    if (mapped_.size() <= threads_) throw std::bad_alloc();
    ++threads_;
  }
  void remove_thread() {
    const std::lock_guard<std::mutex> lock(mutex_);
    --threads_;
  }

 private:
  static bool is_room() {
    void* const room =
        ::mmap(nullptr, kBuffer_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return room != MAP_FAILED && ::munmap(room, kBuffer_bytes) == 0;
  }

  std::mutex mutex_;
  std::set<void*> mapped_;
  std::size_t threads_ = 0;
};

Buffers& buffers() {
  static Buffers& all = *new Buffers;  // outlives every thread
  return all;
}

struct ComputingThread {
  ComputingThread() { buffers().add_thread(); }
  ~ComputingThread() { buffers().remove_thread(); }
};

}  // namespace

void use_one_blas_thread() {
  openblas_set_num_threads(1);
  if (omp_set_max_active_levels) omp_set_max_active_levels(0);
  thread_local const ComputingThread buffer;
}

std::string foreign_blas() {
  Dl_info found{};
  if (!::dladdr(::dlsym(RTLD_DEFAULT, "ssyrk_"), &found) || !found.dli_fname) return "";
  void* const library = ::dlopen(found.dli_fname, RTLD_LAZY | RTLD_NOLOAD);
  if (!library) return "";
  const bool is_openblas = ::dlsym(library, "openblas_get_config") != nullptr;  // or of its needed
  ::dlclose(library);
  return is_openblas ? "" : found.dli_fname;
}

}  // namespace palpate::fem
