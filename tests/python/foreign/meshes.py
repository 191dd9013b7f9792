"""Meshes of cubes: STL, OBJ, PLY and OFF."""

import struct

import numpy as np

from foreign.sample import Sample, read_mesh

TRIANGLES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6),
             (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
UTM = (447123.25, 5411234.75, 312.5)


def cube(corner=(0, 0, 0), edge=10.0, faces=TRIANGLES):
    corners = np.array([(x, y, z) for x in (0, edge) for y in (0, edge) for z in (0, edge)]) + corner
    return corners.tolist(), faces


def inward(body):
    return body[0], [face[::-1] for face in body[1]]


def stl(bodies, spelling=str, end="endsolid x", name=" part name"):
    text = ""
    for corners, faces in bodies:
        text += spelling("solid") + name + "\n"
        for face in faces:
            text += spelling("facet normal") + " 0 0 0\n" + spelling("outer loop") + "\n"
            for k in face:
                text += spelling("vertex") + " {!r} {!r} {!r}\n".format(*corners[k])
            text += spelling("endloop") + "\n" + spelling("endfacet") + "\n"
        text += end + "\n"
    return text


def binary_stl(bodies, head=b"", trail=b""):
    facets = [[corners[k] for k in face] for corners, faces in bodies for face in faces]
    content = head.ljust(80) + struct.pack("<I", len(facets))
    for facet in facets:
        content += struct.pack("<12fH", 0, 0, 0, *np.ravel(facet), 0)
    return content + trail


def obj(bodies, relative=False, corner="{}", names=True):
    """Corners of faces may also name normals and texture coordinates."""
    text, first = "# comment\nvn 0 0 1\nvt 0 0\n", 1
    for number, (corners, faces) in enumerate(bodies):
        text += f"o body{number}\n" if names else ""
        text += "".join("v {!r} {!r} {!r}\n".format(*point) for point in corners)
        shift = -len(corners) if relative else first
        for face in faces:
            text += "f " + " ".join(corner.format(k + shift) for k in face) + "\n"
        first += len(corners)
    return text


PLY = """ply
format {form} 1.0
comment made by hand
element vertex 8
property {number} x
property {number} y
property {number} z
{more}element face {faces}
property list {count} {index} {name}
end_header
"""


def ply(body, name="vertex_indices", more="", extra=""):
    corners, faces = body
    text = PLY.format(form="ascii", number="double", more=more, faces=len(faces), count="uchar", index="int",
                      name=name)
    text += "".join("{!r} {!r} {!r}".format(*point) + extra + "\n" for point in corners)
    return text + "".join(f"{len(face)} {' '.join(map(str, face))}\n" for face in faces)


def binary_ply(body, order="<"):
    corners, faces = body
    form = "binary_little_endian" if order == "<" else "binary_big_endian"
    head = PLY.format(form=form, number="float", more="property uchar red\n", faces=len(faces),
                      count="ushort", index="uint", name="vertex_index")
    content = b"".join(struct.pack(order + "3fB", *point, 7) for point in corners)
    content += b"".join(struct.pack(f"{order}H{len(face)}I", len(face), *face) for face in faces)
    return head.encode() + content


def off(body):
    corners, faces = body
    text = f"OFF\n# comment\n{len(corners)} {len(faces)} 0\n"
    text += "".join("{} {} {}\n".format(*point) for point in corners)
    return text + "".join(f"{len(face)} {' '.join(map(str, face))} 0.5 0.5 0.5\n" for face in faces)


def sample(name, content, *volumes, error=""):
    return Sample("mesh", name, content, error or {"volumes": list(volumes)}, read_mesh, {}, 1e-7)


SMALL = cube((30, 0, 0), 5)
TWO = [cube(), SMALL]
OPEN = cube(faces=TRIANGLES[1:])
COLORS = "property uchar red\nproperty float nx\n"

SAMPLES = [
    sample("plain.stl", stl([cube()]), 1000),
    sample("capitals.stl", stl([cube()], str.upper, "ENDSOLID"), 1000),
    sample("end_solid.stl", stl([cube()], str.title, "end solid part"), 1000),
    sample("no_name.stl", stl([cube()], end="endsolid", name=""), 1000),
    sample("cr.stl", stl([cube()]).replace("\n", "\r"), 1000),
    sample("solids_crlf.stl", stl(TWO).replace("\n", "\r\n"), 1000, 125),
    sample("utm.stl", stl([cube(UTM, 0.25)]), 0.25**3),
    sample("binary_solid.stl", binary_stl([cube()], b"solid like ascii"), 1000),
    sample("trailing.stl", binary_stl([cube()], b"solid a\nfacet", b"trailing text"), 1000),
    sample("overlapping.stl", binary_stl([cube(), cube((5, 0, 0))]), 1000, 1000),
    sample("hollow.stl", binary_stl([cube(), inward(cube((2, 2, 2), 5))]), 875),
    sample("within.stl", binary_stl([cube(), cube((2, 2, 2), 5)]), 1000, 125),
    sample("cut.stl", binary_stl([cube()])[:-20], error="unreadable-mesh"),
    sample("open.stl", stl([OPEN]), error="open-mesh"),
    sample("named.obj", obj(TWO), 1000, 125),
    sample("unnamed.obj", obj(TWO, names=False), 1000, 125),
    sample("relative.obj", obj(TWO, relative=True), 1000, 125),
    sample("quads_crlf.obj", obj([cube(faces=QUADS)]).replace("\n", "\r\n"), 1000),
    sample("normals.obj", obj([cube()], corner="{}//1"), 1000),
    sample("texture.obj", obj([cube()], corner="{}/1/1"), 1000),
    sample("weights.obj", obj([cube()]).replace(".0\n", ".0 1.0\n"), 1000),
    sample("continued.obj", obj([cube(faces=QUADS)]).replace("f 1 ", "f 1 \\\n"), 1000),
    sample("utm.obj", obj([cube(UTM, 0.25)]), 0.25**3),
    sample("beyond.obj", obj([cube()]).replace("f 1 ", "f 99 "), error="bad-mesh"),
    sample("text.ply", ply(cube()), 1000),
    sample("quads_crlf.ply", ply(cube(faces=QUADS)).replace("\n", "\r\n"), 1000),
    sample("colors.ply", ply(cube(), "vertex_index", COLORS, " 255 0.5"), 1000),
    sample("utm.ply", ply(cube(UTM, 0.25)), 0.25**3),
    sample("little_endian.ply", binary_ply(cube(faces=QUADS)), 1000),
    sample("big_endian.ply", binary_ply(cube(), ">"), 1000),
    sample("cut.ply", binary_ply(cube())[:-3], error="unreadable-mesh"),
    sample("text.off", off(cube()), 1000),
    sample("quads_crlf.off", off(cube(faces=QUADS)).replace("\n", "\r\n"), 1000),
    sample("inside_out.off", off(inward(cube())), error="inside-out"),
]
