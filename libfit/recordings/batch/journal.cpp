#include "libfit/recordings/batch/journal.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <concepts>
#include <cstring>
#include <utility>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/atomic_file.hpp"

namespace palpate::recordings {
namespace {

constexpr std::string_view kMagic = "palpate-journal 12\n";  // raise with every change of an entry
constexpr std::uint64_t kMaxCount = std::uint64_t{1} << 32;  // of rows, letters: more is damage

// What an entry holds, for writing and for reading.
template <class Archive, class T>
requires std::same_as<std::remove_const_t<T>, Conditioned>
void fields(Archive& archive, T& r) {
  archive(r.name, r.is_axial, r.deflection_m, r.force_N, r.time_s, r.error_N, r.torque_Nm, r.status,
          r.contact_m, r.inward, r.contact.travel_m, r.contact.deviation_m, r.contact.estimator,
          r.speed_m_s, r.noise_N, r.hysteresis, r.young_Pa, r.cycles.depth_m, r.cycles.push_N,
          r.cycles.error_N, r.breaks, r.apparent_Pa, r.way_in.travel_m, r.way_in.push_N, r.history,
          r.grade, r.reasons, r.dropped_rows, r.source.tip_radius_m, r.source.format,
          r.source.taken, r.source.units.position, r.source.units.force, r.trace);
}
template <class Archive, class T>
requires std::same_as<std::remove_const_t<T>, TimedPress>
void fields(Archive& archive, T& press) {
  archive(press.time_s, press.depth_m, press.push_N, press.readings, press.deflection_m,
          press.force_N);
}
template <class Archive, class T>
requires std::same_as<std::remove_const_t<T>, SignalTrace>
void fields(Archive& archive, T& t) {
  archive(t.time_s, t.travel_m, t.push_N, t.phase, t.is_used, t.bias_N, t.drift_N_m);
}
template <class Archive, class T>
requires std::same_as<std::remove_const_t<T>, Failure>
void fields(Archive& archive, T& failure) { archive(failure.where, failure.what, failure.remedy); }
template <class Archive, class T>
requires std::same_as<std::remove_const_t<T>, Refused>
void fields(Archive& archive, T& refused) { archive(refused.name, refused.failure, refused.trace); }

// Values one after another, native order: a journal does not travel between machines.
struct ByteWriter {
  std::string bytes;

  template <class... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }
  template <class T>
  void put(const T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    } else if constexpr (requires { fields(*this, value); }) {
      fields(*this, value);
    } else if constexpr (requires { value.has_value(); }) {
      put(value.has_value());
      if (value) put(*value);
    } else if constexpr (requires { value.rows(); }) {
      put(static_cast<std::uint64_t>(value.rows()));
      bytes.append(reinterpret_cast<const char*>(value.data()),
                   static_cast<std::size_t>(value.size()) * sizeof(double));
    } else {
      put(static_cast<std::uint64_t>(value.size()));
      for (const auto& item : value) put(item);
    }
  }
};

class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}
  bool is_bad = false;

  std::string_view rest() const { return rest_; }
  template <class T>
  T next() {
    T value{};
    get(value);
    return value;
  }
  std::string_view text() { return take(count(1)); }
  template <class... T>
  void operator()(T&... values) {
    (get(values), ...);
  }

 private:
  template <class T>
  void get(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      value = next<char>() != 0;
    } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      if (const auto part = take(sizeof value); !part.empty())
        std::memcpy(&value, part.data(), sizeof value);
    } else if constexpr (requires { fields(*this, value); }) {
      fields(*this, value);
    } else if constexpr (requires { value.has_value(); }) {
      if (next<bool>()) get(value.emplace());
    } else if constexpr (requires { value.rows(); }) {
      const std::size_t row_bytes = sizeof(double) * static_cast<std::size_t>(value.cols());
      value.resize(static_cast<Eigen::Index>(count(row_bytes)), value.cols());
      const auto part = take(static_cast<std::size_t>(value.size()) * sizeof(double));
      if (!part.empty()) std::memcpy(value.data(), part.data(), part.size());
    } else {
      constexpr std::size_t kLeastBytes = 8;  // of an item that is no number
      using Item = typename T::value_type;
      value.resize(count(std::is_class_v<Item> ? kLeastBytes : sizeof(Item)));
      for (auto& item : value) get(item);
    }
  }
  std::size_t count(std::size_t bytes_each) {
    const auto n = next<std::uint64_t>();
    if (n <= kMaxCount && n * bytes_each <= rest_.size()) return static_cast<std::size_t>(n);
    is_bad = true;
    return 0;
  }
  std::string_view take(std::size_t bytes) {
    if (bytes > rest_.size()) {
      is_bad = true;
      rest_ = {};
      return {};
    }
    const auto part = rest_.substr(0, bytes);
    rest_.remove_prefix(bytes);
    return part;
  }

  std::string_view rest_;
};

