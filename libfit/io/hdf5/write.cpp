#include <hdf5.h>

#include <algorithm>
#include <bit>
#include <cassert>

#include "libfit/core/fast_hash.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/hdf5/chunks.hpp"
#include "libfit/io/hdf5/hdf5.hpp"

namespace palpate::h5 {

static_assert(std::endian::native == std::endian::little,
              "values are stored as they lie in memory");

namespace {

constexpr std::size_t kImageGrowth = 1 << 20;  // bytes the memory image grows by
constexpr std::size_t kChunkBytes = 1 << 16;   // small: what is packed anew for one changed row

// Made in memory, stored when closed. H5Fget_file_image would do without a path, but in 1.10 it
// spoils the superblock's checksum.
Handle new_file(const std::filesystem::path& partial) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_core(access.id(), kImageGrowth, true);
  H5Pset_libver_bounds(access.id(), H5F_LIBVER_V110, H5F_LIBVER_V110);  // checksummed metadata
  H5Pset_fclose_degree(access.id(), H5F_CLOSE_STRONG);
  const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation.id(), false);
  return Handle(H5Fcreate(partial.c_str(), H5F_ACC_TRUNC, creation.id(), access.id()), H5Fclose);
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

// Rows of a chunk: whole rows, at least one. HDF5 has no chunks without rows.
std::size_t chunk_rows_of(Shape shape, std::size_t value_bytes) {
  const std::size_t row_bytes = value_bytes * std::max<std::size_t>(shape.columns, 1);
  return std::clamp<std::size_t>(kChunkBytes / row_bytes, 1, std::max<std::size_t>(shape.rows, 1));
}

// Compressed and with a checksum.
Handle storage_of(Shape shape, std::size_t value_bytes) {
  Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation.id(), false);
  H5Pset_fill_time(creation.id(), H5D_FILL_TIME_NEVER);
  if (shape.count() == 0) return creation;
  const hsize_t chunk[2] = {chunk_rows_of(shape, value_bytes), shape.columns};
  H5Pset_chunk(creation.id(), shape.columns == 0 ? 1 : 2, chunk);
  H5Pset_shuffle(creation.id());
  H5Pset_deflate(creation.id(), kDeflateLevel);
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

Writer::Writer(const std::filesystem::path& path, std::string_view schema, int version,
               const Attributes& attributes, const std::filesystem::path& earlier)
    : path_(path), stored_(path) {
  silence();
  earlier_ = open_earlier(earlier.empty() ? path : earlier);
  file_ = new_file(stored_.partial_path());
  check(file_.id(), "", "cannot be written");
  attribute("", "schema", schema);
  attribute("", "version", version);
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
  const std::size_t value_bytes = H5Tget_size(type);
  const Handle storage = storage_of(shape, value_bytes);
  const Handle set(H5Dcreate2(group.id(), leaf.c_str(), type, space.id(), H5P_DEFAULT, storage.id(),
                              H5P_DEFAULT),
                   H5Dclose);
  check(set.id(), name, "data set cannot be made");
  if (shape.count() > 0) put_chunks(set, name, static_cast<const char*>(data), shape, value_bytes);
  attribute(name, "unit", unit);
}

// Chunks that an earlier file has are taken from there: packing them is what costs time. Each is
// handed over packed, in order, so that the bytes do not depend on what was taken.
void Writer::put_chunks(const Handle& set, const std::string& name, const char* data, Shape shape,
                        std::size_t value_bytes) {
  const std::size_t chunk_rows = chunk_rows_of(shape, value_bytes);
  const std::size_t row_bytes = value_bytes * std::max<std::size_t>(shape.columns, 1);
  const EarlierChunks earlier(earlier_, name, value_bytes, chunk_rows);
  std::vector<ChunkHash> hashes;
  std::string padded, bytes;
  for (std::size_t row = 0; row < shape.rows; row += chunk_rows) {
    std::string_view values(data + row * row_bytes,
                            std::min(chunk_rows, shape.rows - row) * row_bytes);
    if (values.size() < chunk_rows * row_bytes) {
      padded.assign(values);
      padded.resize(chunk_rows * row_bytes, '\0');
      values = padded;
    }
    ChunkHash hash{values_hash(values, value_bytes), 0};
    if (!earlier.find(hash.values, bytes, hash.stored)) {
      bytes = packed_chunk(values, value_bytes, kDeflateLevel);
      hash.stored = fast_hash(bytes);
    }
    const hsize_t offset[2] = {row, 0};
    check(H5Dwrite_chunk(set.id(), H5P_DEFAULT, 0, offset, bytes.size(), bytes.data()), name,
          "data set cannot be written");
    hashes.push_back(hash);
    stored_hash_[name] = mix_word(stored_hash_[name], hash.stored);
  }
  const Handle space = space_of({hashes.size(), 2});
  put_attribute(set.id(), kChunkHash, H5T_STD_U64LE, space.id(), hashes.data());
}

std::uint64_t Writer::stored_hash(const std::string& name) const {
  const auto found = stored_hash_.find(name);
  return found == stored_hash_.end() ? 0 : found->second;
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
  const Handle type = text_type(packed.longest);
  put(name, kNoUnit, type.id(), packed.bytes.data(), {values.size(), 0});
}

void Writer::put_attribute(std::int64_t object, const std::string& name, std::int64_t type,
                           std::int64_t space, const void* data) {
  const Handle attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  check(attribute.id(), name, "attribute cannot be made");
  check(H5Awrite(attribute.id(), type, data), name, "attribute cannot be written");
}

void Writer::attribute(const std::string& object, const std::string& name, std::string_view value) {
  const PackedStrings packed = pack({std::string(value)}, path_.string() + ":" + name);
  const Handle type = text_type(packed.longest);
  const Handle scalar(H5Screate(H5S_SCALAR), H5Sclose);
  put_attribute(open(object).id(), name, type.id(), scalar.id(), packed.bytes.data());
}

void Writer::attribute(const std::string& object, const std::string& name, std::int32_t value) {
  const Handle scalar(H5Screate(H5S_SCALAR), H5Sclose);
  put_attribute(open(object).id(), name, H5T_NATIVE_INT32, scalar.id(), &value);
}

void Writer::attribute(const std::string& object, const std::string& name,
                       const std::vector<std::string>& values) {
  const PackedStrings packed = pack(values, path_.string() + ":" + name);
  const Handle type = text_type(packed.longest);
  const Handle space = space_of({values.size(), 0});
  put_attribute(open(object).id(), name, type.id(), space.id(), packed.bytes.data());
}

void Writer::commit() {
  earlier_.reset();
  const bool is_stored = H5Fclose(file_.release()) >= 0;
  if (!is_stored)
    throw Error(path_.string(), "cannot be written (HDF5: " + take_reason() + ")",
                "Choose a folder that exists, can be written and has space.");
  stored_.commit();
}

}  // namespace palpate::h5
