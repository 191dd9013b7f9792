"""Imports particles, volumes and solid textures of Terrazzo into Blender: File, Import, Terrazzo (.glb, .vdb, .png).

Install: Edit, Preferences, Add-ons, Install, and choose this file. Or run it in the text editor.

A .glb file written with `instancing: extension` becomes one object per particle. Objects of one shape share a mesh. Each has
the particle's color (shown by the material through Object Info) and the custom property `id`, its index. The .vdb file beside
it, or any that is chosen alone, becomes a volume. A .png file of the slices of a cubic solid becomes a material that shows the
solid at each point of an object, and repeats. One unit of the scene is one millimeter.

Tested with Blender 3.4. Lines marked "4.x" are for later versions and untested.
"""
import json
import math
import os
import struct

import bpy
from bpy_extras.io_utils import ImportHelper
from mathutils import Matrix, Quaternion, Vector

bl_info = {
    "name": "Terrazzo",
    "author": "The authors of Terrazzo",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "File > Import > Terrazzo (.glb, .vdb, .png)",
    "description": "Imports particles as instances with colors and ids, grids as a volume, and slices as a material",
    "category": "Import-Export",
}

MM_PER_METER = 1000.0
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
FORMATS = {5121: "B", 5123: "H", 5125: "I", 5126: "f"}


class TerrazzoError(Exception):
    """A file that cannot be imported."""


class Glb:
    """A binary glTF file: its JSON and its accessors."""

    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        if len(data) < 20 or data[:4] != b"glTF":
            raise TerrazzoError("this is not a binary glTF file")
        chunks, at = {}, 12
        while at + 8 <= len(data):
            length, kind = struct.unpack_from("<I4s", data, at)
            if at + 8 + length > len(data):
                raise TerrazzoError("the file is truncated")
            chunks.setdefault(kind, data[at + 8:at + 8 + length])
            at += 8 + length
        try:
            self.json = json.loads(chunks[b"JSON"])
        except (KeyError, ValueError) as error:
            raise TerrazzoError("the file has no valid JSON") from error
        self.bytes = chunks.get(b"BIN\0", b"")

    def rows(self, index):
        """The elements of an accessor as tuples of numbers."""
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        row = struct.Struct("<" + COMPONENTS[accessor["type"]] * FORMATS[accessor["componentType"]])
        if "byteStride" in view or begin + accessor["count"] * row.size > len(self.bytes):
            raise TerrazzoError("the file has data in a form that Terrazzo does not write")
        return list(row.iter_unpack(self.bytes[begin:begin + accessor["count"] * row.size]))


def z_up(v):
    """glTF has the y axis up and meters, the scene the z axis and millimeters."""
    return Vector((v[0], -v[2], v[1])) * MM_PER_METER


def object_color_material():
    """One material for all: its color is that of the object."""
    material = bpy.data.materials.get("Terrazzo particle")
    if material:
        return material
    material = bpy.data.materials.new("Terrazzo particle")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    info = nodes.new("ShaderNodeObjectInfo")
    info.location = (-300, 200)
    shader = next(n for n in nodes if n.type == "BSDF_PRINCIPLED")
    shader.inputs["Roughness"].default_value = 0.6
    links.new(info.outputs["Color"], shader.inputs["Base Color"])
    return material


def make_mesh(glb, index):
    """A mesh with one vertex per position; glTF repeats those of flat faces, because it stores their normals."""
    source = glb.json["meshes"][index]
    primitive = source["primitives"][0]
    positions = glb.rows(primitive["attributes"]["POSITION"])
    corners = [row[0] for row in glb.rows(primitive["indices"])]
    if corners and max(corners) >= len(positions):
        raise TerrazzoError("a mesh refers to vertices that do not exist")
    first = {}
    number = [first.setdefault(p, len(first)) for p in positions]
    faces = [tuple(number[c] for c in corners[k:k + 3]) for k in range(0, len(corners), 3)]
    mesh = bpy.data.meshes.new(source.get("name") or "particle")
    mesh.from_pydata([z_up(p) for p in first], [], faces)
    smooth = len(positions) < len(corners)
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(mesh.polygons))
    mesh.materials.append(object_color_material())
    mesh.update()
    return mesh


