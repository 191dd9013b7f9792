// Node types whose compute function is written in Python. Calls are serialized on the GIL.
#pragma once

#include <string>

#include "runtime/clients/python/bind.h"

namespace terrazzo::python {

// Raises Canceled in the threads whose nodes are canceled. Python code sees it at its next line.
void stop_canceled_calls();

// The exception with this traceback that a node raised, or None. The caller is the only one to get it.
py::object take_exception(const std::string& traceback);

}  // namespace terrazzo::python
