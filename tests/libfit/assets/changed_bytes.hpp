#pragma once

#include <gtest/gtest.h>

#include <cstring>

#include "tests/libfit/runtime/golden/golden_asset.hpp"

namespace palpate::test {

using runtime::Header;

inline AssetBytes small_asset() {
  return make_asset_bytes(sphere_model(0.03, 6, uniform(400, 300, 0.3)),
                          {.meta_json = "{\"a\": 1}"});
}

inline Header header_of(const AssetBytes& bytes) {
  Header header;
  std::memcpy(&header, bytes.data(), sizeof header);
  return header;
}

inline void fix_checksum(AssetBytes& bytes, std::size_t size) {
  const std::uint64_t sum = runtime::asset_checksum(bytes.data(), size);
  std::memcpy(bytes.data() + offsetof(Header, checksum), &sum, sizeof sum);
}

inline Status open(const AssetBytes& bytes, std::size_t size) {
  Status status;
  const Asset asset = Asset::open(bytes.data(), size, &status);
  EXPECT_EQ(asset.is_open(), status == Status::ok);
  return status;
}

}  // namespace palpate::test