def import_particles(path, context):
    """Adds a collection with one object per particle, and returns their number."""
    glb = Glb(path)
    name = os.path.splitext(os.path.basename(path))[0]
    found = []
    try:
        for node in glb.json.get("nodes", []):
            extension = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
            if extension is None:
                continue
            at = extension["attributes"]
            columns = [glb.rows(at[key]) for key in ("TRANSLATION", "ROTATION", "SCALE", "_COLOR_0", "_ID")]
            if len({len(column) for column in columns}) != 1:
                raise TerrazzoError("the particles' attributes differ in number")
            found.append((node["mesh"], columns))
    except (KeyError, IndexError, TypeError) as error:
        raise TerrazzoError(f"the file is incomplete: {error}") from error
    if not found:
        raise TerrazzoError("the file has no instances; export particles with instancing: extension")
    collection = bpy.data.collections.new(name)
    context.scene.collection.children.link(collection)
    count = 0
    for index, columns in found:
        mesh = make_mesh(glb, index)
        for place, turn, scale, color, number in zip(*columns):
            item = bpy.data.objects.new(f"{mesh.name}.{int(number[0])}", mesh)
            rotation = Quaternion((turn[3], turn[0], -turn[2], turn[1]))
            item.matrix_world = Matrix.LocRotScale(z_up(place), rotation, Vector((scale[0], scale[2], scale[1])))
            item.color = (*color, 1.0)
            item["id"] = int(number[0])
            collection.objects.link(item)
            count += 1
    return count


def import_volume(path, context, hidden):
    """Adds a volume object for a .vdb file. Terrazzo's lengths in it are millimeters."""
    name = os.path.splitext(os.path.basename(path))[0]
    volume = bpy.data.volumes.new(name + " grids")
    volume.filepath = path
    if not volume.grids.load():
        reason = volume.grids.error_message
        bpy.data.volumes.remove(volume)
        raise TerrazzoError(f"'{path}' cannot be read: {reason}")
    item = bpy.data.objects.new(volume.name, volume)
    # The particles fill the same space.
    item.hide_render = hidden
    context.scene.collection.objects.link(item)
    item.hide_set(hidden)
    return len(volume.grids)


def voxels_of(width, height):
    """Voxels along an edge of a cubic solid whose slices fill a picture of this size."""
    for count in range(1, 2049):
        columns = math.ceil(math.sqrt(count))
        if columns * count == width and -(-count // columns) * count == height:
            return count
    raise TerrazzoError(f"{width} × {height} pixels are not the slices of a cube; export a volume of equal edges as .png")


class SolidNodes:
    """Makes nodes of a material. Values are sockets or numbers."""

    def __init__(self, tree):
        self.tree = tree

    def add(self, kind, inputs=(), **settings):
        node = self.tree.nodes.new(kind)
        for name, value in settings.items():
            setattr(node, name, value)
        for index, value in enumerate(inputs):
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, node.inputs[index])
            else:
                node.inputs[index].default_value = value
        return node

    def math(self, operation, *inputs):
        return self.add("ShaderNodeMath", inputs, operation=operation).outputs[0]

    def slice(self, image, count, x, y, z):
        """The color at texel (x, y) of slice z, which is a whole number."""
        columns = image.size[0] // count
        inside = [self.math("MINIMUM", self.math("MAXIMUM", v, 0.5), count - 0.5) for v in (x, y)]
        column, row = self.math("MODULO", z, columns), self.math("FLOOR", self.math("DIVIDE", z, columns))
        u = self.math("DIVIDE", self.math("MULTIPLY_ADD", column, count, inside[0]), image.size[0])
        v = self.math("DIVIDE", self.math("MULTIPLY_ADD", row, count, inside[1]), image.size[1])
        at = self.add("ShaderNodeCombineXYZ", (u, self.math("SUBTRACT", 1.0, v), 0.0)).outputs[0]
        return self.add("ShaderNodeTexImage", (at,), image=image, extension="EXTEND").outputs["Color"]


