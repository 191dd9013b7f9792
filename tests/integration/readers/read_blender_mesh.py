"""blender --background --factory-startup --python read_blender_mesh.py -- FILE.glb OUT.json [COPY.glb]: imports a glTF file with
Blender's own importer, writes its mesh with colors as JSON, and exports the scene again."""
import json
import sys

import bpy
import numpy

numpy.bool = bool  # Blender 3.4 uses names that NumPy 1.24 removed

path, out_file, *copy = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=path)
out = []
for o in bpy.data.objects:
    if o.type != "MESH":
        continue
    colors = o.data.color_attributes
    corners = [list(c.color)[:3] for c in colors[0].data] if len(colors) else []
    per_corner = len(colors) and colors[0].domain == "CORNER"
    out.append({
        "name": o.data.name,
        "vertices": [list(o.matrix_world @ v.co) for v in o.data.vertices],
        "polygons": len(o.data.polygons),
        "color_of": [loop.vertex_index for loop in o.data.loops] if per_corner else list(range(len(corners))),
        "colors": corners,
        "textures": [n.image.size[0] for m in o.data.materials for n in m.node_tree.nodes if n.bl_idname == "ShaderNodeTexImage"],
    })
if copy:
    # A mirrored, turned and scaled child of a moved parent.
    parent = bpy.data.objects.new("parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.location = (0.01, 0.02, 0.03)
    parent.rotation_euler = (0.3, 0.2, 0.1)
    for o in bpy.data.objects:
        if o.type == "MESH":
            o.parent = parent
            o.scale = (-2, 1, 1.5)
    bpy.ops.export_scene.gltf(filepath=copy[0], export_format="GLB")
json.dump(out, open(out_file, "w"))
