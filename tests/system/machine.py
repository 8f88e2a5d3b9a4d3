"""Importing this module moves a test program into its own namespaces, so that tests can run at the same time. The program then has
its own loopback interface with all ports and DDS domains free, its own mounts, and an empty /dev/shm. The namespaces end with the program
and its children. This needs root. Without root, `MISSING` contains the reason, the tests share the network of the machine, and each of them
uses another DDS domain."""

import ctypes
import os
import subprocess

CLONE_NEWNS = 0x20000
CLONE_NEWNET = 0x40000000


def _enter():
    """Moves this process into new namespaces. Returns an empty string, or the reason why this failed."""
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
