// Type-erased values on wires, which the runtime stores, hashes and passes on.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "runtime/codec.h"

namespace terrazzo {

// Everything that the runtime needs to know about a value type.
struct ValueType {
  std::string name;  // as used by ports: "Image"
  std::string doc;
  std::function<void(const void*, Writer&)> encode;            // deterministic: equal values have equal bytes
  std::function<std::shared_ptr<const void>(Reader&)> decode;  // throws Error "damaged"
  std::function<nlohmann::json(const void*)> describe;         // for `terrazzo show --json`
};

// Specialized for each type in nodes/data/.
template <class T>
const ValueType& value_type();

// Builds the ValueType of T from three functions. Used in nodes/data/*.cpp.
template <class T>
ValueType make_value_type(std::string name, std::string doc, void (*encode)(const T&, Writer&),
                          T (*decode)(Reader&), nlohmann::json (*describe)(const T&));

class Value {
 public:
  Value() = default;
  template <class T>
  static Value of(T v) {
    return Value(&value_type<T>(), std::make_shared<const T>(std::move(v)));
  }
  template <class T>
  static Value share(std::shared_ptr<const T> v) {
    return Value(&value_type<T>(), std::move(v));
  }
  Value(const ValueType* type, std::shared_ptr<const void> data) : type_(type), data_(std::move(data)) {}

  explicit operator bool() const { return data_ != nullptr; }
  const ValueType& type() const { return *type_; }
  const void* data() const { return data_.get(); }
  std::shared_ptr<const void> share() const { return data_; }
  template <class T>
  bool is() const {
    return type_ && type_->name == value_type<T>().name;
  }
  template <class T>
  const T& as() const {
    if (!is<T>())
      throw Error("wrong-type",
                  "expected a " + value_type<T>().name + ", got " + (type_ ? type_->name : "nothing"));
    return *static_cast<const T*>(data_.get());
  }

 private:
  const ValueType* type_ = nullptr;
  std::shared_ptr<const void> data_;
};

// The value types of a program by name. Cached values find their decoder here.
class ValueTypes {
 public:
  void add(const ValueType&);
  const ValueType* find(const std::string& name) const;
  std::vector<std::string> names() const;

 private:
  std::map<std::string, const ValueType*> types_;
};

template <class T>
ValueType make_value_type(std::string name, std::string doc, void (*encode)(const T&, Writer&),
                          T (*decode)(Reader&), nlohmann::json (*describe)(const T&)) {
  return {std::move(name), std::move(doc),
          [encode](const void* v, Writer& w) { encode(*static_cast<const T*>(v), w); },
          [decode](Reader& r) -> std::shared_ptr<const void> { return std::make_shared<const T>(decode(r)); },
          [describe](const void* v) { return describe(*static_cast<const T*>(v)); }};
}

}  // namespace terrazzo
