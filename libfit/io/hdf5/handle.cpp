#include "libfit/io/hdf5/handle.hpp"

#include <hdf5.h>

#include <type_traits>

namespace palpate::h5 {

static_assert(std::is_same_v<hid_t, std::int64_t>, "HDF5 1.10 or later");

void silence() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

std::string take_reason() {
  std::string reason;
  const auto keep_first = [](unsigned, const H5E_error2_t* entry, void* out) -> herr_t {
    auto& text = *static_cast<std::string*>(out);
    if (text.empty() && entry->desc != nullptr) text = entry->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_first, &reason);
  H5Eclear2(H5E_DEFAULT);
  return reason;
}

}  // namespace palpate::h5
