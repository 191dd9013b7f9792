"""read_surface.py FILE.msh|FILE.stl: prints what meshio finds as JSON."""
import json
import sys

import meshio
import numpy

mesh = meshio.read(sys.argv[1])
triangles = mesh.cells_dict["triangle"]
out = {"types": sorted({block.type for block in mesh.cells}), "points": len(mesh.points), "triangles": len(triangles),
       "low": mesh.points.min(axis=0).tolist(), "high": mesh.points.max(axis=0).tolist()}
if "tetra" in mesh.cells_dict:
    corner = [mesh.points[mesh.cells_dict["tetra"][:, k]] for k in range(4)]
    a, b, c = (corner[k] - corner[0] for k in (1, 2, 3))
    volumes = numpy.einsum("ij,ij->i", numpy.cross(a, b), c) / 6
    out.update(volume=abs(volumes).sum(), least=abs(volumes).min(),
               regions=len(set(mesh.cell_data_dict["gmsh:physical"]["tetra"].tolist())))
elif mesh.field_data:
    tags = mesh.cell_data_dict["gmsh:physical"]["triangle"]
    out["surfaces"] = {name: [int((tags == tag).sum()), int(dimension)] for name, (tag, dimension) in mesh.field_data.items()}
    # per pair of surfaces: the largest difference of the nodes' positions along each axis
    out["periodic"] = []
    for dimension, (slave, master), _, pairs in mesh.gmsh_periodic or []:
        difference = mesh.points[pairs[:, 0]] - mesh.points[pairs[:, 1]]
        out["periodic"].append([int(slave), int(master), difference.min(axis=0).tolist(), difference.max(axis=0).tolist()])
print(json.dumps(out))
