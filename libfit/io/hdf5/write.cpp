#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>

#include "libfit/io/hdf5/hdf5.hpp"

namespace palpate::h5 {

static_assert(std::endian::native == std::endian::little,
              "values are stored as they lie in memory");

namespace {

// Made in memory, stored when closed. H5Fget_file_image would do without a path, but in 1.10 it
// spoils the superblock's checksum.
Handle new_file(const std::filesystem::path& partial) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_core(access.id(), 1 << 20, true);                         // grows by a MiB
  H5Pset_libver_bounds(access.id(), H5F_LIBVER_V110, H5F_LIBVER_V110);  // checksummed metadata
  H5Pset_fclose_degree(access.id(), H5F_CLOSE_STRONG);
  const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation.id(), false);
  return Handle(H5Fcreate(partial.c_str(), H5F_ACC_TRUNC, creation.id(), access.id()), H5Fclose);
}

// HDF5 writes the image by the system's calls, whose errno says more than its own stack.
Error cannot_store(const std::filesystem::path& path, int reason) {
  return cannot_write(path, reason != 0 ? std::strerror(reason) : "HDF5: " + take_reason());
}

Handle text_type(std::size_t longest) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.id(), std::max<std::size_t>(longest, 1));
  H5Tset_strpad(type.id(), H5T_STR_NULLPAD);
  H5Tset_cset(type.id(), H5T_CSET_UTF8);
  return type;
}

Handle space_of(Shape shape) {
  const hsize_t dims[2] = {shape.rows, shape.columns};
  return Handle(H5Screate_simple(shape.columns == 0 ? 1 : 2, dims, nullptr), H5Sclose);
}

// Compressed and with a checksum, in chunks of whole rows. HDF5 has no chunks without rows.
Handle storage_of(Shape shape, std::size_t value_bytes) {
  Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation.id(), false);
  H5Pset_fill_time(creation.id(), H5D_FILL_TIME_NEVER);
  if (shape.count() == 0) return creation;
  const std::size_t row_bytes = value_bytes * std::max<std::size_t>(shape.columns, 1);
  // Half of what the HDF5 cache of a data set holds.
  const hsize_t chunk[2] = {std::clamp<std::size_t>((1 << 18) / row_bytes, 1, shape.rows),
                            shape.columns};
  H5Pset_chunk(creation.id(), shape.columns == 0 ? 1 : 2, chunk);
  H5Pset_shuffle(creation.id());
  H5Pset_deflate(creation.id(), 4);  // 6: 1 % less on control values for twice the time
  H5Pset_fletcher32(creation.id());
  return creation;
}

// Strings side by side, each padded with zeros to the longest.
struct PackedStrings {
  std::size_t longest = 1;
  std::string bytes;
};

PackedStrings pack(const std::vector<std::string>& values, const std::string& where) {
  PackedStrings packed;
  for (const auto& value : values) {
    if (value.find('\0') != std::string::npos)
      throw Error(where, "text holds a zero byte", "Take it out of the text.");
    packed.longest = std::max(packed.longest, value.size());
  }
  for (const auto& value : values) {
    packed.bytes += value;
    packed.bytes.resize(packed.bytes.size() + packed.longest - value.size(), '\0');
  }
  return packed;
}

}  // namespace

Writer::Writer(const std::filesystem::path& path, std::string_view schema,
               const Attributes& attributes)
    : path_(path), stored_(path) {
  silence();
  errno = 0;
  file_ = new_file(stored_.partial_path());
  if (!file_.is_valid()) throw cannot_store(path_, errno);
  attribute("", "schema", schema);
  attribute("", "version", kFileVersion);
  for (const auto& [name, value] : attributes) attribute("", name, value);
}

void Writer::check(std::int64_t result, const std::string& name, const std::string& what) const {
  if (result >= 0) return;
  const std::string reason = take_reason();
  throw Error(path_.string() + (name.empty() ? "" : ":" + name),
              what + (reason.empty() ? "" : " (HDF5: " + reason + ")"),
              "Report this; the old file, if any, is untouched.");
}

