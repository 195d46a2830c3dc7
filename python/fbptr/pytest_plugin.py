"""The pytest plugin: golden pictures of framebuffers.

In: tests that take the fixture `assert_golden`. Out: comparisons with PNG files in the folder
`golden` beside the test's file, and a report of the pictures of those that failed.
"""

import os
import re

import pytest


def pytest_addoption(parser):
    parser.addoption(
        "--bless",
        action="store_true",
        help="write the golden pictures of fbptr anew; the tests still fail, the next run passes",
    )


@pytest.fixture
def assert_golden(request, monkeypatch):
    """Compares a framebuffer with a golden picture: `assert_golden(fb)`, `assert_golden(fb, "name")`.

    The file is `golden/NAME.png` beside the test's file, by default with the name of the test.
    Further arguments are those of `Framebuffer.assert_golden`. `--bless` or BLESS=1 writes it,
    and the test ends with an error.
    """
    if request.config.getoption("--bless"):
        monkeypatch.setenv("BLESS", "1")
    used, blessed = {}, []

    def check(fb, name=None, **tolerance):
        __tracebackhide__ = True
        if name is None:
            name = re.sub(r"[^\w.-]+", "_", request.node.name)
            used[name] = used.get(name, 0) + 1
            if used[name] > 1:
                name = "%s-%d" % (name, used[name])
        name = str(name)
        path = request.path.parent / "golden" / (name if name.endswith(".png") else name + ".png")
        try:
            fb.assert_golden(path, **tolerance)
        except AssertionError as failure:
            if os.environ.get("BLESS"):
                # The test goes on, so that one run writes all of its pictures; it fails at the end.
                blessed.append(str(failure))
                return
            request.node.add_report_section("call", "fbptr golden picture", str(failure))
            raise

    yield check
    if blessed:
        pytest.fail("\n".join(blessed), pytrace=False)