def import_solid(path, edge):
    """Adds a material that shows the solid whose slices are in a picture. `edge`: of the solid, in scene units."""
    image = bpy.data.images.load(path)
    count = voxels_of(*image.size)
    material = bpy.data.materials.new(os.path.splitext(os.path.basename(path))[0])
    material.use_nodes = True
    nodes = SolidNodes(material.node_tree)
    place = nodes.add("ShaderNodeTexCoord").outputs["Object"]
    periods = nodes.add("ShaderNodeVectorMath", (place, (1 / edge,) * 3), operation="MULTIPLY").outputs[0]
    inside = nodes.add("ShaderNodeVectorMath", (periods,), operation="FRACTION").outputs[0]
    x, y, z = (nodes.math("MULTIPLY", v, count) for v in nodes.add("ShaderNodeSeparateXYZ", (inside,)).outputs)
    below = nodes.math("FLOOR", nodes.math("SUBTRACT", z, 0.5))
    share = nodes.math("SUBTRACT", nodes.math("SUBTRACT", z, 0.5), below)
    first = nodes.math("MODULO", nodes.math("ADD", below, count), count)
    second = nodes.math("MODULO", nodes.math("ADD", first, 1.0), count)
    colors = [nodes.slice(image, count, x, y, k) for k in (first, second)]
    color = nodes.add("ShaderNodeMixRGB", (share, *colors)).outputs[0]
    surface = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")  # names are translated
    material.node_tree.links.new(color, surface.inputs["Base Color"])
    return material


class IMPORT_SCENE_OT_terrazzo(bpy.types.Operator, ImportHelper):
    """Import particles and volumes that Terrazzo has exported"""
    bl_idname = "import_scene.terrazzo"
    bl_label = "Import Terrazzo"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".glb"
    filter_glob: bpy.props.StringProperty(default="*.glb;*.vdb;*.png", options={"HIDDEN"})
    volume: bpy.props.BoolProperty(
        name="Volume", default=True,
        description="With a .glb file, also import the .vdb file of the same name, hidden, since particles fill the same space")

    edge: bpy.props.FloatProperty(
        name="Edge", default=1.0, min=1e-6,
        description="With a .png file of slices, the edge of the solid in units of the scene")

    def execute(self, context):
        stem, extension = os.path.splitext(self.filepath)
        try:
            if extension.lower() == ".png":
                material = import_solid(self.filepath, self.edge)
                if context.object is not None and context.object.type == "MESH":
                    context.object.data.materials.append(material)
                self.report({"INFO"}, f"material {material.name}")
                return {"FINISHED"}
            if extension.lower() == ".vdb":
                grids = import_volume(self.filepath, context, hidden=False)
                self.report({"INFO"}, f"{grids} grids")
                return {"FINISHED"}
            count = import_particles(self.filepath, context)
            grids = 0
            if self.volume and os.path.exists(stem + ".vdb"):
                grids = import_volume(stem + ".vdb", context, hidden=True)
            self.report({"INFO"}, f"{count} particles, {grids} grids")
            return {"FINISHED"}
        except (TerrazzoError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}


def menu_entry(self, _context):
    self.layout.operator(IMPORT_SCENE_OT_terrazzo.bl_idname, text="Terrazzo (.glb, .vdb, .png)")


classes = [IMPORT_SCENE_OT_terrazzo]

if bpy.app.version >= (4, 1, 0):  # 4.x: files can be dropped into the window
    class IMPORT_SCENE_FH_terrazzo(bpy.types.FileHandler):
        bl_idname = "IMPORT_SCENE_FH_terrazzo"
        bl_label = "Terrazzo volume"
        bl_import_operator = "import_scene.terrazzo"
        bl_file_extensions = ".vdb"

        @classmethod
        def poll_drop(cls, context):
            return context.area is not None and context.area.type == "VIEW_3D"

    classes.append(IMPORT_SCENE_FH_terrazzo)


def register():
    for item in classes:
        bpy.utils.register_class(item)
    bpy.types.TOPBAR_MT_file_import.append(menu_entry)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(menu_entry)
    for item in reversed(classes):
        bpy.utils.unregister_class(item)


if __name__ == "__main__":
    register()
