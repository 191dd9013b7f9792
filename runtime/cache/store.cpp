#include "runtime/cache/store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "graph/input_file.h"
#include "runtime/cache/cache_folder.h"
#include "runtime/cache/value_file.h"
#include "runtime/files.h"
#include "runtime/files/json_input.h"
#include "runtime/json_text.h"

namespace terrazzo {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

// Hashes a value. Keeps the bytes of a small one, and streams a larger one into a temporary file in `folder`,
// without a second copy in memory.
class ValueWriter : public Writer {
 public:
  ValueWriter(fs::path folder, double seconds) : folder_(std::move(folder)), seconds_(seconds) {}
  ~ValueWriter() override {
    if (stream_) std::fclose(stream_);
  }
  void bytes(const void* data, std::size_t size) override {
    if (size == 0) return;  // an empty vector has no address
    hash_.bytes(data, size);
    if (!file_ && small_.size() + size <= kSmallValue) {
      small_.append(static_cast<const char*>(data), size);
      return;
    }
    if (!file_) open();
    write(data, size);
  }
  const HashWriter& hash() const { return hash_; }
  bool is_small() const { return !file_; }
  std::string& small() { return small_; }
  // The complete file. Only for values that are not small.
  TemporaryFile& close() {
    if (std::fclose(std::exchange(stream_, nullptr))) fail();
    return *file_;
  }

 private:
  void open() {
    file_.emplace(folder_, "incoming");
    if (!(stream_ = std::fopen(file_->path().c_str(), "wb"))) fail();
    std::setvbuf(stream_, nullptr, _IOFBF, 1 << 20);
    const std::string head = value_head(seconds_);
    write(head.data(), head.size());
    write(small_.data(), small_.size());
  }
  void write(const void* data, std::size_t size) {
    if (size > 0 && std::fwrite(data, 1, size, stream_) != size) fail();
  }
  [[noreturn]] void fail() {
    throw Error("cache-write", "cannot write to the cache: " + file_->path().string());
  }
  fs::path folder_;
  double seconds_;
  std::string small_;
  std::optional<TemporaryFile> file_;
  std::FILE* stream_ = nullptr;
  HashWriter hash_;
};

// Updates a file's time of last use, which decides when it is collected. Writes at most once an hour. Also
// corrects times in the future, left by a wrong clock.
void touch(const fs::path& path) {
  struct stat s;
  struct timespec now;
  ::clock_gettime(CLOCK_REALTIME, &now);
  if (::stat(path.c_str(), &s) == 0 && std::abs(now.tv_sec - s.st_mtim.tv_sec) > 3600)
    ::utimensat(AT_FDCWD, path.c_str(), nullptr, 0);
}

}  // namespace

std::shared_ptr<const ActionRecord> parse_action(const std::string& text) {
  // First line: hash of the rest.
  if (text.find('\n') != 32 || Hash::parse(text.substr(0, 32)) != hash_of(text.data() + 33, text.size() - 33))
    return {};
  try {
    return std::make_shared<const ActionRecord>(
        action_record_from_json(parse_json(std::string_view(text).substr(33))));
  } catch (const json::exception&) {
    return {};
  } catch (const Error&) {
    return {};
  }
}

Store::Store(const ValueTypes& types, fs::path folder, std::uint64_t memory)
    : types_(types), folder_(std::move(folder)), memory_(memory) {
  if (folder_.empty()) return;
  try {
    open_cache_folder(folder_);
  } catch (const Error& e) {
    note_trouble(e.diagnostic().message);
    folder_.clear();  // do not trust its content
  }
}

Store::~Store() { add_usage(); }

void Store::add_usage() {
  if (const std::int64_t bytes = usage_.exchange(0); bytes != 0 && !folder_.empty())
    CacheUsage(folder_).add(bytes);
}

void Store::note_usage(std::int64_t bytes) {
  constexpr std::int64_t kMuch = 16 << 20;
  if ((usage_ += bytes) >= kMuch) add_usage();
}

void Store::note_trouble(const std::string& what) {
  const std::lock_guard lock(mutex_);
  if (trouble_.empty()) trouble_ = what;
}

std::string Store::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

std::shared_ptr<const ActionRecord> Store::find_action(const Hash& key, Tier& from) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto it = actions_.find(key); it != actions_.end()) {
      from = Tier::Memory;
      return it->second;
    }
  }
  from = Tier::None;
  if (folder_.empty()) return {};
  const fs::path path = cache_entry(folder_, "actions", key);
  const auto text = read_file(path);
  if (!text) return {};
  if (auto record = parse_action(*text)) {
    touch(path);
    const std::lock_guard lock(mutex_);
    actions_.emplace(key, record);
    from = Tier::Disk;
    return record;
  }
  // A damaged record is a cache miss. Remove it so that it is written again.
  std::error_code ignored;
  fs::remove(path, ignored);
  return {};
}

ComputedTwice Store::computed_twice() const {
  const std::lock_guard lock(mutex_);
  return twice_;
}