std::string entry_of(const std::string& key, const std::string& stamp, const ItemResult& result) {
  ByteWriter w, framed;
  w(key, stamp, result.hash, result.failure, result.recordings, result.refused, result.trace);
  framed(w.bytes, hash_of(w.bytes));
  return framed.bytes;
}

// Nothing of no bytes, or of bytes that are no result.
std::optional<ItemResult> parsed(std::string_view bytes) {
  if (bytes.empty()) return std::nullopt;
  ByteReader in(bytes);
  ItemResult result;
  in(result.hash, result.failure, result.recordings, result.refused, result.trace);
  if (in.is_bad) return std::nullopt;
  result.is_done = result.is_reused = true;
  return result;
}

Error cannot_keep(const std::filesystem::path& path) {
  return Error(path.string(), std::string("cannot be written: ") + std::strerror(errno),
               "Choose a folder that exists, can be written and has space.");
}

}  // namespace

Journal::Journal(const std::filesystem::path& path) : path_(path) {
  if (path.empty()) return;
  if (std::error_code ignored; std::filesystem::exists(path, ignored)) {
    before_ = read_whole_file(path);
    if (before_.starts_with(kMagic)) {
      bytes_ = kMagic.size();
      while (true) {
        ByteReader in(std::string_view(before_).substr(bytes_));
        const std::string_view body = in.text();
        const auto hash = in.next<std::uint64_t>();
        if (in.is_bad || body.empty() || hash_of(body) != hash) break;
        const std::size_t length = 2 * sizeof(std::uint64_t) + body.size();
        bytes_ += length;
        ByteReader entry(body);
        const auto key = entry.next<std::string>(), stamp = entry.next<std::string>();
        if (entry.is_bad) continue;
        if (!stamp.empty()) key_of_stamp_[stamp] = key;
        kept_[key] = {bytes_ - length, length, entry.rest(), false};
      }
    }
  }
  descriptor_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0 || ::ftruncate(descriptor_, static_cast<off_t>(bytes_)) != 0 ||
      ::lseek(descriptor_, 0, SEEK_END) < 0)
    throw cannot_keep(path);
  if (bytes_ > 0) return;
  if (::write(descriptor_, kMagic.data(), kMagic.size()) < 0) throw cannot_keep(path);
  bytes_ = kMagic.size();
}

Journal::~Journal() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::string_view Journal::use(const std::string& key) {
  const auto found = kept_.find(key);
  if (found == kept_.end()) return {};
  found->second.is_used = true;
  return found->second.result;
}

std::optional<ItemResult> Journal::find(const std::string& key) {
  std::string_view bytes;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    bytes = use(key);
  }
  return parsed(bytes);
}

std::optional<ItemResult> Journal::find_stamp(const std::string& stamp) {
  std::string_view bytes;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = key_of_stamp_.find(stamp);
    if (found != key_of_stamp_.end()) bytes = use(found->second);
  }
  return parsed(bytes);
}

void Journal::add(const std::string& key, const std::string& stamp, const ItemResult& result) {
  if (path_.empty()) return;
  const std::string entry = entry_of(key, stamp, result);
  const std::lock_guard<std::mutex> lock(mutex_);
  kept_[key] = {bytes_, entry.size(), {}, true};
  std::string_view rest = entry;
  while (descriptor_ >= 0 && !rest.empty()) {
    const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    // A full disk costs the journal, not the batch: what comes after a torn entry would be lost on
    // reading.
    if (written < 0) return void(::close(std::exchange(descriptor_, -1)));
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  bytes_ += entry.size();
}

void Journal::compact() {
  if (descriptor_ < 0) return;
  std::size_t used = kMagic.size();
  for (const auto& [key, kept] : kept_) used += kept.is_used ? kept.bytes : 0;
  if (2 * used >= bytes_) return;
  const std::string before = read_whole_file(path_);
  std::string bytes(kMagic);
  for (const auto& [key, kept] : kept_)
    if (kept.is_used) bytes += before.substr(kept.offset, kept.bytes);
  ::close(std::exchange(descriptor_, -1));
  write_file_atomically(path_, bytes);
}

}  // namespace palpate::recordings
