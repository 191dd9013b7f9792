#include "runtime/clients/studio/library.h"

#include "nodes/common/io/provenance.h"
#include "nodes/register_nodes.h"
#include "runtime/clients/studio/paint/paint_command.h"
#include "runtime/clients/studio/studio_command.h"

extern "C" const terrazzo::studio::Library* terrazzo_studio_library() {
  static const terrazzo::studio::Library library = {terrazzo::register_nodes, terrazzo::register_value_types,
                                                    terrazzo::read_provenance, terrazzo::studio::paint,
                                                    terrazzo::studio::studio};
  return &library;
}
