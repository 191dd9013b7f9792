// The grid types of a volume. Include this instead of OpenVDB's own header.
#pragma once

#include <openvdb/openvdb.h>

#ifdef TERRAZZO_GRIDS_OF_OPENVDB
// libopenvdb registers these types, so it contains their virtual functions, which take ten seconds per type
// to compile. Every file that creates a grid would compile them again. Builds without optimization and with
// sanitizers do so: the former also call small functions that libopenvdb has only inlined, and the latter
// check what they compile.
#define TERRAZZO_EACH_GRID_TREE(DO) \
  DO(FloatTree) DO(DoubleTree) DO(Int32Tree) DO(BoolTree) DO(Vec3STree) DO(Vec3ITree)
#define TERRAZZO_GRID(NAME)                                               \
  extern template class openvdb::tree::Tree<openvdb::NAME::RootNodeType>; \
  extern template class openvdb::Grid<openvdb::NAME>;
TERRAZZO_EACH_GRID_TREE(TERRAZZO_GRID)
#undef TERRAZZO_GRID
#endif
