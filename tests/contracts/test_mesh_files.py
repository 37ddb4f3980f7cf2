"""OBJ, MTL and PLY files as people have them: right values, or the fault named."""

from io import BytesIO

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from PIL import Image

from restir_gi.reference.scene.checks.shapes import check_mesh
from restir_gi.reference.scene.loaders.load import load_scene
from restir_gi.reference.scene.loaders.pictures import decode_srgb
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Lambertian,
)
from restir_gi.reference.scene.shapes import Mesh
from restir_gi.reference.scene.textures import read
from restir_gi.reference.system.errors import UsageError

SQUARE = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n"
CORNERS = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
FAN = [[0, 1, 2], [0, 2, 3]]
PLACED = f"{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3 4/4\n"


@pytest.fixture
def put(tmp_path):
    """Return a writer of files, which gives back the path of the last."""

    def write(**files):
        for name, contents in files.items():
            path = tmp_path / name.replace("_", ".")
            data = contents if isinstance(contents, bytes) else contents.encode()
            path.write_bytes(data)
        return path

    return write


def refusal(path, lenient=False):
    with pytest.raises(UsageError) as caught:
        load_scene(path, lenient)
    message = str(caught.value)
    assert "\n" not in message
    assert message.count(str(path)) == 1
    return message


def only_mesh(path, lenient=False) -> Mesh:
    (mesh,) = load_scene(path, lenient).meshes
    return mesh


def picture(*colors, mode="RGB"):
    """PNG of one row."""
    buffer = BytesIO()
    image = Image.new(mode, (len(colors), 1))
    image.putdata(colors)
    image.save(buffer, "png")
    return buffer.getvalue()


# ---------------------------------------------------------------- OBJ


@pytest.mark.parametrize(
    "faces",
    [
        "f 1 2 3 4\n",
        "f -4 -3 -2 -1\n",
        "f 1 2 \\\n 3 4\n",
        "f 1 2 \\\r\n 3 4\r\n",
        "  f\t1 2 3 4   # a comment\n",
        "f 1// 2// 3// 4//\n",
        "g wall\no wall\ns off\nf 1 2 3 4\nl 1 2\np 1\n",
    ],
)
def test_one_square_in_many_ways(put, faces):
    mesh = only_mesh(put(a_obj=SQUARE + faces))
    assert_array_equal(mesh.vertices, CORNERS)
    assert_array_equal(mesh.faces, FAN)
    assert mesh.uv is None
    assert mesh.normals is None


@pytest.mark.parametrize("code", ["utf-8-sig", "utf-16", "latin-1"])
def test_texts_in_other_codes(put, code):
    text = f"# é\n{SQUARE}f 1 2 3 4\n"
    assert_array_equal(only_mesh(put(a_obj=text.encode(code))).vertices, CORNERS)


def test_lines_that_end_as_on_old_machines(put):
    text = f"{SQUARE}f 1 2 3 4\n".replace("\n", "\r")
    assert_array_equal(only_mesh(put(a_obj=text)).vertices, CORNERS)


def test_backward_indices_count_from_where_they_stand(put):
    later = "v 5 0 0\nv 6 0 0\nv 5 1 0\n"
    text = f"{SQUARE}f -4 -3 -2 -1\n{later}f -3 -2 -1\n"
    mesh = only_mesh(put(a_obj=text))
    assert_array_equal(mesh.vertices[mesh.faces[-1]], [[5, 0, 0], [6, 0, 0], [5, 1, 0]])


def test_corners_carry_their_own_uv_and_normal(put):
    text = f"{SQUARE}vt .25 .5\nvt .5 .75\nvn 0 0 1\nvn 0 .6 .8\n"
    text += "f 1/1/1 2/2/2 3/1/1\nf 1/2/2 3/1/1 4/2/1\n"
    mesh = only_mesh(put(a_obj=text))
    uv, normals = mesh.uv[mesh.faces], mesh.normals[mesh.faces]
    assert_array_equal(uv[0], [[0.25, 0.5], [0.5, 0.75], [0.25, 0.5]])
    assert_array_equal(uv[1], [[0.5, 0.75], [0.25, 0.5], [0.5, 0.75]])
    assert_array_equal(normals[1], [[0, 0.6, 0.8], [0, 0, 1], [0, 0, 1]])
    assert len(mesh.vertices) == 5  # 1/1/1 and 1/2/2 are two


