"""Nodes that are repeated for a list of values."""

import pytest

import terrazzo as t
from conftest import SOURCE

REPEATED = f"""\
terrazzo: 1
nodes:
  spots:  # four pictures
    type: Pattern
    each: {{kind: [fat, wood], seed: 1:2:1}}
    params: {{kind: "${{kind}}", width: 32, height: 32, seed: "${{seed}}"}}
  fields:
    graph: {SOURCE}/graphs/library/fields.yaml
    each: {{of: ["fat,1", "wood,2"]}}
    inputs: {{image: "spots[${{of}}].image"}}
  sheet: {{type: ContactSheet, inputs: {{images: spots.image}}, params: {{cell: 32}}}}
outputs:
  spots: spots.image
"""


def test_repeated_nodes_are_kept_and_their_elements_evaluated(tmp_path):
    (tmp_path / "r.yaml").write_text(REPEATED)
    g = t.load(tmp_path / "r.yaml", cache=False)
    assert g.to_yaml(tmp_path) == REPEATED
    g.save(tmp_path / "again.yaml")
    assert (tmp_path / "again.yaml").read_text() == REPEATED
    assert g["spots[wood,2]"]["kind"] == "wood" and g["spots"]["kind"] == "${kind}"
    h = t.Graph(cache=False)
    assert g["spots[wood,2]"].image.value() == h.Pattern(kind="wood", width=32, height=32, seed=2).image.value()
    elements = [g[f"spots[{name}]"].image.value() for name in ("fat,1", "fat,2", "wood,1", "wood,2")]
    assert g["spots"].image.value() == g.spots.values() == elements
    assert g["sheet"].image.value()
    assert "spots × 4" in g.draw("dot")
    g["spots"]["width"] = 40
    assert g["spots[fat,1]"].image.value().width == 40
    assert "each: {kind: [fat, wood], seed: 1:2:1}" in g.to_yaml(tmp_path)


def test_an_element_of_a_subgraph_has_its_own_outputs(tmp_path):
    (tmp_path / "dots.yaml").write_text(
        "terrazzo: 1\nparameters: {seed: {type: int, default: 1}}\nnodes:\n"
        "  dots: {type: Pattern, params: {kind: fat, width: 32, height: 32, seed: '${seed}'}}\n"
        "outputs: {image: dots.image}\n")
    (tmp_path / "g.yaml").write_text(
        "terrazzo: 1\nnodes:\n  all: {graph: dots.yaml, each: {k: [3, 4]}, params: {seed: '${k}'}}\n"
        "  sheet: {type: ContactSheet, inputs: {images: all.image}, params: {cell: 32}}\n")
    g = t.load(tmp_path / "g.yaml", cache=False)
    h = t.Graph(cache=False)
    assert g["all[4]"].image.value() == h.Pattern(kind="fat", width=32, height=32, seed=4).image.value()
    assert g["sheet"].image.value()
    assert g["all"].image.value() == [g["all[3]"].image.value(), g["all[4]"].image.value()]


def test_files_that_a_node_is_repeated_for_follow_the_graph(tmp_path):
    (tmp_path / "to").mkdir()
    (tmp_path / "g.yaml").write_text(
        "terrazzo: 1\nnodes:\n  f: {type: LoadImage, each: {file: [a.png]}, params: {path: '${file}'}}\n")
    t.load(tmp_path / "g.yaml", cache=False).save(tmp_path / "to" / "g.yaml")
    assert "../a.png" in (tmp_path / "to" / "g.yaml").read_text()


def test_a_repeated_node_is_written_as_a_person_would(tmp_path):
    g = t.Graph(cache=False)
    spots = g.Pattern(each={"kind": ["fat", "wood"], "seed": range(1, 3)}, kind="${kind}", seed="${seed}", width=32,
                      height=32, name="spots")
    sheet = g.ContactSheet(images=spots.image, cell=32)
    grain = g.Grain(each={"of": ["wood,2", "fat,1"]}, image=g["spots[${of}]"].image)
    assert g.to_yaml() == """\
terrazzo: 1
nodes:
  spots:
    type: Pattern
    each: {kind: [fat, wood], seed: 1:2:1}
    params: {kind: "${kind}", width: 32, height: 32, seed: "${seed}"}
  contact_sheet:
    type: ContactSheet
    inputs: {images: spots.image}
    params: {cell: 32}
  grain:
    type: Grain
    each: {of: ["wood,2", "fat,1"]}
    inputs: {image: "spots[${of}].image"}
"""
    assert spots.each == {"kind": ["fat", "wood"], "seed": "1:2:1"} and sheet.each == {}
    h = t.Graph(cache=False)
    assert spots.image.value() == [h.Pattern(kind=k, seed=s, width=32, height=32).image.value()
                                   for k in ("fat", "wood") for s in (1, 2)]
    first, second = grain.image.value()  # in the order of `each`, whichever is computed first
    assert first == h.Grain(image=spots.image.value()[3]).image.value()
    assert second == h.Grain(image=spots.image.value()[0]).image.value()
    assert sheet.image.values() == [sheet.image.value()]
    run = g.run(spots, sheet)
    assert run.value(spots.image) == spots.image.value() and run.value(sheet.image) == sheet.image.value()
    g.save(tmp_path / "g.yaml")
    assert len(t.load(tmp_path / "g.yaml", cache=False)["spots"].image.value()) == 4
    del g["grain"]  # it uses elements that the next line removes
    spots.set(each={"kind": ["fat"], "seed": [7]})
    assert spots.image.value() == [h.Pattern(kind="fat", seed=7, width=32, height=32).image.value()]


def test_files_that_a_new_node_is_repeated_for(tmp_path):
    for k in (1, 2):
        t.image([[k / 4]]).save(f"{k}.png")
    g = t.Graph(cache=False)
    photos = g.LoadImage(each={"file": ["1.png", "2.png"]}, path="${file}")
    assert [round(float(v.pixels.mean()) + 0.01, 1) for v in photos.image.value()] == [0.3, 0.5]
    g.save(tmp_path / "g.yaml")
    assert "[work/1.png, work/2.png]" in (tmp_path / "g.yaml").read_text()


@pytest.mark.parametrize("each", [3, {"k": []}, {"k": range(0)}, {"k": [1, 1]}, {"a b": [1]}, {1: [1]},
                                  {"k": [object()]}, {"k": "x"}])
def test_wrong_lists(each):
    g = t.Graph(cache=False)
    with pytest.raises(t.Error):
        g.Pattern(each=each, seed="${k}")
        g.check()


def test_a_sweep_of_a_repeated_node():
    g = t.Graph(cache=False)
    g.parameter("seeds", "ints", [1])
    spots = g.Pattern(each={"k": g.reference("seeds")}, seed="${k}", width=32, height=32)
    sweep = g.sweep({"seeds": [[1], [3, 2]]}, spots.image, jobs=2)
    seed = {k: t.Graph(cache=False).Pattern(seed=k, width=32, height=32).image.value() for k in (1, 2, 3)}
    assert [v for (v,) in sweep.values] == [[seed[1]], [seed[3], seed[2]]]
