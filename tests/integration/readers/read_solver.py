"""read_solver.py FILE.yaml|FILE.vtu: prints as JSON what PyYAML or VTK finds."""
import json
import sys

path = sys.argv[1]
if path.endswith(".yaml"):
    import yaml

    with open(path) as file:
        print(json.dumps(yaml.safe_load(file)))
else:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    sizes = vtkCellSizeFilter()
    sizes.SetInputConnection(reader.GetOutputPort())
    sizes.Update()
    grid, cells = reader.GetOutput(), sizes.GetOutput().GetCellData()
    fields, points = grid.GetFieldData(), vtk_to_numpy(grid.GetPoints().GetData())

    def side(name):
        return vtk_to_numpy(fields.GetArray("nodes_" + name))

    print(json.dumps({
        "bounds": grid.GetBounds(),
        "volumes": vtk_to_numpy(cells.GetArray("Volume")).tolist(),
        "material": vtk_to_numpy(cells.GetArray("material")).tolist(),
        "arrays": [cells.GetArrayName(i) for i in range(cells.GetNumberOfArrays())],
        "steps": {a: (points[side(a + "1")] - points[side(a + "0")]).tolist() for a in "XYZ"},
    }))
