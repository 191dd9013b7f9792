#include "runtime/store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "runtime/cache_folder.h"
#include "runtime/files.h"
#include "runtime/json_text.h"
#include "runtime/value_file.h"

namespace terrazzo {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

// Streams values into a file and hashes them on the way, without a second copy in memory.
class FileWriter : public Writer {
 public:
  explicit FileWriter(const fs::path& path) : path_(path), file_(std::fopen(path.c_str(), "wb")) {
    if (!file_) fail();
    std::setvbuf(file_, nullptr, _IOFBF, 1 << 20);
  }
  ~FileWriter() override {
    if (file_) std::fclose(file_);
  }
  void bytes(const void* data, std::size_t size) override {
    if (size == 0) return;  // an empty vector has no address
    hash_.bytes(data, size);
    if (std::fwrite(data, 1, size, file_) != size) fail();
  }
  void head(const std::string& text) {  // not hashed
    if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) fail();
  }
  void close() {
    const int bad = std::fclose(file_);
    file_ = nullptr;
    if (bad) fail();
  }
  HashWriter& hash() { return hash_; }

 private:
  [[noreturn]] void fail() { throw Error("cache-write", "cannot write to the cache: " + path_.string()); }
  fs::path path_;
  std::FILE* file_;
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
        action_record_from_json(json::parse(text.begin() + 33, text.end())));
  } catch (const std::exception&) {
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
  constexpr std::int64_t much = 16 << 20;
  if ((usage_ += bytes) >= much) add_usage();
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
    if (const auto it = actions_.find(key); it != actions_.end()) return from = Tier::Memory, it->second;
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
        ++twice_.count, twice_.seconds += r->seconds;
        twice_.differing += other->outputs != r->outputs;
        return;
      }
  const std::string body = json_text(to_json(*r));
  try {
    note_usage(write_cache_entry(folder_, "actions", key, hash_of(body).text() + "\n" + body));
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

OutputRecord Store::put_value(const Value& v, double seconds) {
  OutputRecord record{v.type().name, {}, 0};
  bool on_disk = false;
  const auto encode = [&](Writer& w) {
    w.text(v.type().name);
    v.type().encode(v.data(), w);
  };
  if (!folder_.empty() && trouble().empty()) try {
      // The final name is the content hash, which is known only after the value is written.
      TemporaryFile file(folder_ / "values", "incoming");
      FileWriter w(file.path());
      w.head(value_head(seconds));
      encode(w);
      w.close();
      record.content = w.hash().hash(), record.bytes = w.hash().size();
      const fs::path place = cache_entry(folder_, "values", record.content);
      std::error_code error;
      if (!fs::exists(place, error)) {
        fs::create_directories(place.parent_path(), error);
        note_usage(static_cast<std::int64_t>(bytes_on_disk(record.bytes + value_head_size)));
      }
      file.rename_to(place);
      written_ += record.bytes;
      on_disk = true;
    } catch (const Error& e) {
      note_trouble(e.diagnostic().message);
    }
  if (!on_disk) {
    HashWriter w;
    encode(w);
    record.content = w.hash(), record.bytes = w.size();
  }
  keep_in_memory(record.content, v, record.bytes, seconds);
  return record;
}

void Store::keep_in_memory(const Hash& content, const Value& v, std::uint64_t bytes, double seconds) {
  const std::lock_guard lock(mutex_);
  auto [it, fresh] = values_.try_emplace(content);
  Kept& kept = it->second;
  if (fresh) {
    kept.value = v, kept.bytes = bytes;
    kept.per_byte = seconds / static_cast<double>(bytes + 1);
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

Value Store::get_value(const OutputRecord& r, double seconds) {
  if (Value v = find_in_memory(r.content)) return v;
  const ValueType* type = types_.find(r.type);
  if (folder_.empty() || !type) return {};
  const fs::path path = cache_entry(folder_, "values", r.content);
  const auto data = read_file(path);
  if (!data) return {};
  if (const auto payload = value_payload(*data, r.content); !payload.empty()) try {
      Reader reader(payload.data(), payload.size());
      if (reader.text() == r.type) {
        Value v(type, type->decode(reader));
        touch(path);
        keep_in_memory(r.content, v, r.bytes, seconds);
        return v;
      }
    } catch (const Error&) {  // written by another version of the codec: a cache miss
    }
  std::error_code ignored;
  fs::remove(path, ignored);
  return {};
}

}  // namespace terrazzo
