"""Bundles, as other people send them."""

import json
import shutil
import zipfile

import pytest
import terrazzo as t

GRAPH = """terrazzo: 1
parameters: {size: {type: int, default: 8}}
nodes:
  photo: {type: LoadImage, params: {path: pictures/a.png}}
  sheet: {type: ContactSheet, inputs: {images: photo.image}, params: {cell: 40}}
"""


@pytest.fixture
def folder(tmp_path, section):
    own = tmp_path / "stone"
    (own / "pictures").mkdir(parents=True)
    shutil.copy(section, own / "pictures" / "a.png")
    (own / "graph.yaml").write_text(GRAPH)
    (own / "bundle.json").write_text(json.dumps({"terrazzo_bundle": 1, "graph": "graph.yaml"}))
    return own


def test_folders_and_archives_open(folder, tmp_path):
    archive = shutil.make_archive(tmp_path / "sent", "zip", folder)
    shapes = [t.load(f, size=9)["sheet"].image.value().pixels.shape for f in (folder, archive)]
    assert shapes[0] == shapes[1]


def test_nothing_outside_is_read(folder, tmp_path):
    graph = folder / "graph.yaml"
    graph.write_text(GRAPH.replace("pictures/a.png", "../other.png"))
    with pytest.raises(t.Error) as e:
        t.load(folder)
    assert e.value.code == "outside-bundle"
    with zipfile.ZipFile(tmp_path / "evil.zip", "w") as z:
        z.writestr("../evil.txt", "x")
    with pytest.raises(t.Error) as e:
        t.load(tmp_path / "evil.zip")
    assert e.value.code == "bad-bundle"
    assert not (tmp_path / "evil.txt").exists()
