"""Golden pictures: the method, the pytest plugin, animations."""

import pytest

import fbptr

pytest_plugins = ["pytester"]


def test_the_method_compares_blesses_and_writes_the_difference(tmp_path, monkeypatch):
    fb = fbptr.Framebuffer(16, 12)
    fb.circle(8, 6, 4, "gold")
    golden = tmp_path / "circle.png"
    monkeypatch.delenv("BLESS", raising=False)
    with pytest.raises(AssertionError, match="BLESS=1"):
        fb.assert_golden(golden)
    monkeypatch.setenv("BLESS", "1")
    with pytest.raises(AssertionError):
        fb.assert_golden(golden)
    monkeypatch.delenv("BLESS")
    fb.assert_golden(str(golden))
    fb.pixel(1, 1, (3, 0, 0))
    with pytest.raises(AssertionError, match="1 pixel"):
        fb.assert_golden(golden)
    assert (tmp_path / "circle.diff.png").exists() and (tmp_path / "circle.actual.png").exists()
    fb.assert_golden(golden, tolerance=3)
    fb.assert_golden(golden, pixels=1)
    assert not (tmp_path / "circle.diff.png").exists()


def test_the_plugin(pytester, monkeypatch):
    monkeypatch.delenv("BLESS", raising=False)
    pytester.makepyfile(
        """
        import fbptr

        def test_circle(assert_golden):
            fb = fbptr.Framebuffer(16, 12)
            fb.circle(8, 6, 4, "gold")
            assert_golden(fb)
            fb.clear("navy")
            assert_golden(fb)
            assert_golden(fb, "named", tolerance=1)
        """
    )
    options = () if _is_installed() else ("-p", "fbptr.pytest_plugin")
    pytester.mkdir("golden")
    assert pytester.runpytest_subprocess(*options).ret == 1
    pytester.runpytest_subprocess("--bless", *options).assert_outcomes(passed=1, errors=1)
    pytester.runpytest_subprocess(*options).assert_outcomes(passed=1)
    names = sorted(p.name for p in (pytester.path / "golden").iterdir())
    assert names == ["named.png", "test_circle-2.png", "test_circle.png"]


def _is_installed():
    from importlib.metadata import entry_points

    return any(point.value == "fbptr.pytest_plugin" for point in entry_points(group="pytest11"))


def test_an_animation_is_a_gif(tmp_path):
    def draw(fb, i):
        fb.circle(8, 6, i, "gold")

    movie = fbptr.animate(draw, 4, size=(16, 12), rate=10, path=tmp_path / "a.gif")
    assert movie.data[:6] == b"GIF89a" and movie.frames == 4 and len(set(movie.crcs)) == 4
    assert (tmp_path / "a.gif").read_bytes() == movie.data
    assert fbptr.animate(draw, 4, size=(16, 12), rate=10).data == movie.data
    bundle = movie._repr_mimebundle_()
    assert bundle["text/html"].startswith("<img") and bundle["image/gif"]
    fb = fbptr.Framebuffer(16, 12)
    assert fbptr.animate(draw, [0, 1, 2, 3], fb=fb).crcs == movie.crcs
    with pytest.raises(ValueError):
        fbptr.animate(draw, 0)
    with pytest.raises(ValueError):
        fbptr.animate(draw, 2, rate=1000)
    with pytest.raises(ZeroDivisionError):
        fbptr.animate(lambda fb, i: 1 / i, 2)
    with pytest.raises(TypeError):
        fbptr.animate(None, 2)
