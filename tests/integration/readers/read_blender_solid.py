"""blender --background --factory-startup --python read_blender_solid.py -- ADDON.py SLICES.png EDGE OUT.json: imports slices with the
add-on and writes the colors of a plane through the solid, rendered from above, as JSON: rows from the bottom."""
import importlib.util
import json
import sys
import tempfile

import bpy

SIDE = 48  # pixels

addon, path, edge, out_file = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
spec = importlib.util.spec_from_file_location("terrazzo_import", addon)
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
module.register()
edge = float(edge)
mesh = bpy.data.meshes.new("plane")  # over two periods, tilted
mesh.from_pydata([(0, 0, 0.3 * edge), (2 * edge, 0, 0.3 * edge), (2 * edge, 2 * edge, 1.2 * edge), (0, 2 * edge, 1.2 * edge)], [],
                 [(0, 1, 2, 3)])
plane = bpy.data.objects.new("plane", mesh)
scene = bpy.context.scene
scene.collection.objects.link(plane)
bpy.context.view_layer.objects.active = plane
result = list(bpy.ops.import_scene.terrazzo(filepath=path, edge=edge))
material = plane.data.materials[0]
tree = material.node_tree  # seen as it is, without light
glow = tree.nodes.new("ShaderNodeEmission")
tree.links.new(tree.nodes["Principled BSDF"].inputs["Base Color"].links[0].from_socket, glow.inputs["Color"])
tree.links.new(glow.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
camera = bpy.data.cameras.new("camera")
camera.type, camera.ortho_scale = "ORTHO", 2 * edge
eye = bpy.data.objects.new("camera", camera)
eye.location = (edge, edge, 5 * edge)
camera.clip_end = 10 * edge
scene.collection.objects.link(eye)
scene.camera = eye
scene.render.engine = "CYCLES"
scene.cycles.samples = 1
scene.cycles.use_denoising = False
scene.cycles.filter_width = 0.01
scene.render.resolution_x = scene.render.resolution_y = SIDE
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.filepath = tempfile.mkdtemp() + "/plane.exr"
bpy.ops.render.render(write_still=True)
picture = bpy.data.images.load(scene.render.filepath)
picture.colorspace_settings.name = "Linear"
json.dump({"result": result, "side": SIDE, "pixels": list(picture.pixels)}, open(out_file, "w"))
