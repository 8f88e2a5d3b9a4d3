"""A machine of its own for each test program, so that tests can run side by side: network interfaces (only the loopback one, with all
of its ports and DDS domains), mounts, and a /dev/shm that holds nothing of anybody else. It ends with the program and what that
started. Needs root; without, `MISSING` says why, the tests share the machine and keep apart by their domains."""

import ctypes
import os
import subprocess

CLONE_NEWNS = 0x20000
CLONE_NEWNET = 0x40000000


def _enter():
    """Moves this process there. Returns why not, or an empty text."""
    if os.geteuid() != 0:
        return "namespaces need root"
    if ctypes.CDLL(None, use_errno=True).unshare(CLONE_NEWNS | CLONE_NEWNET) != 0:
        return "no namespaces can be made here: " + os.strerror(ctypes.get_errno())
    for command in (["mount", "--make-rprivate", "/"], ["mount", "-t", "tmpfs", "tmpfs", "/dev/shm"], ["ip", "link", "set", "lo", "up"]):
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            chroot = "; in a chroot, its root has to be a mount point: mount --bind ROOT ROOT" if not os.path.ismount("/") else ""
            raise RuntimeError("%s: %s%s" % (" ".join(command), done.stderr.strip(), chroot))
    return ""


MISSING = _enter()
