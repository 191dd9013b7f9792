// Every node type in this build.
#pragma once

#include "nodes/register_nodes.h"

namespace terrazzo::test {

inline const Registry& all_nodes() {
  static const Registry all = [] {
    Registry r;
    register_nodes(r);
    return r;
  }();
  return all;
}

}  // namespace terrazzo::test
