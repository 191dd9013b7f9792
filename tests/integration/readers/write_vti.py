"""write_vti.py FILE.vti MODE: writes cell data a = x + 10 y + 100 z (Int32) and v = (a, a / 2, -a) (Float32) on 4 x 3 x 2
voxels of 0.5 mm (0.0005 m) with VTK's own writer and prints true. MODE: ascii, binary, appended, raw or plain."""
import sys

import numpy
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

z, y, x = numpy.indices((2, 3, 4))
a = (x + 10 * y + 100 * z).astype(numpy.int32).ravel()
image = vtkImageData()
image.SetExtent(0, 4, 0, 3, 0, 2)
image.SetSpacing(0.0005, 0.0005, 0.0005)
for name, values in (("a", a), ("v", numpy.stack([a, a / 2, -a], axis=1).astype(numpy.float32))):
    array = numpy_to_vtk(values, deep=True)
    array.SetName(name)
    image.GetCellData().AddArray(array)
writer = vtkXMLImageDataWriter()
writer.SetFileName(sys.argv[1])
writer.SetInputData(image)
mode = sys.argv[2]
if mode == "ascii":
    writer.SetDataModeToAscii()
elif mode in ("binary", "plain"):
    writer.SetDataModeToBinary()
else:
    writer.SetDataModeToAppended()
    writer.SetEncodeAppendedData(mode != "raw")
if mode == "plain":
    writer.SetCompressorTypeToNone()
writer.Write()
print("true")
