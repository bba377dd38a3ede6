"""``isomatch upload``, without a service."""

from tests.client.command_line import run


def test_several_files_have_no_common_name() -> None:
    done = run("upload", __file__, "b.off", "--name", "same", url="http://127.0.0.1:9")
    assert (done.returncode, done.stdout) == (2, "")
    assert "several files would have one name" in done.stderr
