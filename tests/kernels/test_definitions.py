"""Constants and struct layouts are the same in C as in Python."""

import numpy as np
import pyopencl as cl
import pytest
from kernel_arguments import on_device
from makeup_video.kernels import material, paint, surface
from makeup_video.kernels.definitions import Definitions, floats, offsets
from makeup_video.kernels.program import Device

INNER = np.dtype([("a", np.float32, 3), ("b", np.int32)])
OUTER = np.dtype([("c", np.float32), ("inner", INNER), ("d", np.float32, (2, 3))])


def test_constants_keep_every_bit_of_float32():
    values = [0.96, -0.85, 1.9 / 39, 1e-5, 14.999, 2.0**-24, 1 / 3, 10000 / 203]
    constants = {f"VALUE_{number}": value for number, value in enumerate(values)}
    definitions = Definitions({**constants, "COUNT": len(values)})
    source = f"""
    __kernel void read(__global float *out) {{
        const float values[COUNT] = {{{", ".join(constants)}}};
        for (int i = 0; i < COUNT; ++i) out[i] = values[i];
    }}
    """
    device, out = Device(), np.zeros(len(values), np.float32)
    kernel = cl.Kernel(device.build(source, 13, definitions=definitions), "read")
    with on_device(device, out) as buffers:
        device.launch(kernel, (1, 1), buffers)
    np.testing.assert_array_equal(out, np.array(values, np.float32))


def members(layout):
    return [(name, offset) for name, (_, offset, *_) in layout.fields.items()]


@pytest.mark.parametrize(
    ("definitions", "name"),
    [
        (Definitions(structs={"inner": INNER, "outer": OUTER}), "outer"),
        (paint.DEFINITIONS, "colour_coding"),
        (paint.DEFINITIONS, "material"),
        (paint.DEFINITIONS, "paint_region"),
    ],
)
def test_c_puts_every_member_where_numpy_does(definitions, name):
    layout = definitions.structs[name]
    lines = [
        f"out[{number}] = (int)((char *)&one.{member} - (char *)&one);"
        for number, (member, _) in enumerate(members(layout))
    ]
    source = f"""
    __kernel void measure(__global int *out) {{
        {name} one;
        {" ".join(lines)}
        out[{len(lines)}] = sizeof(one);
    }}
    """
    device, out = Device(), np.zeros(len(lines) + 1, np.int32)
    kernel = cl.Kernel(device.build(source, 13, definitions=definitions), "measure")
    with on_device(device, out) as buffers:
        device.launch(kernel, (1, 1), buffers)
    assert out.tolist() == [*(offset for _, offset in members(layout)), layout.itemsize]


def test_a_struct_that_c_would_pad_is_refused():
    for layout in (
        np.dtype([("a", np.float64)]),
        np.dtype([("a", np.float32), ("b", np.float32)], align=False).newbyteorder(),
        np.dtype({"names": ["a"], "formats": [np.float32], "offsets": [4]}),
    ):
        with pytest.raises(TypeError):
            Definitions(structs={"odd": layout}).source()


def test_offsets_count_floats_by_upper_case_names():
    assert offsets(OUTER) == {"C_AT": 0, "INNER_AT": 1, "D_AT": 5}
    assert floats(OUTER) == 11


def test_another_constant_is_another_program():
    """PoCL caches compiled programs by source and options."""
    source = "__kernel void read(__global float *out) { *out = VALUE; }"
    device, got = Device(), []
    for value in (1.5, 2.5, 1.5):
        out = np.zeros(1, np.float32)
        program = device.build(source, 13, definitions=Definitions({"VALUE": value}))
        with on_device(device, out) as buffers:
            device.launch(cl.Kernel(program, "read"), (1, 1), buffers)
        got.append(out.item())
    assert got == [1.5, 2.5, 1.5]


def test_definitions_of_included_files_come_first():
    names = ["colour_coding", "material", "paint_product", "paint_region"]
    assert list(paint.DEFINITIONS.structs) == names
    assert material.DEFINITIONS.constants.items() <= paint.DEFINITIONS.constants.items()


def test_no_number_of_surface_is_defined_twice():
    """Fields of the same name in two buffers of surface.cl would share a macro."""
    names = [
        name
        for layout in (surface.GIVEN, surface.OUT, surface.PLACE, surface.PLANE, surface.SCRATCH)
        for name in layout.names
    ]
    assert len(names) == len(set(names))
