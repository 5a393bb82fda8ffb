import pyopencl as cl
import pytest
from makeup_video.pipeline import FindFaces, Look, product
from makeup_video.pipeline.faces.net import Net
from makeup_video.pipeline.live.warm_up import warm_up
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from people import clip, frame_of


@pytest.fixture
def used(monkeypatch):
    """The nets and kernels that ran."""
    seen = set()
    run, launch = Net.__call__, cl.enqueue_nd_range_kernel

    def counted_run(net, rgb8):
        seen.add(id(net))
        return run(net, rgb8)

    def counted_launch(queue, kernel, *rest):
        seen.add(kernel.function_name)
        return launch(queue, kernel, *rest)

    monkeypatch.setattr(Net, "__call__", counted_run)
    monkeypatch.setattr(cl, "enqueue_nd_range_kernel", counted_launch)
    return seen


def test_the_warm_up_runs_every_net_and_kernel_of_a_video(used):
    find, scene = FindFaces(), BuildScene()
    paint = Composite(
        Look(lips=product((180, 0, 30), "gloss"), eyes=product((20, 40, 90), "satin", "eyes"))
    )
    for number, rgb8 in enumerate(clip(4)):
        paint(scene(find(frame_of(rgb8, number))))
    of_video = set(used)
    assert len(of_video) >= 4 + 4  # nets and kernels
    used.clear()
    warm_up(scene, paint)
    assert used >= of_video


@pytest.mark.parametrize("faces", ["all", "7"])
def test_after_the_warm_up_the_first_frame_builds_no_kernel(monkeypatch, faces):
    find, scene, paint = FindFaces(), BuildScene(), Composite(Look(), faces=faces)
    warm_up(scene, paint)
    assert paint.painted_frames == 0 and paint.look == Look()
    monkeypatch.setattr(cl.Program, "build", None)
    paint.set_look(Look(lips=product((180, 0, 30), "gloss")))
    paint(scene(find(frame_of(clip(1)[0]))))
    assert paint.painted_frames == (faces == "all")
