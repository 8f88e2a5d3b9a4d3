import signal
import socket
import sys

server = socket.socket()
server.bind(("127.0.0.1", int(sys.argv[1])))  # fails if an earlier process still listens, even without SO_REUSEADDR
server.listen()
print("listens", flush=True)
signal.pause()