def test_faces_with_and_without_uv_are_two_meshes(put):
    text = f"{SQUARE}vt 0 0\nf 1/1 2/1 3/1\nf 1 3 4\n"
    one, other = load_scene(put(a_obj=text)).meshes
    assert one.uv is None
    assert other.uv is not None
    assert_array_equal(one.vertices[one.faces[0]], [CORNERS[i] for i in (0, 2, 3)])


def test_colours_of_vertices_are_srgb(put):
    text = "v 0 0 0 1 .5 0\nv 1 0 0 0 0 0\nv 0 1 0 1 1 1\nf 1 2 3\n"
    mesh = only_mesh(put(a_obj=text))
    assert_allclose(mesh.colors[0], decode_srgb(np.array([1, 0.5, 0])))
    assert mesh.material.reflectance == (1, 1, 1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f"{SQUARE}f 1 2 3\nf 0 1 3\n", "line 6: a face names vertex 0; they are 1 to"),
        (f"{SQUARE}f -5 1 2\n", "line 5: a face names vertex -5; they are 1 to 4"),
        (f"{SQUARE}f 1/1 2/1 3/1\n", "names texture coordinate 1; the file has no vt"),
        (f"{SQUARE}f 1//9 2//9 3//9\n", "names normal 9; the file has no vn"),
        (f"{SQUARE}f 1/2/3/4 2 3\n", 'line 5: a face has the corner "1/2/3/4"'),
        (f"{SQUARE}f 1 2 x\n", 'line 5: a face has the corner "x"; it should be v,'),
        (f"{SQUARE}f 1 2 {'9' * 19}\n", "line 5: a face has the corner"),
        (f"{SQUARE}\\\n\nv 1 2\nf 1 2 3\n", "line 7: v has 2 numbers; it needs 3"),
        (f"{SQUARE}v 1 2 3 zz\nf 1 2 3\n", 'line 5: v has "zz"; it needs numbers'),
        (f"{SQUARE}vn 0 1\nf 1 2 3\n", "line 5: vn has 2 numbers"),
        (f"{SQUARE}s 1\nf 1 2 3\n", "line 5: smoothing of faces without normals"),
        (f"{SQUARE}surf 0 1\nf 1 2 3\n", 'line 5: "surf" is not modelled'),
        (f"{SQUARE}usemtl x\nf 1 2 3\n", 'line 5: no material file (mtllib) has "x"'),
        ("v 0 0 0 2 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "colours lie between 0 and 1"),
        (b"v 0 0 0\0\nf 1 2 3\n", "this is not text"),
    ],
)
def test_faults_of_obj_files_are_named(put, text, message):
    assert message in refusal(put(a_obj=text))


def test_huge_numbers_are_the_validations_to_report(put):
    text = f"v {'9' * 308} 0 0\nv 1 0 0\nv 0 1{'0' * 400} 0\nf 1 2 3\n"
    assert np.isinf(only_mesh(put(a_obj=text)).vertices[2, 1])


def test_all_refusals_are_told_at_once_before_numbers_are_read(put):
    mtl = "newmtl m\nKd 1 1 1\nbump a.png\nd 0.5\n"
    text = f"mtllib a.mtl\nmtllib no.mtl\nsurf 1\nv broken\nusemtl m\n{SQUARE}f 1 2 3\n"
    message = refusal(put(a_mtl=mtl, a_obj=text))
    assert "4 faults: (1) " in message
    for part in ('line 3: "surf"', '"no.mtl" cannot', "a.mtl: line 3: ", '"d 0.5"'):
        assert part in message
    assert "broken" not in message


# ---------------------------------------------------------------- MTL


def look(put, words, lenient=False, **files):
    """Mesh of a square that wears one material."""
    put(a_mtl=f"newmtl m\n{words}\n", **files)
    return only_mesh(put(a_obj=f"mtllib a.mtl\n{PLACED}"), lenient)


def test_several_libraries_on_a_line_and_names_with_spaces(put, tmp_path):
    put(a_mtl="newmtl green\nKd 0 1 0\n", b_mtl="newmtl m\nKd 1 0 0\n")
    path = put(a_obj=f"mtllib a.mtl b.mtl\n{PLACED}")
    assert only_mesh(path).material.reflectance == (1, 0, 0)
    (tmp_path / "my own.mtl").write_text("newmtl m\nKd 0 0 1\n")
    path = put(a_obj=f"mtllib my own.mtl\n{PLACED}")
    assert only_mesh(path).material.reflectance == (0, 0, 1)


