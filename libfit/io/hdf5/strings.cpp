#include "libfit/io/hdf5/strings.hpp"

#include <hdf5.h>

#include <cstring>

namespace palpate::h5 {
namespace {

std::string trimmed(const char* field, std::size_t size, bool is_space_padded) {
  std::size_t length = ::strnlen(field, size);
  while (is_space_padded && length > 0 && field[length - 1] == ' ') --length;
  return std::string(field, length);
}

bool read_variable(const Handle& type, const Handle& space, std::size_t count,
                   const ReadValues& read, std::vector<std::string>& out) {
  std::vector<char*> texts(count, nullptr);
  if (read(type.id(), texts.data()) < 0) return false;
  for (const char* text : texts) out.emplace_back(text != nullptr ? text : "");
  H5Dvlen_reclaim(type.id(), space.id(), H5P_DEFAULT, texts.data());
  return true;
}

bool read_fixed(const Handle& type, std::size_t count, const ReadValues& read,
                std::vector<std::string>& out) {
  const std::size_t size = H5Tget_size(type.id());
  std::vector<char> packed(count * size);
  if (read(type.id(), packed.data()) < 0) return false;
  const bool is_space_padded = H5Tget_strpad(type.id()) == H5T_STR_SPACEPAD;
  for (std::size_t i = 0; i < count; ++i)
    out.push_back(trimmed(packed.data() + i * size, size, is_space_padded));
  return true;
}

}  // namespace

// The file's own type is the memory type: HDF5 does not convert between character sets.
bool read_strings(const Handle& type, const Handle& space, std::size_t count,
                  const ReadValues& read, std::vector<std::string>& out) {
  return H5Tis_variable_str(type.id()) > 0 ? read_variable(type, space, count, read, out)
                                           : read_fixed(type, count, read, out);
}

}  // namespace palpate::h5