Handle Writer::group_of(const std::string& name) {
  Handle group(H5Gopen2(file_.id(), "/", H5P_DEFAULT), H5Gclose);
  const Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation.id(), false);
  for (std::size_t at = name.find('/'); at != std::string::npos; at = name.find('/', at + 1)) {
    const std::string path = name.substr(0, at);
    if (H5Lexists(file_.id(), path.c_str(), H5P_DEFAULT) > 0)
      group = Handle(H5Gopen2(file_.id(), path.c_str(), H5P_DEFAULT), H5Gclose);
    else
      group = Handle(H5Gcreate2(file_.id(), path.c_str(), H5P_DEFAULT, creation.id(), H5P_DEFAULT),
                     H5Gclose);
    check(group.id(), path, "group cannot be made");
  }
  return group;
}

Handle Writer::open(const std::string& object) {
  Handle handle(H5Oopen(file_.id(), object.empty() ? "/" : object.c_str(), H5P_DEFAULT), H5Oclose);
  check(handle.id(), object, "no such object");
  return handle;
}

void Writer::put(const std::string& name, std::string_view unit, std::int64_t type,
                 const void* data, Shape shape) {
  const Handle group = group_of(name);
  const std::string leaf = name.substr(name.rfind('/') + 1);
  const Handle space = space_of(shape);
  const Handle storage = storage_of(shape, H5Tget_size(type));
  const Handle set(H5Dcreate2(group.id(), leaf.c_str(), type, space.id(), H5P_DEFAULT, storage.id(),
                              H5P_DEFAULT),
                   H5Dclose);
  check(set.id(), name, "data set cannot be made");
  if (shape.count() > 0)
    check(H5Dwrite(set.id(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), name,
          "data set cannot be written");
  attribute(name, "unit", unit);
}

void Writer::numbers(const std::string& name, std::string_view unit, const double* data,
                     Shape shape) {
  put(name, unit, H5T_IEEE_F64LE, data, shape);
}

void Writer::integers(const std::string& name, std::string_view unit, const std::int32_t* data,
                      Shape shape) {
  put(name, unit, H5T_STD_I32LE, data, shape);
}

void Writer::bytes(const std::string& name, std::string_view unit, const std::int8_t* data,
                   Shape shape) {
  put(name, unit, H5T_STD_I8LE, data, shape);
}

void Writer::strings(const std::string& name, const std::vector<std::string>& values) {
  const PackedStrings packed = pack(values, path_.string() + ":" + name);
  put(name, kNoUnit, text_type(packed.longest).id(), packed.bytes.data(), {values.size(), 0});
}

void Writer::put_attribute(const std::string& object, const std::string& name, std::int64_t type,
                           const Handle& space, const void* data) {
  const Handle attribute(
      H5Acreate2(open(object).id(), name.c_str(), type, space.id(), H5P_DEFAULT, H5P_DEFAULT),
      H5Aclose);
  check(attribute.id(), name, "attribute cannot be made");
  check(H5Awrite(attribute.id(), type, data), name, "attribute cannot be written");
}

void Writer::put_texts(const std::string& object, const std::string& name,
                       const std::vector<std::string>& values, const Handle& space) {
  const PackedStrings packed = pack(values, path_.string() + ":" + name);
  put_attribute(object, name, text_type(packed.longest).id(), space, packed.bytes.data());
}

void Writer::attribute(const std::string& object, const std::string& name, std::string_view value) {
  put_texts(object, name, {std::string(value)}, Handle(H5Screate(H5S_SCALAR), H5Sclose));
}

void Writer::attribute(const std::string& object, const std::string& name, std::int32_t value) {
  put_attribute(object, name, H5T_NATIVE_INT32, Handle(H5Screate(H5S_SCALAR), H5Sclose), &value);
}

void Writer::attribute(const std::string& object, const std::string& name,
                       const std::vector<std::string>& values) {
  put_texts(object, name, values, space_of({values.size(), 0}));
}

void Writer::commit() {
  errno = 0;
  const bool is_stored = H5Fclose(file_.release()) >= 0;
  if (!is_stored) throw cannot_store(path_, errno);
  stored_.commit();
}

}  // namespace palpate::h5
