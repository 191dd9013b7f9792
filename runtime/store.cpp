#include "runtime/store.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "runtime/files.h"

namespace terrazzo {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr char value_magic[8] = {'T', 'Z', 'V', 'A', 'L', '0', '0', '1'};

// Values are streamed straight into the file while they are hashed: no second copy in memory.
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
    hash_.bytes(data, size);
    if (std::fwrite(data, 1, size, file_) != size) fail();
  }
  void raw(const void* data, std::size_t size) {
    if (std::fwrite(data, 1, size, file_) != size) fail();
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

json to_json(const ActionRecord& r) {
  json outputs = json::object(), files = json::array();
  for (const auto& [port, o] : r.outputs)
    outputs[port] = {{"type", o.type}, {"content", o.content.text()}, {"bytes", o.bytes}};
  for (const auto& f : r.files) files.push_back({{"path", f.path}, {"content", f.content.text()}});
  json metrics = json::object();
  for (const auto& [name, v] : r.metrics)
    metrics[name] = fmt::format("{}", v);  // keeps infinities and every digit
  return {{"outputs", outputs},
          {"metrics", metrics},
          {"warnings", r.warnings},
          {"files", files},
          {"seconds", r.seconds}};
}

ActionRecord from_json(const json& j) {
  ActionRecord r;
  for (const auto& [port, o] : j.at("outputs").items())
    r.outputs[port] = {o.at("type"), Hash::parse(o.at("content").get<std::string>()), o.at("bytes")};
  for (const auto& [name, v] : j.at("metrics").items()) r.metrics[name] = std::stod(v.get<std::string>());
  r.warnings = j.at("warnings").get<std::vector<std::string>>();
  for (const auto& f : j.at("files"))
    r.files.push_back({f.at("path"), Hash::parse(f.at("content").get<std::string>())});
  r.seconds = j.at("seconds");
  return r;
}

fs::path two_level(const fs::path& base, const Hash& h) {
  const std::string name = h.text();
  return base / name.substr(0, 2) / name;
}

}  // namespace

Store::Store(const ValueTypes& types, fs::path folder, std::uint64_t budget)
    : types_(types), folder_(std::move(folder)), budget_(budget) {
  if (folder_.empty()) return;
  std::error_code error;
  fs::create_directories(folder_ / "actions", error);
  if (!error) fs::create_directories(folder_ / "values", error);
  if (error) note_trouble("cannot use the cache folder '" + folder_.string() + "': " + error.message());
}

fs::path Store::action_path(const Hash& h) const { return two_level(folder_ / "actions", h); }
fs::path Store::value_path(const Hash& h) const { return two_level(folder_ / "values", h); }

void Store::note_trouble(const std::string& what) {
  const std::lock_guard lock(mutex_);
  if (trouble_.empty()) trouble_ = what;
}

std::string Store::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

std::optional<ActionRecord> Store::find_action(const Hash& key, Tier& from) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto it = actions_.find(key); it != actions_.end()) return from = Tier::Memory, it->second;
  }
  from = Tier::None;
  if (folder_.empty()) return {};
  const fs::path path = action_path(key);
  const auto text = read_file(path);
  if (!text) return {};
  // First line: hash of the rest. Whatever does not hold is a miss, and is removed so that it is written
  // anew.
  const auto line = text->find('\n');
  if (line == 32 && Hash::parse(text->substr(0, 32)) == hash_of(text->data() + 33, text->size() - 33)) try {
      ActionRecord r = from_json(json::parse(text->begin() + 33, text->end()));
      const std::lock_guard lock(mutex_);
      actions_.emplace(key, r);
      from = Tier::Disk;
      return r;
    } catch (const std::exception&) {
    }
  std::error_code ignored;
  fs::remove(path, ignored);
  return {};
}

void Store::put_action(const Hash& key, const ActionRecord& r) {
  {
    const std::lock_guard lock(mutex_);
    actions_[key] = r;
  }
  if (folder_.empty()) return;
  const std::string body = to_json(r).dump();
  try {
    write_text_atomically(action_path(key), hash_of(body).text() + "\n" + body);
  } catch (const Error& e) {
    note_trouble(e.diagnostic().message);
  }
}

OutputRecord Store::put_value(const Value& v) {
  OutputRecord record{v.type().name, {}, 0};
  bool on_disk = false;
  const auto encode = [&](Writer& w) {
    w.text(v.type().name);
    v.type().encode(v.data(), w);
  };
  if (!folder_.empty() && trouble().empty()) try {
      // The name is the content's hash, known only once written: into a temporary name first, then renamed.
      static std::atomic<unsigned> serial{0};
      const fs::path place = folder_ / "values" / fmt::format("incoming-{}-{}", ::getpid(), ++serial);
      Hash content;
      std::uint64_t size = 0;
      write_atomically(place, [&](const fs::path& temporary) {
        FileWriter w(temporary);
        w.raw(value_magic, sizeof value_magic);
        encode(w);
        w.close();
        content = w.hash().hash(), size = w.hash().size();
      });
      record.content = content, record.bytes = size;
      std::error_code error;
      fs::create_directories(value_path(content).parent_path(), error);
      fs::rename(place, value_path(content), error);
      if (error) {
        std::error_code ignored;
        fs::remove(place, ignored);
        throw Error("cache-write", "cannot write to the cache: " + error.message());
      }
      on_disk = true;
    } catch (const Error& e) {
      note_trouble(e.diagnostic().message);
    }
  if (!on_disk) {
    HashWriter w;
    encode(w);
    record.content = w.hash(), record.bytes = w.size();
  }
  keep_in_memory(record.content, v, record.bytes);
  return record;
}

void Store::keep_in_memory(const Hash& content, const Value& v, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  if (const auto it = values_.find(content); it != values_.end()) {
    ages_.splice(ages_.end(), ages_, it->second.age);
    return;
  }
  ages_.push_back(content);
  values_[content] = {v, bytes, std::prev(ages_.end())};
  used_ += bytes;
  while (used_ > budget_ && ages_.size() > 1) {
    const auto old = values_.find(ages_.front());
    used_ -= old->second.bytes;
    values_.erase(old);
    ages_.pop_front();
  }
}

bool Store::has_value(const OutputRecord& r) {
  {
    const std::lock_guard lock(mutex_);
    if (values_.count(r.content)) return true;
  }
  std::error_code error;
  return !folder_.empty() && fs::exists(value_path(r.content), error);
}

Value Store::get_value(const OutputRecord& r) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto it = values_.find(r.content); it != values_.end()) {
      ages_.splice(ages_.end(), ages_, it->second.age);
      return it->second.value;
    }
  }
  const ValueType* type = types_.find(r.type);
  if (folder_.empty() || !type) return {};
  const fs::path path = value_path(r.content);
  const auto data = read_file(path);
  if (!data) return {};
  constexpr std::size_t head = sizeof value_magic;
  if (data->size() > head && data->compare(0, head, value_magic, head) == 0 &&
      hash_of(data->data() + head, data->size() - head) == r.content)
    try {
      Reader reader(data->data() + head, data->size() - head);
      if (reader.text() == r.type) {
        Value v(type, type->decode(reader));
        keep_in_memory(r.content, v, r.bytes);
        return v;
      }
    } catch (const Error&) {  // written by another version of the codec: recomputed
    }
  std::error_code ignored;
  fs::remove(path, ignored);
  return {};
}

}  // namespace terrazzo
