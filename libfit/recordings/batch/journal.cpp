#include "libfit/recordings/batch/journal.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/atomic_file.hpp"

namespace palpate::recordings {
namespace {

constexpr std::string_view kMagic = "palpate-journal 5\n";   // raise with every change of an entry
constexpr std::uint64_t kMaxCount = std::uint64_t{1} << 32;  // of rows, letters: more is damage

// Values one after another, native order: a journal does not travel between machines.
class Writer {
 public:
  template <class T>
  Writer& plain(const T& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Writer& text(std::string_view value) {
    plain<std::uint64_t>(value.size());
    bytes.append(value);
    return *this;
  }
  template <class Matrix>
  Writer& numbers(const Matrix& values) {
    plain<std::uint64_t>(static_cast<std::uint64_t>(values.rows()));
    bytes.append(reinterpret_cast<const char*>(values.data()),
                 static_cast<std::size_t>(values.size()) * sizeof(double));
    return *this;
  }
  Writer& place(const std::optional<Vec3>& value) {
    return plain<char>(value.has_value()).plain(value.value_or(Vec3::Zero()));
  }
  std::string bytes;
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}
  bool is_bad = false;

  template <class T>
  T plain() {
    T value{};
    if (const auto part = take(sizeof value); !part.empty())
      std::memcpy(static_cast<void*>(&value), part.data(), sizeof value);
    return value;
  }
  std::string_view view() { return take(count(1)); }
  std::string_view rest() const { return rest_; }
  std::string text() { return std::string(view()); }
  template <class Matrix>
  void numbers(Matrix& values) {
    const auto rows =
        static_cast<Eigen::Index>(count(sizeof(double) * static_cast<std::size_t>(values.cols())));
    values.resize(rows, values.cols());
    const auto part = take(static_cast<std::size_t>(values.size()) * sizeof(double));
    if (!part.empty()) std::memcpy(values.data(), part.data(), part.size());
  }
  std::optional<Vec3> place() {
    const bool is_there = plain<char>() != 0;
    Vec3 value;
    for (int k = 0; k < 3; ++k) value[k] = plain<double>();
    return is_there ? std::optional(value) : std::nullopt;
  }
  std::size_t count(std::size_t bytes_each) {
    const auto n = plain<std::uint64_t>();
    if (n > kMaxCount || n * bytes_each > rest_.size()) {
      is_bad = true;
      return 0;
    }
    return static_cast<std::size_t>(n);
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

 private:
  std::string_view rest_;
};

void write(Writer& w, const Conditioned& r) {
  w.text(r.name).plain(r.is_axial).numbers(r.deflection_m).numbers(r.force_N).numbers(r.error_N);
  w.numbers(r.torque_Nm).plain(r.is_force_from_signal);
  w.plain<std::uint64_t>(r.status.size());
  for (const RowStatus status : r.status) w.plain(status);
  w.place(r.contact_m).place(r.inward);
  w.plain(r.contact_travel_m)
      .plain(r.contact_deviation_m)
      .text(r.estimator)
      .plain(r.speed_m_s)
      .plain(r.noise_N);
  w.plain(r.hysteresis).plain(r.young_Pa).plain(r.apparent_Pa).plain(r.grade);
  w.plain<std::uint64_t>(r.reasons.size());
  for (const std::string& reason : r.reasons) w.text(reason);
  w.plain<std::uint64_t>(r.dropped_rows).plain(r.tip_radius_m);
}

Conditioned read_recording(Reader& in) {
  Conditioned r;
  r.name = in.text();
  r.is_axial = in.plain<bool>();
  in.numbers(r.deflection_m);
  in.numbers(r.force_N);
  in.numbers(r.error_N);
  in.numbers(r.torque_Nm);
  r.is_force_from_signal = in.plain<bool>();
  r.status.resize(in.count(1));
  for (RowStatus& status : r.status) status = in.plain<RowStatus>();
  r.contact_m = in.place();
  r.inward = in.place();
  r.contact_travel_m = in.plain<double>();
  r.contact_deviation_m = in.plain<double>();
  r.estimator = in.text();
  r.speed_m_s = in.plain<double>();
  r.noise_N = in.plain<double>();
  r.hysteresis = in.plain<double>();
  r.young_Pa = in.plain<double>();
  r.apparent_Pa = in.plain<double>();
  r.grade = in.plain<Grade>();
  r.reasons.resize(in.count(8));
  for (std::string& reason : r.reasons) reason = in.text();
  r.dropped_rows = in.plain<std::uint64_t>();
  r.tip_radius_m = in.plain<double>();
  return r;
}

std::string entry_of(const std::string& key, const std::string& stamp, const ItemResult& result) {
  Writer w;
  w.text(key).text(stamp).text(result.hash).plain<char>(result.failure.has_value());
  if (result.failure)
    w.text(result.failure->where).text(result.failure->what).text(result.failure->remedy);
  w.plain<std::uint64_t>(result.recordings.size());
  for (const Conditioned& recording : result.recordings) write(w, recording);
  Writer framed;
  framed.text(w.bytes);
  framed.plain(hash_of(w.bytes));
  return framed.bytes;
}

ItemResult read_result(Reader& in) {
  ItemResult result;
  result.hash = in.text();
  if (in.plain<char>()) {
    result.failure.emplace();
    result.failure->where = in.text();
    result.failure->what = in.text();
    result.failure->remedy = in.text();
  }
  result.recordings.resize(in.count(16));
  for (Conditioned& recording : result.recordings) recording = read_recording(in);
  result.is_done = result.is_reused = true;
  return result;
}

// Nothing of no bytes, or of bytes that are no result.
std::optional<ItemResult> parsed(std::string_view bytes) {
  if (bytes.empty()) return std::nullopt;
  Reader in(bytes);
  ItemResult result = read_result(in);
  return in.is_bad ? std::nullopt : std::optional(std::move(result));
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
        Reader in(std::string_view(before_).substr(bytes_));
        const std::string_view body = in.view();
        const auto hash = in.plain<std::uint64_t>();
        if (in.is_bad || body.empty() || hash_of(body) != hash) break;
        const std::size_t length = 2 * sizeof(std::uint64_t) + body.size();
        bytes_ += length;
        Reader entry(body);
        const std::string key = entry.text(), stamp = entry.text();
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
