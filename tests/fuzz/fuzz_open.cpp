// Any bytes as an asset: refused, or safe to touch.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "libfit/runtime/engine.hpp"
#include "tests/fuzz/promises.hpp"

namespace {

using namespace palpate::runtime;
using palpate::fuzz::promise;
using palpate::fuzz::promise_finite;

// Presses and drags over the body's box at places drawn from the bytes themselves.
void touch_all_over(const Asset& asset, std::uint64_t random) {
  const TreeNode& box = asset.tree[0];
  Contact tip, ball;
  double at[3], goal[3] = {0, 0, 0};
  for (int k = 0; k < 3; ++k) at[k] = asset.origin_m[k] + 1.2 * double(box.hi[k]);
  for (int tick = 0; tick < 400; ++tick) {
    for (int k = 0; k < 3; ++k) {
      random = random * 6364136223846793005u + 1442695040888963407u;
      const double share = double(random >> 11) / 9007199254740992.0 * 1.4 - 0.2;
      if (tick % 20 == 0)
        goal[k] =
            asset.origin_m[k] + double(box.lo[k]) + share * (double(box.hi[k]) - double(box.lo[k]));
      at[k] += (goal[k] - at[k]) * 0.15;
    }
    Output out, ball_out;
    double tangent[9];
    const Status status = touch(asset, tip, at, out, tangent);
    promise_finite(out.force_on_tool_N, 3, "a tip's force is finite");
    promise(status == Status::ok || out.state == ContactState::air,
            "an error comes without a force");
    promise_finite(out.weight, 3, "area coordinates are finite");
    touch_ball(asset, ball, at, 0.004, ball_out, tangent);
    promise_finite(ball_out.force_on_tool_N, 3, "a ball's force is finite");
  }
}

void open_and_touch(unsigned char* bytes, std::size_t size) {
  Status status;
  const Asset whole = Asset::open(bytes, size, &status);
  promise(whole.is_open() == (status == Status::ok), "an asset is open exactly when all is well");
  // What differs in the replay alone has passed every other check, so it must be safe as well.
  const Asset unplayed = Asset::open_without_replay(bytes, size, &status);
  if (status == Status::ok) touch_all_over(unplayed, checksum(bytes, size / 8 * 8));
}

// Past the envelope: an input with possible counts gets the size that they ask for, and a header
// that says so, so that no mutation is wasted on what the envelope alone refuses.
void open_made_good(const unsigned char* data, std::size_t size) {
  constexpr std::uint64_t kMax = std::uint64_t{1} << 16;
  Header header;
  if (size < sizeof header) return;
  std::memcpy(&header, data, sizeof header);
  if (!has_possible_counts(header)) return;
  std::memcpy(header.magic, "PALP", 4);
  header.endian_mark = kEndianMark;
  header.version = kVersion;
  header.file_bytes = lay_out(header, header.offset);
  if (header.file_bytes > kMax) return;
  std::vector<unsigned char> fitted(data, data + size);
  fitted.resize(header.file_bytes);
  std::memcpy(fitted.data(), &header, sizeof header);
  header.checksum = asset_checksum(fitted.data(), fitted.size());
  std::memcpy(fitted.data(), &header, sizeof header);
  palpate::fuzz::AlignedCopy copy(fitted.data(), fitted.size());
  open_and_touch(copy.data(), fitted.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  palpate::fuzz::AlignedCopy copy(data, size);
  open_and_touch(copy.data(), size);
  open_made_good(data, size);
  return 0;
}