def test_glass_is_glass(put):
    glass = "Kd 0 0 0\nKs 1 1 1\nNs 1000\nNi 1.5\nd 0.1\nTf 1 1 1\nillum 7"
    material = look(put, glass).material
    assert isinstance(material, Dielectric)
    assert (material.ior, material.alpha) == (1.5, 0)
    # A writer that says illum 4 of everything, and d 1 of what is opaque.
    opaque = look(put, "Kd .5 .5 .5\nNi 1.5\nTf 1 1 1\nd 1\nillum 4").material
    assert isinstance(opaque, Lambertian)


def test_mirrors_and_coats(put):
    mirror = look(put, "Kd 0 0 0\nKs .9 .8 .7\nillum 3").material
    assert isinstance(mirror, Conductor)
    assert (mirror.reflectance, mirror.alpha) == ((0.9, 0.8, 0.7), 0)
    coat = look(put, "Kd .5 .5 .5\nKs 1 1 1\nNi 1.4\nillum 5").material
    assert isinstance(coat, Coated)
    assert (coat.ior, coat.alpha, coat.specular) == (1.4, 0, (1, 1, 1))
    metal = look(put, "Kd .9 .6 .3\nPr .5\nPm 1").material
    assert (metal.alpha, metal.schlick) == (0.25, True)
    assert look(put, "Kd .9 .6 .3\nPr .5\nPm 0\nPs 0").material.alpha == 0.25


@pytest.mark.parametrize("illum", ["illum 0", "illum 1"])
def test_highlights_without_effect(put, illum):
    words = f"Kd .5 .5 .5\nKs .5 .5 .5\nNs 250\nNi 1.45\nKa 1 1 1\nd 1\n{illum}"
    assert isinstance(look(put, words).material, Lambertian)
    assert isinstance(look(put, "Kd .5 .5 .5\nKs 0 0 0\nillum 2").material, Lambertian)


@pytest.mark.parametrize(("ks", "ns"), [(0.5, 250), (1, 20), (0.02, 96)])
def test_a_highlight_has_the_height_of_the_formula(put, ks, ns):
    """F D(0) / 4 = Ks / π for light from where the eye is; rounding only."""
    coat = look(put, f"Kd .5 .5 .5\nKs {ks} {ks / 2} 0\nNs {ns}\nillum 2").material
    fresnel = ((coat.ior - 1) / (coat.ior + 1)) ** 2
    height = fresnel / (np.pi * coat.alpha**2) / 4
    # Where Ks is small, ior - 1 loses digits: a few hundred steps at the most.
    assert_allclose(
        height * np.array(coat.specular), np.array([1, 0.5, 0]) * ks / np.pi, rtol=1e-12
    )
    assert coat.distribution == "beckmann"
    assert_allclose(coat.alpha, np.sqrt(2 / (ns + 2)))


TWO = picture((255, 0, 0), (0, 0, 255))


def test_maps_with_options_and_spaces(put, tmp_path):
    (tmp_path / "my tex.png").write_bytes(TWO)
    mesh = look(put, "Kd 1 1 1\nmap_Kd -s 2 2 1 -o .25 0 0 -clamp off my tex.png")
    assert_allclose(mesh.uv, np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * 2 + [0.25, 0])
    red = read(mesh.material.reflectance, np.array([[0.25, 0.5]]))
    assert_allclose(red, [[1, 0, 0]])


@pytest.mark.parametrize("size", ["1e308", "-1e308"])
def test_a_map_of_a_size_beyond_all_numbers_is_told(put, size):
    """Coordinates times it may be infinite: one line, and no warning."""
    mesh = look(put, f"Kd 1 1 1\nmap_Kd -s {size} {size} -o {size} 0 t.png", t_png=TWO)
    with pytest.raises(UsageError, match="texture coordinate 1 is"):
        check_mesh("here", mesh)


def test_maps_of_emission_and_masks(put):
    mask = picture((255, 255, 255, 255), (0, 0, 0, 0), mode="RGBA")
    mesh = look(
        put, "Kd 1 1 1\nKe 2 2 2\nmap_Ke t.png\nmap_d m.png", t_png=TWO, m_png=mask
    )
    assert_allclose(mesh.emission.pixels, [[[2, 0, 0], [0, 0, 2]]])
    assert_array_equal(mesh.opacity.pixels[..., 0], [[1, 0]])
    assert mesh.opacity_cutoff == 0.5
    grey = look(put, "Kd 1 1 1\nmap_d m.png", m_png=picture(0, 255, mode="L"))
    assert_array_equal(grey.opacity.pixels[..., 0], [[0, 1]])


