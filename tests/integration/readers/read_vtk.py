"""read_vtk.py FILE.vti|FILE.nii.gz: prints what VTK's own reader finds as JSON."""
import json
import sys

from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkNIFTIImageReader
from vtkmodules.vtkIOXML import vtkXMLImageDataReader

path = sys.argv[1]
reader = vtkXMLImageDataReader() if path.endswith(".vti") else vtkNIFTIImageReader()
reader.SetFileName(path)
reader.Update()
image = reader.GetOutput()
data = image.GetCellData() if path.endswith(".vti") else image.GetPointData()
fields = image.GetFieldData()
print(json.dumps({
    "extent": image.GetExtent(),
    "spacing": image.GetSpacing(),
    "origin": image.GetOrigin(),
    "arrays": {
        data.GetArrayName(i): {
            "type": data.GetArray(i).GetDataTypeAsString(),
            "components": data.GetArray(i).GetNumberOfComponents(),
            "values": vtk_to_numpy(data.GetArray(i)).ravel().tolist(),
        } for i in range(data.GetNumberOfArrays())
    },
    "fields": {
        fields.GetArrayName(i): [str(fields.GetAbstractArray(i).GetVariantValue(k).ToString())
                                 for k in range(fields.GetAbstractArray(i).GetNumberOfValues())]
        for i in range(fields.GetNumberOfArrays())
    },
}))
