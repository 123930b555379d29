#include "libfit/io/hdf5/chunks.hpp"

#include <hdf5.h>
#include <zlib.h>

#include <cassert>

#include "libfit/core/fast_hash.hpp"

namespace palpate::h5 {
namespace {

// Bytes of one significance side by side, as HDF5's shuffle filter lays them.
std::string shuffled(std::string_view values, std::size_t value_bytes) {
  std::string out(values.size(), '\0');
  const std::size_t count = values.size() / value_bytes;
  for (std::size_t k = 0; k < value_bytes; ++k)
    for (std::size_t i = 0; i < count; ++i) out[k * count + i] = values[i * value_bytes + k];
  return out;
}

// Checksum of HDF5's fletcher32 filter: sums of big-endian 16-bit words.
std::uint32_t fletcher32(std::string_view bytes) {
  constexpr std::size_t kBeforeFold = 360;  // words that cannot overflow 32 bits
  const auto byte = [&](std::size_t i) {
    return static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i]));
  };
  std::uint32_t sum1 = 0, sum2 = 0;
  const auto fold = [&] {
    sum1 = (sum1 & 0xffff) + (sum1 >> 16);
    sum2 = (sum2 & 0xffff) + (sum2 >> 16);
  };
  const std::size_t words = bytes.size() / 2;
  for (std::size_t i = 0; i < words;) {
    for (const std::size_t end = std::min(words, i + kBeforeFold); i < end; ++i) {
      sum1 += byte(2 * i) << 8 | byte(2 * i + 1);
      sum2 += sum1;
    }
    fold();
  }
  if (bytes.size() % 2 != 0) {
    sum1 += byte(bytes.size() - 1) << 8;
    sum2 += sum1;
    fold();
  }
  fold();
  return sum2 << 16 | sum1;
}

}  // namespace

std::uint64_t values_hash(std::string_view values, std::size_t value_bytes) {
  static const std::uint64_t packing = fast_hash(zlibVersion(), kDeflateLevel);
  return fast_hash(values, mix_word(packing, value_bytes));
}

std::string packed_chunk(std::string_view values, std::size_t value_bytes, unsigned deflate_level) {
  const std::string plain = value_bytes > 1 ? shuffled(values, value_bytes) : std::string(values);
  uLongf length = compressBound(static_cast<uLong>(plain.size()));
  std::string packed(length, '\0');
  [[maybe_unused]] const int result =
      compress2(reinterpret_cast<Bytef*>(packed.data()), &length,
                reinterpret_cast<const Bytef*>(plain.data()), static_cast<uLong>(plain.size()),
                static_cast<int>(deflate_level));
  assert(result == Z_OK);
  packed.resize(length);
  const std::uint32_t sum = fletcher32(packed);
  for (int k = 0; k < 4; ++k) packed.push_back(static_cast<char>(sum >> 8 * k & 0xff));
  return packed;
}

bool read_chunk(std::int64_t data_set, std::size_t row, std::uintmax_t max_bytes,
                std::string& bytes) {
  const hsize_t offset[2] = {row, 0};
  hsize_t length = 0;
  std::uint32_t skipped_filters = 0;
  if (H5Dget_chunk_storage_size(data_set, offset, &length) < 0 || length == 0 || length > max_bytes)
    return false;
  bytes.resize(length);
  return H5Dread_chunk(data_set, H5P_DEFAULT, offset, &skipped_filters, bytes.data()) >= 0 &&
         skipped_filters == 0;
}

EarlierChunks::EarlierChunks(const Handle& file, const std::string& name, std::size_t value_bytes,
                             std::size_t chunk_rows)
    : chunk_rows_(chunk_rows) {
  if (!file.is_valid()) return;
  set_ = Handle(H5Dopen2(file.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!set_.is_valid() || H5Aexists(set_.id(), kChunkHash) <= 0) return;
  const Handle creation(H5Dget_create_plist(set_.id()), H5Pclose);
  const Handle type(H5Dget_type(set_.id()), H5Tclose);
  hsize_t chunk[2] = {0, 0};
  if (H5Pget_layout(creation.id()) != H5D_CHUNKED || H5Pget_chunk(creation.id(), 2, chunk) < 0 ||
      chunk[0] != chunk_rows || H5Tget_size(type.id()) != value_bytes)
    return;
  const Handle hashes(H5Aopen(set_.id(), kChunkHash, H5P_DEFAULT), H5Aclose);
  const Handle space(H5Aget_space(hashes.id()), H5Sclose);
  hsize_t dims[2] = {0, 0};
  if (H5Fget_filesize(file.id(), &file_bytes_) < 0 || H5Sget_simple_extent_ndims(space.id()) != 2 ||
      H5Sget_simple_extent_dims(space.id(), dims, nullptr) < 0 || dims[1] != 2 ||
      dims[0] > file_bytes_ / sizeof(ChunkHash))
    return;
  std::vector<ChunkHash> hash(dims[0]);
  if (H5Aread(hashes.id(), H5T_NATIVE_UINT64, hash.data()) < 0) return;
  for (std::size_t i = 0; i < hash.size(); ++i)
    chunk_.emplace(hash[i].values, std::pair(i, hash[i].stored));
}

bool EarlierChunks::find(std::uint64_t values, std::string& bytes, std::uint64_t& stored) const {
  const auto found = chunk_.find(values);
  if (found == chunk_.end() ||
      !read_chunk(set_.id(), found->second.first * chunk_rows_, file_bytes_, bytes))
    return false;
  stored = fast_hash(bytes);
  return stored == found->second.second;
}

Handle open_earlier(const std::filesystem::path& path) {
  std::error_code ignored;
  if (path.empty() || !std::filesystem::is_regular_file(path, ignored) ||
      H5Fis_hdf5(path.c_str()) <= 0)
    return {};
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fclose_degree(access.id(), H5F_CLOSE_STRONG);
  H5Pset_file_locking(access.id(), false, true);
  return Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.id()), H5Fclose);
}

}  // namespace palpate::h5