@pytest.mark.parametrize(
    ("words", "message", "kind"),
    [
        ("Kd 1 1 1\nd 0.5", '"d 0.5" is not modelled without glass', Lambertian),
        ("Kd 1 1 1\nd -halo 0.5", '"d -halo 0.5" is not modelled', Lambertian),
        ("Kd 1 1 1\nTr 0.5", '"tr 0.5" is not modelled', Lambertian),
        ("Kd 0 0 0\nNi 1.5\nTf 1 0 0\nillum 6", "coloured glass (Tf)", Dielectric),
        ("Kd 1 1 1\nNi 1.5\nd .5\nillum 6", "glass that scatters (Kd)", Dielectric),
        ("Kd 1 1 1\nKs 1 1 1\nillum 3", "a mirror (illum 3, Ks) over Kd", Coated),
        ("Kd 1 1 1\nKs 1 1 1\nNs 1", "its highlight reflects 2.67 of", Lambertian),
        ("Kd 1 1 1\nillum 10", "illum 10 is not modelled", Lambertian),
        ("Kd 1 1 1\nPm .5", "Pm 0.5 is not modelled", Conductor),
        ("Kd 1 1 1\nPr .5\nPc 1", '"pc" is not modelled', Coated),
        ("Kd 1 1 1\nbump a.png", '"bump" is not modelled', Lambertian),
        ("Kd 1 1 1\nmap_Bump a.png", '"bump" is not modelled', Lambertian),
        ("Kd 1 1 1\nKs .5 .5 .5\nNs 9\nmap_Ks a.png", '"map_ks" is not', Coated),
        ("Kd 1 1 1\nwobble 3", '"wobble" is not modelled', Lambertian),
        ("Kd 1 1 1\nmap_Kd -clamp on t.png", '"-clamp on" of map_kd', Lambertian),
        ("Kd 1 1 1\nmap_Kd -t 1 1 1 t.png", '"-t 1 1 1" of map_kd', Lambertian),
        (
            "Kd 1 1 1\nKe 1 1 1\nmap_Kd -s 2 2 t.png\nmap_Ke t.png",
            "in different ways",
            Lambertian,
        ),
    ],
)
def test_what_is_not_modelled_is_refused_or_replaced(put, words, message, kind):
    with pytest.raises(UsageError) as caught:
        look(put, words, t_png=TWO)
    assert message in str(caught.value)
    assert "a.mtl: line " in str(caught.value)
    assert isinstance(look(put, words, lenient=True, t_png=TWO).material, kind)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("Kd 1 1", 'kd is "1 1"; it should be one number or three'),
        ("Kd spectral a.rfl", 'kd is "spectral a.rfl"'),
        ("Ns 1 2 3", "ns should be one number"),
        ("Kd 1 1 1\nKs -1 -1 -1", "should not be negative"),
        ("Kd 0 0 0\nNi 0\nd .1\nillum 7", "Ni is 0; it should be above 0"),
    ],
)
def test_faults_of_mtl_files_are_named(put, words, message):
    with pytest.raises(UsageError) as caught:
        look(put, words, lenient=True)
    assert message in str(caught.value)
    assert "a.mtl: line " in str(caught.value)


# ---------------------------------------------------------------- PLY

TRIANGLE = [[-1, -1, 0], [1, -1, 0], [0, 1, 0]]


def ply(form="ascii", vertex="float x y z", rows=TRIANGLE, face="", faces=""):
    kind, *names = vertex.split()
    head = f"ply\nformat {form} 1.0\ncomment made here\nelement vertex {len(rows)}\n"
    head += "".join(f"property {kind} {name}\n" for name in names)
    return (
        f"{head}{face}end_header\n"
        + "".join(" ".join(map(str, row)) + "\n" for row in rows)
        + faces
    )


FACE = "element face 1\nproperty list uchar int vertex_indices\n"


@pytest.mark.parametrize(
    ("face", "faces"),
    [
        (FACE, "3 0 1 2\n"),
        (FACE.replace("indices", "index"), "3 0 1 2\n"),
        (f"{FACE}property list uchar float texcoord\n", "3 0 1 2 6 0 0 1 0 0 1\n"),
        (f"{FACE}property uchar flags\n", "3 0 1 2 7\n"),
        (f"element junk 1\nproperty list int int many\n{FACE}", "2 8 9\n3 0 1 2\n"),
        (f"{FACE}element edge 1\nproperty int vertex1\n", "3 0 1 2\n5\n"),
    ],
)
def test_one_triangle_in_many_ways(put, face, faces):
    mesh = only_mesh(put(a_ply=ply(face=face, faces=faces)))
    assert_array_equal(mesh.vertices, TRIANGLE)
    assert_array_equal(mesh.faces, [[0, 1, 2]])


