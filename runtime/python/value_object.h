// The base of the classes of values.
#pragma once

#include <utility>

#include "runtime/given.h"
#include "runtime/python/bind.h"

namespace terrazzo::python {

struct ValueObject {
  explicit ValueObject(Value v) : value(std::move(v)) {}
  Value value;
};

py::object volume_object(const Value&);

}  // namespace terrazzo::python
