from __future__ import annotations

import fcntl
import os
import shutil
import signal

import pytest

from cable_tracker.folder_lock import FolderLock


def is_free(path):
    try:
        FolderLock(path).release()
    except BlockingIOError:
        return False
    return True


def test_a_folder_is_locked_until_it_is_released(tmp_path):
    lock = FolderLock(tmp_path / "new" / "folder")
    assert not is_free(tmp_path / "new" / "folder")
    lock.release()
    lock.release()
    assert is_free(tmp_path / "new" / "folder")
    assert list((tmp_path / "new" / "folder").iterdir()) == []


def test_a_lock_that_is_forgotten_is_released(tmp_path):
    FolderLock(tmp_path)
    assert is_free(tmp_path)


def test_a_lock_ends_with_its_process_also_when_that_has_children(tmp_path):
    said, says = os.pipe()
    holder = os.fork()
    if not holder:
        lock = FolderLock(tmp_path)
        child = os.fork()
        if not child:
            os.write(says, str(os.getpid()).encode())
        signal.pause()
        os._exit(lock is None)
    child = int(os.read(said, 20))
    try:
        assert not is_free(tmp_path)
        os.kill(holder, signal.SIGKILL)
        os.waitpid(holder, 0)
        assert is_free(tmp_path)
    finally:
        os.kill(child, signal.SIGKILL)
        os.close(said)
        os.close(says)


def test_a_forked_child_that_ends_does_not_release_the_lock(tmp_path):
    lock = FolderLock(tmp_path)
    child = os.fork()
    if not child:
        lock.release()
        os._exit(0)
    os.waitpid(child, 0)
    assert not is_free(tmp_path)


def test_a_folder_that_is_removed_while_it_is_locked_is_made_again(tmp_path, monkeypatch):
    path, flock, removed = tmp_path / "folder", fcntl.flock, []

    def remove_first(descriptor, operation):
        if not removed:
            shutil.rmtree(path)
            removed.append(path)
        flock(descriptor, operation)

    monkeypatch.setattr("fcntl.flock", remove_first)
    lock = FolderLock(path)
    assert path.is_dir()
    assert not is_free(path)
    lock.release()


def test_a_folder_that_cannot_be_made_is_an_error(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match=r"Not a directory|File exists"):
        FolderLock(tmp_path / "file" / "folder")
