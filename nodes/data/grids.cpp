#include "nodes/data/grids.h"

#ifdef TERRAZZO_GRIDS_OF_OPENVDB
// libopenvdb has inlined these constructors, so it does not contain them; whether a caller inlines them
// depends on what is compiled with it.
#define TERRAZZO_GRID(NAME) template openvdb::Grid<openvdb::NAME>::Grid(const openvdb::NAME::ValueType&);
TERRAZZO_EACH_GRID_TREE(TERRAZZO_GRID)
#undef TERRAZZO_GRID
#endif
