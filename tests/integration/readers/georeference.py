"""georeference.py write FILE.tif A,B,C,D,E,F EPSG [Point]: GDAL writes a georeferenced picture of 8 x 6 pixels.
georeference.py read FILE.geojson: prints as JSON what OGR finds."""
import json
import sys

from osgeo import gdal, ogr, osr

gdal.UseExceptions()
if sys.argv[1] == "write":
    path, numbers, epsg = sys.argv[2], [float(v) for v in sys.argv[3].split(",")], int(sys.argv[4])
    out = gdal.GetDriverByName("GTiff").Create(path, 8, 6, 1, gdal.GDT_Byte)
    out.SetGeoTransform(numbers)
    system = osr.SpatialReference()
    system.ImportFromEPSG(epsg)
    out.SetProjection(system.ExportToWkt())
    if sys.argv[5:] == ["Point"]:
        out.SetMetadataItem("AREA_OR_POINT", "Point")
    out.GetRasterBand(1).Fill(90)
    out.FlushCache()
    print("{}")
else:
    file = ogr.Open(sys.argv[2])  # layers end with their file
    layer = file.GetLayer()
    system = layer.GetSpatialRef()
    print(json.dumps({
        "extent": layer.GetExtent(),
        "epsg": int(system.GetAuthorityCode(None)) if system else 0,
        "areas": [f.GetGeometryRef().GetArea() for f in layer],
        "valid": all(f.GetGeometryRef().IsValid() for f in layer),
    }))
