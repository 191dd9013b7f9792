// Intermediate results that later computations of the same process use again, such as geometry while only
// colors change.
#pragma once

#include <chrono>
#include <concepts>
#include <memory>
#include <string>
#include <type_traits>

#include "runtime/hash.h"
#include "runtime/value.h"

namespace terrazzo {

class Store;

// Intermediate results share the store's memory with values: within the same limit (--memory), those with the
// fewest seconds per byte are dropped first. They are never written to disk.
class Intermediates {
 public:
  Intermediates() = default;  // keeps nothing, so that every computation starts anew
  explicit Intermediates(Store& store) : store_(&store) {}

  // Whether anything is kept. If not, parts need not be separated.
  explicit operator bool() const { return store_; }

  // Returns what `make` returned for the same key, or calls it. The result must be a function of what the key
  // contains (key_of) and of nothing else. T has bytes(), its size in memory. Two threads that ask for one
  // key at the same time may both make it.
  template <class T, class Make>
  std::shared_ptr<const T> get(const Hash& key, Make&& make) const {
    if (auto found = find(key)) return std::static_pointer_cast<const T>(found);
    const auto start = std::chrono::steady_clock::now();
    auto made = std::make_shared<const T>(make());
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    keep(key, made, made->bytes(), time.count());
    return made;
  }

 private:
  std::shared_ptr<const void> find(const Hash&) const;
  void keep(const Hash&, std::shared_ptr<const void>, std::uint64_t bytes, double seconds) const;

  Store* store_ = nullptr;
};

// The key of an intermediate result: its name, unique in the program, and all that it depends on: numbers,
// vectors of Eigen, and values of the types on wires.
template <class... Parts>
Hash key_of(const std::string& name, const Parts&... parts) {
  HashWriter writer;
  writer.text("intermediate " + name);
  const auto add = [&]<class T>(const T& part) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>)
      writer.pod(part);
    else if constexpr (requires { part.derived().coeff(0); })
      for (int i = 0; i < part.size(); ++i) writer.pod(part.derived().coeff(i));
    else
      value_type<T>().encode(&part, writer);
  };
  (add(parts), ...);
  return writer.hash();
}

}  // namespace terrazzo
