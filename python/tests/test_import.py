"""The import: what it loads, and what the package has."""

import subprocess
import sys

import fbptr


def test_the_import_loads_nothing_heavy():
    program = "import sys; before = set(sys.modules); import fbptr; print(*sorted(set(sys.modules) - before))"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.split()
    assert "fbptr._native" in loaded
    heavy = {"numpy", "socket", "mmap", "asyncio", "IPython", "dask", "inspect", "json", "tempfile", "subprocess"}
    assert not heavy & set(loaded)


def test_the_clients_are_in_the_package():
    assert fbptr.Client.__module__ == fbptr.SharedMemory.__module__ == "fbptr.client"
    assert issubclass(fbptr.CommandError, Exception)
    assert set(fbptr.__all__) <= set(dir(fbptr))
    for name in fbptr.__all__:
        assert getattr(fbptr, name) is not None
    try:
        fbptr.no_such_thing
    except AttributeError as error:
        assert "no_such_thing" in str(error)
    else:
        raise AssertionError
