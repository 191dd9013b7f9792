#include "nodes/data/grids.h"

#ifdef TERRAZZO_GRIDS_OF_OPENVDB
// libopenvdb has inlined these constructors, so it does not contain them; whether a caller inlines them
// depends on what is compiled with it.
#define TERRAZZO_GRID(NAME) template openvdb::Grid<openvdb::NAME>::Grid(const openvdb::NAME::ValueType&);
TERRAZZO_GRID(FloatTree)
TERRAZZO_GRID(DoubleTree)
TERRAZZO_GRID(Int32Tree)
TERRAZZO_GRID(BoolTree)
TERRAZZO_GRID(Vec3STree)
TERRAZZO_GRID(Vec3ITree)
#undef TERRAZZO_GRID
#endif
