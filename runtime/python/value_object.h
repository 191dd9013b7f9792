// The base of the classes of values.
#pragma once

#include <utility>

#include "runtime/hash.h"
#include "runtime/python/bind.h"

namespace terrazzo::python {

struct ValueObject {
  explicit ValueObject(Value v) : value(std::move(v)) {}
  Value value;
};

// The hash of the type and the encoded value, as the store computes it.
Hash content_of(const Value&);

py::object volume_object(const Value&);

}  // namespace terrazzo::python