void Store::put_action(const Hash& key, std::shared_ptr<const ActionRecord> r) {
  bool known;  // this process replaces a record, for example because written files have changed
  {
    const std::lock_guard lock(mutex_);
    known = actions_.count(key) > 0;
    actions_[key] = r;
  }
  if (folder_.empty()) return;
  if (!known)
    if (const auto text = read_file(cache_entry(folder_, "actions", key)))
      if (const auto other = parse_action(*text)) {
        const std::lock_guard lock(mutex_);
        ++twice_.count;
        twice_.seconds += r->seconds;
        twice_.differing += other->outputs != r->outputs;
        return;
      }
  const std::string body = json_text(to_json(*r));
  try {
    note_usage(write_cache_entry(folder_, "actions", key, hash_of(body).text() + "\n" + body));
    written_ += body.size();
  } catch (const Error& e) {
    note_trouble(e.diagnostic().message);
  }
}

void Store::drop_action(const Hash& key) {
  {
    const std::lock_guard lock(mutex_);
    actions_.erase(key);
  }
  std::error_code ignored;
  if (!folder_.empty()) fs::remove(cache_entry(folder_, "actions", key), ignored);
}

void Store::move_to_its_place(TemporaryFile& file, const OutputRecord& record) {
  const fs::path place = cache_entry(folder_, "values", record.content);
  std::error_code error;
  if (!fs::exists(place, error)) {
    fs::create_directories(place.parent_path(), error);
    note_usage(bytes_on_disk(record.bytes + kValueHeadSize));
  }
  file.rename_to(place);
  written_ += record.bytes;
}

OutputRecord Store::put_value(const Value& v, double seconds) {
  OutputRecord record{v.type().name, {}, 0};
  bool on_disk = false;
  const auto encode = [&](Writer& w) {
    w.text(v.type().name);
    v.type().encode(v.data(), w);
  };
  if (!folder_.empty() && trouble().empty()) try {
      // The final name is the content hash, which is known only after the value is written.
      ValueWriter w(folder_ / "values", seconds);
      encode(w);
      record.content = w.hash().hash();
      record.bytes = w.hash().size();
      if (w.is_small())
        record.small = std::make_shared<const std::string>(std::move(w.small()));
      else
        move_to_its_place(w.close(), record);
      on_disk = true;
    } catch (const Error& e) {
      note_trouble(e.diagnostic().message);
    }
  if (!on_disk) {
    HashWriter w;
    encode(w);
    record.content = w.hash();
    record.bytes = w.size();
  }
  keep_in_memory(record.content, v, record.bytes, seconds);
  return record;
}

void Store::keep_in_memory(const Hash& content, const Value& v, std::uint64_t bytes, double seconds) {
  const std::lock_guard lock(mutex_);
  auto [it, fresh] = values_.try_emplace(content);
  Kept& kept = it->second;
  if (fresh) {
    kept.value = v;
    kept.bytes = bytes;
    kept.per_byte = seconds / (bytes + 1);
    used_ += bytes;
  } else {
    by_worth_.erase({kept.worth, content});
  }
  kept.worth = left_worth_ + kept.per_byte;
  by_worth_.insert({kept.worth, content});
  while (used_ > memory_ && !by_worth_.empty()) {
    const auto least = *by_worth_.begin();
    left_worth_ = least.first;
    const auto out = values_.find(least.second);
    used_ -= out->second.bytes;
    values_.erase(out);
    by_worth_.erase(by_worth_.begin());
  }
}

bool Store::has_value(const OutputRecord& r) {
  if (r.small) return true;
  {
    const std::lock_guard lock(mutex_);
    if (values_.count(r.content)) return true;
  }
  std::error_code error;
  return !folder_.empty() && fs::exists(cache_entry(folder_, "values", r.content), error);
}

Value Store::find_in_memory(const Hash& key) {
  const std::lock_guard lock(mutex_);
  const auto it = values_.find(key);
  if (it == values_.end()) return {};
  Kept& kept = it->second;
  by_worth_.erase({kept.worth, key});
  kept.worth = left_worth_ + kept.per_byte;
  by_worth_.insert({kept.worth, key});
  return kept.value;
}

std::shared_ptr<const void> Store::find_kept(const Hash& key) { return find_in_memory(key).share(); }

void Store::keep(const Hash& key, std::shared_ptr<const void> data, std::uint64_t bytes, double seconds) {
  static const ValueType none;  // intermediate results have no type, and are never encoded
  keep_in_memory(key, Value(&none, std::move(data)), bytes, seconds);
}

Value Store::get_value(const OutputRecord& r, double seconds, bool keep) {
  if (Value v = find_in_memory(r.content)) return v;
  const ValueType* type = types_.find(r.type);
  if (!type) return {};
  const auto decoded = [&](std::string_view payload) -> Value {
    try {
      Reader reader(payload.data(), payload.size());
      if (reader.text() == r.type) return Value(type, type->decode(reader));
    } catch (const Error&) {  // written by another version of the codec: a cache miss
    }
    return {};
  };
  Value v;
  if (r.small) v = decoded(*r.small);
  if (!v && !folder_.empty()) {
    const fs::path path = cache_entry(folder_, "values", r.content);
    // A file of another size is damaged, and is not read.
    const FileText data = read_input_file(path, r.bytes + kValueHeadSize);
    if (data || data.too_large) {
      if (const auto payload = value_payload(data.text, r.content); !payload.empty()) v = decoded(payload);
      std::error_code ignored;
      if (v)
        touch(path);
      else
        fs::remove(path, ignored);
    }
  }
  if (v && keep) keep_in_memory(r.content, v, r.bytes, seconds);
  return v;
}

}  // namespace terrazzo
