// initialize() writes garbage to every socket of its process, and so to the socket on which the host answers
// the node.
#include <takt/module.h>

#include <sys/socket.h>

extern "C" {
void initialize(irp::Property const&) {
  for (int fd = 3; fd < 256; ++fd) static_cast<void>(send(fd, "garbage", 7, MSG_NOSIGNAL | MSG_DONTWAIT));
}
void run(void) {}
}
