"""blender --background --factory-startup --python read_blender.py -- ADDON.py FILE.glb|FILE.vdb OUT.json: imports a file with the
add-on and writes what the scene contains as JSON."""
import importlib.util
import json
import sys

import bpy

addon, path, out_file = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
spec = importlib.util.spec_from_file_location("terrazzo_import", addon)
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
module.register()
try:
    result, error = list(bpy.ops.import_scene.terrazzo(filepath=path)), ""
except RuntimeError as raised:  # the report of a canceled operator
    result, error = ["CANCELLED"], str(raised)
meshes = [o for o in bpy.data.objects if o.type == "MESH"]
out = {
    "result": result,
    "error": error,
    "meshes": {m.name: [len(m.vertices), len(m.polygons)] for m in bpy.data.meshes},
    "particles": [{
        "id": o["id"],
        "mesh": o.data.name,
        "color": list(o.color),
        "material": o.data.materials[0].name,
        # the first vertex of the mesh in the scene
        "corner": list(o.matrix_world @ o.data.vertices[0].co),
        "place": list(o.matrix_world.translation),
    } for o in meshes],
    "volumes": [],
}
for o in bpy.data.objects:
    if o.type != "VOLUME":
        continue
    o.data.grids.load()
    out["volumes"].append({
        "grids": {g.name: [g.data_type, g.channels, [list(row) for row in g.matrix_object]] for g in o.data.grids},
        "hidden": o.hide_render,
        "scale": list(o.matrix_world.to_scale()),
        "box": [list(corner) for corner in o.bound_box],
    })
module.unregister()
json.dump(out, open(out_file, "w"))
