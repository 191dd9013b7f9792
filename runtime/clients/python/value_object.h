// The base of the classes of values.
#pragma once

#include <utility>

#include "runtime/clients/python/bind.h"
#include "runtime/given.h"

namespace terrazzo::python {

struct ValueObject {
  explicit ValueObject(Value v) : value(std::move(v)) {}
  Value value;
};

py::object volume_object(const Value&);

}  // namespace terrazzo::python