def test_strips_turn_every_other_triangle(put):
    rows = [[-1, -1, 0], [1, -1, 0], [-1, 1, 0], [1, 1, 0], [-1, 2, 0]]
    face = "element tristrips 2\nproperty list int int vertex_indices\n"
    mesh = only_mesh(
        put(a_ply=ply(rows=rows, face=face, faces="5 0 1 2 3 4\n7 0 1 2 -1 2 3 4\n"))
    )
    expected = [[0, 1, 2], [1, 3, 2], [2, 3, 4], [0, 1, 2], [2, 3, 4]]
    assert_array_equal(mesh.faces, expected)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("mixed", [False, True])
def test_both_orders_of_bytes_and_lists_of_any_length(put, order, mixed):
    form = "binary_little_endian" if order == "<" else "binary_big_endian"
    face = FACE.replace("face 1", "face 2").replace("uchar int", "ushort uint")
    face += "property double area\n"
    head = ply(form, "double x y z", [], face).replace("vertex 0", "vertex 4")
    body = np.array(CORNERS, f"{order}f8").tobytes()
    for corners in ([0, 1, 2, 3], [3, 2, 1]) if mixed else ([0, 1, 2], [0, 2, 3]):
        body += np.array(len(corners), f"{order}u2").tobytes()
        body += np.array(corners, f"{order}u4").tobytes()
        body += np.array(0.5, f"{order}f8").tobytes()
    mesh = only_mesh(put(a_ply=head.encode() + body))
    assert_array_equal(mesh.vertices, CORNERS)
    assert_array_equal(mesh.faces, [*FAN, [3, 2, 1]] if mixed else FAN)


@pytest.mark.parametrize(
    ("kind", "stored", "linear"),
    [
        ("uchar", (255, 128, 0), decode_srgb(np.array([255, 128, 0]) / 255)),
        ("ushort", (65535, 128, 0), decode_srgb(np.array([65535, 128, 0]) / 65535)),
        ("float", (1.0, 0.5, 0.0), np.array([1.0, 0.5, 0.0])),
    ],
)
def test_colours_of_vertices(put, kind, stored, linear):
    text = ply(face=FACE, faces="3 0 1 2\n", rows=[[*row, *stored] for row in TRIANGLE])
    colors = "".join(f"property {kind} {name}\n" for name in ("red", "green", "blue"))
    text = text.replace("element face", f"{colors}element face")
    assert_allclose(only_mesh(put(a_ply=text)).colors, [linear] * 3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (("vertex 3", "vertex 999999999999"), "it promises 999,999,999,999 rows of"),
        (("face 1", "face 77777777777777777777"), "rows of 'face' and has"),
        (("3 0 1 2", "3 0 1 7"), "face with vertex 7; its vertices are 0 to 2"),
        (("3 0 1 2", "3 0 1 2.5"), "an index of its faces is not a whole number"),
        (("3 0 1 2", "3 0 1 nan"), "an index of its faces is not a whole number"),
        (("3 0 1 2", "2 0 1"), "face 0 has 2 corners; it needs 3"),
        (("3 0 1 2", "99999 0 1 2"), "it is truncated or corrupt"),
        (("3 0 1 2", "-3 0 1 2"), "it is truncated or corrupt"),
        (("3 0 1 2", "3 0 x 2"), 'value 12 after its header is "x", no number'),
        (
            ("vertex_indices", "corners"),
            "its faces lack vertex_indices or vertex_index",
        ),
        (("float y", "float w"), "its vertices lack x, y or z"),
        (("float y", "float x"), '"vertex x" wrongly'),
        (("float y", "half y"), '"property half y" wrongly'),
        (
            ("ascii", "binary_middle_endian"),
            '"format binary_middle_endian 1.0" wrongly',
        ),
    ],
)
def test_faults_of_ply_files_are_named(put, changes, message):
    text = ply(face=FACE, faces="3 0 1 2\n")
    assert changes[0] in text
    assert message in refusal(put(a_ply=text.replace(*changes)))
